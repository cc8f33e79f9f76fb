// SPDX-License-Identifier: GPL-3.0-or-later
//! Materials: preview surfaces, textures, bindings.

use gnurt_scene::io::LoadOptions;
use gnurt_scene::material::{Alpha, Surface};

use crate::support::{Folder, load, warnings};

const QUAD: &str = r#"
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    texCoord2f[] primvars:map = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
"#;

#[test]
fn numbers_of_preview_surfaces() {
    let loaded = load(&format!(
        r#"
def Mesh "Q" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {QUAD} rel material:binding = </M> }}
def Material "M" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    float inputs:shine = 0.25
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0.1, 0.2, 0.3)
        float inputs:metallic = 1
        float inputs:roughness.connect = </M.inputs:shine>
        float inputs:opacity = 0.5
        token outputs:surface
    }}
}}
"#
    ));
    assert_eq!(warnings(&loaded), "");
    let material = loaded.scene.material(loaded.scene.meshes()[0].material);
    assert_eq!(material.name, "M");
    let Surface::MetallicRoughness { base_color, metallic, roughness, .. } = &material.surface else {
        panic!("{material:?}")
    };
    assert_eq!(
        (base_color.factor, *metallic, *roughness),
        ([0.1, 0.2, 0.3], 1.0, 0.25),
        "through the interface"
    );
    assert!(
        matches!(material.alpha, Alpha::Blend { opacity } if opacity.factor == 0.5),
        "{:?}",
        material.alpha
    );
}

/// A picture of 2 x 1: red, then blue.
fn picture() -> Vec<u8> {
    let mut picture = gnurt_image::Picture::new(2, 1);
    picture.color[0] = [1.0, 0.0, 0.0, 1.0];
    picture.color[1] = [0.0, 0.0, 1.0, 1.0];
    let options = gnurt_image::WriteOptions::default();
    gnurt_image::encode(&picture, gnurt_image::PictureFormat::PNG, &options).expect("a picture")
}

#[test]
fn textures_and_where_they_lie() {
    let text = format!(
        r#"#usda 1.0
( metersPerUnit = 1 )
def Mesh "Q" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {QUAD} rel material:binding = </M> }}
def Material "M" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>
        float inputs:roughness.connect = </M/T.outputs:r>
        token outputs:surface
    }}
    def Shader "T" {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./maps/a.png@
        token inputs:wrapS = "clamp"
        float2 inputs:st.connect = </M/P.outputs:result>
        float3 outputs:rgb
        float outputs:r
    }}
    def Shader "P" {{
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </M/R.outputs:result>
        float inputs:rotation = 90
        float2 inputs:scale = (2, 3)
        float2 inputs:translation = (0.5, 0.25)
        float2 outputs:result
    }}
    def Shader "R" {{
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "map"
        float2 outputs:result
    }}
}}
"#
    );
    let folder = Folder::with(&[("a.usda", &text)]);
    std::fs::create_dir(folder.path("maps")).expect("a folder");
    std::fs::write(folder.path("maps/a.png"), picture()).expect("a picture");
    let loaded = folder.load("a.usda", &LoadOptions::default()).expect("a scene");
    assert_eq!(warnings(&loaded), "");
    let mesh = &loaded.scene.meshes()[0];
    assert_eq!(mesh.texcoords[2], [1.0, 1.0], "the primvar that the network reads");
    let material = loaded.scene.material(mesh.material);
    let Surface::MetallicRoughness { base_color, metallic_roughness_texture, .. } = &material.surface else {
        panic!("{material:?}")
    };
    let lies = base_color.texture.expect("a texture").uv_from_mesh;
    // Scaled, turned by a quarter, moved: (1, 1) goes to (-3 + 0.5, 2 + 0.25).
    let [a, b, c, d, e, f] = lies;
    assert!((a + c + e + 2.5).abs() < 1e-5 && (b + d + f - 2.25).abs() < 1e-5, "{lies:?}");
    let rough = loaded.scene.texture(metallic_roughness_texture.expect("a texture").texture);
    assert_eq!(rough.texels.texel(0, 0)[1], 1.0, "red became green: roughness");
    assert_eq!(rough.texels.texel(1, 0)[1], 0.0, "and so did the other texel");
    std::fs::remove_file(folder.path("maps/a.png")).expect("it was there");
    let without = folder.load("a.usda", &LoadOptions::default()).expect("a scene without it");
    assert!(warnings(&without).contains("a.png"), "{}", warnings(&without));
}

