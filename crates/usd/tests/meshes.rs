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

/// Triangles without area are not shown, but counted.
#[test]
fn flat_triangles_are_counted() {
    let mesh = |indices: &str, count: usize| {
        let counts = vec!["3"; count].join(", ");
        format!(
            "def Mesh \"A\" {{ uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [{counts}]\n int[] faceVertexIndices = [{indices}]\n point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0)] }}\n"
        )
    };
    let flat = load(&mesh("0, 1, 2, 0, 1, 3, 0, 0, 2", 3));
    let counts: Vec<u64> = flat.scene.labels().flat_triangles.values().copied().collect();
    assert_eq!((counts, flat.scene.meshes()[0].indices.len()), (vec![2], 1));
    assert!(load(&mesh("0, 1, 2", 1)).scene.labels().flat_triangles.is_empty(), "none");
}
