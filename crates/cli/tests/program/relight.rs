// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt relight`: sums of groups against the picture, and against pictures that are rendered under other lights.

use gnurt::image::read;

use super::harness::Folder;

const ROOM: &str = "render builtin:materials -r 40x30 --spp 4 --integrator path --light-groups \
                    --set materials.lamp.group=first --set lights.0.group=second";

#[test]
fn groups_are_mixed() {
    let folder = Folder::new();
    folder.gnurt(&format!("{ROOM} -o f.exr")).success();
    let picture = |name: &str| read(&folder.at(name)).expect("a picture");
    folder.gnurt("relight f.exr -o same.exr").success();
    let (before, same) = (picture("f.exr"), picture("same.exr"));
    for (a, b) in before.color.as_flattened().iter().zip(same.color.as_flattened()) {
        assert!((a - b).abs() <= 1e-5 * a.abs().max(1.0), "{a} became {b}");
    }
    folder.gnurt("relight f.exr first=2 second=0.5 rest=1,0.5,0 -o mixed.exr").success();
    folder.gnurt("relight mixed.exr first=0.5 second=2 -o back.exr").success();
    let (mixed, back) = (picture("mixed.exr"), picture("back.exr"));
    let rest = |picture: &gnurt::image::Picture, channel: &str, i: usize| match &picture
        .layer("light_rest")
        .and_then(|layer| layer.channel(channel))
        .expect("the rest")
        .data
    {
        gnurt::image::ChannelData::F32(values) => values[i],
        gnurt::image::ChannelData::U32(_) => panic!("light"),
    };
    let mut differs = false;
    for (i, (a, b)) in before.color.iter().zip(&back.color).enumerate() {
        differs |= (mixed.color[i][0] - a[0]).abs() > 0.01;
        assert!((a[0] - b[0]).abs() <= 1e-4 * a[0].abs().max(1.0), "red comes back");
        let blue = a[2] - rest(&before, "B", i);
        assert!((blue - b[2]).abs() <= 1e-4 * blue.abs().max(1.0), "but not what became black");
    }
    assert!(differs, "gains count");
    folder.gnurt("relight f.exr first=0 -o dark.png").success();
    folder.gnurt(&format!("{ROOM} -o g.0001.exr")).success();
    folder.gnurt("relight g.####.exr first=2 -o h.####.png").success();
    assert!(folder.at("h.0001.png").exists(), "films");
}

#[test]
fn mistakes_are_told() {
    let folder = Folder::new();
    folder.gnurt(&format!("{ROOM} -o f.exr")).success();
    folder
        .gnurt("relight f.exr frist=2 -o o.png")
        .fails(1, "unknown light group 'frist'; valid are: first, second");
    folder.gnurt("relight f.exr first -o o.png").fails(2, "give a group and its gain");
    folder.gnurt("relight f.exr first=-1 -o o.png").fails(2, "give a group and its gain");
    folder.gnurt("relight f.exr first=1 -o f.exr").fails(2, "the same file");
    folder.gnurt("render builtin:cornell -r 8x8 --spp 1 -o plain.exr").success();
    folder.gnurt("relight plain.exr first=1 -o o.png").fails(1, "no light groups");
    folder.gnurt("relight missing.exr first=1 -o o.png").fails(1, "missing.exr");
    folder.gnurt("relight g.####.exr first=1 -o o.####.png").fails(1, "no file has such a name");
    assert!(!folder.at("o.png").exists(), "nothing was written");
}
