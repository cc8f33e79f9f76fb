// SPDX-License-Identifier: GPL-3.0-or-later
//! Instances: native ones and those at points.

use crate::support::{load, warnings};

const CUBE: &str = "def Cube \"C\" { double size = 1 }";

#[test]
fn native_instances_share_their_mesh() {
    let mesh = "def Mesh \"M\" { uniform token subdivisionScheme = \"none\"\n int[] faceVertexCounts = [3]\n
        int[] faceVertexIndices = [0, 1, 2]\n point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)] }";
    let instance = |name: &str, x: i32| {
        format!(
            "def Xform \"{name}\" ( instanceable = true\n prepend references = </P> ) {{
               double3 xformOp:translate = ({x}, 0, 0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"] }}\n"
        )
    };
    let loaded = load(&format!("class Xform \"P\" {{ {mesh} }}\n{}{}", instance("A", 1), instance("B", 2)));
    assert_eq!(warnings(&loaded), "");
    let scene = &loaded.scene;
    assert_eq!((scene.meshes().len(), scene.instances().len()), (1, 2), "one mesh, shown twice");
    assert_eq!(scene.instances()[1].name, "/B/M", "its path is that of the instance");
}

#[test]
fn instancers_nest_and_hide() {
    let loaded = load(&format!(
        r#"
def PointInstancer "Outer" {{
    rel prototypes = </Outer/Inner>
    int[] protoIndices = [0, 0]
    point3f[] positions = [(0, 0, 0), (0, 10, 0)]
    def PointInstancer "Inner" {{
        rel prototypes = </Outer/Inner/C>
        int[] protoIndices = [0, 0, 0]
        point3f[] positions = [(0, 0, 0), (2, 0, 0), (4, 0, 0)]
        quath[] orientations = [(1, 0, 0, 0), (0.7071, 0, 0, 0.7071), (1, 0, 0, 0)]
        float3[] scales = [(1, 1, 1), (3, 1, 1), (1, 1, 1)]
        int64[] ids = [7, 8, 9]
        int64[] invisibleIds = [9]
        {CUBE}
    }}
}}
"#
    ));
    assert_eq!(warnings(&loaded), "");
    let shown: Vec<_> = loaded.scene.occurrences().filter(|found| !found.object.meshes.is_empty()).collect();
    assert_eq!(shown.len(), 4, "two of three, twice");
    assert!(shown.iter().all(|found| found.name == "/Outer/Inner/C"), "the prim that is shown");
    // Scaled along x, then turned to y.
    let along = shown[1].world_from_object.vector([1.0, 0.0, 0.0]);
    assert!(along[0].abs() < 1e-2 && (along[1] - 3.0).abs() < 1e-2, "{along:?}");
    assert_eq!(
        shown[2].world_from_object.columns[3],
        [0.0, 10.0, 0.0],
        "the second instance of the inner one"
    );
}

#[test]
fn faulty_instancers_are_named() {
    let loaded = load(
        "def PointInstancer \"I\" { int[] protoIndices = [0, 1]\n point3f[] positions = [(0, 0, 0)] }
         def PointInstancer \"J\" { rel prototypes = </J>\n int[] protoIndices = [0]\n point3f[] positions = [(0, 0, 0)] }",
    );
    assert!(warnings(&loaded).contains("/I: 2 protoIndices"), "{}", warnings(&loaded));
    assert!(loaded.scene.meshes().is_empty(), "one that repeats itself shows nothing");
}

/// Inactive ones are metadata, which layers edit as lists.
#[test]
fn inactive_ones_are_not_shown() {
    let shown = |edit: &str| {
        let body = format!(
            "def PointInstancer \"P\" ( {edit} ) {{ rel prototypes = </P/C>\n int[] protoIndices = [0, 0, 0]\n point3f[] positions = [(0, 0, 0), (2, 0, 0), (4, 0, 0)]\n {CUBE} }}"
        );
        let loaded = load(&body);
        assert_eq!(warnings(&loaded), "", "{edit}");
        loaded.scene.occurrences().filter(|found| !found.object.meshes.is_empty()).count()
    };
    assert_eq!(shown(""), 3);
    assert_eq!(shown("inactiveIds = [1]"), 2);
    assert_eq!(shown("append inactiveIds = [0, 2]"), 1);
    assert_eq!(shown("prepend inactiveIds = [1]"), 2);
    assert_eq!(shown("delete inactiveIds = [1]"), 3);
}
