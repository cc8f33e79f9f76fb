// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt manuals`: a page for each command that the help lists, and completions that know them.

use std::path::Path;

use super::harness::Folder;

#[test]
fn every_command_has_a_page() {
    let folder = Folder::new();
    folder.gnurt("manuals new/folder").success();
    let read = |name: &str| String::from_utf8(folder.read(&format!("new/folder/{name}"))).expect("text");
    for command in ["render", "view", "info", "diff", "convert", "trace", "bench", "bench-rays", "scenes"] {
        let page = read(&format!("gnurt-{command}.1"));
        assert!(
            page.contains(".SH SYNOPSIS") && page.contains(".SH OPTIONS"),
            "{command} has a page:\n{page}"
        );
    }
    assert!(read("gnurt.1").contains("render"), "the first page names the others");
    for from in ["gnurt.1", "gnurt-bench.1"] {
        let page = read(from).replace("\\-", "-");
        for named in page.lines().filter_map(|line| line.strip_suffix("(1)")) {
            assert!(
                folder.at(&format!("new/folder/{named}.1")).exists(),
                "{from} sends its readers to {named}"
            );
        }
    }
    let render = read("gnurt-render.1");
    for arguments_given in ["Also write a heat map", "Maximum depth"] {
        assert!(
            render.contains(arguments_given),
            "the page says what options do that the short help leaves out: {arguments_given}"
        );
    }
    assert!(!folder.at("new/folder/gnurt-manuals.1").exists(), "it is not for everybody");
    for name in ["gnurt.bash", "_gnurt", "gnurt.fish"] {
        assert!(read(name).contains("render"), "{name} knows the commands");
    }
    let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/command-line.md");
    let known = std::fs::read_to_string(&reference).unwrap_or_default();
    assert!(
        known == read("command-line.md"),
        "docs/reference/command-line.md differs from the options; `gnurt manuals DIR` writes it anew"
    );
    folder.write("file", "");
    folder.gnurt("manuals file/below").fails(1, "cannot write to file/below");
}
