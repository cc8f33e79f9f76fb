// SPDX-License-Identifier: GPL-3.0-or-later
//! Changes of a loaded scene by names: `materials.gold.roughness=0.3`, `lights.key.intensity=2`.
//! A name may be `*`, for all. Numbers have the units of the scene's own fields. Tests: `tests/overrides.rs`.

use std::fmt;
use std::str::FromStr;

use crate::id::{InstanceId, LightId, MaterialId};
use crate::light::Light;
use crate::material::{Alpha, Color, Material, Opacity, OpacityChannel, Principled, Surface};
use crate::scene::Scene;

/// One change.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    part: Part,
    name: String,
    property: String,
    /// One number, or three.
    value: Vec<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Materials,
    Lights,
    Instances,
}

/// A change that cannot be made; `Display` says why, and what would be right.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct OverrideError(String);

const FORM: &str = "expected PART.NAME.PROPERTY=VALUE, such as materials.gold.roughness=0.3; \
                    parts are materials, lights, instances";
const OF_MATERIALS: &str = "color, emission, opacity, roughness, metallic, ior, specular, specular_color, clearcoat, \
                            clearcoat_roughness, sheen_color, sheen_roughness, transmission";
const OF_LIGHTS: &str = "color, intensity, scale";
const OF_INSTANCES: &str = "visible";

impl FromStr for Override {
    type Err = OverrideError;

    fn from_str(text: &str) -> Result<Self, OverrideError> {
        let form = || OverrideError(FORM.into());
        let (path, value) = text.split_once('=').ok_or_else(form)?;
        let (part, rest) = path.split_once('.').ok_or_else(form)?;
        let (name, property) = rest.rsplit_once('.').ok_or_else(form)?;
        let part = match part {
            "materials" => Part::Materials,
            "lights" => Part::Lights,
            "instances" => Part::Instances,
            _ => return Err(form()),
        };
        if name.is_empty() || property.is_empty() {
            return Err(form());
        }
        let number = |text: &str| text.trim().parse::<f32>().ok().filter(|x| x.is_finite());
        let value: Option<Vec<f32>> = match value {
            "true" => Some(vec![1.0]),
            "false" => Some(vec![0.0]),
            _ => value.split(',').map(number).collect(),
        };
        let value = value.filter(|value| matches!(value.len(), 1 | 3));
        let value = value.ok_or_else(|| OverrideError("the value is one number, or three: R,G,B".into()))?;
        Ok(Self { part, name: name.into(), property: property.into(), value })
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = match self.part {
            Part::Materials => "materials",
            Part::Lights => "lights",
            Part::Instances => "instances",
        };
        write!(f, "{part}.{}.{}", self.name, self.property)
    }
}

