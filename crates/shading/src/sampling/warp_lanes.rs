// SPDX-License-Identifier: GPL-3.0-or-later
//! Maps from the unit square for sixteen samples at once: see `warp`.
//! Source: as `warp`; sine and cosine by Taylor's series, which within an eighth of a turn end soon.
//! Invariants: all have the bits of the scalar form, directions those of `cosine_hemisphere_by_series`, which differ from
//! `cosine_hemisphere` by rounding only.
//! Proof: `tests::the_same_maps`.

use std::f32::consts::FRAC_PI_4;

use gnurt_simd::{Simd, f32x16, prelude::*};

use crate::lanes::{Floats, Vec3x16, floats};

/// See [`cosine_hemisphere_by_series`](super::cosine_hemisphere_by_series).
#[inline(always)]
pub fn cosine_hemisphere_x16<S: Simd>(u: [Floats<S>; 2]) -> Vec3x16<S> {
    let simd = u[0].token();
    let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
    let (x, y) = (u[0] * 2.0 - one, u[1] * 2.0 - one);
    let wide = x.abs().simd_gt(y.abs());
    let (radius, less) = (wide.select(x, y), wide.select(y, x));
    // Where both are zero the radius is, and any angle will do.
    let angle = radius.simd_eq(zero).select(zero, f32x16::splat(simd, FRAC_PI_4) * (less / radius));
    let (sin, cos) = sin_cos(angle);
    let (x, y) = (radius * wide.select(cos, sin), radius * wide.select(sin, cos));
    let z = (one - (x * x + y * y)).max(zero).sqrt();
    Vec3x16::new(x, y, z)
}

/// Sine and cosine of angles of at most an eighth of a turn.
#[inline(always)]
fn sin_cos<S: Simd>(a: Floats<S>) -> (Floats<S>, Floats<S>) {
    let simd = a.token();
    let a2 = a * a;
    let sin = ((a2 * (1.0 / 362_880.0) + floats(simd, -1.0 / 5_040.0)) * a2 + floats(simd, 1.0 / 120.0)) * a2;
    let sin = a + a * ((sin + floats(simd, -1.0 / 6.0)) * a2);
    let cos = ((a2 * (1.0 / 40_320.0) + floats(simd, -1.0 / 720.0)) * a2 + floats(simd, 1.0 / 24.0)) * a2;
    let cos = floats(simd, 1.0) + (cos + floats(simd, -0.5)) * a2;
    (sin, cos)
}

/// See [`triangle`](super::triangle).
#[inline(always)]
pub fn triangle_x16<S: Simd>([a, b]: [Floats<S>; 2]) -> [Floats<S>; 2] {
    let above = b.simd_gt(a);
    let (half_a, half_b) = (a * 0.5, b * 0.5);
    [above.select(half_a, a - half_b), above.select(b - half_a, half_b)]
}

/// `v` in the frame that [`Basis::around`](super::Basis::around) makes, in the world.
#[inline(always)]
pub fn to_world_x16<S: Simd>(normal: Vec3x16<S>, v: Vec3x16<S>) -> Vec3x16<S> {
    let n = normal;
    let one = f32x16::splat(n.x.token(), 1.0);
    let sign = one.copysign(n.z);
    let a = -one / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = Vec3x16::new(one + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let bitangent = Vec3x16::new(b, sign + n.y * n.y * a, -n.y);
    tangent * v.x + bitangent * v.y + n * v.z
}

#[cfg(test)]
mod tests {
    use super::super::{Basis, cosine_hemisphere, cosine_hemisphere_by_series, triangle};
    use super::*;
    use crate::batch::SampleKey;
    use crate::lanes::LANES;
    use crate::sampling::sample_pair;
    use glam::Vec3;
    use gnurt_simd::{Level, dispatch_wide};

    #[inline(always)]
    fn in_lanes<S: Simd>(simd: S, u: &[[f32; 2]; LANES], n: Vec3) -> [(Vec3, [f32; 2], Vec3); LANES] {
        let numbers = [0, 1].map(|k| f32x16::from_fn(simd, |i| u[i][k]));
        let (dir, weights) = (cosine_hemisphere_x16(numbers), triangle_x16(numbers));
        let world = to_world_x16(Vec3x16::splat(simd, n), dir);
        std::array::from_fn(|i| (dir.get(i), weights.map(|w| w[i]), world.get(i)))
    }

    #[test]
    fn the_same_maps() {
        for round in 0..512 {
            let u = std::array::from_fn(|i| {
                let key = SampleKey { pixel: round, sample: i as u32, branch: 0 };
                // Centre, edges and diagonals too.
                if round == 0 { [i % 4, i / 4].map(|k| k as f32 * 0.25) } else { sample_pair(1, key, 0, 0) }
            });
            let n = cosine_hemisphere(sample_pair(2, SampleKey::default(), round, 3));
            let n = if round % 2 == 0 { n } else { -n };
            let found = dispatch_wide!(Level::default(), simd => in_lanes(simd, &u, n), else return);
            for (u, (dir, weights, world)) in u.into_iter().zip(found) {
                assert_eq!(dir, cosine_hemisphere_by_series(u), "{u:?}");
                let wanted = cosine_hemisphere(u);
                // The height of what is nearly flat is a root of what rounding left.
                let error = (dir - wanted).abs() * Vec3::new(1.0, 1.0, wanted.z.max(1e-3));
                assert!(error.max_element() < 2.5e-7, "{u:?}: {dir} instead of {wanted}");
                assert_eq!(weights, triangle(u), "{u:?}");
                assert_eq!(world, Basis::around(n).to_world(dir), "{u:?} around {n}");
            }
        }
    }
}
