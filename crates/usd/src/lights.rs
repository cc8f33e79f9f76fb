// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights of UsdLux: areas as surfaces that shine, distant ones as directions, domes as environments.
//! Source: UsdLux (the luminance of the light, and its divisor where its power is normalized).
//! Units: intensity is radiance; lengths within formulas are those of the stage. Tests: `tests/lights.rs`.

use std::f64::consts::PI;

use gnurt_scene::io::reader::Meaning;
use gnurt_scene::labels::{Luminaire, Shining};
use gnurt_scene::light_links::LinkKind;
use gnurt_scene::material::{Color, Material, Surface, TextureRef};
use gnurt_scene::texture::{Filter, Texture, Wrap};
use gnurt_scene::{Affine, ConeEdge, InstanceId, Light, LightId, Mesh, MeshId, TextureId};
use openusd::sdf::{Path, Value};

use crate::builder::{Builder, Placed, State};
use crate::reader::Reader;
use crate::shapes;
use crate::value;

/// Sides of luminaires: each triangle is a light of its own.
const BALL: [u32; 2] = [24, 12];
/// Attributes that put a light into a group.
const GROUPS: [&str; 4] =
    ["lightGroup", "ri:light:lightGroup", "inputs:ri:light:lightGroup", "userProperties:lightGroup"];

/// A collection of prims. Source: UsdCollectionAPI: the nearest path above a prim that is listed decides.
struct Collection {
    includes: Vec<Path>,
    excludes: Vec<Path>,
    /// Whether prims are members that no listed path is above.
    has_root: bool,
    /// Whether only the listed prims themselves are members.
    is_explicit: bool,
}

impl Collection {
    /// `None` if it holds everything, as a light's do where nothing is authored.
    fn of(reader: &Reader, prim: &Path, name: &str) -> Option<Self> {
        let list = |what: &str| reader.targets(prim, &format!("collection:{name}:{what}"));
        let rule = reader.word(prim, &format!("collection:{name}:expansionRule"));
        let made = Self {
            includes: list("includes"),
            excludes: list("excludes"),
            has_root: reader.flag(prim, &format!("collection:{name}:includeRoot")).unwrap_or(true),
            is_explicit: rule.as_deref() == Some("explicitOnly"),
        };
        (!made.has_root || !made.excludes.is_empty()).then_some(made)
    }

    fn holds(&self, prim: &str) -> bool {
        let is_above = |path: &&Path| {
            let path = path.as_str();
            prim == path
                || (!self.is_explicit && prim.strip_prefix(path).is_some_and(|rest| rest.starts_with('/')))
        };
        let nearest = |list: &[Path]| list.iter().filter(is_above).map(|path| path.as_str().len()).max();
        match (nearest(&self.includes), nearest(&self.excludes)) {
            (None, None) => self.has_root && !self.is_explicit,
            (included, excluded) => included > excluded,
        }
    }
}

impl Reader {
    fn light_number(&self, prim: &Path, name: &str, fallback: f64) -> f64 {
        self.number_or(prim, &format!("inputs:{name}"), fallback)
    }

    /// Radiance before it is divided by an area.
    fn radiance(&self, prim: &Path, intensity: f64) -> [f64; 3] {
        let color =
            self.value(prim, "inputs:color").as_ref().and_then(value::vector::<3>).unwrap_or([1.0; 3]);
        let strength =
            self.light_number(prim, "intensity", intensity) * self.light_number(prim, "exposure", 0.0).exp2();
        let tint = match self.flag(prim, "inputs:enableColorTemperature") {
            Some(true) => blackbody(self.light_number(prim, "colorTemperature", 6500.0)),
            _ => [1.0; 3],
        };
        std::array::from_fn(|c| (color[c] * tint[c] * strength).max(0.0))
    }
}

