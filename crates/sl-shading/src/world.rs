// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of a running shader: spaces, attributes of the mesh, pictures, and rays and lights if there is a
//! tracer.
//! Space: world is the common space; `object` and `shader` are the instance's; matrices have points as rows.
//! The first query for lights traces them for all points of a batch, so that shadow rays are traced together.
//! Tests: `tests/scripts.rs`; crates/render/tests/appearance.rs for the matrices.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use glam::Vec3;
use gnurt_accel::Ray;
use gnurt_shading::{
    AttributeRequest, CameraProperties, ColorMap, LightBatch, PixelSamples, RayRequest, SampleKey,
    SurfaceBatch, SurfaceHit, Tracer, Vec3s,
};
use gnurt_sl::exec::{
    Arriving, ClosureDecl, DualRow, Given, Host, LANES, Point, Points, Program, Results, TextureOptions,
    TraceOptions, lanes_of, longitude_latitude,
};
use gnurt_sl::hir::Data;
use gnurt_sl::types::{Base, Type};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use gnurt_sl_lib::points::PointCloud;

use crate::attributes::{self, Value, fitting};
use crate::closures;
use crate::faults::Faults;
use crate::live::Live;
use crate::parts::Open;
use crate::properties::Properties;
use crate::surface_state::{Needs, RAYS};
use crate::textures::Textures;

/// Lights, by category, whose light at a batch of points is kept.
const MOST_LIGHTS: usize = 4096;

/// Branches of a point's key from here on are rays that a shader traces.
const BRANCH: u32 = 64;

/// State shared by all points of a shader.
pub(crate) struct Common {
    pub(crate) name: String,
    pub(crate) program: Arc<dyn Program>,
    pub(crate) textures: Arc<Textures>,
    pub(crate) faults: Arc<Faults>,
    /// The requests to the mesh.
    pub(crate) requests: Vec<AttributeRequest>,
    pub(crate) colors: ColorSystem,
    /// From Rec. 709 to the working space.
    pub(crate) map: ColorMap,
    /// Parameters that may change while it runs.
    pub(crate) live: Live,
    /// The inputs that it reads.
    pub(crate) needs: Needs,
    /// Its properties.
    pub(crate) properties: Properties,
    /// In boxes: eight kilobytes would be moved in and out for each batch.
    pub(crate) scratch: Mutex<Vec<Box<Scratch>>>,
}

/// Memory that batches of points are shaded in, two at once.
#[derive(Default)]
pub(crate) struct Scratch {
    points: [Points; 2],
    results: [Results; 2],
    open: Vec<Open>,
}

/// A batch that has been run.
pub(crate) struct Ran<'s> {
    /// The index of its first point.
    pub(crate) first: usize,
    pub(crate) points: &'s Points,
    pub(crate) results: &'s Results,
    /// Memory to visit closures in.
    pub(crate) open: &'s mut Vec<Open>,
}

impl Common {
    /// The first row of a stored value, in [`Results::rows`]; the others of a triple follow.
    pub(crate) fn row(&self, name: &str) -> Option<usize> {
        self.program.retained().iter().find(|retained| retained.name == name).map(|retained| retained.row)
    }

    /// Whether a stored value is a number.
    pub(crate) fn is_number(&self, name: &str) -> bool {
        self.program.retained().iter().any(|retained| retained.name == name && retained.ty.size() == 1)
    }

    /// Lends unused memory. Its former contents belong to the same shader.
    fn with_scratch(&self, with: impl FnOnce(&mut Scratch)) {
        let retained = self.scratch.lock().ok().and_then(|mut list| list.pop());
        let mut scratch = retained.unwrap_or_default();
        with(&mut scratch);
        if let Ok(mut list) = self.scratch.lock() {
            list.push(scratch);
        }
    }

    /// Runs the shader, and forwards its output.
    pub(crate) fn run(&self, world: &World, points: &Points, results: &mut Results) {
        self.program.run(world, points, results);
        self.forward(results);
    }

