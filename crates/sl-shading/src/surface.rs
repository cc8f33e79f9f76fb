// SPDX-License-Identifier: GPL-3.0-or-later
//! Surfaces: points of a batch to points of a group, closures to lobes.
//! The globals have OSL's meaning. Space: world; normals face the ray, as OSL's renderers have them. A shader
//! with its own light (`illuminance`, `radiance`, the radiance of rays) is shaded as by Whitted's
//! renderer: its computed radiance counts as emission, and its other closures are lit by all lights.
//! Integrators scatter the closures of all other shaders, also of those that trace rays for distances and hits.
//! Tests: `tests/scripts.rs`.

use glam::Vec3;
use gnurt_shading::bsdf::{Bsdf, ClosureBatch, Scattering};
use gnurt_shading::materials::scattered_radiance;
use gnurt_shading::{
    AttributeRequest, Interior, RadianceShader, ShaderOutput, SurfaceBatch, SurfaceShader, Tracer, Vec3s,
};
use gnurt_simd::Level;
use gnurt_sl::exec::{LANES, Points, lanes_of};

use crate::emission_and_opacity::EmissionAndOpacity;
use crate::fixed::Fixed;
use crate::outputs::Outputs;
use crate::parts::{Flattened, Lights, column};
use crate::properties::Properties;
use crate::surface_state::{Caller, points};
use crate::world::{Common, Ran, World};

/// A surface.
pub(crate) struct ScriptSurface {
    pub(crate) common: Common,
    /// Its closures, if they are the same at all points: then it need not run.
    pub(crate) fixed: Option<Fixed>,
    /// Its outputs for layers.
    pub(crate) outputs: Outputs,
}

impl ScriptSurface {
    /// Runs it for all points; for sixteen at a time, `with(the first one, what they do to light)`. Lobes are written to `out`, to the
    /// points from 0 on if it is for sixteen only.
    fn each(
        &self,
        world: &World,
        (hits, caller): (&SurfaceBatch, Caller),
        out: &mut ClosureBatch,
        mut with: impl FnMut(usize, Flattened),
    ) {
        let is_whole = out.len() == hits.len();
        let fill = |first: usize, to: &mut Points| points(hits, first, caller, self.common.needs, to);
        self.common.run_all(world, hits.len(), fill, |Ran { first, points, results, open }| {
            let to = (&mut *out, if is_whole { first } else { 0 });
            let flattened = Flattened::flatten_lists(points, results, to, open, self.common.map);
            if flattened.is_cut() {
                self.common.faults.note(&format!(
                    "{}: a point has more than {} lobes; the last ones are left out",
                    self.common.name,
                    gnurt_shading::bsdf::MOST
                ));
            }
            with(first, flattened);
        });
    }

    /// The same, one point after the other: `with(point, what it does to light that it scatters, what goes straight through)`.
    fn each_single(
        &self,
        world: &World,
        hits: &SurfaceBatch,
        caller: Caller,
        mut with: impl FnMut(usize, &Bsdf, Vec3),
    ) {
        if let Some(fixed) = &self.fixed {
            for i in 0..hits.len() {
                let (lobes, through) = fixed.at(hits, i);
                with(i, &Bsdf::new(Fixed::normal(hits, i), lobes.clone()), through);
            }
            return;
        }
        let mut out = ClosureBatch::default();
        out.reset(LANES);
        self.each(world, (hits, caller), &mut out, |first, flattened| {
            for lane in 0..LANES.min(hits.len() - first) {
                let i = first + lane;
                let bsdf = Bsdf::new(hits.facing_ns(i), flattened.lists.lobes(lane));
                with(i, &bsdf, flattened.lights.through.get(lane));
            }
        });
    }

    /// Writes the scattering of sixteen points from `first` on; their emission and opacity go to
    /// `emission_and_opacity`.
    fn write(
        hits: &SurfaceBatch,
        first: usize,
        flattened: Flattened,
        emission_and_opacity: &mut Vec<(usize, EmissionAndOpacity)>,
    ) {
        let Flattened { mut lists, lights, points, .. } = flattened;
        let count = LANES.min(hits.len() - first);
        for lane in lanes_of(lights.beside_lobes()) {
            emission_and_opacity.push((first + lane, EmissionAndOpacity::of(&mut lists, &lights, lane)));
        }
        lists.face_all(&points.n);
        let plain = hits.unbent(Level::best(), first, &points.n) & !lists.bent();
        let all = (1_u32 << count) - 1;
        for lane in lanes_of(all & !plain) {
            let i = first + lane;
            let wo = -hits.ray_dir.get(i);
            let (at, ns) = (hits.point(i), column(&points.n, lane));
            // The heaviest lobe's normal is the point's; mirror images stay above.
            let is_bent = lists.bent() >> lane & 1 != 0;
            let main = if is_bent { lists.main_normal(lane) } else { Vec3::ZERO };
            let of = |n: Vec3| at.bent_normal(if n == Vec3::ZERO { ns } else { n }, wo);
            lists.face(lane, of(main), |n| if n == main { Vec3::ZERO } else { of(n) });
        }
    }