/// The colour of a black body in linear Rec.709, of luminance 1.
///
/// Source: chromaticities by Kang et al. 2002, valid from 1667 to 25000 K; outside of these the nearest.
fn blackbody(kelvin: f64) -> [f64; 3] {
    let t = 1000.0 / kelvin.clamp(1667.0, 25000.0);
    let cubic = |[a, b, c, d]: [f64; 4], x: f64| ((a * x + b) * x + c) * x + d;
    let x = match kelvin < 4000.0 {
        true => cubic([-0.266_123_9, -0.234_358_9, 0.877_695_6, 0.179_910], t),
        false => cubic([-3.025_846_9, 2.107_037_9, 0.222_634_7, 0.240_390], t),
    };
    let y = match kelvin {
        k if k < 2222.0 => cubic([-1.106_381_4, -1.348_110_2, 2.185_558_32, -0.202_196_83], x),
        k if k < 4000.0 => cubic([-0.954_947_6, -1.374_185_93, 2.091_370_15, -0.167_488_67], x),
        _ => cubic([3.081_758, -5.873_386_7, 3.751_129_97, -0.370_014_83], x),
    };
    let [big_x, big_z] = [x / y, (1.0 - x - y) / y];
    let rgb = [
        3.240_454_2 * big_x - 1.537_138_5 - 0.498_531_4 * big_z,
        -0.969_266 * big_x + 1.876_010_8 + 0.041_556 * big_z,
        0.055_643_4 * big_x - 0.204_025_9 + 1.057_225_2 * big_z,
    ];
    rgb.map(|c: f64| c.max(0.0))
}

