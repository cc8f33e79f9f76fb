// SPDX-License-Identifier: GPL-3.0-or-later
//! The renderer's side of shading: batches of rays in, batches of radiance out, by recursion.
//! Source: [Whi80] (recursion); batches by shader after the paper's section 8. Space: world.
//! Flow: rays -> hits -> lanes sorted by shader -> surface points -> shader, which may query lights and more
//! rays.
//! Invariant: the result of a lane depends on its ray and key only.
//! Tests: crates/render/tests/{lights,mirrors,appearance,determinism}.rs.

use std::ops::Range;
use std::sync::{Arc, OnceLock};

use glam::Vec3;
use gnurt_accel::{Coherence, HitBatch, Pencil, Query, RayBatch, Record};
use gnurt_scene::RayMask;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::materials::recursive_radiance;
use gnurt_shading::{
    CameraProperties, Detail, EnvironmentShader, LightBatch, RayRequest, SampleKey, SurfaceBatch,
    SurfaceShader, Vec3s,
};

use crate::behind::Behind;
use crate::camera_batch::CameraBatch;
use crate::cone::Cone;
use crate::cost::TileCosts;
use crate::guide::Guide;
use crate::held::Held;
use crate::log::Log;
use crate::options::{Integrator, RenderOptions};
use crate::pixel_order::PixelOrder;
use crate::seen::SeenLight;
use crate::stats::RenderStats;
use crate::transport::manifold::{Caustics, Searched};
use crate::transport::{Blockers, Through, Wavefront};
use crate::world::{HitLanes, World};

/// Albedo of surfaces that do not return theirs.
pub(crate) const MID_GREY: Vec3 = Vec3::splat(0.5);

/// Lights that shaders which loop over lights meet behind those of the world: virtual ones.
pub(crate) trait FurtherLights: Sync {
    /// How many.
    fn count(&self, tracer: &BatchTracer) -> usize;

    /// Light of light `number` at points.
    fn illuminate(
        &self,
        tracer: &mut BatchTracer,
        number: usize,
        points: &SurfaceBatch,
        out: &mut LightBatch,
    );
}

/// How pixels share virtual lights out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sharing {
    /// No sharing: each uses all of them.
    All,
    /// Each by its position in a pattern, which is in its key's sample.
    Pattern,
    /// Each sample by chance: its key's pixel.
    Random,
}

/// Traces for one tile at a time.
pub(crate) struct BatchTracer<'w> {
    pub(crate) world: &'w World,
    pub(crate) options: &'w RenderOptions,
    pub(crate) stats: RenderStats,
    /// Cost per pixel of the tile, if a heat map is requested.
    pub(crate) costs: Option<TileCosts>,
    /// Events along the paths, if a log is requested.
    pub(crate) log: Option<Log>,
    /// Lights for shaders in addition to those of the world.
    pub(crate) lights: Option<&'w dyn FurtherLights>,
    /// Whether radiance-only shaders are probed for their scattering, in place of their radiance.
    pub(crate) probes: bool,
    /// Where light comes from, if paths are guided.
    pub(crate) guide: Option<&'w Guide>,
    /// The same for samples from a number on.
    pub(crate) guide_from: Option<(&'w Guide, u32)>,
    /// Smooth surfaces and lamps of searches, if paths make them.
    pub(crate) caustics: Option<&'w Caustics>,
    /// The searches that were made, if a pilot learns from them.
    pub(crate) searched: Option<Vec<Searched>>,
    /// How pixels share virtual lights out.
    pub(crate) sharing: Sharing,
    /// Keys of samples.
    pub(crate) pixel_order: PixelOrder,
    /// The footprint of a pixel.
    pub(crate) cone: Cone,
    /// The camera as shaders query it.
    pub(crate) properties: Option<CameraProperties>,
    record: Record,
    /// Directly visible light, lane by lane; empty if it is not requested, or if the integrator does not
    /// provide it.
    pub(crate) direct: Vec3s,
    /// Light by scatterings, for the layers of denoisers; empty if it is not requested, or not known.
    pub(crate) seen: SeenLight,
    /// Whether camera rays meet other instances than scattered rays do, once it is known.
    pub(crate) differs_for_camera: Arc<OnceLock<bool>>,
    /// What lanes of the camera see of the background; empty if the integrator does not note it.
    pub(crate) behind: Vec<Behind>,
    /// What lanes of the camera see of holes; empty if the world has none.
    pub(crate) held: Vec<Held>,
    /// Memory of batches, for the next ones; shaders that trace need more than one at a time.
    spare: Vec<Group>,
    /// Reused memory of the camera rays.
    pub(crate) camera: CameraBatch,
    /// And of paths.
    pub(crate) wavefront: Wavefront,
    /// And of closures.
    pub(crate) closures: ClosureBatch,
    /// Radiance without light at the points of the last probed shader.
    pub(crate) dark: Vec3s,
    /// Coherence of adjacent shadow rays.
    pub(crate) shadows: Coherence,
    /// And of the hits of shadow rays.
    blocked: Vec<bool>,
    /// Rays with their times, if the shutter is open.
    timed: RayBatch,
}

