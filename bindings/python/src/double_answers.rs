// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of ray scenes in double precision, with float64 answers. Structure as in `answers.rs`.
//! Tests: `tests/test_doubles.py`.

use gnurt_accel::Threads;
use gnurt_accel::doubles::{DoubleHit, DoublePoint, DoubleRay, DoubleScene};
use pyo3::prelude::*;
use rayon::prelude::*;

use crate::answers::{AnyHit, POINTS, RayQuery, Which};
use crate::arrays::New;
use crate::hits::{AllHits, Found, Hits, Origin};
use crate::rays::Rays;

impl AnyHit for DoubleHit {
    type Number = f64;

    fn numbers(&self) -> [f64; 3] {
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
    pub(crate) fn double_intersect(self, py: Python<'_>, rays: &Rays, scene: &DoubleScene) -> PyResult<Hits> {
        let n = rays.count();
        let floats = || New::<f64>::empty(py, n, 1);
        let numbers = || New::<u32>::empty(py, n, 1);
        let [mut t, mut u, mut v] = [floats()?, floats()?, floats()?];
        let [mut prim, mut geom, mut inst] = [numbers()?, numbers()?, numbers()?];
        let mut ids = Vec::with_capacity(n);
        {
            let (t, u, v) = (t.all(), u.all(), v.all());
            let (prim, geom, inst) = (prim.all(), geom.all(), inst.all());
            for range in rays.blocks() {
                let list = rays.doubles(&range);
                py.detach(|| {
                    let hits = scene.intersect_batch(&list, self.workers.threads());
                    for (i, hit) in range.clone().zip(&hits) {
                        (t[i], u[i], v[i]) =
                            hit.map_or((f64::INFINITY, 0.0, 0.0), |hit| (hit.t, hit.u, hit.v));
                        prim[i] = hit.map_or(u32::MAX, |hit| hit.prim_id);
                        let named = hit.map(|hit| self.trees.ids(hit.ids()));
                        (geom[i], inst[i]) = named.unwrap_or((u32::MAX, u32::MAX));
                        let of = |hit: DoubleHit| [hit.prim_id, hit.geom_id, hit.inst_id, hit.leaf_id];
                        ids.push(hit.map_or([u32::MAX; 4], of));
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
                normals: None,
            }),
        })
    }

    /// One answer for each ray.
    fn double_rays<T: Copy + Send>(
        &self,
        py: Python<'_>,
        rays: &Rays,
        all: &mut [T],
        answer: impl Fn(&[DoubleRay], Threads) -> Vec<T> + Sync + Send,
    ) -> PyResult<()> {
        for range in rays.blocks() {
            let list = rays.doubles(&range);
            let part = &mut all[range];
            py.detach(|| part.copy_from_slice(&answer(&list, self.workers.threads())));
            py.check_signals()?;
        }
        Ok(())
    }

    pub(crate) fn double_occluded(
        self,
        py: Python<'_>,
        rays: &Rays,
        scene: &DoubleScene,
    ) -> PyResult<Py<PyAny>> {
        let mut answers = New::<u8>::empty(py, rays.count(), 1)?;
        self.double_rays(py, rays, answers.all(), |list, threads| {
            scene.occluded_batch(list, threads).into_iter().map(u8::from).collect()
        })?;
        answers.done_as("bool")
    }

    pub(crate) fn double_crossings(
        self,
        py: Python<'_>,
        rays: &Rays,
        scene: &DoubleScene,
    ) -> PyResult<Py<PyAny>> {
        let mut answers = New::<u32>::empty(py, rays.count(), 1)?;
        self.double_rays(py, rays, answers.all(), |list, threads| scene.crossings_batch(list, threads))?;
        answers.done_as("int32")
    }

    pub(crate) fn double_all_hits(
        self,
        py: Python<'_>,
        rays: &Rays,
        which: Which,
        scene: &DoubleScene,
    ) -> PyResult<AllHits> {
        let mut splits = vec![0i64];
        let mut all: Vec<DoubleHit> = Vec::new();
        for range in rays.blocks() {
            let list = rays.doubles(&range);
            py.detach(|| {
                let of = |ray: &DoubleRay| {
                    let mut hits = Vec::new();
                    match which {
                        Which::First(most) => scene.first_hits(ray, most, &mut hits),
                        Which::Crossed => scene.crossing_hits(ray, &mut hits),
                    }
                    hits
                };
                let parts: Vec<Vec<DoubleHit>> = self.workers.threads().run(|parallel| {
                    if parallel {
                        list.par_iter().with_min_len(256).map(of).collect()
                    } else {
                        list.iter().map(of).collect()
                    }
                });
                for hits in parts {
                    splits.push(splits[splits.len() - 1] + hits.len() as i64);
                    all.extend(hits);
                }
            });
            py.check_signals()?;
        }
        self.listed(py, &splits, &all)
    }

    pub(crate) fn double_contains(
        self,
        py: Python<'_>,
        points: &[[f64; 3]],
        scene: &DoubleScene,
    ) -> PyResult<Py<PyAny>> {
        let mut answers = New::<u8>::empty(py, points.len(), 1)?;
        for (points, part) in points.chunks(POINTS).zip(answers.all().chunks_mut(POINTS)) {
            py.detach(|| {
                let inside = scene.contains_batch(points, u32::MAX, self.workers.threads());
                part.iter_mut().zip(inside).for_each(|(into, is)| *into = u8::from(is));
            });
            py.check_signals()?;
        }
        answers.done_as("bool")
    }

    pub(crate) fn double_distance(
        self,
        py: Python<'_>,
        points: &[[f64; 3]],
        signed: bool,
        scene: &DoubleScene,
    ) -> PyResult<Py<PyAny>> {
        let mut answers = New::<f64>::empty(py, points.len(), 1)?;
        for (points, part) in points.chunks(POINTS).zip(answers.all().chunks_mut(POINTS)) {
            py.detach(|| {
                let threads = self.workers.threads();
                if signed {
                    part.copy_from_slice(&scene.signed_distance_batch(points, u32::MAX, threads));
                } else {
                    let found = scene.closest_points(points, f64::INFINITY, u32::MAX, threads);
                    let distance =
                        |found: &Option<DoublePoint>| found.map_or(f64::INFINITY, |found| found.distance);
                    part.iter_mut().zip(&found).for_each(|(into, found)| *into = distance(found));
                }
            });
            py.check_signals()?;
        }
        Ok(answers.done())
    }

    /// As `closest_point`; weights and normals are in double precision, too.
    pub(crate) fn double_closest_point(
        self,
        py: Python<'_>,
        points: &[[f64; 3]],
        detailed: bool,
        scene: &DoubleScene,
    ) -> PyResult<Vec<Py<PyAny>>> {
        let n = points.len();
        let [mut at, mut distance] = [New::<f64>::empty(py, n, 3)?, New::empty(py, n, 1)?];
        let [mut prim, mut geom] = [New::<u32>::empty(py, n, 1)?, New::empty(py, n, 1)?];
        let m = if detailed { n } else { 0 };
        let [mut uv, mut normal] = [New::<f64>::empty(py, m, 2)?, New::empty(py, m, 3)?];
        for (block, points) in points.chunks(POINTS).enumerate() {
            let (at, distance, prim, geom) = (at.all(), distance.all(), prim.all(), geom.all());
            let (uv, normal) = (uv.all(), normal.all());
            py.detach(|| {
                let all = scene.closest_points(points, f64::INFINITY, u32::MAX, self.workers.threads());
                for (i, found) in all.iter().enumerate() {
                    let i = block * POINTS + i;
                    at[3 * i..3 * i + 3].copy_from_slice(&found.map_or([f64::NAN; 3], |found| found.point));
                    distance[i] = found.map_or(f64::INFINITY, |found| found.distance);
                    prim[i] = found.map_or(u32::MAX, |found| found.prim_id);
                    let name =
                        |found: DoublePoint| self.trees.ids([found.geom_id, found.inst_id, found.leaf_id]).0;
                    geom[i] = found.map_or(u32::MAX, name);
                    if detailed {
                        uv[2 * i..2 * i + 2]
                            .copy_from_slice(&found.map_or([0.0; 2], |found| [found.u, found.v]));
                        let upright =
                            |found: DoublePoint| scene.normal(found.leaf_id, found.geom_id, found.prim_id);
                        normal[3 * i..3 * i + 3].copy_from_slice(&found.map_or([0.0; 3], upright));
                    }
                }
            });
            py.check_signals()?;
        }
        let mut all = vec![at.done(), distance.done(), prim.done_as("int32")?, geom.done_as("int32")?];
        if detailed {
            all.extend([uv.done(), normal.done()]);
        }
        Ok(all)
    }
}
