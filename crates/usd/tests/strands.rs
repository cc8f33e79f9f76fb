// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and points.

use gnurt_scene::{CurveBasis, CurveForm, Mesh, Primitives};

use crate::support::{load, warnings};

fn curves(mesh: &Mesh) -> &gnurt_scene::Curves {
    match &mesh.primitives {
        Primitives::Curves(curves) => curves,
        other => panic!("{other:?}"),
    }
}

#[test]
fn curves_stay_curves() {
    let loaded = load(
        r#"
def BasisCurves "Line" {
    uniform token type = "linear"
    int[] curveVertexCounts = [3, 2]
    point3f[] points = [(0, 0, 0), (0, 2, 0), (0, 4, 0), (5, 0, 0), (5, 1, 0)]
    float[] widths = [0.5] ( interpolation = "constant" )
}
def BasisCurves "Bezier" {
    int[] curveVertexCounts = [4]
    point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]
    float[] widths = [0.1, 0.4] ( interpolation = "varying" )
    normal3f[] normals = [(0, 0, 1), (0, 0, 1)] ( interpolation = "varying" )
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] ( interpolation = "varying" )
}
def BasisCurves "Naked" { int[] curveVertexCounts = [2]  point3f[] points = [(0, 0, 0), (1, 0, 0)] }
"#,
    );
    assert!(warnings(&loaded).contains("/Naked: BasisCurves without widths"), "{}", warnings(&loaded));
    let [line, bezier] = loaded.scene.meshes() else { panic!("two meshes") };
    let of_line = curves(line);
    assert_eq!((of_line.basis, of_line.form), (CurveBasis::Linear, CurveForm::Round), "tubes");
    assert_eq!(of_line.segments, [0, 1, 3], "strands are not joined");
    assert_eq!(of_line.radii, [0.25; 5], "half the width");
    let of_bezier = curves(bezier);
    assert_eq!((of_bezier.basis, of_bezier.form), (CurveBasis::Bezier, CurveForm::Oriented), "a ribbon");
    let expected = [0.05, 0.1, 0.15, 0.2];
    assert!(of_bezier.radii.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{:?}", of_bezier.radii);
    assert_eq!(bezier.colors[3], [0.0, 1.0, 0.0, 1.0], "the tip");
    loaded.scene.check().expect("in order");
}

#[test]
fn ends_are_pinned_or_joined() {
    let of = |wrap: &str| {
        let loaded = load(&format!(
            r#"
def BasisCurves "C" {{
    uniform token basis = "bspline"
    uniform token wrap = "{wrap}"
    int[] curveVertexCounts = [4]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 1, 0), (3, 1, 0)]
    float[] widths = [0.2, 0.4, 0.4, 0.2] ( interpolation = "vertex" )
}}"#
        ));
        loaded.scene.meshes()[0].clone()
    };
    let pinned = of("pinned");
    assert_eq!(pinned.positions[0], [-1.0, 0.0, 0.0], "as it came, beyond its first point");
    assert_eq!(curves(&pinned).segments.len(), 3, "from the first point to the last");
    // A B-spline whose end goes on as it came begins there.
    let [a, b, c] = [0, 1, 2].map(|i| pinned.positions[i][0]);
    assert!((a + 4.0 * b + c).abs() < 1e-6, "at its first point");
    assert_eq!(curves(&of("periodic")).segments.len(), 4, "all around");
    assert_eq!(curves(&of("nonperiodic")).segments.len(), 1, "its middle");
}

#[test]
fn points_are_spheres() {
    let loaded =
        load("def Points \"P\" { point3f[] points = [(0, 0, 0), (3, 0, 0)]\n float[] widths = [1, 2] }");
    assert_eq!(warnings(&loaded), "");
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!(mesh.primitives, Primitives::Spheres(vec![0.5, 1.0]), "half of their widths");
}

#[test]
fn arrays_of_other_lengths_are_named() {
    let loaded = load(
        r#"
def BasisCurves "C" {
    uniform token type = "linear"
    int[] curveVertexCounts = [3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    float[] widths = [0.2, 0.4]
}"#,
    );
    assert!(warnings(&loaded).contains("2 widths, which fit no interpolation"), "{}", warnings(&loaded));
}
