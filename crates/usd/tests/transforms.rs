// SPDX-License-Identifier: GPL-3.0-or-later
//! Transform operations, units and axes.

use gnurt_scene::Affine;
use gnurt_scene::io::LoadOptions;

use crate::support::{Folder, load, load_at, warnings};

const TRIANGLE: &str = r#"
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
"#;

fn place(operations: &str) -> Affine {
    let loaded = load(&format!("def Xform \"W\" {{\n{operations}\n def Mesh \"M\" {{ {TRIANGLE} }}\n}}"));
    assert_eq!(warnings(&loaded), "", "{operations}");
    loaded.scene.instances()[0].world_from_object
}

fn close(a: Affine, b: Affine) {
    let far =
        a.columns.as_flattened().iter().zip(b.columns.as_flattened()).any(|(a, b)| (a - b).abs() > 1e-6);
    assert!(!far, "{a:?} is not {b:?}");
}

#[test]
fn operations_go_from_the_outermost() {
    let found = place(
        "double3 xformOp:translate = (1, 2, 3)\nfloat3 xformOp:rotateXYZ = (90, 0, 90)\nfloat3 xformOp:scale = (2, 2, 2)\n
         uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateXYZ\", \"xformOp:scale\"]",
    );
    // x first: y goes to z, then z stays; x goes to y.
    let quarter = std::f64::consts::FRAC_PI_2;
    let turned = Affine::rotation([0.0, 0.0, 1.0], quarter) * Affine::rotation([1.0, 0.0, 0.0], quarter);
    close(found, Affine::translation([1.0, 2.0, 3.0]) * turned * Affine::scale([2.0; 3]));
}

#[test]
fn inverses_and_matrices() {
    let found = place(
        "double3 xformOp:translate:pivot = (1, 2, 3)\ndouble xformOp:rotateY = 90\n
         matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 5, 1))
         uniform token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:rotateY\", \"xformOp:transform\", \"!invert!xformOp:translate:pivot\"]",
    );
    let pivot = [1.0, 2.0, 3.0];
    let turn = Affine::rotation([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2);
    let expected = Affine::translation(pivot) * turn * Affine::translation([0.0, 0.0, 5.0]);
    close(found, expected * Affine::translation(pivot.map(|x: f64| -x)));
}

#[test]
fn units_and_axes_become_metres_and_y() {
    let text = format!("#usda 1.0\n(\n upAxis = \"Z\"\n)\ndef Mesh \"M\" {{ {TRIANGLE} }}\n");
    let loaded =
        Folder::with(&[("a.usda", &text)]).load("a.usda", &LoadOptions::default()).expect("a triangle");
    // Centimetres where nothing is said; z is y.
    let found = loaded.scene.instances()[0].world_from_object;
    let corner = found.point([1.0, 2.0, 3.0]);
    let near = corner.iter().zip([0.01, 0.03, -0.02]).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near, "{corner:?}");
}

#[test]
fn samples_are_interpolated_in_seconds() {
    let body = format!(
        "def Mesh \"M\" {{ {TRIANGLE} double3 xformOp:translate.timeSamples = {{ 0: (0, 0, 0), 24: (10, 0, 0) }}\n
         uniform token[] xformOpOrder = [\"xformOp:translate\"] }}"
    );
    let x = |at| load_at(&body, at).scene.instances()[0].world_from_object.columns[3][0];
    let turned = format!(
        "def Mesh \"M\" {{ {TRIANGLE} double xformOp:rotateZ.timeSamples = {{ 0: 0, 24: 180 }}\n
         uniform token[] xformOpOrder = [\"xformOp:rotateZ\"] }}"
    );
    let found = load_at(&turned, Some(0.5)).scene.instances()[0].world_from_object;
    close(found, Affine::rotation([0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_2));
    // 24 time codes a second where nothing is said.
    assert_eq!((x(None), x(Some(0.5)), x(Some(9.0))), (0.0, 5.0, 10.0), "at rest, between, behind the last");
}
