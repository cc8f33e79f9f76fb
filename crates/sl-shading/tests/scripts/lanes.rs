// SPDX-License-Identifier: GPL-3.0-or-later
//! Points of a batch beside each other, and alone; what a surface may do once its values are known.

use gnurt_shading::Vec3s;
use gnurt_shading::bsdf::{ClosureBatch, Kind, Scattering};

use super::floor::{Probe, floor, script, surface};

fn points(body: &str) -> [Vec<Scattering>; 2] {
    let (surface, mut hits) = (surface(body), floor(21));
    // Some are seen from behind.
    (0..21).step_by(5).for_each(|i| hits.ng.set(i, -hits.ng.get(i)));
    (0..21).for_each(|i| hits.texcoord[0][i] /= 21.0);
    let mut out = ClosureBatch::default();
    out.reset(21);
    surface.evaluate(&hits, &mut out);
    let all = (0..21).map(|i| out.point(i)).collect();
    let alone = (0..21).map(|i| {
        out.reset(1);
        surface.evaluate(&hits.gather(&[i]), &mut out);
        out.point(0)
    });
    [all, alone.collect()]
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
        let [all, alone] = points(body);
        for (i, (beside, alone)) in all.iter().zip(&alone).enumerate() {
            let lobes = |point: &Scattering| {
                let all = point.bsdf.lobes().as_slice().iter().filter(|lobe| lobe.kind != Kind::None);
                format!(
                    "{:?} {} {} {:?}",
                    point.bsdf.normal(),
                    point.emission,
                    point.coverage,
                    all.collect::<Vec<_>>()
                )
            };
            assert_eq!(lobes(beside), lobes(alone), "{body}: point {i}");
        }
    }
}

#[test]
fn values_say_what_light_may_do() {
    let text = "surface s (float hole = 0, color glass = 0, float rough = 0.3, float glow = 0) {
        Ci = layer (dielectric_bsdf (N, dPdu, 1, glass, rough * rough, rough * rough, 1.5, \"ggx\"), diffuse (N));
        if (hole > 0) Ci += hole * transparent ();
        if (glow > 0) Ci += glow * emission (); }";
    let told = |values: &[(&str, &str)]| {
        let mut script = script(text);
        for (name, value) in values {
            script.set_text(name, value).unwrap_or_else(|why| panic!("{why}"));
        }
        let surface = script.surface().expect("a surface");
        [surface.is_opaque(), surface.is_solid(), surface.emits()]
    };
    assert_eq!(told(&[]), [true, true, false], "plastic");
    assert_eq!(told(&[("glass", "1")]), [true, true, false], "dull glass");
    assert_eq!(told(&[("glass", "1"), ("rough", "0")]), [false, true, false], "clear glass");
    assert_eq!(told(&[("rough", "0")]), [true, true, false], "a mirror");
    assert_eq!(told(&[("hole", "0.5"), ("glow", "1")]), [false, false, true], "holes, light");
    let mut principled = script(include_str!("../../../../shaders/surfaces/principled.osl"));
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
