// SPDX-License-Identifier: GPL-3.0-or-later
//! `--set`: values of a scene changed from the command line.

use super::harness::Folder;

const SMALL: &str = "-r 16x16 --spp 4 -t 2";

#[test]
fn values_are_changed_before_rendering() {
    let folder = Folder::new();
    let render = |name: &str, set: &str| {
        folder.gnurt(&format!("render builtin:cornell {set} -o {name}.pfm {SMALL}")).success();
        folder.read(&format!("{name}.pfm"))
    };
    let plain = render("plain", "");
    let black = render("black", "--set materials.*.base_color=0 --set materials.*.emission=0");
    let again = render("again", "--set materials.*.emission=0 --set materials.*.base_color=0");
    assert!(plain != black && black == again, "every change counts, in any order of different fields");
    let last = render(
        "last",
        "--set materials.*.emission=3 --set materials.*.emission=0 --set materials.*.base_color=0",
    );
    assert!(last == black, "of two for one field the last");
}

#[test]
fn mistakes_are_told() {
    let folder = Folder::new();
    for (set, words) in [
        ("gold", "give LIST.NAME.FIELD=VALUE like materials.gold.roughness=0.3"),
        ("materials.gold.roughness=1", "--set: materials: unknown name 'gold'; valid are:"),
        ("lights.*.size=1", "--set:"),
    ] {
        folder.gnurt(&format!("render builtin:cornell --set {set} {SMALL}")).fails(2, words);
    }
}

#[test]
fn lights_are_linked_to_instances() {
    let folder = Folder::new();
    let render = |name: &str, set: &str| {
        let run = format!("render builtin:spheres {set} -o {name}.pfm {SMALL} --integrator path");
        folder.gnurt(&run).success();
        folder.read(&format!("{name}.pfm"))
    };
    let plain = render("plain", "");
    let some = render("some", "--set lights.*.link=floor,red");
    assert!(plain != some, "others are dark");
    assert!(
        some == render("others", "--set lights.*.link=^blue,glass,gold,green,ivory,mirror,violet"),
        "all but these"
    );
    assert!(plain == render("all", "--set lights.*.link=^none"), "^none is everything");
    let wrong = "--set lights.*.shadow_link=chair";
    folder
        .gnurt(&format!("render builtin:spheres {wrong} {SMALL}"))
        .fails(2, "no instance is called 'chair'");
    let run = format!("render builtin:spheres --set lights.*.link=red {SMALL} --integrator whitted -o w.pfm");
    let run = folder.gnurt(&run).success();
    assert_eq!(run.lines("warning: --integrator whitted ignores the links").len(), 1, "{}", run.stderr);
}

#[test]
fn instances_are_held_out() {
    let folder = Folder::new();
    let run = "render builtin:spheres -r 40x30 --spp 4 --integrator path --denoise=none";
    folder
        .gnurt(&format!("{run} --set instances.gold.holdout=true --layers crypto_object -o held.exr"))
        .success();
    let picture = gnurt::image::read(&folder.at("held.exr")).expect("a picture");
    let gold = gnurt::mattes::matte(&picture, gnurt::render::MatteKind::Object, "gold").expect("mattes");
    let inside: Vec<usize> = (0..gold.len()).filter(|&i| gold[i] > 0.999).collect();
    assert!(!inside.is_empty(), "it has a matte");
    assert!(inside.iter().all(|&i| picture.color[i] == [0.0; 4]), "and a hole");
    folder.gnurt(&format!("{run} --set instances.gold.holdout=yes -o o.exr")).fails(2, "give true or false");
    folder
        .gnurt(&format!("{run} --set materials.gold.holdout=true -o o.exr"))
        .fails(2, "unknown field 'holdout'");
}
