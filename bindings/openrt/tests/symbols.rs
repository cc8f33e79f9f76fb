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
