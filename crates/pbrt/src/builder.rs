// SPDX-License-Identifier: GPL-3.0-or-later
//! The scene as it grows: shapes become objects; their looks become materials at the end, when all named ones are known.
//! Shapes that follow each other under one transform are one object, so that they share a tree; whole quadrics that are alike are
//! stored once. Tests: `tests/`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnurt_scene::io::reader::{Access, Meaning, Pictures};
use gnurt_scene::io::{Error, Oddity, Warnings};
use gnurt_scene::texture::{Filter, Texels, Wrap};
use gnurt_scene::{
    Affine, InstanceId, Light, Material as Made, MaterialId, MediumId, Member, Mesh, MeshId, Object,
    ObjectId, Scene, Texture as SceneTexture, TextureId,
};

use crate::infinite;
use crate::lights::{AreaLight, Infinite};
use crate::location::Location;
use crate::material::{Material, Model};
use crate::media::Media;
use crate::motion::Motion;
use crate::osl::Library;
use crate::surface::{self, Coverage};
use crate::texture::{Encoding, Image, Input, Texture};

/// Bytes that a shape costs beside its mesh.
const SHAPE_BYTES: usize = 1024;

/// A material by its number: it may be named before it is defined.
struct Slot {
    name: Option<String>,
    /// Where it was named first.
    location: Location,
    material: Option<Material>,
}

/// The material, light and opacity of a mesh.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    material: u32,
    medium: Option<MediumId>,
    emission: Option<([u32; 3], bool)>,
    picture: Option<PathBuf>,
    /// A number's bits, or a texture's place in memory.
    alpha: Option<(u32, usize)>,
}

/// A material that is made at the end.
struct Pending {
    id: MaterialId,
    number: u32,
    medium: Option<MediumId>,
    light: Option<(Arc<AreaLight>, [f32; 3])>,
    alpha: Option<Input>,
}

/// Meshes under one transform.
struct Group {
    transform: Affine,
    meshes: Vec<MeshId>,
    name: String,
}

pub(crate) struct Builder<'a> {
    pub(crate) access: &'a Access,
    pub(crate) scene: Scene,
    pub(crate) warnings: Warnings,
    pictures: Pictures<'a>,
    slots: Vec<Slot>,
    named: HashMap<String, u32>,
    keys: HashMap<Key, usize>,
    pending: Vec<Pending>,
    /// Textures of the scene by files, bytes' meaning, and how they are read.
    textures: HashMap<(PathBuf, bool, Wrap, bool), Option<TextureId>>,
    /// Quadrics by their signatures.
    shared: HashMap<(String, MaterialId), ObjectId>,
    group: Option<Group>,
    /// Members of the object that is being defined.
    pub(crate) members: Option<Vec<Member>>,
    /// Objects by name.
    pub(crate) objects: HashMap<String, ObjectId>,
    infinite: Vec<(Infinite, Affine)>,
    pub(crate) motion: Motion,
    pub(crate) media: Media,
    /// Members that move, of the object that is being defined.
    moving_members: Vec<(u32, [Affine; 2], Location)>,
    /// From the file's world to the renderer's.
    pub(crate) world_from_file: Affine,
}

/// A shape that is to be shown.
pub(crate) struct Shown {
    pub(crate) mesh: Mesh,
    pub(crate) class: String,
    /// The same text for equal shapes; `None` for a shape that is not shared.
    pub(crate) signature: Option<String>,
    /// From its space to the file's world, or that of the object, when the shutter opens and when it closes.
    pub(crate) transforms: [Affine; 2],
    pub(crate) material: u32,
    /// The medium within.
    pub(crate) medium: Option<MediumId>,
    pub(crate) area_light: Option<Arc<AreaLight>>,
    pub(crate) alpha: Option<Input>,
    pub(crate) location: Location,
}

