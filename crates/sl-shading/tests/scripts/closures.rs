// SPDX-License-Identifier: GPL-3.0-or-later
//! The rendering of each closure.

use glam::Vec3;
use gnurt_shading::bsdf::{BetweenFacets, ClosureBatch, Film, Kind, Scattering};

use super::floor::{floor, script, surface};

fn point(body: &str) -> Scattering {
    let hits = floor(1);
    let mut out = ClosureBatch::default();
    out.reset(1);
    surface(body).evaluate(&hits, &mut out);
    out.point(0)
}

fn toward() -> Vec3 {
    Vec3::new(0.0, 1.0, 1.0).normalize()
}

#[test]
fn each_closure_has_its_lobe() {
    let zero = "vector (0)";
    for (closure, kind) in [
        ("diffuse (N)", Kind::Diffuse),
        ("oren_nayar (N, 0.5)", Kind::Diffuse),
        ("oren_nayar_diffuse_bsdf (N, color (0.5), 0.3)", Kind::Diffuse),
        ("burley_diffuse_bsdf (N, color (0.5), 0.8)", Kind::Diffuse),
        ("subsurface (1.3, 0, color (1), color (0.5))", Kind::Diffuse),
        ("subsurface_bssrdf (N, color (0.5), color (1), 0)", Kind::Diffuse),
        ("phong (N, 100)", Kind::Phong),
        ("ward (N, dPdu, 0.2, 0.3)", Kind::Ward),
        ("microfacet (\"ggx\", N, 0.3, 1.5, 0)", Kind::Glass),
        ("microfacet (\"ggx\", N, 0.3, 0, 0)", Kind::Microfacets),
        ("microfacet (\"beckmann\", N, dPdu, 0.3, 0.2, 0, 0)", Kind::Beckmann),
        ("microfacet (concat (\"default\", \"\"), N, 0.3, 1.5, 2)", Kind::Beckmann),
        ("microfacet (\"beckmann\", N, 0, 1.5, 2)", Kind::SmoothGlass),
        ("microfacet (\"ggx\", N, 0.3, 1.5, 2)", Kind::Glass),
        ("reflection (N)", Kind::Mirror),
        ("reflection (N, 1.5)", Kind::SmoothGlass),
        ("refraction (N, 1.5)", Kind::SmoothGlass),
        (
            &format!("dielectric_bsdf (N, {zero}, color (1), color (1), 0, 0, 1.5, \"ggx\")"),
            Kind::SmoothGlass,
        ),
        (&format!("dielectric_bsdf (N, {zero}, color (1), color (1), 0.2, 0.2, 1.5, \"ggx\")"), Kind::Glass),
        (
            &format!(
                "dielectric_bsdf (N, {zero}, color (1), color (1), 0, 0, 1.5, \"ggx\", \"thin_walled\", 1)"
            ),
            Kind::SmoothPane,
        ),
        (
            &format!(
                "dielectric_bsdf (N, {zero}, color (0), color (1), 0.2, 0.2, 1.5, \"ggx\", \"thin_walled\", 1)"
            ),
            Kind::Pane,
        ),
        (
            &format!("dielectric_bsdf (N, {zero}, color (1), color (0), 0.2, 0.2, 1.5, \"ggx\")"),
            Kind::Microfacets,
        ),
        (&format!("conductor_bsdf (N, {zero}, 0.2, 0.2, color (0.2), color (3), \"ggx\")"), Kind::Metal),
        (
            &format!(
                "generalized_schlick_bsdf (N, {zero}, color (1), color (0), 0.2, 0.2, color (0.1), color (1), 5, \"ggx\")"
            ),
            Kind::Microfacets,
        ),
        ("sheen_bsdf (N, color (0.5), 0.4)", Kind::Sheen),
        ("sheen_bsdf (N, color (0.5), 0.4, \"mode\", 0)", Kind::Sheen),
        ("sheen_bsdf (N, color (0.5), 0.4, \"mode\", 1)", Kind::Fibres),
        ("diffuse_toon (N, 0.5, 0.1)", Kind::Toon),
        ("glossy_toon (N, 0.5, 0.1)", Kind::GlossyToon),
        ("hair_reflection (N, 0.2, 0.5, dPdu, 0)", Kind::Strand),
        ("hair_transmission (N, 0.2, 0.5, dPdu, 0)", Kind::Strand),
    ] {
        let found = point(&format!("Ci = {closure};"));
        let kinds: Vec<Kind> = found.bsdf.lobes().as_slice().iter().map(|lobe| lobe.kind).collect();
        assert_eq!(kinds, [kind], "{closure}");
        let albedo = found.bsdf.albedo(toward());
        let fine = albedo.max_element() <= 1.001 && albedo.min_element() > 0.0;
        assert!(fine, "{closure} scatters some of the light, and no more: {albedo}");
        assert_eq!((found.emission, found.coverage), (Vec3::ZERO, 1.0), "{closure} does nothing else");
    }
    let hair = point(
        "Ci = huang_hair_bsdf (N, dPdu, vector (0), color (1), color (0.5), color (1), color (1), 1.55, 0.3, 0.8, 0.03, 0.5, color (0));",
    );
    let kinds: Vec<Kind> = hair.bsdf.lobes().as_slice().iter().map(|lobe| lobe.kind).collect();
    assert_eq!(kinds, [Kind::RoughFibre; 4], "a lobe for each term");
    let albedo = hair.bsdf.albedo(toward());
    assert!(albedo.max_element() <= 1.001 && albedo.min_element() > 0.3, "hair scatters light: {albedo}");
    for closure in ["translucent (N)", "translucent_bsdf (N, color (0.5))"] {
        let found = point(&format!("Ci = {closure};"));
        let albedo = found.bsdf.albedo(toward());
        assert!(found.bsdf.is_translucent() && albedo.x > 0.49 && albedo.x <= 1.001, "{closure}: {albedo}");
        assert_eq!(found.bsdf.eval(toward(), Vec3::Y), Vec3::ZERO, "{closure} sends nothing back");
    }
    for closure in ["debug (\"x\")", "holdout ()"] {
        assert!(point(&format!("Ci = {closure};")).bsdf.is_black(), "{closure}");
    }
}

