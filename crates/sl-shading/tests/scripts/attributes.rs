// SPDX-License-Identifier: GPL-3.0-or-later
//! `getattribute` about the camera, names and numbers of a point's geometry, and elements of arrays.

use std::sync::Arc;

use glam::Vec3;
use gnurt_accel::RayBatch;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_shading::{
    AttributeRequest, CameraProjection, CameraProperties, CameraSamples, SceneNames, SurfaceBatch,
    SurfaceShader,
};
use gnurt_sl_shading::{CameraFrame, Codes};

use super::floor::{floor, script, surface};

fn camera() -> CameraProperties {
    CameraProperties {
        resolution: [640, 320],
        projection: Some(CameraProjection::Perspective { half_height: 1.0 }),
        shutter: [0.0, 1.0],
    }
}

/// The emission of the last point; the same when there is code.
fn emitted(shader: &dyn SurfaceShader, hits: &SurfaceBatch) -> Vec3 {
    let mut out = ClosureBatch::default();
    let mut shine = || {
        out.reset(hits.len());
        shader.evaluate(hits, &mut out);
        out.emission(hits.len() - 1)
    };
    let first = shine();
    Codes::default().wait();
    assert_eq!(first, shine(), "code and interpreter");
    first
}

/// What the statements make of a colour `c` and an int `found`: the colour, or -1 for nothing, plus 2.
fn found(statements: &str, hits: &SurfaceBatch) -> Vec3 {
    let shader = surface(&format!(
        "color c = 0; int found = 0; {statements} Ci = (found ? c + 2 : color (1)) * emission ();"
    ));
    emitted(&*shader, hits) - Vec3::splat(2.0)
}

const NOTHING: Vec3 = Vec3::NEG_ONE;

#[test]
fn values_of_the_mesh_change_from_pixel_to_pixel() {
    let mut hits = floor(3);
    hits.ray_dir = gnurt_shading::Vec3s::splat(3, -Vec3::Y);
    hits.footprint = vec![0.25; 3];
    // Component k of every value is 5 + k, and its gradient (k, 0, -2).
    let show = |declared: &str, statements: &str, hits: &mut SurfaceBatch| {
        let text = format!(
            "surface s ({declared}) {{ vector x = Dx (P), y = Dy (P); color c = 0; {statements} Ci = (c + 2) * emission (); }}"
        );
        let shader = script(&text).surface().expect("a surface");
        let value = |request: &AttributeRequest| -> Vec<f32> {
            let is_gradient = request.name.starts_with(AttributeRequest::GRADIENT);
            let of = |k: usize| match (is_gradient, k % 3) {
                (false, _) => 5.0 + k as f32,
                (true, 0) => (k / 3) as f32,
                (true, 1) => 0.0,
                (true, _) => -2.0,
            };
            (0..request.components as usize).flat_map(|k| [of(k); 3]).collect()
        };
        hits.attributes = shader.attributes().iter().map(value).collect();
        emitted(&*shader, hits) - Vec3::splat(2.0)
    };
    let slopes = "c = color (Dx (heat), Dy (heat), heat);";
    let expected = |k: usize| {
        format!("c = color (dot (x, vector ({k}, 0, -2)), dot (y, vector ({k}, 0, -2)), {});", 5 + k)
    };
    let other = "float f = 7 + 0.5 * x[0]; c = color (Dx (f), Dy (f), 1);";
    assert_eq!(show("", other, &mut hits), Vec3::Z, "what has no slope has none");
    for (declared, statements, k) in [
        ("float heat = 0 [[ int lockgeom = 0 ]]", slopes.to_owned(), 0),
        ("", format!("float heat; getattribute (\"heat\", heat); {slopes}"), 0),
        ("", format!("float heat; getattribute (\"list\", 2, heat); {slopes}"), 2),
        ("", format!("vector way; getattribute (\"way\", way); float heat = way[1]; {slopes}"), 1),
        ("color Cd = 0 [[ int lockgeom = 0 ]]", format!("float heat = Cd[2]; {slopes}"), 2),
    ] {
        let [found, wanted] = [show(declared, &statements, &mut hits), show("", &expected(k), &mut hits)];
        assert!(
            (found - wanted).abs().max_element() < 1e-6,
            "{declared} {statements}: {found}, not {wanted}"
        );
        assert!(wanted.x != 0.0 || wanted.y != 0.0, "a slope: {wanted}");
    }
    // Coordinates change as u and v do.
    let uv = "float st[2] = {0, 0}; getattribute (\"st\", st); c = color (Dx (st[0]), Dy (st[1]), 0);";
    let shader = surface(&format!("color c = 0; {uv} Ci = (c + 2) * emission ();"));
    hits.attributes = shader.attributes().iter().map(|r| vec![f32::NAN; 3 * r.components as usize]).collect();
    let found = emitted(&*shader, &hits);
    let own = surface("Ci = (2 + color (Dx (u), Dy (v), 0)) * emission ();");
    assert_eq!(found, emitted(&*own, &hits));
    assert_ne!(found, Vec3::splat(2.0));
}

