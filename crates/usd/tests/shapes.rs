// SPDX-License-Identifier: GPL-3.0-or-later
//! Shapes: their area and volume are those of the formulas, but for their sides.

use std::f64::consts::PI;

use gnurt_scene::Mesh;

use crate::support::{load, warnings};

/// Area, and volume by the divergence theorem: above zero where all triangles face outwards.
fn measure(mesh: &Mesh) -> [f64; 2] {
    mesh.indices.iter().fold([0.0; 2], |[area, volume], t| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
        let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|k| p[k] - a[k]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let dot = |p: [f64; 3], q: [f64; 3]| (0..3).map(|k| p[k] * q[k]).sum::<f64>();
        [area + dot(n, n).sqrt() / 2.0, volume + dot(a, n) / 6.0]
    })
}

#[test]
fn areas_and_volumes() {
    let shapes = [
        ("Cube", "double size = 3", 54.0, 27.0),
        ("Sphere", "double radius = 2", 16.0 * PI, 32.0 / 3.0 * PI),
        (
            "Cylinder",
            "double radius = 2\n double height = 3\n uniform token axis = \"X\"",
            20.0 * PI,
            12.0 * PI,
        ),
        ("Cone", "double radius = 3\n double height = 4\n uniform token axis = \"Y\"", 24.0 * PI, 12.0 * PI),
        ("Capsule", "double radius = 1\n double height = 2", 8.0 * PI, 10.0 / 3.0 * PI),
    ];
    for (kind, values, area, volume) in shapes {
        let loaded = load(&format!("def {kind} \"S\" {{ {values} }}"));
        assert_eq!(warnings(&loaded), "", "{kind}");
        let [found_area, found_volume] = measure(&loaded.scene.meshes()[0]);
        assert!((found_area / area - 1.0).abs() < 2e-3, "{kind}: area {found_area}, expected {area}");
        assert!(
            (found_volume / volume - 1.0).abs() < 3e-3,
            "{kind}: volume {found_volume}, expected {volume}"
        );
        let normals = loaded.scene.meshes()[0].normals.iter();
        let good =
            normals.map(|n| n.iter().map(|x| x * x).sum::<f32>()).all(|square| (square - 1.0).abs() < 1e-4);
        assert!(good, "{kind}: normals of unit length");
    }
    let plane = load("def Plane \"P\" { double width = 2\n double length = 3\n uniform token axis = \"Y\" }");
    assert!((measure(&plane.scene.meshes()[0])[0] - 6.0).abs() < 1e-6, "a plane");
    // As OpenUSD computes the extents of planes 3 wide and 1.5 long.
    for (axis, most) in [("X", [0.0, 0.75, 1.5]), ("Y", [1.5, 0.0, 0.75]), ("Z", [1.5, 0.75, 0.0])] {
        let plane = load(&format!(
            "def Plane \"P\" {{ double width = 3\n double length = 1.5\n uniform token axis = \"{axis}\" }}"
        ));
        let positions = plane.scene.meshes()[0].positions.clone();
        let found = positions.into_iter().reduce(|a, b| [0, 1, 2].map(|k| a[k].max(b[k])));
        assert_eq!(found, Some(most), "{axis}");
    }
}
