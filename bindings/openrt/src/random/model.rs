// SPDX-License-Identifier: GPL-3.0-or-later
//! A model of the state machine, written from the specification: for random programs it gives the error and
//! the ids of each call, and the numbers of objects, triangles and instances.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::context::Context;
use crate::state::error::{Error, Result};
use crate::state::framebuffer::FrameMemory;
use proptest::prelude::*;

struct Nowhere;

impl FrameMemory for Nowhere {
    fn write(&self, _offset: usize, _bytes: &[u8]) {}
}

/// A call of a program; numbers are arguments.
#[derive(Clone, Copy, Debug)]
enum Call {
    Class(usize),
    BindClass(u32),
    NewShader,
    BindShader(u32),
    DeleteShader(u32),
    GenObjects(i32),
    NewObject(u32, u32),
    CreateObject(u32),
    EndObject,
    Instantiate(u32),
    RemoveObject(u32),
    DeleteInstance(u32),
    ClearInstances,
    Begin(u32),
    Vertices(u32),
    End,
    UseLight(u32),
    RemoveLight(u32),
    Start,
    Finish,
    SceneMode(u32),
    Push,
    Pop,
}

/// A surface and a light, and none.
const CLASSES: [(&std::ffi::CStr, Option<bool>); 3] =
    [(c"ConstantShader", Some(true)), (c"SpotLightShader", Some(false)), (c"none", None)];

/// Vertices that wait for more: mode, shader, how many.
type Waiting = Option<(u32, u32, u32)>;

/// Geometry in the making.
#[derive(Default)]
struct Assembly {
    waiting: Waiting,
    triangles: usize,
    vertices: usize,
}

#[derive(Default)]
struct Model {
    /// The classes loaded, by id - 1: surfaces or not.
    classes: Vec<bool>,
    bound_class: Option<u32>,
    bound_shader: Option<u32>,
    /// Class of every shader made.
    shaders: Vec<u32>,
    deleted: BTreeSet<u32>,
    last_object: u32,
    objects: BTreeSet<u32>,
    /// Vertices and triangles of defined objects.
    defined: BTreeMap<u32, (usize, usize)>,
    open: Option<(u32, u32, Assembly)>,
    unnamed: Assembly,
    /// Mode, vertices taken.
    block: Option<(u32, u32)>,
    last_instance: u32,
    instances: BTreeMap<u32, u32>,
    lights: Vec<u32>,
    immediate: bool,
    in_flight: bool,
    depth: u32,
}

const OPERATION: Error = Error::InvalidOperation;
const VALUE: Error = Error::InvalidValue;
const ENUM: Error = Error::InvalidEnum;

/// Triangles of a block of a mode that shares vertices, or of whole primitives of the others.
fn triangles(mode: u32, n: u32) -> u32 {
    match mode {
        0x100 => n / 3,
        0x103 => n / 4 * 2,
        0x104 => n.saturating_sub(2) / 2 * 2,
        _ => n.saturating_sub(2),
    }
}

fn independent(mode: u32) -> Option<u32> {
    match mode {
        0x100 => Some(3),
        0x103 => Some(4),
        _ => None,
    }
}

impl Model {
    fn outside(&self) -> Result<()> {
        if self.block.is_some() { Err(OPERATION) } else { Ok(()) }
    }

    fn no_object(&self) -> Result<()> {
        self.outside()?;
        if self.open.is_some() { Err(OPERATION) } else { Ok(()) }
    }

    fn shader(&self, id: u32) -> Option<u32> {
        let there = (1..=self.shaders.len() as u32).contains(&id) && !self.deleted.contains(&id);
        there.then(|| self.shaders[id as usize - 1])
    }

    /// Whether a class is of surfaces.
    fn is_surface(&self, class: u32) -> bool {
        self.classes[class as usize - 1]
    }

    fn bound_surface(&self) -> Option<u32> {
        self.bound_shader.filter(|_| self.bound_class.is_some_and(|class| self.is_surface(class)))
    }

