// SPDX-License-Identifier: GPL-3.0-or-later
//! Displacement shaders: changes of `P`, calls of `displace`, outputs of surfaces, groups.

use std::path::Path;

use glam::Vec3;
use gnurt_shading::{AttributeRequest, DisplacementShader, Vec3s};
use gnurt_sl_shading::{Access, Codes, Kind, Script};

use crate::floor::{floor, script};
use crate::kinds::emitted;

/// Offsets of forty points of the floor. Their normal is y; rays go against it when vertices are displaced.
pub(crate) fn offsets(script: &Script) -> Vec<[f32; 3]> {
    let shader = script.displacement().expect("not too large").expect("a displacement");
    let interpreted = offsets_by(&*shader);
    // Machine code takes over, with the same values.
    Codes::default().wait();
    assert_eq!(offsets_by(&*shader), interpreted, "machine code");
    interpreted
}

fn offsets_by(shader: &dyn DisplacementShader) -> Vec<[f32; 3]> {
    let mut points = floor(40);
    points.ray_dir = Vec3s::splat(40, -Vec3::Y);
    (points.footprint, points.cone_spread) = (vec![0.0; 40], vec![0.0; 40]);
    let value = |request: &AttributeRequest| match request.name == AttributeRequest::WORLD_FROM_OBJECT {
        true => (0..12).flat_map(|k| [if matches!(k, 0 | 4 | 8) { 1.0 } else { 0.0 }; 40]).collect(),
        false => (0..40 * request.components).map(|i| if i < 40 { i as f32 } else { 0.0 }).collect(),
    };
    points.attributes = shader.attributes().iter().map(value).collect();
    let mut out = Vec3s::default();
    out.reset(40, Vec3::ZERO);
    shader.displace(&points, &mut out);
    assert_eq!(shader.faults(), Vec::<String>::new());
    (0..40).map(|i| out.get(i).to_array()).collect()
}

#[track_caller]
fn check(text: &str, expected: impl Fn(f32) -> [f32; 3]) {
    for (i, found) in offsets(&script(text)).into_iter().enumerate() {
        let expected = expected(i as f32);
        let near = (0..3).all(|k| (found[k] - expected[k]).abs() <= 1e-5 * (1.0 + expected[k].abs()));
        assert!(near, "{text}\npoint {i}: {found:?} instead of {expected:?}");
    }
}

#[test]
fn points_move_as_the_text_says() {
    check("displacement d (float a = 2) { P += a * sin (P[0]) * N; }", |x| [0.0, 2.0 * x.sin(), 0.0]);
    check("displacement d () { displace (u); }", |x| [0.0, x, 0.0]);
    check("displacement d () { displace (vector (1, u, 3)); }", |x| [1.0, x, 3.0]);
    check("displacement d () { displace (0.5); displace (0.25); N = calculatenormal (P); }", |_| {
        [0.0, 0.75, 0.0]
    });
    check("displacement d () { if (u > 3) displace (1); else P = P - vector (0, 0, 2); }", |x| {
        if x > 3.0 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, -2.0] }
    });
    check("displacement d () { for (int i = 0; i < 3; ++i) displace (\"object\", u); }", |x| {
        [0.0, 3.0 * x, 0.0]
    });
    check("void up (float by) { displace (by); } displacement d () { up (2 * u); }", |x| [0.0, 2.0 * x, 0.0]);
    check("displacement d () { bump (3); }", |_| [0.0; 3]);
    check("displacement d () { if (u > 3) P = point (1, 2, 3); }", |x| {
        if x > 3.0 { [1.0 - x, 2.0, 3.0] } else { [0.0; 3] }
    });
    check("displacement d () { displace (raytype (\"displacement\") - raytype (\"camera\")); }", |_| {
        [0.0, 1.0, 0.0]
    });
    check("displacement d (float h = 0 [[int lockgeom = 0]]) { displace (h); }", |x| [0.0, x, 0.0]);
    // A length in another space is longer here if that is larger.
    check(
        "displacement d () { matrix m = matrix (1,0,0,0, 0,4,0,0, 0,0,1,0, 0,0,0,1);
        vector there = transform (m, vector (N)); P += N * (2 / length (there)); }",
        |_| [0.0, 0.5, 0.0],
    );
}

