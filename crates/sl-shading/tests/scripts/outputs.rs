// SPDX-License-Identifier: GPL-3.0-or-later
//! Outputs of surface shaders for layers of pictures, by the interpreter and by code.

use std::path::Path;

use glam::Vec3;
use gnurt_shading::{OutputKind, SurfaceShader, Vec3s};
use gnurt_sl_shading::{Access, Codes, Script};

use super::floor::{floor, script};

/// The values of an output; the same later, when there is code.
fn values(shader: &dyn SurfaceShader, name: &str) -> Vec<Vec3> {
    let hits = floor(37);
    let [mut first, mut then] = [(); 2].map(|()| Vec3s::splat(37, Vec3::ZERO));
    shader.output(name, &hits, &mut first);
    Codes::default().wait();
    shader.output(name, &hits, &mut then);
    let [first, then] = [first, then].map(|list| (0..37).map(|i| list.get(i)).collect::<Vec<_>>());
    assert_eq!(first, then, "code: {name}");
    first
}

#[test]
fn outputs_are_values_by_name() {
    let script = script(
        "surface s (float scale = 2, output float mask = 0, output color tint = 0, output normal n = 0, output int id = 7,
            output string text = \"\", output float list[2] = {1, 2}, output color unset = color (0.25, 0.5, 1)) {
            mask = u > 10; tint = color (u, v, scale); n = N; id = (int) u % 3; Ci = tint * emission (); }",
    );
    let shader = script.surface().expect("a surface");
    let all: Vec<(&str, OutputKind)> =
        shader.outputs().iter().map(|output| (&output.name[..], output.kind)).collect();
    let plain: Vec<_> = all.iter().filter(|(name, _)| !name.contains('.')).copied().collect();
    let expected = [
        ("mask", OutputKind::Number),
        ("tint", OutputKind::Color),
        ("n", OutputKind::Vector),
        ("id", OutputKind::Number),
        ("unset", OutputKind::Color),
    ];
    assert_eq!(plain, expected, "texts and arrays are no layers");
    for i in 0..37 {
        let number = |is: usize| Vec3::splat(is as f32);
        let u = i as f32;
        let expected = [
            ("mask", number(usize::from(i > 10))),
            ("tint", Vec3::new(u, 0.5, 2.0)),
            ("n", Vec3::Y),
            ("id", number(i % 3)),
            ("unset", Vec3::new(0.25, 0.5, 1.0)),
            ("nothing", Vec3::ZERO),
            ("scale", Vec3::ZERO),
        ];
        if i % 12 == 0 {
            for (name, value) in expected {
                assert_eq!(values(&*shader, name)[i], value, "{name}, point {i}");
            }
        }
    }
}

#[test]
fn layers_of_groups_have_outputs() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write("a.osl", "shader a (output float x = 0, output float only = 0) { x = 3 * u; only = 5; }");
    write("b.osl", "surface b (float from = 0, output float x = 0) { x = from + 1; Ci = emission (); }");
    write("g.oslgroup", "shader a first ; shader b last ; connect first.x last.from ;");
    let script =
        Script::open(Path::new(&folder.path().join("g.oslgroup")), &Access::default()).expect("a group");
    let shader = script.surface().expect("a surface");
    for (name, expected) in
        [("x", 13.0), ("last.x", 13.0), ("first.x", 12.0), ("first.only", 5.0), ("only", 5.0)]
    {
        assert_eq!(values(&*shader, name)[4].x, expected, "{name}");
    }
    assert!(script.faults().is_empty(), "{:?}", script.faults());
}

#[test]
fn debug_closures_are_outputs() {
    let script = script(
        "surface s (string part = \"rust\", output color both = color (1, 0, 0), output float plain = 3) {
            closure color c = u * debug (\"ramp\") + color (-1, 0, 2) * debug (part) + 0.5 * diffuse (N);
            if (u > 3) c += 2 * debug (\"ramp\");
            c = layer (0.25 * debug (\"under\") + 0 * sheen_bsdf (N, color (1), 0.5), c);
            string unknown = u > 1 ? \"ramp\" : \"nobody\";
            both = 4; plain = u; Ci = 0.5 * c + debug (\"both\") + 10 * debug (unknown); }",
    );
    let shader = script.surface().expect("a surface");
    let all: Vec<(&str, OutputKind)> =
        shader.outputs().iter().map(|output| (&output.name[..], output.kind)).collect();
    let color = OutputKind::Color;
    let expected =
        [("both", color), ("plain", OutputKind::Number), ("ramp", color), ("rust", color), ("under", color)];
    let mut sorted = all.clone();
    sorted.sort_by_key(|(name, _)| *name);
    assert_eq!(sorted, expected, "tags that are known beforehand");
    for i in [0_usize, 2, 4, 36] {
        let u = i as f32;
        // A tag that is computed adds to the known one.
        let more = if u > 1.0 { 10.0 } else { 0.0 };
        let ramp = 0.5 * (u + if u > 3.0 { 2.0 } else { 0.0 }) + more;
        for (name, value) in [
            ("ramp", Vec3::splat(ramp)),
            ("rust", Vec3::new(-0.5, 0.0, 1.0)),
            ("under", Vec3::splat(0.125)),
            ("both", Vec3::splat(5.0)),
            ("plain", Vec3::splat(u)),
            ("nobody", Vec3::ZERO),
        ] {
            assert!(
                (values(&*shader, name)[i] - value).length() < 1e-5,
                "{name}, point {i}: {}",
                values(&*shader, name)[i]
            );
        }
    }
    // They add no light.
    let mut out = gnurt_shading::bsdf::ClosureBatch::default();
    out.reset(37);
    shader.evaluate(&floor(37), &mut out);
    assert_eq!(out.emission(9), Vec3::ZERO);
}
