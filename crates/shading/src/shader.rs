// SPDX-License-Identifier: GPL-3.0-or-later
//! Traits of shaders, and the services that they may use: the interface between renderer, materials, OpenRT
//! classes and plugins.
//! Source: \[DWBS03\] (shader kinds); \[SIP06\], section 8 (no ray-by-ray prototypes); the batch form is
//! original. All calls take whole batches; implementations hold no mutable state and are called from many
//! threads at once.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};

use crate::batch::{RayKind, SampleKey, SurfaceBatch, Vec3s};
use crate::bsdf::ClosureBatch;
use crate::camera_projection::CameraProjection;

/// A value that a shader requests for each hit from its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct AttributeRequest {
    /// Name of the mesh's attribute.
    pub name: String,
    /// Floats per value.
    pub components: u32,
    /// Used where the mesh has no such attribute; `components` floats.
    pub default: Vec<f32>,
}

impl AttributeRequest {
    /// The name of the instance attribute with the transform from object to world: 12 floats, the images of
    /// the x, y and z axes, then of the origin.
    pub const WORLD_FROM_OBJECT: &'static str = "gnurt:world_from_object";

    /// The name of the meshes' area with their transform, world units squared: one float. As they are when
    /// the shutter opens.
    pub const SURFACE_AREA: &'static str = "gnurt:surface_area";

    /// The name of the time of the ray, from 0 to 1 during an open shutter: one float. 0 where nothing moves.
    pub const TIME: &'static str = "gnurt:time";

    /// The name of the length of the open shutter, in the unit of [`TIME`](Self::TIME): one float. 1 where something
    /// moves, 0 elsewhere.
    pub const SHUTTER: &'static str = "gnurt:shutter";

    /// The name of the velocity of the surface's point at the time of the ray: three floats, world units per open
    /// shutter.
    pub const VELOCITY: &'static str = "gnurt:velocity";

    /// A request by this name, beside one for [`IDS`](Self::IDS), fills `SceneNames::object_of` and `SceneNames::constants`, too: one
    /// float without a meaning.
    pub const OBJECTS: &'static str = "gnurt:objects";

    /// What the name of a gradient begins with, before the name of an attribute: how each of its components changes with the
    /// place on the surface, three floats for each, in world space and per world unit. They are along the plane of the
    /// triangle; 0 where the mesh lacks the attribute, or has it by triangles. `Cd` is the colour of vertices if no attribute
    /// has that name.
    pub const GRADIENT: &'static str = "gnurt:gradient:";

    /// The name of the numbers of instance, object, material and primitive: four floats with the bits of these
    /// integers. A request for them also fills `SurfaceBatch::names`, and lets rays be restricted to sets.
    pub const IDS: &'static str = "gnurt:ids";
}

/// The form of a value that a shader puts out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum OutputKind {
    /// A number; all three components have it.
    Number,
    /// A vector, a point or a normal.
    Vector,
    /// A colour.
    Color,
}

/// A value that a surface puts out for layers of pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderOutput {
    /// Its name in the shader.
    pub name: String,
    /// Its form.
    pub kind: OutputKind,
}

