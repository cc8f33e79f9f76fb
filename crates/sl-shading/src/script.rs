// SPDX-License-Identifier: GPL-3.0-or-later
//! A shader's file with values for its parameters, and the shaders of the renderer that it makes.
//! `.osl` is source text, `.oso` the output of OSL's compiler, `.oslgroup` OSL's text for groups: `param
//! float scale 2 ; shader noise.osl pattern ; shader matte.osl base ; connect pattern.out base.Kd ;`, with
//! file names relative to it.
//! Tests: `tests/scripts.rs`.

use std::borrow::Cow;
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use gnurt_image::WorkingSpace;
use gnurt_shading::script::{CameraFrame, Kind, Parameter, ParameterValue, document_and_node};
use gnurt_shading::{
    AttributeRequest, CameraShader, ColorMap, DisplacementShader, EnvironmentShader, LightShader,
    PixelShader, SurfaceShader,
};
use gnurt_simd::Level;
use gnurt_sl::exec::{Plan, PlanOptions, Program};
use gnurt_sl::group::{Group, Hint};
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{Shader, SymbolKind};
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::{Base, Type};
use gnurt_sl::{Options, compile};
use gnurt_sl_lib::color::ColorSystem;

use crate::access::Access;
use crate::attributes::{self, CAMERA_PREFIX, PATH_PREFIX};
use crate::camera::CameraScript;
use crate::changes::{each_op, gradients, read_changes, reads_bounces};
use crate::displacement;
use crate::faults::Faults;
use crate::fixed::Fixed;
use crate::library;
use crate::light::ScriptLight;
use crate::live::Live;
use crate::mtlx;
use crate::outputs::{Made, Outputs, Wanted};
use crate::parameter;
use crate::pixel::{self, ScriptPixel};
use crate::properties::{Properties, debug_tags};
use crate::reader::Reader;
use crate::sky::ScriptSky;
use crate::surface::ScriptSurface;
use crate::surface_state::{CAMERA, DIFFUSE, Needs};
use crate::textures::Textures;
use crate::world::Common;

/// The layer that takes closure outputs as `Ci`: light, and its opacity.
const CLOSURE_OUTPUT: &str =
    "surface closure_output (closure color bsdf = 0, closure color edf = 0, float opacity = 1) {
    float part = clamp (opacity, 0.0, 1.0);
    Ci = part * (bsdf + edf) + (1 - part) * transparent ();
}";

/// The outputs of a shader that are its `Ci`, and the parameters of that layer for them: the first output that is a closure, or
/// the fields of MaterialX's `surfaceshader`.
fn closure_outputs(shader: &Shader) -> Vec<(String, &'static str)> {
    let outputs = || shader.params().map(|(_, symbol)| symbol).filter(|s| s.kind == SymbolKind::OutputParam);
    if let Some(only) = outputs().find(|s| s.ty == Type::CLOSURE && !s.name.contains('.')) {
        return vec![(only.name.to_string(), "bsdf")];
    }
    let fields = |of: &str| {
        let field = |field: &'static str| (format!("{of}.{field}"), field);
        let all = ["bsdf", "edf", "opacity"].map(field);
        let is_there = |(name, field): &(String, &str)| {
            let ty = if *field == "opacity" { Type::FLOAT } else { Type::CLOSURE };
            shader.find(name).is_some_and(|id| shader.symbol(id).ty == ty)
        };
        all.iter().all(is_there).then(|| all.to_vec())
    };
    outputs().find_map(|s| s.ty.struct_id().and_then(|_| fields(&s.name))).unwrap_or_default()
}

/// Iterations of loops that a point may take.
const ITERATIONS: u64 = 1 << 20;

