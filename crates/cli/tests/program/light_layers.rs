// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --layers` with parts of the light, `--light-groups`, their pieces and checkpoints.

use gnurt::image::{ChannelData, Picture, read};

use super::harness::Folder;

const SMALL: &str = "render builtin:cornell -r 40x32 --spp 4 --integrator path";
const PARTS: &str = "diffuse,glossy,transmission,volume,emission,environment";

/// Values of a layer's channels, one after the other.
fn values(picture: &Picture, name: &str) -> Vec<f32> {
    let layer = picture.layer(name).unwrap_or_else(|| panic!("the layer {name}"));
    let channels = ["R", "G", "B"].map(|channel| layer.channel(channel).expect("a colour"));
    let floats = channels.into_iter().map(|channel| match &channel.data {
        ChannelData::F32(values) => values.clone(),
        ChannelData::U32(_) => panic!("{name} holds light"),
    });
    floats.flatten().collect()
}

/// The largest difference between the sum of layers and the picture.
fn off(picture: &Picture, names: &[&str]) -> f32 {
    let whole: Vec<f32> = (0..3).flat_map(|k| picture.color.iter().map(move |pixel| pixel[k])).collect();
    let parts: Vec<Vec<f32>> = names.iter().map(|name| values(picture, name)).collect();
    let sum = |i: usize| parts.iter().map(|part| part[i]).sum::<f32>();
    whole.iter().enumerate().map(|(i, x)| (sum(i) - x).abs() / x.abs().max(1.0)).fold(0.0, f32::max)
}

#[test]
fn parts_of_a_file_make_its_picture() {
    let folder = Folder::new();
    let names: Vec<&str> = PARTS.split(',').collect();
    for scene in ["builtin:cornell", "builtin:materials"] {
        let run = format!("render {scene} -r 40x32 --spp 4 --integrator path");
        folder.gnurt(&format!("{run} --layers {PARTS} -o p.exr")).success();
        let picture = read(&folder.at("p.exr")).expect("a picture");
        assert!(off(&picture, &names) < 1e-5, "{scene}: {}", off(&picture, &names));
        folder.gnurt(&format!("{run} --bits 32 -o plain.exr")).success();
        let plain = read(&folder.at("plain.exr")).expect("a picture");
        assert!(plain.color == picture.color, "{scene}: layers change no bit");
    }
    folder.gnurt(&format!("{SMALL} --layers caustic=C<RD><.S>+[LO],light:light -o p.exr")).success();
    let picture = read(&folder.at("p.exr")).expect("a picture");
    assert!(values(&picture, "caustic").iter().all(|&x| x >= 0.0), "an expression");
    assert!(off(&picture, &["light.light"]) < 1e-5, "the only light");
}

#[test]
fn groups_come_from_the_command_line() {
    let folder = Folder::new();
    let set = "--set materials.light.group=lamp";
    folder.gnurt(&format!("{SMALL} {set} --light-groups --layers normal -o p.exr")).success();
    let picture = read(&folder.at("p.exr")).expect("a picture");
    let mut names: Vec<&str> = picture.layers.iter().map(|layer| layer.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["N", "background", "light.lamp", "light_rest"], "one for each group, and the rest");
    assert!(off(&picture, &["light.lamp", "light_rest"]) < 1e-5, "all light");
    assert!(values(&picture, "light_rest").iter().all(|&x| x == 0.0), "no other");
    let run = folder.gnurt(&format!("{SMALL} --light-groups -o p.exr")).success();
    assert_eq!(run.lines("warning: --light-groups: no light has a group").len(), 1, "{}", run.stderr);
}

#[test]
fn pieces_and_checkpoints_carry_them() {
    let folder = Folder::new();
    let more = format!("--layers {PARTS},albedo --set materials.light.group=lamp --light-groups");
    folder.gnurt(&format!("{SMALL} {more} -o whole.exr")).success();
    for piece in [1, 2] {
        folder.gnurt(&format!("{SMALL} {more} --piece {piece}/2 -o p{piece}.exr")).success();
    }
    folder.gnurt("join p1.exr p2.exr -o joined.exr").success();
    let without = |name: &str| {
        let picture = read(&folder.at(name)).expect("a picture");
        Picture { metadata: Vec::new(), ..picture }
    };
    let whole = without("whole.exr");
    assert!(whole == without("joined.exr"), "all layers, bit for bit");
    assert_eq!(whole.layers.len(), 10, "six parts, two of groups, albedo, background");
    let other = SMALL.replace("--spp 4", "--spp 2");
    folder.gnurt(&format!("{other} {more} --checkpoint c -o p.exr")).success();
    folder.gnurt(&format!("{SMALL} {more} --checkpoint c -o resumed.exr")).success();
    assert!(whole == without("resumed.exr"), "from a checkpoint");
    folder.gnurt(&format!("{SMALL} --checkpoint c -o p.exr")).fails(1, "of another picture");
}

#[test]
fn mistakes_are_told() {
    let folder = Folder::new();
    for (more, words) in [
        ("--layers direct --integrator whitted", "'direct' is unsupported with --integrator whitted"),
        ("--layers direct,diffuse --integrator bir", "'diffuse' is unsupported with --integrator bir"),
        ("--layers direct --integrator ir --interleave 3", "interleaved pixels have no layers of light"),
        ("--light-groups --integrator whitted", "unsupported with --integrator whitted"),
        ("--layers x=C<RD", "character 2: '>' is missing"),
        ("--layers light:kye", "called 'kye'; light groups are: none"),
        ("--layers dirct", "did you mean 'direct'?"),
        ("--set materials.light.group=a/b", "give letters"),
    ] {
        let integrator = if more.contains("--integrator") { "" } else { "--integrator path" };
        folder
            .gnurt(&format!("render builtin:cornell -r 8x8 --spp 1 {integrator} {more} -o p.exr"))
            .fails(2, words);
    }
    folder.gnurt(&format!("{SMALL} --light-groups -o p.png")).fails(2, "p.png has no layers");
    assert!(!folder.at("p.exr").exists(), "nothing was written");
}

#[test]
fn files_want_layers() {
    let folder = Folder::new();
    super::animation::animated(&folder);
    let path = folder.at("a.gltf");
    let text = std::fs::read_to_string(&path).expect("a scene");
    let wish = r#"{"extras":{"gnurt":{"outputs":["normal","direct","all_light=C.*"]}},"#;
    std::fs::write(&path, text.replacen('{', wish, 1)).expect("a file");
    let names = |more: &str| {
        folder.gnurt(&format!("render a.gltf -r 16x12 --spp 2 {more} -o p.exr")).success();
        let picture = read(&folder.at("p.exr")).expect("a picture");
        let mut names: Vec<String> = picture.layers.iter().map(|layer| layer.name.clone()).collect();
        names.sort_unstable();
        names
    };
    assert_eq!(names("--integrator path"), ["N", "all_light", "background", "direct"], "those of the file");
    assert_eq!(names("--integrator whitted"), ["N"], "as far as they are there");
    assert_eq!(names("--integrator path --layers albedo"), ["albedo"], "options win");
    folder.gnurt("render a.gltf -r 16x12 --spp 2 -o p.png").success();
}
