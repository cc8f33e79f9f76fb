// SPDX-License-Identifier: GPL-3.0-or-later
//! Picture files that cannot be read: one error line that names the file; status 2 from `diff`, 1 from `convert`.
//! Truncations and corruptions at every byte are tested in `gnurt-image`; here is the way to the user.

use super::harness::Folder;
use super::samples;

/// A folder with one small picture of each format.
fn pictures() -> Folder {
    let folder = Folder::new();
    folder.write("p.pfm", samples::pfm());
    folder.write("p.jpg", samples::jpeg());
    for format in ["png", "exr", "hdr"] {
        folder.gnurt(&format!("convert p.pfm p.{format}")).success();
    }
    folder
}

#[test]
fn good_ones_are_read() {
    let folder = pictures();
    for format in ["png", "exr", "hdr", "pfm", "jpg"] {
        folder.gnurt(&format!("diff p.{format} p.{format}")).success();
        folder.gnurt(&format!("convert p.{format} q.pfm")).success();
    }
}

#[test]
fn broken_ones_are_refused() {
    let folder = pictures();
    for format in ["png", "exr", "hdr", "pfm", "jpg"] {
        let good = folder.read(&format!("p.{format}"));
        let half = good[..good.len() / 2].to_vec();
        let head = good[..good.len().min(12)].to_vec();
        let one_short = good[..good.len() - 1].to_vec();
        let mut wrong_head = good.clone();
        wrong_head[..4].copy_from_slice(b"nope");
        let broken = [
            ("empty", Vec::new()),
            ("head", head),
            ("half", half),
            ("end", one_short),
            ("magic", wrong_head),
        ];
        for (what, bytes) in broken {
            let name = format!("{what}.{format}");
            println!("{name}");
            folder.write(&name, bytes);
            let before = folder.contents();
            folder.gnurt(&format!("diff {name} p.pfm")).fails(2, &name);
            folder.gnurt(&format!("diff p.pfm {name}")).fails(2, &name);
            folder.gnurt(&format!("convert {name} out.png")).fails(1, &name);
            assert_eq!(folder.contents(), before, "{name} left something behind");
        }
    }
}

#[test]
fn declared_sizes_are_not_believed() {
    let folder = Folder::new();
    let rows: [(&str, &[u8]); 6] = [
        ("a.pfm", b"PF\n100000 100000\n-1.0\n\0\0\0\0"),
        ("b.pfm", b"PF\n0 4\n-1.0\n"),
        ("c.pfm", b"PF\n-4 4\n-1.0\n"),
        ("d.pfm", b"PF\n99999999999999999999 1\n-1.0\n"),
        ("e.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 90000 +X 90000\n"),
        ("f.hdr", b"#?RADIANCE\n\n-Y 0 +X 0\n"),
    ];
    for (name, bytes) in rows {
        folder.write(name, bytes);
        folder.gnurt(&format!("convert {name} out.png")).fails(1, name);
        folder.gnurt(&format!("diff {name} {name}")).fails(2, name);
    }
}

#[test]
fn what_is_no_picture() {
    let folder = Folder::new();
    folder.write("p.pfm", samples::pfm());
    folder.write("text.png", "hello");
    folder.write("wide.pfm", b"PF\n3 1\n-1.0\n".iter().copied().chain([0; 36]).collect::<Vec<u8>>());
    std::fs::create_dir(folder.at("folder.png")).expect("a folder");
    for (line, status, expected) in [
        ("diff missing.png p.pfm", 2, "missing.png"),
        ("diff p.pfm missing.png", 2, "missing.png"),
        ("diff p.pfm text.png", 2, "text.png"),
        ("diff p.pfm folder.png", 2, "folder.png"),
        ("diff p.pfm /dev/zero", 2, "/dev/zero"),
        ("diff p.pfm wide.pfm", 2, "sizes differ"),
        ("convert missing.png out.png", 1, "missing.png"),
        ("convert text.png out.png", 1, "text.png"),
        ("convert folder.png out.png", 1, "folder.png"),
    ] {
        println!("gnurt {line}");
        folder.gnurt(line).fails(status, expected);
    }
}
