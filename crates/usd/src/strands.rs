// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and points.
//! Source: UsdGeomBasisCurves, UsdGeomPoints. Curves with normals are ribbons across them, others are tubes; points are spheres.
//! Pinned and periodic curves get the vertices that their ends need. Space: that of the prim; widths are diameters.
//! Tests: `tests/strands.rs`.

use gnurt_scene::io::Oddity;
use gnurt_scene::{CurveBasis, CurveForm, Curves, Mesh, ObjectId, Primitives};
use openusd::sdf::Path;

use crate::builder::Builder;
use crate::value;

/// One curve of a prim: where its values begin in the arrays, and how its vertices follow.
struct Strand {
    /// Its number in the prim.
    curve: usize,
    /// Its first point, and how many it has.
    first: usize,
    count: usize,
    /// Where values that vary along it begin, and how many there are.
    first_knot: usize,
    knots: usize,
    /// The points that its vertices are, from `-1` to `count`; beyond both ends points go on as they came.
    vertices: Vec<i64>,
    basis: CurveBasis,
    is_periodic: bool,
}

/// How many values arrays of each interpolation have.
struct Counts {
    points: usize,
    curves: usize,
    knots: usize,
}

impl Strand {
    /// The values of an array at its vertices. `None` if the array has another length than any interpolation.
    fn spread<const N: usize>(&self, values: &[[f32; N]], of: &Counts) -> Option<Vec<[f32; N]>> {
        let mixed = |a: [f32; N], b: [f32; N], t: f32| std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t);
        let at_point = |&i: &i64| {
            let own = &values[self.first..self.first + self.count];
            let last = own.len() - 1;
            match usize::try_from(i) {
                _ if self.is_periodic => own[i.rem_euclid(self.count as i64) as usize],
                Ok(i) if i <= last => own[i],
                Ok(_) => mixed(own[last], own[last.saturating_sub(1)], -1.0),
                Err(_) => mixed(own[0], own[1.min(last)], -1.0),
            }
        };
        let at_knot = |position: usize| {
            let own = &values[self.first_knot..self.first_knot + self.knots];
            let at = match self.basis {
                CurveBasis::Linear => position as f32,
                CurveBasis::Bezier => position as f32 / 3.0,
                _ => position as f32 - 1.0,
            };
            let wrapped =
                |i: usize| own[if self.is_periodic { i % self.knots } else { i.min(self.knots - 1) }];
            let low = at.max(0.0).floor();
            mixed(wrapped(low as usize), wrapped(low as usize + 1), (at - low).max(0.0))
        };
        Some(match values.len() {
            0 => return None,
            n if n == of.points => self.vertices.iter().map(at_point).collect(),
            1 => vec![values[0]; self.vertices.len()],
            n if n == of.curves => vec![values[self.curve]; self.vertices.len()],
            n if n == of.knots => (0..self.vertices.len()).map(at_knot).collect(),
            _ => return None,
        })
    }
}

/// The points that vertices of a curve are.
fn vertices(count: usize, basis: CurveBasis, wrap: &str) -> Vec<i64> {
    let n = count as i64;
    match (basis, wrap) {
        (CurveBasis::Linear, "periodic") if n > 1 => (0..=n).collect(),
        (CurveBasis::Linear, _) => (0..n).collect(),
        (CurveBasis::Bezier, "periodic") => (0..n / 3 * 3 + i64::from(n >= 3)).collect(),
        (CurveBasis::Bezier, _) => (0..n).collect(),
        (_, "periodic") if n > 1 => (0..n + 3).collect(),
        (_, "pinned") if n > 1 => (-1..=n).collect(),
        _ => (0..n).collect(),
    }
}

/// Values that vary along a curve.
fn knots(count: usize, basis: CurveBasis, wrap: &str) -> usize {
    let spans = match (basis, wrap) {
        (CurveBasis::Linear, "periodic") => return count,
        (CurveBasis::Linear, _) => count.saturating_sub(1),
        (CurveBasis::Bezier, "periodic") => return count / 3,
        (CurveBasis::Bezier, _) => count.saturating_sub(1) / 3,
        (_, "periodic") => return count,
        (_, "pinned") => count.saturating_sub(1),
        _ => count.saturating_sub(3),
    };
    spans + 1
}

