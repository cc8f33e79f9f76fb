// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the light of a shape goes that its shader sends to some directions alone: spots, lamps with a narrow spread, fixtures.
//! Choices among lamps ask it; emission itself is the shader's.
//! Source: the cone of a light's emission in [EK18]. Differs: a table of brightness within it. Space: world.
//! Invariant: within the cone around all directions that samples of the emission showed to be lit no direction is quite dark;
//! outside of it only scattered rays find light, as on sides that were dark at all samples.
//! Tests: `tests`, `light_set_tests`, crates/render/tests/beams.rs.

use glam::Vec3;

use super::light_estimates::LEAST_SHARE;
use crate::real::{Real, Vector};
use crate::sampling::octahedron::{direction_of, square_of, stretch};

/// Cells of the square of directions along a side.
const SIDE: usize = 48;
/// Least share of the light's directions that are dark: other emission is even enough to choose by its mean.
const LEAST_DARK: f64 = 1.0 / 8.0;

/// Brightness by direction of light that leaves a shape, over its mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Beam {
    /// The square of an octahedron, row by row.
    cells: Vec<f32>,
    /// The brightest.
    peak: f32,
    /// A cone around all directions that are not dark: its axis, unit, and the cosine of its half angle.
    cone: (Vec3, f32),
}

impl Beam {
    /// Directions in which [`new`](Self::new) needs the brightness, unit, away from the shape: corners of cells.
    pub fn directions() -> impl Iterator<Item = Vec3> {
        let at = |i: usize| i as f32 / SIDE as f32;
        (0..=SIDE).flat_map(move |y| (0..=SIDE).map(move |x| direction_of([at(x), at(y)])))
    }

    /// By the brightness in each of these directions, and along a triangle's `normal`; with the mean brightness over the shape and,
    /// by cosines, all directions. `None` if most directions are lit, or none is.
    #[must_use]
    pub fn new(bright: &[f32], normal: Option<(Vec3, f32)>) -> Option<(Self, f32)> {
        let weights = Self::directions().map(|dir| {
            let cos = normal.map_or(1.0, |(normal, _)| normal.dot(dir).max(0.0));
            f64::from(stretch(dir) * cos)
        });
        let (mut whole, mut dark, mut sum) = (0.0, 0.0, 0.0);
        for (weight, &bright) in weights.zip(bright) {
            whole += weight;
            dark += if bright > 0.0 { 0.0 } else { weight };
            sum += weight * f64::from(bright);
        }
        let mut cells = Vec::with_capacity(SIDE * SIDE);
        for y in 0..SIDE {
            for x in 0..SIDE {
                let corner = |x: usize, y: usize| bright[y * (SIDE + 1) + x];
                let [a, b] = [y, y + 1].map(|y| corner(x, y).max(corner(x + 1, y)));
                cells.push(a.max(b));
            }
        }
        if let Some((normal, bright)) = normal {
            // Narrow light along the normal may lie between corners.
            let here = &mut cells[index(cell(Vector::from(normal)))];
            sum += if *here > 0.0 { 0.0 } else { f64::from(bright * stretch(normal)) };
            *here = here.max(bright);
        }
        let (peak, mean) = (cells.iter().fold(0.0_f32, |peak, &x| peak.max(x)), (sum / whole) as f32);
        if !(mean > 0.0 && peak.is_finite() && dark >= LEAST_DARK * whole) {
            return None;
        }
        let (least, cone) = (LEAST_SHARE * peak, cone(&cells));
        for (i, cell) in cells.iter_mut().enumerate() {
            let is_within = corners(i).any(|corner| corner.dot(cone.0) >= cone.1);
            *cell = if is_within { cell.max(least) / mean } else { 0.0 };
        }
        Some((Self { cells, peak: peak / mean, cone }, mean))
    }

    /// A cone around all directions that are not dark: its axis, unit, and the cosine of its half angle; -1 for all directions.
    #[must_use]
    pub fn cone(&self) -> (Vec3, f32) {
        self.cone
    }

    /// The brightest direction's share.
    #[must_use]
    pub fn peak(&self) -> f32 {
        self.peak
    }

    /// The mean over these cells.
    #[inline(always)]
    pub(super) fn share<R: Real>(&self, cells: [R; 4]) -> R {
        let sum = cells[0].each(
            #[inline(always)]
            |i| {
                let [a, b, c, d] = [cells[0].lane(i), cells[1].lane(i), cells[2].lane(i), cells[3].lane(i)];
                (self.cells[index(a)] + self.cells[index(b)]) + (self.cells[index(c)] + self.cells[index(d)])
            },
        );
        sum * 0.25
    }
}

/// The corners of a cell, as unit directions.
fn corners(cell: usize) -> impl Iterator<Item = Vec3> {
    let at = move |x: usize, y: usize| {
        direction_of([cell % SIDE + x, cell / SIDE + y].map(|x| x as f32 / SIDE as f32))
    };
    [[0, 0], [0, 1], [1, 0], [1, 1]].into_iter().map(move |[x, y]| at(x, y))
}