/// The mean of a picture.
fn mean(texels: &Texels) -> [f32; 3] {
    let mut sum = [0.0_f64; 3];
    for (x, y) in (0..texels.height as usize).flat_map(|y| (0..texels.width as usize).map(move |x| (x, y))) {
        sum.iter_mut().zip(texels.texel(x, y)).for_each(|(sum, x)| *sum += f64::from(x));
    }
    sum.map(|sum| (sum / (f64::from(texels.width) * f64::from(texels.height))) as f32)
}

impl<'a> Builder<'a> {
    pub(crate) fn new(access: &'a Access) -> Self {
        Self {
            access,
            scene: Scene::new(),
            warnings: Warnings::default(),
            pictures: Pictures::new(access),
            slots: Vec::new(),
            named: HashMap::new(),
            keys: HashMap::new(),
            pending: Vec::new(),
            textures: HashMap::new(),
            shared: HashMap::new(),
            group: None,
            members: None,
            objects: HashMap::new(),
            infinite: Vec::new(),
            motion: Motion::default(),
            media: Media::default(),
            moving_members: Vec::new(),
            world_from_file: Affine::IDENTITY,
        }
    }

    /// Adds a material without a name.
    pub(crate) fn add_material(&mut self, material: Material) -> u32 {
        self.slots.push(Slot { name: None, location: material.location.clone(), material: Some(material) });
        self.slots.len() as u32 - 1
    }

    /// The number of a named material, defined or not.
    pub(crate) fn named_material(&mut self, name: &str, location: &Location) -> u32 {
        if let Some(&number) = self.named.get(name) {
            return number;
        }
        self.slots.push(Slot { name: Some(name.to_owned()), location: location.clone(), material: None });
        let number = self.slots.len() as u32 - 1;
        self.named.insert(name.to_owned(), number);
        number
    }

    /// Defines a named material; false if it was defined before.
    pub(crate) fn define_material(&mut self, name: &str, material: Material) -> bool {
        let number = self.named_material(name, &material.location);
        let slot = &mut self.slots[number as usize];
        let is_new = slot.material.is_none();
        slot.material.get_or_insert(material);
        is_new
    }

    /// Whether a material may read texture coordinates, which one that is defined later may.
    pub(crate) fn is_textured(&self, number: u32) -> bool {
        self.slots[number as usize].material.as_ref().is_none_or(Material::is_textured)
    }

    /// Whether a material is no surface at all; one that is defined later is one.
    pub(crate) fn is_interface(&self, number: u32) -> bool {
        matches!(&self.slots[number as usize].material, Some(Material { model: Model::Interface, .. }))
    }

    /// Shows a shape.
    pub(crate) fn show(&mut self, shown: Shown) -> Result<(), Error> {
        let Shown { mut mesh, class, signature, transforms, material, medium, area_light, alpha, location } =
            shown;
        if mesh.primitive_count() == 0 {
            return Ok(());
        }
        self.access.budget.hold(SHAPE_BYTES).map_err(|e| location.excess(e))?;
        let light = area_light.map(|light| {
            let world_from_shape = self.world_from_file * transforms[0];
            let radiance = self.radiance(&light, || mesh.area(&world_from_shape));
            (light, radiance)
        });
        let picks = |input: &Input| match input {
            Input::Constant(value) => (value[0].to_bits(), 0),
            Input::Texture(texture) => (0, Arc::as_ptr(texture) as usize),
        };
        let key = Key {
            material,
            medium,
            emission: light.as_ref().map(|(light, rgb)| (rgb.map(f32::to_bits), light.both_sides)),
            picture: light.as_ref().and_then(|(light, _)| light.picture.clone()),
            alpha: alpha.as_ref().map(picks),
        };
        let id = match self.keys.get(&key) {
            Some(&known) => self.pending[known].id,
            None => {
                let id = self.scene.add_material(Made::matte("", [0.5; 3]));
                self.keys.insert(key, self.pending.len());
                self.pending.push(Pending { id, number: material, medium, light, alpha });
                id
            }
        };
        mesh.material = id;
        mesh.name.clone_from(&class);
        let transform = transforms[0];
        if transforms[0] != transforms[1] {
            self.end_group();
            let mesh = self.scene.add_mesh(mesh);
            let object = self.scene.add_object_of(class, vec![mesh]);
            self.transform_moving(object, &transforms, None, &location);
            return Ok(());
        }
        let Some(signature) = signature else {
            let mesh = self.scene.add_mesh(mesh);
            match &mut self.group {
                Some(group) if group.transform == transform => group.meshes.push(mesh),
                _ => {
                    self.end_group();
                    let name = format!("{class} of line {}", location.line);
                    self.group = Some(Group { transform, meshes: vec![mesh], name });
                }
            }
            return Ok(());
        };
        let (scene, access) = (&mut self.scene, self.access);
        let bytes = mesh.memory_bytes();
        let mut is_known = true;
        let object = *self.shared.entry((signature, id)).or_insert_with(|| {
            is_known = false;
            let mesh = scene.add_mesh(mesh);
            scene.add_object_of(class, vec![mesh])
        });
        if is_known {
            access.budget.release(bytes);
        }
        self.location(object, transform, None);
        Ok(())
    }

