// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials, lights and cameras from arguments. Names as in glTF. Angles are in degrees.
//! Tests: `tests/test_pictures.py`.

use gnurt::Surroundings;
use gnurt::osl::Script;
use gnurt::scene::LayerTextures;
use gnurt::scene::detail::{Anisotropy, DiffuseTransmission, Interior, Iridescence, Subsurface};
use gnurt::scene::material::{
    Alpha, BumpMap, Color, NormalMap, Opacity, OpacityChannel, Principled, TextureRef,
};
use gnurt::scene::{Camera, ConeEdge, Lens, Light, Material, MediumId, Projection, Surface, Texture};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::displacements::{self, NewDisplacement};
use crate::given::Given;
use crate::scripts::script;
use crate::textures::{Pictures, reference};

const MOST: f64 = f32::MAX as f64;

/// A material, and the displacement of its surfaces.
pub(crate) struct NewMaterial {
    pub(crate) look: NewLook,
    pub(crate) displacement: NewDisplacement,
}

/// The scene's form of a material.
pub(crate) enum NewLook {
    Material(Material),
    /// Its name, the script that replaces it, and the medium behind it.
    Script(String, Script, Option<MediumId>),
}

/// A material; `kind` selects its arguments, unless a shader replaces all of them.
pub(crate) fn material(given: &mut Given, pictures: &dyn Pictures) -> PyResult<NewMaterial> {
    let displacement = displacements::displacement(given, pictures)?;
    Ok(NewMaterial { look: look(given, pictures)?, displacement })
}

