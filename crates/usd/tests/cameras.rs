// SPDX-License-Identifier: GPL-3.0-or-later
//! Cameras and render settings.

use gnurt_scene::Projection;

use crate::support::{load, warnings};

#[test]
fn lengths_are_tenths_of_a_unit() {
    let loaded = load(
        r#"
def Camera "C" {
    float verticalAperture = 20
    float focalLength = 10
    float focusDistance = 4
    float fStop = 2
    float horizontalApertureOffset = 5
    float verticalApertureOffset = -10
    double3 xformOp:translate = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "Parallel" { token projection = "orthographic"  float verticalAperture = 30 }
def Scope "Render" {
    def RenderSettings "S" { rel camera = </Parallel>  int2 resolution = (640, 480) }
}
"#,
    );
    assert_eq!(warnings(&loaded), "", "nothing is odd but that it is empty");
    let [camera, parallel] = loaded.scene.cameras() else { panic!("two cameras") };
    assert_eq!((camera.eye, camera.target), ([1.0, 2.0, 3.0], [1.0, 2.0, -1.0]), "along -z to the focus");
    assert!((camera.fov_y - 90.0).abs() < 1e-4, "{}", camera.fov_y);
    assert!((camera.lens.aperture - 0.5).abs() < 1e-6, "a tenth of 10 over 2: {:?}", camera.lens);
    assert_eq!(camera.lens.focus, Some(4.0));
    assert_eq!((camera.shift, parallel.shift), ([0.25, -0.5], [0.0; 2]), "in heights of the aperture");
    assert_eq!(parallel.projection, Projection::Orthographic { height: 3.0 });
    let labels = loaded.scene.labels();
    assert_eq!(
        (labels.camera.map(|id| id.0), labels.resolution),
        (Some(1), Some([640, 480])),
        "what is wished"
    );
}

#[test]
fn render_variables_are_outputs() {
    let loaded = load(
        r#"
def Scope "Render" {
    def RenderSettings "Settings" { rel products = [</Render/Beauty>] }
    def RenderProduct "Beauty" { rel orderedVars = [</Render/Color>, </Render/Key>, </Render/Normals>, </Render/Odd>] }
    def RenderVar "Color" { string sourceName = "Ci" }
    def RenderVar "Key" { uniform token sourceType = "lpe"  uniform string sourceName = "lpe:C.*<L.'key'>" }
    def RenderVar "Normals" { string sourceName = "Nn" }
    def RenderVar "Odd" { uniform token sourceType = "primvar"  string sourceName = "st" }
}
"#,
    );
    assert_eq!(loaded.scene.labels().outputs, ["Key=C.*<L.'key'>", "normal"]);
    assert!(warnings(&loaded).contains("primvar 'st'"), "{}", warnings(&loaded));
}