    /// Ends the meshes that share a transform.
    pub(crate) fn end_group(&mut self) {
        if let Some(Group { transform, meshes, name }) = self.group.take() {
            let object = self.scene.add_object_of(name, meshes);
            self.location(object, transform, None);
        }
    }

    /// Puts an object somewhere in the file's world, or in the object that is being defined.
    pub(crate) fn location(&mut self, object: ObjectId, transform: Affine, name: Option<&str>) {
        match &mut self.members {
            Some(members) => members.push(Member::new(object, transform)),
            None => {
                let id = self.scene.instantiate(object, self.world_from_file * transform);
                if let Some(name) = name {
                    name.clone_into(&mut self.scene.edit_instance(id).name);
                }
            }
        }
    }

    /// The same where it moves.
    pub(crate) fn transform_moving(
        &mut self,
        object: ObjectId,
        transforms: &[Affine; 2],
        name: Option<&str>,
        location: &Location,
    ) {
        self.location(object, transforms[0], name);
        if transforms[0] == transforms[1] {
            return;
        }
        if let Some(members) = &self.members {
            self.moving_members.push((members.len() as u32 - 1, *transforms, location.clone()));
            return;
        }
        let instance = InstanceId(self.scene.instances().len() as u32 - 1);
        let moves = self.motion.instance(instance, self.world_from_file, transforms);
        self.tell_motion(moves, location);
    }

    /// Warns of a motion that is not shown.
    pub(crate) fn tell_motion(&mut self, moves: bool, location: &Location) {
        if !moves {
            let detail = "motion by a transform that shears: it is where it begins";
            location.warn(&mut self.warnings, Oddity::NotShown, detail);
        }
    }

    /// Ends the object that is being defined.
    pub(crate) fn end_object(&mut self, name: &str) -> ObjectId {
        self.end_group();
        let members = self.members.take().unwrap_or_default();
        let id = self.scene.add_object(Object { name: name.to_owned(), members, ..Object::default() });
        for (member, transforms, location) in std::mem::take(&mut self.moving_members) {
            let moves = self.motion.member(id, member, &transforms);
            self.tell_motion(moves, &location);
        }
        id
    }

    /// The radiance of an area light on a surface.
    fn radiance(&mut self, light: &AreaLight, area: impl FnOnce() -> f64) -> [f32; 3] {
        let Some(power) = light.power else { return light.radiance };
        let mut of_unit = area() as f32 * std::f32::consts::PI;
        if light.both_sides {
            of_unit *= 2.0;
        }
        if let Some(Ok(texels)) = light.picture.as_ref().map(|path| self.pictures.file(path, Meaning::Color))
        {
            let [r, g, b] = mean(&texels);
            of_unit *= 0.2126 * r + 0.7152 * g + 0.0722 * b;
        }
        let scale = if of_unit > 0.0 { power / of_unit } else { 0.0 };
        light.radiance.map(|c| c * scale)
    }

