// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --layers`.

use super::harness::Folder;

const SMALL: &str = "render builtin:cornell -r 16x16 --spp 2 -q";

#[test]
fn an_exr_has_the_layers_of_the_list() {
    let folder = Folder::new();
    let picture = |list: &str| {
        folder.gnurt(&format!("{SMALL} --layers {list} -o p.exr")).success();
        gnurt::image::read(&folder.at("p.exr")).expect("a picture")
    };
    let whole = picture("all");
    let some = picture("normal,albedo");
    let mut names: Vec<&str> = some.layers.iter().map(|layer| layer.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["N", "albedo"], "those of the list");
    assert!(some.layers.iter().all(|layer| whole.layer(&layer.name) == Some(layer)), "the same values");
    assert!(picture("none").layers.is_empty(), "none");
    assert!(picture("background").layer("background").is_some(), "the background alone");
    folder.gnurt(&format!("{SMALL} --layers normals -o p.exr")).fails(2, "did you mean 'normal'?");
    folder.gnurt(&format!("{SMALL} --layers normal -o p.png")).fails(2, "p.png has no layers");
}
