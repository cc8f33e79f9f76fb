// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries, block by block: between blocks Ctrl-C is checked, and other Python threads run meanwhile.
//! Tests: `tests/test_rays.py`, `tests/test_points.py`.

use std::sync::Arc;

use gnurt_accel::{Hit, HitSlices, PointHit, Query, Ray64};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::arrays::{New, Output};
use crate::hits::{AllHits, Found, Hits, Origin};
use crate::pool::Workers;
use crate::rays::Rays;
use crate::trees::{Trees, run_query};

/// Points of a query between two checks for Ctrl-C.
pub(crate) const POINTS: usize = 1 << 16;

/// Which hits of a ray are listed.
#[derive(Clone, Copy)]
pub(crate) enum Which {
    /// The nearest, at most this many, on each triangle that the ray touches.
    First(usize),
    /// One for each crossing.
    Crossed,
}

/// A scene for queries, and the threads.
pub(crate) struct RayQuery {
    pub(crate) trees: Arc<Trees>,
    pub(crate) workers: Workers,
}

/// A hit of either precision.
pub(crate) trait AnyHit {
    type Number: Output;
    /// Distance, then both weights.
    fn numbers(&self) -> [Self::Number; 3];
    fn prim_id(&self) -> u32;
    /// Geometry, instance and leaf as the trees name them.
    fn ids(&self) -> [u32; 3];
}

impl AnyHit for Hit {
    type Number = f32;

    fn numbers(&self) -> [f32; 3] {
        [self.t, self.u, self.v]
    }

    fn prim_id(&self) -> u32 {
        self.prim_id
    }

    fn ids(&self) -> [u32; 3] {
        [self.geom_id, self.inst_id, self.leaf_id]
    }
}