#[test]
fn volume_closures_are_what_lies_behind() {
    let glass = "dielectric_bsdf (N, vector (0), color (1), color (1), 0, 0, 1.5, \"ggx\")";
    let absorbing = Vec3::new(0.5, 1.0, 0.25);
    for (closure, absorption, scattering) in [
        (format!("{glass} + anisotropic_vdf (color (0), color (0.5, 1, 0.25), 0.3)"), absorbing, Vec3::ZERO),
        (format!("layer ({glass}, anisotropic_vdf (color (0.5), color (2), 0.3))"), Vec3::ONE, Vec3::ONE),
        (
            format!("0.5 * medium_vdf (color (0.25), 2, color (exp (-4)), 0.3, 1.5, 0) + {glass}"),
            Vec3::splat(0.75),
            Vec3::splat(0.25),
        ),
        (format!("medium_vdf (color (0), 1, color (0), 0.3, 1.5, 0) + {glass}"), Vec3::ZERO, Vec3::ZERO),
    ] {
        // Layers without a medium change nothing.
        let others = " + layer (translucent (N), emission ())";
        for varying in ["1", "(u < 7 ? 1 : 2)"] {
            let made = surface(&format!("Ci = {varying} * ({closure}{others});"));
            let mut out = ClosureBatch::default();
            out.reset(1);
            made.evaluate(&floor(1), &mut out);
            let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-5;
            assert!(made.has_medium() && near(out.medium(0).on(false), absorption), "{closure}");
            assert_eq!(out.medium(0).on(true), Vec3::ZERO, "only beyond the front: {closure}");
            match (made.interior(), varying) {
                (Some(interior), "1") => {
                    assert!(near(interior.scattering, scattering) && interior.anisotropy == 0.3, "{closure}");
                }
                (None, varying) => assert_ne!(varying, "1", "{closure}"),
                (Some(_), _) => panic!("a medium that varies is not one medium: {closure}"),
            }
        }
    }
    assert!(!surface(&format!("Ci = {glass};")).has_medium(), "nothing behind");
}

