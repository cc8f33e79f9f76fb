// SPDX-License-Identifier: GPL-3.0-or-later
//! `curve`: Bezier curves and B-splines of degree 2 and 3: ribbons that face rays, tubes, and ribbons across normals.
//! Normals turn on the great circle between those given. Source: [PJH23] 6.7. Differs: flat curves are shaded as the
//! tubes that they stand for. Tests: `tests/shapes.rs`.

use gnurt_scene::io::Error;
use gnurt_scene::io::reader::quoted;
use gnurt_scene::{CurveBasis, CurveForm, Curves, Mesh, Primitives};

use super::reading::Reading;
use super::triangles::positions;
use crate::parameter::Parameters;
use crate::transform::{dot, double, single, unit};

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

/// The same curve by four Bezier points.
fn cubic(points: &[[f64; 3]]) -> [[f64; 3]; 4] {
    let mixed = |a: usize, b: usize, t: f64| [0, 1, 2].map(|k| points[a][k] * (1.0 - t) + points[b][k] * t);
    match points.len() {
        3 => [points[0], mixed(0, 1, 2.0 / 3.0), mixed(1, 2, 1.0 / 3.0), points[2]],
        _ => [points[0], points[1], points[2], points[3]],
    }
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
    let form = match parameters.text("type")?.unwrap_or("flat") {
        "flat" => CurveForm::Flat,
        "cylinder" => CurveForm::Round,
        "ribbon" => CurveForm::Oriented,
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
    let is_ribbon = form == CurveForm::Oriented;
    let normals: Vec<Option<[f64; 3]>> =
        parameters.triples("N").unwrap_or_default().iter().map(|n| unit(double(*n))).collect();
    if is_ribbon && normals.len() != segments + 1 {
        let problem = format!("a ribbon of {segments} segments has {} normals", normals.len());
        return Err(location.error(problem, "give one for each end of a segment: \"normal N\" [ ... ]"));
    }
    let vertices = 3 * segments + 1;
    let bytes = vertices.saturating_mul(64);
    reading.access.budget.hold(bytes).map_err(|e| location.excess(e))?;
    let mut curves = Curves::of_strands(CurveBasis::Bezier, form, [vertices]);
    let mut mesh = Mesh::default();
    for segment in 0..segments {
        let blossom = bezier(&points[segment * step..segment * step + degree + 1], is_spline);
        for (i, point) in cubic(&blossom).into_iter().enumerate().skip(usize::from(segment > 0)) {
            let t = i as f64 / 3.0;
            let along = (segment as f64 + t) / segments as f64;
            mesh.positions.push(single(point));
            curves.radii.push((0.5 * (ends[0] + along * (ends[1] - ends[0]))).max(0.0) as f32);
            if is_ribbon {
                let normal = match (normals.get(segment), normals.get(segment + 1)) {
                    (Some(Some(a)), Some(Some(b))) => slerp(*a, *b, t),
                    _ => [0.0, 0.0, 1.0],
                };
                mesh.normals.push(single(normal));
            }
        }
    }
    mesh.primitives = Primitives::Curves(Box::new(curves));
    reading.access.budget.release(bytes);
    Ok(mesh)
}