    fn reserve(&mut self, count: u32) -> u32 {
        if self.last_object < 0x2FF && self.last_object + count >= 0x200 {
            self.last_object = 0x2FF;
        }
        let first = self.last_object + 1;
        self.last_object += count;
        self.objects.extend(first..first + count);
        first
    }

    fn add_instance(&mut self, object: u32) -> u32 {
        self.last_instance += 1;
        self.instances.insert(self.last_instance, object);
        self.last_instance
    }

    /// Closes the open object: an instance, if its mode makes one.
    fn close(&mut self) -> Result<Option<u32>> {
        let (id, mode, assembly) = self.open.take().ok_or(OPERATION)?;
        let known = self.defined.get(&id).map_or(0, |(vertices, _)| *vertices);
        if mode == 0x202 && assembly.vertices != known {
            return Err(OPERATION);
        }
        self.defined.insert(id, (assembly.vertices, assembly.triangles));
        Ok((mode == 0x201).then(|| self.add_instance(id)))
    }

    fn open_object(&mut self, id: u32, mode: u32) -> u32 {
        self.open = Some((id, mode, Assembly::default()));
        id
    }

    /// Makes a call; returns its id, or 0 if it has none.
    fn call(&mut self, call: Call) -> Result<u32> {
        match call {
            Call::Class(number) => {
                self.outside()?;
                let surface = CLASSES[number].1.ok_or(VALUE)?;
                let known = self.classes.iter().position(|&class| class == surface);
                let lattice_position = known.unwrap_or_else(|| {
                    self.classes.push(surface);
                    self.classes.len() - 1
                });
                (self.bound_class, self.bound_shader) = (Some(lattice_position as u32 + 1), None);
                return Ok(lattice_position as u32 + 1);
            }
            Call::BindClass(id) => {
                self.outside()?;
                if !(1..=self.classes.len() as u32).contains(&id) {
                    return Err(OPERATION);
                }
                (self.bound_class, self.bound_shader) = (Some(id), None);
            }
            Call::NewShader => {
                self.outside()?;
                self.shaders.push(self.bound_class.ok_or(OPERATION)?);
                self.bound_shader = Some(self.shaders.len() as u32);
                return Ok(self.shaders.len() as u32);
            }
            Call::BindShader(id) => {
                self.outside()?;
                self.bound_class = Some(self.shader(id).ok_or(OPERATION)?);
                self.bound_shader = Some(id);
            }
            Call::DeleteShader(id) => {
                self.outside()?;
                self.shader(id).ok_or(VALUE)?;
                self.deleted.insert(id);
                self.bound_shader = self.bound_shader.filter(|&bound| bound != id);
            }
            Call::GenObjects(count) => {
                self.no_object()?;
                let count = u32::try_from(count).ok().filter(|&n| n > 0).ok_or(VALUE)?;
                return Ok(self.reserve(count));
            }
            Call::NewObject(id, mode) => {
                self.no_object()?;
                (0x200..0x203).contains(&mode).then_some(()).ok_or(ENUM)?;
                self.objects.get(&id).ok_or(VALUE)?;
                return Ok(self.open_object(id, mode));
            }
            Call::CreateObject(mode) => {
                self.no_object()?;
                (0x200..0x203).contains(&mode).then_some(()).ok_or(ENUM)?;
                let id = self.reserve(1);
                return Ok(self.open_object(id, mode));
            }
            Call::EndObject => {
                self.outside()?;
                self.close()?;
            }
            Call::Instantiate(id) => {
                self.outside()?;
                match &self.open {
                    Some((open, ..)) if *open == id => {
                        let of_mode = self.close()?;
                        return Ok(of_mode.unwrap_or_else(|| self.add_instance(id)));
                    }
                    Some(_) => return Err(OPERATION),
                    None => self.objects.get(&id).ok_or(VALUE)?,
                };
                return Ok(self.add_instance(id));
            }
            Call::RemoveObject(id) => {
                self.no_object()?;
                self.objects.take(&id).ok_or(VALUE)?;
            }
            Call::DeleteInstance(id) => {
                self.outside()?;
                self.instances.remove(&id).ok_or(VALUE)?;
            }
            Call::ClearInstances => {
                self.outside()?;
                self.instances.clear();
            }
            Call::Begin(mode) => {
                self.outside()?;
                (0x100..0x106).contains(&mode).then_some(()).ok_or(ENUM)?;
                self.block = Some((mode, 0));
            }
            Call::Vertices(count) => {
                let surface = self.bound_surface();
                let (_, taken) = self.block.as_mut().ok_or(OPERATION)?;
                surface.ok_or(OPERATION)?;
                *taken += count;
                self.assembly().vertices += count as usize;
            }
            Call::End => {
                let (mode, n) = self.block.take().ok_or(OPERATION)?;
                let shader = self.bound_surface().unwrap_or(0);
                let assembly = self.assembly();
                match independent(mode) {
                    _ if n == 0 => {}
                    Some(size) if n < size => {
                        let before = assembly.waiting.filter(|w| (w.0, w.1) == (mode, shader));
                        let waiting = before.map_or(0, |w| w.2) + n;
                        assembly.triangles += triangles(mode, waiting) as usize;
                        assembly.waiting = Some((mode, shader, waiting % size));
                    }
                    _ => {
                        assembly.waiting = None;
                        assembly.triangles += triangles(mode, n) as usize;
                    }
                }
            }
            Call::UseLight(id) => {
                self.outside()?;
                let class = self.shader(id).ok_or(VALUE)?;
                if self.is_surface(class) || self.lights.contains(&id) {
                    return Err(OPERATION);
                }
                self.lights.push(id);
            }
            Call::RemoveLight(id) => {
                self.outside()?;
                let lattice_position = self.lights.iter().position(|&light| light == id).ok_or(VALUE)?;
                self.lights.remove(lattice_position);
            }
            Call::Start => {
                self.no_object()?;
                if std::mem::replace(&mut self.in_flight, true) {
                    return Err(OPERATION);
                }
                self.unnamed = Assembly::default();
                if self.immediate {
                    self.instances.clear();
                    self.lights.clear();
                }
            }
            Call::Finish => {
                self.no_object()?;
                if !std::mem::replace(&mut self.in_flight, false) {
                    return Err(OPERATION);
                }
            }
            Call::SceneMode(mode) => {
                self.outside()?;
                self.immediate = match mode {
                    0x600 => false,
                    0x601 => true,
                    _ => return Err(ENUM),
                };
            }
            Call::Push => {
                self.outside()?;
                self.depth += 1;
            }
            Call::Pop => {
                self.outside()?;
                self.depth = self.depth.checked_sub(1).ok_or(Error::StackUnderflow)?;
            }
        }
        Ok(0)
    }