fn look(given: &mut Given, pictures: &dyn Pictures) -> PyResult<NewLook> {
    let name = given.text("name")?.unwrap_or_default();
    let medium = given.whole("medium", 0, u64::from(u32::MAX))?.map(|number| MediumId(number as u32));
    if let Some(script) = script(given, pictures)? {
        return Ok(NewLook::Script(name, script, medium));
    }
    let kind = given.text("kind")?.unwrap_or_else(|| "principled".into());
    if kind == "boundary" {
        return match medium {
            Some(medium) => Ok(NewLook::Material(Material::boundary(name, medium))),
            None => Err(PyValueError::new_err("medium: a boundary needs one")),
        };
    }
    let color = given.color("color")?;
    let color_texture = reference(given, "color_texture")?;
    // A texture without a colour is shown as it is.
    let factor = color.unwrap_or(if color_texture.is_some() { [1.0; 3] } else { [0.8; 3] });
    let base_color = Color { factor, texture: color_texture };
    let share = |given: &mut Given, name, default: f64| -> PyResult<f32> {
        Ok(given.number(name, 0.0, 1.0)?.unwrap_or(default) as f32)
    };
    let surface = match kind.as_str() {
        "matte" => match share(given, "roughness", 0.0)? {
            0.0 => Surface::Matte { base_color },
            roughness => Surface::RoughMatte { base_color, roughness },
        },
        "mirror" => {
            let reflectance = Color { factor: color.unwrap_or([1.0; 3]), texture: color_texture };
            Surface::Mirror { reflectance }
        }
        "glass" if color_texture.is_some() => {
            return Err(PyValueError::new_err("color_texture: glass has none; give a shader"));
        }
        "glass" => {
            let (ior, tint) = (ior(given)?, color.unwrap_or([1.0; 3]));
            let (roughness, thin) = (share(given, "roughness", 0.0)?, given.flag("thin")?.unwrap_or(false));
            let interior = interior(given)?;
            if roughness == 0.0 && !thin {
                Surface::Dielectric { ior, reflectance: [1.0; 3], transmittance: tint, interior }
            } else {
                let (reflectance, transmittance) = ([1.0; 3], tint);
                Surface::RoughDielectric { ior, roughness, reflectance, transmittance, thin, interior }
            }
        }
        "principled" => Surface::Principled(Box::new(Principled {
            base_color,
            metallic: share(given, "metallic", 0.0)?,
            roughness: share(given, "roughness", 0.5)?,
            metallic_roughness_texture: reference(given, "metallic_roughness_texture")?,
            normal_texture: match reference(given, "normal_texture")? {
                None => None,
                Some(texture) => Some(NormalMap {
                    texture,
                    scale: given.number("normal_scale", -MOST, MOST)?.unwrap_or(1.0) as f32,
                }),
            },
            ior: ior(given)?,
            specular: share(given, "specular", 1.0)?,
            specular_color: given.color("specular_color")?.unwrap_or([1.0; 3]),
            clearcoat: share(given, "clearcoat", 0.0)?,
            clearcoat_roughness: share(given, "clearcoat_roughness", 0.0)?,
            sheen_color: given.color("sheen_color")?.unwrap_or([0.0; 3]),
            sheen_roughness: share(given, "sheen_roughness", 0.3)?,
            transmission: share(given, "transmission", 0.0)?,
            thin: given.flag("thin")?.unwrap_or(true),
            interior: interior(given)?,
            anisotropy: Anisotropy {
                strength: share(given, "anisotropy", 0.0)?,
                rotation: given.number("anisotropy_rotation", -MOST, MOST)?.unwrap_or(0.0).to_radians()
                    as f32,
                texture: reference(given, "anisotropy_texture")?,
            },
            iridescence: Iridescence {
                factor: share(given, "iridescence", 0.0)?,
                ior: given.number("iridescence_ior", 1.0, 100.0)?.unwrap_or(1.3) as f32,
                thickness: given.number("iridescence_thickness", 0.0, 1e6)?.unwrap_or(400.0) as f32,
                least_thickness: given.number("iridescence_least", 0.0, 1e6)?.unwrap_or(100.0) as f32,
            },
            diffuse_transmission: DiffuseTransmission {
                factor: share(given, "diffuse_transmission", 0.0)?,
                color: given.color("diffuse_transmission_color")?.unwrap_or([1.0; 3]),
            },
            subsurface: subsurface(given)?,
            layer_textures: layer_textures(given)?,
        })),
        _ => {
            return Err(PyValueError::new_err(format!(
                "kind: expected principled, matte, mirror, glass or boundary, not '{kind}'"
            )));
        }
    };
    let mut material = Material::of(name, surface);
    material.medium = medium;
    material.emission_texture = reference(given, "emission_texture")?;
    let full = if material.emission_texture.is_some() { [1.0; 3] } else { [0.0; 3] };
    material.emission = given.color("emission")?.unwrap_or(full);
    if let Some(texture) = reference(given, "bump_texture")? {
        let height = given.number("bump_height", -MOST, MOST)?.unwrap_or(1.0) as f32;
        material.bump = Some(BumpMap { texture, height });
    }
    let opacity_texture = reference(given, "opacity_texture")?;
    let cutoff = given.number("opacity_cutoff", 0.0, 1.0)?;
    let factor = share(given, "opacity", 1.0)?;
    if factor < 1.0 || opacity_texture.is_some() {
        let channel = match given.text("opacity_channel")?.as_deref() {
            None | Some("alpha") => OpacityChannel::Alpha,
            Some("red") => OpacityChannel::Red,
            Some(other) => {
                return Err(PyValueError::new_err(format!(
                    "opacity_channel: expected alpha or red, not '{other}'"
                )));
            }
        };
        let opacity = Opacity { factor, texture: opacity_texture, channel };
        material.alpha = match cutoff {
            Some(cutoff) => Alpha::Mask { cutoff: cutoff as f32, opacity },
            None => Alpha::Blend { opacity },
        };
    }
    Ok(NewLook::Material(material))
}

/// The interior of glass that is not thin.
fn interior(given: &mut Given) -> PyResult<Interior> {
    Ok(Interior {
        attenuation_color: given.color("attenuation_color")?.unwrap_or([1.0; 3]),
        attenuation_distance: given
            .number("attenuation_distance", 1e-30, MOST)?
            .map_or(f32::INFINITY, |distance| distance as f32),
        dispersion: given.number("dispersion", 0.0, 1000.0)?.unwrap_or(0.0) as f32,
        scatter_color: given.color("scatter_color")?.unwrap_or([0.0; 3]),
        scatter_anisotropy: given.number("scatter_anisotropy", -0.99, 0.99)?.unwrap_or(0.0) as f32,
    })
}