/// A surface: the scattering of its points.
pub trait SurfaceShader: Send + Sync {
    /// Writes the closure of each point; `out` has `hits.len()` points without lobes. Nothing else is known
    /// of a surface, except for one with [`radiance`](Self::radiance).
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let _ = (hits, out);
    }

    /// The same for a surface that queries distances and hits of rays, which then determine its closures. Where no tracer is at hand, as
    /// where surfaces are sampled as lights, [`evaluate`](Self::evaluate) takes its place: rays hit nothing.
    fn evaluate_traced(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let _ = tracer;
        self.evaluate(hits, out);
    }

    /// Itself, if it computes its radiance by its own rays and loops over lights, as shaders of OpenRT do.
    /// Integrators that scatter light themselves treat that as emission, in addition to its own emission, and
    /// end there.
    fn radiance(&self) -> Option<&dyn RadianceShader> {
        None
    }

    /// Whether [`evaluate`](Self::evaluate) may return emission: such surfaces are lights, sampled by
    /// evaluating it.
    fn emits(&self) -> bool {
        false
    }

    /// The radiance that its front and its back emit, if that is the same at all points, in all directions and for all rays: such
    /// lights are sampled without evaluating it.
    fn even_emission(&self) -> Option<[Vec3; 2]> {
        None
    }

    /// Writes the share of light that goes straight through; `out` has `hits.len()` lanes, all zero.
    /// Called only if [`is_opaque`](Self::is_opaque) is false.
    fn transmit(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let _ = (tracer, hits, out);
    }

    /// Whether it lets no light straight through anywhere.
    fn is_opaque(&self) -> bool {
        true
    }

    /// Writes the share of light that passes without hitting the surface: transparent parts. For integrators
    /// that scatter light themselves: they find light through glass by scattered rays, and must not count it
    /// here as well. `out` has `hits.len()` lanes, all zero; called only if [`is_solid`](Self::is_solid) is
    /// false.
    fn gaps(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.transmit(tracer, hits, out);
    }

    /// Whether it has no transparent parts; smooth glass counts as none.
    fn is_solid(&self) -> bool {
        self.is_opaque()
    }

    /// Whether some point may have absorption on one of its sides ([`ClosureBatch::fill`]). If no surface
    /// does, paths skip absorption.
    fn has_medium(&self) -> bool {
        false
    }

    /// Whether some point may leave a hole in the picture ([`ClosureBatch::hold_out`]).
    fn has_holes(&self) -> bool {
        false
    }

    /// The medium behind it, if that is the same at all points: only then can it scatter light.
    fn interior(&self) -> Option<Interior> {
        None
    }

    /// Whether some point may be smooth glass or tinted transparency: light samples search for lights only
    /// through such surfaces.
    fn is_clear(&self) -> bool {
        !self.is_opaque() && self.radiance().is_none()
    }

    /// Writes the share of light that the surface scatters, for previews and denoisers; `out` has `hits.len()` lanes of
    /// mid-grey.
    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        let _ = (hits, out);
    }

    /// The background, for a shadow catcher: a Lambertian reflector that shows just that under all light of
    /// the environment, and shadow elsewhere. In pictures with opacity, its opacity is the relative
    /// darkening.
    fn backdrop(&self) -> Option<Vec3> {
        None
    }

    /// The inner values at one point, a line for each, for debugging.
    fn describe(&self, hits: &SurfaceBatch, lane: usize) -> Vec<String> {
        let _ = (hits, lane);
        Vec::new()
    }

    /// The values that it puts out for layers of pictures.
    fn outputs(&self) -> &[ShaderOutput] {
        &[]
    }

    /// Writes one of [`outputs`](Self::outputs); `out` has `hits.len()` lanes, all zero, and stays so for other names.
    fn output(&self, name: &str, hits: &SurfaceBatch, out: &mut Vec3s) {
        let _ = (name, hits, out);
    }

    /// The requested mesh attributes, in the order of `SurfaceBatch::attributes`.
    fn attributes(&self) -> &[AttributeRequest] {
        &[]
    }
}

/// A surface's displacement, evaluated once at each vertex when a scene is committed.
pub trait DisplacementShader: Send + Sync {
    /// Writes the offset of each point; `out` has `points.len()` lanes, all zero. Space: object, of points, normals and offsets.
    /// `ns` and `ng` are the normal that the vertices of a position share, and `ray_dir` is against it. Footprints are 0.
    fn displace(&self, points: &SurfaceBatch, out: &mut Vec3s);

    /// The requested mesh attributes, in the order of `SurfaceBatch::attributes`.
    fn attributes(&self) -> &[AttributeRequest] {
        &[]
    }

    /// Reports of its runs, each once.
    fn faults(&self) -> Vec<String> {
        Vec::new()
    }
}

/// An even medium behind a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Interior {
    /// Absorption coefficient, 1 over world units, >= 0.
    pub absorption: Vec3,
    /// Scattering coefficient, 1 over world units, >= 0.
    pub scattering: Vec3,
    /// Mean cosine of scattered light, in (-1, 1).
    pub anisotropy: f32,
}

/// A surface that computes its radiance itself.
pub trait RadianceShader: Send + Sync {
    /// Writes the radiance that leaves each point against its ray; `out` has `hits.len()` lanes, all zero.
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s);
}

/// Light arriving at points.
#[derive(Clone, Debug, Default)]
pub struct LightBatch {
    /// Unit directions towards the light.
    pub dir: Vec3s,
    /// Distances to it, world units; infinite for lights without a position.
    pub dist: Vec<f32>,
    /// Unoccluded irradiance at a surface that faces `dir`, divided by the probability of choosing `dir`.
    /// Zero = this light does not reach the point.
    pub radiance: Vec3s,
    /// That probability as a density over solid angle, 1/sr: `radiance * pdf` is radiance out of `dir`. Zero where the
    /// light has one direction only, so that there is no density: points, directions, virtual lights.
    pub pdf: Vec<f32>,
}

