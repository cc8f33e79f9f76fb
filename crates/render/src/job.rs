// SPDX-License-Identifier: GPL-3.0-or-later
//! State that all tiles of a rendering share, and the camera rays of their pixels. Samples placed by the
//! filter [EST06].

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use glam::Vec3;
use gnurt_accel::{Ray, RayBatch};
use gnurt_image::Filter;
use gnurt_shading::sampling::{purpose, sample_pair, sample_pairs};
use gnurt_shading::{CameraProperties, CameraSamples, CameraShader, SampleKey};
use gnurt_simd::dispatch_wide;

use crate::camera_batch::CameraBatch;
use crate::cone::Cone;
use crate::expressions::LightPaths;
use crate::guide::Guide;
use crate::many_lights::Common;
use crate::options::RenderOptions;
use crate::pixel_order::PixelOrder;
use crate::progress::Watch;
use crate::tracer::BatchTracer;
use crate::transport::links::LightLinks;
use crate::transport::manifold::Caustics;
use crate::world::World;

/// State that all tiles of a rendering share.
pub(crate) struct Job<'a> {
    pub(crate) world: &'a World,
    pub(crate) camera: &'a dyn CameraShader,
    pub(crate) options: &'a RenderOptions,
    pub(crate) filter: Filter,
    pub(crate) watch: &'a dyn Watch,
    pub(crate) deadline: Option<Instant>,
    /// Samples that the whole rendering will take.
    pub(crate) all_samples: u64,
    pub(crate) samples_done: AtomicU64,
    /// After one thread was told to stop, all stop.
    pub(crate) stopped: AtomicBool,
    /// Unit direction of view, for depths along it.
    pub(crate) forward: Vec3,
    /// Where the middle of the picture is seen from.
    pub(crate) eye: Vec3,
    /// The footprint of a pixel.
    pub(crate) cone: Cone,
    /// The camera as shaders query it.
    pub(crate) properties: CameraProperties,
    /// Centres of columns and rows, computed at first use.
    centres: OnceLock<[Vec<f32>; 2]>,
    /// State of virtual lights that all passes share.
    pub(crate) common: Arc<Common>,
    /// What paths are compared with, if layers of light are requested.
    pub(crate) light_paths: Option<Arc<LightPaths>>,
    /// Where light comes from, and from which sample on paths are guided by it.
    pub(crate) guide: Option<(&'a Guide, u32)>,
    /// Smooth surfaces and lamps of searches, if paths make them.
    pub(crate) caustics: Option<Arc<Caustics>>,
    /// Lights that do not reach everything, if there are any.
    pub(crate) links: Option<Arc<LightLinks>>,
    /// Whether camera rays meet other instances than scattered rays do, found at first use: there may be many instances.
    differs_for_camera: Arc<OnceLock<bool>>,
}

impl<'a> Job<'a> {
    /// A job without deadline that has nothing done.
    pub(crate) fn new(
        world: &'a World,
        camera: &'a dyn CameraShader,
        options: &'a RenderOptions,
        watch: &'a dyn Watch,
    ) -> Self {
        let [eye, forward] = middle(camera, options);
        // Options were checked; labels of a world that are too much for an automaton leave layers black.
        let layers = Some(&options.light_layers).filter(|layers| !layers.is_empty());
        let light_paths = layers.and_then(|layers| LightPaths::new(world, layers).ok().map(Arc::new));
        Self {
            world,
            camera,
            options,
            filter: Filter::new(options.filter),
            watch,
            deadline: None,
            all_samples: 1,
            samples_done: AtomicU64::new(0),
            stopped: AtomicBool::new(false),
            forward,
            eye,
            cone: Cone::of(camera, options),
            properties: CameraProperties {
                resolution: [options.width, options.height],
                projection: camera.projection(),
                shutter: [0.0, if world.is_open() { 1.0 } else { 0.0 }],
            },
            centres: OnceLock::new(),
            common: Arc::default(),
            light_paths,
            guide: None,
            caustics: None,
            links: LightLinks::new(world).map(Arc::new),
            differs_for_camera: Arc::default(),
        }
    }

