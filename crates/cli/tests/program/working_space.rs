// SPDX-License-Identifier: GPL-3.0-or-later
//! `--working-space`, `--primaries`, `--tile-size`: colours against closed forms, by materials of a file and by shaders.

use gnurt::image::{WorkingSpace, convert, read};

use super::harness::Folder;

const LIGHT: [f32; 3] = [0.2, 1.0, 3.0];
const ALBEDO: [f32; 3] = [0.8, 0.2, 0.1];

/// A floor that fills the picture.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.obj", "mtllib a.mtl\nusemtl red\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nv -9 0 -9\nf 1 2 3 4\n");
    folder.write("a.mtl", "newmtl red\nKd 0.8 0.2 0.1\n");
    folder.write("red.osl", "surface red () { Ci = color (0.8, 0.2, 0.1) * diffuse (N); }");
    folder.write("weighted.osl", "surface weighted (color c = 1) { Ci = c[0] * oren_nayar_diffuse_bsdf (N, color (0.8, 0.2, 0.1), 0.0); }");
    folder.write("shines.osl", "surface shines () { Ci = color (0.2, 1, 3) * emission (); }");
    folder
}

const RENDER: &str =
    "render a.obj -q -r 8x8 --spp 64 --eye 0,2,0.1 --target 0,0,0 --fov 5 --environment 0.2,1,3";

fn mean(folder: &Folder, file: &str) -> [f32; 3] {
    let picture = read(&folder.at(file)).expect("a picture");
    let count = picture.color.len() as f32;
    [0, 1, 2].map(|k| picture.color.iter().map(|pixel| pixel[k]).sum::<f32>() / count)
}

fn expected(space: WorkingSpace) -> [f32; 3] {
    let map = |rows: Option<[[f32; 3]; 3]>, color| rows.map_or(color, |rows| convert(&rows, color));
    let (a, b) = (map(space.from_rec709(), ALBEDO), map(space.from_rec709(), LIGHT));
    map(space.to_rec709(), [a[0] * b[0], a[1] * b[1], a[2] * b[2]])
}

#[track_caller]
fn assert_near(found: [f32; 3], expected: [f32; 3], what: &str) {
    let is_near = found.into_iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.01 + 0.01 * b.abs());
    assert!(is_near, "{what}: {found:?}, {expected:?}");
}

#[test]
fn light_is_multiplied_in_the_space() {
    let folder = folder();
    for space in WorkingSpace::ALL {
        for shader in ["", "--shader red=red.osl", "--shader red=weighted.osl"] {
            folder.gnurt(&format!("{RENDER} --working-space {space} {shader} -o p.exr")).success();
            assert_near(mean(&folder, "p.exr"), expected(space), &format!("{space} {shader}"));
        }
        folder.gnurt(&format!("{RENDER} --working-space {space} --shader red=shines.osl -o p.exr")).success();
        assert_near(mean(&folder, "p.exr"), LIGHT, &format!("{space}: emission"));
    }
    // Pictures for screens.
    let line = format!("{RENDER} --working-space acescg --exposure 0 --tone clamp --denoise=none");
    folder.gnurt(&format!("{line} -o p.png")).success();
    let shown = mean(&folder, "p.png");
    assert_near(shown, expected(WorkingSpace::AcesCg).map(|x| x.clamp(0.0, 1.0)), "sRGB");
}

#[test]
fn files_state_their_primaries() {
    let folder = folder();
    let states = |file: &str, space: WorkingSpace| {
        let bytes = std::fs::read(folder.at(file)).expect("a file");
        let red = space.chromaticities().primaries[0][0].to_le_bytes();
        let name = b"chromaticities\0chromaticities\0\x20\0\0\0";
        bytes.windows(name.len() + 4).any(|some| some.starts_with(name) && some.ends_with(&red))
    };
    folder.gnurt(&format!("{RENDER} --working-space acescg -o wide.exr")).success();
    assert!(states("wide.exr", WorkingSpace::AcesCg), "those of the working space");
    folder.gnurt(&format!("{RENDER} --working-space acescg --primaries rec709 -o p.exr")).success();
    assert!(states("p.exr", WorkingSpace::Rec709), "as requested");
    folder.gnurt("convert wide.exr p.exr --tile-size 16").success();
    assert!(states("p.exr", WorkingSpace::Rec709), "of a picture that was read");
    assert_near(mean(&folder, "p.exr"), mean(&folder, "wide.exr"), "the same colours");
    let bytes = std::fs::read(folder.at("p.exr")).expect("a file");
    assert_ne!(bytes[5] & 2, 0, "tiles");
    folder.gnurt("convert p.exr back.exr --primaries acescg").success();
    assert!(states("back.exr", WorkingSpace::AcesCg), "by request");
    let idle = folder.gnurt("convert p.exr p.png --primaries acescg --tile-size 32").success();
    for option in ["--tile-size", "--primaries"] {
        let expected = format!("{option} has no effect except on EXR");
        assert!(idle.stderr.contains(&expected), "{}", idle.stderr);
    }
}

#[test]
fn wrong_values_name_right_ones() {
    let folder = folder();
    for (option, right) in [
        ("--working-space aces", "acescg"),
        ("--primaries p3", "valid are: rec709, acescg"),
        ("--tile-size 8", "from 16 to 16384"),
    ] {
        folder.gnurt(&format!("{RENDER} {option} -o p.exr")).fails(2, right);
    }
}

#[test]
fn pieces_and_views_have_the_same_colours() {
    let folder = folder();
    let line = format!("{RENDER} --working-space acescg");
    for (file, denoise) in [("p.exr", "--denoise=none"), ("clean.exr", "--denoise=built-in")] {
        folder.gnurt(&format!("{line} {denoise} -o {file}")).success();
        for piece in ["1/2", "2/2"] {
            folder.gnurt(&format!("{line} --piece {piece} -o {}.exr", &piece[..1])).success();
        }
        folder.gnurt(&format!("join -q 1.exr 2.exr {denoise} -o joined.exr")).success();
        let [whole, joined] = [file, "joined.exr"].map(|file| read(&folder.at(file)).expect("a picture"));
        assert_eq!(whole.color, joined.color, "{file}: joined as rendered");
        assert_near(mean(&folder, "joined.exr"), expected(WorkingSpace::AcesCg), file);
    }
    folder.gnurt(&format!("{RENDER} --piece 1/2 -o 1.exr")).success();
    folder.gnurt("join -q 1.exr 2.exr -o joined.exr").fails(1, "is of another picture");
    let line = line.replacen("render", "view", 1);
    for more in ["", "--frames 2 --orbit 0.01 --spp 1", "--rest 1"] {
        folder.gnurt(&format!("{line} --headless {more} -o v.exr")).success();
        assert_near(mean(&folder, "v.exr"), expected(WorkingSpace::AcesCg), &format!("view {more}"));
    }
}
