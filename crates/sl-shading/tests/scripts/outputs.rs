// SPDX-License-Identifier: GPL-3.0-or-later
//! Outputs of surface shaders for layers of pictures, by the interpreter and by code.

use std::path::Path;

use glam::Vec3;
use gnurt_shading::{OutputKind, SurfaceShader, Vec3s};
use gnurt_sl_shading::{Access, Script};

use super::floor::{floor, script};

/// The values of an output; the same later, when there is code.
fn values(shader: &dyn SurfaceShader, name: &str) -> Vec<Vec3> {
    let hits = floor(37);
    let [mut first, mut then] = [(); 2].map(|()| Vec3s::splat(37, Vec3::ZERO));
    shader.output(name, &hits, &mut first);
    std::thread::sleep(std::time::Duration::from_millis(150));
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
