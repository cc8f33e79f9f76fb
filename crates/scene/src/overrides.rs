// SPDX-License-Identifier: GPL-3.0-or-later
//! Changes of a scene by text, such as `materials.gold.roughness=0.3`: values of a file, replaced before
//! rendering. A path names a list, an element and a field; one function for each kind of surface lists its
//! fields, with their ranges.
//! Tests: `tests`, crates/cli/tests/program/overrides.rs.

use crate::displacement::{Displacement, Offset, Refinement};
use crate::id::{InstanceId, LightId, MaterialId};
use crate::labels::Shining;
use crate::light::Light;
use crate::light_links::LinkKind;
use crate::material::{Alpha, Material, Opacity, OpacityChannel, Principled, Surface};
use crate::scene::Scene;

/// One change: `LIST.NAME.FIELD=VALUE`.
///
/// * `materials.NAME.FIELD`: base_color, metallic, roughness, ior, specular, clearcoat, transmission, emission, opacity and others; an
///   error lists those of the material's kind. Colours are linear: three numbers `r,g,b`, or one for a grey. A texture of the
///   field stays, and is multiplied.
/// * `lights.NAME.intensity`: a name of the file, or the number from 0 in the order of `gnurt info`. One number sets the largest
///   channel and keeps the colour; three numbers set the channels; `*` before a number multiplies by it. The unit is the
///   light's own (W/sr, W/m² or radiance).
///   `materials.NAME.emission` takes the same forms.
/// * `materials.NAME.displacement`: how far surfaces move along their normals; the factor of a texture that displaces them already.
///   `displacement_edge`: triangles are cut until no edge is longer; `displacement_levels`: each triangle is cut into four, so often.
/// * `instances.NAME.visible`: `true` or `false`; `instances.NAME.holdout`: whether it leaves a hole in the picture;
///   `instances.NAME.traceset`: names of sets that it is added to, between commas.
/// * `group` of lights, materials and instances: the light group of what they give off; any name.
/// * `link` and `shadow_link` of the same: names of the instances that their light reaches, and that stop it, between commas;
///   `none`, or `^` before the names for all others.
///
/// `*` as a name means all of them: those without the field stay as they are, but one must have it.
///
/// # Examples
///
/// ```
/// use gnurt_scene::{Material, Scene, overrides::Override};
///
/// let mut scene = Scene::new();
/// scene.add_material(Material::matte("wall", [0.5; 3]));
/// Override::parse("materials.*.base_color=0.2,0.3,0.4")?.apply(&mut scene)?;
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    list: List,
    name: String,
    field: String,
    value: String,
}

/// Lists of a scene whose elements can be changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum List {
    Materials,
    Lights,
    Instances,
}

/// The names of the lists.
const LISTS: [(&str, List); 3] =
    [("materials", List::Materials), ("lights", List::Lights), ("instances", List::Instances)];