    fn forward(&self, results: &Results) {
        for (_, event) in &results.events {
            self.faults.note_event(&self.name, event);
        }
    }

    /// Runs the shader for this many points, in batches of sixteen, two of them at once where there are as many:
    /// `fill(first, points)` writes the points of a batch, and `with` takes what has become of them, in order.
    pub(crate) fn run_all(
        &self,
        world: &World,
        count: usize,
        mut fill: impl FnMut(usize, &mut Points),
        mut with: impl FnMut(Ran<'_>),
    ) {
        self.with_scratch(|Scratch { points, results, open }| {
            for first in (0..count).step_by(2 * LANES) {
                let batches = (count - first).div_ceil(LANES).min(2);
                let firsts = [first, first + LANES];
                for (points, first) in points.iter_mut().zip(firsts).take(batches) {
                    fill(first, points);
                }
                if batches == 2 {
                    self.program.run_pair(world, points, results);
                } else {
                    self.program.run(world, &points[0], &mut results[0]);
                }
                for ((points, results), first) in points.iter().zip(&*results).zip(firsts).take(batches) {
                    self.forward(results);
                    with(Ran { first, points, results, open });
                }
            }
        });
    }
}

/// A triple that begins in this row.
pub(crate) fn vector(results: &Results, row: usize, lane: usize) -> Vec3 {
    Vec3::from([0, 1, 2].map(|k| results.rows[row + k][lane]))
}

/// Where a shader runs.
pub(crate) struct World<'a> {
    common: &'a Common,
    hits: Option<&'a SurfaceBatch>,
    pixels: Option<&'a PixelSamples<'a>>,
    queries: Option<RefCell<Queries<'a>>>,
    /// From a camera's space, at a time.
    pub(crate) world_from_camera: Option<&'a dyn Fn(f32) -> [[f32; 4]; 4]>,
    /// Whether that is the same at all times.
    pub(crate) camera_is_still: bool,
    /// Width over height of the picture.
    pub(crate) aspect: f32,
    /// The camera, of camera shaders.
    pub(crate) camera: Option<CameraProperties>,
}

/// A tracer, and its answers so far.
struct Queries<'a> {
    tracer: &'a mut (dyn Tracer + 'a),
    /// Light and transmittance, by lights.
    lights: HashMap<(i32, String), (LightBatch, Option<Vec3s>)>,
    /// The number of rays that each point has traced.
    rays: Vec<u32>,
    /// The last ray of each point.
    last: Vec<Option<Last>>,
}

/// A traced ray, and its results.
struct Last {
    request: RayRequest,
    /// How far it went; infinite if it met nothing.
    distance: f32,
    /// Its hit, computed at first use.
    met: Option<Option<SurfaceHit>>,
}

impl<'a> Queries<'a> {
    fn new(tracer: &'a mut (dyn Tracer + 'a), points: usize) -> RefCell<Self> {
        let last = std::iter::repeat_with(|| None).take(points).collect();
        RefCell::new(Self { tracer, lights: HashMap::new(), rays: vec![0; points], last })
    }
}

impl<'a> World<'a> {
    /// Without surfaces: of lights, cameras, skies.
    pub(crate) fn empty(common: &'a Common) -> Self {
        Self {
            common,
            hits: None,
            pixels: None,
            queries: None,
            world_from_camera: None,
            camera_is_still: false,
            aspect: 1.0,
            camera: None,
        }
    }