impl RayQuery {
    pub(crate) fn intersect(self, py: Python<'_>, rays: &Rays) -> PyResult<Hits> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_intersect(py, rays, &scene);
        }
        let n = rays.count();
        let [mut t, mut u, mut v] =
            [New::<f32>::empty(py, n, 1)?, New::empty(py, n, 1)?, New::empty(py, n, 1)?];
        let [mut prim, mut geom, mut inst] =
            [New::<u32>::empty(py, n, 1)?, New::empty(py, n, 1)?, New::empty(py, n, 1)?];
        let mut ids = Vec::with_capacity(n);
        let mut normals = match self.trees.kinds.has_others {
            true => Some(New::<f32>::empty(py, n, 3)?),
            false => None,
        };
        {
            let mut normals = normals.as_mut().map(|all| all.all().as_chunks_mut::<3>().0);
            let (t, u, v) = (t.all(), u.all(), v.all());
            let (prim, geom, inst) = (prim.all(), geom.all(), inst.all());
            for range in rays.blocks() {
                let slices = rays.slices(&range)?;
                let r = || range.clone();
                let (t, u, v) = (&mut t[r()], &mut u[r()], &mut v[r()]);
                let (prim, geom, inst) = (&mut prim[r()], &mut geom[r()], &mut inst[r()]);
                let normal = normals.as_mut().map(|all| &mut all[r()]);
                py.detach(|| {
                    let mut leaf = vec![0; range.len()];
                    let mut into = HitSlices {
                        t: Some(&mut *t),
                        u: Some(&mut *u),
                        v: Some(&mut *v),
                        prim_id: Some(&mut *prim),
                        geom_id: Some(&mut *geom),
                        inst_id: Some(&mut *inst),
                        leaf_id: Some(&mut leaf),
                        normal,
                    };
                    let query = Query { coherence: rays.coherence(&slices), ..Query::default() };
                    let traced =
                        run_query!(self.trees, tree => tree.intersect_slices(&query, &slices, self.workers.threads(), &mut into));
                    traced.expect("arrays were made for these rays");
                    for i in 0..range.len() {
                        ids.push([prim[i], geom[i], inst[i], leaf[i]]);
                        (geom[i], inst[i]) = self.trees.ids([geom[i], inst[i], leaf[i]]);
                    }
                });
                py.check_signals()?;
            }
        }
        Ok(Hits {
            t: t.done(),
            prim_id: prim.done_as("int32")?,
            geom_id: geom.done_as("int32")?,
            inst_id: inst.done_as("int32")?,
            u: u.done(),
            v: v.done(),
            count: n,
            origin: Origin::Query(Found {
                trees: self.trees,
                threads: self.workers.count(),
                ids,
                normals: normals.map(New::done),
            }),
        })
    }

    pub(crate) fn occluded(self, py: Python<'_>, rays: &Rays) -> PyResult<Py<PyAny>> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_occluded(py, rays, &scene);
        }
        let mut answers = New::<u8>::empty(py, rays.count(), 1)?;
        let all = answers.all();
        for range in rays.blocks() {
            let slices = rays.slices(&range)?;
            let part = &mut all[range.clone()];
            py.detach(|| {
                let mut occluded = vec![false; part.len()];
                let query = Query { coherence: rays.coherence(&slices), ..Query::default() };
                let traced = run_query!(self.trees, tree => tree.occluded_slices(&query, &slices, self.workers.threads(), &mut occluded));
                traced.expect("an array was made for these rays");
                part.iter_mut().zip(occluded).for_each(|(into, is)| *into = u8::from(is));
            });
            py.check_signals()?;
        }
        answers.done_as("bool")
    }

    pub(crate) fn all_hits(self, py: Python<'_>, rays: &Rays, which: Which) -> PyResult<AllHits> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_all_hits(py, rays, which, &scene);
        }
        let mut splits = vec![0i64];
        let mut all: Vec<Hit> = Vec::new();
        for range in rays.blocks() {
            let list = rays.list(&range)?;
            py.detach(|| {
                let of = |part: &[Ray64]| {
                    let (mut hits, mut counts, mut one) = (Vec::new(), Vec::new(), Vec::new());
                    for ray in part {
                        let query = Query::default();
                        match which {
                            Which::First(most) => {
                                run_query!(self.trees, tree => tree.first_hits(&query, ray, most, &mut one));
                            }
                            Which::Crossed => {
                                run_query!(self.trees, tree => tree.crossing_hits(&query, ray, &mut one));
                            }
                        }
                        hits.extend_from_slice(&one);
                        counts.push(one.len() as i64);
                    }
                    (hits, counts)
                };
                let parts: Vec<_> = self.workers.threads().run(|parallel| {
                    if parallel {
                        list.par_chunks(1024).map(of).collect()
                    } else {
                        list.chunks(1024).map(of).collect()
                    }
                });
                for (hits, counts) in parts {
                    all.extend(hits);
                    for count in counts {
                        splits.push(splits[splits.len() - 1] + count);
                    }
                }
            });
            py.check_signals()?;
        }
        self.listed(py, &splits, &all)
    }

    /// Arrays of the hits of all rays, which are those between two of `splits`.
    pub(crate) fn listed<H: AnyHit>(self, py: Python<'_>, splits: &[i64], all: &[H]) -> PyResult<AllHits> {
        let of_rays = splits.windows(2).enumerate();
        let ray_ids: Vec<i64> =
            of_rays.flat_map(|(i, ends)| (ends[0]..ends[1]).map(move |_| i as i64)).collect();
        let numbers = |i: usize| -> PyResult<Py<PyAny>> {
            Ok(New::of(py, &all.iter().map(|hit| hit.numbers()[i]).collect::<Vec<_>>())?.done())
        };
        let ids = |field: &dyn Fn(&H) -> u32| -> PyResult<Py<PyAny>> {
            New::of(py, &all.iter().map(field).collect::<Vec<u32>>())?.done_as("int32")
        };
        let named = |hit: &H| self.trees.ids(hit.ids());
        let levels = self.trees.levels();
        let mut path = New::<u32>::empty(py, all.len(), levels)?;
        for (path, hit) in path.all().chunks_exact_mut(levels).zip(all) {
            self.trees.path(hit.ids(), path);
        }
        Ok(AllHits {
            splits: New::of(py, splits)?.done(),
            ray_id: New::of(py, &ray_ids)?.done(),
            t: numbers(0)?,
            prim_id: ids(&H::prim_id)?,
            geom_id: ids(&|hit| named(hit).0)?,
            inst_id: ids(&|hit| named(hit).1)?,
            path: path.rows_as("int32", levels)?,
            u: numbers(1)?,
            v: numbers(2)?,
        })
    }

    pub(crate) fn crossings(self, py: Python<'_>, rays: &Rays) -> PyResult<Py<PyAny>> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_crossings(py, rays, &scene);
        }
        let mut answers = New::<u32>::empty(py, rays.count(), 1)?;
        let all = answers.all();
        for range in rays.blocks() {
            let list = rays.list(&range)?;
            let part = &mut all[range];
            py.detach(|| {
                let mut counts = Vec::new();
                run_query!(self.trees, tree => tree.crossings_batch(&Query::default(), &list, self.workers.threads(), &mut counts));
                part.copy_from_slice(&counts);
            });
            py.check_signals()?;
        }
        answers.done_as("int32")
    }

    /// Curves enclose nothing: a ray may leave them where it came in, or through an open end.
    fn check_solids(&self, query: &str) -> PyResult<()> {
        if self.trees.kinds.has_curves {
            return Err(PyTypeError::new_err(format!(
                "{query}: the scene has curves, which enclose nothing; put meshes and spheres into a scene without curves"
            )));
        }
        Ok(())
    }

    pub(crate) fn contains(self, py: Python<'_>, points: &[[f64; 3]]) -> PyResult<Py<PyAny>> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_contains(py, points, &scene);
        }
        self.check_solids("contains")?;
        let mut answers = New::<u8>::empty(py, points.len(), 1)?;
        for (points, part) in points.chunks(POINTS).zip(answers.all().chunks_mut(POINTS)) {
            py.detach(|| {
                let mut inside = Vec::new();
                run_query!(self.trees, tree => tree.contains_batch(&Query::default(), points, self.workers.threads(), &mut inside));
                part.iter_mut().zip(inside).for_each(|(into, is)| *into = u8::from(is));
            });
            py.check_signals()?;
        }
        answers.done_as("bool")
    }

    /// Distances, those from inside of a closed surface negative if `signed`.
    pub(crate) fn distance(self, py: Python<'_>, points: &[[f64; 3]], signed: bool) -> PyResult<Py<PyAny>> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_distance(py, points, signed, &scene);
        }
        if signed {
            self.check_solids("signed_distance")?;
        }
        let mut answers = New::<f64>::empty(py, points.len(), 1)?;
        for (points, part) in points.chunks(POINTS).zip(answers.all().chunks_mut(POINTS)) {
            py.detach(|| {
                let (query, threads) = (Query::default(), self.workers.threads());
                if signed {
                    let mut distances = Vec::new();
                    run_query!(self.trees, tree => tree.signed_distance_batch(&query, points, threads, &mut distances));
                    part.copy_from_slice(&distances);
                } else {
                    let mut hits = Vec::new();
                    run_query!(self.trees, tree => tree.closest_points(&query, points, f64::INFINITY, threads, &mut hits));
                    let distance = |hit: &Option<PointHit>| hit.map_or(f64::INFINITY, |hit| hit.distance);
                    part.iter_mut().zip(&hits).for_each(|(into, hit)| *into = distance(hit));
                }
            });
            py.check_signals()?;
        }
        Ok(answers.done())
    }

    /// Points, distances, primitives and geometries; weights of the second and third corner and unit normals, too, if `detailed`.
    pub(crate) fn closest_point(
        self,
        py: Python<'_>,
        points: &[[f64; 3]],
        detailed: bool,
    ) -> PyResult<Vec<Py<PyAny>>> {
        if let Some(scene) = self.trees.doubles.clone() {
            return self.double_closest_point(py, points, detailed, &scene);
        }
        let n = points.len();
        let [mut at, mut distance] = [New::<f64>::empty(py, n, 3)?, New::empty(py, n, 1)?];
        let [mut prim, mut geom] = [New::<u32>::empty(py, n, 1)?, New::empty(py, n, 1)?];
        let m = if detailed { n } else { 0 };
        let [mut uv, mut normal] = [New::<f32>::empty(py, m, 2)?, New::empty(py, m, 3)?];
        {
            let (at, distance, prim, geom) = (at.all(), distance.all(), prim.all(), geom.all());
            let (uv, normal) = (uv.all(), normal.all());
            for (block, points) in points.chunks(POINTS).enumerate() {
                py.detach(|| {
                    let mut hits = Vec::new();
                    run_query!(self.trees, tree => tree.closest_points(&Query::default(), points, f64::INFINITY, self.workers.threads(), &mut hits));
                    for (i, hit) in hits.iter().enumerate() {
                        let i = block * POINTS + i;
                        let point = hit.map_or([f64::NAN; 3], |hit| hit.point);
                        at[3 * i..3 * i + 3].copy_from_slice(&point);
                        distance[i] = hit.map_or(f64::INFINITY, |hit| hit.distance);
                        prim[i] = hit.map_or(u32::MAX, |hit| hit.prim_id);
                        let name = |hit: PointHit| self.trees.ids([hit.geom_id, hit.inst_id, hit.leaf_id]).0;
                        geom[i] = hit.map_or(u32::MAX, name);
                        if detailed {
                            uv[2 * i..2 * i + 2]
                                .copy_from_slice(&hit.map_or([0.0; 2], |hit| [hit.u, hit.v]));
                            normal[3 * i..3 * i + 3]
                                .copy_from_slice(&hit.map_or([0.0; 3], |hit| self.trees.normal_at(&hit)));
                        }
                    }
                });
                py.check_signals()?;
            }
        }
        let mut all = vec![at.done(), distance.done(), prim.done_as("int32")?, geom.done_as("int32")?];
        if detailed {
            all.extend([uv.done(), normal.done()]);
        }
        Ok(all)
    }
}
