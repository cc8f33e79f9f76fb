// SPDX-License-Identifier: GPL-3.0-or-later
//! Documents that are wrong or hostile: one clear error each, soon.

use std::fmt::Write;

use crate::made::{document, generated, shader};

fn refused(text: &str, expected: &str) {
    let why = shader(text, &[], Some("n")).expect_err("it is wrong");
    assert!(why.contains(expected) && why.lines().count() == 1, "{expected}: {why}");
}

#[test]
fn broken_files_name_their_line() {
    refused("", "no element");
    refused("<materialx version=\"1.39\">\n<a>", "is not closed");
    refused("<materialx version=\"1.39\">\n<a>\n</b></materialx>", "t.mtlx:3");
    refused("<scene/>", "t.mtlx:1: <scene> is not <materialx>");
    refused("<materialx version=\"x\"/>", "'x' is not a version");
    refused("<materialx version=\"1.39\"/>\n<materialx/>", "a second root element");
    refused("<materialx version=\"1.39\"><a b=\"&lol;\"/></materialx>", "t.mtlx:1");
    for (elements, expected) in [
        ("<nonsense name=\"n\" type=\"float\"/>", "t.mtlx:3: there is no node 'nonsense'"),
        ("<add name=\"n\" type=\"string\"/>", "there is no node 'add' of type 'string'; types are"),
        ("<add name=\"n\" type=\"float\" nodedef=\"ND_x\"/>", "there is no nodedef 'ND_x'"),
        (
            "<add name=\"n\" type=\"float\"><input name=\"in1\" type=\"float\" nodename=\"m\"/></add>",
            "there is no node 'm'",
        ),
        (
            "<add name=\"n\" type=\"float\"><input name=\"in1\" type=\"float\" value=\"1, 2\"/></add>",
            "'1, 2' is not a float: it has 2 numbers",
        ),
        (
            "<add name=\"n\" type=\"float\"><input name=\"in1\" type=\"float\" value=\"inf\"/></add>",
            "'inf' is not a number",
        ),
    ] {
        refused(&document(elements), expected);
    }
}

#[test]
fn cycles_end() {
    let node = |name: &str, other: &str| {
        format!(
            "<dot name=\"{name}\" type=\"float\"><input name=\"in\" type=\"float\" nodename=\"{other}\"/></dot>"
        )
    };
    refused(&document(&format!("{}{}", node("n", "m"), node("m", "n"))), "depends on itself");
    refused(&document(&node("n", "n")), "depends on itself");
    let own = "<nodedef name=\"ND_r\" node=\"r\" inherit=\"ND_r\"><output name=\"out\" type=\"float\"/></nodedef>\
               <nodegraph name=\"NG_r\" nodedef=\"ND_r\"><r name=\"a\" type=\"float\"/>\
               <output name=\"out\" type=\"float\" nodename=\"a\"/></nodegraph><r name=\"n\" type=\"float\"/>";
    let why = generated(own, Some("n")).expect_err("it never ends");
    assert!(why.contains("more than"), "{why}");
    let own_file = document("<xi:include href=\"./t.mtlx\"/>");
    let why = shader(&own_file, &[("./t.mtlx", own_file.clone())], None).expect_err("it includes itself");
    assert!(why.contains("includes itself"), "{why}");
}

#[test]
fn long_chains_are_fine_and_longer_ones_refused() {
    let chain = |len: usize| {
        let mut elements = String::from("<constant name=\"x0\" type=\"float\"/>");
        for i in 1..=len {
            let name = if i == len { "n".to_owned() } else { format!("x{i}") };
            let _ = write!(
                elements,
                "<dot name=\"{name}\" type=\"float\"><input name=\"in\" type=\"float\" nodename=\"x{}\"/></dot>",
                i - 1
            );
        }
        document(&elements)
    };
    shader(&chain(1400), &[], Some("n")).expect("a long one");
    refused(&chain(20_000), "follow on one another");
}

#[test]
fn laughs_are_counted() {
    // Each graph uses the one before ten times.
    let mut elements = String::from(
        "<nodedef name=\"ND_l0\" node=\"l0\"><output name=\"out\" type=\"float\"/></nodedef>\
         <nodegraph name=\"NG_l0\" nodedef=\"ND_l0\"><noise3d name=\"a\" type=\"float\"/>\
         <output name=\"out\" type=\"float\" nodename=\"a\"/></nodegraph>",
    );
    for level in 1..12 {
        let _ = write!(
            elements,
            "<nodedef name=\"ND_l{level}\" node=\"l{level}\"><output name=\"out\" type=\"float\"/></nodedef>\
             <nodegraph name=\"NG_l{level}\" nodedef=\"ND_l{level}\">"
        );
        for i in 0..10 {
            let _ = write!(
                elements,
                "<l{0} name=\"u{i}\" type=\"float\"/><add name=\"s{i}\" type=\"float\">\
                 <input name=\"in1\" type=\"float\" nodename=\"u{i}\"/>",
                level - 1
            );
            if i > 0 {
                let _ = write!(elements, "<input name=\"in2\" type=\"float\" nodename=\"s{}\"/>", i - 1);
            }
            elements.push_str("</add>");
        }
        elements.push_str("<output name=\"out\" type=\"float\" nodename=\"s9\"/></nodegraph>");
    }
    elements.push_str("<l11 name=\"n\" type=\"float\"/>");
    refused(&document(&elements), "expands to more than");
    let entities = "<?xml version=\"1.0\"?><!DOCTYPE l [<!ENTITY a \"ha\"><!ENTITY b \"&a;&a;\">]>\
                    <materialx version=\"1.39\"><a name=\"&b;\"/></materialx>";
    refused(entities, "t.mtlx:1");
}

#[test]
fn nesting_ends() {
    let mut deep = String::from("<materialx version=\"1.39\">");
    while deep.len() < 2 << 20 {
        deep.push_str("<nodegraph>");
    }
    refused(&deep, "nested deeper than 64");
    let mut many = String::from("<materialx version=\"1.39\">");
    while many.len() < 2 << 20 {
        many.push_str("<a/>");
    }
    refused(&many, "more than 262144 elements");
    let tokens = "<image name=\"n\" type=\"color3\"><token name=\"t\" type=\"string\" value=\"[t][t][t][t][t][t][t][t]\"/>\
                  <input name=\"file\" type=\"filename\" value=\"[t]\"/></image>";
    generated(tokens, Some("n")).expect("tokens within themselves stay");
}
