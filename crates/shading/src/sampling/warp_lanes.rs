// SPDX-License-Identifier: GPL-3.0-or-later
//! Maps from the unit square for one sample or sixteen: see `warp`.
//! Source: as `warp`; sine and cosine by Taylor's series, which within an eighth of a turn end soon: so they are the same on
//! every system, whatever its library's sine is.
//! Tests: `tests`, those of `warp`.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use crate::real::{Real, Vector};

/// See [`concentric_disk`](super::concentric_disk).
#[inline(always)]
pub(crate) fn concentric_disk_of<R: Real>(u: [R; 2]) -> [R; 2] {
    let (zero, one) = (u[0].all(0.0), u[0].all(1.0));
    let (x, y) = (u[0] * 2.0 - one, u[1] * 2.0 - one);
    let wide = x.size().above(y.size());
    let (radius, less) = (R::pick(wide, x, y), R::pick(wide, y, x));
    // Where both are zero the radius is, and any angle will do.
    let angle = R::pick(radius.is(zero), zero, less / radius * FRAC_PI_4);
    let (sin, cos) = sin_cos(angle);
    [radius * R::pick(wide, cos, sin), radius * R::pick(wide, sin, cos)]
}

/// See [`cosine_hemisphere`](super::cosine_hemisphere).
#[inline(always)]
pub fn cosine_hemisphere_of<R: Real>(u: [R; 2]) -> Vector<R> {
    let [x, y] = concentric_disk_of(u);
    let z = (x * x + y * y).rest().or_more(x.all(0.0)).root();
    Vector::new(x, y, z)
}

/// Sine and cosine of angles of at most an eighth of the circle.
#[inline(always)]
fn sin_cos<R: Real>(a: R) -> (R, R) {
    let a2 = a * a;
    let sin = ((a2 * (1.0 / 362_880.0) + a.all(-1.0 / 5_040.0)) * a2 + a.all(1.0 / 120.0)) * a2;
    let sin = a + a * ((sin + a.all(-1.0 / 6.0)) * a2);
    let cos = ((a2 * (1.0 / 40_320.0) + a.all(-1.0 / 720.0)) * a2 + a.all(1.0 / 24.0)) * a2;
    let cos = a.all(1.0) + (cos + a.all(-0.5)) * a2;
    (sin, cos)
}

/// Sine and cosine of `fraction` in [0, 1], 1 being all around.
#[inline(always)]
pub(crate) fn sin_cos_of_fraction<R: Real>(fraction: R) -> (R, R) {
    let quarters = (fraction * 4.0 + fraction.all(0.5)).whole();
    let (sin, cos) = sin_cos((fraction * 4.0 - quarters) * FRAC_PI_2);
    let is = |k: f32| quarters.is(fraction.all(k));
    let odd = is(1.0) | is(3.0);
    let (s, c) = (R::pick(odd, cos, sin), R::pick(odd, sin, cos));
    (R::pick(is(2.0) | is(3.0), -s, s), R::pick(is(1.0) | is(2.0), -c, c))
}

/// Barycentric weights of a triangle's second and third vertex, uniform by area.
#[inline(always)]
pub fn triangle<R: Real>([a, b]: [R; 2]) -> [R; 2] {
    // Fold the square along its diagonal; halving first keeps neighbours together.
    let (above, half_a, half_b) = (b.above(a), a * 0.5, b * 0.5);
    [R::pick(above, half_a, a - half_b), R::pick(above, b - half_a, half_b)]
}

/// The frame that [`Basis::around`](super::Basis::around) makes: tangent and bitangent.
#[inline(always)]
pub(crate) fn frame_around<R: Real>(n: Vector<R>) -> [Vector<R>; 2] {
    let one = n.x.all(1.0);
    // A negative zero counts as positive, which makes no difference to a frame.
    let sign = R::pick(n.z.all(0.0).above(n.z), -one, one);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = Vector::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let bitangent = Vector::new(b, sign + n.y * n.y * a, -n.y);
    [tangent, bitangent]
}

#[cfg(test)]
mod tests {
    use super::super::Basis;
    use super::*;
    use crate::batch::SampleKey;
    use crate::lanes::{LANES, Vec3x16};
    use crate::sampling::sample_pair;
    use glam::Vec3;
    use gnurt_simd::{Level, Simd, dispatch, f32x16, prelude::*};

    type Found = (Vec3, [f32; 2], Vec3, [f32; 2]);

    fn maps<R: Real>(u: [R; 2], n: Vector<R>) -> (Vector<R>, Vector<R>, (R, R)) {
        let (dir, [tangent, bitangent]) = (cosine_hemisphere_of(u), frame_around(n));
        (dir, tangent * dir.x + bitangent * dir.y + n * dir.z, sin_cos_of_fraction(u[0]))
    }

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, u: &[[f32; 2]; LANES], n: Vec3) -> [Found; LANES] {
        let numbers = [0, 1].map(|k| f32x16::from_fn(simd, |i| u[i][k]));
        let ((dir, world, (sin, cos)), weights) = (maps(numbers, Vec3x16::splat(simd, n)), triangle(numbers));
        std::array::from_fn(|i| (dir.get(i), weights.map(|w| w[i]), world.get(i), [sin[i], cos[i]]))
    }

    #[test]
    fn the_same_maps_at_every_level() {
        for round in 0..512 {
            let u = std::array::from_fn(|i| {
                let key = SampleKey { pixel: round, sample: i as u32, branch: 0 };
                // Centre, edges and diagonals too.
                if round == 0 { [i % 4, i / 4].map(|k| k as f32 * 0.25) } else { sample_pair(1, key, 0, 0) }
            });
            let n = super::super::cosine_hemisphere(sample_pair(2, SampleKey::default(), round, 3));
            let n = if round % 2 == 0 { n } else { -n };
            for level in Level::available() {
                let found = dispatch!(level, simd => in_lanes(simd, &u, n));
                for (u, (dir, weights, world, turned)) in u.into_iter().zip(found) {
                    let (expected, of_world, (sin, cos)) = maps(u, n.into());
                    assert_eq!(
                        (dir, world),
                        (expected.into(), of_world.into()),
                        "{u:?} around {n} at {level}"
                    );
                    assert_eq!(turned, [sin, cos], "{u:?} at {level}");
                    let (s, c) = (f64::from(u[0]) * std::f64::consts::TAU).sin_cos();
                    let off = (f64::from(sin) - s).abs().max((f64::from(cos) - c).abs());
                    assert!(off < 3e-7, "{u:?}: {sin}, {cos} for {s}, {c}");
                    assert_eq!(weights, triangle(u), "{u:?}");
                    let basis = Basis::around(n).to_world(dir);
                    assert!((world - basis).length() < 1e-6, "{u:?} around {n}: {world}, {basis}");
                }
            }
        }
    }
}
