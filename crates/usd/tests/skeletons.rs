// SPDX-License-Identifier: GPL-3.0-or-later
//! Skeletons and blend shapes at a moment. The judge compares them with OpenUSD's own skinning.

use crate::support::{load_at, warnings};

const RIG: &str = r#"
def SkelRoot "R" {
    def Skeleton "S" ( prepend apiSchemas = ["SkelBindingAPI"] ) {
        uniform token[] joints = ["A", "A/B"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,2,0,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,2,0,1))]
        rel skel:animationSource = </R/S/M>
        def SkelAnimation "M" {
            uniform token[] joints = ["A/B"]
            float3[] translations = [(0, 2, 0)]
            half3[] scales = [(1, 1, 1)]
            quatf[] rotations.timeSamples = { 0: [(1, 0, 0, 0)], 24: [(0.70710678, 0, 0, 0.70710678)] }
            uniform token[] blendShapes = ["wide"]
            float[] blendShapeWeights.timeSamples = { 0: [0], 24: [1] }
        }
    }
    def Mesh "T" ( prepend apiSchemas = ["SkelBindingAPI"] ) {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 2, 0), (0, 3, 0)]
        int[] primvars:skel:jointIndices = [0, 1, 1] ( elementSize = 1  interpolation = "vertex" )
        float[] primvars:skel:jointWeights = [1, 1, 1] ( elementSize = 1  interpolation = "vertex" )
        uniform token[] skel:blendShapes = ["wide"]
        rel skel:blendShapeTargets = </R/T/Wide>
        rel skel:skeleton = </R/S>
        def BlendShape "Wide" {
            uniform vector3f[] offsets = [(4, 0, 0)]
            uniform int[] pointIndices = [1]
            uniform vector3f[] inbetweens:half = [(0, 0, 8)] ( weight = 0.5 )
        }
    }
}
"#;

fn points(at: f64) -> Vec<[f32; 3]> {
    let loaded = load_at(RIG, Some(at));
    assert_eq!(warnings(&loaded), "");
    loaded.scene.meshes()[0].positions.clone()
}

#[track_caller]
fn close(found: &[[f32; 3]], expected: [[f32; 3]; 3]) {
    let far = found.iter().flatten().zip(expected.as_flattened()).any(|(a, b)| (a - b).abs() > 1e-5);
    assert!(!far, "{found:?} is not {expected:?}");
}

#[test]
fn joints_and_shapes_bend() {
    close(&points(0.0), [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [0.0, 3.0, 0.0]]);
    // The second point is 4 wider, then a quarter turn around (0, 2, 0): x to y, y to -x.
    close(&points(1.0), [[0.0, 0.0, 0.0], [0.0, 7.0, 0.0], [-1.0, 2.0, 0.0]]);
    // Half of the way the shape is the one between.
    let half = points(0.5)[1];
    assert!((half[2] - 8.0).abs() < 1e-5, "{half:?}");
}
