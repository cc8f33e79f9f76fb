// SPDX-License-Identifier: GPL-3.0-or-later
//! The statements `LightSource` and `AreaLightSource`.
//! Source: the section Lights of the file-format page; scales as in pbrt-v4: a light of scale 1 has luminance 1, `power` and
//! `illuminance` are then in its photometric units. A spot's edge is ours, with the light of pbrt's. Tests: `tests/lights.rs`.

use std::f32::consts::PI;
use std::path::PathBuf;

use gnurt_scene::io::reader::{Access, quoted, resolve};
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::{Affine, ConeEdge, Light};

use crate::location::Location;
use crate::parameter::Parameters;
use crate::spectrum::Spectrum;
use crate::transform::{double, single, unit};

/// The light of a surface.
#[derive(Clone, Debug)]
pub(crate) struct AreaLight {
    /// Radiance, before it is divided by the surface's area where there is a power.
    pub(crate) radiance: [f32; 3],
    pub(crate) both_sides: bool,
    /// Of the whole surface.
    pub(crate) power: Option<f32>,
    pub(crate) picture: Option<PathBuf>,
    pub(crate) location: Location,
}

/// Light from all directions.
#[derive(Clone, Debug)]
pub(crate) struct Infinite {
    /// Radiance, multiplied to the picture.
    pub(crate) radiance: [f32; 3],
    pub(crate) picture: Option<PathBuf>,
    pub(crate) illuminance: Option<f32>,
    pub(crate) location: Location,
}

/// A light.
pub(crate) enum Found {
    Plain(Light),
    /// One that a picture is before: it has the picture's mean, as a colour or grey.
    Pictured {
        light: Light,
        picture: PathBuf,
        grey: bool,
    },
    Infinite(Infinite),
}

/// Data for reading lights.
pub(crate) struct Reading<'a> {
    pub(crate) access: &'a Access,
    /// From the current space to the renderer's world.
    pub(crate) world_from_light: Affine,
    /// The film's factor of all light.
    pub(crate) exposure: f32,
}

fn times(color: [f32; 3], by: f32) -> [f32; 3] {
    color.map(|c| c * by)
}

/// The colour of a light under this name; white if it is not given.
fn spectrum(parameters: &Parameters, name: &str, access: &Access) -> Result<[f32; 3], Error> {
    Ok(Spectrum::of(parameters, name, access)?.map_or([1.0; 3], |found| found.light()))
}

/// A light with the mean of its picture; a power is that of all of it already.
fn pictured(parameters: &Parameters, light: Light, grey: bool) -> Result<Found, Error> {
    let picture = parameters.text("filename")?.map(|name| resolve(&parameters.location.path, name));
    let has_power = parameters.float("power")?.is_some_and(|power| power > 0.0);
    Ok(match picture.filter(|_| !has_power) {
        Some(picture) => Found::Pictured { light, picture, grey },
        None => Found::Plain(light),
    })
}