#[test]
fn the_camera_has_its_standard_attributes() {
    let mut hits = floor(3);
    hits.camera = Some(camera());
    let one = Vec3::splat;
    for (statements, expected) in [
        (
            "int r[2]; found = getattribute (\"camera:resolution\", r); c = color (r[0], r[1], 0);",
            Vec3::new(640.0, 320.0, 0.0),
        ),
        ("int r = 0; found = getattribute (\"camera:resolution\", 1, r); c = r;", one(320.0)),
        ("int r = 0; found = getattribute (\"camera:resolution\", 2, r);", NOTHING),
        ("float x = 0; found = getattribute (\"camera:pixelaspect\", x); c = x;", one(1.0)),
        (
            "string s = \"\"; found = getattribute (\"camera:projection\", s); c = s == \"perspective\";",
            one(1.0),
        ),
        ("float x = 0; found = getattribute (\"camera:fov\", x); c = x;", one(90.0)),
        ("int x = 0; found = getattribute (\"camera:fov\", x); c = x;", one(90.0)),
        ("found = getattribute (\"camera:fov\", c);", one(90.0)),
        (
            "float x[2]; found = getattribute (\"camera:fov\", x); c = color (x[0], x[1], 0);",
            Vec3::new(90.0, 90.0, 0.0),
        ),
        ("float x = 1; found = getattribute (\"camera:clip_near\", x); c = x;", one(0.0)),
        ("float x = 0; found = getattribute (\"camera:clip_far\", x); c = x == 1e30;", one(1.0)),
        ("float x[2]; found = getattribute (\"camera:clip\", x); c = x[1] == 1e30;", one(1.0)),
        ("float x = 0; found = getattribute (\"camera:shutter_close\", x); c = x;", one(1.0)),
        ("float x = 1; found = getattribute (\"camera:shutter_open\", x); c = x;", one(0.0)),
        ("found = getattribute (\"camera:shutter\", c);", Vec3::Y),
        (
            "float w[4]; found = getattribute (\"camera:screen_window\", w); c = color (w[0], w[1], w[2] + w[3]);",
            Vec3::new(-2.0, -1.0, 3.0),
        ),
        ("float w[3]; found = getattribute (\"camera:screen_window\", w);", NOTHING),
        ("string s = \"\"; found = getattribute (\"camera:fov\", s);", NOTHING),
        ("float x = 0; found = getattribute (\"camera:weight\", x);", NOTHING),
        ("float x = 0; found = getattribute (\"global\", \"camera:fov\", x); c = x;", one(90.0)),
        ("float x = 0; found = getattribute (\"lamp\", \"camera:fov\", x);", NOTHING),
        (
            "string n = concat (\"camera:\", u > 1 ? \"fov\" : \"clip_near\"); float x = 0; found = getattribute (n, x); c = x;",
            one(90.0),
        ),
        ("int n = 0; found = getattribute (\"global\", \"osl:version\", n); c = n > 10000;", one(1.0)),
    ] {
        assert!(
            (found(statements, &hits) - expected).length() < 1e-4,
            "{statements}: {}",
            found(statements, &hits)
        );
    }
    hits.camera = None;
    assert_eq!(found("float x = 0; found = getattribute (\"camera:fov\", x);", &hits), NOTHING, "no camera");
    hits.camera = Some(CameraProperties { projection: Some(CameraProjection::Panorama), ..camera() });
    assert_eq!(found("float x = 0; found = getattribute (\"camera:fov\", x);", &hits), NOTHING, "no angle");
}