fn subsurface(given: &mut Given) -> PyResult<Subsurface> {
    let default = Subsurface::default();
    Ok(Subsurface {
        factor: given.number("subsurface", 0.0, 1.0)?.unwrap_or(0.0) as f32,
        radius: given.color("subsurface_radius")?.unwrap_or(default.radius),
        anisotropy: given.number("subsurface_anisotropy", -0.99, 0.99)?.unwrap_or(0.0) as f32,
    })
}

fn ior(given: &mut Given) -> PyResult<f32> {
    Ok(given.number("ior", 0.01, 100.0)?.unwrap_or(1.5) as f32)
}

/// The scene's form of a light.
pub(crate) enum NewLight {
    Light(Light),
    Around(Surroundings, [f32; 3], f64),
    /// A sky that a shader makes.
    Script(Box<Script>, [f32; 3], f64),
    /// A latitude-longitude picture, and its factors.
    Texture(Texture, [f32; 3], [f32; 3], f64),
}

/// A light; `kind` selects its arguments.
pub(crate) fn light(kind: &str, given: &mut Given, pictures: &dyn Pictures) -> PyResult<NewLight> {
    let missing = |name: &str| PyValueError::new_err(format!("{name}: a {kind} light needs one"));
    let position = |given: &mut Given| given.numbers("position")?.ok_or_else(|| missing("position"));
    let direction = |given: &mut Given| {
        let direction: [f32; 3] = given.numbers("direction")?.ok_or_else(|| missing("direction"))?;
        match direction {
            [0.0, 0.0, 0.0] => Err(PyValueError::new_err("direction: the zero vector has no direction")),
            _ => Ok(direction),
        }
    };
    let intensity = |given: &mut Given| Ok::<_, PyErr>(given.color("intensity")?.unwrap_or([1.0; 3]));
    let radius = |given: &mut Given| Ok::<_, PyErr>(given.number("radius", 0.0, MOST)?.unwrap_or(0.0) as f32);
    let edge = |given: &mut Given| match given.text("edge")?.as_deref() {
        None | Some("squared") => Ok(ConeEdge::Squared),
        Some("smooth") => Ok(ConeEdge::Smooth),
        Some(other) => Err(PyValueError::new_err(format!("edge: expected squared or smooth, not '{other}'"))),
    };
    Ok(NewLight::Light(match kind {
        "point" => {
            Light::Point { position: position(given)?, intensity: intensity(given)?, radius: radius(given)? }
        }
        "spot" => {
            let outer = given.number("outer_angle", 0.01, 90.0)?.unwrap_or(45.0);
            let inner = given.number("inner_angle", 0.0, outer)?.unwrap_or(0.0);
            // A cone without an edge would have no light at it.
            let inner = inner.min(outer * (1.0 - 1e-6));
            Light::Spot {
                position: position(given)?,
                direction: direction(given)?,
                intensity: intensity(given)?,
                inner_angle: inner.to_radians() as f32,
                outer_angle: outer.to_radians() as f32,
                edge: edge(given)?,
                radius: radius(given)?,
            }
        }
        "directional" => Light::Directional {
            direction: direction(given)?,
            irradiance: given.color("irradiance")?.unwrap_or([1.0; 3]),
            angle: given.number("angle", 0.0, 180.0)?.unwrap_or(0.0).to_radians() as f32,
        },
        "environment" => {
            let up = given.numbers("up")?.unwrap_or([0.0, 1.0, 0.0]);
            let turn_degrees = given.number("turn", -MOST, MOST)?.unwrap_or(0.0);
            if let Some(script) = script(given, pictures)? {
                return Ok(NewLight::Script(Box::new(script), up, turn_degrees));
            }
            let texture = given.whole("texture", 0, u64::from(u32::MAX))?;
            let sky = given.text("sky")?;
            let picture =
                given.get("picture")?.map(|path| path.extract::<std::path::PathBuf>()).transpose()?;
            let radiance = given.color("radiance")?;
            if let Some(number) = texture {
                if sky.is_some() || picture.is_some() {
                    return Err(PyValueError::new_err("environment: give one of sky, picture and texture"));
                }
                let texture = pictures.texture(number as usize)?;
                return Ok(NewLight::Texture(texture, radiance.unwrap_or([1.0; 3]), up, turn_degrees));
            }
            let around = match (sky, picture, radiance) {
                (Some(sky), None, None) => Surroundings::sky(&sky).ok_or_else(|| {
                    PyValueError::new_err(format!("sky: expected day, evening or overcast, not '{sky}'"))
                })?,
                (None, Some(path), None) => Surroundings::Picture(path),
                (None, None, radiance) => Surroundings::Uniform(radiance.unwrap_or([1.0; 3])),
                _ => return Err(PyValueError::new_err("environment: give one of sky, picture and radiance")),
            };
            return Ok(NewLight::Around(around, up, turn_degrees));
        }
        _ => {
            return Err(PyValueError::new_err(format!(
                "kind: expected point, spot, directional or environment, not '{kind}'"
            )));
        }
    }))
}

