// SPDX-License-Identifier: GPL-3.0-or-later
//! Curves and points.

use crate::support::{load, warnings};

#[test]
fn curves_are_tubes() {
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
    float[] widths = [0.1, 0.3] ( interpolation = "varying" )
}
def BasisCurves "Naked" { int[] curveVertexCounts = [2]  point3f[] points = [(0, 0, 0), (1, 0, 0)] }
"#,
    );
    assert!(warnings(&loaded).contains("/Naked: BasisCurves without widths"), "{}", warnings(&loaded));
    let [line, bezier] = loaded.scene.meshes() else { panic!("two meshes") };
    assert_eq!(line.indices.len(), 3 * 16, "three pieces of eight sides");
    let top = line.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
    assert_eq!(top, 4.0, "to its end");
    let middle = bezier.positions.iter().map(|p| p[1]).fold(0.0, f32::max);
    // The curve is 0.75 high in its middle, and a tenth thick there.
    assert!((middle - 0.85).abs() < 0.01, "{middle}");
}

#[test]
fn points_are_balls() {
    let loaded =
        load("def Points \"P\" { point3f[] points = [(0, 0, 0), (3, 0, 0)]\n float[] widths = [1, 2] }");
    assert_eq!(warnings(&loaded), "");
    let shown = loaded.scene.occurrences().filter(|found| !found.object.meshes.is_empty());
    let places: Vec<f64> = shown.map(|found| found.world_from_object.point([0.5, 0.0, 0.0])[0]).collect();
    assert_eq!(places, [0.5, 4.0], "half of their widths beside their middles");
}
