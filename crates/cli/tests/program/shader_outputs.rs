// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt render --layers shader.NAME`: outputs of surface shaders as layers of EXR files.

use gnurt::image::{ChannelData, Picture, read};

use super::harness::Folder;

const RUN: &str = "render builtin:cornell -r 40x32 --spp 4 --integrator path --denoise=none";

fn plane<'a>(picture: &'a Picture, layer: &str, channel: &str) -> &'a [f32] {
    let found = picture.layer(layer).unwrap_or_else(|| panic!("the layer {layer}"));
    match &found.channel(channel).unwrap_or_else(|| panic!("{layer}.{channel}")).data {
        ChannelData::F32(values) => values,
        ChannelData::U32(_) => panic!("{layer} holds numbers"),
    }
}

/// Materials of two shaders; the rest has none.
fn shaders(folder: &Folder) -> String {
    let floor = "surface a (output float mask = 0, output vector dir = 0, output color tint = 0)
        { mask = 1; dir = N; tint = color (0.25, 0.5, 1); Ci = 0.5 * diffuse (N); }";
    let veil =
        "surface b (output float mask = 0) { mask = 3; Ci = 0.25 * diffuse (N) + 0.75 * transparent (); }";
    std::fs::write(folder.at("a.osl"), floor).expect("a shader");
    std::fs::write(folder.at("b.osl"), veil).expect("a shader");
    format!("{RUN} --shader white=a.osl")
}

#[test]
fn outputs_are_layers() {
    let folder = Folder::new();
    let run = shaders(&folder);
    folder.gnurt(&format!("{run} --layers normal,ids,shader.mask,shader.dir,shader.tint -o p.exr")).success();
    let picture = read(&folder.at("p.exr")).expect("a picture");
    let names = |layer: &str| {
        let all = &picture.layer(layer).expect("a layer").channels;
        all.iter().map(|channel| &channel.name[..]).collect::<Vec<_>>().join("")
    };
    let [mask, dir, tint] = ["shader.mask", "shader.dir", "shader.tint"].map(names);
    assert_eq!(
        (&mask[..], &tint[..], &dir[..]),
        ("Y", "BGR", "XYZ"),
        "channels as their types have them, sorted"
    );
    let mask = plane(&picture, "shader.mask", "Y");
    let (some, all) = (mask.iter().filter(|&&x| x > 0.0).count(), mask.iter().filter(|&&x| x == 1.0).count());
    assert!(all > 100 && some < mask.len() && all < some, "inside, outside and edges: {all}, {some}");
    for (i, &mask) in mask.iter().enumerate() {
        for (channel, scale) in [("R", 0.25), ("G", 0.5), ("B", 1.0)] {
            let tint = plane(&picture, "shader.tint", channel)[i];
            assert!((tint - scale * mask).abs() < 1e-6, "pixel {i}: means over samples: {tint}, {mask}");
        }
        for channel in ["X", "Y", "Z"].into_iter().filter(|_| mask == 1.0) {
            let (dir, normal) = (plane(&picture, "shader.dir", channel)[i], plane(&picture, "N", channel)[i]);
            assert!((dir - normal).abs() < 1e-5, "pixel {i}: {dir}, {normal}");
        }
    }
    folder.gnurt(&format!("{run} --bits 32 -o plain.exr")).success();
    let plain = read(&folder.at("plain.exr")).expect("a picture");
    assert!(plain.color == picture.color, "layers change no bit");
}

#[test]
fn transparent_surfaces_and_what_is_behind_share() {
    let folder = Folder::new();
    let run = shaders(&folder).replace("--shader white=a.osl", "--shader *=b.osl");
    folder.gnurt(&format!("{run} --layers shader.mask -o p.exr")).success();
    let picture = read(&folder.at("p.exr")).expect("a picture");
    let mask = plane(&picture, "shader.mask", "Y");
    // A quarter of the first, then of the next: two surfaces or more, but 3 at most.
    let first = 3.0 * 0.25;
    assert!(mask.iter().all(|&x| x < 3.0 + 1e-4), "no more than there is");
    assert!(mask.iter().any(|&x| (x - first).abs() < 1e-4 || x > first), "{mask:?}");
    assert!(mask.iter().any(|&x| x > first + 0.1), "behind");
}

#[test]
fn pieces_carry_them_and_mistakes_are_reported() {
    let folder = Folder::new();
    let run = shaders(&folder);
    let run = format!("{run} --layers shader.mask,shader.dir");
    folder.gnurt(&format!("{run} -o whole.exr")).success();
    for piece in [1, 2] {
        folder.gnurt(&format!("{run} --piece {piece}/2 -o p{piece}.exr")).success();
    }
    folder.gnurt("join p1.exr p2.exr -o joined.exr").success();
    let [whole, joined] = ["whole.exr", "joined.exr"].map(|name| {
        let picture = read(&folder.at(name)).expect("a picture");
        Picture { metadata: Vec::new(), ..picture }
    });
    assert!(whole == joined, "bit for bit");
    folder
        .gnurt(&format!("{RUN} --shader white=a.osl --layers shader.msk -o p.exr"))
        .fails(2, "has an output 'msk'; there are: ");
    folder.gnurt(&format!("{RUN} --layers shader.mask -o p.exr")).fails(2, "there are: none");
    folder.gnurt(&format!("{RUN} --layers shader.1 -o p.exr")).fails(2, "give NAME or LAYER.NAME");
}