    fn assembly(&mut self) -> &mut Assembly {
        self.open.as_mut().map_or(&mut self.unnamed, |(_, _, assembly)| assembly)
    }

    /// Objects, triangles, instances.
    fn counts(&self) -> [usize; 3] {
        let alive = || self.defined.iter().filter(|(id, _)| self.objects.contains(id));
        let triangles = alive().map(|(_, (_, triangles))| triangles).sum();
        [alive().count(), triangles, self.instances.len()]
    }
}

/// The same call on the library. `given` counts vertices, so that no two have the same position.
fn perform(context: &mut Context, call: Call, given: &mut u32) -> Result<u32> {
    let none = |outcome: Result<()>| outcome.map(|()| 0);
    match call {
        Call::Class(number) => context.gen_new_shader_class(Some(CLASSES[number].0), None),
        Call::BindClass(id) => none(context.bind_shader_class(id)),
        Call::NewShader => context.gen_new_shader(),
        Call::BindShader(id) => none(context.bind_shader(id)),
        Call::DeleteShader(id) => none(context.delete_shader(id)),
        Call::GenObjects(count) => context.gen_objects(count),
        Call::NewObject(id, mode) => context.new_object(id, mode),
        Call::CreateObject(mode) => context.create_object(mode),
        Call::EndObject => none(context.end_object()),
        Call::Instantiate(id) => context.instantiate_object(id),
        Call::RemoveObject(id) => none(context.remove_object(id)),
        Call::DeleteInstance(id) => none(context.delete_instance(id)),
        Call::ClearInstances => none(context.clear_instances()),
        Call::Begin(mode) => none(context.begin(mode)),
        Call::Vertices(count) => {
            for _ in 0..count {
                // On a twisted curve: no three points of it are on a line.
                *given += 1;
                let k = f64::from(*given) / 64.0;
                none(context.vertex([k, k * k, k * k * k, 1.0]))?;
            }
            Ok(0)
        }
        Call::End => none(context.end()),
        Call::UseLight(id) => none(context.use_light(id)),
        Call::RemoveLight(id) => none(context.remove_light(id)),
        Call::Start => none(context.start_rendering()),
        Call::Finish => none(context.end_rendering()),
        Call::SceneMode(mode) => none(context.set_scene_mode(mode)),
        Call::Push => none(context.push_matrix()),
        Call::Pop => none(context.pop_matrix()),
    }
}