/// A field of an element, to write its value.
enum Slot<'a> {
    /// A number within a range.
    Number(&'a mut f32, [f32; 2]),
    /// Three numbers of at least 0 and at most this; one number is a grey.
    Color(&'a mut [f32; 3], f32),
    /// Three numbers of at least 0; one number keeps the colour.
    Light(&'a mut [f32; 3]),
    /// Yes or no.
    Flag(&'a mut bool),
}

const UNIT: [f32; 2] = [0.0, 1.0];
/// Indices of refraction.
const IOR: [f32; 2] = [1e-3, 1e3];
/// Thicknesses and distances.
const LENGTH: [f32; 2] = [0.0, f32::MAX];

impl Override {
    /// Reads `LIST.NAME.FIELD=VALUE`. A name may hold dots.
    ///
    /// # Errors
    ///
    /// If the text has another form, or the list is not one of `materials`, `lights` and `instances`.
    pub fn parse(text: &str) -> Result<Self, String> {
        let form = || {
            format!(
                "invalid change of a scene: '{text}'; give LIST.NAME.FIELD=VALUE like materials.gold.roughness=0.3"
            )
        };
        let (path, value) = text.split_once('=').ok_or_else(form)?;
        let (list, rest) = path.split_once('.').ok_or_else(form)?;
        let (name, field) = rest.rsplit_once('.').ok_or_else(form)?;
        if name.is_empty() || field.is_empty() || value.trim().is_empty() {
            return Err(form());
        }
        let known = LISTS.iter().find(|(known, _)| *known == list);
        let Some(&(_, list)) = known else {
            let lists = LISTS.map(|(list, _)| list).join(", ");
            return Err(format!("unknown list of a scene: '{list}'; valid are: {lists}"));
        };
        Ok(Self { list, name: name.into(), field: field.into(), value: value.trim().into() })
    }

    /// Makes the change.
    ///
    /// # Errors
    ///
    /// If nothing has that name, nothing of that name has the field, or the value is out of its range. The message lists the valid ones.
    /// The scene is then unchanged, except for elements before the faulty one under `*`.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), String> {
        let places = self.places(scene)?;
        match &self.field[..] {
            "group" => return self.put_into_group(&places, scene),
            field if self.list == List::Materials && field.starts_with("displacement") => {
                return self.displace(&places, scene);
            }
            "holdout" if self.list == List::Instances => return self.hold_out(&places, scene),
            "traceset" if self.list == List::Instances => return self.add_to_trace_sets(&places, scene),
            "link" => return self.link(&places, LinkKind::Lit, scene),
            "shadow_link" => return self.link(&places, LinkKind::Shadows, scene),
            _ => {}
        }
        let mut valid: Vec<&'static str> = Vec::new();
        let mut changed = 0;
        for place in places {
            let known = match self.list {
                List::Materials => {
                    let mut material = scene.material(MaterialId(place)).clone();
                    if self.field == "opacity" && material.alpha == Alpha::Opaque {
                        let channel = OpacityChannel::Alpha;
                        material.alpha =
                            Alpha::Blend { opacity: Opacity { factor: 1.0, texture: None, channel } };
                    }
                    let known = self.set_material(&mut material)?;
                    if known.is_ok() && material != *scene.material(MaterialId(place)) {
                        *scene.edit_material(MaterialId(place)) = material;
                    }
                    known
                }
                List::Lights => {
                    let mut light = scene.light(LightId(place)).clone();
                    let known = self.set(light_fields(&mut light))?;
                    if known.is_ok() {
                        *scene.edit_light(LightId(place)) = light;
                    }
                    known
                }
                List::Instances => {
                    let instance = scene.edit_instance(InstanceId(place));
                    self.set(vec![("visible", Slot::Flag(&mut instance.visible))])?
                }
            };
            match known {
                Ok(()) => changed += 1,
                Err(names) => {
                    valid.extend(names.into_iter().filter(|name| !valid.contains(name)).collect::<Vec<_>>());
                }
            }
        }
        if changed > 0 {
            return Ok(());
        }
        let (list, name) = (self.list_name(), &self.name);
        let valid = if valid.is_empty() { "none".into() } else { valid.join(", ") };
        Err(format!("{list}.{name}: unknown field '{}'; valid are: {valid}", self.field))
    }

    /// Sets the field of a material; metal and plastic get layers if only those have it.
    fn set_material(&self, material: &mut Material) -> Result<Result<(), Vec<&'static str>>, String> {
        let known = self.set(material_fields(material))?;
        if known.is_err()
            && let Some(mut layered) = material.surface.layered()
            && self.set(principled_fields(&mut layered))?.is_ok()
        {
            material.surface = Surface::Principled(Box::new(layered));
            return Ok(Ok(()));
        }
        Ok(known)
    }

    /// Changes how surfaces are displaced.
    fn displace(&self, places: &[u32], scene: &mut Scene) -> Result<(), String> {
        let wrong = |allowed: &str| {
            Err(format!("materials.{}.{}: invalid value '{}'; {allowed}", self.name, self.field, self.value))
        };
        let number = self.value.parse::<f32>().ok().filter(|x| x.is_finite());
        for id in places.iter().copied().map(MaterialId) {
            let none = Displacement::new(Offset::Constant(0.0));
            let mut displacement = scene.displacement(id).copied().unwrap_or(none);
            match (&self.field[..], number) {
                ("displacement", Some(height)) => match &mut displacement.offset {
                    Offset::Height { .. } | Offset::Vector { .. } => displacement.scale = height,
                    offset => *offset = Offset::Constant(height),
                },
                ("displacement", None) => return wrong("give a number"),
                ("displacement_edge", Some(longest)) if longest > 0.0 => {
                    displacement.refinement = Refinement::Edges(longest);
                }
                ("displacement_edge", _) => return wrong("give a number above 0"),
                ("displacement_levels", _) => match self.value.parse::<u8>() {
                    Ok(levels @ 0..=12) => displacement.refinement = Refinement::Levels(levels),
                    _ => return wrong("give a whole number from 0 to 12"),
                },
                (other, _) => {
                    return Err(format!(
                        "materials.{}: unknown field '{other}'; valid are: displacement, displacement_edge, displacement_levels",
                        self.name
                    ));
                }
            }
            scene.set_displacement(id, Some(displacement));
        }
        Ok(())
    }

    fn put_into_group(&self, places: &[u32], scene: &mut Scene) -> Result<(), String> {
        let is_fine = |c: char| c.is_alphanumeric() || "_-. ".contains(c);
        if !self.value.chars().all(is_fine) || self.value.len() > 100 {
            return Err(format!(
                "{}.{}.group: invalid value '{}'; give letters, digits, _ - . and spaces",
                self.list_name(),
                self.name,
                self.value
            ));
        }
        places.iter().for_each(|&place| scene.labels_mut().set_light_group(self.shining(place), &self.value));
        Ok(())
    }

    fn hold_out(&self, places: &[u32], scene: &mut Scene) -> Result<(), String> {
        let is_one: bool = self.value.parse().map_err(|_| {
            format!("instances.{}.holdout: invalid value '{}'; give true or false", self.name, self.value)
        })?;
        for id in places.iter().copied().map(InstanceId) {
            match is_one {
                true => _ = scene.labels_mut().holdouts.insert(id),
                false => _ = scene.labels_mut().holdouts.remove(&id),
            }
        }
        Ok(())
    }

    fn add_to_trace_sets(&self, places: &[u32], scene: &mut Scene) -> Result<(), String> {
        let add = |id: &u32| scene.labels_mut().add_to_trace_sets(InstanceId(*id), &self.value);
        let added: Result<(), String> = places.iter().try_for_each(add);
        added.map_err(|why| format!("instances.{}.traceset: {why}", self.name))
    }

    /// Links lights to instances by names between commas; `^` before the first means all but these.
    fn link(&self, places: &[u32], kind: LinkKind, scene: &mut Scene) -> Result<(), String> {
        let (is_negated, list) =
            self.value.strip_prefix('^').map_or((false, &self.value[..]), |rest| (true, rest));
        let names: Vec<&str> = list.split(',').map(str::trim).filter(|name| !name.is_empty()).collect();
        let (found, unknown) = match &names[..] {
            ["none"] => (Vec::new(), Vec::new()),
            names => scene.instances_named(names),
        };
        if let Some(name) = unknown.first() {
            let (list, own, field) = (self.list_name(), &self.name, &self.field);
            return Err(format!("{list}.{own}.{field}: no instance is called '{name}'"));
        }
        let all = (0..scene.instances().len() as u32).map(InstanceId);
        let members: Vec<InstanceId> =
            if is_negated { all.filter(|id| found.binary_search(id).is_err()).collect() } else { found };
        for &place in places {
            scene.link_light(self.shining(place), kind, Some(members.clone()));
        }
        Ok(())
    }

    fn shining(&self, place: u32) -> Shining {
        match self.list {
            List::Materials => Shining::Material(MaterialId(place)),
            List::Lights => Shining::Light(LightId(place)),
            List::Instances => Shining::Instance(InstanceId(place)),
        }
    }

    fn list_name(&self) -> &'static str {
        LISTS.iter().find(|(_, list)| *list == self.list).map_or("", |(name, _)| name)
    }

    /// Those of the list that the name means.
    fn places(&self, scene: &Scene) -> Result<Vec<u32>, String> {
        let names: Vec<String> = match self.list {
            List::Materials => scene.materials().iter().map(|material| material.name.clone()).collect(),
            List::Lights => {
                let name = |number: u32| {
                    let named = scene.labels().lights.get(&LightId(number));
                    // Numbers mean a light whatever its name is.
                    let is_number = self.name == number.to_string();
                    named.filter(|_| !is_number).cloned().unwrap_or_else(|| number.to_string())
                };
                (0..scene.lights().len() as u32).map(name).collect()
            }
            List::Instances => scene.instances().iter().map(|instance| instance.name.clone()).collect(),
        };
        // Paths are known by their last part as well.
        let is_last = |name: &str| name.rsplit('/').next() == Some(&self.name[..]);
        let meant = |name: &String| self.name == "*" || *name == self.name || is_last(name);
        let places: Vec<u32> = (0..).zip(&names).filter(|(_, name)| meant(name)).map(|(i, _)| i).collect();
        if !places.is_empty() {
            return Ok(places);
        }
        const MOST: usize = 20;
        let mut valid: Vec<&str> = names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
        valid.dedup();
        let more = valid.len().saturating_sub(MOST);
        valid.truncate(MOST);
        let mut list = valid.join(", ");
        if more > 0 {
            list += &format!(" and {more} more");
        }
        let list = if list.is_empty() { "none: the list is empty or nameless".into() } else { list };
        Err(format!("{}: unknown name '{}'; valid are: {list}", self.list_name(), self.name))
    }

    /// Sets the field; the names of the fields, if it is none of them.
    fn set(&self, fields: Vec<(&'static str, Slot)>) -> Result<Result<(), Vec<&'static str>>, String> {
        let names = fields.iter().map(|(name, _)| *name).collect();
        match fields.into_iter().find(|(name, _)| *name == self.field) {
            None => Ok(Err(names)),
            Some((_, slot)) => self.put(slot).map(Ok),
        }
    }

    fn put(&self, slot: Slot) -> Result<(), String> {
        let wrong = |allowed: String| {
            let path = format!("{}.{}.{}", self.list_name(), self.name, self.field);
            format!("{path}: invalid value '{}'; {allowed}", self.value)
        };
        let numbers = |most: f32| {
            let parsed: Result<Vec<f32>, _> =
                self.value.split(',').map(|number| number.trim().parse::<f32>()).collect();
            let numbers = parsed.ok().filter(|all| all.iter().all(|x| (0.0..=most).contains(x)));
            match numbers.as_deref() {
                Some(&[grey]) => Some((vec![grey; 3], true)),
                Some(&[r, g, b]) => Some((vec![r, g, b], false)),
                _ => None,
            }
        };
        let three = |most: f32| {
            let range = if most < f32::MAX { format!("from 0 to {most}") } else { "of at least 0".into() };
            format!("give three numbers {range} like 0.8,0.5,0.2, or one")
        };
        match slot {
            Slot::Number(place, [least, most]) => {
                let value = self.value.parse::<f32>().ok().filter(|x| (least..=most).contains(x));
                let range = if most < f32::MAX {
                    format!("from {least} to {most}")
                } else {
                    format!("of at least {least}")
                };
                *place = value.ok_or_else(|| wrong(format!("give a number {range}")))?;
            }
            Slot::Color(place, most) => {
                let (color, _) = numbers(most).ok_or_else(|| wrong(three(most)))?;
                place.copy_from_slice(&color);
            }
            Slot::Light(place) => {
                if let Some(factor) = self.value.strip_prefix('*') {
                    let factor = factor.trim().parse::<f32>().ok().filter(|x| (0.0..=f32::MAX).contains(x));
                    let factor =
                        factor.ok_or_else(|| wrong("give a number of at least 0 after the *".into()))?;
                    *place = place.map(|x| x * factor);
                    return Ok(());
                }
                let (color, is_one) = numbers(f32::MAX).ok_or_else(|| wrong(three(f32::MAX)))?;
                let largest = place.iter().fold(0.0_f32, |most, &x| most.max(x));
                if is_one && largest > 0.0 {
                    *place = place.map(|x| x / largest * color[0]);
                } else {
                    place.copy_from_slice(&color);
                }
            }
            Slot::Flag(place) => {
                *place = self.value.parse().map_err(|_| wrong("give true or false".into()))?;
            }
        }
        Ok(())
    }
}

/// The fields of a material, by its kind of surface.
fn material_fields(material: &mut Material) -> Vec<(&'static str, Slot<'_>)> {
    use Slot::{Color, Number};
    let Material { surface, alpha, emission, .. } = material;
    let mut fields = match surface {
        Surface::Matte { base_color } => vec![("base_color", Color(&mut base_color.factor, 1.0))],
        Surface::MetallicRoughness { base_color, metallic, roughness, ior, .. } => vec![
            ("base_color", Color(&mut base_color.factor, 1.0)),
            ("metallic", Number(metallic, UNIT)),
            ("roughness", Number(roughness, UNIT)),
            ("ior", Number(ior, IOR)),
        ],
        Surface::Principled(principled) => principled_fields(principled),
        Surface::RoughMatte { base_color, roughness } => {
            vec![("base_color", Color(&mut base_color.factor, 1.0)), ("roughness", Number(roughness, UNIT))]
        }
        Surface::Metal { eta, k, roughness } => vec![
            ("eta", Color(eta, f32::MAX)),
            ("k", Color(k, f32::MAX)),
            ("roughness", Number(roughness, UNIT)),
        ],
        Surface::RoughDielectric { ior, roughness, reflectance, transmittance, .. } => vec![
            ("ior", Number(ior, IOR)),
            ("roughness", Number(roughness, UNIT)),
            ("reflectance", Color(reflectance, 1.0)),
            ("transmittance", Color(transmittance, 1.0)),
        ],
        Surface::Mirror { reflectance } => vec![("reflectance", Color(&mut reflectance.factor, 1.0))],
        Surface::Dielectric { ior, reflectance, transmittance, .. } => vec![
            ("ior", Number(ior, IOR)),
            ("reflectance", Color(reflectance, 1.0)),
            ("transmittance", Color(transmittance, 1.0)),
        ],
        Surface::ShadowCatcher { albedo, .. } => vec![("albedo", Color(albedo, 1.0))],
        Surface::Unlit { color } => vec![("color", Color(&mut color.factor, f32::MAX))],
        Surface::Shader(_) => Vec::new(),
    };
    fields.push(("emission", Slot::Light(emission)));
    match alpha {
        Alpha::Opaque => {}
        Alpha::Mask { cutoff, opacity } => {
            fields.push(("alpha_cutoff", Number(cutoff, UNIT)));
            fields.push(("opacity", Number(&mut opacity.factor, UNIT)));
        }
        Alpha::Blend { opacity } => fields.push(("opacity", Number(&mut opacity.factor, UNIT))),
    }
    fields
}

fn principled_fields(principled: &mut Principled) -> Vec<(&'static str, Slot<'_>)> {
    use Slot::{Color, Number};
    let Principled { interior, anisotropy, iridescence, diffuse_transmission, subsurface, .. } = principled;
    vec![
        ("base_color", Color(&mut principled.base_color.factor, 1.0)),
        ("metallic", Number(&mut principled.metallic, UNIT)),
        ("roughness", Number(&mut principled.roughness, UNIT)),
        ("ior", Number(&mut principled.ior, IOR)),
        ("specular", Number(&mut principled.specular, UNIT)),
        ("specular_color", Color(&mut principled.specular_color, f32::MAX)),
        ("clearcoat", Number(&mut principled.clearcoat, UNIT)),
        ("clearcoat_roughness", Number(&mut principled.clearcoat_roughness, UNIT)),
        ("sheen_color", Color(&mut principled.sheen_color, 1.0)),
        ("sheen_roughness", Number(&mut principled.sheen_roughness, UNIT)),
        ("transmission", Number(&mut principled.transmission, UNIT)),
        ("thin", Slot::Flag(&mut principled.thin)),
        ("attenuation_color", Color(&mut interior.attenuation_color, 1.0)),
        ("attenuation_distance", Number(&mut interior.attenuation_distance, LENGTH)),
        ("dispersion", Number(&mut interior.dispersion, LENGTH)),
        ("anisotropy", Number(&mut anisotropy.strength, UNIT)),
        ("anisotropy_rotation", Number(&mut anisotropy.rotation, [-1e3, 1e3])),
        ("iridescence", Number(&mut iridescence.factor, UNIT)),
        ("iridescence_ior", Number(&mut iridescence.ior, IOR)),
        ("iridescence_thickness", Number(&mut iridescence.thickness, LENGTH)),
        ("diffuse_transmission", Number(&mut diffuse_transmission.factor, UNIT)),
        ("diffuse_transmission_color", Color(&mut diffuse_transmission.color, 1.0)),
        ("subsurface", Number(&mut subsurface.factor, UNIT)),
        ("subsurface_radius", Color(&mut subsurface.radius, f32::MAX)),
        ("subsurface_anisotropy", Number(&mut subsurface.anisotropy, [-0.99, 0.99])),
    ]
}

fn light_fields(light: &mut Light) -> Vec<(&'static str, Slot<'_>)> {
    match light {
        Light::Point { intensity, radius, .. } | Light::Spot { intensity, radius, .. } => {
            vec![("intensity", Slot::Light(intensity)), ("radius", Slot::Number(radius, LENGTH))]
        }
        Light::Directional { irradiance, .. } => vec![("intensity", Slot::Light(irradiance))],
        Light::Environment { radiance, .. } => vec![("intensity", Slot::Light(radiance))],
        Light::Backdrop { .. } => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let mut scene = Scene::new();
        scene.add_material(Material::matte("wall.white", [0.5; 3]));
        scene.add_material(Material::of("gold", Surface::Principled(Box::default())));
        scene.add_light(Light::Point { position: [0.0; 3], intensity: [4.0, 2.0, 1.0], radius: 0.0 });
        scene
    }

    fn apply(scene: &mut Scene, text: &str) -> Result<(), String> {
        Override::parse(text)?.apply(scene)
    }

    #[test]
    fn fields_take_numbers_colours_and_intensities() {
        let mut scene = scene();
        apply(&mut scene, "materials.gold.roughness=0.25").expect("a number");
        apply(&mut scene, "materials.wall.white.base_color=0.1,0.2,0.3").expect("a name with a dot");
        apply(&mut scene, "lights.0.intensity=8").expect("one number");
        apply(&mut scene, "materials.*.clearcoat=1").expect("one of them has it");
        let Surface::Principled(gold) = &scene.materials()[1].surface else { panic!("a principled one") };
        assert_eq!((gold.roughness, gold.clearcoat), (0.25, 1.0));
        assert_eq!(scene.materials()[0].surface.base_color().factor, [0.1, 0.2, 0.3]);
        let Light::Point { intensity, .. } = scene.lights()[0] else { panic!("a point light") };
        assert_eq!(intensity, [8.0, 4.0, 2.0], "the colour stays");
        apply(&mut scene, "lights.*.intensity=*0.5").expect("a factor");
        let Light::Point { intensity, .. } = scene.lights()[0] else { panic!("a point light") };
        assert_eq!(intensity, [4.0, 2.0, 1.0], "half of it");
        apply(&mut scene, "materials.gold.opacity=0.5").expect("an opaque material becomes transparent");
        assert!(matches!(scene.materials()[1].alpha, Alpha::Blend { opacity } if opacity.factor == 0.5));
        let plastic = Surface::MetallicRoughness {
            base_color: crate::material::Color::constant([0.5; 3]),
            metallic: 0.0,
            roughness: 0.3,
            metallic_roughness_texture: None,
            ior: 1.4,
            normal_texture: None,
        };
        scene.add_material(Material::of("plastic", plastic));
        apply(&mut scene, "materials.plastic.roughness=0.2").expect("its own field");
        assert!(matches!(scene.materials()[2].surface, Surface::MetallicRoughness { .. }));
        apply(&mut scene, "materials.plastic.subsurface=1").expect("a field of layers");
        let Surface::Principled(layered) = &scene.materials()[2].surface else { panic!("layers") };
        assert_eq!((layered.ior, layered.roughness, layered.subsurface.factor), (1.4, 0.2, 1.0));
        apply(&mut scene, "materials.gold.subsurface_radius=0.3,0.2,0.1").expect("a length by colour");
        apply(&mut scene, "materials.gold.displacement_levels=3").expect("a whole number");
        apply(&mut scene, "materials.gold.displacement=-0.5").expect("a hollow");
        let refinement = Refinement::Levels(3);
        let expected = Displacement { refinement, ..Displacement::new(Offset::Constant(-0.5)) };
        assert_eq!(scene.displacement(MaterialId(1)), Some(&expected));
        let texture = crate::texture::TextureRef::new(crate::id::TextureId(0));
        let offset = Offset::Height { texture, channel: 0 };
        scene.set_displacement(MaterialId(1), Some(Displacement::new(offset)));
        apply(&mut scene, "materials.gold.displacement=0.25").expect("a factor");
        let found = scene.displacement(MaterialId(1)).expect("one");
        assert_eq!((found.scale, found.offset), (0.25, offset), "of the texture");
    }

    #[test]
    fn mistakes_name_what_is_valid() {
        let mut scene = scene();
        for (text, words) in [
            ("gold", "LIST.NAME.FIELD=VALUE"),
            ("materials.gold=3", "LIST.NAME.FIELD=VALUE"),
            ("meshes.a.b=3", "valid are: materials, lights, instances"),
            ("materials.silver.roughness=0", "valid are: wall.white, gold"),
            (
                "materials.wall.white.roughness=0",
                "unknown field 'roughness'; valid are: base_color, emission",
            ),
            ("materials.gold.roughness=2", "from 0 to 1"),
            ("materials.gold.roughness=nan", "from 0 to 1"),
            ("materials.gold.base_color=1,2", "three numbers from 0 to 1"),
            ("materials.gold.displacement=far", "give a number"),
            ("materials.gold.displacement_edge=0", "above 0"),
            ("materials.gold.displacement_levels=99", "from 0 to 12"),
            ("materials.gold.displacement_size=1", "valid are: displacement, displacement_edge"),
            ("lights.1.intensity=1", "valid are: 0"),
            ("lights.0.intensity=*red", "after the *"),
            ("instances.a.visible=true", "the list is empty or nameless"),
        ] {
            let message = apply(&mut scene, text).expect_err(text);
            assert!(message.contains(words), "{text}: {message}");
        }
    }
}
