// SPDX-License-Identifier: GPL-3.0-or-later
//! The filter over the frames of `gnurt render --frames`, and the layer of motion.

use gnurt::image::{ChannelData, Picture};

use super::animation::animated;
use super::harness::Folder;

const SMALL: &str = "-r 24x16 --spp 4 -t 2 -q --integrator path";

#[test]
fn frames_borrow_and_continue_with_the_same_bytes() {
    let folder = Folder::new();
    animated(&folder);
    let film = "render a.gltf --frames 0..6 --fps 8 --denoise-window 1";
    folder.gnurt(&format!("{film} -o f.#.png {SMALL}")).success();
    folder
        .gnurt(&format!("render a.gltf --frames 0..6 --fps 8 --denoise-window 0 -o s.#.png {SMALL}"))
        .success();
    let frame = |name: &str, i: u32| folder.read(&format!("{name}.{i}.png"));
    assert!((0..7).any(|i| frame("f", i) != frame("s", i)), "frames borrow light");
    // An interrupted film goes on as it would have.
    for i in [0, 1, 4] {
        folder.write(&format!("g.{i}.png"), "there");
    }
    folder.gnurt(&format!("{film} --skip-existing -o g.#.png {SMALL}")).success();
    for i in [2, 3, 5, 6] {
        assert!(frame("g", i) == frame("f", i), "frame {i}");
    }
    assert_eq!(frame("g", 4), b"there", "kept");
    folder.gnurt(&format!("{film} -o one.#.png -t 1 -r 24x16 --spp 4 -q --integrator path")).success();
    assert!((0..7).all(|i| frame("one", i) == frame("f", i)), "on one thread");
}

#[test]
fn motion_leads_to_the_same_surface() {
    let folder = Folder::new();
    animated(&folder);
    let line = "render a.gltf --animation slide --frames 0..2 --fps 8 --denoise=none -r 96x64 --spp 1 -q";
    folder.gnurt(&format!("{line} -o f.#.exr")).success();
    let frames: Vec<Picture> =
        (0..3).map(|i| gnurt::image::read(&folder.at(&format!("f.{i}.exr"))).expect("a picture")).collect();
    let floats = |i: usize, layer: &str, name: &str| {
        let channel = frames[i].layer(layer).and_then(|layer| layer.channel(name));
        match &channel.expect("the layer is there").data {
            ChannelData::F32(values) => values.clone(),
            ChannelData::U32(_) => panic!("floats"),
        }
    };
    let (x, y, far) = (floats(1, "motion", "Z"), floats(1, "motion", "W"), floats(1, "motion", "after"));
    let (here, there) = (floats(1, "depth", "Z"), floats(2, "depth", "Z"));
    let (mut met, mut right, mut moved) = (0, 0, 0.0_f32);
    for p in (0..96 * 64).filter(|&p| here[p].is_finite()) {
        let at = [(p % 96) as f32 + x[p], (p / 96) as f32 + y[p]].map(|x| x.round() as usize);
        if at[0] < 96 && at[1] < 64 {
            met += 1;
            right += usize::from((there[at[1] * 96 + at[0]] - far[p]).abs() < 0.05);
            moved = moved.max(x[p].abs());
        }
    }
    assert!(met > 100 && moved > 1.0, "{met} points, moved by {moved}");
    assert!(right * 100 > met * 93, "{right} of {met} points are where they should be");
}
