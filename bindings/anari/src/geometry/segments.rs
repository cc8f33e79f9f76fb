// SPDX-License-Identifier: GPL-3.0-or-later
//! Spheres, cylinders, cones and curves by the kernels: cylinders and cones are straight cubic tubes, which have open ends, with
//! discs where they are closed. Light is sampled on triangles and spheres, so other shapes that shine are made of triangles. Cylinders are
//! unit shapes in many places then. Cones, whose form differs, have 64 sides each. A curve's pieces are the cones that touch the
//! balls around both vertices, and those balls. Tests: tests/{rounds,shapes}.rs.

use glam::Vec3;
use gnurt::scene::{Affine, CurveBasis, CurveForm, Curves, Mesh, Primitives as Surfaces};

use super::data::{Form, Geometry, Part, Placement, Primitives, Vertices};
use super::faces::{indices, positions, reported, valid_indices};
use super::rates::{Rates, list};
use super::unit;
use crate::object::Snapshot;

/// Sides of a cone.
const SIDES: u32 = 64;

/// The surfaces of round shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shapes {
    /// The kernels' own.
    Exact,
    /// Triangles, for shapes that shine.
    Triangles,
}

type Built = Result<(Geometry, Option<String>), String>;

fn radius_at(list: &[[f32; 4]], index: usize, otherwise: f32) -> f32 {
    let radius = list.get(index).map_or(otherwise, |value| value[0]);
    if radius.is_finite() { radius.abs() } else { 0.0 }
}

fn ball(p: [f32; 3], radius: f32, primitive: u32, vertex: u32) -> Placement {
    let r = f64::from(radius);
    let object_from_part = Affine::translation(p.map(f64::from)) * Affine::scale([r; 3]);
    Placement { object_from_part, primitive, ends: [vertex; 2] }
}

/// Where the unit cylinder becomes this one; `None` where it has no length or no radius.
fn rod(ends: [[f32; 3]; 2], radius: f32, primitive: u32, vertices: [u32; 2]) -> Option<Placement> {
    let [a, b] = ends.map(Vec3::from);
    let along = (b - a).try_normalize().filter(|_| radius > 0.0)?;
    let (x, y) = along.any_orthonormal_pair();
    let column = |v: Vec3| v.to_array().map(f64::from);
    let object_from_part =
        Affine { columns: [column(x * radius), column(y * radius), column(b - a), column(a)] };
    Some(Placement { object_from_part, primitive, ends: vertices })
}

/// Spheres.
pub(super) fn spheres(now: &Snapshot) -> Built {
    let points = positions(now)?;
    let (rows, wrong) = valid_indices::<1>(now, points.len())?;
    let warning = reported(wrong, rows.len());
    let (radii, otherwise) = (list(now, "vertex.radius"), now.f32("radius").unwrap_or(1.0));
    let radius = |vertex: u32| radius_at(&radii, vertex as usize, otherwise);
    // A wrong one has no radius, and keeps its number.
    let vertex_of = |row: &Option<[u32; 1]>| row.map_or(0, |[vertex]| vertex);
    let own = |row: &Option<[u32; 1]>| row.map_or(0.0, |[vertex]| radius(vertex));
    let mesh = Mesh {
        positions: rows
            .iter()
            .map(|row| points.get(vertex_of(row) as usize).copied().unwrap_or_default())
            .collect(),
        primitives: Surfaces::Spheres(rows.iter().map(own).collect()),
        ..Mesh::default()
    };
    let part = Part::once(mesh, Primitives::Own, Vertices::Listed(rows.iter().map(vertex_of).collect()));
    let parts = vec![part];
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points: Vec::new() }, warning))
}

/// Which ends are closed, for each pair of vertices.
fn caps(now: &Snapshot) -> impl Fn([u32; 2]) -> [bool; 2] + use<> {
    let word = now.text("caps").unwrap_or("none");
    let all = [["first", "both"].contains(&word), ["second", "both"].contains(&word)];
    let own = list(now, "vertex.cap");
    move |ends| {
        let closed = |k: usize| own.get(ends[k] as usize).map_or(all[k], |value| value[0] != 0.0);
        [closed(0), closed(1)]
    }
}

/// Straight tubes of the kernels and discs at their ends.
#[derive(Default)]
struct Tubes {
    mesh: Mesh,
    curves: Curves,
    numbers: Vec<u32>,
    /// The program's vertex for each of the mesh.
    vertices: Vec<u32>,
    discs: Vec<Placement>,
}

