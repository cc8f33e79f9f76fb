// SPDX-License-Identifier: GPL-3.0-or-later
//! C and C++ programs with librtut, built and run; what it exports. Source: original.

#[path = "../../openrt/tests/common/mod.rs"]
mod common;

use std::process::Command;

use OpenRT as _;
use common::{Workshop, built, source};

const LIBRARIES: &[&str] = &["rtut", "OpenRT"];

#[test]
fn shapes() {
    let workshop = Workshop::with(LIBRARIES);
    let binary = workshop.build("cc", "c99", &source("tests/c/shapes.c"));
    workshop.run(&binary, &[]);
}

#[test]
fn dialects() {
    let workshop = Workshop::with(LIBRARIES);
    for (compiler, standards) in
        [("cc", &["c89", "c99", "c11", "c17"][..]), ("c++", &["c++11", "c++14", "c++17", "c++20"][..])]
    {
        let program = if compiler == "cc" { "tests/c/dialect.c" } else { "tests/c/dialect.cpp" };
        for standard in standards {
            let binary = workshop.build(compiler, standard, &source(program));
            workshop.run(&binary, &[]);
        }
    }
}

#[test]
fn exports_are_the_header() {
    let header = std::fs::read_to_string(source("include/openrt/rtut.h")).expect("the header");
    let name = |rest: &str| rest.split('(').next().expect("a name before the parenthesis").to_owned();
    let mut declared: Vec<String> = header.split("RTAPIENTRY ").skip(1).map(name).collect();
    let symbols = Command::new("nm").args(["-D", "--defined-only"]).arg(built("librtut.so")).output();
    let symbols = String::from_utf8(symbols.expect("nm of binutils must be there").stdout).expect("names");
    let word = |line: &str| line.split_whitespace().nth(2).map(str::to_owned);
    let mut exported: Vec<String> = symbols.lines().filter_map(word).collect();
    declared.sort();
    exported.sort();
    assert_eq!(declared, exported, "exactly the functions of the header");
    let dynamic = Command::new("readelf").arg("-d").arg(built("librtut.so")).output().expect("readelf");
    assert!(String::from_utf8_lossy(&dynamic.stdout).contains("librtut.so.0"), "the soname");
}
