// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of a batch in lanes and singly; properties of surfaces with known values.

use std::path::Path;

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Kind, Scattering};
use gnurt_shading::{SurfaceBatch, Vec3s};
use gnurt_sl_shading::{Access, Codes, Script};

use super::floor::{Probe, floor, script, surface};

const PRINCIPLED: &str = include_str!("../../../../shaders/surfaces/principled.osl");

/// Points of which some are seen from behind.
fn both_sides() -> SurfaceBatch {
    let mut hits = floor(21);
    (0..21).step_by(5).for_each(|i| hits.ng.set(i, -hits.ng.get(i)));
    (0..21).for_each(|i| hits.texcoord[0][i] /= 21.0);
    hits
}

fn points(body: &str) -> [Vec<Scattering>; 2] {
    let (surface, hits) = (surface(body), both_sides());
    let mut out = ClosureBatch::default();
    out.reset(21);
    surface.evaluate(&hits, &mut out);
    let all = (0..21).map(|i| out.point(i)).collect();
    let single = (0..21).map(|i| {
        out.reset(1);
        surface.evaluate(&hits.gather(&[i]), &mut out);
        out.point(0)
    });
    [all, single.collect()]
}

/// All that a point does to light; places that only other points need are empty.
fn reported(point: &Scattering) -> String {
    let all = point.bsdf.lobes().as_slice().iter().filter(|lobe| lobe.kind != Kind::None);
    let lobes: Vec<_> = all.collect();
    format!("{:?} {} {} {} {lobes:?}", point.bsdf.normal(), point.emission, point.coverage, point.passing)
}

#[test]
fn points_beside_others_are_as_they_are_alone() {
    for body in [
        "Ci = u * diffuse (N);",
        // Lists of different lengths, of other closures, layers of them.
        "closure color c = 0; for (int i = 0; i < u * 5; ++i) c += u * oren_nayar (N, 0.2 * i); if (u > 0.5) c = 0.5 * layer (sheen_bsdf (N, color (u), 0.5), c); Ci = c + (1 - u) * reflection (N);",
        "float a = u > 0.3 ? 0.2 : 0; Ci = layer (dielectric_bsdf (N, dPdu, 1, a, a, a, 1.4, \"ggx\"), color (u, 0.5, 0) * diffuse (N)) + u * generalized_schlick_bsdf (N, dPdu, 1, u > 0.6 ? 0.5 : 0, 0.2, 0.1, color (u), 1, 5, \"ggx\");",
        // Glass from both sides, normals of their own, light, holes.
        "Ci = dielectric_bsdf (N, dPdu, 1, 1, 0.2, 0.2, 1.4, \"ggx\") + u * diffuse (normalize (N + vector (u, 0, 0)));",
        "if (u > 0.2) Ci = u * emission (); Ci += u * transparent () + layer (diffuse (N) + 0.5 * transparent (), color (1, u, 0) * uniform_edf (color (u)) + 0.5 * transparent ());",
        "for (int i = 0; i < 12 * u; ++i) Ci = Ci + 0.1 * diffuse (normalize (N + vector (i, 0, 0)));",
    ] {
        let [all, single] = points(body);
        for (i, (in_batch, single)) in all.iter().zip(&single).enumerate() {
            assert_eq!(reported(in_batch), reported(single), "{body}: point {i}");
        }
    }
}