/// The attributes that the points of a batch need.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AttributeRequests {
    /// All that shaders can do.
    Light,
    /// Base colours, positions and normals.
    Sides,
}

/// Memory of a batch of points.
#[derive(Default)]
struct Group {
    /// Lanes that hit something, in order of materials: material in the upper half, lane in the lower one.
    order: Vec<u64>,
    lanes: Vec<u32>,
    points: SurfaceBatch,
}

impl<'w> BatchTracer<'w> {
    /// A tracer that can note the cost of each ray, or not.
    pub(crate) fn new(world: &'w World, options: &'w RenderOptions, costs: bool) -> Self {
        let record = if costs { Record::with_costs() } else { Record::default() };
        Self {
            world,
            options,
            stats: RenderStats::default(),
            costs: None,
            log: None,
            lights: None,
            guide: None,
            guide_from: None,
            caustics: None,
            searched: None,
            probes: options.integrator.has_virtual_lights(),
            sharing: Sharing::All,
            pixel_order: PixelOrder::new(options),
            cone: Cone::default(),
            properties: None,
            record,
            direct: Vec3s::default(),
            seen: SeenLight::default(),
            differs_for_camera: Arc::default(),
            behind: Vec::new(),
            held: Vec::new(),
            spare: Vec::new(),
            camera: CameraBatch::default(),
            wavefront: Wavefront::default(),
            closures: ClosureBatch::default(),
            dark: Vec3s::default(),
            shadows: Coherence::Coherent,
            blocked: Vec::new(),
            timed: RayBatch::default(),
        }
    }

    /// The counters so far; starts again from zero.
    pub(crate) fn take_stats(&mut self) -> RenderStats {
        let counters = std::mem::take(&mut self.record.counters);
        self.stats.nodes_visited += counters.nodes;
        self.stats.triangles_tested += counters.triangles;
        std::mem::take(&mut self.stats)
    }

    /// Closest hits of rays of a kind with these keys.
    pub(crate) fn intersect(
        &mut self,
        kind: RayMask,
        rays: &RayBatch,
        keys: &[SampleKey],
        coherence: Coherence,
    ) -> HitBatch {
        let mut hits = HitBatch::default();
        self.intersect_into(kind, rays, keys, coherence, &mut hits);
        hits
    }

    /// As [`intersect`](Self::intersect), into memory that is there.
    pub(crate) fn intersect_into(
        &mut self,
        kind: RayMask,
        rays: &RayBatch,
        keys: &[SampleKey],
        coherence: Coherence,
        hits: &mut HitBatch,
    ) {
        let query = Query { level: self.options.level, coherence, mask: kind.0 };
        let rays = with_times(self.world, rays, keys, &mut self.timed);
        self.world.tree().intersect_batch(&query, rays, hits, &mut self.record);
        self.note_costs(keys);
    }

    /// Calls `with(tracer, material's shader, lanes, their points)` for each material that was hit; the points are as the
    /// shader's methods that are `requested` need them.
    pub(crate) fn for_each_surface(
        &mut self,
        from: HitLanes,
        requested: AttributeRequests,
        with: impl FnMut(&mut Self, &dyn SurfaceShader, &[u32], &SurfaceBatch),
    ) {
        self.for_each_surface_in(0..from.rays.len(), from, requested, with);
    }