/// A shader's file, compiled, with values.
#[derive(Clone, Debug)]
pub struct Script {
    name: String,
    kind: Kind,
    group: Group,
    /// The path of its caller: a file, an embedded one, or a file and the node of a document.
    path: PathBuf,
    /// Where it is read from again: its file, and the node of a document.
    origin: Option<PathBuf>,
    files: Vec<PathBuf>,
    /// Their texts.
    texts: Vec<(PathBuf, String)>,
    warnings: Vec<String>,
    textures: Arc<Textures>,
    faults: Arc<Faults>,
    access: Access,
    /// Values that were given, the last one of each parameter.
    given: Vec<(String, ParameterValue)>,
    live: Live,
}

impl Script {
    /// Reads and compiles a file; `builtin/wood.osl` is an embedded one, unless there is a file of that name.
    ///
    /// # Errors
    /// The file cannot be read, or the compiler's messages: file, line, column and the source line of each
    /// error.
    pub fn open(path: &Path, access: &Access) -> Result<Self, String> {
        if let Some(text) = library::text(path) {
            return Self::made(path, text, access, true);
        }
        if let Some((file, node)) = document_and_node(&path.to_string_lossy()) {
            return Self::of_document(path, Path::new(file), node, None, access);
        }
        let text = access.text(path).map_err(|why| {
            let why = library::unknown(path).unwrap_or(why);
            format!("{}: {why}", path.display())
        })?;
        Self::from_text(path, &text, access)
    }