#[test]
fn facets_are_as_wide_as_shaders_say() {
    let only = |closure: &str| {
        let found = point(&format!("Ci = {closure};"));
        let &[lobe] = found.bsdf.lobes().as_slice() else { panic!("{closure}: one lobe") };
        lobe
    };
    let schlick = "color (1), color (0), 0.3, 0.1, color (0.1), color (1), 5, \"ggx\"";
    for closure in [
        "microfacet (\"ggx\", N, vector (1, 0, 0), 0.3, 0.1, 1.5, 0)",
        "microfacet (\"ggx\", N, vector (1, 0, 0), 0.3, 0.1, 1.5, 2)",
        "ward (N, vector (1, 0, 0), 0.3, 0.1)",
        "dielectric_bsdf (N, vector (1, 0, 0), color (1), color (1), 0.3, 0.1, 1.5, \"ggx\")",
        "conductor_bsdf (N, vector (1, 0, 0), 0.3, 0.1, color (0.2), color (3), \"ggx\")",
        &format!("generalized_schlick_bsdf (N, vector (1, 0, 0), {schlick})"),
    ] {
        let lobe = only(closure);
        assert_eq!((lobe.alpha, lobe.across, lobe.tangent), (0.3, 0.1, Vec3::X), "{closure}");
    }
    let even = only("microfacet (\"ggx\", N, 0.2, 1.5, 0)");
    assert_eq!((even.alpha, even.across), (0.2, 0.0), "alike in all directions");
    let film = "\"thinfilm_thickness\", 320, \"thinfilm_ior\", 1.4";
    for closure in [
        format!("dielectric_bsdf (N, vector (0), color (1), color (1), 0, 0, 1.5, \"ggx\", {film})"),
        format!("conductor_bsdf (N, vector (0), 0.2, 0.2, color (0.2), color (3), \"ggx\", {film})"),
        format!("generalized_schlick_bsdf (N, vector (1, 0, 0), {schlick}, {film})"),
    ] {
        let Film { share, ior, thickness } = only(&closure).film;
        assert_eq!([share, ior, thickness], [1.0, 1.4, 320.0], "{closure}");
    }
}

/// The fate of light between microfacets is a keyword, 0 unless it is given.
#[test]
fn light_between_facets_has_a_keyword() {
    let only = |closure: &str| point(&format!("Ci = {closure};")).bsdf.lobes().as_slice()[0];
    for closure in [
        "generalized_schlick_bsdf (N, vector (0), color (1), color (0), 0.5, 0.5, color (0.4), color (1), 5, \"ggx\"",
        "conductor_bsdf (N, vector (0), 0.5, 0.5, color (0.2), color (3), \"ggx\"",
    ] {
        let plain = only(&format!("{closure})"));
        use BetweenFacets::{Lost, Scaled, Seen, Spread};
        for (number, light) in [Spread, Scaled, Lost, Seen].into_iter().enumerate() {
            let given = only(&format!("{closure}, \"multiscatter\", {number})"));
            assert_eq!(given, plain.between_facets(light), "{closure} {light:?}");
        }
        assert_ne!(plain.between_facets(BetweenFacets::Scaled), plain, "{closure}");
    }
}

