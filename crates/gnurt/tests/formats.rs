// SPDX-License-Identifier: GPL-3.0-or-later
//! The tables of formats, compared with the page and the README that list them.

use gnurt::FORMATS;
use gnurt::image::PictureFormat;

fn page(path: &str) -> String {
    let path = format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn row(name: &str, extensions: &[&str], read: &str, written: &str, notes: &str) -> String {
    let extensions: Vec<_> = extensions.iter().map(|e| format!("`.{e}`")).collect();
    format!("| {name} ({}) | {read} | {written} | {notes} |\n", extensions.join(", "))
}

#[test]
fn the_page_lists_the_tables() {
    let word = |is_there: bool, is_whole: bool| match (is_there, is_whole) {
        (false, _) => "no",
        (true, false) => "partly",
        (true, true) => "yes",
    };
    let scenes: String = FORMATS
        .iter()
        .map(|format| {
            let read = word(format.read.is_some(), format.read_whole);
            let written = word(format.write.is_some(), format.write.is_some_and(|w| w.is_whole));
            row(format.name, format.extensions, read, written, format.notes)
        })
        .collect();
    let pictures: String = PictureFormat::ALL
        .iter()
        .map(|format| {
            let (read, written) = (word(true, format.is_whole), word(format.is_written(), true));
            row(format.name, format.extensions, read, written, format.notes)
        })
        .collect();
    let page = page("docs/reference/formats.md");
    for rows in [scenes, pictures] {
        assert!(page.contains(&rows), "docs/reference/formats.md must have these rows:\n{rows}");
    }
}

#[test]
#[cfg(not(feature = "usd"))]
fn what_is_not_compiled_says_how_to_get_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.usda");
    let missing = gnurt::load_scene(&file).expect_err("there is no file").to_string();
    assert!(missing.contains("no such file"), "{missing}");
    std::fs::write(&file, "#usda 1.0\n").expect("it can be written");
    let read = gnurt::load_scene(&file).expect_err("it was not compiled").to_string();
    let scene = gnurt::load_scene("builtin:cornell").expect("it is built in").scene;
    let written = FORMATS.save(&scene, &file).expect_err("it was not compiled").to_string();
    for message in [read, written] {
        assert!(message.contains("without USD") && message.contains("--features usd"), "{message}");
    }
}

#[test]
fn extensions_are_listed_and_found() {
    let listed = FORMATS.read_extensions();
    for extension in listed.split(", ") {
        let name = format!("scene{extension}");
        let format = FORMATS.of(name.as_ref()).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(format.read.is_some(), "{name} can be read");
    }
    let error = FORMATS.of("scene.blend".as_ref()).expect_err("no such format").to_string();
    let all_but_last = listed.rsplit_once(", ").map_or(&*listed, |(all, _)| all);
    assert!(error.contains(all_but_last), "the message lists them: {error}");
}
