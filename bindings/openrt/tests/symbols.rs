// SPDX-License-Identifier: GPL-3.0-or-later
//! The library exports exactly the functions that openrt/rt.h declares, under its run-time name.

mod common;

use std::collections::BTreeSet;
use std::process::Command;

fn output_of(tool: &str, arguments: &[&str]) -> String {
    let output = Command::new(tool).args(arguments).arg(common::library()).output();
    let output = output.unwrap_or_else(|error| panic!("{tool} of binutils must be there: {error}"));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn exports_are_the_header() {
    let header = std::fs::read_to_string(common::source("include/openrt/rt.h")).expect("the header");
    let declared: BTreeSet<&str> = header
        .split("RTAPIENTRY ")
        .skip(1)
        .map(|rest| rest.split('(').next().expect("a name before the parenthesis"))
        .collect();
    let symbols = output_of("nm", &["-D", "--defined-only"]);
    let exported: BTreeSet<&str> =
        symbols.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    let missing: Vec<_> = declared.difference(&exported).collect();
    let extra: Vec<_> = exported.difference(&declared).collect();
    assert!(declared.len() > 190, "the header was read: {} functions", declared.len());
    assert!(missing.is_empty(), "declared but not exported: {missing:?}");
    assert!(extra.is_empty(), "exported but not declared: {extra:?}");
}

#[test]
fn run_time_name() {
    let dynamic = output_of("readelf", &["-d"]);
    assert!(dynamic.contains("libOpenRT.so.0"), "the soname is libOpenRT.so.0:\n{dynamic}");
}

/// Functions that a text declares: names before a parenthesis that begin with rt and a capital.
fn functions(text: &str) -> BTreeSet<String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let before = |part: &str| part.rsplit(|c| !is_part(c)).next().unwrap_or_default().to_owned();
    let parts: Vec<&str> = text.split('(').collect();
    let names = parts[..parts.len() - 1].iter().map(|part| before(part));
    names.filter(|name| name.starts_with("rt") && name.len() > 2 && !name[2..3].contains('_')).collect()
}

#[test]
fn the_reference_has_every_function() {
    let read =
        |path: &str| std::fs::read_to_string(common::source(path)).unwrap_or_else(|e| panic!("{path}: {e}"));
    let declared: BTreeSet<String> = ["include/openrt/rt.h", "../rtut/include/openrt/rtut.h"]
        .iter()
        .flat_map(|path| {
            let header = read(path);
            let declarations = header.split("RTAPIENTRY ").skip(1);
            declarations.map(|rest| rest.split('(').next().unwrap_or_default().to_owned()).collect::<Vec<_>>()
        })
        .collect();
    let reference = read("../../docs/reference/openrt-calls.md");
    // Synopses are the fenced parts.
    let synopses: String = reference.split("```").skip(1).step_by(2).collect();
    let explained = functions(&synopses);
    let missing: Vec<_> = declared.difference(&explained).collect();
    let extra: Vec<_> = explained.difference(&declared).collect();
    assert!(missing.is_empty(), "not in docs/reference/openrt-calls.md: {missing:?}");
    assert!(extra.is_empty(), "in docs/reference/openrt-calls.md, but in no header: {extra:?}");
}

/// Words without marks and line ends, in which the header and the page agree.
fn plain(text: &str) -> String {
    let without_marks: String = text.chars().filter(|c| !"`*\\".contains(*c)).collect();
    let without_links = without_marks.replace("[openrt.md](openrt.md)", "openrt.md");
    without_links.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The page's text below the synopsis of a function.
fn explanation(reference: &str, function: &str) -> String {
    let mut places = reference.match_indices("```c\n").map(|(at, fence)| &reference[at + fence.len()..]);
    let call = format!("{function}(");
    let below = places.find_map(|rest| {
        let (synopsis, below) = rest.split_once("```")?;
        let is_named = synopsis.split([' ', '*']).any(|token| token.starts_with(&call));
        is_named.then_some(below)
    });
    let below = below.unwrap_or_else(|| panic!("{function} has a synopsis"));
    plain(below.split("\n## ").next().and_then(|part| part.split("\n### ").next()).unwrap_or_default())
}

/// The page follows the header, sentence by sentence.
#[test]
fn the_reference_says_what_the_header_says() {
    let read = |path: &str| std::fs::read_to_string(common::source(path)).expect("it is there");
    let (header, reference) = (read("include/openrt/rt.h"), read("../../docs/reference/openrt-calls.md"));
    let (mut sentences, mut missing) = (0, Vec::new());
    for comment in header.split("/*").skip(1) {
        let Some((message, declarations)) = comment.split_once("*/") else { continue };
        let Some(first) = declarations.trim_start().strip_prefix("RTAPI ") else { continue };
        let name = first.split("RTAPIENTRY ").nth(1).and_then(|rest| rest.split('(').next());
        let name = name.expect("a function's name");
        let explained = explanation(&reference, name);
        let message = plain(message);
        // Ends of sentences and of their parts: the page has errors in a paragraph of their own.
        for sentence in
            message.split(". ").flat_map(|part| part.split("; ")).flat_map(|part| part.split(": "))
        {
            let sentence = sentence.trim_end_matches(['.', ';', ':']);
            sentences += 1;
            if !explained.contains(sentence) {
                missing.push(format!("{name}: {sentence}"));
            }
        }
    }
    assert!(sentences > 200, "the header was read: {sentences} sentences");
    assert!(missing.is_empty(), "docs/reference/openrt-calls.md does not say:\n{}", missing.join("\n"));
}