fn calls() -> impl Strategy<Value = Vec<Call>> {
    let id = || 0_u32..6;
    let block = (0x100_u32..0x106, 1_u32..9)
        .prop_map(|(mode, n)| vec![Call::Begin(mode), Call::Vertices(n), Call::End]);
    let single = prop_oneof![
        (0..CLASSES.len()).prop_map(Call::Class),
        id().prop_map(Call::BindClass),
        Just(Call::NewShader),
        id().prop_map(Call::BindShader),
        (0_u32..12).prop_map(Call::DeleteShader),
        (-1..300).prop_map(Call::GenObjects),
        (id(), 0x1FF_u32..0x204).prop_map(|(id, mode)| Call::NewObject(id, mode)),
        (0x1FF_u32..0x204).prop_map(Call::CreateObject),
        Just(Call::EndObject),
        id().prop_map(Call::Instantiate),
        id().prop_map(Call::RemoveObject),
        id().prop_map(Call::DeleteInstance),
        Just(Call::ClearInstances),
        (0xFF_u32..0x107).prop_map(Call::Begin),
        (1_u32..9).prop_map(Call::Vertices),
        Just(Call::End),
        id().prop_map(Call::UseLight),
        id().prop_map(Call::RemoveLight),
        Just(Call::Start),
        Just(Call::Finish),
        (0x600_u32..0x603).prop_map(Call::SceneMode),
        Just(Call::Push),
        Just(Call::Pop),
    ];
    let step = prop_oneof![3 => single.prop_map(|call| vec![call]), 2 => block];
    prop::collection::vec(step, 1..60).prop_map(|steps| {
        // A shader to begin with, or most programs would only fail.
        let start = [Call::Class(1), Call::NewShader, Call::Class(0), Call::NewShader];
        start.into_iter().chain(steps.concat()).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn does_what_the_model_says(calls in calls()) {
        let mut context = Context::with_arguments([&b"--rt-threads=1"[..]].into_iter());
        context.set_frame_buffer(Some(Arc::new(Nowhere)), [2, 2], 0x310).expect("a good buffer");
        let (mut model, mut given) = (Model::default(), 0);
        for (step, &call) in calls.iter().enumerate() {
            let (expected, outcome) = (model.call(call), perform(&mut context, call, &mut given));
            prop_assert_eq!(outcome, expected, "call {}, {:?}", step, call);
            let mut counts = Vec::new();
            for name in 0x0700..0x0703 {
                let _ = context.get_integers(name, Some(&mut |numbers| counts.extend_from_slice(numbers)));
            }
            if model.block.is_none() {
                let counts: Vec<usize> = counts.iter().map(|&count| count as usize).collect();
                prop_assert_eq!(&counts[..], &model.counts()[..], "objects, triangles, instances after call {}", step);
            }
        }
        let _ = context.end();
        prop_assert_eq!(context.exit(), Ok(()), "a program may always leave");
    }
}
