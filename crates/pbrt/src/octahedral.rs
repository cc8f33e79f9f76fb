// SPDX-License-Identifier: GPL-3.0-or-later
//! The map from the square to the sphere that keeps areas, by which pbrt-v4 stores light from all directions.
//! Source: P. Clarberg, Fast Equal-Area Mapping of the (Hemi)Sphere using SIMD, 2008. Invariant: the two functions undo each other.
//! Tests: `tests`.

use std::f64::consts::FRAC_PI_4;

/// The direction of a place in the unit square.
pub(crate) fn direction([x, y]: [f64; 2]) -> [f64; 3] {
    let (u, v) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let (across, along) = (u.abs(), v.abs());
    // How far it lies within the diagonal.
    let within = 1.0 - (across + along);
    let r = 1.0 - within.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((along - across) / r + 1.0) * FRAC_PI_4 };
    let z = (1.0 - r * r).copysign(within);
    let side = r * (2.0 - r * r).max(0.0).sqrt();
    [phi.cos().copysign(u) * side, phi.sin().copysign(v) * side, z]
}

/// The place of a unit direction in the unit square.
pub(crate) fn square([x, y, z]: [f64; 3]) -> [f64; 2] {
    let r = (1.0 - z.abs()).max(0.0).sqrt();
    let phi = if x == 0.0 && y == 0.0 { 0.0 } else { y.abs().atan2(x.abs()) / (2.0 * FRAC_PI_4) };
    let (mut u, mut v) = (r - phi * r, phi * r);
    if z < 0.0 {
        (u, v) = (1.0 - v, 1.0 - u);
    }
    [0.5 * (u.copysign(x) + 1.0), 0.5 * (v.copysign(y) + 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for i in 0..400 {
            let at = [(f64::from(i % 20) + 0.37) / 20.0, (f64::from(i / 20) + 0.61) / 20.0];
            let dir = direction(at);
            let length: f64 = dir.iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-12, "unit: {dir:?}");
            let back = square(dir);
            assert!((0..2).all(|k| (back[k] - at[k]).abs() < 1e-9), "{at:?} {dir:?} {back:?}");
        }
        assert_eq!(direction([0.5, 0.5]), [0.0, 0.0, 1.0], "the middle is above");
    }
}
