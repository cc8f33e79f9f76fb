// SPDX-License-Identifier: GPL-3.0-or-later
//! Displacement of preview surfaces and of MaterialX's networks.

use std::sync::Arc;

use gnurt_scene::displacement::{Offset, Refinement};
use gnurt_scene::io::{LoadOptions, Loaded};
use gnurt_scene::texture::{Filter, TexelData, Texels, Texture, TextureRef, Wrap};
use gnurt_scene::{Affine, Displacement, Material, Mesh, Scene};

use crate::support::{FORMATS, Folder, load, warnings};

const CUBE: &str = r#"
    int[] faceVertexCounts = [4, 4, 4, 4, 4, 4]
    int[] faceVertexIndices = [0, 1, 3, 2, 2, 3, 5, 4, 4, 5, 7, 6, 6, 7, 1, 0, 1, 7, 5, 3, 6, 0, 2, 4]
    point3f[] points = [(-1, -1, 1), (1, -1, 1), (-1, 1, 1), (1, 1, 1), (-1, 1, -1), (1, 1, -1), (-1, -1, -1), (1, -1, -1)]
    rel material:binding = </M>
"#;

fn stage(scheme: &str, material: &str) -> String {
    format!(
        "def Mesh \"Q\" ( prepend apiSchemas = [\"MaterialBindingAPI\"] ) {{ {CUBE} uniform token subdivisionScheme = \
         \"{scheme}\" }}\ndef Material \"M\" {{ {material} }}\n"
    )
}

fn preview(displacement: &str, more: &str) -> String {
    format!(
        r#"
    token outputs:surface.connect = </M/S.outputs:surface>
    token outputs:displacement.connect = </M/S.outputs:displacement>
    def Shader "S" {{
        uniform token info:id = "UsdPreviewSurface"
        {displacement}
        token outputs:surface
        token outputs:displacement
    }}
    {more}"#
    )
}

fn only(loaded: &Loaded) -> Option<Displacement> {
    let mesh = &loaded.scene.meshes()[0];
    assert!(loaded.scene.displacements().count() < 2, "one material");
    loaded.scene.displacement(mesh.material).copied()
}

#[test]
fn numbers_displace_finer_surfaces() {
    let constant = preview("float inputs:displacement = 0.25", "");
    let loaded = load(&stage("catmullClark", &constant));
    assert_eq!(warnings(&loaded), "");
    assert_eq!(only(&loaded), Some(Displacement::new(Offset::Constant(0.25))));
    let plain = load(&stage("catmullClark", &preview("float inputs:displacement = 0", "")));
    assert_eq!((warnings(&plain), only(&plain)), (String::new(), None), "nothing moves by 0");
    let [fine, coarse] = [&loaded, &plain].map(|loaded| loaded.scene.meshes()[0].indices.len());
    assert_eq!((coarse, fine), (12 << 4, 12 << 10), "levels 2 and 5");
    let polygons = load(&stage("none", &constant));
    assert_eq!(polygons.scene.meshes()[0].indices.len(), 12, "polygons stay");
    assert!(only(&polygons).is_some(), "and move");
}

#[test]
fn textures_have_channels_scales_and_wraps() {
    let mut picture = gnurt_image::Picture::new(2, 1);
    picture.color[0] = [1.0, 0.0, 0.0, 1.0];
    let options = gnurt_image::WriteOptions::default();
    let bytes = gnurt_image::encode(&picture, gnurt_image::PictureFormat::PNG, &options).expect("a picture");
    let texture = r#"
    def Shader "T" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @h.png@
        token inputs:wrapS = "mirror"
        token inputs:wrapT = "clamp"
        float4 inputs:scale = (1, 0.5, 1, 1)
        float4 inputs:bias = (0, -0.25, 0, 0)
        float2 inputs:st.connect = </M/R.outputs:result>
        float outputs:g
    }
    def Shader "R" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "map"
        float2 outputs:result
    }"#;
    let body =
        stage("catmullClark", &preview("float inputs:displacement.connect = </M/T.outputs:g>", texture));
    let text = format!("#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Y\"\n)\n{body}");
    let folder = Folder::with(&[("scene.usda", &text)]);
    std::fs::write(folder.path("h.png"), bytes).expect("a file");
    let loaded = folder.load("scene.usda", &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings(&loaded), "");
    let Some(Displacement {
        offset: Offset::Height { texture, channel: 1 }, scale: 0.5, midlevel: 0.5, ..
    }) = only(&loaded)
    else {
        panic!("{:?}", only(&loaded))
    };
    let texture = loaded.scene.texture(texture.texture);
    assert_eq!(texture.wrap, [Wrap::MirroredRepeat, Wrap::ClampToEdge]);
    assert!(matches!(texture.texels.data, gnurt_image::TexelData::Linear8(_)), "heights are no colours");
}