/// A camera.
pub(crate) fn camera(given: &mut Given) -> PyResult<Camera> {
    let needed = |name: &str| PyValueError::new_err(format!("{name}: a camera needs one"));
    let mut camera = Camera {
        name: given.text("name")?.unwrap_or_default(),
        eye: given.numbers("eye")?.ok_or_else(|| needed("eye"))?,
        target: given.numbers("target")?.ok_or_else(|| needed("target"))?,
        up: given.numbers("up")?.unwrap_or([0.0, 1.0, 0.0]),
        fov_y: given.number("fov", 0.001, 360.0)?.unwrap_or(40.0) as f32,
        lens: Lens {
            aperture: given.number("aperture", 0.0, MOST)?.unwrap_or(0.0) as f32,
            focus: given.number("focus", f64::from(f32::MIN_POSITIVE), MOST)?.map(|focus| focus as f32),
        },
        shift: given.numbers("shift")?.unwrap_or([0.0; 2]),
        ..Camera::default()
    };
    if camera.frame().is_none() {
        return Err(PyValueError::new_err("target: equal to eye; they must be different points"));
    }
    let word = given.text("projection")?;
    let height = given.number("view_height", f64::from(f32::MIN_POSITIVE), MOST)?;
    camera.projection = match word.as_deref().unwrap_or(Projection::NAMES[0]) {
        "perspective" => Projection::Perspective,
        "fisheye" => Projection::Fisheye,
        "panorama" => Projection::Panorama,
        "orthographic" => Projection::Orthographic {
            height: height.map_or_else(|| camera.height_at_target(), |height| height as f32),
        },
        other => {
            let words = Projection::NAMES.join(", ");
            return Err(PyValueError::new_err(format!("projection: expected one of {words}, not '{other}'")));
        }
    };
    if height.is_some() && !matches!(camera.projection, Projection::Orthographic { .. }) {
        let projection = camera.projection;
        return Err(PyValueError::new_err(format!(
            "view_height: is of orthographic cameras, and this is a {projection}"
        )));
    }
    match camera.fault() {
        Some(fault) => Err(PyValueError::new_err(format!("camera: {fault}"))),
        None => Ok(camera),
    }
}

/// Textures of the layers of a principled material, each named like its number with `_texture` behind.
fn layer_textures(given: &mut Given) -> PyResult<LayerTextures<TextureRef>> {
    Ok(LayerTextures {
        specular: reference(given, "specular_texture")?,
        specular_color: reference(given, "specular_color_texture")?,
        clearcoat: reference(given, "clearcoat_texture")?,
        clearcoat_roughness: reference(given, "clearcoat_roughness_texture")?,
        clearcoat_normal: reference(given, "clearcoat_normal_texture")?,
        clearcoat_normal_scale: given.number("clearcoat_normal_scale", -MOST, MOST)?.unwrap_or(1.0) as f32,
        sheen_color: reference(given, "sheen_color_texture")?,
        sheen_roughness: reference(given, "sheen_roughness_texture")?,
        transmission: reference(given, "transmission_texture")?,
        iridescence: reference(given, "iridescence_texture")?,
        iridescence_thickness: reference(given, "iridescence_thickness_texture")?,
        diffuse_transmission: reference(given, "diffuse_transmission_texture")?,
        diffuse_transmission_color: reference(given, "diffuse_transmission_color_texture")?,
    })
}
