// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt denoise`: finished pictures and films, and names of other renderers.

use gnurt::image::{Picture, WriteOptions};

use super::animation::animated;
use super::harness::Folder;

const SMALL: &str = "-r 24x16 --spp 4 -t 2 -q --integrator path";

fn picture(folder: &Folder, name: &str) -> Picture {
    gnurt::image::read(&folder.at(name)).expect("a picture")
}

fn apart(a: &Picture, b: &Picture) -> f64 {
    gnurt::image::compare(a, b).expect("of one size").rel_mse
}

#[test]
fn finished_frames_are_filtered_as_those_that_are_rendered() {
    let folder = Folder::new();
    animated(&folder);
    let film = format!("render a.gltf --frames 0..4 --fps 8 {SMALL}");
    folder.gnurt(&format!("{film} --denoise=none --layers denoise -o noisy.#.exr")).success();
    folder.gnurt(&format!("{film} --denoise=built-in --denoise-window 2 -o direct.#.exr")).success();
    folder.gnurt("denoise -q noisy.#.exr --denoise-window 2 -o later.#.exr").success();
    folder.gnurt("denoise -q noisy.#.exr --denoise-window 0 -o single.#.exr").success();
    let mut alone = 0.0;
    for i in 0..5 {
        let [noisy, direct, later, single] =
            ["noisy", "direct", "later", "single"].map(|name| picture(&folder, &format!("{name}.{i}.exr")));
        let [far, near] = [apart(&direct, &noisy), apart(&direct, &later)];
        assert!(near <= 0.02 * far, "frame {i}: {near} of {far}; files keep less than memory");
        alone += apart(&single, &later);
    }
    assert!(alone > 0.0, "frames borrow light");
    folder.gnurt("denoise -q noisy.#.exr --frames 1..2 -o some.#.png").success();
    assert!(folder.at("some.1.png").exists() && !folder.at("some.0.png").exists(), "those frames");
    folder.gnurt("denoise -q noisy.2.exr -o one.exr").success();
    assert!(
        apart(&picture(&folder, "one.exr"), &picture(&folder, "single.2.exr")) == 0.0,
        "a single picture"
    );
}

#[test]
fn files_of_cycles_are_known_by_their_names() {
    let folder = Folder::new();
    let scene = "render builtin:cornell -r 48x36 --integrator path -q --denoise=none";
    folder.gnurt(&format!("{scene} --spp 4 -o noisy.exr")).success();
    folder.gnurt(&format!("{scene} --spp 512 -o truth.exr")).success();
    let mut foreign = picture(&folder, "noisy.exr");
    foreign.drop_background();
    foreign.layers.retain(|layer| ["albedo", "N"].contains(&&*layer.name));
    for layer in &mut foreign.layers {
        let name = if layer.name == "N" { "Normal" } else { "Albedo" };
        layer.name = format!("ViewLayer.Denoising {name}");
    }
    let write = |picture: &Picture, name: &str| {
        gnurt::image::write(picture, &folder.at(name), &WriteOptions::default()).expect("a file");
    };
    write(&foreign, "cycles.exr");
    let run = folder.gnurt("denoise -v cycles.exr -o clean.exr").success();
    assert!(run.stderr.contains("albedo from 'ViewLayer.Denoising Albedo'"), "{}", run.stderr);
    let [truth, noisy, clean] = ["truth.exr", "noisy.exr", "clean.exr"].map(|name| picture(&folder, name));
    let (before, after) = (apart(&noisy, &truth), apart(&clean, &truth));
    // A fifth with the variance that our own files have.
    assert!(after < 0.5 * before, "{after} of {before}");
    foreign.layers.clear();
    write(&foreign, "bare.exr");
    folder.gnurt("denoise bare.exr -o no.exr").fails(1, "bare.exr: the picture has no channel 'variance.R'");
    assert!(!folder.at("no.exr").exists(), "nothing is written");
}

#[test]
fn mistakes_are_told_before_work() {
    let folder = Folder::new();
    folder.gnurt("denoise f.#.exr -o f.exr").fails(2, "mark the number by #");
    folder.gnurt("denoise f.#.exr -o g.#.exr").fails(1, "no file has such a name");
    folder.gnurt("denoise a.exr --denoise-window 2 -o b.exr").fails(2, "is one picture");
    folder.gnurt("denoise a.exr --denoise=none -o b.exr").fails(2, "gnurt convert");
    folder.gnurt("denoise a.exr -o a.exr").fails(2, "the same file");
    folder.gnurt("denoise a.exr -o b.exr").fails(1, "a.exr");
}