#[test]
fn sums_weights_and_layers() {
    let sum =
        point("Ci = color (0.1, 0.2, 0.3) * diffuse (N) + 0.5 * (diffuse (N) * 0.5 + 2 * emission ());");
    let lambertian = sum.bsdf.albedo(toward());
    assert!((lambertian - Vec3::new(0.35, 0.45, 0.55)).length() < 1e-5, "weights multiply: {lambertian}");
    assert_eq!(sum.emission, Vec3::ONE, "light that is given off");
    let coat = "dielectric_bsdf (N, vector (0), color (1), color (0), 0.1, 0.1, 1.5, \"ggx\")";
    let layered = point(&format!("Ci = layer ({coat}, diffuse (N));"));
    let single = point(&format!("Ci = {coat} + diffuse (N);"));
    let [layered, single] = [layered, single].map(|point| point.bsdf.albedo(toward()).x);
    assert!(
        layered <= 1.0 + 1e-3 && layered > 0.95,
        "a coat takes what it sends back from the body: {layered}"
    );
    assert!(single > 1.02, "a sum does not: {single}");
    let tilted = point("Ci = diffuse (N) + 0.1 * diffuse (normalize (N + vector (1, 0, 0)));");
    let [main, other] = tilted.bsdf.lobes().as_slice() else { panic!("two lobes") };
    assert_eq!(main.normal, Vec3::ZERO, "the heavier one lies around the point's normal");
    assert!(other.normal.x > 0.5, "the other around its own: {}", other.normal);
    assert_eq!(tilted.bsdf.normal(), Vec3::Y);
}

#[test]
fn light_goes_straight_through() {
    let open = point("Ci = transparent ();");
    assert_eq!(open.coverage, 0.0, "nothing is there");
    let lamp = point("Ci = color (1, 2, 3) * emission () + transparent ();");
    assert_eq!(
        (lamp.emission, lamp.coverage),
        (Vec3::new(1.0, 2.0, 3.0), 0.0),
        "it shines, and stops nothing"
    );
    let half = point("Ci = 0.5 * transparent () + 0.5 * diffuse (N);");
    assert_eq!(half.coverage, 0.5);
    let albedo = half.bsdf.albedo(toward()).x * half.coverage;
    assert!((albedo - 0.5).abs() < 1e-5, "what is there scatters as much as the sum says: {albedo}");
    let red = point("Ci = color (0.75, 0.25, 0.25) * transparent ();");
    assert_eq!((red.coverage, red.passing), (0.0, Vec3::new(0.75, 0.25, 0.25)), "no path ends there");
    assert!(red.bsdf.lobes().as_slice().is_empty(), "nothing scatters");
    let black = point("Ci = 0 * transparent ();");
    assert_eq!((black.coverage, black.passing), (1.0, Vec3::ONE), "all paths end");
    for (through, scattered, coverage) in [
        ([0.5, 0.25, 0.0], 0.5, 0.75),
        ([1.0, 0.5, 1.0], 0.1, 1.0 / 6.0),
        ([1.0, 0.95, 1.0], 0.01, 1.0 / 16.0),
    ] {
        let [r, g, b] = through;
        let veil =
            point(&format!("Ci = color ({r}, {g}, {b}) * transparent () + {scattered} * diffuse (N);"));
        assert!((veil.coverage - coverage).abs() < 1e-6, "as many paths as light: {}", veil.coverage);
        let passing = veil.passing * (1.0 - veil.coverage);
        assert!((passing - Vec3::from(through)).length() < 1e-6, "{through:?}: {passing}");
        let found = veil.bsdf.albedo(toward()).x * veil.coverage;
        assert!((found - scattered).abs() < 1e-4, "what is there scatters as much as the sum says: {found}");
    }
}

#[test]
fn numbers_that_are_none_do_no_harm() {
    for body in [
        "Ci = (0.0 / u) * diffuse (N);",
        "Ci = diffuse (normal (0));",
        "Ci = diffuse (normal (1e38) * 1e38);",
        "Ci = exp (1000.0) * emission ();",
        "Ci = (-1) * diffuse (N);",
        "Ci = microfacet (\"ggx\", N, dPdu, -1, 1e30, -2, 2);",
        "Ci = dielectric_bsdf (N, vector (0), color (1e30), color (-1), 7, -7, 0, \"\");",
        "Ci = conductor_bsdf (-N, vector (0), 0, 0, color (0), color (-1), \"\");",
        "closure color c = diffuse (N); for (int i = 0; i < 40; ++i) c = layer (c, c); Ci = c;",
        "for (int i = 0; i < 100; ++i) Ci = Ci + 0.001 * diffuse (N);",
    ] {
        let found = point(body);
        let albedo = found.bsdf.albedo(toward());
        assert!(albedo.is_finite() && found.emission.is_finite(), "{body}: {albedo} {}", found.emission);
    }
}

