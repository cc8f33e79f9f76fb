// SPDX-License-Identifier: GPL-3.0-or-later
//! Dictionaries: queries, values, and invalid XML.

use gnurt_sl_lib::dictionary::*;
use gnurt_sl_lib::text::{stof, stoi};
use proptest::prelude::*;

const CAMERAS: &str = r#"<?xml version="1.0"?><!DOCTYPE set [ <!ELEMENT a> ]>
<set><!-- two packs -->
  <pack name="first" sides="1"><camera name="a &lt;main&gt;"><form matrix="1.5 2, -3
4"/></camera><image channel='color'/></pack>
  <pack name="second" sides="0"><camera name="b"/><image channel="color"/><image channel="bump"/><note>A <b>bold</b> word</note></pack>
  <raw><![CDATA[<no & tag>]]></raw>
</set>"#;

fn all(dictionaries: &mut Dictionaries, query: &str) -> Vec<String> {
    let mut node = dictionaries.find(CAMERAS, query, |_| None).unwrap_or_else(|error| panic!("{error}"));
    let mut names = Vec::new();
    while node != 0 {
        let name = ["name", "channel", "matrix", ""].iter().find_map(|a| dictionaries.value(node, a));
        names.push(name.unwrap_or("?").to_owned());
        node = dictionaries.next(node);
    }
    names
}

#[test]
fn paths_find_what_they_say() {
    let mut dictionaries = Dictionaries::default();
    let known: [(&str, &[&str]); 21] = [
        ("//pack", &["first", "second"]),
        ("/set/pack", &["first", "second"]),
        ("set/pack[2]", &["second"]),
        ("//pack[last()]/image", &["color", "bump"]),
        ("//image[1]", &["color", "color"]),
        ("//pack[@sides='0']/camera", &["b"]),
        ("//pack[@sides != \"0\"]", &["first"]),
        ("//pack[note]", &["second"]),
        ("//pack[@name='first' and @sides='1']", &["first"]),
        ("//pack[@name='x' or @sides='1']", &["first"]),
        ("//camera/..", &["first", "second"]),
        ("//image/../camera", &["a <main>", "b"]),
        ("//pack/*[2]", &["color", "color"]),
        ("//form", &["1.5 2, -3\n4"]),
        ("//raw/text()", &["<no & tag>"]),
        ("//note/text()", &["A ", " word"]),
        ("//note[.='A bold word']/b/text()", &["bold"]),
        ("//camera | //image[@channel='bump']", &["a <main>", "b", "bump"]),
        ("//nothing", &[]),
        ("pack", &[]),
        ("//pack//form", &["1.5 2, -3\n4"]),
    ];
    for (query, expected) in known {
        assert_eq!(all(&mut dictionaries, query), expected, "{query}");
        assert_eq!(all(&mut dictionaries, query), expected, "{query}, asked again");
    }
    for query in ["", "//", "//pack[", "//pack[@sides=]", "count(//pack)", "a b", "//pack]"] {
        let error = dictionaries.find(CAMERAS, query, |_| None).expect_err(query);
        assert!(error.result() == 0 && error.to_string().contains(&format!("'{query}'")), "{error}");
    }
}

#[test]
fn values_become_numbers() {
    let mut dictionaries = Dictionaries::default();
    let pack = dictionaries.find(CAMERAS, "//pack", |_| None).expect("a query");
    let form = dictionaries.find_from(pack, "camera/form").expect("a query");
    assert_eq!(dictionaries.find_from(pack, "image/nothing"), Ok(0));
    let mut row = [9.0; 5];
    numbers(dictionaries.value(form, "matrix").expect("an attribute"), &mut row, stof);
    assert_eq!(row, [1.5, 2.0, -3.0, 4.0, 0.0]);
    let mut sides = [7];
    numbers(dictionaries.value(pack, "sides").expect("an attribute"), &mut sides, stoi);
    assert_eq!(sides, [1]);
    assert_eq!(
        [dictionaries.value(pack, "none"), dictionaries.value(99, "name"), dictionaries.value(-1, "name")],
        [None; 3]
    );
    assert_eq!([dictionaries.next(0), dictionaries.next(-5), dictionaries.next(1000)], [0; 3]);
    assert_eq!(dictionaries.find_from(1000, "x"), Ok(0));
}

#[test]
fn files_are_read_once_and_faults_are_told_once() {
    let mut dictionaries = Dictionaries::default();
    let load = |_: &str| Some("<a><b/></a>".to_owned());
    assert_eq!(dictionaries.find("there.xml", "a/b", load), Ok(1));
    assert_eq!(dictionaries.find("there.xml", "a/b", |_| None), Ok(1), "not read again");
    let error = dictionaries.find("noexist.xml", "foo", |_| None).expect_err("no such file");
    assert_eq!(
        (error.result(), error.to_string().as_str()),
        (-1, "XML parsed with errors: File was not found, at offset 0")
    );
    assert_eq!(dictionaries.find("noexist.xml", "foo", |_| None), Ok(-1), "told once");
    let wrong = [
        "<a>",
        "<a></b>",
        "</a>",
        "<a b></a>",
        "<a b=c/>",
        "<a b='c/>",
        "<",
        "<a",
        "<!-- x",
        "<![CDATA[ x",
        "<?x",
        "<!DOCTYPE [",
        "",
        "text only",
        "<a></a",
        "<a></a x>",
    ];
    for text in wrong {
        assert_eq!(dictionaries.find(text, "a", |_| None).map_err(|error| error.result()), Err(-1), "{text}");
    }
    let deep = "<a>".repeat(50_000) + &"</a>".repeat(50_000);
    assert!(dictionaries.find(&deep, "//a//a//a[last()]", |_| None).is_ok(), "no deep recursion");
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(text in "[<>/a-c='\" &;!?\\[\\]-]{0,24}", query in "[/a-c@*.\\[\\]='|() 1]{0,12}") {
        let mut dictionaries = Dictionaries::default();
        let _ = dictionaries.find(&text, &query, |_| None);
        let _ = dictionaries.find("<a><b c='1'/><b/></a>", &query, |_| None);
    }
}

/// Ends of entities are not looked for in all of the text.
#[test]
fn texts_of_signs_alone_are_read_once() {
    let text = format!("<set><a b='{}'/></set>", "&".repeat(1 << 20));
    let start = std::time::Instant::now();
    let mut dictionaries = Dictionaries::default();
    let node = dictionaries.find(&text, "//a", |_| None).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(dictionaries.value(node, "b").map(str::len), Some(1 << 20), "they stay");
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}