    /// Its surroundings, with rays if it traces them.
    fn around<'a>(&'a self, tracer: &'a mut (dyn Tracer + 'a), hits: &'a SurfaceBatch) -> World<'a> {
        let tracer = if self.common.properties.is_traced { Some(tracer) } else { None };
        World::around(&self.common, hits, tracer)
    }

    /// Writes the closures of all points.
    fn write_all(&self, world: &World, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        let mut emission_and_opacity = Vec::new();
        self.each(world, (hits, Caller::Rays), out, |first, flattened| {
            Self::write(hits, first, flattened, &mut emission_and_opacity);
        });
        emission_and_opacity
            .into_iter()
            .for_each(|(i, emission_and_opacity)| emission_and_opacity.write(i, hits.front(i), out));
    }
}

impl SurfaceShader for ScriptSurface {
    fn evaluate(&self, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        if let Some(fixed) = &self.fixed {
            fixed.write(hits, out);
            return;
        }
        self.write_all(&World::around(&self.common, hits, None), hits, out);
    }

    fn evaluate_traced(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut ClosureBatch) {
        if self.common.properties.is_traced {
            self.write_all(&self.around(tracer, hits), hits, out);
        } else {
            self.evaluate(hits, out);
        }
    }

    fn radiance(&self) -> Option<&dyn RadianceShader> {
        self.common.properties.is_radiance.then_some(self)
    }

    fn emits(&self) -> bool {
        // Light that depends on rays or paths is met, not sampled.
        let Properties { is_light, is_traced, reads_bounces, .. } = self.common.properties;
        is_light && !is_traced && !reads_bounces
    }

    fn even_emission(&self) -> Option<[Vec3; 2]> {
        self.fixed.as_ref().map(Fixed::emission)
    }

    fn transmit(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let world = self.around(tracer, hits);
        self.each_single(&world, hits, Caller::Shadow, |i, bsdf, through| {
            // Glass counts as thin, so that windows let light in.
            let [_, straight] = bsdf.delta_branches(-hits.ray_dir.get(i));
            let glass = straight.map_or(Vec3::ZERO, |branch| branch.weight);
            out.set(i, (through + glass).clamp(Vec3::ZERO, Vec3::ONE));
        });
    }

    fn has_medium(&self) -> bool {
        self.common.properties.has_medium
    }

    fn has_holes(&self) -> bool {
        self.common.properties.has_holes
    }

    fn interior(&self) -> Option<Interior> {
        self.fixed.as_ref().map(Fixed::interior).filter(|interior| *interior != Interior::default())
    }

    fn is_opaque(&self) -> bool {
        !(self.common.properties.is_holey || self.common.properties.is_glass)
    }

    fn gaps(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let world = self.around(tracer, hits);
        self.each_single(&world, hits, Caller::Shadow, |i, _, through| {
            out.set(i, through.clamp(Vec3::ZERO, Vec3::ONE));
        });
    }

    fn is_solid(&self) -> bool {
        !self.common.properties.is_holey
    }

    fn is_clear(&self) -> bool {
        let properties = &self.common.properties;
        (properties.is_glass || properties.is_holey) && !properties.is_radiance
    }

    fn albedo(&self, hits: &SurfaceBatch, out: &mut Vec3s) {
        let world = World::around(&self.common, hits, None);
        self.each_single(&world, hits, Caller::Rays, |i, bsdf, _| {
            out.set(i, bsdf.albedo(-hits.ray_dir.get(i)).clamp(Vec3::ZERO, Vec3::ONE));
        });
    }

    fn outputs(&self) -> &[ShaderOutput] {
        &self.outputs.all
    }

    fn output(&self, name: &str, hits: &SurfaceBatch, out: &mut Vec3s) {
        self.outputs.write(name, hits, out);
    }

    fn attributes(&self) -> &[AttributeRequest] {
        &self.common.requests
    }

    fn describe(&self, hits: &SurfaceBatch, lane: usize) -> Vec<String> {
        let world = World::around(&self.common, hits, None);
        let mut all = Points::default();
        points(hits, lane / LANES * LANES, Caller::Rays, self.common.needs.with_all(), &mut all);
        self.common.program.describe_point(&world, &all.point(lane % LANES))
    }
}

impl RadianceShader for ScriptSurface {
    fn shade(&self, tracer: &mut dyn Tracer, hits: &SurfaceBatch, out: &mut Vec3s) {
        let mut closures = ClosureBatch::default();
        closures.reset(hits.len());
        {
            let world = World::around(&self.common, hits, Some(&mut *tracer));
            self.each(&world, (hits, Caller::Rays), &mut closures, |first, mut flattened| {
                for lane in lanes_of(flattened.lights.radiance.some) {
                    let radiance = flattened.lights.radiance.get(lane);
                    if radiance.is_finite() {
                        out.add(first + lane, radiance);
                    }
                }
                // The caller follows the straight transmission.
                flattened.lights = Lights::default();
                Self::write(hits, first, flattened, &mut Vec::new());
            });
        }
        let points: Vec<Scattering> = (0..hits.len()).map(|i| closures.point(i)).collect();
        if points.iter().any(|point| !point.bsdf.is_black()) {
            scattered_radiance(tracer, hits, &points, out);
        }
    }
}
