// SPDX-License-Identifier: GPL-3.0-or-later
//! `curve`: Bezier curves and B-splines of degree 2 and 3, as tubes and ribbons.
//! Rule: a segment has [`STEPS`] pieces; flat curves, which turn to the ray, and cylinders are tubes of [`SIDES`] sides whose mean
//! shadow is as wide as the curve; ribbons lie square to their normals. Normals turn on the great circle between those given.
//! Source: [PJH23] 6.7. Differs: pbrt tilts the shading normals of flat curves. Tests: `tests/shapes.rs`.

use std::f64::consts::TAU;

use gnurt_scene::Mesh;
use gnurt_scene::io::Error;
use gnurt_scene::io::reader::quoted;

use super::reading::Reading;
use super::triangles::positions;
use crate::parameter::Parameters;
use crate::transform::{cross, dot, double, single, unit};

/// Pieces of a segment.
const STEPS: usize = 8;
/// Sides of a tube.
const SIDES: u32 = 6;

/// A place on a curve.
#[derive(Clone, Copy)]
struct Section {
    at: [f64; 3],
    along: [f64; 3],
    /// What ribbons are square to.
    normal: Option<[f64; 3]>,
    width: f64,
    /// How much of the curve lies behind it, in [0, 1].
    v: f64,
}

/// Blossoms of a segment: its Bezier points, of degree 2 or 3.
fn bezier(points: &[[f64; 3]], is_spline: bool) -> Vec<[f64; 3]> {
    let mixed = |a: usize, b: usize, t: f64| [0, 1, 2].map(|k| points[a][k] * (1.0 - t) + points[b][k] * t);
    let middle = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
    match (is_spline, points.len()) {
        (false, _) => points.to_vec(),
        (true, 3) => vec![mixed(0, 1, 0.5), points[1], mixed(1, 2, 0.5)],
        (true, _) => {
            let [a, b, c, d] = [
                mixed(0, 1, 2.0 / 3.0),
                mixed(1, 2, 1.0 / 3.0),
                mixed(1, 2, 2.0 / 3.0),
                mixed(2, 3, 1.0 / 3.0),
            ];
            vec![middle(a, b), b, c, middle(c, d)]
        }
    }
}

/// The place at `t` of Bezier points, and where they go there.
fn point(points: &[[f64; 3]], t: f64) -> ([f64; 3], [f64; 3]) {
    let mut level = points.to_vec();
    while level.len() > 2 {
        level =
            level.windows(2).map(|pair| [0, 1, 2].map(|k| pair[0][k] * (1.0 - t) + pair[1][k] * t)).collect();
    }
    let [a, b] = [level[0], level[1]];
    ([0, 1, 2].map(|k| a[k] * (1.0 - t) + b[k] * t), [0, 1, 2].map(|k| b[k] - a[k]))
}

/// Between two unit vectors.
fn slerp(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    let angle = dot(a, b).clamp(-1.0, 1.0).acos();
    let sin = angle.sin();
    if sin < 1e-6 {
        return a;
    }
    let [x, y] = [((1.0 - t) * angle).sin() / sin, (t * angle).sin() / sin];
    [0, 1, 2].map(|k| x * a[k] + y * b[k])
}