#[test]
fn values_say_what_light_may_do() {
    let text = "surface s (float hole = 0, color glass = 0, float rough = 0.3, float glow = 0) {
        Ci = layer (dielectric_bsdf (N, dPdu, 1, glass, rough * rough, rough * rough, 1.5, \"ggx\"), diffuse (N));
        if (hole > 0) Ci += hole * transparent ();
        if (glow > 0) Ci += glow * emission (); }";
    let reported = |values: &[(&str, &str)]| {
        let mut script = script(text);
        for (name, value) in values {
            script.set_text(name, value).unwrap_or_else(|why| panic!("{why}"));
        }
        let surface = script.surface().expect("a surface");
        [surface.is_opaque(), surface.is_solid(), surface.emits()]
    };
    assert_eq!(reported(&[]), [true, true, false], "plastic");
    assert_eq!(reported(&[("glass", "1")]), [true, true, false], "dull glass");
    assert_eq!(reported(&[("glass", "1"), ("rough", "0")]), [false, true, false], "clear glass");
    assert_eq!(reported(&[("rough", "0")]), [true, true, false], "a mirror");
    assert_eq!(reported(&[("hole", "0.5"), ("glow", "1")]), [false, false, true], "holes, light");
    let mut principled = script(PRINCIPLED);
    assert!(principled.surface().expect("a surface").is_opaque(), "plastic with widths that are worked out");
    principled.set_text("transmission", "1").expect("a parameter");
    assert!(principled.surface().expect("a surface").is_opaque(), "dull glass");
    principled.set_text("roughness", "0").expect("a parameter");
    assert!(!principled.surface().expect("a surface").is_opaque(), "clear glass");
    let clear = surface("float rough = u; Ci = dielectric_bsdf (N, dPdu, 1, 1, rough, rough, 1.5, \"ggx\");");
    assert!(!clear.is_opaque(), "glass that is clear where u is 0");
    let mut through = Vec3s::splat(2, glam::Vec3::ZERO);
    clear.transmit(&mut Probe(1.0), &floor(2), &mut through);
    assert!(through.get(0).x > 0.5 && through.get(1).x == 0.0, "there alone: {through:?}");
}

/// A script that keeps its code for itself.
fn separate(text: &str) -> (Script, Codes) {
    let codes = Codes::separate();
    let access = Access { codes: codes.clone(), ..Access::default() };
    (Script::from_text(Path::new("apart.osl"), text, &access).unwrap_or_else(|why| panic!("{why}")), codes)
}

#[test]
fn lobes_that_are_the_same_everywhere_are_those_of_each_point() {
    let mut hits = both_sides();
    // A bump that leans over, one that does not, and a ray that grazes.
    hits.bent = hits.ns.clone();
    hits.bent.set(3, Vec3::new(0.9, -0.1, 0.0).normalize());
    hits.bent.set(7, Vec3::new(0.5, 1.0, 0.2).normalize());
    hits.ray_dir.set(9, Vec3::new(1.0, -1e-3, 0.0).normalize());
    let coat = "base=.6,.1,.08:roughness=.4:coat=1:coat_roughness=.1:sheen=.1,.1,.2:sheen_roughness=.5";
    let glass = "base=.7,.9,.8:roughness=.2:transmission=.7:metallic=.2:coat=.5";
    const LIGHT: &str = "surface lamp (float glow = 5, color c = color (1, 0.5, 0.2), float hole = 0.3, float tint = 0.2) {
        Ci = glow * c * emission () + hole * transparent () + tint * transparent ();
        if (hole < 0.4) Ci = layer (sheen_bsdf (N, color (0.5), 0.4), Ci + glow * uniform_edf (c)) + (1 - hole) * diffuse (N); }";
    const SIDED: &str = "surface sided (float glow = 5, float cone = -2) {
        if (backfacing ()) Ci = 0.25 * transparent () + 0.25 * diffuse (N);
        else {
            vector d = normalize (-I);
            float share = 1;
            if (cone > -1.0) share = d[2];
            Ci = glow * share * emission () + 0.5 * transparent (); } }";
    for (text, values) in [
        (PRINCIPLED, coat),
        (PRINCIPLED, glass),
        (PRINCIPLED, "base=.5,.5,.5:roughness=.6"),
        (PRINCIPLED, "metallic=1"),
        (PRINCIPLED, "roughness=0:transmission=1"),
        (LIGHT, ""),
        (LIGHT, "hole=0"),
        (LIGHT, "hole=0.6"),
        (LIGHT, "glow=0:tint=0"),
        (LIGHT, "hole=1:glow=0:tint=0"),
        (SIDED, ""),
        (SIDED, "glow=2"),
    ] {
        let (mut fixed, codes) = separate(text);
        for (name, value) in values.split(':').filter_map(|value| value.split_once('=')) {
            fixed.set_text(name, value).unwrap_or_else(|why| panic!("{why}"));
        }
        // The same of numbers that may change: it is run at the points.
        let mut run = fixed.clone();
        run.make_tunable();
        let all = |script: &Script| {
            let surface = script.surface().expect("a surface");
            let mut out = ClosureBatch::default();
            out.reset(21);
            surface.evaluate(&hits, &mut out);
            let mut more = [(); 3].map(|()| Vec3s::splat(21, Vec3::ZERO));
            surface.transmit(&mut Probe(1.0), &hits, &mut more[0]);
            surface.gaps(&mut Probe(1.0), &hits, &mut more[1]);
            surface.albedo(&hits, &mut more[2]);
            let lights = |i: usize| more.each_ref().map(|list| list.get(i));
            (0..21).map(|i| (reported(&out.point(i)), lights(i))).collect::<Vec<_>>()
        };
        let found = all(&fixed);
        assert_eq!(codes.count(), 0, "{values}: nobody runs it");
        for (i, (found, expected)) in found.iter().zip(&all(&run)).enumerate() {
            assert_eq!(found, expected, "{values}: point {i}");
        }
        assert_eq!(codes.count(), 1, "{values}: numbers that change are run");
    }
}

