// SPDX-License-Identifier: GPL-3.0-or-later
//! Lights: kinds, units, normalization.

use gnurt_scene::Light;
use gnurt_scene::labels::Luminaire;

use crate::support::{load, warnings};

#[test]
fn areas_shine_with_their_radiance() {
    let loaded = load(
        r#"
def RectLight "Rect" { float inputs:width = 2  float inputs:height = 3  float inputs:intensity = 5  float inputs:exposure = 1 }
def RectLight "Same" { float inputs:width = 2  float inputs:height = 3  float inputs:intensity = 60  bool inputs:normalize = 1 }
def DiskLight "Disk" { color3f inputs:color = (1, 0.5, 0) }
def SphereLight "Ball" { float inputs:radius = 1 }
def CylinderLight "Tube" { float inputs:length = 2 }
"#,
    );
    assert_eq!(warnings(&loaded), "");
    let scene = &loaded.scene;
    let kinds: Vec<Luminaire> = scene.labels().luminaires.values().copied().collect();
    let expected =
        [Luminaire::Rect, Luminaire::Rect, Luminaire::Disk, Luminaire::Sphere, Luminaire::Cylinder];
    assert_eq!(kinds, expected);
    let emission = |i: usize| scene.material(scene.meshes()[i].material).emission;
    assert_eq!(
        (emission(0), emission(1), emission(2)),
        ([10.0; 3], [10.0; 3], [1.0, 0.5, 0.0]),
        "W per area and angle"
    );
    assert_eq!(
        scene.meshes()[3].primitives,
        gnurt_scene::Primitives::Spheres(vec![1.0]),
        "a ball is a sphere"
    );
    // They shine along -z, and balls outwards.
    for mesh in &scene.meshes()[..3] {
        let [a, b, c] = mesh.indices[0].map(|i| mesh.positions[i as usize]);
        let up = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(up < 0.0, "{}: {mesh:?}", mesh.name);
    }
}

#[test]
fn lights_without_surface() {
    let loaded = load(
        r#"
def DistantLight "Sun" { float inputs:intensity = 3  float inputs:angle = 0 }
def DistantLight "Wide" { float inputs:intensity = 100  float inputs:angle = 1 }
def SphereLight "Point" { bool treatAsPoint = 1  float inputs:radius = 2  float inputs:intensity = 1 }
def SphereLight "Spot" ( prepend apiSchemas = ["ShapingAPI"] ) {
    float inputs:shaping:cone:angle = 30
    float inputs:shaping:cone:softness = 0.5
    bool inputs:normalize = 1
    float inputs:intensity = 8
}
def DomeLight "Sky" { float inputs:intensity = 0.5 }
"#,
    );
    assert_eq!(warnings(&loaded), "");
    let [sun, wide, point, spot, sky] = loaded.scene.lights() else { panic!("five lights") };
    assert_eq!(*sun, Light::Directional { direction: [0.0, 0.0, -1.0], irradiance: [3.0; 3], angle: 0.0 });
    let Light::Directional { irradiance, angle, .. } = wide else { panic!("a direction") };
    // Radiance times the projected solid angle of half a degree around.
    let spread = std::f64::consts::PI * 0.5_f64.to_radians().sin().powi(2);
    assert!((f64::from(irradiance[0]) / (100.0 * spread) - 1.0).abs() < 1e-5, "{irradiance:?}");
    assert!((angle.to_degrees() - 1.0).abs() < 1e-5, "{angle}");
    let Light::Point { intensity, radius: 0.0, .. } = point else { panic!("a point") };
    assert!(
        (intensity[0] - 4.0 * std::f32::consts::PI).abs() < 1e-4,
        "radiance times the disk: {intensity:?}"
    );
    let Light::Spot { intensity, inner_angle, outer_angle, radius, .. } = spot else { panic!("a spot") };
    assert!((intensity[0] - 2.0).abs() < 1e-5 && (outer_angle.to_degrees() - 30.0).abs() < 1e-3, "{spot:?}");
    assert!((inner_angle.to_degrees() - 15.0).abs() < 0.1, "{inner_angle}");
    assert!(*radius == 0.5, "half shadows, for it is no point: {radius}");
    assert!(matches!(sky, Light::Environment { radiance: [0.5, 0.5, 0.5], .. }), "{sky:?}");
}

#[test]
fn temperatures_tint() {
    let loaded = load(
        "def RectLight \"Warm\" { bool inputs:enableColorTemperature = 1\n float inputs:colorTemperature = 3000 }
         def RectLight \"Day\" { bool inputs:enableColorTemperature = 1 }",
    );
    let emission = |i: usize| loaded.scene.material(loaded.scene.meshes()[i].material).emission;
    let [r, g, b] = emission(0);
    assert!(r > g && g > b, "3000 K is orange: {r} {g} {b}");
    let luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    assert!((luminance - 1.0).abs() < 1e-3, "the luminance stays: {luminance}");
    assert!(emission(1).iter().all(|x| (x - 1.0).abs() < 0.06), "6500 K is nearly white: {:?}", emission(1));
}

#[test]
fn what_is_not_there_is_named() {
    let loaded = load(
        "def RectLight \"L\" ( prepend apiSchemas = [\"ShapingAPI\"] ) { float inputs:shaping:cone:angle = 20\n bool inputs:shadow:enable = 0 }",
    );
    let reported = warnings(&loaded);
    assert!(
        reported.contains("/L: the shaping") && reported.contains("/L: a light without shadows"),
        "{reported}"
    );
}

#[test]
fn attributes_put_lights_into_groups() {
    let loaded = load(
        r#"
def RectLight "Key" { token ri:light:lightGroup = "key" }
def DomeLight "Sky" { string lightGroup = "sky" }
def DistantLight "Sun" { float inputs:angle = 0 }
"#,
    );
    assert_eq!(loaded.scene.labels().group_names(), ["key", "sky"]);
    assert_eq!(loaded.scene.labels().light_groups.len(), 2);
}

#[test]
fn collections_link_lights() {
    use gnurt_scene::labels::Shining;
    use gnurt_scene::{InstanceId, LightId};

    let loaded = load(
        r#"
def Xform "Set" { def Cube "A" {} def Cube "B" {} }
def Cube "C" {}
def DistantLight "All" { float inputs:angle = 0 }
def DistantLight "Some" {
    float inputs:angle = 0
    uniform bool collection:lightLink:includeRoot = 0
    rel collection:lightLink:includes = [</Set>]
    rel collection:lightLink:excludes = [</Set/B>]
    rel collection:shadowLink:excludes = [</C>]
}
def RectLight "Rect" {
    uniform bool collection:lightLink:includeRoot = 0
    rel collection:lightLink:includes = [</C>]
}
"#,
    );
    assert_eq!(warnings(&loaded), "");
    let scene = &loaded.scene;
    let links = &scene.labels().light_links;
    assert_eq!(links.len(), 2, "others light everything: {links:?}");
    let names = |ids: &Option<Vec<InstanceId>>| -> Vec<String> {
        ids.iter().flatten().map(|&id| scene.instance(id).name.clone()).collect()
    };
    let some = &links[&Shining::Light(LightId(1))];
    assert_eq!(names(&some.lit), ["/Set/A"]);
    assert_eq!(names(&some.shadows), ["/Set/A", "/Set/B", "/Rect"], "all but one");
    let rect = links.iter().find(|(shining, _)| matches!(shining, Shining::Material(_))).expect("a surface");
    assert_eq!(names(&rect.1.lit), ["/C"]);
}
