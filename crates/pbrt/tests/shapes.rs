// SPDX-License-Identifier: GPL-3.0-or-later
//! Shapes: areas by closed forms, sides of normals, texture coordinates.

use gnurt_scene::{CurveBasis, CurveForm, Mesh, Primitives};

use crate::common::world;

fn mesh(text: &str) -> Mesh {
    let loaded = world(text);
    assert_eq!(loaded.scene.meshes().len(), 1, "{text}");
    Mesh::clone(&loaded.scene.meshes()[0])
}

fn corners(mesh: &Mesh) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
    mesh.indices.iter().map(|triangle| triangle.map(|i| mesh.positions[i as usize].map(f64::from)))
}

fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn area(mesh: &Mesh) -> f64 {
    corners(mesh).map(|c| normal(c).iter().map(|x| x * x).sum::<f64>().sqrt() / 2.0).sum()
}

/// The volume that it encloses, below zero if it is inside out.
fn volume(mesh: &Mesh) -> f64 {
    corners(mesh).map(|c| (0..3).map(|k| c[0][k] * normal(c)[k]).sum::<f64>() / 6.0).sum()
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 5e-3, "{found} instead of {expected}");
}

#[test]
fn quadrics_have_their_areas() {
    use std::f64::consts::PI;
    near(area(&mesh("Shape \"sphere\" \"float radius\" 2")), 4.0 * PI);
    near(volume(&mesh("Shape \"sphere\"")), 4.0 / 3.0 * PI);
    near(volume(&mesh("ReverseOrientation\nShape \"sphere\"")), -4.0 / 3.0 * PI);
    // Archimedes: a zone's area is that of the cylinder around it.
    near(
        area(&mesh("Shape \"sphere\" \"float zmin\" -0.5 \"float zmax\" 0.25 \"float phimax\" 90")),
        0.75 * PI / 2.0,
    );
    near(
        area(&mesh("Shape \"disk\" \"float radius\" 2 \"float innerradius\" 1 \"float phimax\" 180")),
        1.5 * PI,
    );
    near(area(&mesh("Shape \"cylinder\" \"float radius\" 2 \"float zmin\" 0 \"float zmax\" 3")), 12.0 * PI);
    let disk = mesh("Shape \"disk\" \"float height\" 1");
    assert!(corners(&disk).all(|c| normal(c)[2] > 0.0), "a disk looks along z");
    let uv = &mesh("Shape \"cylinder\"").texcoords;
    assert!(uv.contains(&[0.0, 0.0]) && uv.contains(&[1.0, 1.0]), "texture coordinates go around");
}

/// Whole spheres that shine outwards alike are spheres; what has a picture, an inside or a part missing is a mesh.
#[test]
fn lamps_are_spheres_without_triangles() {
    let lamp = "AreaLightSource \"diffuse\" \"rgb L\" [ 1 2 3 ]\n";
    let ball = mesh(&format!("{lamp}Translate 1 2 3 Rotate 20 1 1 0\nShape \"sphere\" \"float radius\" 2"));
    assert_eq!(ball.primitives, Primitives::Spheres(vec![1.0]), "its size is in the transform");
    for text in [
        "Shape \"sphere\"",
        &format!("{lamp}Scale 1 2 1\nShape \"sphere\""),
        &format!("{lamp}ReverseOrientation\nShape \"sphere\""),
        &format!("{lamp}Shape \"sphere\" \"float phimax\" 359"),
        &format!("{lamp}Shape \"sphere\" \"float zmax\" 0.9"),
        &format!("{lamp}Shape \"sphere\" \"float alpha\" 0.5"),
        "AreaLightSource \"diffuse\" \"bool twosided\" true\nShape \"sphere\"",
    ] {
        assert!(mesh(text).has_triangles(), "{text}");
    }
    // 8 W over pi times the area of 16 pi.
    let power = world("AreaLightSource \"diffuse\" \"float power\" 8\nShape \"sphere\" \"float radius\" 2");
    near(power.scene.materials()[0].emission[0].into(), 8.0 / (16.0 * std::f64::consts::PI.powi(2)));
}

#[test]
fn a_sphere_is_stored_once() {
    let loaded =
        world("Shape \"sphere\" \"float radius\" 2\nTranslate 5 0 0\nShape \"sphere\" \"float radius\" 3");
    let scene = &loaded.scene;
    assert_eq!((scene.meshes().len(), scene.instances().len()), (1, 2));
    let sizes: Vec<f64> = scene.instances().iter().map(|i| i.world_from_object.columns[1][1]).collect();
    assert_eq!(sizes, [2.0, 3.0]);
}