#[test]
fn other_objects_are_found_by_their_names() {
    let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
    let mut hits = floor(3);
    let values = [("heat".to_owned(), vec![3.0]), ("tint".to_owned(), vec![0.25, 0.5, 0.75])];
    hits.names = Some(Arc::new(SceneNames {
        instances: list(&["", "/room/chair"]),
        objects: list(&["floor", "", "stool"]),
        object_of: vec![0, 2],
        constants: [(2, values.into_iter().collect())].into_iter().collect(),
        ..SceneNames::default()
    }));
    hits.attributes = vec![vec![0.0; 12], vec![0.0; 3]];
    let one = Vec3::splat;
    for (statements, expected) in [
        ("float x = 0; found = getattribute (\"stool\", \"heat\", x); c = x;", one(3.0)),
        ("float x = 0; found = getattribute (\"/room/chair\", \"heat\", x); c = x;", one(3.0)),
        ("int x = 0; found = getattribute (\"chair\", \"heat\", x); c = x;", one(3.0)),
        ("found = getattribute (\"chair\", \"tint\", c);", Vec3::new(0.25, 0.5, 0.75)),
        ("float x = 0; found = getattribute (\"chair\", \"tint\", 2, x); c = x;", one(0.75)),
        ("float x = 0; found = getattribute (\"chair\", \"tint\", 3, x);", NOTHING),
        ("found = getattribute (\"chair\", \"heat\", c);", NOTHING),
        ("float x = 0; found = getattribute (\"floor\", \"heat\", x);", NOTHING),
        ("float x = 0; found = getattribute (\"nobody\", \"heat\", x);", NOTHING),
        (
            "string o = u > 1 ? \"stool\" : \"floor\"; int x = 0; found = getattribute (o, \"object\", x); c = x;",
            one(2.0),
        ),
        ("int x = 0; found = getattribute (\"chair\", \"instance\", x); c = x;", one(1.0)),
        ("int x = 0; found = getattribute (\"stool\", \"instance\", x);", NOTHING),
        ("string s; found = getattribute (\"chair\", \"geom:name\", s); c = s == \"/room/chair\";", one(1.0)),
        ("string s; found = getattribute (\"chair\", \"object\", s); c = s == \"stool\";", one(1.0)),
    ] {
        let shown = found(statements, &hits);
        assert!((shown - expected).length() < 1e-5, "{statements}: {shown}");
    }
    let shader = surface("float x = 0; getattribute (\"chair\", \"heat\", x); Ci = x * emission ();");
    let names: Vec<&str> = shader.attributes().iter().map(|request| &request.name[..]).collect();
    assert_eq!(names, [AttributeRequest::IDS, AttributeRequest::OBJECTS]);
}