    /// The same for the lanes in `range`.
    pub(crate) fn for_each_surface_in(
        &mut self,
        range: Range<usize>,
        from: HitLanes,
        requested: AttributeRequests,
        with: impl FnMut(&mut Self, &dyn SurfaceShader, &[u32], &SurfaceBatch),
    ) {
        let mut group = self.spare.pop().unwrap_or_default();
        let mut order = std::mem::take(&mut group.order);
        self.world.sort_by_material(from.hits, range, &mut order);
        self.spare.push(group);
        self.for_each_surface_of(&order, from, requested, with);
        if let Some(group) = self.spare.last_mut() {
            group.order = order;
        }
    }

    /// The same for some of the lanes, in order of their materials: material in the upper half, lane in the lower one.
    pub(crate) fn for_each_surface_of(
        &mut self,
        order: &[u64],
        from: HitLanes,
        requested: AttributeRequests,
        mut with: impl FnMut(&mut Self, &dyn SurfaceShader, &[u32], &SurfaceBatch),
    ) {
        let world = self.world;
        let mut group = self.spare.pop().unwrap_or_default();
        for same in order.chunk_by(|a, b| a >> 32 == b >> 32) {
            let shader = world.shader((same[0] >> 32) as usize);
            let Group { lanes, points, .. } = &mut group;
            lanes.clear();
            lanes.extend(same.iter().map(|&lane| lane as u32));
            let detail = if requested == AttributeRequests::Light { Detail::Full } else { Detail::Sides };
            world.surface_points().surface_points(
                (self.options.level, self.options.ray_epsilon),
                from,
                lanes,
                detail,
                shader.attributes(),
                points,
            );
            points.camera = self.properties;
            // Unknown if no material reads it.
            if world.materials().read_widths() {
                self.cone.widen(self.pixel_order, points, lanes, from.cones);
            }
            with(self, shader, lanes, points);
        }
        self.spare.push(group);
    }

    /// Radiance along each ray, given its hit.
    pub(crate) fn shade(&mut self, from: HitLanes, radiance: &mut Vec3s) {
        radiance.reset(from.rays.len(), Vec3::ZERO);
        self.shade_misses(from, radiance);
        self.for_each_surface(from, AttributeRequests::Light, |tracer, shader, lanes, points| {
            if let Some(log) = &mut tracer.log {
                log.surface(shader, points);
            }
            let mut shaded = Vec3s::splat(lanes.len(), Vec3::ZERO);
            let mut closures = std::mem::take(&mut tracer.closures);
            recursive_radiance(tracer, points, shader, &mut closures, &mut shaded);
            tracer.closures = closures;
            for (k, &lane) in lanes.iter().enumerate() {
                radiance.set(lane as usize, shaded.get(k));
            }
        });
    }

    fn shade_misses(&mut self, from: HitLanes, radiance: &mut Vec3s) {
        let missed: Vec<usize> = (0..from.rays.len()).filter(|&i| from.hits.get(i).is_none()).collect();
        let direct = self.environment(from.rays, &missed, |lane| from.is_of_camera(lane));
        for (k, &lane) in missed.iter().enumerate() {
            radiance.set(lane, direct.get(k));
        }
    }

    /// Radiance of the environment along some of the rays, unoccluded; `is_of_camera` tells whether a lane's
    /// ray comes from the camera.
    pub(crate) fn environment(
        &mut self,
        rays: &RayBatch,
        lanes: &[usize],
        is_of_camera: impl Fn(usize) -> bool,
    ) -> Vec3s {
        let mut direct = Vec3s::splat(lanes.len(), Vec3::ZERO);
        let lights = self.world.lights();
        let Some(environment) = lights.environment.as_ref().filter(|_| !lanes.is_empty()) else {
            return direct;
        };
        let mut dirs = Vec3s::default();
        lanes.iter().for_each(|&lane| dirs.push(Vec3::from(rays.get(lane).dir)));
        environment.miss(&dirs, &mut direct);
        if let Some(backdrop) = &lights.backdrop {
            let mut shown = direct.clone();
            backdrop.miss(&dirs, &mut shown);
            let of_camera = lanes.iter().enumerate().filter(|(_, lane)| is_of_camera(**lane));
            of_camera.for_each(|(k, _)| direct.set(k, shown.get(k)));
        }
        // Pixels of a picture where a camera sees nothing have rays without direction.
        let nowhere = (0..dirs.len()).filter(|&i| dirs.get(i) == Vec3::ZERO);
        nowhere.for_each(|i| direct.set(i, Vec3::ZERO));
        direct
    }