#[test]
fn triangles_turn_to_their_normals() {
    let text = "Shape \"trianglemesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 ] \"integer indices\" [ 0 1 2 ]";
    let down = format!("{text} \"normal N\" [ 0 0 -1 0 0 -1 0 0 -1 ]");
    assert!(normal(corners(&mesh(text)).next().expect("one"))[2] > 0.0);
    assert!(normal(corners(&mesh(&down)).next().expect("one"))[2] < 0.0, "the normal's side");
    let reversed = mesh(&format!("ReverseOrientation\n{text}"));
    assert!(normal(corners(&reversed).next().expect("one"))[2] < 0.0, "the other side");
}

#[test]
fn patches_and_subdivision() {
    let flat = mesh("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 2 0 0 0 3 0 2 3 0 ]");
    assert_eq!((flat.indices.len(), area(&flat)), (2, 6.0), "a rectangle is two triangles");
    assert!(corners(&flat).all(|c| normal(c)[2] > 0.0), "u across v");
    let bent = mesh("Shape \"bilinearmesh\" \"point3 P\" [ 0 0 0 1 0 0 0 1 0 1 1 1 ]");
    // The integral of the root of 1 + x² + y² over the unit square.
    near(area(&bent), 1.2808);
    let cube = "\"point3 P\" [ -1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1 -1 -1 1 1 -1 1 1 1 1 -1 1 1 ] \"integer indices\" [ \
        0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7 ]";
    let [coarse, fine] =
        [2, 4].map(|levels| mesh(&format!("Shape \"loopsubdiv\" \"integer levels\" {levels} {cube}")));
    assert_eq!(coarse.indices.len(), 12 * 16);
    // Vertices are on the limit surface at all levels, so volumes come near each other.
    assert!((volume(&fine) / volume(&coarse) - 1.0).abs() < 0.08, "{} {}", volume(&fine), volume(&coarse));
    assert!(volume(&fine) > 1.0 && volume(&fine) < 8.0, "rounded and outside out: {}", volume(&fine));
    for (p, n) in fine.positions.iter().zip(&fine.normals) {
        assert!((0..3).map(|k| p[k] * n[k]).sum::<f32>() > 0.0, "normals look out");
    }
}

#[test]
fn curves_are_as_wide_as_they_should_be() {
    let straight = "\"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 ] \"float width0\" 0.1 \"float width1\" 0.4";
    let curves = |mesh: &Mesh| match &mesh.primitives {
        Primitives::Curves(curves) => curves.clone(),
        other => panic!("{other:?}"),
    };
    let flat = curves(&mesh(&format!("Shape \"curve\" {straight}")));
    assert_eq!((flat.basis, flat.form), (CurveBasis::Bezier, CurveForm::Flat), "the default");
    let expected = [0.05, 0.1, 0.15, 0.2];
    assert!(flat.radii.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{:?}", flat.radii);
    let ribbon =
        mesh(&format!("Shape \"curve\" \"string type\" \"ribbon\" \"normal N\" [ 0 0 1 0 1 0 ] {straight}"));
    assert_eq!(curves(&ribbon).form, CurveForm::Oriented, "with normals");
    assert!(
        ribbon.normals[3][1] > 0.999 && (ribbon.normals[1][1] - 0.5).abs() < 1e-6,
        "{:?}",
        ribbon.normals
    );
    let spline = mesh(
        "Shape \"curve\" \"string basis\" \"bspline\" \"point3 P\" [ 0 0 0 1 0 0 2 0 0 3 0 0 4 0 0 ] \"float width\" 0.1",
    );
    assert_eq!(curves(&spline).segments, [0, 3], "two segments");
    let ends = spline.positions.iter().fold([f32::MAX, f32::MIN], |[a, b], p| [a.min(p[0]), b.max(p[0])]);
    assert!(
        (ends[0] - 1.0).abs() < 1e-5 && (ends[1] - 3.0).abs() < 1e-5,
        "from the second to the last but one: {ends:?}"
    );
    let square = mesh("Shape \"curve\" \"integer degree\" 2 \"point3 P\" [ 0 0 0 1 2 0 2 0 0 ]");
    assert!((square.positions[1][1] - 4.0 / 3.0).abs() < 1e-6, "a cubic that is the same");
}
