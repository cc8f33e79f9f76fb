// SPDX-License-Identifier: GPL-3.0-or-later
//! Meshes: values over them, holes, polygons, subsets.

use crate::support::{load, warnings};

const QUAD: &str = r#"
def Xform "World" {
    double3 xformOp:translate = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Mesh "Quad" {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    }
}
"#;

#[test]
fn a_quadrangle_is_two_triangles() {
    let loaded = load(QUAD);
    assert_eq!(warnings(&loaded), "");
    let [instance] = loaded.scene.instances() else { panic!("one instance") };
    assert_eq!(instance.name, "/World/Quad");
    assert_eq!(instance.world_from_object.columns[3], [1.0, 2.0, 3.0]);
    assert_eq!(loaded.scene.meshes()[0].indices, [[0, 1, 2], [0, 2, 3]]);
}
