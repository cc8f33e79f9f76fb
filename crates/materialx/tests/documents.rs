// SPDX-License-Identifier: GPL-3.0-or-later
//! Documents: graphs, interfaces, own definitions, includes, namespaces, prefixes, tokens, former versions, materials.

use std::path::Path;

use gnurt_materialx::Document;

use crate::made::{compiled, document, generated, shader, value};

const GRAPH: &str = "<nodegraph name=\"g\">\
    <input name=\"k\" type=\"float\" value=\"3\"/>\
    <multiply name=\"m\" type=\"float\"><input name=\"in1\" type=\"float\" interfacename=\"k\"/>\
    <input name=\"in2\" type=\"float\" value=\"2\"/></multiply>\
    <output name=\"out\" type=\"float\" nodename=\"m\"/></nodegraph>";

#[test]
fn graphs_have_interfaces() {
    let user = "<add name=\"n\" type=\"float\"><input name=\"in1\" type=\"float\" nodegraph=\"g\" output=\"out\"/>\
                <input name=\"in2\" type=\"float\" value=\"0.5\"/></add>";
    assert_eq!(value(&format!("{GRAPH}{user}"), "n"), 6.5);
    assert_eq!(value(GRAPH, "g/out"), 6.0);
    let made = generated(&format!("{GRAPH}{user}"), Some("n")).expect("a shader");
    for parameter in ["float g_k = 3.0", "float g_m_in2 = 2.0", "float in2 = 0.5"] {
        assert!(made.text.contains(parameter), "{parameter}\n{}", made.text);
    }
}

#[test]
fn own_definitions_are_used() {
    let own = "<nodedef name=\"ND_twice\" node=\"twice\"><input name=\"x\" type=\"float\" value=\"4\"/>\
               <output name=\"out\" type=\"float\"/></nodedef>\
               <nodedef name=\"ND_twice2\" node=\"twice\" inherit=\"ND_twice\" version=\"2\" isdefaultversion=\"true\">\
               <input name=\"y\" type=\"float\" value=\"1\"/></nodedef>\
               <nodegraph name=\"NG_twice\" nodedef=\"ND_twice\"><add name=\"a\" type=\"float\">\
               <input name=\"in1\" type=\"float\" interfacename=\"x\"/><input name=\"in2\" type=\"float\" interfacename=\"x\"/>\
               </add><output name=\"out\" type=\"float\" nodename=\"a\"/></nodegraph>\
               <nodegraph name=\"NG_twice2\" nodedef=\"ND_twice2\"><add name=\"a\" type=\"float\">\
               <input name=\"in1\" type=\"float\" interfacename=\"x\"/><input name=\"in2\" type=\"float\" interfacename=\"y\"/>\
               </add><output name=\"out\" type=\"float\" nodename=\"a\"/></nodegraph>";
    let by = |attribute: &str| format!("{own}<twice name=\"n\" type=\"float\" {attribute}/>");
    assert_eq!(value(&by(""), "n"), 5.0, "the default version");
    assert_eq!(value(&by("nodedef=\"ND_twice\""), "n"), 8.0);
}

#[test]
fn files_are_included_with_their_namespaces() {
    let inner = "<materialx version=\"1.38\" namespace=\"in\"><constant name=\"c\" type=\"float\">\
                 <input name=\"value\" type=\"float\" value=\"9\"/></constant>\
                 <surfacematerial name=\"M\" type=\"material\"/></materialx>";
    let outer = document(
        "<xi:include href=\"sub/inner.mtlx\"/><dot name=\"n\" type=\"float\">\
                          <input name=\"in\" type=\"float\" nodename=\"in:c\"/></dot>",
    );
    let files = [("sub/inner.mtlx", inner.to_owned())];
    let made = shader(&outer, &files, Some("n")).expect("a shader");
    assert!(made.text.contains("= 9.0"), "{}", made.text);
    let mut load = |_: &Path| Ok(inner.to_owned());
    let read = Document::of_text(Path::new("t.mtlx"), &outer, &mut load).expect("a document");
    assert_eq!(read.materials(), ["in:M"]);
    assert_eq!(read.paths().count(), 2);
    let why = shader(&outer, &[], Some("n")).expect_err("no file");
    assert!(why.starts_with("t.mtlx:3: xi:include of 'sub/inner.mtlx'"), "{why}");
}

#[test]
fn names_of_files_have_prefixes_and_tokens() {
    let text = "<nodegraph name=\"g\" fileprefix=\"maps/\"><token name=\"Res\" type=\"string\" value=\"2k\"/>\
                <image name=\"i\" type=\"color3\"><input name=\"file\" type=\"filename\" value=\"wood_[Res].png\" \
                colorspace=\"srgb_texture\"/></image><output name=\"out\" type=\"color3\" nodename=\"i\"/></nodegraph>";
    let made = generated(text, None).expect("a shader");
    let wanted = ["string i_file = \"maps/wood_2k.png\"", "\"colorspace\", \"srgb\""];
    assert!(wanted.iter().all(|part| made.text.contains(part)), "{}", made.text);
    let raw = generated(&text.replace("colorspace=\"srgb_texture\"", ""), None).expect("a shader");
    assert!(raw.text.contains("\"colorspace\", \"raw\""), "{}", raw.text);
}