#[test]
fn surfaces_may_have_offsets() {
    let text =
        "surface s (output vector displacement = 0) { displacement = vector (u, 2, 0); Ci = diffuse (N); }";
    check(text, |x| [x, 2.0, 0.0]);
    assert!(script(text).surface().is_ok(), "and are surfaces");
    let alone = "shader s (output vector displacement = 0) { displacement = vector (0, u, 0); }";
    check(alone, |x| [0.0, x, 0.0]);
    assert_eq!(script(alone).kind(), Kind::Displacement, "without a closure it is nothing else");
    let none = script("surface s (output float displacement = 0) { Ci = diffuse (N); }");
    assert!(none.displacement().expect("sound").is_none(), "no vector");
    let plain = script("surface s () { Ci = diffuse (N); }");
    assert!(plain.displacement().expect("sound").is_none(), "without one");
    let moved = script("displacement d () { P += N; }");
    assert_eq!((moved.kind(), moved.warnings()), (Kind::Displacement, &[][..]));
    let why = moved.surface().err().expect("no surface");
    assert!(why.contains("of type displacement"), "{why}");
}

#[test]
fn surfaces_may_displace() {
    check("surface s (float a = 2) { displace (a * u); Ci = diffuse (N); }", |x| [0.0, 2.0 * x, 0.0]);
    check("surface s () { if (u > 3) displace (vector (1, 0, u)); Ci = diffuse (N); }", |x| {
        if x > 3.0 { [1.0, 0.0, x] } else { [0.0; 3] }
    });
    // What a surface assigns to is its own.
    check(
        "surface s (float h = P[0] + 1) { P = 7 * P; N = normal (1, 0, 0); displace (vector (0, h, P[0])); P = 0; Ci = diffuse (N); }",
        |x| [0.0, x + 1.0, 7.0 * x],
    );
    check("surface s () { if (raytype (\"displacement\")) displace (0.5); Ci = emission (); }", |_| {
        [0.0, 0.5, 0.0]
    });
    let plain = script("surface s () { P += N; Ci = diffuse (N); }");
    assert!(
        plain.displacement().expect("sound").is_none(),
        "assignments displace in displacement shaders only"
    );
}

/// The files of a group.
fn group(files: &[(&str, &str)], text: &str) -> Script {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    let script = Script::from_text(&folder.path().join("all.oslgroup"), text, &Access::default());
    script.unwrap_or_else(|why| panic!("{why}"))
}

#[test]
fn surfaces_of_displaced_layers_do_not_move_again() {
    let files = [
        ("up.osl", "displacement up (output float h = 0) { h = P[0]; P += h * N; N = normal (1, 0, 0); }"),
        (
            "look.osl",
            "surface look (float h = 0) { displace (h); Ci = color (h, P[1], N[1]) * emission (); P = 0; }",
        ),
    ];
    let script = group(&files, "shader up a ; shader look b ; connect a.h b.h ;");
    assert_eq!(script.kind(), Kind::Surface);
    for (i, offset) in offsets(&script).into_iter().enumerate() {
        assert_eq!(offset, [i as f32, i as f32, 0.0], "point {i}: up, then along the normal of the first");
    }
    let surface = script.surface().expect("a surface");
    for (i, light) in emitted(&*surface, &floor(40)).into_iter().enumerate() {
        assert_eq!(light, Vec3::new(i as f32, 0.0, 1.0), "point {i}: where and as it is given");
    }
    let none = group(&files[..1], "shader up a ; shader up b ;");
    assert_eq!(none.kind(), Kind::Displacement);
}

#[test]
fn layers_move_one_after_the_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
    write("noise.osl", "shader noise (float k = 1, output float h = 0) { h = k * u; }");
    write("up.osl", "displacement up (float by = 0) { displace (by); }");
    write("aside.osl", "displacement aside () { P[0] += P[1]; }");
    let group = "param float k 3 ; shader noise a ; shader up b ; connect a.h b.by ; shader aside c ;";
    let script = Script::from_text(&folder.path().join("all.oslgroup"), group, &Access::default());
    let found = offsets(&script.unwrap_or_else(|why| panic!("{why}")));
    for (i, offset) in found.into_iter().enumerate() {
        let x = 3.0 * i as f32;
        assert_eq!(offset, [x, x, 0.0], "point {i}: up, then aside by the height");
    }
    let text = std::fs::read_to_string(folder.path().join("up.osl")).expect("a file");
    assert!(Script::from_text(Path::new("up.osl"), &text, &Access::default()).is_ok());
}
