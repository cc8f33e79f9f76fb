// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes: their grids, places and shaders.

use std::io::Read;

use gnurt_image::Volume;
use gnurt_scene::io::{LoadOptions, Loaded};
use gnurt_scene::medium::Extent;

use crate::support::{Folder, warnings};

/// Grids of NanoVDB as `gnurt-image` tests them.
fn grids() -> Vec<u8> {
    let packed: &[u8] = include_bytes!("../../image/tests/data/nano/grids.nvdb.gz");
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed).read_to_end(&mut bytes).expect("a packed file");
    bytes
}

fn load(body: &str) -> Loaded {
    let text = format!("#usda 1.0\n(\n    metersPerUnit = 0.5\n    upAxis = \"Y\"\n)\n{body}");
    let folder = Folder::with(&[("scene.usda", &text), ("broken.vdb", "none")]);
    std::fs::write(folder.path("grids.nvdb"), grids()).expect("a file");
    folder.load("scene.usda", &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn smoke(fields: &str, more: &str) -> String {
    format!(
        r#"
def Volume "Smoke" ( prepend apiSchemas = ["MaterialBindingAPI"] ) {{
    double3 xformOp:translate = (1, 2, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    {fields}
    def OpenVDBAsset "Density" {{ asset filePath = @grids.nvdb@  token fieldName = "density" }}
    def OpenVDBAsset "Broken" {{ asset filePath = @broken.vdb@  token fieldName = "density" }}
    def OpenVDBAsset "Unknown" {{ asset filePath = @grids.nvdb@  token fieldName = "heat" }}
    def Field3DAsset "Old" {{ asset filePath = @grids.nvdb@ }}
}}
{more}"#
    )
}

#[test]
fn smoke_is_where_the_prim_is() {
    let loaded = load(&smoke("rel field:density = </Smoke/Density>\n rel field:heat = </Smoke/Unknown>", ""));
    let [medium] = loaded.scene.media() else { panic!("{}", warnings(&loaded)) };
    assert_eq!(
        (medium.extent, medium.scattering, medium.absorption),
        (Extent::Free, [2.0; 3], [0.0; 3]),
        "per metre"
    );
    assert!(warnings(&loaded).contains("/Smoke: field 'heat'"), "{}", warnings(&loaded));
    let volume = Volume::decode(&grids(), 1 << 28).expect("a volume");
    let grid = volume.grid("density").expect("a grid");
    let [first, _] = grid.active().expect("voxels");
    let cells = medium.grid.as_ref().expect("cells");
    // The middle of the first cell.
    let found = cells.world_from_unit.point(cells.size.map(|n| 0.5 / f64::from(n)));
    let index = first.map(|i| f64::from(i) - 1.0);
    let place = grid.index_from_world().inverse().transform_point3(index.into()).to_array();
    let expected: [f64; 3] = std::array::from_fn(|k| 0.5 * (place[k] + [1.0, 2.0, 3.0][k]));
    assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-5), "{found:?}, not {expected:?}");
}

#[test]
fn shaders_of_volumes_scatter() {
    let look = r#"
def Material "Grey" {
    token outputs:mtlx:volume.connect = </Grey/Volume.outputs:out>
    def Shader "Volume" {
        uniform token info:id = "ND_volume_volumeshader"
        token inputs:vdf.connect = </Grey/Vdf.outputs:out>
        token outputs:out
    }
    def Shader "Vdf" {
        uniform token info:id = "ND_anisotropic_vdf"
        float3 inputs:absorption = (1, 2, 3)
        float3 inputs:scattering = (4, 5, 6)
        float inputs:anisotropy = 0.25
        token outputs:out
    }
}
"#;
    let bound = "rel material:binding = </Grey>\n rel field:smoke = </Smoke/Density>";
    let loaded = load(&smoke(bound, look));
    let [medium] = loaded.scene.media() else { panic!("{}", warnings(&loaded)) };
    assert_eq!(warnings(&loaded), "");
    assert_eq!((medium.absorption, medium.scattering), ([2.0, 4.0, 6.0], [8.0, 10.0, 12.0]));
    assert_eq!(medium.phase.anisotropy, 0.25);
    let absorbing = look.replace("ND_anisotropic_vdf", "ND_absorption_vdf");
    let loaded = load(&smoke(bound, &absorbing));
    assert_eq!(loaded.scene.media()[0].scattering, [0.0; 3], "{}", warnings(&loaded));
}

#[test]
fn fields_that_are_not_shown_are_named() {
    for (fields, part) in [
        ("", "/Smoke: Volume without fields"),
        ("rel field:density", "/Smoke: field 'density', which names no prim"),
        ("rel field:density = </Smoke/Broken>", "/Smoke/Broken: broken.vdb: "),
        ("rel field:density = </Smoke/Unknown>", "no grid 'heat'; it has "),
        ("rel field:density = </Smoke/Old>", "/Smoke/Old: field of the type 'Field3DAsset'"),
        (
            "rel field:a = </Smoke/Density>\n rel field:b = </Smoke/Density>",
            "without a field 'density', but a, b",
        ),
    ] {
        let loaded = load(&smoke(fields, ""));
        assert!(loaded.scene.media().is_empty(), "{fields}");
        assert!(warnings(&loaded).contains(part), "{fields}: {}", warnings(&loaded));
    }
}