impl Override {
    /// Changes the scene.
    ///
    /// # Errors
    /// Nothing has the name, its kind has no such property, or the value is out of range. The scene is as before then.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), OverrideError> {
        match self.part {
            Part::Materials => {
                let names = scene.materials().iter().map(|material| material.name.clone()).collect();
                for i in self.found(names)? {
                    let id = MaterialId(i);
                    let mut material = scene.material(id).clone();
                    self.set_material(&mut material)?;
                    *scene.edit_material(id) = material;
                }
            }
            Part::Lights => {
                let labels = &scene.labels().lights;
                let name = |i: u32| labels.get(&LightId(i)).cloned().unwrap_or_else(|| i.to_string());
                let names = (0..scene.lights().len() as u32).map(name).collect();
                for i in self.found(names)? {
                    let mut light = scene.light(LightId(i)).clone();
                    self.set_light(&mut light)?;
                    *scene.edit_light(LightId(i)) = light;
                }
            }
            Part::Instances => {
                let names = scene.instances().iter().map(|instance| instance.name.clone()).collect();
                let found = self.found(names)?;
                let is_visible = match (&self.property[..], &self.value[..]) {
                    ("visible", [0.0]) => false,
                    ("visible", [1.0]) => true,
                    ("visible", _) => return Err(self.error("expected true or false")),
                    _ => return Err(self.unknown(OF_INSTANCES)),
                };
                found.into_iter().for_each(|i| scene.edit_instance(InstanceId(i)).visible = is_visible);
            }
        }
        Ok(())
    }

    fn error(&self, why: impl fmt::Display) -> OverrideError {
        OverrideError(format!("{self}: {why}"))
    }

    fn unknown(&self, valid: &str) -> OverrideError {
        self.error(format_args!("unknown property; valid are {valid}"))
    }

    /// The numbers of those with the name.
    fn found(&self, names: Vec<String>) -> Result<Vec<u32>, OverrideError> {
        let is_meant = |name: &String| self.name == "*" || *name == self.name;
        let found: Vec<u32> = (0..).zip(&names).filter(|(_, name)| is_meant(name)).map(|(i, _)| i).collect();
        if !found.is_empty() {
            return Ok(found);
        }
        if names.is_empty() {
            return Err(self.error("the scene has none"));
        }
        let mut named: Vec<&str> =
            names.iter().map(|name| &name[..]).filter(|name| !name.is_empty()).collect();
        named.sort_unstable();
        named.dedup();
        let more = if named.len() > 8 { ", ..." } else { "" };
        named.truncate(8);
        Err(self.error(format_args!("nothing has this name; there are {}{more}", named.join(", "))))
    }

    fn color(&self) -> Result<[f32; 3], OverrideError> {
        let color = match self.value[..] {
            [all] => [all; 3],
            _ => [self.value[0], self.value[1], self.value[2]],
        };
        match color.iter().all(|&c| c >= 0.0) {
            true => Ok(color),
            false => Err(self.error("expected numbers of 0 or more")),
        }
    }

    fn number(&self, low: f32, high: f32) -> Result<f32, OverrideError> {
        match self.value[..] {
            [x] if (low..=high).contains(&x) => Ok(x),
            _ if high == f32::MAX => Err(self.error(format_args!("expected a number of {low} or more"))),
            _ => Err(self.error(format_args!("expected a number from {low} to {high}"))),
        }
    }

    fn set_material(&self, material: &mut Material) -> Result<(), OverrideError> {
        match &self.property[..] {
            "color" => {
                let to = self.color()?;
                return match base_color(&mut material.surface) {
                    Some(color) => {
                        color.factor = to;
                        Ok(())
                    }
                    None => match &mut material.surface {
                        Surface::Dielectric { transmittance, .. }
                        | Surface::RoughDielectric { transmittance, .. } => {
                            *transmittance = to;
                            Ok(())
                        }
                        _ => Err(self.error("this kind of material has no colour")),
                    },
                };
            }
            "emission" => {
                material.emission = self.color()?;
                return Ok(());
            }
            "opacity" => {
                let factor = self.number(0.0, 1.0)?;
                match &mut material.alpha {
                    Alpha::Blend { opacity } => opacity.factor = factor,
                    _ if factor == 1.0 => {}
                    alpha => {
                        let opacity = Opacity { factor, texture: None, channel: OpacityChannel::Alpha };
                        *alpha = Alpha::Blend { opacity };
                    }
                }
                return Ok(());
            }
            _ => {}
        }
        if let Surface::Metal { roughness, .. } | Surface::RoughDielectric { roughness, .. } =
            &mut material.surface
            && self.property == "roughness"
        {
            *roughness = self.number(0.0, 1.0)?;
            return Ok(());
        }
        if let Surface::Dielectric { ior, .. } | Surface::RoughDielectric { ior, .. } = &mut material.surface
            && self.property == "ior"
        {
            *ior = self.number(1e-3, 100.0)?;
            return Ok(());
        }
        let Some(mut principled) = principled(&material.surface) else {
            return Err(self.error("this kind of material has no such property"));
        };
        let p = &mut principled;
        match &self.property[..] {
            "roughness" => p.roughness = self.number(0.0, 1.0)?,
            "metallic" => p.metallic = self.number(0.0, 1.0)?,
            "ior" => p.ior = self.number(1.0, 100.0)?,
            "specular" => p.specular = self.number(0.0, 1.0)?,
            "specular_color" => p.specular_color = self.color()?,
            "clearcoat" => p.clearcoat = self.number(0.0, 1.0)?,
            "clearcoat_roughness" => p.clearcoat_roughness = self.number(0.0, 1.0)?,
            "sheen_color" => p.sheen_color = self.color()?,
            "sheen_roughness" => p.sheen_roughness = self.number(0.0, 1.0)?,
            "transmission" => p.transmission = self.number(0.0, 1.0)?,
            _ => return Err(self.unknown(OF_MATERIALS)),
        }
        material.surface = Surface::Principled(Box::new(principled));
        Ok(())
    }

    fn set_light(&self, light: &mut Light) -> Result<(), OverrideError> {
        let power = match light {
            Light::Point { intensity, .. } | Light::Spot { intensity, .. } => intensity,
            Light::Directional { irradiance, .. } => irradiance,
            Light::Environment { radiance, .. } => radiance,
            Light::Backdrop { .. } => return Err(self.error("a backdrop is seen, but lights nothing")),
        };
        let most = power.iter().fold(0.0_f32, |most, &c| most.max(c));
        *power = match &self.property[..] {
            "scale" => {
                let scale = self.number(0.0, f32::MAX)?;
                power.map(|c| c * scale)
            }
            "intensity" => {
                let to = self.number(0.0, f32::MAX)?;
                if most > 0.0 { power.map(|c| c / most * to) } else { [to; 3] }
            }
            "color" => {
                let to = self.color()?;
                let brightest = to.iter().fold(0.0_f32, |most, &c| most.max(c));
                let scale = if brightest > 0.0 { most / brightest } else { 0.0 };
                to.map(|c| c * scale)
            }
            _ => return Err(self.unknown(OF_LIGHTS)),
        };
        Ok(())
    }
}

fn base_color(surface: &mut Surface) -> Option<&mut Color> {
    match surface {
        Surface::Matte { base_color }
        | Surface::RoughMatte { base_color, .. }
        | Surface::MetallicRoughness { base_color, .. } => Some(base_color),
        Surface::Principled(principled) => Some(&mut principled.base_color),
        Surface::Mirror { reflectance } => Some(reflectance),
        Surface::Unlit { color } => Some(color),
        _ => None,
    }
}

/// The same surface with all layers; a matte one reflects nothing but by its body until more is set.
fn principled(surface: &Surface) -> Option<Principled> {
    Some(match surface {
        Surface::Principled(principled) => (**principled).clone(),
        Surface::MetallicRoughness {
            base_color,
            metallic,
            roughness,
            metallic_roughness_texture,
            ior,
            normal_texture,
        } => Principled {
            base_color: *base_color,
            metallic: *metallic,
            roughness: *roughness,
            metallic_roughness_texture: *metallic_roughness_texture,
            ior: *ior,
            normal_texture: *normal_texture,
            ..Principled::default()
        },
        Surface::Matte { base_color } | Surface::RoughMatte { base_color, .. } => {
            Principled { base_color: *base_color, metallic: 0.0, specular: 0.0, ..Principled::default() }
        }
        _ => return None,
    })
}
