// SPDX-License-Identifier: GPL-3.0-or-later
//! Media: numbers, what holds them, and where grids are.

use gnurt_scene::medium::Extent;
use gnurt_scene::{MediumId, Scene};

use crate::common::{read_with_files, world, world_warned};

const FOG: &str = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [ 1 2 3 ] \
    \"rgb sigma_s\" [ 4 5 6 ] \"float scale\" 2 \"float g\" 0.5\n";

fn of_first_mesh(scene: &Scene) -> Option<MediumId> {
    scene.material(scene.meshes()[0].material).medium
}

#[test]
fn shapes_hold_media() {
    let loaded =
        world(&format!("{FOG}MediumInterface \"fog\" \"\"\nMaterial \"interface\"\nShape \"sphere\""));
    let scene = loaded.scene;
    let medium = scene.medium(of_first_mesh(&scene).expect("fog"));
    assert_eq!((medium.absorption, medium.scattering), ([2.0, 4.0, 6.0], [8.0, 10.0, 12.0]));
    assert_eq!((medium.phase.anisotropy, medium.extent), (0.5, Extent::Bodies));
    let loaded =
        world(&format!("{FOG}MediumInterface \"\" \"fog\"\nMaterial \"dielectric\"\nShape \"sphere\""));
    let hollow = loaded.scene.medium(of_first_mesh(&loaded.scene).expect("nothing within"));
    assert_eq!((hollow.absorption, hollow.scattering), ([0.0; 3], [0.0; 3]), "glass in fog is clear");
    let none = world(&format!("{FOG}Shape \"sphere\"")).scene;
    assert_eq!(of_first_mesh(&none), None);
}

#[test]
fn the_cameras_medium_is_everywhere() {
    let text =
        format!("{FOG}MediumInterface \"\" \"fog\"\nCamera \"perspective\"\nWorldBegin\nShape \"sphere\"");
    let (loaded, _folder) = read_with_files(&text, &[]);
    let scene = loaded.expect("a scene").scene;
    let everywhere = Extent::Around { centre: [0.0; 3], radius: f32::INFINITY };
    assert_eq!(scene.media()[0].extent, everywhere);
}

#[test]
fn grids_are_where_the_medium_is_made() {
    let grid = "MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1 \
        \"float density\" [ 3 4 ] \"point3 p0\" [ 0 0 0 ] \"point3 p1\" [ 2 1 1 ] \"float Lescale\" 5\n";
    let text = format!(
        "Translate 7 0 0\n{grid}MediumInterface \"smoke\" \"\"\nMaterial \"interface\"\nShape \"sphere\""
    );
    let scene = world(&text).scene;
    let grid = scene.medium(of_first_mesh(&scene).expect("smoke")).grid.as_ref().expect("a grid");
    assert_eq!(grid.size, [4, 3, 3], "with a rim");
    assert_eq!(grid.density[(3 + 1) * 4 + 1..][..2], [3.0, 4.0]);
    assert_eq!(grid.emission[(3 + 1) * 4 + 1], [5.0; 3]);
    let corner = grid.world_from_unit.point([0.25, 1.0 / 3.0, 1.0 / 3.0]);
    assert!((corner[0].abs() - 7.0).abs() < 1e-5, "the corner of the first cell: {corner:?}");
}

#[test]
fn subsurface_is_glass_around_a_medium() {
    let scene =
        world("Material \"subsurface\" \"string name\" \"Skin1\" \"float scale\" 10\nShape \"sphere\"").scene;
    let medium = scene.medium(of_first_mesh(&scene).expect("skin"));
    assert!((medium.scattering[0] - 7.4).abs() < 1e-4 && (medium.absorption[2] - 4.8).abs() < 1e-4);
}

#[test]
fn odd_media_are_named() {
    world_warned("MakeNamedMedium \"sky\" \"string type\" \"cloud\"\nShape \"sphere\"", &["`cloud`"]);
    for (text, part) in [
        ("MakeNamedMedium \"a\" \"string type\" \"soup\"", "soup"),
        ("MakeNamedMedium \"a\"", "no \"string type\""),
        ("MakeNamedMedium \"a\" \"string type\" \"homogeneous\" \"float g\" 1.5", "anisotropies"),
        (
            "MakeNamedMedium \"a\" \"string type\" \"uniformgrid\" \"float density\" [ 1 2 ]",
            "2 values for 1 cells",
        ),
        ("MakeNamedMedium \"a\" \"string type\" \"uniformgrid\" \"integer nx\" -4", "-4"),
        ("MediumInterface \"b\" \"\"\nShape \"sphere\"", "no medium `b`"),
    ] {
        let (loaded, _folder) = read_with_files(&format!("WorldBegin\n{text}\n"), &[]);
        let error = loaded.expect_err("nonsense").to_string();
        assert!(error.contains(part), "{error}");
    }
    let twice = format!("WorldBegin\n{FOG}{FOG}");
    let error = read_with_files(&twice, &[]).0.expect_err("twice").to_string();
    assert!(error.contains("defined twice") && error.contains("t.pbrt:3"), "{error}");
}