impl Reading<'_> {
    fn point(&self, p: [f32; 3]) -> [f64; 3] {
        self.world_from_light.point(double(p))
    }

    /// The direction from one point of the light's space to another.
    fn towards(&self, parameters: &Parameters) -> Result<[f32; 3], Error> {
        let [from, to] = self.ends(parameters)?;
        let along = [0, 1, 2].map(|k| f64::from(to[k]) - f64::from(from[k]));
        let along = unit(self.world_from_light.vector(along));
        along.map(single).ok_or_else(|| {
            parameters
                .location
                .error("\"from\" and \"to\" of a light are one point", "give points that differ")
        })
    }

    fn ends(&self, parameters: &Parameters) -> Result<[[f32; 3]; 2], Error> {
        Ok([parameters.triple_or("from", [0.0; 3])?, parameters.triple_or("to", [0.0, 0.0, 1.0])?])
    }

    /// Its scale, times the film's factor.
    fn scale(&self, parameters: &Parameters) -> Result<f32, Error> {
        let scale = parameters.float_or("scale", 1.0)?;
        if !(scale >= 0.0 && scale.is_finite()) {
            return Err(parameters
                .location
                .error(format!("\"scale\" of a light is {scale}"), "it must be 0 or above"));
        }
        Ok(scale * self.exposure)
    }

    /// A light of a class with these parameters.
    pub(crate) fn read(
        &self,
        class: &str,
        parameters: &Parameters,
        warnings: &mut Warnings,
    ) -> Result<Found, Error> {
        let location = &parameters.location;
        let power = |of_unit: f32| -> Result<f32, Error> {
            Ok(parameters.float("power")?.filter(|power| *power > 0.0).map_or(1.0, |power| power / of_unit))
        };
        let light = match class {
            "point" => Light::Point {
                position: single(self.point(parameters.triple_or("from", [0.0; 3])?)),
                intensity: times(
                    spectrum(parameters, "I", self.access)?,
                    self.scale(parameters)? * power(4.0 * PI)?,
                ),
                radius: 0.0,
            },
            "spot" => self.spot(parameters, power)?,
            "distant" => {
                let illuminance = parameters.float("illuminance")?.filter(|e| *e > 0.0).unwrap_or(1.0);
                let color = spectrum(parameters, "L", self.access)?;
                Light::Directional {
                    direction: self.towards(parameters)?,
                    irradiance: times(color, self.scale(parameters)? * illuminance),
                    angle: 0.0,
                }
            }
            "infinite" => return self.infinite(parameters, warnings).map(Found::Infinite),
            "goniometric" => {
                location.warn(warnings, Oddity::StandIn, "light \"goniometric\", the same to all sides");
                let light = Light::Point {
                    position: single(self.point([0.0; 3])),
                    intensity: times(
                        spectrum(parameters, "I", self.access)?,
                        self.scale(parameters)? * power(4.0 * PI)?,
                    ),
                    radius: 0.0,
                };
                return pictured(parameters, light, true);
            }
            "projection" => {
                location.warn(
                    warnings,
                    Oddity::StandIn,
                    "light \"projection\", a spot of its picture's mean colour",
                );
                let half = (parameters.float_or("fov", 90.0)? / 2.0).clamp(0.1, 89.0).to_radians();
                let along = self.world_from_light.vector([0.0, 0.0, 1.0]);
                let solid = 2.0 * PI * (1.0 - half.cos());
                let light = Light::Spot {
                    position: single(self.point([0.0; 3])),
                    direction: single(unit(along).unwrap_or([0.0, 0.0, 1.0])),
                    intensity: [self.scale(parameters)? * power(solid)?; 3],
                    inner_angle: 0.999 * half,
                    outer_angle: half,
                    edge: ConeEdge::default(),
                    radius: 0.0,
                };
                return pictured(parameters, light, false);
            }
            other => {
                let known = "distant, goniometric, infinite, point, projection and spot";
                return Err(
                    location.error(format!("unknown light {}", quoted(other)), format!("valid are {known}"))
                );
            }
        };
        Ok(Found::Plain(light))
    }

    fn spot(
        &self,
        parameters: &Parameters,
        power: impl Fn(f32) -> Result<f32, Error>,
    ) -> Result<Light, Error> {
        let outer = parameters.float_or("coneangle", 30.0)?.clamp(0.01, 180.0);
        let inner = (outer - parameters.float_or("conedeltaangle", 5.0)?).clamp(0.0, outer);
        let [cos_end, cos_start] = [outer, inner].map(|angle| angle.to_radians().cos());
        let of_unit = 2.0 * PI * ((1.0 - cos_start) + (cos_start - cos_end) / 2.0);
        let from = parameters.triple_or("from", [0.0; 3])?;
        Ok(Light::Spot {
            position: single(self.point(from)),
            direction: self.towards(parameters)?,
            intensity: times(
                spectrum(parameters, "I", self.access)?,
                self.scale(parameters)? * power(of_unit)?,
            ),
            inner_angle: inner.to_radians(),
            outer_angle: outer.to_radians(),
            edge: ConeEdge::Smooth,
            radius: 0.0,
        })
    }

    fn infinite(&self, parameters: &Parameters, warnings: &mut Warnings) -> Result<Infinite, Error> {
        let location = &parameters.location;
        if parameters.triples("portal").is_some() {
            location.warn(
                warnings,
                Oddity::StandIn,
                "\"portal\" of an infinite light: light comes from everywhere",
            );
        }
        let picture = parameters.text("filename")?.map(|name| resolve(&location.path, name));
        let color = Spectrum::of(parameters, "L", self.access)?;
        if picture.is_some() && color.is_some() {
            let problem = "an infinite light has both \"L\" and \"filename\"";
            return Err(location.error(problem, "leave one of them out"));
        }
        let color = color.map_or([1.0; 3], |found| found.light());
        let radiance = times(color, self.scale(parameters)?);
        let illuminance = parameters.float("illuminance")?.filter(|e| *e > 0.0);
        Ok(match (picture, illuminance) {
            (None, Some(illuminance)) => Infinite {
                radiance: times(radiance, illuminance / PI),
                picture: None,
                illuminance: None,
                location: location.clone(),
            },
            (picture, illuminance) => Infinite { radiance, picture, illuminance, location: location.clone() },
        })
    }

    /// The light of surfaces from now on.
    pub(crate) fn area(&self, class: &str, parameters: &Parameters) -> Result<AreaLight, Error> {
        let location = &parameters.location;
        if class != "diffuse" {
            return Err(location.error(format!("unknown area light {}", quoted(class)), "valid is diffuse"));
        }
        let picture = parameters.text("filename")?.map(|name| resolve(&location.path, name));
        let color = Spectrum::of(parameters, "L", self.access)?;
        if picture.is_some() && color.is_some() {
            let problem = "an area light has both \"L\" and \"filename\"";
            return Err(location.error(problem, "leave one of them out"));
        }
        let color = color.map_or([1.0; 3], |found| found.light());
        Ok(AreaLight {
            radiance: times(color, self.scale(parameters)?),
            both_sides: parameters.bool_or("twosided", false)?,
            power: parameters.float("power")?.filter(|power| *power > 0.0),
            picture,
            location: location.clone(),
        })
    }
}
