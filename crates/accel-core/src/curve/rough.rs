// SPDX-License-Identifier: GPL-3.0-or-later
//! A rough test of a ray and a part of a cubic, in lanes of floats: eight straight stretches, each as wide as all that may be
//! around it. Most misses are sure by it, and hits where a ray goes through the middle of a tube or of a ribbon.
//! Space: object. Invariant: a hit of the exact test lies within the radius of the curve's point, and that within an eighth's
//! bend of its stretch. Rounding of points, seen along the ray, is below half of the slack: 31 units of the greatest coordinate of
//! a vertex and 13 of the origin's, where units and slack are those of `slab.rs`.
//! Tests: `tests`.

use gnurt_simd::{Simd, f32x8, mask32x8, prelude::*};

use super::input::{CurveBasis, CurveForm, Curves};
use crate::slab::SLACK;

/// Stretches of a part.
const STRETCHES: usize = 8;

/// Parts in one, two, four and eight, by their places in a heap.
const PLACES: usize = 16;

/// Those that have others at both ends.
const INNER: u64 = 0b0111_1110;

/// Weights of the four vertices at the starts and at the ends of a part's stretches.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Weights {
    starts: [[f32; STRETCHES]; 4],
    ends: [[f32; STRETCHES]; 4],
}

/// Those of all parts, and how much radii may bend.
struct Parts {
    weights: [Weights; PLACES],
    /// No second derivative of the radius is greater than so many times the greatest radius of a vertex.
    bend: f32,
}

/// By the weights of vertices in powers of the parameter.
const fn parts(powers: &[[f64; 4]; 4], bend: f32) -> Parts {
    let none = Weights { starts: [[0.0; STRETCHES]; 4], ends: [[0.0; STRETCHES]; 4] };
    let mut weights = [none; PLACES];
    let mut place = 1;
    while place < PLACES {
        let count = 1 << place.ilog2();
        let mut i = 0;
        while i <= STRETCHES {
            let t = ((place - count) * STRETCHES + i) as f64 / (count * STRETCHES) as f64;
            let mut k = 0;
            while k < 4 {
                let weight = powers[0][k] + t * (powers[1][k] + t * (powers[2][k] + t * powers[3][k]));
                if i < STRETCHES {
                    weights[place].starts[k][i] = weight as f32;
                }
                if i > 0 {
                    weights[place].ends[k][i - 1] = weight as f32;
                }
                k += 1;
            }
            i += 1;
        }
        place += 1;
    }
    Parts { weights, bend }
}

static BEZIER: Parts = parts(&CurveBasis::BEZIER, 24.0);
static B_SPLINE: Parts = parts(&CurveBasis::B_SPLINE, 4.0);
static CATMULL_ROM: Parts = parts(&CurveBasis::CATMULL_ROM, 12.0);

/// A ray as the rough test takes it.
#[derive(Clone, Copy)]
pub struct RoughRay<S: Simd> {
    pub org: [f32x8<S>; 3],
    /// Two across, and the direction, all of length 1.
    pub axes: [[f32x8<S>; 3]; 3],
    /// The greatest coordinate of the origin.
    pub away: f32,
    /// That of the direction.
    pub length: f32,
}

impl<S: Simd> RoughRay<S> {
    /// Offsets from the origin by the axes.
    #[inline(always)]
    pub fn seen(&self, from: [f32x8<S>; 3]) -> [f32x8<S>; 3] {
        [self.by(from, 0), self.by(from, 1), self.by(from, 2)]
    }

    /// Offsets by one of the axes.
    #[inline(always)]
    pub fn by(&self, from: [f32x8<S>; 3], axis: usize) -> f32x8<S> {
        let [x, y, z] = self.axes[axis];
        from[0].mul_add(x, from[1].mul_add(y, from[2] * z))
    }
}

