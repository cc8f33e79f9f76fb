// SPDX-License-Identifier: GPL-3.0-or-later
//! The part of `openrt/rts.h` that a surface needs, and safe names for it: implement [`Surface`], then `module!(Type)`.
//!
//! Invariants: structures are those of the header, member for member; slices have as many lanes as the batch. Panics abort
//! (build with `panic = "abort"`): none may cross to the host.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::marker::PhantomData;

/// Version of the interface.
pub const ABI: u32 = 0x0001_0000;
const SURFACE: u32 = 0x400;
const FLOAT: u32 = 0x1406;

/// How often a parameter changes.
#[repr(u32)]
#[derive(Clone, Copy)]
#[allow(dead_code, reason = "this plugin does not use all of them")]
pub enum Rate {
    Shader = 0x500,
    Vertex = 0x501,
    Triangle = 0x502,
}

/// `RTSparam`.
#[repr(C)]
pub struct Parameter {
    name: *const c_char,
    kind: u32,
    count: u32,
    rate: u32,
    offset: u32,
}

// SAFETY: it is constant, and so are its targets.
unsafe impl Sync for Parameter {}

impl Parameter {
    /// `count` floats at `offset` of the block of their rate.
    pub const fn floats(name: &'static CStr, count: u32, rate: Rate, offset: usize) -> Self {
        Self { name: name.as_ptr(), kind: FLOAT, count, rate: rate as u32, offset: offset as u32 }
    }
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct Vectors {
    x: *const f32,
    y: *const f32,
    z: *const f32,
}

#[repr(C)]
#[derive(Clone, Copy)]
pub struct VectorsOut {
    x: *mut f32,
    y: *mut f32,
    z: *mut f32,
}

/// `RTShits`.
#[repr(C)]
pub struct Hits {
    struct_size: u32,
    n: u32,
    shader: *const c_void,
    p: Vectors,
    ng: Vectors,
    ns: Vectors,
    ray_dir: Vectors,
    t: *const f32,
    b1: *const f32,
    b2: *const f32,
    color: Vectors,
    texcoord: Vectors,
    alpha: *const f32,
    object: *const u32,
    instance: *const u32,
    triangle: *const u32,
    depth: *const u32,
    back: *const u8,
}

type Ctx = *mut c_void;

/// `RTShost`, as far as this wrapper uses it.
#[repr(C)]
pub struct Host {
    struct_size: u32,
    abi: u32,
    param: unsafe extern "C" fn(Ctx, *const Hits, u32, *mut f32),
    light_count: unsafe extern "C" fn(Ctx) -> u32,
    others: [*const c_void; 6],
}

type ShadeFn = unsafe extern "C" fn(*const Host, Ctx, *const Hits, VectorsOut);

/// `RTSclass`.
#[repr(C)]
pub struct Class {
    struct_size: u32,
    kind: u32,
    flags: u32,
    name: *const c_char,
    shader_size: u32,
    shader_align: u32,
    triangle_size: u32,
    vertex_size: u32,
    param_count: u32,
    params: *const Parameter,
    init: Option<unsafe extern "C" fn(*mut c_void)>,
    fini: Option<unsafe extern "C" fn(*mut c_void)>,
    prepare: Option<unsafe extern "C" fn(*const Host, *mut c_void) -> c_int>,
    shade: Option<ShadeFn>,
    others: [*const c_void; 4],
}

// SAFETY: it is constant, and so are its targets.
unsafe impl Sync for Class {}

/// `RTSmodule`.
#[repr(C)]
pub struct Module {
    pub struct_size: u32,
    pub abi: u32,
    pub class_count: u32,
    pub classes: *const &'static Class,
}

// SAFETY: it is constant, and so are its targets.
unsafe impl Sync for Module {}

/// A surface: the type is its block per shader.
pub trait Surface: Copy + Sync + 'static {
    /// Name of the class.
    const NAME: &'static CStr;
    /// Its parameters.
    const PARAMETERS: &'static [Parameter];
    /// The block of a new shader.
    const DEFAULT: Self;
    /// Bytes of the block per triangle.
    const TRIANGLE_SIZE: u32 = 0;
    /// Bytes of the block per vertex.
    const VERTEX_SIZE: u32 = 0;

    /// Writes the radiance that leaves each point, channel by channel.
    fn shade(&self, batch: &Batch<'_>, out: [&mut [f32]; 3]);
}

/// The points of a call and their queries.
pub struct Batch<'a> {
    host: &'a Host,
    ctx: Ctx,
    hits: &'a Hits,
    parameters: &'static [Parameter],
    /// Contexts belong to one thread.
    _not_sync: PhantomData<*mut ()>,
}

