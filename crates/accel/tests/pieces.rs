// SPDX-License-Identifier: GPL-3.0-or-later
//! Ribbons in straight pieces equal exact ones where pieces are many, and differ by their bends where they are few; tubes are
//! met up to a thousandth of their radius from the silhouettes, by the distance from the curve.

use gnurt_accel::{BuildOptions, CurveBasis, CurveForm, Curves, Geometry, ObjectTree, Query, Ray, Threads};
use gnurt_testkit::Random;

/// An arc in the plane of x and z.
const ARC: [[f32; 4]; 4] =
    [[0.0, 0.0, 0.0, 0.1], [1.0, 0.0, 0.4, 0.1], [2.0, 0.0, 0.4, 0.1], [3.0, 0.0, 0.0, 0.1]];

fn tree(curves: Curves) -> ObjectTree {
    ObjectTree::build_from(&[Geometry::from(curves)], &BuildOptions::default(), Threads::Single)
}

fn arc_at(u: f64) -> [f64; 2] {
    let s = 1.0 - u;
    let weights = [s * s * s, 3.0 * s * s * u, 3.0 * s * u * u, u * u * u];
    [0, 2].map(|k| (0..4).map(|i| weights[i] * f64::from(ARC[i][k])).sum())
}

/// The least distance of a point of the plane from the arc, and the parameter there.
fn from_arc([x, z]: [f64; 2]) -> (f64, f64) {
    let distance = |u: f64| {
        let [a, b] = arc_at(u);
        (a - x).hypot(b - z)
    };
    let steps = 2000;
    let best = (0..=steps).map(|i| f64::from(i) / f64::from(steps));
    let best = best.min_by(|&a, &b| distance(a).total_cmp(&distance(b))).expect("there are some");
    let (mut low, mut high) = ((best - 1e-3).max(0.0), (best + 1e-3).min(1.0));
    for _ in 0..100 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if distance(a) < distance(b) { high = b } else { low = a }
    }
    (distance(low), low)
}

#[test]
fn tubes_are_met_up_to_their_silhouettes() {
    let tube = tree(Curves::new(CurveBasis::Bezier, CurveForm::Round, &ARC, &[0]));
    let (mut random, mut met) = (Random::new(3), 0);
    for i in 0..4000 {
        let (u, side) = (f64::from(random.between(0.05, 0.95)), if i % 2 == 0 { 1.0f64 } else { -1.0 });
        let [a, b] = [arc_at(u), arc_at(u + 1e-4)];
        let (dx, dz) = (b[0] - a[0], b[1] - a[1]);
        // Nearer and nearer to where it just touches, on either side.
        let off = 0.1 * (1.0 + 10f64.powi(-(i % 3) - 1) * if i % 3 == 0 { 1.0 } else { -1.0 }) * side;
        let (x, z) = ((a[0] - off * dz / dx.hypot(dz)) as f32, (a[1] + off * dx / dx.hypot(dz)) as f32);
        let (distance, u) = from_arc([f64::from(x), f64::from(z)]);
        let ray = Ray::new([x, -5.0, z], [0.0, 1.0, 0.0]);
        let mut hits = Vec::new();
        tube.all_hits(&Query::default(), &ray, &mut hits);
        let left = 0.1f32 as f64 * 0.1f32 as f64 - distance * distance;
        if left.abs() < 1e-8 || !(0.01..0.99).contains(&u) {
            continue;
        }
        met += usize::from(left > 0.0);
        let expected = if left > 0.0 { vec![5.0 - left.sqrt(), 5.0 + left.sqrt()] } else { Vec::new() };
        assert_eq!(hits.len(), expected.len(), "{distance} from the curve at {u}: {hits:?}");
        for (hit, t) in hits.iter().zip(expected) {
            assert!((f64::from(hit.t) - t).abs() < 1e-5, "{t} at {distance}: {hit:?}");
        }
    }
    assert!(met > 1000, "{met} rays meet it");
}

#[test]
fn many_pieces_are_the_ribbon() {
    let pieces =
        |pieces: u8| tree(Curves { pieces, ..Curves::new(CurveBasis::Bezier, CurveForm::Flat, &ARC, &[0]) });
    let (exact, one, many) = (pieces(0), pieces(1), pieces(255));
    let (mut random, mut met, mut others) = (Random::new(4), 0, 0);
    for _ in 0..4000 {
        let aim = [random.between(0.0, 3.0), 0.0, random.between(-0.15, 0.5)];
        let from = [random.between(0.0, 3.0), -4.0, random.between(-1.0, 1.5)];
        let ray = Ray::new(from, [0, 1, 2].map(|k| aim[k] - from[k]));
        let (a, b) = (exact.intersect(&ray), many.intersect(&ray));
        met += usize::from(a.is_some());
        match (a, b) {
            (Some(a), Some(b)) => {
                let near = |x: f32, y: f32| (x - y).abs() < 2e-2;
                assert!(near(a.t, b.t) && near(a.u, b.u) && near(a.v, b.v), "{a:?}, and in pieces {b:?}");
            }
            (None, None) => {}
            _ => others += 1,
        }
    }
    assert!(met > 800 && others * 100 < met, "{others} of {met} differ");
    // One piece is straight, from end to end.
    let down =
        |tree: &ObjectTree, z: f32| tree.intersect(&Ray::new([1.5, -4.0, z], [0.0, 1.0, 0.0])).is_some();
    assert!(down(&exact, 0.3) && !down(&exact, 0.0), "the ribbon is bent");
    assert!(down(&one, 0.0) && !down(&one, 0.3), "one piece is not");
    // A ray that starts on it goes on.
    let on = Ray::new([1.5, 0.0, 0.3], [0.0, 1.0, 0.001]);
    assert_eq!(many.intersect(&on), None, "within twice the radius");
}