#[test]
fn camera_shaders_know_their_picture() {
    let script = script(
        "camera c () { int r[2]; float t[2]; getattribute (\"camera:resolution\", r);
            getattribute (\"camera:shutter\", t); P = point (r[0], r[1], t[1]); I = vector (0, 0, -1); }",
    );
    let frame = CameraFrame {
        eye: [0.0; 3],
        right: [1.0, 0.0, 0.0],
        up: [0.0, 1.0, 0.0],
        back: [0.0, 0.0, 1.0],
        pixels: [200, 100],
    };
    let mut rays = RayBatch::default();
    let samples = CameraSamples { positions: &[[0.5; 2]], lens: &[], times: &[0.25] };
    script.camera(frame).expect("a camera").rays(&samples, 2.0, &mut rays);
    assert_eq!(rays.get(0).org, [200.0, 100.0, 1.0]);
}

#[test]
fn parts_have_names_and_numbers() {
    let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
    let mut hits = floor(3);
    hits.names = Some(Arc::new(SceneNames {
        instances: list(&["", "chair"]),
        objects: list(&["", "", "stool"]),
        materials: list(&["wood"]),
        ..SceneNames::default()
    }));
    let ids = |i: usize| [[0, 1, 2], [2, 2, 2], [0, 0, 0], [5, 16_777_217, 7]].map(|row| row[i]);
    let rows = (0..4).flat_map(|k| (0..3).map(move |i| f32::from_bits(ids(i)[k])));
    hits.attributes = vec![rows.collect()];
    for (expression, expected) in [
        (
            "string s = \"\"; found = getattribute (\"geom:name\", s); c = color (s == \"stool\", s == \"chair\", 0);",
            Vec3::ZERO,
        ),
        ("string s = \"\"; found = getattribute (\"object\", s); c = s == \"stool\";", Vec3::ONE),
        ("string s = \"\"; found = getattribute (\"material\", s); c = s == \"wood\";", Vec3::ONE),
        ("int n = 0; found = getattribute (\"prim\", n); c = n;", Vec3::splat(7.0)),
        ("int n = 0; found = getattribute (\"instance\", n); c = n;", Vec3::splat(2.0)),
        ("string s = \"\"; found = getattribute (\"prim\", s);", NOTHING),
        ("float x = 0; found = getattribute (\"object\", x);", NOTHING),
    ] {
        let text = format!(
            "color c = 0; int found = 0; {expression} Ci = (found ? c + 2 : color (1)) * emission ();"
        );
        let shader = surface(&text);
        let names: Vec<(&str, u32)> =
            shader.attributes().iter().map(|request| (&request.name[..], request.components)).collect();
        assert_eq!(names, [(AttributeRequest::IDS, 4)], "{expression}");
        // Instance 2 has no name: its geometry has that of the object.
        let expected = if expression.contains("geom:name") { Vec3::X } else { expected };
        assert_eq!(emitted(&*shader, &hits) - Vec3::splat(2.0), expected, "{expression}");
    }
    let exact = "int n = 0; getattribute (\"prim\", n); Ci = (n == 16777217) * emission ();";
    let mut out = ClosureBatch::default();
    out.reset(3);
    surface(exact).evaluate(&hits, &mut out);
    assert_eq!(out.emission(1), Vec3::ONE, "numbers are exact");
}

#[test]
fn elements_of_attributes_have_an_index() {
    let shader = surface(
        "float a = 0, b = 0, c = 0; int found = getattribute (\"heat\", 1, b); getattribute (\"\", \"heat\", a);
            if (getattribute (\"heat\", 7, c)) found = 9;
            if (getattribute (\"\", \"heat\", -1, c)) found = 9;
            Ci = color (a, b, found) * emission ();",
    );
    let names: Vec<(&str, u32)> =
        shader.attributes().iter().map(|request| (&request.name[..], request.components)).collect();
    assert_eq!(names, [("heat", 8)]);
    let mut hits = floor(2);
    // A mesh with two components.
    let rows = (0..8).flat_map(|k| [0.0, if k < 2 { 3.0 + k as f32 } else { f32::NAN }]);
    hits.attributes = vec![rows.collect()];
    assert_eq!(emitted(&*shader, &hits), Vec3::new(3.0, 4.0, 1.0));
}
