// SPDX-License-Identifier: GPL-3.0-or-later
//! Networks of MaterialX's nodes, and documents that stages refer to.

use gnurt_scene::ShaderFile;
use gnurt_scene::io::LoadOptions;

use crate::support::{Folder, load, warnings};

const MESH: &str = r#"
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    texCoord2f[] primvars:map = [(0, 0), (1, 0), (1, 1)] ( interpolation = "vertex" )
    rel material:binding = </Looks/M>
"#;

fn shader_file(loaded: &gnurt_scene::io::Loaded) -> ShaderFile {
    let (_, file) = loaded.scene.shader_files().next().expect("a shader");
    file.clone()
}

/// A stage beside a document.
fn beside(document: (&str, &str), body: &str) -> gnurt_scene::io::Loaded {
    let text = format!("#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n{body}");
    let folder = Folder::with(&[("scene.usda", &text), document]);
    folder.load("scene.usda", &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn networks_become_documents() {
    let loaded = load(&format!(
        r#"
def Mesh "Q" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {MESH} }}
def Scope "Looks" {{
    def Material "M" {{
        color3f inputs:tint = (0.25, 0.5, 1)
        token outputs:mtlx:surface.connect = </Looks/M/S.outputs:out>
        def Shader "S" {{
            uniform token info:id = "ND_standard_surface_surfaceshader"
            color3f inputs:base_color.connect = </Looks/M/G.outputs:out>
            float inputs:metalness = 1
            token outputs:out
        }}
        def NodeGraph "G" {{
            color3f inputs:tint.connect = </Looks/M.inputs:tint>
            color3f outputs:out.connect = </Looks/M/G/N.outputs:out>
            def Shader "N" {{
                uniform token info:id = "ND_multiply_color3FA"
                color3f inputs:in1.connect = </Looks/M/G.inputs:tint>
                float inputs:in2.connect = </Looks/M/G/U.outputs:out>
            }}
            def Shader "U" {{
                uniform token info:id = "ND_geompropvalue_vector2"
                string inputs:geomprop = "map"
            }}
        }}
    }}
}}
"#
    ));
    assert_eq!(warnings(&loaded), "");
    let file = shader_file(&loaded);
    let text = file.text.expect("a document");
    for part in [
        "<node name=\"S\" nodedef=\"ND_standard_surface_surfaceshader\">",
        "<input name=\"base_color\" nodename=\"N_1\" output=\"out\"/>",
        "<input name=\"in1\" value=\"0.25, 0.5, 1\" colorspace=\"\"/>",
        "<input name=\"metalness\" value=\"1\" colorspace=\"\"/>",
        "nodedef=\"ND_geompropvalue_vector2\"",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let mut none = |_: &std::path::Path| Err("no file".to_owned());
    let read = gnurt_materialx::Document::of_text("t.mtlx".as_ref(), &text, &mut none).expect("a document");
    // A float input takes no pair: the fault is named.
    let why = read.shader(None).expect_err("the network is wrong").to_string();
    assert!(why.contains("'in2' is a float, and is connected to a vector2"), "{why}");
    let right = text
        .replace("ND_multiply_color3FA", "ND_multiply_color3")
        .replace("nodename=\"U_2\" output=\"out\"", "value=\"1,1,1\"");
    let read = gnurt_materialx::Document::of_text("t.mtlx".as_ref(), &right, &mut none).expect("a document");
    let made = read.shader(None).expect("a shader");
    assert!(made.text.contains("metalness = 1.0") && made.warnings.is_empty(), "{}", made.text);
}

#[test]
fn referenced_documents_are_materials() {
    let gold = "<?xml version=\"1.0\"?><materialx version=\"1.39\"><standard_surface name=\"S\" type=\"surfaceshader\"/>\
         <surfacematerial name=\"Gold\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" \
         nodename=\"S\"/></surfacematerial></materialx>";
    let loaded = beside(
        ("gold.mtlx", gold),
        &format!(
            r#"
def Mesh "Q" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {MESH} }}
def Scope "Looks" {{
    def Material "M" ( references = @gold.mtlx@</MaterialX/Materials/Gold> ) {{
        float inputs:metalness = 0.5
    }}
}}
"#
        ),
    );
    assert_eq!(warnings(&loaded), "");
    let file = shader_file(&loaded);
    assert!(file.file.to_string_lossy().ends_with("gold.mtlx:Gold"), "{:?}", file.file);
    assert_eq!(file.parameters, [("metalness".to_owned(), "0.5".to_owned())]);
}

#[test]
fn broken_documents_are_named() {
    let loaded = beside(
        ("bad.mtlx", "<materialx version=\"1.39\">"),
        &format!(
            r#"
def Mesh "Q" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {MESH} }}
def Scope "Looks" {{
    def Material "M" ( references = @bad.mtlx@</MaterialX/Materials/Gold> ) {{ }}
}}
"#
        ),
    );
    assert!(warnings(&loaded).contains("bad.mtlx"), "{}", warnings(&loaded));
}
