// SPDX-License-Identifier: GPL-3.0-or-later
//! The same arguments give the same bytes on any number of threads.

use super::harness::Folder;

#[test]
fn threads_change_no_byte() {
    let folder = Folder::new();
    for format in ["png", "pfm", "hdr"] {
        let picture = |threads: u32| {
            let name = format!("{threads}.{format}");
            let line =
                format!("render builtin:cornell -r 50x40 --spp 3 --filter gaussian -t {threads} -o {name}");
            folder.gnurt(&line).success();
            folder.read(&name)
        };
        let one = picture(1);
        assert_eq!(picture(2), one, "2 threads, {format}");
        assert_eq!(picture(7), one, "7 threads, {format}");
    }
}

/// Parts of one sequence: pieces, bands and threads give the bytes of the whole, and another picture than white noise.
#[test]
fn blue_noise_is_the_same_in_pieces() {
    let folder = Folder::new();
    let line = "render builtin:cornell -q -r 70x40 --spp 4 --denoise=none --pixel-noise";
    folder.gnurt(&format!("{line} blue -t 1 -o whole.pfm")).success();
    folder.gnurt(&format!("{line} blue -t 3 -o again.pfm")).success();
    folder.gnurt(&format!("{line} white -o white.pfm")).success();
    for piece in ["1/2", "2/2"] {
        folder.gnurt(&format!("{line} blue --piece {piece} -o p{}.exr", &piece[..1])).success();
    }
    folder.gnurt("join -q p1.exr p2.exr -o joined.pfm").success();
    let whole = folder.read("whole.pfm");
    assert_eq!(folder.read("again.pfm"), whole, "3 threads");
    assert_eq!(folder.read("joined.pfm"), whole, "two pieces");
    assert_ne!(folder.read("white.pfm"), whole, "white noise");
    let wrong = folder.gnurt(&format!("{line} bleu -o x.pfm"));
    assert_eq!(wrong.status, Some(2), "{}", wrong.stderr);
    assert!(wrong.stderr.contains("white, blue"), "{}", wrong.stderr);
}

#[test]
fn compact_trees_are_smaller_and_change_no_byte() {
    let folder = Folder::new();
    let of = |memory: &str| {
        let name = format!("{memory}.pfm");
        // Whose objects are no poses of one mesh: those share a tree, which is small as it is.
        let scene = "builtin:spheres";
        folder.gnurt(&format!("render {scene} -r 40x30 --spp 2 --memory {memory} -o {name}")).success();
        let info = folder.gnurt(&format!("info {scene} --json --tree --memory {memory}")).success();
        let info: serde_json::Value = serde_json::from_str(&info.stdout).expect("JSON");
        (folder.read(&name), info["tree"]["bytes"].as_u64().expect("a number"))
    };
    let ((fast, fast_bytes), (compact, compact_bytes)) = (of("fast"), of("compact"));
    assert_eq!(fast, compact, "the same picture");
    assert!(10 * compact_bytes < 7 * fast_bytes, "{compact_bytes} bytes, and {fast_bytes} otherwise");
}

#[test]
fn threads_change_no_pixel_of_an_exr() {
    let folder = Folder::new();
    for threads in [1, 7] {
        folder
            .gnurt(&format!("render builtin:cornell -r 50x40 --spp 2 -t {threads} -o {threads}.exr"))
            .success();
    }
    folder.gnurt("diff 1.exr 7.exr").success();
}

#[test]
fn seeds_change_the_picture() {
    let folder = Folder::new();
    for (name, seed) in [("a", "0"), ("b", "18446744073709551615")] {
        folder
            .gnurt(&format!("render builtin:cornell -r 20x20 --spp 1 --seed {seed} -o {name}.pfm"))
            .success();
    }
    assert_ne!(folder.read("a.pfm"), folder.read("b.pfm"), "another seed, another picture");
}
