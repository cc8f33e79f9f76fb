// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters that change without compiling, and files that are read again.

use glam::Vec3;
use gnurt_shading::SurfaceShader;
use gnurt_shading::bsdf::ClosureBatch;
use gnurt_sl_shading::{Access, ParameterValue, Script};

use super::floor::{floor, script};

fn emitted(shader: &dyn SurfaceShader) -> Vec<Vec3> {
    let (hits, mut out) = (floor(20), ClosureBatch::default());
    out.reset(20);
    shader.evaluate(&hits, &mut out);
    (0..20).map(|i| out.emission(i)).collect()
}

fn all(shader: &dyn SurfaceShader) -> Vec3 {
    let light = emitted(shader);
    assert!(light.iter().all(|x| *x == light[0]), "alike: {light:?}");
    light[0]
}

const TEXT: &str =
    "surface s (float gain = 2 [[ float min = 0, float max = 4, float step = 0.5, string label = \"Gain\" ]],
    color tint = color (1, 2, 3), int steps = 1 [[ string widget = \"checkBox\" ]], float made = gain * 2,
    string word = \"a\", float heat = 5 [[ int interpolated = 1 ]])
    { Ci = (gain * tint + steps + (word == \"b\") * 100 + (made > 1000)) * emission (); }";

#[test]
fn numbers_change_in_shaders_that_are_there() {
    let mut tuned = script(TEXT);
    let plain = tuned.surface().expect("a surface");
    tuned.make_tunable();
    let shader = tuned.surface().expect("a surface");
    assert_eq!(shader.attributes().len(), 1, "only the mesh's own is asked of it");
    assert_eq!(all(&*shader), Vec3::new(3.0, 5.0, 7.0), "the same value at first");
    tuned.tune("gain", &ParameterValue::Floats(vec![1.0])).expect("a number");
    tuned.tune("steps", &ParameterValue::Ints(vec![0])).expect("a number");
    assert_eq!(all(&*shader), Vec3::new(1.0, 2.0, 3.0), "at once");
    tuned.tune("tint", &ParameterValue::Floats(vec![0.5])).expect("one for all");
    assert_eq!(all(&*shader), Vec3::splat(0.5));
    assert_eq!(all(&*tuned.surface().expect("a surface")), Vec3::splat(0.5), "and in new ones");
    assert_eq!(all(&*plain), Vec3::new(3.0, 5.0, 7.0), "not in those made before");
    for (name, value) in [
        ("word", ParameterValue::Texts(vec!["b".into()])),
        ("made", ParameterValue::Floats(vec![1.0])),
        ("heat", ParameterValue::Floats(vec![1.0])),
        ("gian", ParameterValue::Floats(vec![1.0])),
    ] {
        assert!(tuned.tune(name, &value).is_err(), "{name}");
    }
    let gain = tuned.parameters().into_iter().find(|p| p.name == "gain").expect("it is there");
    assert_eq!((gain.range, gain.step, gain.is_tunable), (Some([0.0, 4.0]), Some(0.5), true));
    assert_eq!(gain.default, ParameterValue::Floats(vec![1.0]), "its value now");
}

#[test]
fn files_are_read_again_with_the_values_given() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("s.osl");
    std::fs::write(&path, "surface s (float a = 1, float b = 2) { Ci = (a + b) * emission (); }")
        .expect("a file");
    let mut first = Script::open(&path, &Access::default()).expect("it compiles");
    for (name, value) in [("a", 5.0), ("b", 7.0)] {
        first.set(name, &ParameterValue::Floats(vec![value])).expect("a number");
    }
    std::fs::write(&path, "surface s (float a = 1) { Ci = 2 * a * emission (); }").expect("a file");
    let second = first.again().expect("it compiles");
    assert_eq!(all(&*second.surface().expect("a surface")), Vec3::splat(10.0), "the value stays");
    assert!(second.warnings().iter().any(|line| line.contains("'b'")), "{:?}", second.warnings());
    std::fs::write(&path, "surface s ( { }").expect("a file");
    let why = second.again().expect_err("it is broken");
    assert!(why.contains("s.osl:1"), "{why}");
}