    /// Adds a light that has the mean of a picture.
    pub(crate) fn add_pictured(&mut self, mut light: Light, path: &Path, grey: bool, location: &Location) {
        match self.pictures.file(path, Meaning::Color) {
            Ok(texels) => {
                let mut color = mean(&texels);
                if grey {
                    color = [color.iter().sum::<f32>() / 3.0; 3];
                }
                if let Light::Point { intensity, .. } | Light::Spot { intensity, .. } = &mut light {
                    intensity.iter_mut().zip(color).for_each(|(i, c)| *i *= c);
                }
            }
            Err(why) => location.warn(&mut self.warnings, Oddity::BadTexture, why),
        }
        self.scene.add_light(light);
    }

    /// Adds a light from all directions; `world_from_light` goes to the renderer's world.
    pub(crate) fn add_infinite(&mut self, light: Infinite, world_from_light: Affine) {
        self.infinite.push((light, world_from_light));
    }

    /// Makes all that had to wait.
    pub(crate) fn finish(&mut self, path: &Path) -> Result<(), Error> {
        self.end_group();
        for slot in &self.slots {
            if let (None, Some(name)) = (&slot.material, &slot.name) {
                let problem = format!("no material {} is defined", gnurt_scene::io::reader::quoted(name));
                return Err(slot
                    .location
                    .error(problem, "define it: MakeNamedMaterial \"NAME\" \"string type\" ..."));
            }
        }
        for pending in std::mem::take(&mut self.pending) {
            self.make(pending);
        }
        for (light, world_from_light) in std::mem::take(&mut self.infinite) {
            self.make_infinite(&light, &world_from_light)?;
        }
        if let Some(animation) = std::mem::take(&mut self.motion).finish() {
            self.scene.animate(animation).map_err(|e| Error::data(path, None, e.to_string(), ""))?;
        }
        Ok(())
    }

    fn make(&mut self, pending: Pending) {
        let Pending { id, number, medium, light, alpha } = pending;
        let slot = &self.slots[number as usize];
        let name = slot.name.clone().unwrap_or_else(|| format!("material of line {}", slot.location.line));
        let inside = slot.material.as_ref().and_then(|material| material.inside.as_deref());
        let medium = inside.map(|inside| self.scene.add_medium(inside.clone())).or(medium);
        if let Some(medium) = medium.filter(|_| self.is_interface(number) && light.is_none()) {
            *self.scene.edit_material(id) = Made::boundary(name, medium);
            return;
        }
        let mut coverage = Coverage { alpha, ..Coverage::default() };
        if let Some((light, radiance)) = light {
            coverage.emission = Some((radiance, light.both_sides));
            if let Some(path) = &light.picture {
                coverage.emission_picture =
                    self.file(path, Meaning::Color, Wrap::ClampToEdge, false, &light.location);
                if coverage.emission_picture.is_none() {
                    coverage.emission = None;
                }
            }
        }
        let (mut made, shader) = surface::make(number, &name, &coverage, self);
        made.name = name;
        made.medium = medium;
        *self.scene.edit_material(id) = made;
        if let Some(mut file) = shader {
            file.confined_to = self.access.confined_to();
            self.scene.set_shader_file(id, file);
        }
    }

