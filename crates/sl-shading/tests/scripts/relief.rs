// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures hand on how they change: relief of a picture is that of the formula which the picture was made of.

use std::f32::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use gnurt_image::{Picture, WriteOptions};
use gnurt_shading::{SurfaceBatch, SurfaceShader, Vec3s};
use gnurt_sl_shading::{Access, Codes, Script};

use super::floor::floor;
use super::kinds::emitted;

const SIDE: usize = 64;

/// Red grows with s, blue with t; green has hills.
fn picture(folder: &Path) {
    let mut picture = Picture::new(SIDE as u32, SIDE as u32);
    for (i, texel) in picture.color.iter_mut().enumerate() {
        let [s, t] = [i % SIDE, i / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32);
        *texel = [0.25 + 0.5 * s, 0.5 + 0.25 * (TAU * s).sin() * (TAU * t).cos(), t, 1.0 - 0.5 * t];
    }
    gnurt_image::write(&picture, &folder.join("h.pfm"), &WriteOptions::default()).expect("a picture");
}

/// The same as a formula.
const FORMULA: &str = "color (0.25 + 0.5 * u, 0.5 + 0.25 * sin (M_2PI * u) * cos (M_2PI * v), v)";

/// Points all over the picture, seen from above by rays of some width.
fn points(width: f32) -> SurfaceBatch {
    let mut hits = floor(40);
    hits.ray_dir = Vec3s::splat(40, -Vec3::Y);
    hits.footprint = vec![width; 40];
    for i in 0..40 {
        hits.texcoord[0][i] = 0.05 + 0.9 * (i as f32 * 0.618).fract();
        hits.texcoord[1][i] = 0.05 + 0.9 * (i as f32 * 0.414).fract();
    }
    hits
}

fn open(folder: &Path, body: &str) -> Arc<dyn SurfaceShader> {
    let at = folder.join("s.osl");
    std::fs::write(&at, format!("surface s () {{ {body} }}")).expect("a shader");
    Script::open(&at, &Access::default()).expect("it compiles").surface().expect("a surface")
}

/// The light of all points, by the interpreter or by code, and later by code.
fn lights(folder: &Path, body: &str, hits: &SurfaceBatch) -> [Vec<Vec3>; 2] {
    let shader = open(folder, body);
    let first = emitted(&*shader, hits);
    Codes::default().wait();
    [first, emitted(&*shader, hits)]
}

/// Compares the results of a body with `HEIGHT` as the picture and as the formula.
fn compare(body: &str, [of_picture, of_formula]: [&str; 2], width: f32, tolerance: f32) {
    let folder = tempfile::tempdir().expect("a folder");
    picture(folder.path());
    let hits = points(width);
    let [found, expected] =
        [of_picture, of_formula].map(|height| lights(folder.path(), &body.replace("HEIGHT", height), &hits));
    assert!(expected[0].iter().any(|light| (*light - expected[0][0]).length() > 0.1), "they differ: {body}");
    for (found, expected) in found.iter().zip(&expected) {
        for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!((*found - *expected).length() < tolerance, "point {i}: {found}, not {expected}: {body}");
        }
    }
}

const BOTH: [&str; 2] = ["texture (\"h.pfm\", u, v)", FORMULA];

#[test]
fn pictures_change_as_their_formula_does() {
    for width in [1e-4, 0.01, 0.04] {
        let scale = 0.4 / width;
        let change = format!(
            "color h = HEIGHT; Ci = (0.7 + {scale} * Dx (h) + 0.4 * {scale} * Dy (h)) * emission ();"
        );
        compare(&change, BOTH, width, 0.03);
    }
    // One channel of another number, and the one after it as opacity.
    let one =
        "float a = 0; float h = HEIGHT; Ci = (0.7 + 40 * color (Dx (h), Dy (h), Dy (a))) * emission ();";
    let hills = "0.5 + 0.25 * sin (M_2PI * u) * cos (M_2PI * v)";
    compare(one, ["texture (\"h.pfm\", u, v, \"firstchannel\", 1)", hills], 0.01, 0.03);
    let with_alpha = format!("0.25 + 0.5 * u; a = {hills}");
    compare(one, ["texture (\"h.pfm\", u, v, \"alpha\", a)", &with_alpha], 0.01, 0.03);
    // By changes that the shader gives.
    let own = "color h = HEIGHT; Ci = (0.7 + 40 * Dx (h)) * emission ();";
    let doubled = "texture (\"h.pfm\", u, v, 2 * Dx (u), 2 * Dx (v), 2 * Dy (u), 2 * Dy (v)) * 0.5";
    compare(own, [doubled, FORMULA], 0.01, 0.03);
}