impl Tubes {
    fn add(&mut self, ends: [[f32; 3]; 2], radii: [f32; 2], caps: [bool; 2], primitive: u32, row: [u32; 2]) {
        let [a, b] = ends.map(Vec3::from);
        let Some(along) = (b - a).try_normalize() else { return };
        if radii == [0.0; 2] {
            return;
        }
        self.numbers.push(primitive);
        self.curves.segments.push(self.mesh.positions.len() as u32);
        for k in 0..4_u8 {
            let share = f32::from(k) / 3.0;
            // Both ends are as the program has them.
            let at = if k == 3 { b } else { a + (b - a) * share };
            self.mesh.positions.push(at.to_array());
            self.curves.radii.push(radii[0] + (radii[1] - radii[0]) * share);
            self.vertices.push(row[usize::from(k / 2)]);
        }
        let (x, y) = along.any_orthonormal_pair();
        for end in [0, 1] {
            if caps[end] && radii[end] > 0.0 {
                let column = |v: Vec3| v.to_array().map(f64::from);
                let (out, y) = if end == 0 { (-along, -y) } else { (along, y) };
                let columns =
                    [column(x * radii[end]), column(y * radii[end]), column(out), ends[end].map(f64::from)];
                let object_from_part = Affine { columns };
                self.discs.push(Placement { object_from_part, primitive, ends: [row[end]; 2] });
            }
        }
    }

    fn parts(self) -> Vec<Part> {
        let Self { mesh, curves, numbers, vertices, discs } = self;
        let (basis, form, has_inside) = (CurveBasis::Bezier, CurveForm::Round, true);
        let curves = Curves { basis, form, has_inside, ..curves };
        let mesh = Mesh { primitives: Surfaces::Curves(Box::new(curves)), ..mesh };
        let tubes = Part::once(mesh, Primitives::Listed(numbers), Vertices::Listed(vertices));
        let discs = (!discs.is_empty()).then(|| Part::placed(unit::disc(), Form::Disc, discs));
        [Some(tubes), discs].into_iter().flatten().collect()
    }
}

/// Cylinders.
pub(super) fn cylinders(now: &Snapshot, shapes: Shapes) -> Built {
    let points = positions(now)?;
    let (rows, wrong) = indices::<2>(now, points.len())?;
    let warning = reported(wrong, rows.len());
    let (radii, otherwise) = (list(now, "primitive.radius"), now.f32("radius").unwrap_or(1.0));
    let caps = caps(now);
    if shapes == Shapes::Exact {
        let mut tubes = Tubes::default();
        for (i, &row) in rows.iter().enumerate() {
            let ends = row.map(|vertex| points[vertex as usize]);
            tubes.add(ends, [radius_at(&radii, i, otherwise); 2], caps(row), i as u32, row);
        }
        let parts = tubes.parts();
        return Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points }, warning));
    }
    let mut by_caps: [Vec<Placement>; 4] = Default::default();
    for (i, &row) in rows.iter().enumerate() {
        let ends = row.map(|vertex| points[vertex as usize]);
        if let Some(placement) = rod(ends, radius_at(&radii, i, otherwise), i as u32, row) {
            let [first, second] = caps(row);
            by_caps[usize::from(first) + 2 * usize::from(second)].push(placement);
        }
    }
    let shape = |k: usize| unit::cylinder([k & 1 != 0, k & 2 != 0]);
    let all = by_caps.into_iter().enumerate().filter(|(_, placements)| !placements.is_empty());
    let parts = all.map(|(k, placements)| Part::placed(shape(k), Form::Rod, placements)).collect();
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points }, warning))
}

/// Cones between places, and where their vertices and primitives come from.
#[derive(Default)]
struct Cones {
    mesh: Mesh,
    primitives: Vec<u32>,
    sources: Vec<([u32; 2], f32)>,
}

impl Cones {
    fn add(&mut self, ends: [Vec3; 2], radii: [f32; 2], caps: [bool; 2], primitive: u32, vertices: [u32; 2]) {
        let rings = unit::frustum(&mut self.mesh, ends, radii, SIDES, caps);
        self.sources.extend(rings.into_iter().map(|end| (vertices, end as f32)));
        self.primitives.resize(self.mesh.indices.len(), primitive);
    }

    fn part(self) -> Option<Part> {
        let (primitives, vertices) = (Primitives::Listed(self.primitives), Vertices::Mixed(self.sources));
        (!self.mesh.indices.is_empty()).then(|| Part::once(self.mesh, primitives, vertices))
    }
}

/// Cones.
pub(super) fn cones(now: &Snapshot, shapes: Shapes) -> Built {
    let points = positions(now)?;
    let (rows, wrong) = indices::<2>(now, points.len())?;
    let warning = reported(wrong, rows.len());
    let (radii, otherwise) = (list(now, "vertex.radius"), now.f32("radius").unwrap_or(1.0));
    let caps = caps(now);
    if shapes == Shapes::Exact {
        let mut tubes = Tubes::default();
        for (i, &row) in rows.iter().enumerate() {
            let ends = row.map(|vertex| points[vertex as usize]);
            let radii = row.map(|vertex| radius_at(&radii, vertex as usize, otherwise));
            tubes.add(ends, radii, caps(row), i as u32, row);
        }
        let parts = tubes.parts();
        return Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points }, warning));
    }
    let mut cones = Cones::default();
    for (i, &row) in rows.iter().enumerate() {
        let ends = row.map(|vertex| Vec3::from(points[vertex as usize]));
        let radii = row.map(|vertex| radius_at(&radii, vertex as usize, otherwise));
        cones.add(ends, radii, caps(row), i as u32, row);
    }
    let parts = cones.part().into_iter().collect();
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points }, warning))
}