    fn make_infinite(&mut self, light: &Infinite, world_from_light: &Affine) -> Result<(), Error> {
        let Some(path) = &light.picture else {
            let environment = Light::Environment {
                radiance: light.radiance,
                texture: None,
                world_from_light: Affine::IDENTITY,
            };
            self.add_environment(environment, &light.location);
            return Ok(());
        };
        let texels = match self.pictures.file(path, Meaning::Color) {
            Ok(texels) => texels,
            Err(why) => {
                light.location.warn(&mut self.warnings, Oddity::BadTexture, why);
                return Ok(());
            }
        };
        if texels.width != texels.height {
            let problem =
                format!("the picture of an infinite light has {} x {} pixels", texels.width, texels.height);
            let remedy =
                "it must be square: imgtool makeequiarea of pbrt makes one of a latitude-longitude picture";
            return Err(light.location.error(problem, remedy));
        }
        let light_from_world = world_from_light
            .inverse()
            .ok_or_else(|| light.location.error("the transform of an infinite light flattens space", ""))?;
        let [columns, rows] = infinite::size(texels.width);
        let bytes = columns as usize * rows as usize * 16;
        self.access.budget.hold(bytes).map_err(|e| light.location.excess(e))?;
        let mut radiance = light.radiance;
        if let Some(illuminance) = light.illuminance {
            let upward = infinite::upward(&texels);
            let scale = if upward > 0.0 { illuminance / upward } else { 1.0 };
            radiance = radiance.map(|c| c * scale);
        }
        let made = infinite::picture(&texels, &light_from_world);
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let texture = self.scene.add_texture(SceneTexture {
            name,
            texels: Arc::new(made),
            wrap: [Wrap::Repeat, Wrap::ClampToEdge],
            filter: Filter::Linear,
        });
        let environment =
            Light::Environment { radiance, texture: Some(texture), world_from_light: Affine::IDENTITY };
        self.add_environment(environment, &light.location);
        Ok(())
    }

    fn add_environment(&mut self, light: Light, location: &Location) {
        if self.scene.lights().iter().any(|known| matches!(known, Light::Environment { .. })) {
            location.warn(
                &mut self.warnings,
                Oddity::NotShown,
                "an infinite light before: the last one counts",
            );
        }
        self.scene.add_light(light);
    }

    /// The texture of the scene for a picture's file.
    fn file(
        &mut self,
        path: &Path,
        meaning: Meaning,
        wrap: Wrap,
        nearest: bool,
        location: &Location,
    ) -> Option<TextureId> {
        let key = (path.to_owned(), meaning == Meaning::Color, wrap, nearest);
        if let Some(known) = self.textures.get(&key) {
            return *known;
        }
        let found = match self.pictures.file(path, meaning) {
            Ok(texels) => {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let filter = if nearest { Filter::Nearest } else { Filter::Linear };
                Some(self.scene.add_texture(SceneTexture { name, texels, wrap: [wrap; 2], filter }))
            }
            Err(why) => {
                location.warn(&mut self.warnings, Oddity::BadTexture, why);
                None
            }
        };
        self.textures.insert(key, found);
        found
    }

    /// Pictures that were asked for.
    pub(crate) fn picture_files(&self) -> Vec<PathBuf> {
        self.pictures.paths()
    }
}

impl Library for Builder<'_> {
    fn picture(&mut self, image: &Image, texture: &Texture) -> Option<TextureId> {
        let meaning = if image.encoding == Encoding::Srgb { Meaning::Color } else { Meaning::Data };
        self.file(&image.path, meaning, image.wrap.unwrap_or_default(), image.nearest, &texture.location)
    }

    fn has_opacity(&self, id: TextureId) -> bool {
        let texels = &self.scene.texture(id).texels;
        let (columns, rows) = (texels.width as usize, texels.height as usize);
        (0..rows).any(|y| (0..columns).any(|x| texels.texel(x, y)[3] < 1.0))
    }

    fn normals(&mut self, path: &Path, material: &Material) -> Option<TextureId> {
        self.file(path, Meaning::Data, Wrap::Repeat, false, &material.location)
    }

    fn material(&self, number: u32) -> Option<Material> {
        self.slots.get(number as usize)?.material.clone()
    }
}