/// How a ray passes stretches, seen along it: each times the length of the stretch.
#[derive(Clone, Copy)]
pub struct Passing<S: Simd> {
    /// The square of that length.
    pub square: f32x8<S>,
    /// Beside the line; its sign tells the side.
    pub beside: f32x8<S>,
    /// Before the start, and behind the end: below zero in between.
    pub before: f32x8<S>,
    pub behind: f32x8<S>,
}

impl<S: Simd> Passing<S> {
    /// By the axes of the ray: the starts and the ends.
    #[inline(always)]
    pub fn new(a: [f32x8<S>; 2], b: [f32x8<S>; 2]) -> Self {
        let step = [b[0] - a[0], b[1] - a[1]];
        Self {
            square: step[0].mul_add(step[0], step[1] * step[1]),
            beside: a[0].mul_sub(step[1], a[1] * step[0]),
            before: a[0].mul_add(step[0], a[1] * step[1]),
            behind: -(b[0].mul_add(step[0], b[1] * step[1])),
        }
    }

    /// Where the ray is no farther than the radius from the stretch, in each of these directions.
    #[inline(always)]
    pub fn is_near(&self, radius: f32x8<S>) -> mask32x8<S> {
        let off = self.before.max(self.behind).max(self.beside.abs());
        (off * off).simd_le(radius * radius * self.square)
    }
}

/// Knowledge of a ray and a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rough {
    /// The ray surely meets nothing of it.
    Missed,
    /// The exact test has to be made.
    Unknown,
    /// The ray surely has a hit.
    Hit,
}

impl Curves<'_> {
    /// Whether the ray may meet a part, of which `radius` is that of a capsule around it, between `near` and `far`. Nothing is known
    /// of curves that have no rough test, and no hit unless `is_any`.
    #[inline(always)]
    pub fn meet_roughly<S: Simd>(
        &self,
        simd: S,
        [prim_id, place]: [u32; 2],
        radius: f32,
        ray: &RoughRay<S>,
        [near, far]: [f32; 2],
        is_any: bool,
    ) -> Rough {
        let parts = match self.basis {
            // Straight pieces are somewhere else than the curve, ribbons across normals turn.
            _ if self.pieces != 0 || self.form == CurveForm::Oriented => return Rough::Unknown,
            CurveBasis::Linear | CurveBasis::Hermite => return Rough::Unknown,
            CurveBasis::Bezier => &BEZIER,
            CurveBasis::BSpline => &B_SPLINE,
            CurveBasis::CatmullRom => &CATMULL_ROM,
        };
        let Some(vertices) = self.of(self.vertices, prim_id).and_then(<[_]>::first_chunk) else {
            return Rough::Unknown;
        };
        let place = place.max(1) as usize & (PLACES - 1);
        let weights = &parts.weights[place];
        let [greatest, widest] = greatest(vertices);
        let [a, b] = [seen(simd, &weights.starts, vertices, ray), seen(simd, &weights.ends, vertices, ray)];
        // A capsule's radius is no less than its part's distance from the chord, which for an eighth is a 64th of that.
        let count = 1u32 << place.max(1).ilog2();
        let bend = parts.bend / (512 * count * count) as f32;
        let wider = bend * widest + radius * (1.0 / 63.0) + 2.0 * SLACK * (2.0 * greatest + ray.away);
        let at = |x: f32| f32x8::splat(simd, x);
        let capsule = radius;
        let radius = a[3].max(b[3]) + at(wider);
        let passing = Passing::new([a[0], a[1]], [b[0], b[1]]);
        let is_near = passing.is_near(radius);
        let (nearest, farthest) = (a[2].min(b[2]), a[2].max(b[2]));
        let (near, far) = (at(near * ray.length), at(far * ray.length));
        let is_here = (nearest - radius).simd_le(far) & (farthest + radius).simd_ge(near);
        if (is_near & is_here).to_bitmask() == 0 {
            return Rough::Missed;
        }
        if is_any {
            let Passing { square, beside, before, behind } = passing;
            // Within the circles of all of the stretch, and far enough from the ends of the ray.
            let inner = a[3].min(b[3]).mul_sub(at(0.875), at(wider));
            let is_inside = inner.simd_gt(at(0.0)) & (beside * beside).simd_le(inner * inner * square);
            let reach = at(2.5) * radius;
            let is_within = (nearest - reach).simd_ge(near) & (farthest + reach).simd_le(far);
            let is_hit = if self.form == CurveForm::Round {
                // A point of the ray is inside of a circle, well away from the part's ends. So the ray comes in and goes out, both
                // beside stretches of the part, as it is not too much along them.
                let depth = farthest - nearest;
                let depth = depth * depth;
                let is_across = depth.simd_le(at(3.0) * square);
                let is_long = (at(8.0) * radius * radius).simd_le(square + depth);
                let is_between = before.simd_le(at(0.0)) & behind.simd_le(at(0.0));
                (is_inside & is_between & is_across & is_long & is_within).to_bitmask() & INNER
            } else {
                // Seen along the ray, the derivative changes over the part by no more than eight times `off`, and over one of its
                // eight stretches by no more than `off`. That is less than a third and a 24th of what it is. So the curve comes
                // nearer up to one point and goes away behind it, and this point belongs to the stretch.
                let off = at(capsule) - a[3].max(b[3]);
                let is_straight = (at(9.0) * off * off).simd_le(square);
                let is_long = (at(2.0) * radius * radius).simd_le(square);
                let most = square * at(-1.0 / 16.0);
                let is_between = before.simd_le(most) & behind.simd_le(most);
                (is_inside & is_between & is_straight & is_long & is_within).to_bitmask()
            };
            if is_hit != 0 {
                return Rough::Hit;
            }
        }
        Rough::Unknown
    }
}

