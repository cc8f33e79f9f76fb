// SPDX-License-Identifier: GPL-3.0-or-later
//! The library exports exactly the functions that openrt/rt.h declares, under its run-time name. Source: original.

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

/// Functions that a text declares: what stands before a parenthesis and begins with rt and a capital.
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
    let reference = read("../../docs/openrt-reference.md");
    // Synopses are the fenced parts.
    let synopses: String = reference.split("```").skip(1).step_by(2).collect();
    let explained = functions(&synopses);
    let missing: Vec<_> = declared.difference(&explained).collect();
    let extra: Vec<_> = explained.difference(&declared).collect();
    assert!(missing.is_empty(), "not in docs/openrt-reference.md: {missing:?}");
    assert!(extra.is_empty(), "in docs/openrt-reference.md, but in no header: {extra:?}");
}