    /// Compiles a text as if a file of this name held it.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_text(path: &Path, text: &str, access: &Access) -> Result<Self, String> {
        match document_and_node(&path.to_string_lossy()) {
            Some((file, node)) => Self::of_document(path, Path::new(file), node, Some(text), access),
            None => Self::made(path, text, access, false),
        }
    }

    /// The shader that a document of MaterialX describes.
    fn of_document(
        path: &Path,
        file: &Path,
        node: Option<&str>,
        text: Option<&str>,
        access: &Access,
    ) -> Result<Self, String> {
        let written = mtlx::written(file, node, text, access)?;
        let mut script = Self::made(file, &written.text, access, true)?;
        (script.path, script.origin) = (path.to_owned(), Some(path.to_owned()));
        // The text that was compiled is in no file, but it may have included some.
        script.files.splice(..0, written.files);
        script.texts.splice(..0, written.texts);
        // Those of the compiler are about a text that the document's author has not written.
        script.warnings = written.warnings;
        Ok(script)
    }

    fn made(path: &Path, text: &str, access: &Access, is_in_no_file: bool) -> Result<Self, String> {
        let texts = if is_in_no_file { Vec::new() } else { vec![(path.to_owned(), text.to_owned())] };
        let reader = Reader { access, texts: RefCell::new(texts), warnings: RefCell::default() };
        let folder = path.parent().map(Path::to_owned).unwrap_or_default();
        let is_group = path.extension().is_some_and(|end| end == "oslgroup");
        let mut group = Group::default();
        if is_group {
            group = reader.group(path, text, &folder)?;
        } else {
            let shader = reader.shader(path, text)?;
            group.name = shader.name.to_string();
            group.add(Arc::new(shader), None, &[], &mut Vec::new());
        }
        let last = group.layers.last().ok_or_else(|| format!("{}: no shader is in it", path.display()))?;
        let kind = match &*last.shader.kind {
            "surface" | "shader" => Kind::Surface,
            "displacement" => Kind::Displacement,
            "light" => Kind::Light,
            "camera" => Kind::Camera,
            "environment" => Kind::Environment,
            "pixel" => Kind::Pixel,
            other => return Err(format!("{}: shaders of type {other} are not drawn", path.display())),
        };
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let is_black = last.shader.find("Ci").is_none() && closure_outputs(&last.shader).is_empty();
        // A `shader` without a closure that has an offset is nothing else.
        let is_offset = is_black && &*last.shader.kind == "shader" && displacement::has_offset(&last.shader);
        let kind = if is_offset { Kind::Displacement } else { kind };
        if kind == Kind::Surface && is_black {
            reader.warnings.borrow_mut().push(format!("{name}: it does not write Ci, and is black"));
        }
        let texts = reader.texts.into_inner();
        let files: Vec<PathBuf> = texts.iter().map(|(path, _)| path.clone()).collect();
        Ok(Self {
            name,
            kind,
            group,
            path: path.to_owned(),
            origin: files.first().cloned(),
            files,
            texts,
            warnings: reader.warnings.into_inner(),
            textures: Arc::new(Textures::new(access.clone(), folder)),
            faults: Arc::default(),
            access: access.clone(),
            given: Vec::new(),
            live: Live::default(),
        })
    }

    /// Reads and compiles its file again, and sets the parameters to their values here; values that no longer
    /// fit become warnings.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn again(&self) -> Result<Self, String> {
        let path = self.origin.as_ref().ok_or_else(|| format!("{}: it has no file", self.name))?;
        let mut script = Self::open(path, &self.access)?;
        for (name, value) in &self.given {
            if let Err(why) = script.set(name, value) {
                script.warnings.push(format!("{}: {why}", self.name));
            }
        }
        Ok(script)
    }

    /// Makes its numbers ones that [`tune`](Self::tune) changes in all shaders that are made of it from now on; those compute a little
    /// more slowly, for nothing of such a number is computed beforehand.
    pub fn make_tunable(&mut self) {
        let tunable: Vec<Parameter> =
            self.parameters().into_iter().filter(|p| p.is_tunable && !p.is_of_mesh).collect();
        let others = self.group.layers.split_last().map_or(&[][..], |(_, others)| others);
        let is_elsewhere = |name: &str| {
            others.iter().any(|layer| layer.shader.find(name).is_some_and(|id| layer.interpolated(id)))
        };
        // A camera's `aspect` without a value is the picture's.
        let is_given = |name: &str| self.given.iter().any(|(known, _)| known == name);
        let is_of_picture = |name: &str| self.kind == Kind::Camera && name == "aspect" && !is_given(name);
        let tunable: Vec<Parameter> =
            tunable.into_iter().filter(|p| !is_elsewhere(&p.name) && !is_of_picture(&p.name)).collect();
        self.live = Live::default();
        let Some(layer) = self.group.layers.last_mut() else { return };
        for parameter in &tunable {
            let (Some(id), Some(numbers)) = (layer.shader.find(&parameter.name), parameter.default.numbers())
            else {
                continue;
            };
            layer.hints.insert(id, Hint { interpolated: true, interactive: false });
            self.live.add(&parameter.name, &numbers);
        }
    }

    /// Whether a parameter is one that [`tune`](Self::tune) changes.
    #[must_use]
    pub fn is_tunable(&self, name: &str) -> bool {
        self.live.has(name)
    }

    /// Gives a number another value in all shaders that were made of this script since it was
    /// [made tunable](Self::make_tunable), at once and without compiling.
    ///
    /// # Errors
    /// As [`set`](Self::set); or it cannot be tuned.
    pub fn tune(&mut self, name: &str, given: &ParameterValue) -> Result<(), String> {
        self.set(name, given)?;
        let numbers =
            self.parameters().into_iter().find(|p| p.name == name).and_then(|p| p.default.numbers());
        match numbers.is_some_and(|numbers| self.live.set(name, &numbers)) {
            true => Ok(()),
            false => Err(format!("parameter '{name}': it cannot be changed without compiling")),
        }
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The file's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The shader's name; the last layer's of a group.
    #[must_use]
    pub fn shader_name(&self) -> &str {
        self.group.layers.last().map_or("", |layer| &layer.shader.name)
    }

    /// All source files that were read, its own first.
    #[must_use]
    pub fn files(&self) -> &[PathBuf] {
        &self.files
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn texts(&self) -> &[(PathBuf, String)] {
        &self.texts
    }

    pub(crate) fn access(&self) -> &Access {
        &self.access
    }

    pub(crate) fn given(&self) -> &[(String, ParameterValue)] {
        &self.given
    }

    /// Warnings of the compiler.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Output and faults of its runs: each line once.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        self.faults.lines()
    }

    /// Its parameters; those of the last layer of a group.
    #[must_use]
    pub fn parameters(&self) -> Vec<Parameter> {
        let Some(layer) = self.group.layers.last() else { return Vec::new() };
        let settable = |ty: Type| ty.struct_id().is_none() && ty.base != Base::Closure;
        let all = layer.shader.params();
        all.filter(|(_, symbol)| symbol.kind == SymbolKind::Param && settable(symbol.ty))
            .map(|(id, symbol)| parameter::declared(symbol, layer.values.get(&id)))
            .collect()
    }

    /// Gives a parameter a value.
    ///
    /// # Errors
    /// There is none of this name, or it takes other values.
    pub fn set(&mut self, name: &str, given: &ParameterValue) -> Result<(), String> {
        let ty = self.type_of(name)?;
        let value = parameter::value(ty, given).map_err(|why| format!("parameter '{name}': {why}"))?;
        let mut messages = Vec::new();
        if let Some(layer) = self.group.layers.last_mut() {
            let hint = Hint { interpolated: self.live.has(name), interactive: false };
            layer.set(name, &value, hint, &mut messages);
        }
        if let Some(why) = messages.first() {
            return Err(format!("parameter '{name}': {why}"));
        }
        self.given.retain(|(known, _)| known != name);
        self.given.push((name.to_owned(), given.clone()));
        Ok(())
    }

    /// The same for a written value: numbers between commas, or a text.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn set_text(&mut self, name: &str, text: &str) -> Result<(), String> {
        let ty = self.type_of(name)?;
        // As people name pictures elsewhere.
        let text = text.strip_prefix('@').filter(|_| ty == Type::STRING).unwrap_or(text);
        let given = parameter::read(ty, text).map_err(|why| format!("parameter '{name}': {why}"))?;
        self.set(name, &given)
    }

    fn type_of(&self, name: &str) -> Result<Type, String> {
        let all = self.parameters();
        let layer = self.group.layers.last();
        if let (true, Some(layer)) = (all.iter().any(|p| p.name == name), layer)
            && let Some(id) = layer.shader.find(name)
        {
            return Ok(layer.shader.symbol(id).ty);
        }
        let names: Vec<&str> = all.iter().map(|p| &p.name[..]).collect();
        let list =
            if names.is_empty() { "it has none".into() } else { format!("there are {}", names.join(", ")) };
        let near = names
            .iter()
            .max_by(|a, b| strsim::jaro_winkler(name, a).total_cmp(&strsim::jaro_winkler(name, b)));
        let near = near.filter(|near| strsim::jaro_winkler(name, near) > 0.8);
        let meant = near.map_or_else(String::new, |near| format!("; did you mean '{near}'?"));
        Err(format!("unknown parameter '{name}'; {list}{meant}"))
    }

    /// The same for light in another space.
    #[must_use]
    pub fn within(&self, space: WorkingSpace) -> Self {
        let access = Access { space, ..self.access.clone() };
        Self { access, ..self.clone() }
    }

    /// As a surface.
    ///
    /// # Errors
    /// It is none, or too large.
    pub fn surface(&self) -> Result<Arc<dyn SurfaceShader>, String> {
        self.is(Kind::Surface)?;
        let bends = |shader: &Shader| displacement::calls(shader, Opcode::Bump);
        if !self.group.layers.iter().any(|l| bends(&l.shader) || displacement::assigns(&l.shader)) {
            return self.displaced_surface();
        }
        let mut script = self.clone();
        for layer in &mut script.group.layers {
            let shader = Arc::make_mut(&mut layer.shader);
            displacement::expand(shader, Opcode::Bump);
            // The point is displaced already.
            if displacement::assigns(shader) {
                displacement::keep_globals(shader);
            }
        }
        script.displaced_surface()
    }

    /// The same, of layers that leave the point where it is.
    fn displaced_surface(&self) -> Result<Arc<dyn SurfaceShader>, String> {
        let group = self.with_closure_output()?;
        let plan = self.plan(&group, &[])?;
        let fixed = Fixed::of(&plan, &colors()?, ColorMap::to(self.access.space));
        let common = match &fixed {
            // It runs only for callers that request its variables.
            Some(_) => self.common_of(&group, &plan, plan.clone())?,
            None => self.compiled(&group, &plan)?,
        };
        let script = self.clone();
        let closed = group.into_owned();
        let tags = debug_tags(&plan, &colors()?);
        let make = move |wanted: &Wanted| {
            // Without the closures where they are not needed.
            let group = if wanted.is_tag { &closed } else { &script.group };
            let parameter = Some(&wanted.name[..]).filter(|_| wanted.is_parameter);
            let made = script.plan(group, parameter.as_slice()).and_then(|plan| {
                let tag = plan.strings.find(&wanted.name).filter(|_| wanted.is_tag);
                Ok(Made { common: script.compiled(group, &plan)?, tag })
            });
            made.map_err(|why| script.faults.note(&why)).ok()
        };
        let outputs = Outputs::of(&self.group, &tags, Box::new(make));
        Ok(Arc::new(ScriptSurface { common, fixed, outputs }))
    }

    /// As the displacement of a surface: by layers of that type, by calls of `displace` in a `surface` or `shader`, or by the output
    /// `vector displacement` of the last one. `None` for others.
    ///
    /// # Errors
    /// It is too large.
    pub fn displacement(&self) -> Result<Option<Arc<dyn DisplacementShader>>, String> {
        let Some(last) = self.group.layers.last() else { return Ok(None) };
        let moves =
            |shader: &Shader| displacement::assigns(shader) || displacement::calls(shader, Opcode::Displace);
        let moves_point = match self.kind {
            Kind::Displacement | Kind::Surface if displacement::has_offset(&last.shader) => false,
            Kind::Displacement | Kind::Surface if self.group.layers.iter().any(|l| moves(&l.shader)) => true,
            _ => return Ok(None),
        };
        let value = if moves_point { displacement::POSITION } else { displacement::OFFSET };
        let mut group = Cow::Borrowed(&self.group);
        if moves_point {
            for layer in &mut group.to_mut().layers {
                let shader = Arc::make_mut(&mut layer.shader);
                if !displacement::assigns(shader) {
                    displacement::keep_globals(shader);
                }
                displacement::expand(shader, Opcode::Displace);
            }
        }
        let options = PlanOptions {
            outputs: vec![value.to_owned()],
            iterations: ITERATIONS,
            drops_outputs: true,
            // All layers move the point, one after the other.
            lazy_globals: !moves_point,
            ..PlanOptions::default()
        };
        let plan =
            Plan::new(&group, &options).map(Arc::new).map_err(|why| format!("{}: {why}", self.name))?;
        Ok(Some(displacement::made(self.compiled(&group, &plan)?, value)))
    }

    /// Its group; if the last shader does not write `Ci`, with a layer that sets `Ci` to its closure outputs.
    fn with_closure_output(&self) -> Result<Cow<'_, Group>, String> {
        let borrowed = Cow::Borrowed(&self.group);
        let Some(last) = self.group.layers.last() else { return Ok(borrowed) };
        if last.shader.find("Ci").is_some() {
            return Ok(borrowed);
        }
        let outputs = closure_outputs(&last.shader);
        if outputs.is_empty() {
            return Ok(borrowed);
        }
        let load = |path: &Path| library::text(path).map(str::to_owned);
        let compiled = compile("closure_output.osl", CLOSURE_OUTPUT, &Options::default(), &load);
        let shader = compiled.shader.ok_or("the layer of closure outputs does not compile")?;
        let mut group = self.group.clone();
        let layer = format!("closure_output_{}", group.layers.len());
        group.add(Arc::new(shader), Some(&layer), &[], &mut Vec::new());
        for (output, parameter) in &outputs {
            group.connect(&last.name, output, &layer, parameter)?;
        }
        Ok(Cow::Owned(group))
    }

    /// As a light.
    ///
    /// # Errors
    /// It is none, or too large.
    pub fn light(&self) -> Result<Arc<dyn LightShader>, String> {
        self.is(Kind::Light)?;
        let common = self.common(&self.group, &["L", "Cl", "lightdist", "lightpdf"])?;
        Ok(Arc::new(ScriptLight { common }))
    }

    /// As a camera with a position. A parameter `aspect` without a value is the picture's width over its
    /// height.
    ///
    /// # Errors
    /// It is none, or too large.
    pub fn camera(&self, frame: CameraFrame) -> Result<Arc<dyn CameraShader>, String> {
        let camera = self.camera_anywhere()?.at(&[frame]);
        camera.ok_or_else(|| format!("{}: it has no position", self.name))
    }

    /// The same, but without a frame.
    ///
    /// # Errors
    /// As [`camera`](Self::camera).
    pub fn camera_anywhere(&self) -> Result<CameraScript, String> {
        self.is(Kind::Camera)?;
        let mut group = self.group.clone();
        if let Some(layer) = group.layers.last_mut()
            && let Some(id) = layer.shader.find("aspect")
            && layer.shader.symbol(id).kind == SymbolKind::Param
            && !layer.values.contains_key(&id)
        {
            layer.hints.insert(id, Hint { interpolated: true, interactive: false });
        }
        let common = Arc::new(self.common(&group, &["P", "I", "tmin", "tmax", "weight"])?);
        let has_lens = group.layers.iter().any(|layer| layer.shader.symbols.iter().any(|s| &*s.name == "xi"));
        Ok(CameraScript { common, has_lens })
    }

    /// As the environment of rays that hit nothing.
    ///
    /// # Errors
    /// It is none, or too large.
    pub fn environment(&self) -> Result<Arc<dyn EnvironmentShader>, String> {
        self.is(Kind::Environment)?;
        // A shader that queries kinds of rays must be evaluated for light rays, too.
        let ray_kinds = if self.reads_ray_kind() { DIFFUSE } else { CAMERA };
        Ok(Arc::new(ScriptSky { common: self.common(&self.group, &[])?, ray_kinds }))
    }

    /// The same as rays of the camera see it, if it queries kinds of rays.
    ///
    /// # Errors
    /// As [`environment`](Self::environment).
    pub fn backdrop(&self) -> Result<Option<Arc<dyn EnvironmentShader>>, String> {
        self.is(Kind::Environment)?;
        if !self.reads_ray_kind() {
            return Ok(None);
        }
        Ok(Some(Arc::new(ScriptSky { common: self.common(&self.group, &[])?, ray_kinds: CAMERA })))
    }

    /// Whether some layer calls `raytype`.
    fn reads_ray_kind(&self) -> bool {
        let mut queries = false;
        self.group
            .layers
            .iter()
            .for_each(|layer| each_op(&layer.shader, &mut |op| queries |= op.code == Opcode::RayType));
        queries
    }

    /// As a pixel shader.
    ///
    /// # Errors
    /// It is none, has no `output color Cpixel`, or is too large.
    pub fn pixel(&self) -> Result<Arc<dyn PixelShader>, String> {
        self.is(Kind::Pixel)?;
        let shown = self.group.layers.last().and_then(|layer| {
            let symbol = layer.shader.symbol(layer.shader.find(pixel::SHOWN)?);
            (symbol.kind == SymbolKind::OutputParam && symbol.ty == Type::COLOR).then_some(())
        });
        if shown.is_none() {
            return Err(format!(
                "{}: pixels show its 'output color {}', and it has none",
                self.name,
                pixel::SHOWN
            ));
        }
        Ok(Arc::new(ScriptPixel { common: self.common(&self.group, &[pixel::SHOWN])? }))
    }

    fn is(&self, expected: Kind) -> Result<(), String> {
        if self.kind == expected {
            return Ok(());
        }
        let (is, expected) = (self.kind.kind_name(), expected.kind_name());
        Err(format!("{}: its shader is of type {is}; one of type {expected} is expected here", self.name))
    }

    /// Ready to run, with the values to store of each point.
    fn common(&self, group: &Group, outputs: &[&str]) -> Result<Common, String> {
        self.compiled(group, &self.plan(group, outputs)?)
    }

    fn plan(&self, group: &Group, outputs: &[&str]) -> Result<Arc<Plan>, String> {
        let outputs = outputs.iter().map(ToString::to_string).collect();
        let plan = Plan::new(
            group,
            &PlanOptions { outputs, iterations: ITERATIONS, drops_outputs: true, ..PlanOptions::default() },
        );
        plan.map(Arc::new).map_err(|why| format!("{}: {why}", self.name))
    }

    /// The interpreter runs it until there is code, where there is some at all; the values are the same.
    fn compiled(&self, group: &Group, plan: &Arc<Plan>) -> Result<Common, String> {
        let job = self.access.codes.cache().start(plan.clone(), Level::best());
        self.common_of(group, plan, Arc::new(job))
    }

    fn common_of(&self, group: &Group, plan: &Plan, program: Arc<dyn Program>) -> Result<Common, String> {
        let colors = colors()?;
        let mut requests = self.requests(group);
        let (changing, has_changes) = read_changes(plan);
        let gradients = gradients(&requests, &changing);
        requests.extend(gradients);
        let frame = |name: &str| requests.iter().position(|request| request.name == name);
        let [area, time] = [AttributeRequest::SURFACE_AREA, AttributeRequest::TIME].map(frame);
        let [shutter, velocity] = [AttributeRequest::SHUTTER, AttributeRequest::VELOCITY].map(frame);
        let needs = Needs::of(plan);
        let properties = Properties { reads_bounces: reads_bounces(group), ..Properties::of(plan, &colors) };
        let space = if properties.is_radiance { WorkingSpace::Rec709 } else { self.access.space };
        Ok(Common {
            name: self.name.clone(),
            program,
            textures: self.textures.clone(),
            faults: self.faults.clone(),
            requests,
            properties,
            colors,
            map: ColorMap::to(space),
            live: self.live.clone(),
            needs: Needs {
                area,
                time,
                shutter,
                velocity,
                derivatives: needs.derivatives || has_changes,
                ..needs
            },
            scratch: Mutex::default(),
        })
    }

    /// Requests to meshes and instances: values of parameters, attributes with constant names, matrices.
    fn requests(&self, group: &Group) -> Vec<AttributeRequest> {
        let mut found: Vec<AttributeRequest> = Vec::new();
        let mut query = |name: &str, components: usize| {
            if components == 0 || components > 64 {
                return;
            }
            // No mesh has a value that is no number: then it has none.
            let default = vec![f32::NAN; components];
            if let Some(known) = found.iter_mut().find(|known| known.name == name) {
                if known.default.len() < components {
                    (known.components, known.default) = (components as u32, default);
                }
            } else {
                found.push(AttributeRequest {
                    name: name.to_owned(),
                    components: components as u32,
                    default,
                });
            }
        };
        let (mut spaces, mut area, mut parts, mut objects) = (false, false, false, false);
        for layer in &group.layers {
            let shader = &layer.shader;
            for (_, symbol) in shader.params().filter(|(id, _)| layer.interpolated(*id)) {
                if self.live.has(&symbol.name) {
                    continue;
                }
                if symbol.ty.base == Base::Int || symbol.ty.base.is_float_based() {
                    query(&symbol.name, symbol.ty.size());
                }
            }
            each_op(shader, &mut |op| {
                let text = |id: u32| match (shader.symbol(id).kind, &shader.symbol(id).value) {
                    (SymbolKind::Const, Some(Data::Str(list))) => list.first().map(|text| &**text),
                    _ => None,
                };
                let index = |id: u32| match (shader.symbol(id).kind, &shader.symbol(id).value) {
                    (SymbolKind::Const, Some(Data::Int(list))) => {
                        list.first().and_then(|&index| usize::try_from(index).ok())
                    }
                    _ => None,
                };
                match op.code {
                    Opcode::GetAttribute => {
                        let value = op.args.last().map(|&id| shader.symbol(id).ty);
                        let [_, names @ .., _] = &op.args[..] else { return };
                        let is_text = |id: &&u32| shader.symbol(**id).ty == Type::STRING;
                        let texts: Vec<Option<&str>> =
                            names.iter().filter(is_text).map(|&id| text(id)).collect();
                        let index = names.iter().find(|id| !is_text(id)).map(|&id| index(id));
                        // Other objects, by names that may be computed.
                        let is_other =
                            matches!(texts[..], [object, _] if !matches!(object, Some("" | "global")));
                        objects |= is_other;
                        parts |= is_other;
                        match (&texts[..], index) {
                            (&[] | &[.., None] | &[None, _, ..], _) => parts = true,
                            (&[.., Some(name)], _) if attributes::is_of_part(name) => parts = true,
                            (&[.., Some(name)], _)
                                if name.starts_with(CAMERA_PREFIX) || name.starts_with(PATH_PREFIX) => {}
                            (&[Some(name)] | &[Some(""), Some(name)], None) => {
                                query(name, value.map_or(0, Type::size));
                            }
                            (&[Some(name)] | &[Some(""), Some(name)], Some(Some(index))) => {
                                query(name, index + 1)
                            }
                            _ => {}
                        }
                    }
                    // Rays that are restricted to sets, by a name that may be computed.
                    Opcode::Trace => {
                        let is_set = |&id: &u32| matches!(text(id), Some("traceset"));
                        parts |= op.args.iter().any(is_set);
                    }
                    // Names of what a ray has hit.
                    Opcode::GetMessage => {
                        parts |= op.args.last().is_some_and(|&id| shader.symbol(id).ty == Type::STRING);
                    }
                    Opcode::Point
                    | Opcode::Vector
                    | Opcode::Normal
                    | Opcode::Matrix
                    | Opcode::GetMatrix
                    | Opcode::Transform
                    | Opcode::TransformV
                    | Opcode::TransformN => {
                        let names = op.args.iter().filter(|&&id| shader.symbol(id).ty == Type::STRING);
                        for &id in names {
                            spaces |= !matches!(text(id), Some("common" | "world" | "camera"));
                        }
                    }
                    Opcode::SurfaceArea => area = true,
                    _ => {}
                }
            });
        }
        let symbols = || group.layers.iter().flat_map(|layer| &layer.shader.symbols);
        let reads = |global: &str| {
            symbols().any(|symbol| symbol.kind == SymbolKind::Global && &*symbol.name == global)
        };
        for (global, attribute, components) in [
            ("time", AttributeRequest::TIME, 1),
            ("dtime", AttributeRequest::SHUTTER, 1),
            ("dPdtime", AttributeRequest::VELOCITY, 3),
        ] {
            if self.kind == Kind::Surface && reads(global) {
                query(attribute, components);
            }
        }
        if parts && matches!(self.kind, Kind::Surface | Kind::Pixel) {
            query(AttributeRequest::IDS, 4);
        }
        if objects && self.kind == Kind::Surface {
            query(AttributeRequest::OBJECTS, 1);
        }
        if area && self.kind == Kind::Surface {
            query(AttributeRequest::SURFACE_AREA, 1);
        }
        if spaces && self.kind == Kind::Surface {
            query(AttributeRequest::WORLD_FROM_OBJECT, 12);
        }
        found
    }
}

fn colors() -> Result<ColorSystem, String> {
    ColorSystem::named("Rec709").ok_or_else(|| "the colour system is missing".to_owned())
}