/// Curves.
pub(super) fn curves(now: &Snapshot, shapes: Shapes) -> Built {
    if shapes == Shapes::Triangles { curve_meshes(now) } else { kernel_curves(now) }
}

/// A piece of a curve: its number, and the first of its two vertices.
#[derive(Clone, Copy, Debug)]
struct Piece {
    number: u32,
    first: u32,
}

/// All pieces whose vertices are there, and a warning about others.
fn pieces(now: &Snapshot, vertices: usize) -> Result<(Vec<Piece>, Option<String>), String> {
    let has_index = now.get("primitive.index").is_some();
    let (rows, mut wrong) = valid_indices::<1>(now, vertices)?;
    // Without an index all vertices make one curve: the last one begins no piece.
    let numbered = if has_index { &rows[..] } else { &rows[..rows.len().saturating_sub(1)] };
    let mut found = Vec::with_capacity(numbered.len());
    for (i, row) in numbered.iter().enumerate() {
        match row {
            Some([first]) if (*first as usize) + 1 < vertices => {
                found.push(Piece { number: i as u32, first: *first })
            }
            Some(_) => wrong += 1,
            None => {}
        }
    }
    Ok((found, reported(wrong, rows.len())))
}

/// Curves by the kernels: cones that touch the balls around both vertices, and those balls.
fn kernel_curves(now: &Snapshot) -> Built {
    let points = positions(now)?;
    let (pieces, warning) = pieces(now, points.len())?;
    let (radii, otherwise) = (list(now, "vertex.radius"), now.f32("radius").unwrap_or(1.0));
    let (numbers, segments) = pieces.iter().map(|piece| (piece.number, piece.first)).unzip();
    let curves = Curves {
        basis: CurveBasis::Linear,
        form: CurveForm::Round,
        radii: (0..points.len()).map(|vertex| radius_at(&radii, vertex, otherwise)).collect(),
        segments,
        spans: Vec::new(),
        has_inside: true,
    };
    let primitives = Surfaces::Curves(Box::new(curves));
    let mesh = Mesh { positions: points, primitives, ..Mesh::default() };
    let parts = vec![Part::once(mesh, Primitives::Listed(numbers), Vertices::Own)];
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points: Vec::new() }, warning))
}

/// Curves of triangles.
fn curve_meshes(now: &Snapshot) -> Built {
    let points = positions(now)?;
    let (pieces, warning) = pieces(now, points.len())?;
    let (radii, otherwise) = (list(now, "vertex.radius"), now.f32("radius").unwrap_or(1.0));
    let (mut rods, mut balls, mut cones) = (Vec::new(), Vec::new(), Cones::default());
    let mut has_ball = vec![false; points.len()];
    for Piece { number: i, first } in pieces {
        let row = [first, first + 1];
        let [r0, r1] = row.map(|vertex| radius_at(&radii, vertex as usize, otherwise));
        let ends = row.map(|vertex| Vec3::from(points[vertex as usize]));
        for (vertex, radius) in row.into_iter().zip([r0, r1]) {
            if !std::mem::replace(&mut has_ball[vertex as usize], true) && radius > 0.0 {
                balls.push(ball(points[vertex as usize], radius, i, vertex));
            }
        }
        if r0 == r1 {
            rods.extend(rod(row.map(|vertex| points[vertex as usize]), r0, i, row));
            continue;
        }
        // The cone touches both balls where its side is upright to their radii.
        let length = ends[0].distance(ends[1]);
        let sin = (r0 - r1) / length;
        if sin.is_finite() && sin.abs() < 1.0 {
            let (along, cos) = ((ends[1] - ends[0]) / length, (1.0 - sin * sin).sqrt());
            let touching = [ends[0] + along * (r0 * sin), ends[1] + along * (r1 * sin)];
            cones.add(touching, [r0 * cos, r1 * cos], [false; 2], i, row);
        }
    }
    let mut parts: Vec<Part> = cones.part().into_iter().collect();
    if !rods.is_empty() {
        parts.push(Part::placed(unit::cylinder([false; 2]), Form::Rod, rods));
    }
    if !balls.is_empty() {
        parts.push(Part::placed(unit::sphere(), Form::Ball, balls));
    }
    Ok((Geometry { parts, attributes: Rates::all(now), ids: Vec::new(), points }, warning))
}