    /// A tracer in its world, which can note the cost of each ray, or not.
    pub(crate) fn tracer(&self, costs: bool) -> BatchTracer<'a> {
        let mut tracer = BatchTracer::new(self.world, self.options, costs);
        tracer.properties = Some(self.properties);
        tracer.differs_for_camera = self.differs_for_camera.clone();
        tracer
    }

    /// One ray through each pixel for each sample, at its centre or placed by the filter; sample by sample.
    pub(crate) fn camera_rays(
        &self,
        pixels: impl Iterator<Item = [u32; 2]>,
        samples: Range<u32>,
        batch: &mut CameraBatch,
    ) {
        let (width, height) = (self.options.width, self.options.height);
        let CameraBatch { pixels: all, rays, keys, positions, lens, times, .. } = batch;
        rays.clear();
        keys.clear();
        positions.clear();
        all.clear();
        let order = PixelOrder::new(self.options);
        // An iterator of rows and columns is fast from inside only.
        pixels.for_each(|pixel| all.push(pixel));
        for sample in samples {
            keys.extend(all.iter().map(|&pixel| order.key(pixel, sample)));
        }
        if self.options.pixel_centres {
            let [columns, rows] = self.centres.get_or_init(|| centres(width, height));
            let centre = |&[x, y]: &[u32; 2]| [columns[x as usize], rows[y as usize]];
            while positions.len() < keys.len() {
                positions.extend(all.iter().map(centre));
            }
        } else {
            self.draw(keys, purpose::PIXEL, positions);
            for (position, &[x, y]) in positions.iter_mut().zip(all.iter().cycle()) {
                let [dx, dy] = self.filter.sample(*position).map(f64::from);
                let across = (f64::from(x) + 0.5 + dx) / f64::from(width);
                let up = 1.0 - (f64::from(y) + 0.5 + dy) / f64::from(height);
                *position = [across as f32, up as f32];
            }
        }
        lens.clear();
        // One sample in the middle of each pixel ignores the lens.
        if self.camera.has_lens() && !(self.options.pixel_centres && self.options.spp == 1) {
            self.draw(keys, purpose::LENS, lens);
        }
        times.clear();
        if self.world.is_open() {
            times.extend(keys.iter().map(|&key| self.world.time(key)));
        }
        let samples = CameraSamples { positions, lens, times };
        self.camera.rays(&samples, width as f32 / height as f32, rays);
        // A camera that gives too few rays leaves the rest dark: a ray without direction hits nothing.
        while rays.len() < keys.len() {
            rays.push(Ray::new([0.0; 3], [0.0; 3]));
        }
    }

    /// Appends the pair of numbers of each key for one purpose of camera rays.
    fn draw(&self, keys: &[SampleKey], purpose: u32, pairs: &mut Vec<[f32; 2]>) {
        let (seed, level) = (self.options.seed, self.options.level);
        dispatch_wide!(
            level,
            simd => sample_pairs(simd, seed, keys, 0, purpose, pairs),
            else pairs.extend(keys.iter().map(|&key| sample_pair(seed, key, 0, purpose)))
        );
    }

    /// Whether to finish now; once yes, always yes.
    pub(crate) fn should_stop(&self) -> bool {
        let stop = self.stopped.load(Ordering::Relaxed)
            || self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
            || self.watch.should_stop();
        if stop {
            self.stopped.store(true, Ordering::Relaxed);
        }
        stop
    }
}

/// Where the centres of columns and rows lie across the picture and up.
fn centres(width: u32, height: u32) -> [Vec<f32>; 2] {
    let across = |x| ((f64::from(x) + 0.5) / f64::from(width)) as f32;
    let up = |y| (1.0 - (f64::from(y) + 0.5) / f64::from(height)) as f32;
    [(0..width).map(across).collect(), (0..height).map(up).collect()]
}

/// Where the middle of the picture is seen from, and its unit direction.
pub(crate) fn middle(camera: &dyn CameraShader, options: &RenderOptions) -> [Vec3; 2] {
    let mut rays = RayBatch::default();
    camera.rays(
        &CameraSamples::sharp(&[[0.5, 0.5]]),
        options.width as f32 / options.height as f32,
        &mut rays,
    );
    if rays.is_empty() {
        return [Vec3::ZERO, Vec3::NEG_Z];
    }
    let ray = rays.get(0);
    [ray.org, ray.dir].map(Vec3::from)
}
