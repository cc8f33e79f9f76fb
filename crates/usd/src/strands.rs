// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves as tubes and points as balls.
//! Source: UsdGeomBasisCurves, UsdGeomPoints. Tubes have [`SIDES`] sides and, where a curve is cubic, [`STEPS`] steps a span; their ends
//! are open. Space: that of the prim; widths are diameters. Tests: `tests/strands.rs`.

use gnurt_scene::io::Oddity;
use gnurt_scene::{Affine, Member, Mesh, ObjectId};
use openusd::sdf::Path;

use crate::builder::Builder;
use crate::shapes;
use crate::value;

/// Sides of a tube.
const SIDES: u32 = 8;
/// Steps of a cubic span.
const STEPS: usize = 8;

type Point = [f64; 3];

/// How control points become a curve.
#[derive(Clone, Copy, PartialEq)]
enum Basis {
    Linear,
    Bezier,
    Bspline,
    CatmullRom,
}

impl Basis {
    /// Weights of four control points.
    fn weights(self, t: f64) -> [f64; 4] {
        let (s, t2, t3) = (1.0 - t, t * t, t * t * t);
        match self {
            Self::Linear => [s, t, 0.0, 0.0],
            Self::Bezier => [s * s * s, 3.0 * s * s * t, 3.0 * s * t2, t3],
            Self::Bspline => [
                s * s * s / 6.0,
                (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
                (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
                t3 / 6.0,
            ],
            Self::CatmullRom => [
                (-t3 + 2.0 * t2 - t) / 2.0,
                (3.0 * t3 - 5.0 * t2 + 2.0) / 2.0,
                (-3.0 * t3 + 4.0 * t2 + t) / 2.0,
                (t3 - t2) / 2.0,
            ],
        }
    }
}

impl Builder<'_> {
    /// The object of curves or points.
    pub(crate) fn strands(&mut self, prim: &Path, kind: &str) -> Option<ObjectId> {
        let reader = self.reader;
        let points = reader.value(prim, "points").as_ref().and_then(value::vectors::<3>)?;
        let widths = reader.value(prim, "widths").as_ref().and_then(value::floats).map(|(_, widths)| widths);
        let color = reader.value(prim, "primvars:displayColor").as_ref().and_then(value::vectors::<3>);
        let color = color.filter(|colors| !colors.is_empty());
        if color.as_ref().is_some_and(|colors| colors.len() > 1) {
            reader.unsupported(
                prim,
                "displayColor that changes along curves or points, the first one is shown",
            );
        }
        let material = match self.bound(prim) {
            Some(material) => self.materials.of(reader, &mut self.scene, &material),
            None => self.materials.unbound(&mut self.scene, color.is_some(), false),
        };
        let Some(widths) = widths.filter(|widths| !widths.is_empty()) else {
            reader.unsupported(prim, format_args!("{kind} without widths"));
            return None;
        };
        let finish = |builder: &mut Self, mut mesh: Mesh| {
            if let (true, Some(color)) = (material.has_colors, &color) {
                let [r, g, b] = color[0];
                mesh.colors = vec![[r, g, b, 1.0]; mesh.positions.len()];
            }
            mesh.material = material.id;
            mesh.name = prim.name().unwrap_or_default().to_owned();
            let mesh = builder.add_mesh(mesh)?;
            Some(builder.scene.add_object_of(prim.as_str(), vec![mesh]))
        };
        if kind == "Points" {
            let mut ball = shapes::ball(0.5, [12, 6]);
            ball.normals = ball.positions.iter().map(|p| p.map(|x| 2.0 * x)).collect();
            reader.files.access.budget.hold(points.len().saturating_mul(160)).ok()?;
            let ball = finish(self, ball)?;
            let width =
                |i: usize| f64::from(if widths.len() == points.len() { widths[i] } else { widths[0] });
            let member = |(i, point): (usize, &[f32; 3])| {
                Member::new(ball, Affine::translation(point.map(f64::from)) * Affine::scale([width(i); 3]))
            };
            let members: Vec<Member> = points.iter().enumerate().map(member).collect();
            let members: Vec<Member> =
                members.into_iter().filter(|member| member.object_from_member.inverse().is_some()).collect();
            return (!members.is_empty()).then(|| self.scene.add_object_of_members(prim.as_str(), members));
        }
        let mesh = self.tubes(prim, &points, &widths)?;
        finish(self, mesh)
    }

    fn tubes(&self, prim: &Path, points: &[[f32; 3]], widths: &[f32]) -> Option<Mesh> {
        let reader = self.reader;
        let counts = reader.value(prim, "curveVertexCounts").as_ref().and_then(value::integers)?;
        let basis = match (reader.word(prim, "type").as_deref(), reader.word(prim, "basis").as_deref()) {
            (Some("linear"), _) => Basis::Linear,
            (_, Some("bspline")) => Basis::Bspline,
            (_, Some("catmullRom")) => Basis::CatmullRom,
            _ => Basis::Bezier,
        };
        let wrap = reader.word(prim, "wrap").unwrap_or_default();
        let all: i64 = counts.iter().map(|&count| i64::from(count).max(0)).sum();
        if all != points.len() as i64 {
            reader.note(
                Oddity::BadMesh,
                prim,
                format_args!("curves of {all} points, but there are {}", points.len()),
            );
            return None;
        }
        if reader.value(prim, "normals").is_some() {
            reader.unsupported(prim, "curves with normals (ribbons), shown as tubes");
        }
        let steps = if basis == Basis::Linear { 1 } else { STEPS };
        let cost = points.len().saturating_mul(steps * SIDES as usize * 48);
        if let Err(excess) = reader.files.access.budget.hold(cost) {
            reader.note(Oddity::BadMesh, prim, excess);
            return None;
        }
        let mut mesh = Mesh::default();
        let (mut begin, mut width_at) = (0, 0);
        for (curve, count) in counts.iter().map(|&count| count.max(0) as usize).enumerate() {
            let own = &points[begin..begin + count];
            let knots = knots(own.len(), basis, &wrap);
            let spans = spans(count, basis, &wrap);
            let path: Vec<Point> = line(own, &spans, basis, steps);
            // Widths per point, per end of a span, per curve, or one.
            let ends = knots;
            let share = |t: f64, of: &[f32]| {
                let at = t * (of.len() - 1) as f64;
                let low = (at.floor() as usize).min(of.len() - 1);
                let high = (low + 1).min(of.len() - 1);
                f64::from(of[low]) + (f64::from(of[high]) - f64::from(of[low])) * (at - low as f64)
            };
            let of_curve: &[f32] = match widths.len() {
                n if n == points.len() => &widths[begin..begin + count],
                n if n == counts.len() => &widths[curve..=curve],
                n if n > 1 && width_at + ends <= n => &widths[width_at..width_at + ends],
                _ => &widths[..1],
            };
            width_at += ends;
            begin += count;
            if path.len() < 2 || of_curve.is_empty() {
                continue;
            }
            let last = (path.len() - 1) as f64;
            let radii: Vec<f64> = (0..path.len()).map(|i| share(i as f64 / last, of_curve) / 2.0).collect();
            sweep(&mut mesh, &path, &radii);
        }
        Some(mesh)
    }
}

/// Values that vary along a curve.
fn knots(count: usize, basis: Basis, wrap: &str) -> usize {
    let spans = spans(count, basis, wrap).len();
    if wrap == "periodic" { spans } else { spans + 1 }
}

/// The control points of each span.
fn spans(count: usize, basis: Basis, wrap: &str) -> Vec<[i64; 4]> {
    let n = count as i64;
    let is_periodic = wrap == "periodic";
    let spans = match basis {
        Basis::Linear => {
            if is_periodic {
                n
            } else {
                n - 1
            }
        }
        Basis::Bezier => {
            if is_periodic {
                n / 3
            } else {
                (n - 1) / 3
            }
        }
        _ if is_periodic => n,
        _ if wrap == "pinned" => n - 1,
        _ => n - 3,
    };
    let step = if basis == Basis::Bezier { 3 } else { 1 };
    let first = if wrap == "pinned" && matches!(basis, Basis::Bspline | Basis::CatmullRom) { -1 } else { 0 };
    (0..spans.max(0)).map(|span| [0, 1, 2, 3].map(|k| first + span * step + k)).collect()
}

/// Places along a curve.
fn line(points: &[[f32; 3]], spans: &[[i64; 4]], basis: Basis, steps: usize) -> Vec<Point> {
    let n = points.len() as i64;
    // Beyond pinned ends points go on as they came; periodic curves begin again.
    let is_pinned = spans.first().is_some_and(|span| span[0] < 0);
    let point = |i: i64| -> Point {
        let at = |i: i64| points[i.rem_euclid(n) as usize].map(f64::from);
        let beyond = |a: Point, b: Point| std::array::from_fn(|k| 2.0 * a[k] - b[k]);
        match i {
            _ if !is_pinned || n < 2 => at(i),
            i if i < 0 => beyond(at(0), at(1)),
            i if i >= n => beyond(at(n - 1), at(n - 2)),
            i => at(i),
        }
    };
    let mut path = Vec::with_capacity(spans.len() * steps + 1);
    for (number, span) in spans.iter().enumerate() {
        let controls = span.map(point);
        let last = usize::from(number + 1 == spans.len());
        for step in 0..steps + last {
            let weights = basis.weights(step as f64 / steps as f64);
            path.push(std::array::from_fn(|k| (0..4).map(|i| weights[i] * controls[i][k]).sum()));
        }
    }
    path
}

/// A tube along a path, whose sides do not turn around it.
fn sweep(mesh: &mut Mesh, path: &[Point], radii: &[f64]) {
    let begin = mesh.positions.len() as u32;
    let mut side: Point = [0.0; 3];
    let mut forward = [0.0, 0.0, 1.0];
    for (i, (centre, radius)) in path.iter().zip(radii).enumerate() {
        let (before, after) = (path[i.saturating_sub(1)], path[(i + 1).min(path.len() - 1)]);
        let along: Point = std::array::from_fn(|k| after[k] - before[k]);
        forward = unit(along).unwrap_or(forward);
        let dot: f64 = (0..3).map(|k| side[k] * forward[k]).sum();
        let across: Point = std::array::from_fn(|k| side[k] - dot * forward[k]);
        side = unit(across).unwrap_or_else(|| {
            let least =
                (0..3).fold(0, |best, k| if forward[k].abs() < forward[best].abs() { k } else { best });
            let mut axis = [0.0; 3];
            axis[least] = 1.0;
            unit(cross(forward, axis)).unwrap_or([1.0, 0.0, 0.0])
        });
        let other = cross(forward, side);
        for k in 0..SIDES {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(SIDES)).sin_cos();
            let normal: Point = std::array::from_fn(|k| cos * side[k] + sin * other[k]);
            mesh.positions.push(std::array::from_fn(|k| (centre[k] + radius * normal[k]) as f32));
            mesh.normals.push(normal.map(|x| x as f32));
        }
    }
    for ring in 0..path.len() as u32 - 1 {
        for k in 0..SIDES {
            let [a, d] = [ring, ring + 1].map(|ring| begin + ring * SIDES + k);
            let [b, c] = [ring, ring + 1].map(|ring| begin + ring * SIDES + (k + 1) % SIDES);
            mesh.indices.extend([[a, b, c], [a, c, d]]);
        }
    }
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: Point) -> Option<Point> {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (length > 1e-12 && length.is_finite()).then(|| v.map(|x| x / length))
}
