// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers, variants, what is shown. The judge compares all arcs with OpenUSD: `tests/judge.py`.

use gnurt_scene::io::{LoadOptions, VariantChoice};

use crate::support::{Folder, load, warnings};

const ASSET: &str = r#"#usda 1.0
( defaultPrim = "Asset" )
def Xform "Asset" (
    variants = { string size = "small" }
    prepend variantSets = "size"
) {
    variantSet "size" = {
        "small" { def Cube "Shape" { double size = 1 } }
        "large" { def Cube "Shape" { double size = 4 } }
    }
}
"#;
const SCENE: &str = r#"#usda 1.0
( metersPerUnit = 1 )
def "A" ( prepend references = @./asset.usda@ ) {}
"#;

fn width(options: &LoadOptions) -> f32 {
    let folder = Folder::with(&[("asset.usda", ASSET), ("scene.usda", SCENE)]);
    let loaded = folder.load("scene.usda", options).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loaded.files.len(), 2, "both files: {:?}", loaded.files);
    let xs = loaded.scene.meshes()[0].positions.iter().map(|p| p[0]);
    xs.clone().fold(0.0, f32::max) - xs.fold(0.0, f32::min)
}

#[test]
fn variants_are_chosen_by_option() {
    let choose = |variant: &str| LoadOptions {
        variants: vec![VariantChoice { prim: "/A".into(), set: "size".into(), variant: variant.into() }],
        ..LoadOptions::default()
    };
    assert_eq!((width(&LoadOptions::default()), width(&choose("large"))), (1.0, 4.0), "the file's and ours");
    let folder = Folder::with(&[("asset.usda", ASSET), ("scene.usda", SCENE)]);
    let error = folder.load("scene.usda", &choose("huge")).expect_err("no such variant").to_string();
    assert!(error.contains("size=huge"), "{error}");
}

#[test]
fn what_is_missing_is_named() {
    let folder = Folder::with(&[("scene.usda", SCENE)]);
    let loaded = folder.load("scene.usda", &LoadOptions::default()).expect("an empty scene");
    assert!(warnings(&loaded).contains("asset.usda"), "{}", warnings(&loaded));
}

#[test]
fn files_stay_in_their_folder() {
    let outer = Folder::with(&[("asset.usda", ASSET)]);
    std::fs::create_dir(outer.path("in")).expect("a folder");
    std::fs::write(outer.path("in/scene.usda"), SCENE.replace("./asset", "../asset")).expect("a file");
    let free = outer.load("in/scene.usda", &LoadOptions::default()).expect("nothing forbids it");
    assert_eq!(free.scene.meshes().len(), 1, "{}", warnings(&free));
    let options = LoadOptions { confine: Some(outer.path("in")), ..LoadOptions::default() };
    let confined = outer.load("in/scene.usda", &options).expect("the rest is shown");
    assert!(
        confined.scene.meshes().is_empty() && warnings(&confined).contains("outside"),
        "{}",
        warnings(&confined)
    );
}

#[test]
fn purposes_and_visibility() {
    let loaded = load(
        r#"
def Cube "Default" {}
def Cube "Render" { uniform token purpose = "render" }
def Cube "Proxy" { uniform token purpose = "proxy" }
def Cube "Guide" { uniform token purpose = "guide" }
def Xform "Hidden" { token visibility = "invisible"  def Cube "Below" { token visibility = "inherited" } }
def Cube "Off" ( active = false ) {}
over Cube "Over" {}
class Cube "Class" {}
"#,
    );
    let names: Vec<&str> = loaded.scene.instances().iter().map(|instance| &instance.name[..]).collect();
    assert_eq!(names, ["/Default", "/Render"], "{}", warnings(&loaded));
}

#[test]
fn equal_references_share_their_mesh() {
    let asset = r#"#usda 1.0
( defaultPrim = "Asset" )
def Xform "Asset" {
    def Mesh "Leaf" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {
        uniform token subdivisionScheme = "none"
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        rel material:binding = </Asset/Green>
    }
    def Material "Green" {
        token outputs:surface.connect = </Asset/Green/S.outputs:surface>
        def Shader "S" {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor = (0.1, 0.8, 0.1)
            token outputs:surface
        }
    }
}
"#;
    let scene = r#"#usda 1.0
def "A" ( prepend references = @./asset.usda@ ) {}
def "B" ( prepend references = @./asset.usda@ ) {}
def "C" ( prepend references = @./asset.usda@ ) {
    over "Leaf" { point3f[] points = [(0, 0, 0), (2, 0, 0), (0, 1, 0)] }
}
def "D" ( prepend references = @./asset.usda@ ) {
    over "Green" { over "S" { color3f inputs:diffuseColor = (0.8, 0.1, 0.1) } }
}
"#;
    let folder = Folder::with(&[("asset.usda", asset), ("scene.usda", scene)]);
    let loaded = folder.load("scene.usda", &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings(&loaded), "");
    let objects: Vec<_> = loaded.scene.instances().iter().map(|instance| instance.object).collect();
    assert_eq!(objects.len(), 4, "each is shown");
    assert_eq!(objects[0], objects[1], "nothing differs");
    assert!(
        objects[0] != objects[2] && objects[0] != objects[3],
        "other points, another colour: {objects:?}"
    );
    assert_eq!(loaded.scene.materials().len(), 2, "green and red");
}