    /// Around points.
    pub(crate) fn around(
        common: &'a Common,
        hits: &'a SurfaceBatch,
        tracer: Option<&'a mut (dyn Tracer + 'a)>,
    ) -> Self {
        let queries = tracer.map(|tracer| Queries::new(tracer, hits.len()));
        Self { hits: Some(hits), queries, ..Self::empty(common) }
    }

    /// Around samples of pixels.
    pub(crate) fn before(
        common: &'a Common,
        pixels: &'a PixelSamples<'a>,
        tracer: &'a mut (dyn Tracer + 'a),
    ) -> Self {
        let queries = Some(Queries::new(tracer, pixels.keys.len()));
        Self { pixels: Some(pixels), queries, ..Self::empty(common) }
    }

    /// The batch and the point's index in it.
    fn lane(&self, point: &Point) -> Option<(&'a SurfaceBatch, usize)> {
        let hits = self.hits?;
        Some((hits, usize::try_from(point.index).ok().filter(|&i| i < hits.len())?))
    }

    /// A value of the mesh, if it has it.
    fn asked(&self, name: &str, point: &Point) -> Option<Vec<f32>> {
        let (hits, lane) = self.lane(point)?;
        let number = self.common.requests.iter().position(|request| request.name == name)?;
        let values = hits.attributes.get(number)?;
        // Another query may have requested more components.
        let all = values.iter().skip(lane).step_by(hits.len()).copied().take_while(|x| !x.is_nan());
        Some(all.collect()).filter(|all: &Vec<f32>| !all.is_empty())
    }

    /// Changes of components of a value of the mesh, from pixel to pixel: from `first` on, of `count`. Empty where they are not known.
    fn slopes(&self, name: &str, (first, count): (usize, usize), point: &Point) -> Option<[Vec<f32>; 2]> {
        let (hits, lane) = self.lane(point)?;
        let is_gradient =
            |request: &AttributeRequest| request.name.strip_prefix(AttributeRequest::GRADIENT) == Some(name);
        let values = hits.attributes.get(self.common.requests.iter().position(is_gradient)?)?;
        let row = |k: usize| values.get(k * hits.len() + lane).copied().unwrap_or(0.0);
        let along = |step: [f32; 3]| {
            let component = |i: usize| (0..3).map(|c| row(3 * i + c) * step[c]).sum();
            (first..first + count).map(component).collect()
        };
        Some([along(point.p.dx), along(point.p.dy)])
    }

    /// With changes of components from `first` on, if they are known.
    fn with_slopes(&self, given: Option<Given>, name: &str, first: usize, point: &Point) -> Option<Given> {
        let mut given = given?;
        if let Data::Float(list) = &given.value
            && let Some(slopes) = self.slopes(name, (first, list.len()), point)
        {
            given.derivs = slopes;
        }
        Some(given)
    }

    /// A value of the mesh, or one of its elements.
    fn element(&self, name: &str, index: Option<i32>, ty: Type, point: &Point) -> Option<Given> {
        let Some(index) = index else { return self.userdata(name, ty, point) };
        let all = self.asked(name, point)?;
        let element = usize::try_from(index).ok().and_then(|index| all.get(index).copied())?;
        let given = fitting(vec![element], ty).filter(|_| ty.size() == 1);
        self.with_slopes(given, name, usize::try_from(index).unwrap_or(0), point)
    }

    /// The numbers of a point's instance, object, material and primitive.
    fn ids(&self, hits: &SurfaceBatch, lane: usize) -> Option<[u32; 4]> {
        let is_ids = |request: &AttributeRequest| request.name == AttributeRequest::IDS;
        let values = hits.attributes.get(self.common.requests.iter().position(is_ids)?)?;
        let mut numbers = values.iter().skip(lane).step_by(hits.len()).map(|x| x.to_bits());
        let ids = [numbers.next()?, numbers.next()?, numbers.next()?, numbers.next()?];
        Some(ids)
    }

    /// The camera of the picture, if it is known.
    fn camera_properties(&self) -> Option<CameraProperties> {
        let of_pixels = |pixels: &PixelSamples| CameraProperties {
            resolution: pixels.size,
            projection: pixels.projection,
            shutter: [0.0, pixels.camera.duration()],
        };
        self.camera.or_else(|| self.hits?.camera).or_else(|| self.pixels.map(of_pixels))
    }

    /// A ray from `p`: away from the surface where `p` is the point that is shaded.
    fn ray(&self, p: [f32; 3], r: [f32; 3], options: &TraceOptions, point: &Point) -> Option<Ray> {
        let of_camera = self.pixels.zip(usize::try_from(point.index).ok());
        if let Some((pixels, lane)) = of_camera.filter(|(pixels, lane)| *lane < pixels.rays.len()) {
            let own = pixels.rays.get(lane);
            let is_whole = options.mindist <= own.t_near
                && options.maxdist >= own.t_far.min(1e30)
                && options.traceset.is_empty();
            if (own.org, own.dir) == (p, r) && is_whole {
                return Some(own);
            }
        }
        let dir = Vec3::from(r).try_normalize()?;
        let far = if options.maxdist >= 1e30 { f32::INFINITY } else { options.maxdist };
        let ray = match self.lane(point) {
            Some((hits, lane)) if Vec3::from(p) == hits.p.get(lane) => hits.spawn(lane, dir, far),
            _ => Ray::new(p, dir.to_array()).within(0.0, far),
        };
        let near = ray.t_near.max(options.mindist);
        Some(ray.within(near, ray.t_far))
    }

    /// The index of the point in its batch, its key, and how wide its rays begin.
    fn asker(&self, point: &Point) -> Option<(usize, SampleKey, f32)> {
        let lane = usize::try_from(point.index).ok()?;
        let key = match (self.hits, self.pixels) {
            (Some(hits), _) => hits.key.get(lane),
            (None, pixels) => pixels?.keys.get(lane),
        };
        let width = self.hits.and_then(|hits| hits.footprint.get(lane));
        Some((lane, *key?, width.copied().unwrap_or(0.0)))
    }

    /// The ray as a request, and the tracer to send it.
    fn request(
        &self,
        ray: Ray,
        set: &Arc<str>,
        point: &Point,
    ) -> Option<(RayRequest, std::cell::RefMut<'_, Queries<'a>>)> {
        let (lane, key, width) = self.asker(point)?;
        let mut queries = self.queries.as_ref()?.borrow_mut();
        let set = Some(set.clone()).filter(|set| !set.is_empty());
        let mut request = RayRequest { set, ..RayRequest::default() };
        // The camera's own ray is not another one.
        if self.own(&ray, &request.set, lane).is_some() {
            request.push(ray, lane, key);
        } else {
            queries.rays[lane] += 1;
            request.push(ray, lane, key.fork(BRANCH + queries.rays[lane]));
        }
        request.width.push(width);
        Some((request, queries))
    }

    /// The known result of a camera ray: radiance, and distance; `None` for other rays.
    fn own(&self, ray: &Ray, set: &Option<Arc<str>>, lane: usize) -> Option<(Vec3, f32)> {
        let pixels = self.pixels.filter(|_| set.is_none())?;
        let is_own = lane < pixels.rays.len() && pixels.rays.get(lane) == *ray;
        is_own.then(|| (pixels.radiance.get(lane), pixels.distances[lane]))
    }

    /// The result of a texture lookup; a failure is reported only if the shader gives no replacement, because
    /// no other message follows.
    fn reported<T>(&self, found: Result<T, String>, options: &TextureOptions) -> Result<T, String> {
        if let (Err(why), true) = (&found, options.missing.is_some()) {
            self.common.faults.note(&format!("{}: {why}", self.common.name));
        }
        found
    }
}

