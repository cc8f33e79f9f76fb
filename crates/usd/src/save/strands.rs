// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and spheres of meshes as BasisCurves and Points.
//! Segments that follow one another become one curve again; widths are diameters. Space: object. Tests: `tests/save.rs`.

use std::path::Path;

use gnurt_scene::io::Warnings;
use gnurt_scene::io::writer::leave_out;
use gnurt_scene::{CurveBasis, CurveForm, Curves, Mesh, Primitives, Scene};

use super::text::{Text, VERTEX, tuple};

/// Writes the attributes of a mesh of spheres.
pub(super) fn write_spheres(mesh: &Mesh, radii: &[f32], text: &mut Text) {
    let all: Vec<usize> = (0..mesh.positions.len()).collect();
    write_vertices(mesh, &all, radii, false, text);
}

/// Writes the attributes of a mesh of curves.
pub(super) fn write_curves(mesh: &Mesh, curves: &Curves, text: &mut Text) {
    let basis = match curves.basis {
        CurveBasis::Linear => None,
        CurveBasis::Bezier => Some("bezier"),
        CurveBasis::BSpline => Some("bspline"),
        CurveBasis::CatmullRom => Some("catmullRom"),
    };
    text.line(format_args!("uniform token type = \"{}\"", if basis.is_some() { "cubic" } else { "linear" }));
    if let Some(basis) = basis {
        text.line(format_args!("uniform token basis = \"{basis}\""));
    }
    text.line("uniform token wrap = \"nonperiodic\"");
    let strands = strands(curves);
    text.numbers("int[] curveVertexCounts", strands.iter().map(ExactSizeIterator::len), "");
    let vertices: Vec<usize> = strands.into_iter().flatten().collect();
    write_vertices(mesh, &vertices, &curves.radii, curves.form == CurveForm::Oriented, text);
}

/// The vertices of each strand.
fn strands(curves: &Curves) -> Vec<std::ops::Range<usize>> {
    let (order, step) = (curves.basis.order(), curves.basis.step());
    let mut strands: Vec<std::ops::Range<usize>> = Vec::new();
    let mut last: Option<(usize, Option<[f32; 2]>)> = None;
    for (i, first) in curves.segments.iter().map(|&first| first as usize).enumerate() {
        let span = curves.spans.get(i).copied();
        // Without spans each segment is a strand of its own.
        let goes_on = |(before, old): (usize, Option<[f32; 2]>)| {
            let joins = old.zip(span).is_some_and(|(old, span)| old[1] == span[0] && span[0] > 0.0);
            before + step == first && joins
        };
        match strands.last_mut() {
            Some(strand) if last.is_some_and(goes_on) => strand.end = first + order,
            _ => strands.push(first..first + order),
        }
        last = Some((first, span));
    }
    strands
}

/// Points, widths and what else vertices have, of these vertices.
fn write_vertices(mesh: &Mesh, vertices: &[usize], radii: &[f32], has_normals: bool, text: &mut Text) {
    let of = |values: &[[f32; 3]]| vertices.iter().map(|&v| values[v]).collect::<Vec<_>>();
    let points = of(&mesh.positions);
    let most = vertices.iter().map(|&v| radii[v]).fold(0.0, f32::max);
    let fold = |pick: fn(f32, f32) -> f32| {
        points.iter().copied().reduce(|a, b| [0, 1, 2].map(|k| pick(a[k], b[k]))).unwrap_or_default()
    };
    let extent = [fold(f32::min).map(|x| x - most), fold(f32::max).map(|x| x + most)];
    text.vectors("point3f[] points", points.iter().copied(), "");
    text.numbers("float[] widths", vertices.iter().map(|&v| 2.0 * radii[v]), VERTEX);
    text.line(format_args!("float3[] extent = [{}, {}]", tuple(extent[0]), tuple(extent[1])));
    if has_normals && !mesh.normals.is_empty() {
        text.vectors("normal3f[] normals", of(&mesh.normals).into_iter(), VERTEX);
    }
    if !mesh.texcoords.is_empty() {
        let texcoords = vertices.iter().map(|&v| mesh.texcoords[v]);
        text.vectors("texCoord2f[] primvars:st", texcoords, VERTEX);
    }
    if !mesh.colors.is_empty() {
        let colors = vertices.iter().map(|&v| mesh.colors[v]);
        text.vectors("color3f[] primvars:displayColor", colors.clone().map(|[r, g, b, _]| [r, g, b]), VERTEX);
        if colors.clone().any(|color| color[3] != 1.0) {
            text.numbers("float[] primvars:displayOpacity", colors.map(|color| color[3]), VERTEX);
        }
    }
}

/// Warns of properties of curves that the layer does not have.
pub(super) fn leave_out_properties(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let count = |has: fn(&Curves) -> bool| {
        let some = scene.meshes().iter().filter_map(|mesh| match &mesh.primitives {
            Primitives::Curves(curves) => Some(&**curves),
            _ => None,
        });
        some.filter(|curves| has(curves)).count()
    };
    leave_out(
        count(|curves| curves.form == CurveForm::Flat),
        "flat curves, written as tubes",
        path,
        warnings,
    );
    leave_out(count(|curves| curves.has_inside), "inside of curves", path, warnings);
}
