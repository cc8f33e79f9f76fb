// SPDX-License-Identifier: GPL-3.0-or-later
//! The statements `Material` and `MakeNamedMaterial`: models and their parameters.
//! Source: the section Materials of the file-format page. `surface` makes the renderer's materials of them.
//! Tests: `tests/materials.rs`.

use std::path::PathBuf;

use gnurt_scene::Medium;
use gnurt_scene::io::reader::{Access, quoted, resolve};
use gnurt_scene::io::{Error, Oddity, Warnings};

use crate::location::Location;
use crate::medium;
use crate::parameter::{Kind, Parameters};
use crate::spectrum::{Spectrum, metal};
use crate::tables::METALS;
use crate::texture::Input;
use crate::texture_parameters::Textures;

/// A material as its statement says it.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    pub(crate) model: Model,
    /// The medium within, of `subsurface`.
    pub(crate) inside: Option<Box<Medium>>,
    /// A picture of normals.
    pub(crate) normal_map: Option<PathBuf>,
    /// Heights that turn normals, in the renderer's units.
    pub(crate) bump: Option<Input>,
    pub(crate) location: Location,
}

/// Scattering models.
#[derive(Clone, Debug)]
pub(crate) enum Model {
    /// No surface: light goes straight on.
    Interface,
    Diffuse(Input),
    CoatedDiffuse {
        reflectance: Input,
        coat: Coat,
    },
    Conductor {
        metal: Metal,
        microfacets: Facets,
    },
    CoatedConductor {
        metal: Metal,
        microfacets: Facets,
        coat: Coat,
    },
    /// Index, Abbe's number.
    Dielectric {
        index: f32,
        abbe: Option<f32>,
        microfacets: Facets,
    },
    ThinDielectric {
        index: f32,
    },
    DiffuseTransmission {
        reflectance: Input,
        transmittance: Input,
        scale: f32,
    },
    Hair(Box<Hair>),
    /// Materials by their numbers.
    Mix {
        parts: [u32; 2],
        amount: Input,
    },
}

impl Material {
    /// Whether it may read texture coordinates.
    pub(crate) fn is_textured(&self) -> bool {
        let textured = |input: &Input| matches!(input, Input::Texture(_));
        let rough = |microfacets: &Facets| microfacets.roughness.iter().any(textured);
        let of_metal = |metal: &Metal| match metal {
            Metal::Complex(eta, k) => textured(eta) || textured(k),
            Metal::Reflectance(reflectance) => textured(reflectance),
        };
        let by_model = match &self.model {
            Model::Interface | Model::ThinDielectric { .. } => false,
            Model::Diffuse(reflectance) => textured(reflectance),
            Model::CoatedDiffuse { reflectance, coat } => textured(reflectance) || rough(&coat.microfacets),
            Model::Conductor { metal, microfacets } => of_metal(metal) || rough(microfacets),
            Model::CoatedConductor { metal, microfacets, coat } => {
                of_metal(metal) || rough(microfacets) || rough(&coat.microfacets)
            }
            Model::Dielectric { microfacets, .. } => rough(microfacets),
            Model::DiffuseTransmission { reflectance, transmittance, .. } => {
                textured(reflectance) || textured(transmittance)
            }
            Model::Hair(hair) => {
                let Hair { color, roughness: [along, around], .. } = &**hair;
                let of_color = match color {
                    HairColor::Absorption(color) | HairColor::Reflectance(color) => textured(color),
                    HairColor::Melanin(dark, red) => textured(dark) || textured(red),
                };
                of_color || textured(along) || textured(around)
            }
            Model::Mix { .. } => true,
        };
        by_model || self.normal_map.is_some() || self.bump.is_some()
    }
}

/// Widths of facets.
#[derive(Clone, Debug)]
pub(crate) struct Facets {
    /// Along u and v.
    pub(crate) roughness: [Input; 2],
    /// Whether the width is the root of it.
    pub(crate) remap: bool,
}

/// A layer of glass on something.
#[derive(Clone, Debug)]
pub(crate) struct Coat {
    pub(crate) microfacets: Facets,
    pub(crate) index: f32,
}

/// A metal.
#[derive(Clone, Debug)]
pub(crate) enum Metal {
    /// Indices and extinction coefficients.
    Complex(Input, Input),
    /// Reflectance at normal incidence.
    Reflectance(Input),
}

/// A hair.
#[derive(Clone, Debug)]
pub(crate) struct Hair {
    pub(crate) color: HairColor,
    /// Along it and around it.
    pub(crate) roughness: [Input; 2],
    pub(crate) index: f32,
    /// Of its scales, in degrees.
    pub(crate) tilt: Input,
}