pub(super) fn mesh(parameters: &Parameters, reading: &Reading) -> Result<Mesh, Error> {
    let location = &parameters.location;
    let points: Vec<[f64; 3]> = positions(parameters, "curve")?.iter().copied().map(double).collect();
    let width = parameters.float_or("width", 1.0)?;
    let ends = [parameters.float_or("width0", width)?, parameters.float_or("width1", width)?].map(f64::from);
    let degree = match parameters.int("degree")?.unwrap_or(3) {
        2 => 2,
        3 => 3,
        other => return Err(location.error(format!("a curve of degree {other}"), "expected 2 or 3")),
    };
    let is_spline = match parameters.text("basis")?.unwrap_or("bezier") {
        "bezier" => false,
        "bspline" => true,
        other => {
            let problem = format!("unknown basis {} of a curve", quoted(other));
            return Err(location.error(problem, "valid are bezier and bspline"));
        }
    };
    let is_ribbon = match parameters.text("type")?.unwrap_or("flat") {
        "flat" | "cylinder" => false,
        "ribbon" => true,
        other => {
            let problem = format!("unknown type {} of a curve", quoted(other));
            return Err(location.error(problem, "valid are cylinder, flat and ribbon"));
        }
    };
    parameters.int("splitdepth")?;
    let (fits, step) = match is_spline {
        true => (points.len() > degree, 1),
        false => (points.len() > degree && (points.len() - 1).is_multiple_of(degree), degree),
    };
    if !fits {
        let remedy = if is_spline {
            "give at least one more than the degree"
        } else {
            "give n times the degree and one"
        };
        return Err(location.error(format!("a curve of {} points, degree {degree}", points.len()), remedy));
    }
    let segments = (points.len() - 1 - degree) / step + 1;
    let normals: Vec<Option<[f64; 3]>> =
        parameters.triples("N").unwrap_or_default().iter().map(|n| unit(double(*n))).collect();
    if is_ribbon && normals.len() != segments + 1 {
        let problem = format!("a ribbon of {segments} segments has {} normals", normals.len());
        return Err(location.error(problem, "give one for each end of a segment: \"normal N\" [ ... ]"));
    }
    let sections = segments * STEPS + 1;
    let bytes = sections.saturating_mul(SIDES as usize * 100 + size_of::<Section>());
    reading.access.budget.hold(bytes).map_err(|e| location.excess(e))?;
    let mut all = Vec::with_capacity(sections);
    for segment in 0..segments {
        let blossom = bezier(&points[segment * step..segment * step + degree + 1], is_spline);
        for i in usize::from(segment > 0)..=STEPS {
            let t = i as f64 / STEPS as f64;
            let (at, along) = point(&blossom, t);
            let v = (segment as f64 + t) / segments as f64;
            let normal = match (is_ribbon, normals.get(segment), normals.get(segment + 1)) {
                (true, Some(Some(a)), Some(Some(b))) => Some(slerp(*a, *b, t)),
                _ => None,
            };
            all.push(Section { at, along, normal, width: ends[0] + v * (ends[1] - ends[0]), v });
        }
    }
    let made = if is_ribbon { ribbon(&all) } else { tube(&all) };
    reading.access.budget.release(bytes);
    Ok(made)
}

fn ribbon(sections: &[Section]) -> Mesh {
    let mut mesh = Mesh::default();
    for (i, section) in sections.iter().enumerate() {
        let normal = section.normal.unwrap_or([0.0, 0.0, 1.0]);
        let side = unit(cross(normal, section.along)).unwrap_or([0.0; 3]);
        for (u, sign) in [(0.0, -0.5), (1.0, 0.5)] {
            mesh.positions.push(single([0, 1, 2].map(|k| section.at[k] + sign * section.width * side[k])));
            mesh.normals.push(single(normal));
            mesh.texcoords.push([u, section.v as f32]);
        }
        if i > 0 {
            let first = 2 * (i as u32 - 1);
            mesh.indices.push([first, first + 1, first + 3]);
            mesh.indices.push([first, first + 3, first + 2]);
        }
    }
    mesh
}

/// Any direction square to another.
fn aside(along: [f64; 3]) -> [f64; 3] {
    let axis = if along[0].abs() < along[1].abs() { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    unit(cross(along, axis)).unwrap_or([0.0, 0.0, 1.0])
}

fn tube(sections: &[Section]) -> Mesh {
    let sides = f64::from(SIDES);
    // The mean shadow of a convex outline is its length over pi.
    let radius = std::f64::consts::PI / (2.0 * sides * (std::f64::consts::PI / sides).sin());
    let mut mesh = Mesh::default();
    let mut across: Option<[f64; 3]> = None;
    for (i, section) in sections.iter().enumerate() {
        let along = unit(section.along).unwrap_or([0.0, 0.0, 1.0]);
        // As little turned from the one before as can be.
        let side = across.and_then(|side| {
            let part = dot(side, along);
            unit([0, 1, 2].map(|k| side[k] - part * along[k]))
        });
        let side = side.unwrap_or_else(|| aside(along));
        across = Some(side);
        let up = cross(along, side);
        for j in 0..=SIDES {
            let u = f64::from(j) / sides;
            let (sin, cos) = (u * TAU).sin_cos();
            let normal = [0, 1, 2].map(|k| cos * side[k] + sin * up[k]);
            mesh.positions
                .push(single([0, 1, 2].map(|k| section.at[k] + radius * section.width * normal[k])));
            mesh.normals.push(single(normal));
            mesh.texcoords.push([u as f32, section.v as f32]);
        }
        if i > 0 {
            let row = SIDES + 1;
            for j in 0..SIDES {
                let [a, c] = [(i as u32 - 1) * row + j, i as u32 * row + j];
                mesh.indices.push([a, a + 1, c + 1]);
                mesh.indices.push([a, c + 1, c]);
            }
        }
    }
    mesh
}