#[test]
fn what_lets_no_light_through_hides_what_lies_below() {
    let albedo = |text: &str| point(&format!("Ci = {text};")).bsdf.albedo(toward());
    let red = albedo("color (0.8, 0.1, 0.2) * diffuse (N)");
    let over = albedo(
        "layer (oren_nayar_diffuse_bsdf (N, color (0.8, 0.1, 0.2), 0), color (0, 1, 0) * diffuse (N))",
    );
    assert!((over - red).length() < 1e-3, "nothing of the green is seen: {over}, not {red}");
    let half = albedo("layer (0.5 * diffuse (N), color (0, 1, 0) * diffuse (N))");
    assert!((half - Vec3::new(0.5, 1.0, 0.5)).length() < 1e-3, "half of it is open: {half}");
}

#[test]
fn coats_have_no_inside() {
    let albedo = |body: &str, from: Vec3| {
        let mut hits = floor(1);
        hits.ray_dir.set(0, -from);
        let mut out = ClosureBatch::default();
        out.reset(1);
        surface(body).evaluate(&hits, &mut out);
        out.point(0).bsdf.albedo(from)
    };
    for roughness in [0.0, 0.1] {
        let body = format!(
            "Ci = layer (dielectric_bsdf (N, vector (0), color (1), color (0), {roughness}, {roughness}, 1.5, \"ggx\"), 0.2 * diffuse (N));"
        );
        let above = albedo(&body, toward());
        let below = albedo(&body, Vec3::new(0.0, -1.0, 1.0).normalize());
        assert!(
            (above - below).length() < 1e-5,
            "roughness {roughness}: {above} from above, {below} from below"
        );
    }
}

#[test]
fn closures_may_be_made_of_themselves() {
    let there =
        point("Ci = 0.5 * diffuse (N); Ci = layer (sheen_bsdf (N, 0, 0.5), Ci);").bsdf.albedo(toward());
    assert!((there - Vec3::splat(0.5)).length() < 1e-3, "what was in Ci lies below: {there}");
}

#[test]
fn models_are_those_that_were_asked_for() {
    use gnurt_shading::bsdf::Lobe;
    let one = |body: &str| {
        let mut found = point(&format!("Ci = {body};")).bsdf.lobes().as_slice()[0];
        found.normal = Vec3::ZERO;
        found
    };
    let grey = Vec3::splat(0.5);
    assert_eq!(one("oren_nayar (N, 0.5)"), Lobe::oren_nayar_once(Vec3::ONE, 0.5));
    let dust = "oren_nayar_diffuse_bsdf (N, color (0.5), 0.3";
    assert_eq!(one(&format!("{dust})")), Lobe::oren_nayar_once(grey, 0.3), "light is lost");
    assert_eq!(one(&format!("{dust}, \"energy_compensation\", 1)")), Lobe::oren_nayar(grey, 0.3), "or kept");
    assert_eq!(one("burley_diffuse_bsdf (N, color (0.5), 0.8)"), Lobe::burley(grey, 0.8));
    let schlick = |power| {
        one(&format!(
            "generalized_schlick_bsdf (N, vector (0), color (1), color (0), 0.2, 0.2, color (0.5), color (1), {power}, \"ggx\")"
        ))
    };
    assert_eq!(schlick(5), Lobe::microfacets(0.2, grey, Vec3::ONE));
    let glass = point(
        "Ci = generalized_schlick_bsdf (N, vector (0), color (1, 0.5, 1), color (0.2), 0.2, 0.2, color (0.25), color (1), 4, \"ggx\");",
    );
    let expected = [(false, Vec3::new(1.0, 0.5, 1.0)), (true, Vec3::splat(0.2))].map(|(through, weight)| {
        let reflectances = [Vec3::splat(0.25), Vec3::ONE];
        let mut lobe = Lobe::schlick_glass(0.2, 1.0 / 3.0, reflectances, 4.0, through);
        lobe.weight = weight;
        lobe
    });
    assert_eq!(glass.bsdf.lobes().as_slice(), expected, "glass: what is mirrored, and what goes through");
    assert_eq!(schlick(3), Lobe::microfacets(0.2, grey, Vec3::ONE).risen(3.0));
}