/// The cone of the cells that are not dark.
fn cone(cells: &[f32]) -> (Vec3, f32) {
    let lit = || (0..cells.len()).filter(|&i| cells[i] > 0.0);
    let axis: Vec3 = lit().flat_map(|i| corners(i).map(move |dir| dir * stretch(dir) * cells[i])).sum();
    let axis = axis.normalize_or(Vec3::Z);
    let least = lit().flat_map(corners).map(|dir| axis.dot(dir)).fold(1.0, f32::min);
    // Wider by half a cell, for light between corners.
    let half = least.clamp(-1.0, 1.0).acos() + 2.0 / SIDE as f32;
    (axis, half.min(std::f32::consts::PI).cos())
}

/// The number of the cell of a direction of any length.
#[inline(always)]
pub(super) fn cell<R: Real>(dir: Vector<R>) -> R {
    let [x, y] = square_of(dir);
    let (x, y) = ((x * SIDE as f32).whole(), (y * SIDE as f32).whole());
    let last = (SIDE - 1) as f32;
    y.within(0.0, last) * SIDE as f32 + x.within(0.0, last)
}

#[inline(always)]
fn index(cell: f32) -> usize {
    (cell as usize).min(SIDE * SIDE - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::SampleKey;
    use crate::sampling::{sample_pair, uniform_sphere};

    fn towards(beam: &Beam, dir: Vec3) -> f32 {
        beam.share([cell(Vector::from(dir)); 4])
    }

    /// Cones of a sphere's light have the mean and the share that their solid angle says.
    #[test]
    fn cones_are_as_bright_as_their_solid_angle_says() {
        let axis = Vec3::new(0.3, -0.5, 0.4).normalize();
        for degrees in [10.0_f32, 30.0, 90.0] {
            let cos = degrees.to_radians().cos();
            let bright: Vec<f32> =
                Beam::directions().map(|dir| if dir.dot(axis) > cos { 5.0 } else { 0.0 }).collect();
            let (beam, mean) = Beam::new(&bright, None).expect("it is narrow");
            let exact = 2.5 * (1.0 - cos);
            assert!((mean / exact - 1.0).abs() < 0.1, "{degrees} degrees: {mean}, not {exact}");
            assert!((beam.peak() * mean - 5.0).abs() < 1e-4, "{degrees} degrees: {}", beam.peak());
            for sample in 0..4096 {
                let dir = uniform_sphere(sample_pair(0, SampleKey { pixel: 0, sample, branch: 0 }, 0, 0));
                let (share, angle) = (towards(&beam, dir), dir.dot(axis).acos().to_degrees());
                if angle < degrees - 9.0 {
                    assert_eq!(share, beam.peak(), "within, at {angle} of {degrees} degrees");
                }
                let (middle, wide) = beam.cone();
                assert!(share > 0.0 || dir.dot(middle) < wide, "all of the cone is lit");
                if angle > degrees + 9.0 {
                    let least = LEAST_SHARE * beam.peak();
                    assert!([0.0, least].contains(&share), "outside, at {angle} of {degrees} degrees");
                }
                if angle > degrees + 18.0 {
                    assert_eq!(share, 0.0, "far outside, at {angle} of {degrees} degrees");
                }
            }
        }
    }

    /// Of triangles directions count by their cosine; light along the normal counts if all others are dark.
    #[test]
    fn triangles_send_light_to_one_side() {
        let normal = Vec3::new(0.2, 0.9, -0.1).normalize();
        let cos = 30.0_f32.to_radians().cos();
        let bright: Vec<f32> =
            Beam::directions().map(|dir| if dir.dot(normal) > cos { 2.0 } else { 0.0 }).collect();
        let (_, mean) = Beam::new(&bright, Some((normal, 2.0))).expect("it is narrow");
        let exact = 2.0 * (1.0 - cos * cos);
        assert!((mean / exact - 1.0).abs() < 0.05, "{mean}, not {exact}");
        let dark = vec![0.0; bright.len()];
        let (beam, mean) = Beam::new(&dark, Some((normal, 2.0))).expect("a ray of light");
        assert!(towards(&beam, normal) * mean > 1.99, "{}", towards(&beam, normal) * mean);
        assert!(Beam::new(&dark, Some((normal, 0.0))).is_none(), "no light");
    }

    #[test]
    fn wide_light_has_no_beam() {
        let even = vec![1.0; Beam::directions().count()];
        assert!(Beam::new(&even, None).is_none());
        let half: Vec<f32> = Beam::directions().map(|dir| f32::from(u8::from(dir.z > -1e-3))).collect();
        assert!(Beam::new(&half, Some((Vec3::Z, 1.0))).is_none(), "all of a triangle's side");
        assert!(Beam::new(&half, None).is_some(), "half of a sphere's");
    }
}