impl LightBatch {
    /// Makes it `n` lanes, unlit, and keeps the memory.
    pub fn reset(&mut self, n: usize) {
        self.dir.reset(n, Vec3::Z);
        self.dist.clear();
        self.dist.resize(n, f32::INFINITY);
        self.radiance.reset(n, Vec3::ZERO);
        self.pdf.clear();
        self.pdf.resize(n, 0.0);
    }
}

/// A light.
pub trait LightShader: Send + Sync {
    /// Chooses a direction to this light from each point. `normal` faces the ray and may be used to choose well;
    /// `random` holds two numbers in [0, 1) per point. `out` has `p.len()` lanes, unlit.
    fn illuminate(&self, p: &Vec3s, normal: &Vec3s, random: &[[f32; 2]], out: &mut LightBatch);

    /// Whether surfaces or misses show this light too, so that rays that a mirror sends may meet it.
    fn is_visible(&self) -> bool {
        false
    }
}

/// The random numbers and positions of camera rays, ray by ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraSamples<'a> {
    /// Where they go through the picture: both in [0, 1], (0, 0) = lower left corner, y upwards.
    pub positions: &'a [[f32; 2]],
    /// Where they go through the lens, each two numbers in [0, 1), uniform for light that falls on all of it alike; empty = through
    /// its middle.
    pub lens: &'a [[f32; 2]],
    /// When they do within the time that the shutter is open, from 0 to 1; empty = in its middle.
    pub times: &'a [f32],
}

impl<'a> CameraSamples<'a> {
    /// Rays through the middle of the lens, in the middle of the time.
    #[must_use]
    pub fn sharp(positions: &'a [[f32; 2]]) -> Self {
        Self { positions, ..Self::default() }
    }

    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Where ray `i` goes through the lens; [0.5, 0.5] is its middle.
    #[must_use]
    pub fn lens(&self, i: usize) -> [f32; 2] {
        self.lens.get(i).copied().unwrap_or([0.5; 2])
    }

    /// The length of the open shutter in the unit of [`time`](Self::time): 1, or 0 if rays have no times.
    #[must_use]
    pub fn duration(&self) -> f32 {
        if self.times.is_empty() { 0.0 } else { 1.0 }
    }

    /// When ray `i` does.
    #[must_use]
    pub fn time(&self, i: usize) -> f32 {
        self.times.get(i).copied().unwrap_or(0.5)
    }
}

/// A camera.
pub trait CameraShader: Send + Sync {
    /// Appends one ray for each of `samples`. Directions are unit, or zero for a ray that sees nothing. `aspect` = width / height.
    fn rays(&self, samples: &CameraSamples, aspect: f32, out: &mut RayBatch);

    /// Whether its rays depend on the position on the lens: if not, no numbers are drawn for that.
    fn has_lens(&self) -> bool {
        false
    }

    /// How it projects, in the middle of the open shutter; `None` if its rays follow another rule.
    fn projection(&self) -> Option<CameraProjection> {
        None
    }

    /// The position of the point `p` of the world in a sharp picture, (0, 0) = lower left corner, (1, 1) =
    /// upper right one; positions outside are those in a larger picture. `None` if it is invisible, or if the
    /// camera has no inverse: pictures of a camera in motion reuse earlier ones only with an inverse.
    fn project(&self, p: Vec3, aspect: f32) -> Option<[f32; 2]> {
        let _ = (p, aspect);
        None
    }
}

/// Samples of pixels: camera rays, and the radiance along them.
#[derive(Clone, Copy)]
pub struct PixelSamples<'a> {
    /// The rays; a direction of zero sees nothing.
    pub rays: &'a RayBatch,
    /// The same a pixel to the right, and a pixel below.
    pub neighbours: [&'a RayBatch; 2],
    /// Position in the picture and on the lens, and time.
    pub camera: CameraSamples<'a>,
    /// Columns and rows of the picture.
    pub size: [u32; 2],
    /// How the camera projects; `None` if its rays follow another rule.
    pub projection: Option<CameraProjection>,
    /// Keys of their random numbers.
    pub keys: &'a [SampleKey],
    /// The radiance against each ray, as the integrator found it.
    pub radiance: &'a Vec3s,
    /// How far each went, world units; infinite where it met nothing.
    pub distances: &'a [f32],
}

/// A function of pixels: the last step between the radiance of camera rays and the picture.
pub trait PixelShader: Send + Sync {
    /// Whether it restricts rays to sets of objects.
    fn needs_names(&self) -> bool {
        false
    }

