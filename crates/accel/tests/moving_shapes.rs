// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres, discs, curves and quads that move while the shutter is open: hits of a ray are those of a tree over the
//! geometry at its time.

use gnurt_accel::{
    BuildOptions, CurveBasis, CurveForm, Curves, Discs, Geometry, GeometryKind, Hit, Level, Moving,
    ObjectTree, Quads, Query, Ray, Spheres, Threads,
};

use gnurt_testkit::Random;

/// Arrays of all kinds at one key.
#[derive(Clone)]
struct Arrays {
    vertices: Vec<[f32; 4]>,
    normals: Vec<[f32; 3]>,
}

impl Arrays {
    fn random(random: &mut Random, count: usize) -> Self {
        let vertex = |random: &mut Random| {
            let [x, y, z] = random.point();
            [x, y, z, 0.02 + 0.1 * random.unit()]
        };
        Self {
            vertices: (0..count).map(|_| vertex(random)).collect(),
            normals: (0..count).map(|_| random.point()).collect(),
        }
    }

    fn mixed(&self, other: &Self, share: f32) -> Self {
        fn mix<const N: usize>(a: &[[f32; N]], b: &[[f32; N]], share: f32) -> Vec<[f32; N]> {
            let one =
                |(a, b): (&[f32; N], &[f32; N])| std::array::from_fn(|k| (1.0 - share) * a[k] + share * b[k]);
            a.iter().zip(b).map(one).collect()
        }
        Self {
            vertices: mix(&self.vertices, &other.vertices, share),
            normals: mix(&self.normals, &other.normals, share),
        }
    }

    fn points(&self) -> (Vec<[f32; 3]>, Vec<f32>) {
        self.vertices.iter().map(|&[x, y, z, radius]| ([x, y, z], radius)).unzip()
    }
}

fn hits(tree: &ObjectTree, ray: &Ray, level: Level) -> Option<Hit> {
    tree.intersect_with(&Query { level, ..Query::default() }, ray)
}

/// Compares motion through three keys with trees over `kind` at each ray's time.
fn check(
    name: &str,
    tolerance: f32,
    kind: impl for<'a> Fn(&'a Arrays, &'a [Vec<f32>; 1], &'a [Vec<[f32; 3]>; 1]) -> GeometryKind<'a>,
) {
    let mut random = Random::new(7);
    let keys: Vec<Arrays> = (0..3).map(|_| Arrays::random(&mut random, 40)).collect();
    let owned: Vec<_> =
        keys.iter().map(|key| (key.points().0, key.points().1)).map(|(p, r)| ([r], [p])).collect();
    let kinds: Vec<GeometryKind> =
        keys.iter().zip(&owned).map(|(key, (radii, centers))| kind(key, radii, centers)).collect();
    let options = BuildOptions::default();
    for range in [[0.0, 1.0], [-0.5, 2.0], [0.25, 0.75]] {
        let moving = Moving { range, ..Moving::new(&kinds) };
        let tree = ObjectTree::build_from(&[moving.into()], &options, Threads::Single);
        assert!(tree.moves(), "{name}");
        let (mut found, mut differ) = (0, 0);
        for i in 0..600 {
            let time = (i % 13) as f32 / 12.0;
            let (from, to) = (random.point(), random.point());
            let dir = [0, 1, 2].map(|k| to[k] - from[k]);
            let ray = Ray::new([0, 1, 2].map(|k| from[k] - 3.0 * dir[k]), dir).with_time(time);
            let at = 2.0 * (time - range[0]) / (range[1] - range[0]);
            let expected = (0.0..=2.0).contains(&at).then(|| {
                let first = (at as usize).min(1);
                let still = keys[first].mixed(&keys[first + 1], at - first as f32);
                let (centers, radii) = still.points();
                let (centers, radii) = ([centers], [radii]);
                let geometry = Geometry::new(kind(&still, &radii, &centers));
                let tree = ObjectTree::build_from(&[geometry], &options, Threads::Single);
                hits(&tree, &ray, Level::Scalar)
            });
            let expected = expected.flatten();
            for level in Level::available() {
                let got = hits(&tree, &ray, level);
                found += u32::from(got.is_some());
                let is_near = match (&got, &expected) {
                    (None, None) => true,
                    (Some(a), Some(b)) => a.prim_id == b.prim_id && (a.t - b.t).abs() < tolerance * b.t,
                    _ => false,
                };
                differ += u32::from(!is_near);
                assert_eq!(got, hits(&tree, &ray, Level::Scalar), "{name}: the same at {level:?}");
                let any = tree.occluded_with(&Query { level, ..Query::default() }, &ray);
                assert_eq!(any, got.is_some(), "{name}: occlusion");
            }
        }
        assert!(found > 100, "{name}: {found} hits");
        // Grazing rays decide by rounding.
        assert!(differ <= found / 200, "{name} in {range:?}: {differ} of {found} differ");
    }
}

#[test]
fn spheres_are_where_they_are_at_the_time() {
    check("spheres", 1e-4, |_, radii, centers| {
        GeometryKind::Spheres(Spheres { centers: &centers[0], radii: &radii[0] })
    });
}

#[test]
fn discs_are_where_they_are_at_the_time() {
    check("discs", 1e-4, |arrays, radii, centers| {
        let normals = Some(&arrays.normals[..]);
        GeometryKind::Discs(Discs { centers: &centers[0], radii: &radii[0], normals })
    });
}

#[test]
fn curves_are_where_they_are_at_the_time() {
    const INDICES: [u32; 9] = [0, 4, 8, 12, 16, 20, 24, 28, 32];
    let forms = [CurveForm::Flat, CurveForm::Round, CurveForm::Oriented];
    for (form, basis) in
        forms.into_iter().zip([CurveBasis::BSpline, CurveBasis::Bezier, CurveBasis::CatmullRom])
    {
        check("curves", 1e-3, |arrays, _, _| {
            let curves = Curves::new(basis, form, &arrays.vertices, &INDICES);
            GeometryKind::Curves(curves.with_normals(&arrays.normals))
        });
    }
    check("lines", 1e-3, |arrays, _, _| {
        GeometryKind::Curves(Curves::new(CurveBasis::Linear, CurveForm::Round, &arrays.vertices, &INDICES))
    });
}

#[test]
fn quads_are_where_they_are_at_the_time() {
    const INDICES: [[u32; 4]; 9] = [
        [0, 1, 2, 3],
        [4, 5, 6, 7],
        [8, 9, 10, 11],
        [12, 13, 14, 15],
        [16, 17, 18, 19],
        [20, 21, 22, 23],
        [24, 25, 26, 27],
        [28, 29, 30, 31],
        [32, 33, 34, 35],
    ];
    check("quads", 1e-4, |_, _, centers| {
        GeometryKind::Quads(Quads { positions: &centers[0], indices: &INDICES })
    });
}

#[test]
fn keys_of_several_kinds_are_nothing() {
    let (centers, radii) = ([[0.0; 3]], [1.0]);
    let spheres = GeometryKind::Spheres(Spheres { centers: &centers, radii: &radii });
    let discs = GeometryKind::Discs(Discs { centers: &centers, radii: &radii, normals: None });
    let keys = [spheres, discs];
    let tree =
        ObjectTree::build_from(&[Moving::new(&keys).into()], &BuildOptions::default(), Threads::Single);
    assert!(tree.bounds().is_empty(), "no primitive");
}