impl Builder<'_> {
    /// Puts the light of a prim into its group, if it has one.
    fn put_into_group(&mut self, prim: &Path, shining: Shining) {
        self.lights.push((shining, prim.clone()));
        let group = GROUPS.iter().find_map(|name| self.reader.word(prim, name));
        group.iter().for_each(|group| self.scene.labels_mut().set_light_group(shining, group));
    }

    /// Links lights to the instances in their collections, once all instances are there.
    pub(crate) fn link_lights(&mut self) {
        for (shining, prim) in std::mem::take(&mut self.lights) {
            for (name, kind) in [("lightLink", LinkKind::Lit), ("shadowLink", LinkKind::Shadows)] {
                let Some(collection) = Collection::of(self.reader, &prim, name) else { continue };
                let ids = (0..).map(InstanceId).zip(self.scene.instances());
                let members = ids.filter(|(_, instance)| collection.holds(&instance.name)).map(|(id, _)| id);
                let members = members.collect();
                self.scene.link_light(shining, kind, Some(members));
            }
        }
    }

    /// Names a light without a surface.
    fn name(&mut self, prim: &Path, light: LightId) {
        self.scene.labels_mut().lights.insert(light, prim.as_str().to_owned());
        self.put_into_group(prim, Shining::Light(light));
    }

    /// Adds a light: to the scene, or to `placed` where it has a surface.
    pub(crate) fn light(&mut self, prim: &Path, kind: &str, state: &State, placed: &mut Vec<Placed>) {
        let reader = self.reader;
        let transform = state.world_from_parent;
        self.note_what_lights_lack(prim);
        match kind {
            "DistantLight" => self.distant(prim, &transform),
            "DomeLight" | "DomeLight_1" => self.dome(prim, &transform),
            "RectLight" => {
                let size = ["width", "height"].map(|name| reader.light_number(prim, name, 1.0).abs());
                let mesh = shapes::rectangle(size, true, 'Z');
                self.luminaire(prim, Luminaire::Rect, mesh, &transform, placed);
            }
            "DiskLight" => {
                let mesh = shapes::disk(reader.light_number(prim, "radius", 0.5).abs());
                self.luminaire(prim, Luminaire::Disk, mesh, &transform, placed);
            }
            "SphereLight" if reader.flag(prim, "treatAsPoint") == Some(true) || self.is_shaped(prim) => {
                self.point(prim, &transform);
            }
            "SphereLight" => {
                let radius = reader.light_number(prim, "radius", 0.5).abs();
                // A picture on it needs coordinates, which spheres have not.
                let is_plain =
                    transform.is_similarity() && reader.value(prim, "inputs:texture:file").is_none();
                let mesh = if is_plain { shapes::exact_ball(radius) } else { shapes::ball(radius, BALL) };
                self.luminaire(prim, Luminaire::Sphere, mesh, &transform, placed);
            }
            "CylinderLight" if reader.flag(prim, "treatAsLine") == Some(true) => {
                reader.unsupported(prim, "treatAsLine, shown with its radius");
                self.cylinder_light(prim, &transform, placed);
            }
            "CylinderLight" => self.cylinder_light(prim, &transform, placed),
            "Mesh" => {
                let Some(object) = self.mesh(prim, None) else { return };
                for id in self.scene.object(object).meshes.clone() {
                    self.let_shine(prim, id, &transform, Luminaire::Mesh);
                }
                let path = prim.as_str().to_owned();
                placed.push(Placed { object, transform, path, luminaire: Some(Luminaire::Mesh) });
            }
            other => reader.unsupported(prim, other),
        }
    }

    fn note_what_lights_lack(&self, prim: &Path) {
        let reader = self.reader;
        let is_set = |name: &str, fallback: f64| {
            reader.number(prim, &format!("inputs:{name}")).is_some_and(|x| (x - fallback).abs() > 1e-9)
        };
        for name in ["diffuse", "specular"] {
            if is_set(name, 1.0) {
                reader.unsupported(prim, format_args!("inputs:{name}"));
            }
        }
        if reader.flag(prim, "inputs:shadow:enable") == Some(false) {
            reader.unsupported(prim, "a light without shadows");
        }
        if matches!(reader.value(prim, "inputs:shaping:ies:file"), Some(Value::AssetPath(file)) if !file.is_empty())
        {
            reader.unsupported(prim, "inputs:shaping:ies:file");
        }
        if !reader.targets(prim, "light:filters").is_empty() {
            reader.unsupported(prim, "light:filters");
        }
    }

    /// Whether a cone or a focus makes a spot of it.
    fn is_shaped(&self, prim: &Path) -> bool {
        self.reader.light_number(prim, "shaping:cone:angle", 90.0) < 90.0
            || self.reader.light_number(prim, "shaping:focus", 0.0) > 0.0
    }

    /// Light from far away.
    fn distant(&mut self, prim: &Path, transform: &Affine) {
        let reader = self.reader;
        let angle = reader.light_number(prim, "angle", 0.53);
        let radiance = reader.radiance(prim, 50000.0);
        // The projected solid angle of its disk; a normalized light's radiance is divided by that.
        let is_normalized = reader.flag(prim, "inputs:normalize") == Some(true) || angle <= 0.0;
        let spread = PI * (angle.min(180.0).to_radians() / 2.0).sin().powi(2);
        let share = if is_normalized { 1.0 } else { spread };
        let direction = transform.vector([0.0, 0.0, -1.0]).map(|x| x as f32);
        let irradiance = radiance.map(|x| (x * share) as f32);
        let light = self.scene.add_light(Light::Directional {
            direction,
            irradiance,
            angle: angle.clamp(0.0, 180.0).to_radians() as f32,
        });
        self.name(prim, light);
    }

    /// A light from one point or the disc around it, in a cone where it is shaped.
    fn point(&mut self, prim: &Path, transform: &Affine) {
        let reader = self.reader;
        let radius = reader.light_number(prim, "radius", 0.5).abs();
        let radiance = reader.radiance(prim, 1.0);
        // The disk that a ball shows to each side, in the squared lengths of its own space.
        let area = match reader.flag(prim, "inputs:normalize") {
            Some(true) => 0.25,
            _ => PI * radius * radius,
        };
        let unit = transform.determinant().abs().cbrt();
        let intensity = radiance.map(|x| (x * area * unit * unit) as f32);
        let is_point = reader.flag(prim, "treatAsPoint") == Some(true);
        let radius = if is_point { 0.0 } else { (radius * unit) as f32 };
        let position = transform.point([0.0; 3]).map(|x| x as f32);
        let light = if self.is_shaped(prim) {
            let outer = reader.light_number(prim, "shaping:cone:angle", 90.0).clamp(0.1, 90.0).to_radians();
            let softness = reader.light_number(prim, "shaping:cone:softness", 0.0).clamp(0.0, 1.0);
            if reader.light_number(prim, "shaping:focus", 0.0) > 0.0 {
                reader.unsupported(prim, "inputs:shaping:focus");
            }
            Light::Spot {
                position,
                direction: transform.vector([0.0, 0.0, -1.0]).map(|x| x as f32),
                intensity,
                inner_angle: (outer * (1.0 - softness) * 0.999) as f32,
                outer_angle: outer as f32,
                edge: ConeEdge::default(),
                radius,
            }
        } else {
            Light::Point { position, intensity, radius }
        };
        let light = self.scene.add_light(light);
        self.name(prim, light);
    }

    fn dome(&mut self, prim: &Path, transform: &Affine) {
        let reader = self.reader;
        let radiance = reader.radiance(prim, 1.0).map(|x| x as f32);
        let format = reader.word(prim, "inputs:texture:format");
        if let Some(format) = format.filter(|format| !matches!(&format[..], "automatic" | "latlong")) {
            reader.unsupported(prim, format_args!("a dome of the format '{format}', shown as 'latlong'"));
        }
        let texture = self.light_texture(prim, [Wrap::Repeat, Wrap::ClampToEdge]);
        // The middle of a picture lies along +z of a dome, and along -z of our environments.
        let unit = transform.determinant().abs().cbrt();
        let rotation =
            Affine { columns: [transform.columns[0], transform.columns[1], transform.columns[2], [0.0; 3]] };
        let mut rotated = rotation * Affine::scale([1.0 / unit; 3]);
        if self.reader.word(prim, "poleAxis").as_deref() == Some("Z") {
            rotated =
                rotated * Affine { columns: [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0; 3]] };
        }
        let world_from_light = rotated * Affine::rotation([0.0, 1.0, 0.0], PI);
        if self.scene.lights().iter().any(|light| matches!(light, Light::Environment { .. })) {
            reader.unsupported(prim, "a second dome, it takes the place of the first");
        }
        let light = self.scene.add_light(Light::Environment { radiance, texture, world_from_light });
        self.name(prim, light);
    }

    fn light_texture(&mut self, prim: &Path, wrap: [Wrap; 2]) -> Option<TextureId> {
        let Some(Value::AssetPath(asset)) = self.reader.value(prim, "inputs:texture:file") else {
            return None;
        };
        if asset.is_empty() {
            return None;
        }
        match self.reader.picture(&mut self.materials.pictures, &asset, Meaning::Color) {
            Ok(texels) => Some(self.scene.add_texture(Texture {
                name: asset.as_str().to_owned(),
                texels,
                wrap,
                filter: Filter::Linear,
            })),
            Err(fault) => {
                self.reader.note(gnurt_scene::io::Oddity::BadTexture, prim, fault);
                None
            }
        }
    }

    fn cylinder_light(&mut self, prim: &Path, transform: &Affine, placed: &mut Vec<Placed>) {
        let radius = self.reader.light_number(prim, "radius", 0.5).abs();
        let length = self.reader.light_number(prim, "length", 1.0).abs();
        let mesh = shapes::tube(radius, length, BALL[0]);
        self.luminaire(prim, Luminaire::Cylinder, mesh, transform, placed);
    }

    /// A surface that shines.
    fn luminaire(
        &mut self,
        prim: &Path,
        luminaire: Luminaire,
        mut mesh: Mesh,
        transform: &Affine,
        placed: &mut Vec<Placed>,
    ) {
        if transform.inverse().is_none() || mesh.primitive_count() == 0 {
            return;
        }
        mesh.material = self
            .scene
            .add_material(Material::of("", Surface::Matte { base_color: Color::constant([0.0; 3]) }));
        let id = self.scene.add_mesh(mesh);
        self.let_shine(prim, id, transform, luminaire);
        let object = self.scene.add_object_of(prim.as_str(), vec![id]);
        let path = prim.as_str().to_owned();
        placed.push(Placed { object, transform: *transform, path, luminaire: Some(luminaire) });
    }

    /// Gives a mesh a material of its own that shines as the light says.
    fn let_shine(&mut self, prim: &Path, id: MeshId, transform: &Affine, luminaire: Luminaire) {
        let reader = self.reader;
        let mut radiance = reader.radiance(prim, 1.0);
        if reader.flag(prim, "inputs:normalize") == Some(true) {
            // Areas in the units of the stage.
            let unit = self.root.determinant().abs().cbrt();
            let area = self.scene.mesh(id).area(transform) / (unit * unit);
            radiance = radiance.map(|x| x / area.max(f64::MIN_POSITIVE));
        }
        if self.is_shaped(prim) {
            reader.unsupported(prim, "the shaping of a light with a surface");
        }
        let texture = self.light_texture(prim, [Wrap::ClampToEdge; 2]);
        let mut material = self.scene.material(self.scene.mesh(id).material).clone();
        if luminaire != Luminaire::Mesh {
            prim.name().unwrap_or_default().clone_into(&mut material.name);
        }
        material.emission = radiance.map(|x| x as f32);
        material.emission_texture = texture.map(TextureRef::new);
        let material = self.scene.add_material(material);
        self.put_into_group(prim, Shining::Material(material));
        let mesh = self.scene.edit_mesh(id);
        mesh.material = material;
        // Flat, as light leaves it.
        mesh.normals.clear();
    }
}