    /// Writes the colour of each sample in place of its radiance; `out` has a lane for each ray, all zero.
    /// Rays that it requests from `tracer` are rays of the camera: `trace` takes a sample of the integrator
    /// along each.
    fn show(&self, tracer: &mut dyn Tracer, samples: &PixelSamples, out: &mut Vec3s);
}

/// Radiance of rays that hit nothing.
pub trait EnvironmentShader: Send + Sync {
    /// Writes the radiance that comes against each direction (unit, world); `out` has `dir.len()` lanes.
    fn miss(&self, dir: &Vec3s, out: &mut Vec3s);
}

/// Rays that a shader requests.
#[derive(Clone, Debug, Default)]
pub struct RayRequest {
    /// The rays; directions are unit, near ends already away from the surface.
    pub rays: RayBatch,
    /// Which lane of the shader's batch each ray serves.
    pub parent: Vec<u32>,
    /// Keys of the rays' random numbers.
    pub key: Vec<SampleKey>,
    /// Widths of the rays' cones where they begin, world units; empty = all 0. Mirrored and straight rays begin as wide
    /// as the point that sends them.
    pub width: Vec<f32>,
    /// Their kinds; empty = all are mirrored, or sent by a shader that follows them itself.
    pub kinds: Vec<RayKind>,
    /// The set that they may hit, as of [`SceneNames::may_hit`](crate::SceneNames::may_hit); `None` = all. `occluded` does
    /// not read it.
    pub set: Option<Arc<str>>,
}

impl RayRequest {
    /// Adds a ray, for a lane of the shader's batch.
    pub fn push(&mut self, ray: Ray, parent: usize, key: SampleKey) {
        self.rays.push(ray);
        self.parent.push(parent as u32);
        self.key.push(key);
    }

    /// Removes all rays.
    pub fn clear(&mut self) {
        let Self { rays, parent, key, width, kinds, set } = self;
        rays.clear();
        parent.clear();
        key.clear();
        width.clear();
        kinds.clear();
        *set = None;
    }
}

/// The first hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// How far away, world units.
    pub t: f32,
    /// Where, world.
    pub p: Vec3,
    /// Unit geometric normal; it faces the ray.
    pub ng: Vec3,
    /// Unit shading normal; it faces the ray.
    pub ns: Vec3,
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// Share of light that is scattered there.
    pub albedo: Vec3,
    /// Whether the ray met the side that the mesh's normal points away from.
    pub back: bool,
    /// Numbers of instance, object, material and triangle.
    pub ids: [u32; 4],
}

/// Services of the renderer for shaders.
pub trait Tracer {
    /// Lights of the scene.
    fn light_count(&self) -> usize;

    /// Whether rays may meet light `light` where they end, so that a shader that traces a reflection must not add it.
    fn light_is_visible(&self, light: usize) -> bool {
        let _ = light;
        false
    }

    /// Queries light `light` for all points of `hits` (facing shading normals are used); `out` is reset
    /// first.
    fn illuminate(&mut self, light: usize, hits: &SurfaceBatch, out: &mut LightBatch);

    /// The same for the lights of a category only: a name or a group of lights, or all others if `-` is before it. The empty
    /// category means all. The default has no categories.
    fn illuminate_in(&mut self, category: &str, light: usize, hits: &SurfaceBatch, out: &mut LightBatch) {
        match category.is_empty() {
            true => self.illuminate(light, hits, out),
            false => out.reset(hits.len()),
        }
    }

    /// Writes for each ray the transmittance between its near and far end: 1 = unoccluded.
    fn occluded(&mut self, request: &RayRequest, transmittance: &mut Vec3s);

    /// Writes the radiance that comes against each ray, one bounce deeper than `hits` was.
    /// Beyond the depth limit the environment is seen.
    fn trace(&mut self, depth: u32, request: &RayRequest, radiance: &mut Vec3s);

    /// Writes the distance of each ray to the first surface, transparent ones included: world units, infinite
    /// if there is none. The default finds nothing.
    fn distances(&mut self, request: &RayRequest, out: &mut Vec<f32>) {
        out.clear();
        out.resize(request.rays.len(), f32::INFINITY);
    }

    /// Writes the first hit of each ray; the default finds none.
    fn meet(&mut self, request: &RayRequest, out: &mut Vec<Option<SurfaceHit>>) {
        out.clear();
        out.resize(request.rays.len(), None);
    }

    /// Two stratified random numbers in [0, 1) for a lane's key and a purpose below [`purpose::LIGHT`].
    ///
    /// [`purpose::LIGHT`]: crate::sampling::purpose::LIGHT
    fn random(&self, key: SampleKey, depth: u32, purpose: u32) -> [f32; 2];
}