#[test]
fn tiles_of_textures_are_one_picture() {
    let text = format!(
        r#"#usda 1.0
( metersPerUnit = 1 )
def Mesh "Q" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {QUAD} rel material:binding = </M> }}
def Material "M" {{
    token outputs:surface.connect = </M/S.outputs:surface>
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </M/T.outputs:rgb>
        token outputs:surface
    }}
    def Shader "T" {{
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./maps/a.<UDIM>.png@
        float3 outputs:rgb
    }}
}}
"#
    );
    let folder = Folder::with(&[("a.usda", &text)]);
    std::fs::create_dir(folder.path("maps")).expect("a folder");
    let flat = |size: [u32; 2], color: [f32; 4]| {
        let mut picture = gnurt_image::Picture::new(size[0], size[1]);
        picture.color.fill(color);
        let options = gnurt_image::WriteOptions::default();
        gnurt_image::encode(&picture, gnurt_image::PictureFormat::PNG, &options).expect("a picture")
    };
    std::fs::write(folder.path("maps/a.1001.png"), picture()).expect("a picture");
    std::fs::write(folder.path("maps/a.1012.png"), flat([1, 3], [0.0, 1.0, 0.0, 1.0])).expect("a picture");
    let loaded = folder.load("a.usda", &LoadOptions::default()).expect("a scene");
    assert_eq!(warnings(&loaded), "");
    let material = loaded.scene.material(loaded.scene.meshes()[0].material);
    let Surface::MetallicRoughness { base_color, .. } = &material.surface else { panic!("{material:?}") };
    let texture = base_color.texture.expect("a texture");
    assert_eq!(texture.uv_from_mesh, [0.5, 0.0, 0.0, 0.5, 0.0, 0.0], "two by two tiles");
    let texels = &loaded.scene.texture(texture.texture).texels;
    assert_eq!([texels.width, texels.height], [4, 6], "each as large as the largest");
    let color = |x: usize, y: usize| [0, 1, 2].map(|k| texels.texel(x, y)[k]);
    assert_eq!([color(0, 5), color(1, 3)], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], "1001 is below, on the left");
    assert_eq!([color(2, 0), color(3, 2)], [[0.0, 1.0, 0.0]; 2], "1012 is above, on the right");
    assert_eq!([color(0, 0), color(3, 5)], [[0.0; 3]; 2], "tiles without a file");
    for tile in ["maps/a.1001.png", "maps/a.1012.png"] {
        std::fs::remove_file(folder.path(tile)).expect("it was there");
    }
    let without = folder.load("a.usda", &LoadOptions::default()).expect("a scene without them");
    assert!(warnings(&without).contains("no tile of it was found"), "{}", warnings(&without));
    std::fs::write(folder.path("maps/a.1001.png"), flat([4000, 4000], [1.0; 4])).expect("a picture");
    std::fs::write(folder.path("maps/a.2000.png"), picture()).expect("a picture");
    let large = folder.load("a.usda", &LoadOptions::default()).expect("a scene");
    assert!(warnings(&large).contains("tiles side by side"), "a budget: {}", warnings(&large));
}

#[test]
fn bindings_without_schema_or_material_bind_nothing() {
    let loaded = load(&format!(
        r#"
def Mesh "Q" {{ {QUAD} rel material:binding = </M> }}
def Material "M" {{}}
def Mesh "R" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{ {QUAD} rel material:binding = </Missing> }}
"#
    ));
    let told = warnings(&loaded);
    assert!(told.contains("/Q: material:binding without MaterialBindingAPI"), "{told}");
    assert!(told.contains("/R: bound to /Missing, which is no Material"), "{told}");
    let is_unbound = |mesh: &gnurt_scene::Mesh| loaded.scene.material(mesh.material).name.is_empty();
    assert!(loaded.scene.meshes().iter().all(|mesh| is_unbound(mesh)), "as if they were unbound");
}
