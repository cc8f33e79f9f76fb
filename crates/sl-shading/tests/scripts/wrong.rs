// SPDX-License-Identifier: GPL-3.0-or-later
//! Files, values and shaders that are wrong.

use std::path::Path;

use gnurt_shading::bsdf::ClosureBatch;
use gnurt_sl_shading::{Access, ParameterValue, Script};

use super::floor::{floor, script};

#[test]
fn errors_show_the_line() {
    let text = "surface s ()\n{\n    float a = diffus (N);\n}\n";
    let why = Script::from_text(Path::new("bad.osl"), text, &Access::default()).expect_err("it is wrong");
    for expected in ["bad.osl", "3", "diffus (N)"] {
        assert!(why.contains(expected), "{expected} is told: {why}");
    }
    let missing = Script::open(Path::new("no/such.osl"), &Access::default()).expect_err("it is missing");
    assert!(missing.contains("no/such.osl"), "{missing}");
}

#[test]
fn parameters_are_checked() {
    let mut script = script(
        "surface s (color tint = 1 [[ string label = \"Tint\", float min = 0, float max = 2 ]], float size[2] = { 1, 2 }, int n = 3,
            string file = \"\", matrix m = 1) { }",
    );
    let parameters = script.parameters();
    let names: Vec<(&str, &str)> = parameters.iter().map(|p| (&p.name[..], &p.ty[..])).collect();
    let expected =
        [("tint", "color"), ("size", "float[2]"), ("n", "int"), ("file", "string"), ("m", "matrix")];
    assert_eq!(names, expected);
    assert_eq!((&parameters[0].label[..], parameters[0].range), ("Tint", Some([0.0, 2.0])));
    for (name, text) in
        [("tint", "0.5"), ("tint", "1,2,3"), ("size", "3,4"), ("n", "7"), ("file", "@wood.png"), ("m", "2")]
    {
        script.set_text(name, text).unwrap_or_else(|why| panic!("{name}={text}: {why}"));
    }
    let values: Vec<ParameterValue> = script.parameters().into_iter().map(|p| p.default).collect();
    assert_eq!(values[0], ParameterValue::Floats(vec![1.0, 2.0, 3.0]));
    assert_eq!(values[3], ParameterValue::Texts(vec!["wood.png".into()]));
    for (name, text, messages) in [
        ("tnt", "1", "unknown parameter 'tnt'; there are tint, size, n, file, m; did you mean 'tint'?"),
        ("tint", "1,2", "'1,2' is not numbers"),
        ("tint", "red", "'red' is not numbers"),
        ("n", "1.5", "'1.5' is not whole numbers"),
        ("size", "1,2,3", "is not numbers"),
    ] {
        let why = script.set_text(name, text).expect_err("it is wrong");
        assert!(why.contains(messages), "{name}={text}: {why}");
    }
    assert!(script.light().err().expect("it is none").contains("of type surface; one of type light"));
}

#[test]
fn hostile_shaders_are_stopped() {
    for body in [
        "while (1) { }",
        "for (int i = 0; i >= 0; i = 0) { float a = noise (P); }",
        "string s = \"xxxxxxxxxxxxxxxx\"; for (int i = 0; i < 64; ++i) s = concat (s, s); printf (\"%d\", strlen (s));",
        "float a[100000]; for (int i = 0; i < 1000; ++i) a[i * 1000] = i; Ci = a[999000] * emission ();",
        "for (int i = 0; i < 5000; ++i) Ci = Ci + diffuse (N);",
        "for (int i = 0; i < 100000; ++i) printf (\"%d\", i);",
    ] {
        let script = script(&format!("surface test () {{ {body} }}"));
        let shader = script.surface().expect("a surface");
        let hits = floor(1);
        let mut out = ClosureBatch::default();
        out.reset(1);
        shader.evaluate(&hits, &mut out);
        assert!(out.emission(0).is_finite(), "{body}");
        let faults = script.faults();
        assert!(faults.len() < 20 && faults.iter().all(|line| line.len() < 500), "{body}: {faults:?}");
    }
}

#[test]
fn confined_shaders_stay_in_their_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    let inner = folder.path().join("inner");
    std::fs::create_dir(&inner).expect("a folder");
    std::fs::write(folder.path().join("secret.h"), "float secret () { return 1; }").expect("a file");
    std::fs::write(inner.join("near.h"), "float near () { return 1; }").expect("a file");
    let access = Access { confined_to: Some(inner.clone()), ..Access::default() };
    let shader = |include: &str, call: &str| {
        let path = inner.join("s.osl");
        let text = format!("#include \"{include}\"\nsurface s () {{ Ci = {call} () * emission (); }}");
        std::fs::write(&path, text).expect("a file");
        Script::open(&path, &access)
    };
    let near = shader("near.h", "near").expect("its own folder");
    assert_eq!(near.files().len(), 2, "{:?}", near.files());
    assert!(shader("../secret.h", "secret").is_err(), "not another one's");
}

#[test]
fn groups_are_layers() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write("pattern.osl", "shader pattern (float scale = 1, output float out = 0) { out = scale * P[0]; }");
    write("base.osl", "surface base (float Kd = 0.5, float more = 0) { Ci = (Kd + more) * emission (); }");
    write(
        "both.oslgroup",
        "param float scale 3 ; shader pattern.osl a ; shader base b ; connect a.out b.Kd ;",
    );
    let mut script = Script::open(&folder.path().join("both.oslgroup"), &Access::default()).expect("a group");
    script.set_text("more", "0.5").expect("the last layer's");
    let mut out = ClosureBatch::default();
    out.reset(3);
    script.surface().expect("a surface").evaluate(&floor(3), &mut out);
    assert_eq!(out.emission(2).x, 6.5, "3 * 2 + 0.5");
    assert_eq!(script.files().len(), 3, "{:?}", script.files());
    write("bad.oslgroup", "shader nothing a ;");
    let why =
        Script::open(&folder.path().join("bad.oslgroup"), &Access::default()).expect_err("it is missing");
    assert!(why.contains("shader 'nothing' is missing"), "{why}");
}