fn some(list: Vec<f32>) -> Option<Given> {
    Some(Given::from(Data::Float(list)))
}

fn changing(list: Vec<Dual<f32>>) -> Option<Given> {
    let part = |of: fn(&Dual<f32>) -> f32| list.iter().map(of).collect();
    Some(Given { value: Data::Float(part(|x| x.value)), derivs: [part(|x| x.dx), part(|x| x.dy)] })
}

const IDENTITY: [[f32; 4]; 4] =
    [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

impl Host for World<'_> {
    fn common_from(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        match space {
            "world" => Some(IDENTITY),
            "camera" => self.world_from_camera.map(|at| at(point.time)),
            "object" | "shader" => {
                let Some(m) = self.asked(AttributeRequest::WORLD_FROM_OBJECT, point) else {
                    return Some(IDENTITY);
                };
                let row = |k: usize, w: f32| [m[3 * k], m[3 * k + 1], m[3 * k + 2], w];
                Some([row(0, 0.0), row(1, 0.0), row(2, 0.0), row(3, 1.0)])
            }
            _ => None,
        }
    }

    fn is_same_space(&self, space: &str, lanes: u32, index: &[i32; LANES]) -> bool {
        if space == "camera" {
            return self.camera_is_still;
        }
        let of_object = matches!(space, "object" | "shader");
        let Some(hits) = self.hits.filter(|_| of_object) else { return space == "world" || of_object };
        // An instance has one matrix.
        let leaf = |lane: usize| usize::try_from(index[lane]).ok().and_then(|i| hits.leaf_id.get(i));
        let mut leaves = lanes_of(lanes).map(leaf);
        let first = leaves.next().flatten();
        first.is_some() && leaves.all(|leaf| leaf == first)
    }

    fn userdata(&self, name: &str, ty: Type, point: &Point) -> Option<Given> {
        if let Some(found) = self.common.live.get(name) {
            return fitting(found, ty);
        }
        if name == "aspect" && ty == Type::FLOAT && self.hits.is_none() {
            return some(vec![self.aspect]);
        }
        if let Some(found) = self.asked(name, point) {
            return self.with_slopes(fitting(found, ty), name, 0, point);
        }
        let (hits, lane) = self.lane(point)?;
        // Coordinates change as `u` and `v` do.
        let [u, v] = [point.u, point.v];
        match (name, ty.base) {
            ("uv" | "st", _) if ty.size() >= 2 => {
                let mut list = vec![u, v];
                list.resize(ty.size(), 0.0.into());
                changing(list)
            }
            ("s", Base::Float) => changing(vec![u]),
            ("t", Base::Float) => changing(vec![v]),
            ("Cd" | "color", base) if base.is_triple() => {
                let color = some(hits.color.get(lane).to_array().to_vec());
                self.with_slopes(color, "Cd", 0, point)
            }
            ("alpha", Base::Float) => some(vec![hits.alpha[lane]]),
            _ => None,
        }
    }

    fn attribute(
        &self,
        object: &str,
        name: &str,
        index: Option<i32>,
        ty: Type,
        point: &Point,
    ) -> Option<Given> {
        // Of the object first, then of the scene.
        if object.is_empty() {
            if let Some(found) = self.element(name, index, ty, point) {
                return Some(found);
            }
            let of_path = |(hits, lane)| attributes::of_path(hits, lane, name);
            if let Some(value) = self.lane(point).and_then(of_path) {
                return attributes::converted(&value, index, ty);
            }
            let part = attributes::is_of_part(name) && index.is_none();
            if let Some((hits, ids)) =
                self.lane(point).filter(|_| part).and_then(|(hits, lane)| Some((hits, self.ids(hits, lane)?)))
            {
                return attributes::of_part(hits, ids, name, ty);
            }
        } else if object != "global" {
            let names = self.hits?.names.as_ref()?;
            return attributes::of_object(names, object, name, index, ty);
        }
        let value = match name {
            "osl:version" => Value::Ints(vec![gnurt_sl::VERSION_CODE as i32]),
            _ => attributes::of_camera(&self.camera_properties()?, name)?,
        };
        attributes::converted(&value, index, ty)
    }

    fn trace(&self, p: Dual<[f32; 3]>, r: Dual<[f32; 3]>, options: &TraceOptions, point: &Point) -> bool {
        let Some(ray) = self.ray(p.value, r.value, options, point) else { return false };
        let Some((request, mut queries)) = self.request(ray, &options.traceset, point) else { return false };
        let lane = request.parent[0] as usize;
        let distance = match self.own(&ray, &request.set, lane) {
            Some((_, distance)) => distance,
            None => {
                let mut found = Vec::new();
                queries.tracer.distances(&request, &mut found);
                found.first().copied().unwrap_or(f32::INFINITY)
            }
        };
        queries.last[lane] = Some(Last { request, distance, met: None });
        distance.is_finite()
    }

    fn trace_message(&self, name: &str, ty: Type, point: &Point) -> (bool, Option<Given>) {
        let (Some(queries), Some((lane, ..))) = (&self.queries, self.asker(point)) else {
            return (false, None);
        };
        let Queries { tracer, last, .. } = &mut *queries.borrow_mut();
        let is_hit = last[lane].as_ref().is_some_and(|last| last.distance.is_finite());
        if (name, ty) == ("hit", Type::INT) {
            return (true, Some(Given::from(Data::Int(vec![i32::from(is_hit)]))));
        }
        let Some(last) = last[lane].as_mut().filter(|_| is_hit) else { return (false, None) };
        if (name, ty) == ("hitdist", Type::FLOAT) {
            return (true, some(vec![last.distance]));
        }
        let met = last.met.get_or_insert_with(|| {
            let mut found = Vec::new();
            tracer.meet(&last.request, &mut found);
            found.first().copied().flatten()
        });
        let found = met.as_ref().and_then(|met| match self.hits {
            Some(hits) if ty == Type::STRING => attributes::of_part(hits, met.ids, name, ty),
            _ => message_of(met, name, ty),
        });
        (true, found)
    }

    fn radiance(
        &self,
        p: Dual<[f32; 3]>,
        r: Dual<[f32; 3]>,
        options: &TraceOptions,
        point: &Point,
    ) -> [f32; 3] {
        let Some(ray) = self.ray(p.value, r.value, options, point) else { return [0.0; 3] };
        let Some((request, mut queries)) = self.request(ray, &options.traceset, point) else {
            return [0.0; 3];
        };
        if let Some((radiance, _)) = self.own(&ray, &request.set, request.parent[0] as usize) {
            return radiance.to_array();
        }
        let mut incoming = Vec3s::default();
        let depth = self.hits.map_or(0, |hits| hits.depth);
        queries.tracer.trace(depth, &request, &mut incoming);
        incoming.get(0).to_array()
    }

    fn light_count(&self) -> i32 {
        self.queries.as_ref().map_or(0, |queries| queries.borrow().tracer.light_count() as i32)
    }

    fn illuminate(
        &self,
        light: i32,
        p: [f32; 3],
        category: &str,
        shadowed: bool,
        point: &Point,
    ) -> Option<Arriving> {
        let (hits, lane) = self.lane(point)?;
        let mut queries = self.queries.as_ref()?.borrow_mut();
        if light < 0 || light as usize >= queries.tracer.light_count() {
            return None;
        }
        if Vec3::from(p) != hits.p.get(lane) {
            let mut single = hits.gather(&[lane as u32]);
            single.p.set(0, Vec3::from(p));
            return arriving(&mut *queries.tracer, (light, category), &single, 0, shadowed, &mut None);
        }
        let key = (light, category.to_owned());
        let mut known = queries.lights.remove(&key);
        let found = arriving(&mut *queries.tracer, (light, category), hits, lane, shadowed, &mut known);
        if let Some(known) = known {
            // Categories may be computed, each another one.
            if queries.lights.len() >= MOST_LIGHTS {
                queries.lights.clear();
            }
            queries.lights.insert(key, known);
        }
        found
    }

    fn texture(
        &self,
        file: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
        _: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.reported(self.common.textures.sample(file, at, options), options)
    }

    fn environment(
        &self,
        file: &str,
        direction: [Dual<f32>; 3],
        options: &TextureOptions,
        point: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        // Its left and right border meet; beyond the poles there is nothing.
        let wrap = ["periodic".into(), "clamp".into(), "clamp".into()];
        let around = TextureOptions { wrap, ..options.clone() };
        self.texture(file, longitude_latitude(direction), &around, point)
    }

    fn texture3d(
        &self,
        file: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
        _: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        self.reported(self.common.textures.sample3d(file, at, options), options)
    }

    fn textures(
        &self,
        file: &str,
        lanes: u32,
        at: &[DualRow; 2],
        options: &TextureOptions,
        out: &mut [DualRow; 4],
    ) -> bool {
        self.common.textures.sample_each(file, lanes, at, options, out)
    }

    fn texture_info(
        &self,
        file: &str,
        at: Option<[f32; 2]>,
        name: &str,
        ty: Type,
    ) -> Result<Option<Data>, String> {
        Ok(self.common.textures.info(file, at, name, ty))
    }

    fn point_cloud(&self, file: &str) -> Result<Arc<PointCloud>, String> {
        self.common.textures.cloud(file).map_err(|why| why.to_string())
    }

    fn dictionary(&self, file: &str) -> Option<String> {
        self.common.textures.text(file)
    }

    fn closures(&self) -> &[ClosureDecl] {
        closures::all().0
    }

    fn ray_kind(&self, name: &str) -> u32 {
        RAYS.iter().position(|ray| *ray == name).map_or(0, |i| 1 << i)
    }

    fn color_system(&self) -> &ColorSystem {
        &self.common.colors
    }
}