#[test]
fn networks_keep_their_displacement() {
    let network = r#"
    token outputs:mtlx:surface.connect = </M/S.outputs:out>
    token outputs:mtlx:displacement.connect = </M/D.outputs:out>
    def Shader "S" {
        uniform token info:id = "ND_standard_surface_surfaceshader"
        token outputs:out
    }
    def Shader "D" {
        uniform token info:id = "ND_displacement_float"
        float inputs:displacement = 0.5
        float inputs:scale = 0.25
        token outputs:out
    }"#;
    let loaded = load(&stage("catmullClark", network));
    assert_eq!(warnings(&loaded), "");
    let (_, file) = loaded.scene.shader_files().next().expect("a shader");
    let text = file.text.clone().expect("a document");
    assert!(text.contains("<node name=\"D_1\" nodedef=\"ND_displacement_float\">"), "{text}");
    let input = "<input name=\"displacementshader\" type=\"displacementshader\" nodename=\"D_1\"/>";
    assert!(text.contains(input), "{text}");
    assert_eq!(loaded.scene.meshes()[0].indices.len(), 12 << 10, "and finer surfaces");
    let other = load(&stage("catmullClark", &network.replace("ND_displacement_float", "Other")));
    assert!(warnings(&other).contains("displacement by 'Other', left out"), "{}", warnings(&other));
}

#[test]
fn heights_are_written_and_read() {
    let mut before = Scene::new();
    let data = TexelData::Linear8(vec![[0, 255, 0, 255], [64, 128, 192, 255]]);
    let texels = Arc::new(Texels { width: 2, height: 1, data });
    let (wrap, filter) = ([Wrap::ClampToEdge; 2], Filter::Linear);
    let texture = before.add_texture(Texture { name: "h".into(), texels, wrap, filter });
    let height = Offset::Height { texture: TextureRef::new(texture), channel: 2 };
    let all = [
        Displacement { scale: 0.5, midlevel: 0.25, ..Displacement::new(height) },
        Displacement { scale: 2.0, ..Displacement::new(Offset::Constant(-0.25)) },
        Displacement { refinement: Refinement::Levels(1), ..Displacement::new(Offset::Shader(0)) },
    ];
    for (i, displacement) in all.into_iter().enumerate() {
        let material = before.add_material(Material::matte(format!("m{i}"), [0.5; 3]));
        before.set_displacement(material, Some(displacement));
        let mesh = before.add_mesh(Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, i as f32]],
            texcoords: vec![[0.0; 2]; 3],
            indices: vec![[0, 1, 2]],
            material,
            ..Mesh::default()
        });
        let object = before.add_object_of("", vec![mesh]);
        before.instantiate(object, Affine::IDENTITY);
    }
    let folder = Folder::with(&[]);
    let reported = FORMATS.save(&before, folder.path("a.usda")).unwrap_or_else(|error| panic!("{error}"));
    let reported: Vec<String> = reported.iter().map(ToString::to_string).collect();
    assert!(reported.iter().any(|line| line.contains("displacement by vectors or a shader")), "{reported:?}");
    assert!(reported.iter().any(|line| line.contains("refinement of displaced meshes")), "{reported:?}");
    let loaded = folder.load("a.usda", &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(warnings(&loaded), "");
    let scene = &loaded.scene;
    let found: Vec<Option<Displacement>> =
        scene.meshes().iter().map(|mesh| scene.displacement(mesh.material).copied()).collect();
    let Some(Displacement {
        offset: Offset::Height { texture, channel: 2 }, scale: 0.5, midlevel: 0.25, ..
    }) = found[0]
    else {
        panic!("{found:?}")
    };
    assert_eq!(scene.texture(texture.texture).wrap, wrap);
    assert_eq!(found[1..], [Some(Displacement::new(Offset::Constant(-0.5))), None]);
}