/// The greatest coordinate and the greatest radius of vertices.
#[inline(always)]
fn greatest(vertices: &[[f32; 4]; 4]) -> [f32; 2] {
    let mut most = [0.0f32; 4];
    for vertex in vertices {
        for k in 0..4 {
            most[k] = if vertex[k].abs() > most[k] { vertex[k].abs() } else { most[k] };
        }
    }
    [most[0].max(most[1]).max(most[2]), most[3]]
}

/// Points by the axes of the ray, and radii.
#[inline(always)]
fn seen<S: Simd>(
    simd: S,
    weights: &[[f32; STRETCHES]; 4],
    vertices: &[[f32; 4]; 4],
    ray: &RoughRay<S>,
) -> [f32x8<S>; 4] {
    let lanes = |i: usize| f32x8::from_slice(simd, &weights[i]);
    let rows = [lanes(0), lanes(1), lanes(2), lanes(3)];
    let at = |i: usize, k: usize| f32x8::splat(simd, vertices[i][k]);
    let mut points = [rows[0] * at(0, 0), rows[0] * at(0, 1), rows[0] * at(0, 2), rows[0] * at(0, 3)];
    for (k, point) in points.iter_mut().enumerate() {
        *point = rows[1].mul_add(at(1, k), *point);
        *point = rows[2].mul_add(at(2, k), *point);
        *point = rows[3].mul_add(at(3, k), *point);
    }
    let [x, y, z, radius] = points;
    let from = [x - ray.org[0], y - ray.org[1], z - ray.org[2]];
    let [across, up, along] = ray.seen(from);
    [across, up, along, radius]
}

#[cfg(test)]
mod tests {
    use gnurt_simd::{Level, dispatch};
    use gnurt_testkit::Random;

    use super::*;
    use crate::curve::RayFrame;

    fn ready<S: Simd>(simd: S, frame: &RayFrame) -> RoughRay<S> {
        let at = |v: [f64; 3]| [0, 1, 2].map(|k| f32x8::splat(simd, v[k] as f32));
        let away = frame.org.iter().fold(0.0, |all: f64, x| all.max(x.abs())) as f32;
        RoughRay { org: at(frame.org), axes: frame.axes.map(at), away, length: frame.length as f32 }
    }