#[test]
fn what_differs_from_point_to_point_is_run() {
    let is_run = |body: &str| {
        let (script, codes) = separate(&format!("surface test () {{ {body} }}"));
        script.surface().expect("a surface");
        codes.count() == 1
    };
    for body in [
        "Ci = diffuse (N);",
        "float sum = 0; for (int i = 0; i < 3; ++i) sum += noise (i * 0.3); Ci = sum * oren_nayar (N, sum);",
        "float a[3] = {0.1, 0.2, 0.3}; if (a[1] < 0.5) Ci = layer (sheen_bsdf (N, color (a[2]), 0.5), diffuse (N));",
        "float w = 0.2; Ci = dielectric_bsdf (N, dPdu, 1, 1, w, w, 1.5, \"ggx\"); float unused = u * 2;",
        "Ci = diffuse (N) + emission ();",
        "Ci = 0.5 * transparent () + 0.5 * uniform_edf (color (0, 1, 2));",
        "if (backfacing ()) Ci = emission ();",
        "Ci = color (0.5, 0.6, 0.7) * transparent () + diffuse (N);",
    ] {
        assert!(!is_run(body), "the same everywhere: {body}");
    }
    for body in [
        "Ci = u * diffuse (N);",
        "if (u > 0.5) Ci = diffuse (N);",
        "float k = 1; for (int i = 0; i < u * 3; ++i) k *= 0.5; Ci = k * diffuse (N);",
        "Ci = diffuse (normalize (N + vector (u, 0, 0)));",
        "Ci = diffuse (normal (0, 1, 0));",
        "N = normalize (N + vector (u, 0, 0)); Ci = diffuse (N);",
        "Ci = dielectric_bsdf (N, dPdu, 1, 1, 0.2, 0.3, 1.5, \"ggx\");",
        "Ci = oren_nayar (N, P[1]);",
        "float a[3] = {0.1, 0.2, 0.3}; Ci = a[(int) u] * diffuse (N);",
        "Ci = (raytype (\"camera\") + backfacing ()) * diffuse (N);",
        "point p = point (\"object\", 0, 0, 0); Ci = p[0] * diffuse (N);",
        "color c = 0; getattribute (\"Cd\", c); Ci = c * diffuse (N);",
        "printf (\"%g\", 1.0); Ci = diffuse (N);",
        "Ci = diffuse (N) + u * emission ();",
        "if (backfacing ()) Ci = u * emission ();",
        "Ci = uniform_edf (color (u)) + transparent ();",
        "Ci = trace (P, N) * diffuse (N);",
        "Ci = subsurface (1, 0, 1, 1);",
    ] {
        assert!(is_run(body), "not the same everywhere: {body}");
    }
}

#[test]
fn what_means_the_same_is_compiled_once() {
    let codes = Codes::separate();
    let access = Access { codes: codes.clone(), ..Access::default() };
    let text = "surface s (float scale = 2) { Ci = scale * u * diffuse (N); }";
    let made = |text: &str, scale: &str| {
        let mut script = Script::from_text(Path::new("s.osl"), text, &access).expect("it compiles");
        if !scale.is_empty() {
            script.set_text("scale", scale).expect("a parameter");
        }
        script.surface().expect("a surface");
        codes.count()
    };
    assert_eq!(made(text, ""), 1, "the first one");
    assert_eq!(made(text, ""), 1, "another material of the same text");
    assert_eq!(made(text, "2"), 1, "the same value, given");
    assert_eq!(made(text, "3"), 2, "another value");
    assert_eq!(made(&text.replace("u *", "v *"), "3"), 3, "another text");
    let light = "light l () { L = Ps - P; Cl = xi[0]; }";
    for _ in 0..2 {
        let light = Script::from_text(Path::new("l.osl"), light, &access).expect("it compiles");
        light.light().expect("a light");
        assert_eq!(codes.count(), 4, "lights, too");
    }
}

#[test]
fn points_are_in_the_space_of_their_own_instance() {
    let surface = surface("point q = transform (\"object\", P); Ci = (0.1 + abs (q[0])) * diffuse (N);");
    let mut hits = both_sides();
    // A matrix's columns, then where it puts the origin: 10 further along x for each instance.
    let matrix = |leaf: u32| [1, 0, 0, 0, 1, 0, 0, 0, 1, 10 * leaf, 0, 0].map(|x| x as f32);
    for leaf_of in [|i: u32| i / 8, |_| 3] {
        hits.leaf_id = (0..21).map(leaf_of).collect();
        let values = (0..12 * 21).map(|n| matrix(hits.leaf_id[n % 21])[n / 21]);
        hits.attributes = vec![values.collect()];
        // At first by the interpreter, then by code.
        for _ in 0..12 {
            let mut out = ClosureBatch::default();
            out.reset(21);
            surface.evaluate(&hits, &mut out);
            for i in 0..21 {
                let x = hits.p.get(i).x - 10.0 * hits.leaf_id[i] as f32;
                let weight = out.point(i).bsdf.lobes().as_slice()[0].weight.x;
                assert!((weight - 0.1 - x.abs()).abs() < 1e-4, "point {i}: {weight}, {x}");
            }
            std::thread::sleep(std::time::Duration::from_millis(3));
        }
    }
}