#[allow(dead_code, reason = "this plugin does not use all of them")]
impl Batch<'_> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.hits.n as usize
    }

    fn slices(&self, v: Vectors) -> [&[f32]; 3] {
        // SAFETY: the host gives as many floats as there are points, for as long as the call lasts.
        [v.x, v.y, v.z].map(|array| unsafe { std::slice::from_raw_parts(array, self.len()) })
    }

    /// Points, world.
    pub fn points(&self) -> [&[f32]; 3] {
        self.slices(self.hits.p)
    }

    /// Unit shading normals, not turned towards the ray.
    pub fn shading_normals(&self) -> [&[f32]; 3] {
        self.slices(self.hits.ns)
    }

    /// Unit directions of the rays that came here.
    pub fn directions(&self) -> [&[f32]; 3] {
        self.slices(self.hits.ray_dir)
    }

    /// s, t and 0.
    pub fn texture_coordinates(&self) -> [&[f32]; 3] {
        self.slices(self.hits.texcoord)
    }

    /// Lights of the scene.
    pub fn light_count(&self) -> u32 {
        // SAFETY: host and context are those of this call.
        unsafe { (self.host.light_count)(self.ctx) }
    }

    /// Writes parameter `index`: component k of point i to `out[k * len + i]`. Panics if there is no such parameter or
    /// `out` is too short.
    pub fn parameter(&self, index: usize, out: &mut [f32]) {
        let count = self.parameters[index].count as usize;
        assert!(out.len() >= count * self.len(), "one float per component and point");
        // SAFETY: `out` has room for all components.
        unsafe { (self.host.param)(self.ctx, self.hits, index as u32, out.as_mut_ptr()) }
    }
}

/// # Safety
/// `block` is a block of `S`.
unsafe extern "C" fn init<S: Surface>(block: *mut c_void) {
    // SAFETY: the host gives a block of the size and alignment that the class states.
    unsafe { block.cast::<S>().write(S::DEFAULT) }
}

/// # Safety
/// By rts.h for `shade`.
unsafe extern "C" fn shade<S: Surface>(host: *const Host, ctx: Ctx, hits: *const Hits, out: VectorsOut) {
    // SAFETY: the host vouches for both.
    let (host, hits) = unsafe { (&*host, &*hits) };
    // SAFETY: the block is a copy of one that `init` wrote, with parameters that are floats.
    let surface = unsafe { *hits.shader.cast::<S>() };
    let batch = Batch { host, ctx, hits, parameters: S::PARAMETERS, _not_sync: PhantomData };
    // SAFETY: three arrays with space for all points, without other writers.
    let out = [out.x, out.y, out.z].map(|array| unsafe { std::slice::from_raw_parts_mut(array, batch.len()) });
    surface.shade(&batch, out);
}

impl Class {
    /// The class of a surface.
    pub const fn of<S: Surface>() -> Self {
        Self {
            struct_size: size_of::<Self>() as u32,
            kind: SURFACE,
            flags: 0,
            name: S::NAME.as_ptr(),
            shader_size: size_of::<S>() as u32,
            shader_align: align_of::<S>() as u32,
            triangle_size: S::TRIANGLE_SIZE,
            vertex_size: S::VERTEX_SIZE,
            param_count: S::PARAMETERS.len() as u32,
            params: S::PARAMETERS.as_ptr(),
            init: Some(init::<S>),
            fini: None,
            prepare: None,
            shade: Some(shade::<S>),
            others: [std::ptr::null(); 4],
        }
    }
}

/// Exports these surfaces.
macro_rules! module {
    ($($surface:ty),+) => {
        #[expect(unsafe_code, reason = "the symbol that hosts look for")]
        const _: () = {
            use $crate::ffi::{ABI, Class, Module};
            static CLASSES: &[&Class] = &[$(&const { Class::of::<$surface>() }),+];
            static MODULE: Module = Module {
                struct_size: size_of::<Module>() as u32,
                abi: ABI,
                class_count: CLASSES.len() as u32,
                classes: CLASSES.as_ptr(),
            };

            #[unsafe(no_mangle)]
            extern "C" fn rts_module(host_abi: u32) -> Option<&'static Module> {
                (host_abi >> 16 == ABI >> 16).then_some(&MODULE)
            }
        };
    };
}
pub(crate) use module;