    /// Random parts of curves: crooked, straight, wide, thin, pointed, large, small and far away; rays at them, long and short.
    #[test]
    fn what_is_surely_missed_or_met_is_so_by_the_exact_test() {
        let mut random = Random::new(11);
        let (mut hits, mut missed, mut sure, mut unknown) = (0, 0, 0, 0);
        for round in 0..60_000 {
            let basis = [CurveBasis::Bezier, CurveBasis::BSpline, CurveBasis::CatmullRom][random.below(3)];
            let form = [CurveForm::Flat, CurveForm::Round][random.below(2)];
            let scale = [1.0, 1e-3, 1e4][random.below(3)];
            let shift = [0.0, 5.0, -300.0][random.below(3)];
            let (crooked, width) = ([0.02, 0.2, 1.5][random.below(3)], [0.004, 0.03, 0.1][random.below(3)]);
            let towards = random.point();
            let vertices = [0, 1, 2, 3].map(|i| {
                let off = random.point();
                let [x, y, z] = [0, 1, 2].map(|k| scale * (shift + i as f32 * towards[k] + crooked * off[k]));
                [
                    x,
                    y,
                    z,
                    scale * width * [random.unit(), 1.0, 0.0, random.between(0.8, 1.0)][random.below(4)],
                ]
            });
            let curves = Curves::new(basis, form, &vertices, &[0]);
            let Some(segment) = curves.check(0, &mut crate::BadPrimitives::default()) else { continue };
            let count = [segment.parts(), 1, 2, 4, 8][random.below(5)];
            let index = random.below(count as usize) as u32;
            let mut capsule = None;
            segment.pieces([0.0, 1.0], count, |piece| {
                if u32::from(piece.index) == index {
                    capsule = Some(piece);
                }
            });
            let capsule = capsule.expect("a piece");
            let part = [f64::from(index) / f64::from(count), f64::from(index + 1) / f64::from(count)];
            // Through the tube, at its side and somewhere else.
            let middle = segment.at(part[0] + f64::from(random.unit()) * (part[1] - part[0]));
            let (side, far) = (random.point(), random.point());
            let aside = [0.3, 1.0, 1.5, 20.0][random.below(4)] * middle[3];
            let to = [0, 1, 2].map(|k| (middle[k] + aside * f64::from(side[k])) as f32);
            let org = [0, 1, 2].map(|k| to[k] + 3.0 * scale * [1.0, 0.02][round % 2] * far[k]);
            let dir = [0, 1, 2].map(|k| to[k] - org[k]);
            if dir == [0.0; 3] {
                continue;
            }
            let frame = RayFrame::new(org.map(f64::from), dir.map(f64::from));
            let t = 2.0 * random.unit();
            let ends = [[0.0, f32::INFINITY], [0.0, t], [t, f32::INFINITY]][random.below(3)];
            let mut has_hit = false;
            segment.meet(&frame, part, &mut |hit| {
                has_hit |= hit.t as f32 >= ends[0] && hit.t as f32 <= ends[1];
                true
            });
            for level in Level::available() {
                let place = count + index;
                let rough = dispatch!(level, simd => {
                    curves.meet_roughly(simd, [0, place], capsule.radius, &ready(simd, &frame), ends, round % 3 != 0)
                });
                let what =
                    format!("round {round}, {level}: {curves:?}, part {part:?}, {org:?} to {to:?}, {ends:?}");
                match rough {
                    Rough::Missed => assert!(!has_hit, "{what} has a hit"),
                    Rough::Hit => assert!(has_hit, "{what} has none"),
                    Rough::Unknown => unknown += usize::from(!has_hit),
                }
                missed += usize::from(rough == Rough::Missed);
                sure += usize::from(rough == Rough::Hit);
                hits += usize::from(has_hit);
            }
        }
        assert!(hits > 20_000 && 25 * sure > hits, "{sure} of {hits} hits are sure");
        assert!(missed > 2 * unknown, "{missed} are known to be missed, {unknown} are not");
    }
}