#[test]
fn former_versions_are_read() {
    let text = "<constant name=\"c\" type=\"color3\"><input name=\"value\" type=\"color3\" value=\"1, 2, 3\"/></constant>\
                <swizzle name=\"s\" type=\"vector2\"><input name=\"in\" type=\"color3\" nodename=\"c\"/>\
                <input name=\"channels\" type=\"string\" value=\"bg\"/></swizzle>\
                <extract name=\"n\" type=\"float\"><input name=\"in\" type=\"vector2\" nodename=\"s\"/></extract>\
                <dot name=\"m\" type=\"float\"><input name=\"in\" type=\"float\" nodename=\"c\" channels=\"g\"/></dot>";
    assert_eq!((value(text, "n"), value(text, "m")), (3.0, 2.0));
}

#[test]
fn materials_of_former_versions_have_shaders_within() {
    let text = format!(
        "{GRAPH}<material name=\"M\"><shaderref name=\"s\" node=\"standard_surface\"><bindinput name=\"base_color\" \
         type=\"color3\" value=\"0.1, 0.2, 0.3\"/><bindinput name=\"metalness\" type=\"float\" nodegraph=\"g\" \
         output=\"out\"/></shaderref></material>"
    );
    let text = text.replace("<input name=\"in2\"", "<parameter name=\"in2\"");
    let made = generated(&text, Some("M")).expect("a shader");
    for part in ["color base_color = color(0.1, 0.2, 0.3)", "g_m_in2 = 2.0", "float g_k = 3.0"] {
        assert!(made.text.contains(part), "{part}\n{}", made.text);
    }
    compiled(&made.text).expect("it compiles");
}

#[test]
fn a_material_is_chosen_by_name() {
    let one = "<standard_surface name=\"s\" type=\"surfaceshader\"><input name=\"base_color\" type=\"color3\" \
               value=\"0.1, 0.2, 0.3\"/></standard_surface><surfacematerial name=\"M\" type=\"material\">\
               <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\"/></surfacematerial>";
    let made = generated(one, None).expect("a shader");
    assert!(made.text.contains("color base_color = color(0.1, 0.2, 0.3)"), "parameters of the shader");
    assert!(made.text.contains("float coat = 0.0"), "those without a value, too");
    compiled(&made.text).expect("it compiles");
    let two = format!("{one}<surfacematerial name=\"N\" type=\"material\"/>");
    let why = generated(&two, None).expect_err("two");
    assert!(why.contains("name one of them: M, N"), "{why}");
    let why = generated(&two, Some("O")).expect_err("none");
    assert!(why.contains("there is no 'O'; there are M, N"), "{why}");
    let empty = generated("", None).expect_err("nothing");
    assert!(empty.contains("there is no material"), "{empty}");
}

#[test]
fn thin_walls_are_panes() {
    let text = "<standard_surface name=\"s\" type=\"surfaceshader\"><input name=\"thin_walled\" type=\"boolean\" \
                value=\"true\"/></standard_surface>";
    let made = generated(text, None).expect("a shader");
    assert_eq!(made.text.matches("\"thin_walled\", 1").count(), 1, "of transmission alone\n{}", made.text);
    compiled(&made.text).expect("it compiles");
    assert!(
        !generated(&text.replace("true", "false"), None)
            .expect("a shader")
            .text
            .contains("\"thin_walled\", 1")
    );
}

#[test]
fn displacement_is_an_output() {
    let text = "<displacement name=\"d\" type=\"displacementshader\"><input name=\"displacement\" type=\"float\" \
                value=\"1\"/></displacement><surfacematerial name=\"M\" type=\"material\"><input \
                name=\"displacementshader\" type=\"displacementshader\" nodename=\"d\"/></surfacematerial>";
    for text in [text.to_owned(), text.replace("\"float\" value=\"1\"", "\"vector3\" value=\"1, 2, 3\"")] {
        let made = generated(&text, None).expect("a shader");
        assert_eq!(made.warnings, [""; 0]);
        assert!(made.text.contains("output vector displacement = 0"), "{}", made.text);
        compiled(&made.text).expect("it compiles");
    }
    let without = generated("<standard_surface name=\"s\" type=\"surfaceshader\"/>", None).expect("a shader");
    assert!(!without.text.contains("vector displacement"), "{}", without.text);
}

#[test]
fn what_is_left_out_is_said_once() {
    let text = "<volume name=\"v\" type=\"volumeshader\"/><volumematerial name=\"M\" type=\"material\"><input \
                name=\"volumeshader\" type=\"volumeshader\" nodename=\"v\"/></volumematerial>";
    let made = generated(text, None).expect("a shader");
    assert_eq!(made.warnings, ["t.mtlx:3: volumes are left out"]);
}