/// The properties of a ray's hit that a shader may query.
fn message_of(met: &SurfaceHit, name: &str, ty: Type) -> Option<Given> {
    let SurfaceHit { p, ng, ns, uv, albedo, back, ids, .. } = met;
    if (name, ty) == ("backfacing", Type::INT) {
        return Some(Given::from(Data::Int(vec![i32::from(*back)])));
    }
    if ty == Type::INT {
        let number = ["instance", "object", "material", "prim"].iter().position(|known| *known == name)?;
        return Some(Given::from(Data::Int(vec![ids[number] as i32])));
    }
    let triple = |v: &Vec3| v.to_array().to_vec();
    let list = match name {
        "P" => triple(p),
        "N" => triple(ns),
        "Ng" => triple(ng),
        "albedo" => triple(albedo),
        "u" => vec![uv[0]],
        "v" => vec![uv[1]],
        _ => return None,
    };
    (ty.base.is_float_based() && list.len() == ty.size()).then(|| Given::from(Data::Float(list)))
}

/// Light at a point of a batch; `known` caches the result for the batch.
fn arriving(
    tracer: &mut dyn Tracer,
    (light, category): (i32, &str),
    hits: &SurfaceBatch,
    lane: usize,
    shadowed: bool,
    known: &mut Option<(LightBatch, Option<Vec3s>)>,
) -> Option<Arriving> {
    let (all, through) = known.get_or_insert_with(|| {
        let mut all = LightBatch::default();
        tracer.illuminate_in(category, light as usize, hits, &mut all);
        (all, None)
    });
    if shadowed && through.is_none() {
        let mut share = Vec3s::splat(hits.len(), Vec3::ZERO);
        let mut request = RayRequest::default();
        for i in 0..hits.len() {
            if all.radiance.get(i) == Vec3::ZERO {
                continue;
            }
            if let Some(ray) = hits.shadow_ray(i, all.dir.get(i), all.dist[i]) {
                request.push(ray, i, hits.key[i]);
            }
        }
        let mut passed = Vec3s::default();
        tracer.occluded(&request, &mut passed);
        for (k, &i) in request.parent.iter().enumerate() {
            share.set(i as usize, passed.get(k));
        }
        *through = Some(share);
    }
    let share = through.as_ref().filter(|_| shadowed).map_or(Vec3::ONE, |share| share.get(lane));
    let light = all.radiance.get(lane) * share;
    (light != Vec3::ZERO).then(|| Arriving {
        dir: all.dir.get(lane).to_array(),
        light: light.to_array(),
        distance: all.dist[lane].min(1e30),
        pdf: all.pdf[lane],
    })
}