/// MaterialX's generated shaders give a closure as an output, and do not write `Ci`.
#[test]
fn a_closure_output_is_ci_where_a_shader_has_none() {
    let text = "shader test (color tint = color (0.2, 0.4, 0.6), output closure color out = 0)
        { out = tint * diffuse (N); }";
    let mut out = ClosureBatch::default();
    out.reset(1);
    script(text).surface().expect("a surface").evaluate(&floor(1), &mut out);
    let expected = point("Ci = color (0.2, 0.4, 0.6) * diffuse (N);");
    assert_eq!(out.point(0).bsdf.lobes().as_slice(), expected.bsdf.lobes().as_slice());
    assert_eq!(expected.bsdf.lobes().as_slice().len(), 1);
}

#[test]
fn surface_shaders_of_materialx_are_taken_as_ci() {
    let text = "struct surfaceshader { closure color bsdf; closure color edf; float opacity; };
        shader s (output surfaceshader out = {0, 0, 1.0}) {
            out.bsdf = diffuse (N);
            out.edf = color (3) * emission ();
            out.opacity = 0.25;
        }";
    let (hits, mut out) = (floor(1), ClosureBatch::default());
    out.reset(1);
    let made = script(text);
    assert!(made.warnings().is_empty(), "{:?}", made.warnings());
    made.surface().expect("a surface").evaluate(&hits, &mut out);
    let point = out.point(0);
    assert_eq!((point.emission, point.coverage), (Vec3::splat(0.75), 0.25), "opacity weighs it");
    assert_eq!(point.bsdf.lobes().as_slice().len(), 1);
}

#[test]
fn holdouts_are_shares_of_the_opaque_part() {
    for (closures, opacity, hole) in [
        ("holdout ()", 1.0, 1.0),
        ("0.25 * holdout () + 0.75 * diffuse (N)", 1.0, 0.25),
        ("color (0.3, 0, 0) * holdout ()", 1.0, 0.1),
        ("0.5 * transparent () + 0.5 * holdout ()", 0.5, 1.0),
        ("0.5 * transparent () + 0.125 * holdout () + 0.375 * diffuse (N)", 0.5, 0.25),
        ("layer (sheen_bsdf (N, color (0), 0.5), 0.5 * holdout ())", 1.0, 0.5),
        ("7 * holdout ()", 1.0, 1.0),
        ("-1 * holdout () + diffuse (N)", 1.0, 0.0),
        ("diffuse (N)", 1.0, 0.0),
    ] {
        // Constant, and computed for each point.
        for of in ["", " + 0 * u * diffuse (N)"] {
            let shader = surface(&format!("Ci = {closures}{of};"));
            let mut out = ClosureBatch::default();
            out.reset(3);
            shader.evaluate(&floor(3), &mut out);
            let is_holed = closures.contains("holdout");
            assert_eq!(shader.has_holes(), is_holed, "{closures}");
            assert!((out.coverage(2) - opacity).abs() < 1e-6, "{closures}{of}: opacity {}", out.coverage(2));
            assert!((out.held_out(2) - hole).abs() < 1e-6, "{closures}{of}: a hole of {}", out.held_out(2));
            assert_eq!(out.emission(2), Vec3::ZERO, "{closures}{of}: no light");
        }
    }
}