    /// Whether rays with these keys, neighbours of each other, hit anything.
    pub(crate) fn occluded_batch(&mut self, rays: &RayBatch, keys: &[SampleKey], blocked: &mut Vec<bool>) {
        let query = Query { level: self.options.level, coherence: self.shadows, mask: RayMask::SHADOW.0 };
        let rays = with_times(self.world, rays, keys, &mut self.timed);
        self.world.tree().occluded_batch(&query, rays, blocked, &mut self.record);
        self.note_costs(keys);
    }

    /// Which of a virtual light's rays hit anything, as bits.
    pub(crate) fn occluded_pencil(&mut self, rays: &mut Pencil) -> u64 {
        let query = Query { level: self.options.level, mask: RayMask::SHADOW.0, ..Query::default() };
        rays.set_time(self.world.time_of_all());
        self.world.tree().occluded_pencil(&query, rays, &mut self.record)
    }

    /// The transmittance of each ray; `through`: the media that it passes, if there are any; `blockers`: the instances that
    /// stop it, if not all do.
    pub(crate) fn passed(
        &mut self,
        request: &RayRequest,
        (through, blockers): (Option<Through>, Option<Blockers>),
        transmittance: &mut Vec3s,
    ) {
        transmittance.reset(request.rays.len(), Vec3::ONE);
        if request.rays.is_empty() {
            return;
        }
        self.stats.shadow_rays += request.rays.len() as u64;
        let materials = self.world.materials();
        let scatters = self.scatters();
        let all_stop = if scatters { materials.all_solid() } else { materials.all_opaque() };
        let blockers = blockers.filter(|blockers| blockers.sets.iter().any(|&set| set != 0));
        if all_stop && blockers.is_none() {
            self.occluded_by_opaque(request, transmittance);
            if let Some(through) = through {
                self.pass_media(request, through, transmittance);
            }
        } else {
            self.pass_layers(request, scatters, (through, blockers), transmittance);
        }
        if let Some(log) = &mut self.log {
            log.shadows(&request.rays, transmittance);
        }
    }

    fn occluded_by_opaque(&mut self, request: &RayRequest, transmittance: &mut Vec3s) {
        // Rays of one batch start side by side and aim at one light.
        let mut blocked = std::mem::take(&mut self.blocked);
        self.occluded_batch(&request.rays, &request.key, &mut blocked);
        for (i, _) in blocked.iter().enumerate().filter(|&(_, &blocked)| blocked) {
            transmittance.set(i, Vec3::ZERO);
        }
        self.blocked = blocked;
    }

    /// Whether the integrator finds light through glass by scattered rays.
    fn scatters(&self) -> bool {
        let integrator = self.options.integrator;
        integrator == Integrator::Path || integrator.has_virtual_lights()
    }

    fn note_costs(&mut self, keys: &[SampleKey]) {
        if let (Some(costs), Some(rays)) = (&mut self.costs, &self.record.costs) {
            costs.add(keys, rays);
        }
    }
}

/// The rays, or copies with the times of their keys if something moves.
fn with_times<'a>(
    world: &World,
    rays: &'a RayBatch,
    keys: &[SampleKey],
    timed: &'a mut RayBatch,
) -> &'a RayBatch {
    if !world.is_open() {
        return rays;
    }
    timed.clone_from(rays);
    timed.time.clear();
    timed.time.extend(keys.iter().take(rays.len()).map(|&key| world.time(key)));
    timed.time.resize(rays.len(), 0.0);
    timed
}
