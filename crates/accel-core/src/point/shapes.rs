// SPDX-License-Identifier: GPL-3.0-or-later
//! The nearest points of a triangle and of a sphere.
//! Source: triangle: [Eri04] section 5.1.5 (regions of corners, edges and the inside); sphere under an affine map: original,
//! the secular equation of trust region methods [GL13]. Space: where distances count, around the given point.
//! Tests: `tests::nearest_of_many_points`, `tests/closest_point.rs`.

use super::Probe;
use super::probe::{eigen, square};

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// The point of a triangle that is nearest to the origin, and the weights of its second and third corner.
pub fn on_triangle([a, b, c]: [[f64; 3]; 3]) -> ([f64; 3], [f64; 2]) {
    let (ab, ac) = (minus(b, a), minus(c, a));
    let (d1, d2) = (-dot(ab, a), -dot(ac, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, [0.0, 0.0]);
    }
    let (d3, d4) = (-dot(ab, b), -dot(ac, b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, [1.0, 0.0]);
    }
    let at = |u: f64, v: f64| ([0, 1, 2].map(|k| a[k] + u * ab[k] + v * ac[k]), [u, v]);
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return at(d1 / (d1 - d3), 0.0);
    }
    let (d5, d6) = (-dot(ab, c), -dot(ac, c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, [0.0, 1.0]);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return at(0.0, d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return at(1.0 - w, w);
    }
    let sum = va + vb + vc;
    at(vb / sum, vc / sum)
}

/// The offset from the probe to the nearest point of a sphere of the searched space, where distances count:
/// there the sphere may be an ellipsoid.
///
/// With `y` from the centre to the target point and `w` to the probe, `|axes * (y - w)|` is least under `|y|
/// = r` where `(M - l) y = M w`. Here `M = axes^T axes`, and `l` is the one value below all eigenvalues of
/// `M` that gives `y` its length.
pub fn on_sphere(probe: &Probe, center: [f64; 3], radius: f64) -> [f64; 3] {
    let from_center = minus(probe.point, center);
    let (m, vectors) = eigen(&square(&probe.axes));
    let w = vectors.map(|v| dot(v, from_center));
    let back = |y: [f64; 3]| {
        let y = [0, 1, 2].map(|k| (0..3).map(|i| y[i] * vectors[i][k]).sum::<f64>() - from_center[k]);
        probe.vector(y)
    };
    let length = dot(w, w).sqrt();
    if m[2] - m[0] <= 1e-13 * m[2] && length > 0.0 {
        return back(w.map(|x| x * (radius / length)));
    }
    let at = |l: f64| [0, 1, 2].map(|i| if w[i] == 0.0 { 0.0 } else { m[i] * w[i] / (m[i] - l) });
    // All that the axes of greater growth can contribute may be too little: the rest lies along the least.
    let rest = [1, 2].map(|i| if m[i] > m[0] { at(m[0])[i] } else { 0.0 });
    let short = radius * radius - rest[0] * rest[0] - rest[1] * rest[1];
    let flat = (0..3).all(|i| w[i] == 0.0 || m[i] > m[0]);
    if flat && short >= 0.0 {
        return back([short.sqrt(), rest[0], rest[1]]);
    }
    let (mut low, mut high) = (m[0] - m[2] * (length / radius).max(1.0), m[0]);
    while dot(at(low), at(low)) > radius * radius {
        low -= 2.0 * (high - low);
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if dot(at(middle), at(middle)) > radius * radius { high = middle } else { low = middle }
    }
    let y = at(low);
    let scale = radius / dot(y, y).sqrt();
    back(y.map(|x| x * scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in `[-1, 1)`.
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 40) as f64 / f64::from(1 << 23) - 1.0
    }

    #[test]
    fn nearest_of_many_points() {
        let mut state = 5;
        let mut point = || [0; 3].map(|_| random(&mut state));
        for round in 0..300 {
            let corners = [point(), point(), point()];
            let (found, [u, v]) = on_triangle(corners);
            let at = |u: f64, v: f64| {
                [0, 1, 2].map(|k| (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k])
            };
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-12, "{u} and {v} are weights");
            let same = minus(found, at(u, v));
            assert!(dot(same, same) < 1e-24, "the weights are those of the point");
            for i in 0..=40 {
                for j in 0..=40 - i {
                    let other = at(f64::from(i) / 40.0, f64::from(j) / 40.0);
                    assert!(
                        dot(found, found) <= dot(other, other) + 1e-12,
                        "{other:?} is nearer than {found:?}"
                    );
                }
            }

            let mut axes = [point(), point(), point()];
            let mut p = point().map(|x| 2.0 * x);
            match round % 6 {
                0 => axes = [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, -2.0, 0.0]],
                1 => (axes, p[0]) = ([[0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]], 0.0),
                2 => (axes, p) = ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 3.0]], [0.0; 3]),
                _ => {}
            }
            let probe = Probe::new([0.0; 3], !0).inside(p, &axes);
            let found = on_sphere(&probe, [0.0; 3], 0.75);
            // On the sphere, and nothing on it is nearer.
            let best = dot(found, found).sqrt();
            let mut nearest = f64::INFINITY;
            for _ in 0..3000 {
                let d = point();
                let scale = 0.75 / dot(d, d).sqrt();
                let offset = probe.offset(d.map(|x| x * scale));
                nearest = nearest.min(dot(offset, offset).sqrt());
            }
            assert!(
                best <= nearest + 1e-9 && best > nearest - 0.4,
                "{best}, of many points {nearest}: {axes:?}, {p:?}"
            );
        }
    }
}