impl Builder<'_> {
    /// The object of curves or points.
    pub(crate) fn strands(&mut self, prim: &Path, kind: &str) -> Option<ObjectId> {
        let reader = self.reader;
        let points = reader.value(prim, "points").as_ref().and_then(value::vectors::<3>)?;
        let widths = reader.value(prim, "widths").as_ref().and_then(value::floats).map(|(_, widths)| widths);
        let colors = reader.value(prim, "primvars:displayColor").as_ref().and_then(value::vectors::<3>);
        let colors = colors.filter(|colors| !colors.is_empty());
        let material = match self.bound(prim) {
            Some(material) => self.materials.of(reader, &mut self.scene, &material),
            None => self.materials.unbound(&mut self.scene, colors.is_some(), false),
        };
        let Some(widths) = widths.filter(|widths| !widths.is_empty()) else {
            reader.unsupported(prim, format_args!("{kind} without widths"));
            return None;
        };
        let colors = colors.filter(|_| material.has_colors);
        let mut mesh = match kind {
            "Points" => self.spheres(prim, &points, &widths, colors.as_deref())?,
            _ => self.curves(prim, &points, &widths, colors.as_deref())?,
        };
        if mesh.primitive_count() == 0 {
            return None;
        }
        mesh.material = material.id;
        mesh.name = prim.name().unwrap_or_default().to_owned();
        let mesh = self.add_mesh(mesh)?;
        Some(self.scene.add_object_of(prim.as_str(), vec![mesh]))
    }

    fn spheres(
        &self,
        prim: &Path,
        points: &[[f32; 3]],
        widths: &[f32],
        colors: Option<&[[f32; 3]]>,
    ) -> Option<Mesh> {
        let reader = self.reader;
        if let Err(excess) = reader.files.access.budget.hold(points.len().saturating_mul(32)) {
            reader.note(Oddity::BadMesh, prim, excess);
            return None;
        }
        let width = |i: usize| if widths.len() == points.len() { widths[i] } else { widths[0] };
        let radii = (0..points.len()).map(|i| 0.5 * width(i).max(0.0)).collect();
        let color = |colors: &[[f32; 3]], i: usize| {
            let [r, g, b] = if colors.len() == points.len() { colors[i] } else { colors[0] };
            [r, g, b, 1.0]
        };
        let colors = colors.map(|colors| (0..points.len()).map(|i| color(colors, i)).collect());
        Some(Mesh {
            positions: points.to_vec(),
            colors: colors.unwrap_or_default(),
            primitives: Primitives::Spheres(radii),
            ..Mesh::default()
        })
    }

    fn curves(
        &self,
        prim: &Path,
        points: &[[f32; 3]],
        widths: &[f32],
        colors: Option<&[[f32; 3]]>,
    ) -> Option<Mesh> {
        let reader = self.reader;
        let counts = reader.value(prim, "curveVertexCounts").as_ref().and_then(value::integers)?;
        let basis = match (reader.word(prim, "type").as_deref(), reader.word(prim, "basis").as_deref()) {
            (Some("linear"), _) => CurveBasis::Linear,
            (_, Some("bspline")) => CurveBasis::BSpline,
            (_, Some("catmullRom")) => CurveBasis::CatmullRom,
            _ => CurveBasis::Bezier,
        };
        let wrap = reader.word(prim, "wrap").unwrap_or_default();
        let all: i64 = counts.iter().map(|&count| i64::from(count).max(0)).sum();
        if all != points.len() as i64 {
            let fault = format_args!("curves of {all} points, but there are {}", points.len());
            reader.note(Oddity::BadMesh, prim, fault);
            return None;
        }
        let cost = (points.len() + 3 * counts.len()).saturating_mul(80);
        if let Err(excess) = reader.files.access.budget.hold(cost) {
            reader.note(Oddity::BadMesh, prim, excess);
            return None;
        }
        let (mut strands, mut first, mut first_knot) = (Vec::with_capacity(counts.len()), 0, 0);
        for (curve, count) in counts.iter().map(|&count| count.max(0) as usize).enumerate() {
            let knots = knots(count, basis, &wrap);
            let (vertices, is_periodic) = (vertices(count, basis, &wrap), wrap == "periodic");
            let strand = Strand { curve, first, count, first_knot, knots, vertices, basis, is_periodic };
            (first, first_knot) = (first + count, first_knot + knots);
            strands.push(strand);
        }
        strands.retain(|strand| strand.count > 0);
        let counts = Counts { points: points.len(), curves: counts.len(), knots: first_knot };
        let normals = reader.value(prim, "normals").as_ref().and_then(value::vectors::<3>);
        let normals = normals.filter(|normals| !normals.is_empty());
        let form = if normals.is_some() { CurveForm::Oriented } else { CurveForm::Round };
        let lengths = strands.iter().map(|strand| strand.vertices.len());
        let mut curves = Curves::of_strands(basis, form, lengths);
        let widths: Vec<[f32; 1]> = widths.iter().map(|&width| [width]).collect();
        let mut mesh = Mesh::default();
        let unfit = |what: &str, count: usize| {
            reader.note(Oddity::BadMesh, prim, format_args!("{count} {what}, which fit no interpolation"));
        };
        for strand in &strands {
            mesh.positions.extend(strand.spread(points, &counts)?);
            let Some(radii) = strand.spread(&widths, &counts) else {
                unfit("widths", widths.len());
                return None;
            };
            curves.radii.extend(radii.iter().map(|[width]| 0.5 * width.max(0.0)));
            if let Some(normals) = &normals {
                let Some(spread) = strand.spread(normals, &counts) else {
                    unfit("normals", normals.len());
                    return None;
                };
                mesh.normals.extend(spread);
            }
            if let Some(spread) = colors.and_then(|colors| strand.spread(colors, &counts)) {
                mesh.colors.extend(spread.iter().map(|&[r, g, b]| [r.max(0.0), g.max(0.0), b.max(0.0), 1.0]));
            }
        }
        if mesh.colors.len() != mesh.positions.len() {
            if let Some(colors) = colors {
                unfit("colours", colors.len());
            }
            mesh.colors.clear();
        }
        mesh.primitives = Primitives::Curves(Box::new(curves));
        Some(mesh)
    }
}