#[test]
fn relief_of_pictures_is_that_of_their_formula() {
    let body = "float h = 0.3 * HEIGHT[1]; vector n = normalize (calculatenormal (P + h * normalize (N))); Ci = (0.5 + 0.5 * color (n)) * emission ();";
    let of_picture = body.replace("HEIGHT[1]", "texture (\"h.pfm\", u, v, \"firstchannel\", 1)");
    let of_formula = body.replace("HEIGHT[1]", "(0.5 + 0.25 * sin (M_2PI * u) * cos (M_2PI * v))");
    compare("HEIGHT", [&of_picture, &of_formula], 0.01, 0.02);
    // A ramp, by its closed form.
    let folder = tempfile::tempdir().expect("a folder");
    picture(folder.path());
    let ramp = "float h = texture (\"h.pfm\", u, v); vector n = normalize (calculatenormal (P + h * normalize (N))); Ci = (0.5 + 0.5 * color (n)) * emission ();";
    let expected = 0.5 + 0.5 * Vec3::new(-0.5, 1.0, 0.0).normalize();
    for light in lights(folder.path(), ramp, &points(0.01)).concat() {
        assert!((light - expected).length() < 1e-3, "{light}, not {expected}");
    }
    // `bump` gives N that normal; P stays.
    for call in [
        "bump (h)",
        "bump (h * N)",
        "bump (\"object\", h)",
        "for (int i = 0; i < 2; ++i) if (i > 0) bump (h)",
    ] {
        let body = format!(
            "float h = texture (\"h.pfm\", u, v); point p = P; {call}; Ci = (0.5 + 0.5 * color (N) + length (P - p)) * emission ();"
        );
        for light in lights(folder.path(), &body, &points(0.01)).concat() {
            assert!((light - expected).length() < 1e-3, "{call}: {light}, not {expected}");
        }
    }
}

#[test]
fn nearest_texels_are_flat_and_borders_have_no_cliffs() {
    let folder = tempfile::tempdir().expect("a folder");
    picture(folder.path());
    let mut hits = points(0.01);
    for u in &mut hits.texcoord[0] {
        *u = if *u < 0.5 { 0.001 } else { 1.5 };
    }
    let body = "color h = texture (\"h.pfm\", u, v, \"interp\", \"closest\"); color k = texture (\"h.pfm\", u, v); color a = Dx (h), b = Dx (k); Ci = (color (0.5) + 100 * color (a[0], 0, b[0] / 4)) * emission ();";
    for light in lights(folder.path(), body, &hits).concat() {
        assert_eq!(light.x, 0.5, "closest: {light}");
        assert!((0.5..=0.63).contains(&light.z), "the ramp at most: {light}");
    }
}

#[test]
fn surroundings_change_as_their_formula_does() {
    let body = "vector r = vector (u - 0.5, v - 0.4, 1.5); color h = HEIGHT; color a = Dx (h), b = Dy (h); Ci = (0.7 + 600 * color (a[0], 0, b[2])) * emission ();";
    let formula = "color (0.25 + 0.5 * (atan2 (-r[0], r[2]) / M_2PI + 0.5), 0, 0.5 - atan2 (r[1], hypot (r[0], r[2])) / M_PI)";
    compare(body, ["environment (\"h.pfm\", r)", formula], 0.01, 0.03);
}
