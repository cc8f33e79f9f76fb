// SPDX-License-Identifier: GPL-3.0-or-later
//! Statements, one after the other, and their effects.
//! Source: the file-format page of pbrt-v4. Invariants: every error names file and line; saved states are counted against the
//! budget; blocks of an imported file end in it, all others by the end of the scene. Tests: `tests/broken.rs`.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use gnurt_scene::io::reader::{Access, quoted, resolve};
use gnurt_scene::io::{Error, ErrorKind, Loaded, Oddity};
use gnurt_scene::{Affine, Projection};

use crate::builder::{Builder, Shown};
use crate::color_space::ColorSpace;
use crate::film::Film;
use crate::lights::{self, Found};
use crate::location::Location;
use crate::material::{self, Material, Model};
use crate::medium;
use crate::parameter::{Kind, Parameters};
use crate::shapes;
use crate::sources::Sources;
use crate::state::{Block, Saved, State, TARGETS};
use crate::texture::Input;
use crate::texture_parameters::{self, Textures};
use crate::tokens::Token;
use crate::transform::{look_at, matrix};
use crate::view::{self, View};

/// Bytes that something with a name costs.
const NAMED_BYTES: usize = 1024;

/// Reads a scene.
pub(crate) fn read(path: &Path, access: &Access) -> Result<Loaded, Error> {
    let mut reader = Reader::new(access, path);
    reader.sources.open_first(path)?;
    reader.all()?;
    reader.finish(path)
}

struct Reader<'a> {
    sources: Sources<'a>,
    builder: Builder<'a>,
    state: State,
    saved: Vec<Saved>,
    textures: Textures,
    spaces: HashMap<String, [Affine; 2]>,
    film: Film,
    camera: Option<(String, Parameters, [Affine; 2])>,
    /// The name of the object that is being defined, and the lights that it cannot have.
    object: Option<String>,
    in_world: bool,
    exposure: f32,
    requested: Requested,
}

/// The file's values for choices of the caller.
#[derive(Default)]
struct Requested {
    film: bool,
    samples: Option<i32>,
    depth: Option<i32>,
    /// Of the first statement.
    location: Option<Location>,
}

impl Requested {
    /// As options of the program.
    fn options(&self, film: &Film) -> String {
        let mut options = Vec::new();
        if self.film {
            let [width, height] = film.size;
            options.push(format!("--resolution {width}x{height}"));
            if let Some([left, right, upper, lower]) = film.crop {
                let at = |part: f32, side: u32| (part.clamp(0.0, 1.0) * side as f32).ceil();
                let [x0, x1] = [left, right].map(|part| at(part, width));
                let [y0, y1] = [upper, lower].map(|part| at(part, height));
                options.push(format!("--crop {x0},{y0},{x1},{y1}"));
            }
        }
        options.extend(self.samples.map(|samples| format!("--spp {samples}")));
        options.extend(self.depth.map(|depth| format!("--max-depth {}", depth.saturating_add(1))));
        options.join(" ")
    }
}

impl<'a> Reader<'a> {
    fn new(access: &'a Access, path: &Path) -> Self {
        let mut builder = Builder::new(access);
        let location = Location { path: path.into(), line: 1 };
        let diffuse = Model::Diffuse(Input::number(0.5));
        let material = builder.add_material(Material {
            model: diffuse,
            inside: None,
            normal_map: None,
            bump: None,
            location,
        });
        Self {
            sources: Sources::new(access),
            builder,
            state: State::new(material),
            saved: Vec::new(),
            textures: Textures::default(),
            spaces: HashMap::new(),
            film: Film::default(),
            camera: None,
            object: None,
            in_world: false,
            exposure: 1.0,
            requested: Requested::default(),
        }
    }