/// How a hair is coloured.
#[derive(Clone, Debug)]
pub(crate) enum HairColor {
    /// Absorption for a radius of 1.
    Absorption(Input),
    /// Colour of thick hair.
    Reflectance(Input),
    /// Concentrations of eumelanin and pheomelanin.
    Melanin(Input, Input),
}

/// What materials are read with.
pub(crate) struct Reading<'a> {
    pub(crate) textures: &'a Textures,
    pub(crate) access: &'a Access,
    /// The number of a named material.
    pub(crate) named: &'a mut dyn FnMut(&str) -> u32,
}

impl Reading<'_> {
    fn color(&self, parameters: &Parameters, name: &str, default: f32) -> Result<Input, Error> {
        let given = self.textures.spectrum(parameters, name, self.access)?;
        Ok(given.unwrap_or(Input::number(default)))
    }

    fn number(&self, parameters: &Parameters, name: &str, default: f32) -> Result<Input, Error> {
        Ok(self.textures.float(parameters, name)?.unwrap_or(Input::number(default)))
    }

    /// Widths of facets whose parameters begin so.
    fn microfacets(&self, parameters: &Parameters, prefix: &str, default: f32) -> Result<Facets, Error> {
        let both = self.number(parameters, &format!("{prefix}roughness"), default)?;
        let one = |axis: char| -> Result<Input, Error> {
            let given = self.textures.float(parameters, &format!("{prefix}{axis}roughness"))?;
            Ok(given.unwrap_or_else(|| both.clone()))
        };
        Ok(Facets { roughness: [one('u')?, one('v')?], remap: parameters.bool_or("remaproughness", true)? })
    }

    /// An index of refraction, and Abbe's number.
    fn index(&self, parameters: &Parameters, name: &str) -> Result<(f32, Option<f32>), Error> {
        let given = match parameters.float(name)? {
            Some(index) => (index, None),
            None => Spectrum::of(parameters, name, self.access)?.map_or((1.5, None), |found| found.index()),
        };
        if !(given.0 > 0.0 && given.0.is_finite()) {
            return Err(parameters
                .location
                .error(format!("\"{name}\" is {}", given.0), "an index of refraction is above 0"));
        }
        Ok(given)
    }

    fn metal(&self, parameters: &Parameters, prefix: &str) -> Result<Metal, Error> {
        let [eta_name, k_name] = ["eta", "k"].map(|name| format!("{prefix}{name}"));
        let [is_eta, is_k] = [&eta_name, &k_name].map(|name| {
            parameters.find(name, &[Kind::Rgb, Kind::Spectrum, Kind::Blackbody, Kind::Texture]).is_some()
        });
        if let Some(reflectance) = self.textures.spectrum(parameters, "reflectance", self.access)? {
            if is_eta || is_k {
                let problem = "a conductor has both \"reflectance\" and \"eta\" or \"k\"";
                return Err(parameters.location.error(problem, "leave one of them out"));
            }
            return Ok(Metal::Reflectance(reflectance));
        }
        let spectra = [&eta_name, &k_name].map(|name| Spectrum::of(parameters, name, self.access));
        let [eta, k] = spectra;
        let (eta, k) = (eta?, k?);
        if let (Some(eta), Some(k)) = (&eta, &k) {
            let [eta, k] = metal(eta, k);
            return Ok(Metal::Complex(Input::Constant(eta), Input::Constant(k)));
        }
        let copper = &METALS[3];
        let eta = self.textures.spectrum(parameters, &eta_name, self.access)?;
        let k = self.textures.spectrum(parameters, &k_name, self.access)?;
        Ok(Metal::Complex(eta.unwrap_or(Input::Constant(copper.eta)), k.unwrap_or(Input::Constant(copper.k))))
    }

    fn coat(&self, parameters: &Parameters, prefix: &str, warnings: &mut Warnings) -> Result<Coat, Error> {
        let eta = format!("{prefix}eta");
        let coat = Coat {
            microfacets: self.microfacets(parameters, prefix, 0.0)?,
            index: self.index(parameters, &eta)?.0,
        };
        let albedo = self.color(parameters, "albedo", 0.0)?;
        self.number(parameters, "thickness", 0.01)?;
        self.number(parameters, "g", 0.0)?;
        parameters.int("maxdepth")?;
        parameters.int("nsamples")?;
        if albedo.constant() != Some([0.0; 3]) {
            let detail = "\"albedo\" of what is within a coat: a clear coat is shown";
            parameters.location.warn(warnings, Oddity::StandIn, detail);
        }
        Ok(coat)
    }

    /// The material of a type with these parameters.
    pub(crate) fn read(
        &mut self,
        class: &str,
        parameters: &Parameters,
        warnings: &mut Warnings,
    ) -> Result<Material, Error> {
        let location = parameters.location.clone();
        let stand_in =
            |warnings: &mut Warnings, detail: &str| location.warn(warnings, Oddity::StandIn, detail);
        let mut inside = None;
        let model = match class {
            "interface" | "none" | "" => Model::Interface,
            "diffuse" => Model::Diffuse(self.color(parameters, "reflectance", 0.5)?),
            "coateddiffuse" => Model::CoatedDiffuse {
                reflectance: self.color(parameters, "reflectance", 0.5)?,
                coat: self.coat(parameters, "", warnings)?,
            },
            "conductor" => Model::Conductor {
                metal: self.metal(parameters, "")?,
                microfacets: self.microfacets(parameters, "", 0.0)?,
            },
            "coatedconductor" => Model::CoatedConductor {
                metal: self.metal(parameters, "conductor.")?,
                microfacets: self.microfacets(parameters, "conductor.", 0.0)?,
                coat: self.coat(parameters, "interface.", warnings)?,
            },
            "dielectric" => {
                let (index, abbe) = self.index(parameters, "eta")?;
                Model::Dielectric { index, abbe, microfacets: self.microfacets(parameters, "", 0.0)? }
            }
            "thindielectric" => Model::ThinDielectric { index: self.index(parameters, "eta")?.0 },
            "diffusetransmission" => Model::DiffuseTransmission {
                reflectance: self.color(parameters, "reflectance", 0.25)?,
                transmittance: self.color(parameters, "transmittance", 0.25)?,
                scale: parameters.float_or("scale", 1.0)?,
            },
            "mix" => {
                let names = parameters.find("materials", &[Kind::Text]).and_then(|p| p.texts());
                let Some([a, b]) = names else {
                    let problem = "a mix has no two \"string materials\"";
                    return Err(
                        location.error(problem, "name two materials: \"string materials\" [ \"a\" \"b\" ]")
                    );
                };
                let parts = [(self.named)(a), (self.named)(b)];
                Model::Mix { parts, amount: self.number(parameters, "amount", 0.5)? }
            }
            "hair" => {
                let given = |name: &str| self.textures.float(parameters, name);
                let color = match self.textures.spectrum(parameters, "reflectance", self.access)? {
                    Some(color) => Some(color),
                    None => self.textures.spectrum(parameters, "color", self.access)?,
                };
                let absorption = self.textures.spectrum(parameters, "sigma_a", self.access)?;
                let melanin = [given("eumelanin")?, given("pheomelanin")?];
                // In the order in which pbrt takes them.
                let color = match (absorption, color, melanin) {
                    (Some(absorption), _, _) => HairColor::Absorption(absorption),
                    (None, Some(color), _) => HairColor::Reflectance(color),
                    (None, None, [None, None]) => HairColor::Melanin(Input::number(1.3), Input::number(0.0)),
                    (None, None, [dark, red]) => {
                        let or_none = |input: Option<Input>| input.unwrap_or(Input::number(0.0));
                        HairColor::Melanin(or_none(dark), or_none(red))
                    }
                };
                let roughness =
                    [self.number(parameters, "beta_m", 0.3)?, self.number(parameters, "beta_n", 0.3)?];
                let index = match parameters.find("eta", &[Kind::Float, Kind::Spectrum, Kind::Rgb]) {
                    Some(_) => self.index(parameters, "eta")?.0,
                    None => 1.55,
                };
                let tilt = self.number(parameters, "alpha", 2.0)?;
                Model::Hair(Box::new(Hair { color, roughness, index, tilt }))
            }
            "measured" => {
                stand_in(warnings, "material \"measured\", shown as a diffuse grey of 0.5");
                parameters.ignore();
                Model::Diffuse(Input::number(0.5))
            }
            "subsurface" => {
                inside = Some(Box::new(medium::subsurface(parameters, self.access, warnings)?));
                let index = match parameters.find("eta", &[Kind::Float, Kind::Spectrum, Kind::Rgb]) {
                    Some(_) => self.index(parameters, "eta")?.0,
                    None => 1.33,
                };
                Model::Dielectric { index, abbe: None, microfacets: self.microfacets(parameters, "", 0.0)? }
            }
            other => {
                let known = "coatedconductor, coateddiffuse, conductor, dielectric, diffuse, diffusetransmission, hair, \
                             interface, measured, mix, subsurface and thindielectric";
                return Err(location
                    .error(format!("unknown material {}", quoted(other)), format!("valid are {known}")));
            }
        };
        let normal_map = parameters.text("normalmap")?.map(|name| resolve(&location.path, name));
        let bump = self.textures.float(parameters, "displacement")?;
        Ok(Material { model, inside, normal_map, bump, location })
    }
}