    fn access(&self) -> &'a Access {
        self.builder.access
    }

    /// Reads all statements of all files.
    fn all(&mut self) -> Result<(), Error> {
        while let Some(source) = self.sources.stack.last_mut() {
            let location = match source.peek() {
                Some(_) => source.location(),
                None => {
                    self.close()?;
                    continue;
                }
            };
            match source.next()? {
                Some(Token::Word(range)) => {
                    let word = source.word(&range).to_owned();
                    self.statement(&word, location)?;
                }
                Some(Token::Text(text)) => {
                    let problem = format!("text \"{}\" where a statement should begin", quoted(&text));
                    return Err(location.error(problem, "each statement begins with its name"));
                }
                Some(_) => {
                    return Err(location.error(
                        "a bracket where a statement should begin",
                        "brackets are around values only",
                    ));
                }
                None => {}
            }
        }
        Ok(())
    }

    /// Ends the innermost file.
    fn close(&mut self) -> Result<(), Error> {
        let Some(source) = self.sources.close() else { return Ok(()) };
        if let Some(depth) = source.import {
            if let Some(open) = self.saved.get(depth..).and_then(<[Saved]>::last)
                && open.block != Block::Import
            {
                return Err(unended(open));
            }
            self.restore(Block::Import, &source.location())?;
        }
        Ok(())
    }

    fn source(&mut self) -> &mut crate::sources::Source {
        self.sources.stack.last_mut().expect("a statement is in a file")
    }

    /// A text that must follow.
    fn text(&mut self, of: &str, location: &Location) -> Result<String, Error> {
        let source = self.source();
        if source.peek() == Some(b'"')
            && let Some(Token::Text(text)) = source.next()?
        {
            return Ok(text);
        }
        Err(location.error(format!("{of} has no name"), format!("expected {of} \"NAME\"")))
    }

    /// Numbers that must follow, between brackets or not.
    fn numbers<const N: usize>(&mut self, of: &str, location: &Location) -> Result<[f64; N], Error> {
        let source = self.source();
        let brackets = source.peek() == Some(b'[');
        let wrong = |found: &str| {
            let found = if found.is_empty() { "its end".to_owned() } else { quoted(found) };
            location.error(format!("{of} takes {N} numbers, found {found}"), format!("give {N} numbers"))
        };
        if brackets {
            source.next()?;
        }
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            match source.next()? {
                Some(Token::Word(range)) => {
                    let word = source.word(&range);
                    let parsed = word.parse().ok().filter(|x: &f64| x.is_finite());
                    *number = parsed.ok_or_else(|| wrong(word))?;
                }
                Some(Token::Text(text)) => return Err(wrong(&text)),
                Some(Token::Open) => return Err(wrong("[")),
                Some(Token::Close) => return Err(wrong("]")),
                None => return Err(wrong("")),
            }
        }
        if brackets && source.next()? != Some(Token::Close) {
            return Err(wrong("more"));
        }
        Ok(numbers)
    }

    /// Parameters that follow, with those of `Attribute` statements for this target.
    fn parameters(&mut self, location: &Location, target: Option<usize>) -> Result<Parameters, Error> {
        let (space, access) = (self.state.space, self.access());
        let mut parameters = Parameters::read(self.source(), location.clone(), space, &access.budget)?;
        if let Some(target) = target {
            parameters.extend(&self.state.attributes[target]);
        }
        Ok(parameters)
    }

    /// A text, and the parameters that follow it.
    fn named(
        &mut self,
        of: &str,
        location: &Location,
        target: Option<usize>,
    ) -> Result<(String, Parameters), Error> {
        let name = self.text(of, location)?;
        Ok((name, self.parameters(location, target)?))
    }

    fn save(&mut self, block: Block, location: &Location) -> Result<(), Error> {
        self.access().budget.hold(size_of::<Saved>()).map_err(|e| location.excess(e))?;
        self.saved.push(Saved { block, location: location.clone(), state: self.state.clone() });
        Ok(())
    }

    fn restore(&mut self, block: Block, location: &Location) -> Result<(), Error> {
        let [begin, end] = block.names();
        // An imported file cannot end a block that it has not begun.
        match self.saved.pop() {
            Some(saved) if saved.block == block => {
                self.access().budget.release(size_of::<Saved>());
                if block == Block::Transform {
                    self.state.transforms = saved.state.transforms;
                } else {
                    self.state = saved.state;
                }
                Ok(())
            }
            Some(saved) => {
                let [_, other] = saved.block.names();
                let problem =
                    format!("{end} after the {} of line {}", saved.block.names()[0], saved.location.line);
                Err(location.error(problem, format!("expected {other} first")))
            }
            None => Err(location
                .error(format!("{end} without {begin}"), format!("leave it out, or begin with {begin}"))),
        }
    }

    fn world_only(&self, word: &str, location: &Location) -> Result<(), Error> {
        if self.in_world {
            return Ok(());
        }
        Err(location.error(format!("{word} before WorldBegin"), "move it behind WorldBegin"))
    }

    fn options_only(&self, word: &str, location: &Location) -> Result<(), Error> {
        if !self.in_world {
            return Ok(());
        }
        Err(location.error(format!("{word} after WorldBegin"), "move it before WorldBegin"))
    }

    fn warn(&mut self, location: &Location, oddity: Oddity, detail: impl Into<String>) {
        location.warn(&mut self.builder.warnings, oddity, detail);
    }

    fn statement(&mut self, word: &str, location: Location) -> Result<(), Error> {
        match word {
            "Shape" | "LightSource" | "AreaLightSource" | "ObjectBegin" | "ObjectInstance" | "Material"
            | "MakeNamedMaterial" | "NamedMaterial" | "Texture" | "AttributeBegin" | "AttributeEnd"
            | "ReverseOrientation" => self.world_only(word, &location)?,
            "Camera" | "Film" | "Sampler" | "Integrator" | "PixelFilter" | "Accelerator" | "WorldBegin" => {
                self.options_only(word, &location)?;
            }
            _ => {}
        }
        match word {
            "Identity" => self.state.each(|transform| *transform = Affine::IDENTITY),
            "Translate" => {
                let by = Affine::translation(self.numbers(word, &location)?);
                self.state.concatenate(&by);
            }
            "Scale" => {
                let by = self.numbers::<3>(word, &location)?;
                if by.contains(&0.0) {
                    return Err(location.error("Scale by 0 flattens space", "give numbers other than 0"));
                }
                self.state.concatenate(&Affine::scale(by));
            }
            "Rotate" => {
                let [angle, x, y, z] = self.numbers(word, &location)?;
                self.state.concatenate(&Affine::rotation([x, y, z], angle.to_radians()));
            }
            "LookAt" => {
                let [ex, ey, ez, x, y, z, ux, uy, uz] = self.numbers(word, &location)?;
                let view = look_at([ex, ey, ez], [x, y, z], [ux, uy, uz]).ok_or_else(|| {
                    location.error(
                        "LookAt has no view",
                        "eye and target must differ, and up must not lie along the view",
                    )
                })?;
                self.state.concatenate(&view);
            }
            "Transform" | "ConcatTransform" => {
                let numbers = self.numbers(word, &location)?;
                let by = matrix(numbers).ok_or_else(|| {
                    location.error(
                        format!("{word} is no affine matrix"),
                        "numbers 4, 8 and 12 must be 0: give columns one after the other",
                    )
                })?;
                if word == "Transform" {
                    self.state.each(|transform| *transform = by);
                } else {
                    self.state.concatenate(&by);
                }
            }
            "CoordinateSystem" => {
                let name = self.text(word, &location)?;
                self.hold_name(&location)?;
                self.spaces.insert(name, self.state.transforms);
            }
            "CoordSysTransform" => {
                let name = self.text(word, &location)?;
                match self.spaces.get(&name) {
                    Some(known) => self.state.transforms = *known,
                    None => {
                        let problem = format!("no coordinate system {} is known", quoted(&name));
                        return Err(location.error(problem, "name it first: CoordinateSystem \"NAME\""));
                    }
                }
            }
            "ReverseOrientation" => self.state.reversed = !self.state.reversed,
            "ActiveTransform" => {
                let which = match self.source().next()? {
                    Some(Token::Word(range)) => self.source().word(&range).to_owned(),
                    _ => String::new(),
                };
                self.state.active = match &which[..] {
                    "StartTime" => [true, false],
                    "EndTime" => [false, true],
                    "All" => [true, true],
                    other => {
                        let problem = format!("unknown ActiveTransform {}", quoted(other));
                        return Err(location.error(problem, "valid are All, EndTime and StartTime"));
                    }
                };
            }
            "TransformTimes" => {
                let [from, to] = self.numbers(word, &location)?;
                if [from, to] != [0.0, 1.0] {
                    self.warn(&location, Oddity::NotShown, "TransformTimes other than 0 and 1");
                }
            }
            "AttributeBegin" => self.save(Block::Attribute, &location)?,
            "AttributeEnd" => self.restore(Block::Attribute, &location)?,
            "TransformBegin" => self.save(Block::Transform, &location)?,
            "TransformEnd" => self.restore(Block::Transform, &location)?,
            "Attribute" => self.attribute(&location)?,
            "ColorSpace" => {
                let name = self.text(word, &location)?;
                self.state.space = ColorSpace::named(&name).ok_or_else(|| {
                    let known: Vec<&str> = ColorSpace::NAMES.iter().map(|(known, _)| *known).collect();
                    location.error(
                        format!("unknown ColorSpace {}", quoted(&name)),
                        format!("valid are {}", known.join(", ")),
                    )
                })?;
            }
            "Option" => {
                let parameters = self.parameters(&location, None)?;
                for name in [
                    "forcediffuse",
                    "wavefront",
                    "disablepixeljitter",
                    "disabletexturefiltering",
                    "disablewavelengthjitter",
                ] {
                    parameters.find(name, &[Kind::Bool]);
                }
                for name in ["msereferenceimage", "msereferenceout", "rendercoordsys"] {
                    parameters.find(name, &[Kind::Text]);
                }
                parameters.find("seed", &[Kind::Integer]);
                parameters.find("displacementedgescale", &[Kind::Float]);
                parameters.find("pixelstats", &[Kind::Bool]);
                parameters.warn_unused(word, &mut self.builder.warnings);
                parameters.release(&self.access().budget);
            }
            "Camera" => {
                let (class, parameters) = self.named(word, &location, None)?;
                let transforms = self.state.transforms;
                self.builder.media.of_camera = self.state.media[1];
                self.camera = Some((class, parameters, transforms));
                let inverses = transforms.map(|transform| transform.inverse());
                if let [Some(start), Some(end)] = inverses {
                    self.spaces.insert("camera".into(), [start, end]);
                }
            }
            "Film" => {
                let (class, parameters) = self.named(word, &location, None)?;
                self.film = Film::read(&class, &parameters, &mut self.builder.warnings)?;
                self.requested.film = true;
                self.requested.location.get_or_insert(location);
                parameters.warn_unused(word, &mut self.builder.warnings);
            }
            "Sampler" | "Integrator" | "PixelFilter" | "Accelerator" => {
                let (_, parameters) = self.named(word, &location, None)?;
                self.requested.samples = parameters.int("pixelsamples")?.or(self.requested.samples);
                self.requested.depth = parameters.int("maxdepth")?.or(self.requested.depth);
                self.requested.location.get_or_insert(location);
                parameters.ignore();
            }
            "WorldBegin" => self.begin_world(&location)?,
            "WorldEnd" => {
                let problem = "WorldEnd is a statement of older formats";
                return Err(
                    location.error(problem, "pbrt --upgrade makes files of version 4; leave it out there")
                );
            }
            "Include" | "Import" => self.include(word, &location)?,
            "Texture" => self.texture(&location)?,
            "Material" => {
                let (class, parameters) = self.named(word, &location, Some(2))?;
                let material = self.material(&class, &parameters)?;
                self.state.material = self.builder.add_material(material);
            }
            "MakeNamedMaterial" => {
                let (name, parameters) = self.named(word, &location, Some(2))?;
                let class = parameters.text("type")?.map(str::to_owned).ok_or_else(|| {
                    location.error("MakeNamedMaterial has no \"string type\"", "give the material's type")
                })?;
                let material = self.material(&class, &parameters)?;
                if !self.builder.define_material(&name, material) {
                    let problem = format!("material {} is defined twice", quoted(&name));
                    return Err(location.error(problem, "give each its own name"));
                }
            }
            "NamedMaterial" => {
                let name = self.text(word, &location)?;
                self.state.material = self.builder.named_material(&name, &location);
            }
            "MakeNamedMedium" => {
                let (name, parameters) = self.named(word, &location, Some(3))?;
                let (access, place) = (self.access(), self.state.transforms[0]);
                let warnings = &mut self.builder.warnings;
                let medium = medium::read(&parameters, &place, access, warnings)?;
                parameters.warn_unused(word, warnings);
                parameters.release(&access.budget);
                if !self.builder.media.define(&mut self.builder.scene, &name, medium, &location) {
                    let problem = format!("medium {} is defined twice", quoted(&name));
                    return Err(location.error(problem, "give each its own name"));
                }
            }
            "MediumInterface" => {
                let first = self.text(word, &location)?;
                let second = match self.source().peek() {
                    Some(b'"') => self.text(word, &location)?,
                    _ => first.clone(),
                };
                let Builder { media, scene, .. } = &mut self.builder;
                self.state.media = [first, second].map(|name| media.named(scene, &name, &location));
            }
            "LightSource" => {
                let (class, parameters) = self.named(word, &location, Some(1))?;
                let world_from_light = self.builder.world_from_file * self.state.transforms[0];
                let reading =
                    lights::Reading { access: self.access(), world_from_light, exposure: self.exposure };
                match reading.read(&class, &parameters, &mut self.builder.warnings)? {
                    Found::Plain(light) => _ = self.builder.scene.add_light(light),
                    Found::Pictured { light, picture, grey } => {
                        self.builder.add_pictured(light, &picture, grey, &location);
                    }
                    Found::Infinite(light) => self.builder.add_infinite(light, world_from_light),
                }
                parameters.warn_unused(word, &mut self.builder.warnings);
                parameters.release(&self.access().budget);
            }
            "AreaLightSource" => {
                let (class, parameters) = self.named(word, &location, Some(1))?;
                let reading = lights::Reading {
                    access: self.access(),
                    world_from_light: Affine::IDENTITY,
                    exposure: self.exposure,
                };
                self.state.area_light = Some(Arc::new(reading.area(&class, &parameters)?));
                parameters.warn_unused(word, &mut self.builder.warnings);
            }
            "Shape" => self.shape(&location)?,
            "ObjectBegin" => {
                let name = self.text(word, &location)?;
                if self.object.is_some() {
                    return Err(location
                        .error("ObjectBegin within an object", "end the object before with ObjectEnd"));
                }
                self.builder.end_group();
                self.save(Block::Object, &location)?;
                self.object = Some(name);
                self.builder.members = Some(Vec::new());
            }
            "ObjectEnd" => {
                self.restore(Block::Object, &location)?;
                let name = self.object.take().unwrap_or_default();
                let id = self.builder.end_object(&name);
                if self.builder.objects.insert(name.clone(), id).is_some() {
                    let problem = format!("object {} is defined twice", quoted(&name));
                    return Err(location.error(problem, "give each its own name"));
                }
            }
            "ObjectInstance" => {
                let name = self.text(word, &location)?;
                if self.object.is_some() {
                    let problem = "ObjectInstance within an object";
                    return Err(location.error(problem, "objects are made of shapes: show it outside"));
                }
                let id = *self.builder.objects.get(&name).ok_or_else(|| {
                    location.error(
                        format!("no object {} is defined", quoted(&name)),
                        "define it before: ObjectBegin \"NAME\"",
                    )
                })?;
                self.hold_name(&location)?;
                self.builder.end_group();
                self.builder.transform_moving(id, &self.state.transforms, Some(&name), &location);
            }
            other => {
                let problem = format!("unknown statement {}", quoted(other));
                return Err(location
                    .error(problem, "pbrt-v4's file-format page lists them; names are case-sensitive"));
            }
        }
        Ok(())
    }

    fn hold_name(&self, location: &Location) -> Result<(), Error> {
        self.access().budget.hold(NAMED_BYTES).map_err(|e| location.excess(e))
    }

    fn attribute(&mut self, location: &Location) -> Result<(), Error> {
        let (target, parameters) = self.named("Attribute", location, None)?;
        let number = TARGETS.iter().position(|known| *known == target).ok_or_else(|| {
            let problem = format!("unknown target {} of Attribute", quoted(&target));
            location.error(problem, format!("valid are {}", TARGETS.join(", ")))
        })?;
        let list = Arc::make_mut(&mut self.state.attributes[number]);
        let new = parameters.into_list();
        list.retain(|known| !new.iter().any(|new| new.name == known.name));
        list.extend(new);
        Ok(())
    }

    fn begin_world(&mut self, location: &Location) -> Result<(), Error> {
        let none = || ("perspective".to_owned(), Parameters::none(location.clone()), [Affine::IDENTITY; 2]);
        let (class, parameters, transforms) = self.camera.take().unwrap_or_else(none);
        let warnings = &mut self.builder.warnings;
        let View { camera, shader, world_from_file, shutter } =
            view::read(&class, &parameters, &transforms[0], &self.film, warnings)?;
        parameters.warn_unused("Camera", warnings);
        let open = shutter[1] - shutter[0];
        if open <= 0.0 || !open.is_finite() {
            return Err(parameters
                .location
                .error("the shutter is not open", "\"shutterclose\" must be above \"shutteropen\""));
        }
        self.exposure = open * self.film.iso / 100.0;
        self.builder.world_from_file = world_from_file;
        let (fov_y, panorama) = (camera.fov_y, camera.projection == Projection::Panorama);
        let id = self.builder.scene.add_camera(camera);
        if transforms[0] != transforms[1] {
            let node = |camera_from_file: Affine| {
                let [x, y, z, eye] = (world_from_file * camera_from_file.inverse()?).columns;
                let back = z.map(|value| -value);
                // Its length says nothing; that of x may be another side's.
                Some(Affine { columns: [x, y, back, eye] })
            };
            let both = [node(transforms[0]), node(transforms[1])];
            let moves = match both {
                [Some(start), Some(end)] if !panorama => self.builder.motion.camera(id, fov_y, &[start, end]),
                _ => false,
            };
            self.builder.tell_motion(moves, &parameters.location);
        }
        if let Some(mut shader) = shader {
            shader.confined_to = self.access().confined_to();
            self.builder.scene.set_camera_file(id, shader);
        }
        self.state.transforms = [Affine::IDENTITY; 2];
        self.state.active = [true; 2];
        self.spaces.insert("world".into(), self.state.transforms);
        self.in_world = true;
        Ok(())
    }

    fn include(&mut self, word: &str, location: &Location) -> Result<(), Error> {
        let name = self.text(word, location)?;
        let path = resolve(&location.path, &name);
        let import = if word == "Import" {
            self.world_only(word, location)?;
            let depth = self.saved.len();
            self.save(Block::Import, location)?;
            Some(depth)
        } else {
            None
        };
        self.sources.open_named(&path, import).map_err(|error| {
            if error.kind == ErrorKind::Io || error.problem.contains("include each other") {
                let problem = format!("{} cannot be read: {}", quoted(&name), error.problem);
                return Error { kind: error.kind, ..location.error(problem, error.remedy) };
            }
            error
        })
    }

    fn texture(&mut self, location: &Location) -> Result<(), Error> {
        let name = self.text("Texture", location)?;
        let kind = self.text("Texture", location)?;
        let class = self.text("Texture", location)?;
        let is_float = match &kind[..] {
            "float" => true,
            "spectrum" => false,
            other => {
                let problem = format!("unknown type {} of texture {}", quoted(other), quoted(&name));
                return Err(location.error(problem, "valid are float and spectrum"));
            }
        };
        let parameters = self.parameters(location, Some(4))?;
        self.hold_name(location)?;
        let world_from_texture = self.builder.world_from_file * self.state.transforms[0];
        let texture_from_world = world_from_texture.inverse().ok_or_else(|| {
            location.error("the transform of a texture flattens space", "it must have an inverse")
        })?;
        let reading = texture_parameters::Reading {
            textures: &self.textures,
            access: self.access(),
            texture_from_world,
            world_from_texture,
            is_float,
        };
        let texture = reading.read(&class, &parameters, &mut self.builder.warnings)?;
        parameters.warn_unused("Texture", &mut self.builder.warnings);
        parameters.release(&self.access().budget);
        let list = if is_float { &mut self.textures.floats } else { &mut self.textures.spectra };
        if list.insert(name.clone(), Arc::new(texture)).is_some() {
            return Err(location
                .error(format!("texture {} is defined twice", quoted(&name)), "give each its own name"));
        }
        Ok(())
    }

    fn material(&mut self, class: &str, parameters: &Parameters) -> Result<Material, Error> {
        self.hold_name(&parameters.location)?;
        let access = self.access();
        let Builder { warnings: of_builder, .. } = &mut self.builder;
        let mut warnings = std::mem::take(of_builder);
        let (builder, location) = (&mut self.builder, parameters.location.clone());
        let mut named = |name: &str| builder.named_material(name, &location);
        let read = material::Reading { textures: &self.textures, access, named: &mut named }.read(
            class,
            parameters,
            &mut warnings,
        );
        parameters.warn_unused("Material", &mut warnings);
        self.builder.warnings = warnings;
        parameters.release(&access.budget);
        read
    }

    fn shape(&mut self, location: &Location) -> Result<(), Error> {
        let (class, parameters) = self.named("Shape", location, Some(0))?;
        let access = self.access();
        let alpha =
            self.textures.float(&parameters, "alpha")?.filter(|alpha| alpha.constant() != Some([1.0; 3]));
        let mut area_light = self.state.area_light.clone();
        if area_light.is_some() && self.object.is_some() {
            self.warn(location, Oddity::NotShown, "area lights of objects that are instanced");
            area_light = None;
        }
        let wants_texcoords = self.builder.is_textured(self.state.material)
            || matches!(alpha, Some(Input::Texture(_)))
            || area_light.as_ref().is_some_and(|light| light.picture.is_some());
        // Spheres have no texture coordinates, and their light leaves them outwards.
        let takes_spheres = area_light.as_ref().is_some_and(|light| !light.both_sides)
            && !wants_texcoords
            && alpha.is_none()
            && !self.state.reversed
            && self.state.transforms.iter().all(Affine::is_similarity);
        let mut reading = shapes::Reading {
            access,
            warnings: &mut self.builder.warnings,
            reversed: self.state.reversed,
            wants_texcoords,
            takes_spheres,
        };
        let mut transforms = self.state.transforms;
        let (mesh, signature) = shapes::read(&class, &parameters, &mut reading, &mut transforms)?;
        parameters.warn_unused("Shape", &mut self.builder.warnings);
        parameters.release(&access.budget);
        if transforms.iter().any(|transform| transform.inverse().is_none()) {
            return Err(location.error("the transform of a shape flattens space", "it must have an inverse"));
        }
        let Builder { media, scene, .. } = &mut self.builder;
        let medium = media.within(scene, self.state.media);
        if medium.is_none() && self.builder.is_interface(self.state.material) && area_light.is_none() {
            // Nothing of it is seen but its medium.
            access.budget.release(mesh.memory_bytes());
            return Ok(());
        }
        self.builder.show(Shown {
            mesh,
            class,
            signature,
            transforms,
            material: self.state.material,
            medium,
            area_light,
            alpha,
            location: location.clone(),
        })
    }

    fn finish(mut self, path: &Path) -> Result<Loaded, Error> {
        if let Some(open) = self.saved.last() {
            return Err(unended(open));
        }
        if !self.in_world {
            let problem = "no WorldBegin: the file describes no scene";
            return Err(Error::data(path, None, problem, "shapes and lights follow WorldBegin"));
        }
        let options = self.requested.options(&self.film);
        if let Some(location) = self.requested.location.take().filter(|_| !options.is_empty()) {
            self.warn(
                &location,
                Oddity::NotShown,
                format!("size and samples of the picture: give {options}"),
            );
        }
        let Builder { media, scene, world_from_file, .. } = &mut self.builder;
        media.finish(scene, world_from_file)?;
        self.builder.finish(path)?;
        let mut files = std::mem::take(&mut self.sources.files);
        files.extend(self.builder.picture_files());
        let Builder { scene, warnings, .. } = self.builder;
        Ok(Loaded { scene, warnings, files })
    }
}

/// The error of a part of a file that does not end.
fn unended(open: &Saved) -> Error {
    let [begin, end] = open.block.names();
    open.location.error(format!("{begin} has no {end}"), format!("end it with {end}"))
}
