// SPDX-License-Identifier: GPL-3.0-or-later
//! `--shader`: a scene's materials shaded by classes of libOpenRT, built-in ones and plugins that a C compiler makes here.

use std::path::{Path, PathBuf};
use std::process::Command;

use gnurt::image::{ChannelData, Picture, compare};

use super::harness::Folder;

/// Compiles a plugin of examples/plugins/c, with `from` replaced by `to`.
pub(crate) fn compile(folder: &Folder, name: &str, [from, to]: [&str; 2]) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let source =
        std::fs::read_to_string(root.join(format!("examples/plugins/c/{name}.c"))).expect("an example");
    assert!(source.contains(from), "{name}.c has '{from}'");
    compile_source(folder, name, &source.replace(from, to))
}

/// Compiles a plugin.
pub(crate) fn compile_source(folder: &Folder, name: &str, source: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let source = folder.write(&format!("{name}.c"), source);
    let target = folder.at(&format!("{name}.so"));
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-O1", "-shared", "-fPIC", "-I"]).arg(root.join("bindings/openrt/include"));
    compiler.arg(source).arg("-lm").arg("-o").arg(&target);
    assert!(compiler.status().expect("a C compiler").success(), "{name}.c compiles");
    target
}

/// As it is.
pub(crate) const SAME: [&str; 2] = ["", ""];

/// As when a programmer changes a line: all is black.
pub(crate) const BLACK: [&str; 2] = ["product[i] *= a;", "product[i] = 0 * a;"];

fn picture(folder: &Folder, name: &str) -> Picture {
    gnurt::image::read(&folder.at(name)).expect("a picture")
}

#[test]
fn plugins_shade_what_built_in_classes_shade() {
    let folder = Folder::new();
    compile(&folder, "diffuse", SAME);
    let line = "render builtin:cornell -r 64x40 --spp 1 --shader";
    folder.gnurt(&format!("{line} *=DiffuseShader:color=0.9,0.5,0.2 -o class.pfm")).success();
    folder.gnurt(&format!("{line} *=diffuse@diffuse.so:color=0.9,0.5,0.2 -o plugin.pfm")).success();
    let [class, plugin] = ["class.pfm", "plugin.pfm"].map(|name| picture(&folder, name));
    let difference = compare(&class, &plugin).expect("one size").max_difference;
    assert!(difference < 1e-5, "the same light: {difference}");
    // A name with the signs of the option in it.
    std::fs::copy(folder.at("diffuse.so"), folder.at("2026:11@home.so")).expect("a file");
    folder.gnurt(&format!(r"{line} *=diffuse@2026\:11\@home.so:color=0.9,0.5,0.2 -o named.pfm")).success();
    assert!(folder.read("named.pfm") == folder.read("plugin.pfm"), "the same plugin");
    folder.gnurt(&format!("{line} *=diffuse@diffuse.so:color=0.2 -o dark.pfm")).success();
    assert!(
        folder.read("dark.pfm") != folder.read("plugin.pfm"),
        "one number for all three, and another picture"
    );
}

#[test]
fn one_material_of_several_and_a_texture() {
    let folder = Folder::new();
    let [obj, mtl] = [super::samples::OBJ, "newmtl red\nKd 0.8 0.1 0.1\n"];
    folder.write("scene.obj", obj);
    folder.write("scene.mtl", mtl);
    let plain = "render scene.obj -r 32x24 --spp 1 --integrator eyelight";
    folder.gnurt(&format!("{plain} -o plain.pfm")).success();
    folder.gnurt(&format!("{plain} --shader red=MatteShader:color=0,1,0 -o green.pfm")).success();
    let [plain_sum, green_sum] = ["plain.pfm", "green.pfm"].map(|name| {
        let color = picture(&folder, name).color;
        color.iter().fold([0.0; 2], |[r, g], pixel| [r + pixel[0], g + pixel[1]])
    });
    assert!(
        plain_sum[0] > plain_sum[1] && green_sum[0] == 0.0 && green_sum[1] > 0.0,
        "{plain_sum:?} {green_sum:?}"
    );
    // The last one counts; a texture is a picture.
    let texture =
        format!("{plain} --shader *=MatteShader --shader red=MatteShader:color=1:texture=@green.pfm");
    folder.gnurt(&format!("{texture} -o textured.pfm")).success();
    assert!(folder.read("textured.pfm") != folder.read("plain.pfm"));
}

#[test]
fn documents_of_materialx_are_shaders() {
    let folder = Folder::new();
    folder.write("scene.obj", super::samples::OBJ);
    folder.write("scene.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    let unlit = |name: &str, color: &str| {
        format!(
            "<surface_unlit name=\"S_{name}\" type=\"surfaceshader\"><input name=\"emission_color\" type=\"color3\" \
             value=\"{color}\"/></surface_unlit><surfacematerial name=\"{name}\" type=\"material\"><input \
             name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S_{name}\"/></surfacematerial>"
        )
    };
    let document = format!(
        "<materialx version=\"1.39\">{}{}</materialx>",
        unlit("red", "0,1,0"),
        unlit("blue", "0,0,1")
    );
    folder.write("two.mtlx", &document);
    let line = "render scene.obj -r 16x12 --spp 1 --shader";
    let shown = |name: &str, choice: &str| {
        folder.gnurt(&format!("{line} {choice} -o {name}")).success();
        let color = picture(&folder, name).color;
        let [r, g, b, _] = color[color.len() / 2 + 8];
        [r, g, b]
    };
    assert_eq!(shown("a.pfm", "*=two.mtlx"), [0.0, 1.0, 0.0], "the material's own name");
    assert_eq!(shown("b.pfm", "red=two.mtlx:blue"), [0.0, 0.0, 1.0]);
    assert_eq!(shown("c.pfm", "red=two.mtlx:blue:emission_color=0.5,0,0"), [0.5, 0.0, 0.0]);
    let refused = |choice: &str, message: &str| {
        folder
            .run(&["render", "scene.obj", "-r", "8x8", "-o", "p.png", "--shader", choice])
            .fails(1, message);
    };
    folder.write("others.mtlx", document.replace("name=\"red\"", "name=\"rust\""));
    refused("*=others.mtlx", "name one of them: rust, blue");
    refused("*=two.mtlx:green", "there is no 'green'; there are red, blue");
    refused("*=none.mtlx", "none.mtlx");
}

#[test]
fn wrong_shaders_are_refused() {
    let folder = Folder::new();
    compile(&folder, "diffuse", SAME);
    compile(&folder, "studio", SAME);
    folder.write("text.so", "no library");
    for (status, choice, message) in [
        (2, "red", "give MATERIAL=CLASS"),
        (2, "*=MatteShader:color", "'color' is not a parameter"),
        (2, "nosuch=MatteShader", "unknown material 'nosuch'"),
        (1, "*=MateShader", "did you mean \"MatteShader\"?"),
        (1, "*=MatteShader:colour=1", "unknown parameter 'colour'"),
        (1, "*=diffuse@none.so", "none.so"),
        (1, "*=diffuse@text.so", "text.so"),
        (1, "*=difuse@diffuse.so", "did you mean \"diffuse\"?"),
        (1, "*=sky@studio.so", "is of no surfaces"),
        (1, "*=diffuse@diffuse.so:shadows=0.5", "'0.5' is not 1 whole number"),
    ] {
        let run = folder.run(&["render", "builtin:cornell", "-r", "8x8", "-o", "p.png", "--shader", choice]);
        run.fails(status, message);
        assert!(!folder.at("p.png").exists(), "no picture of {choice}");
    }
    folder.gnurt("render builtin:cornell --shader *=MatteShader --force-diffuse").fails(2, "--force-diffuse");
}

#[test]
fn checkpoints_know_their_shaders() {
    let folder = Folder::new();
    let line = "render builtin:cornell -r 16x12 --spp 4 -o p.png --checkpoint state --shader";
    compile(&folder, "diffuse", SAME);
    folder.gnurt(&format!("{line} *=diffuse@diffuse.so")).success();
    folder.gnurt(&format!("{line} *=diffuse@diffuse.so")).success();
    folder.gnurt(&format!("{line} *=diffuse@diffuse.so:color=0.5")).fails(1, "options differ");
    compile(&folder, "diffuse", BLACK);
    folder.gnurt(&format!("{line} *=diffuse@diffuse.so")).fails(1, "options differ");
}

/// Distances along x over a sheet that is seen from above, one row.
fn depths(folder: &Folder, options: &str) -> Vec<f32> {
    let view = "--eye 0.5,0.5,2 --target 0.5,0.5,0 --up 0,1,0 --projection orthographic --view-height 0.0625 -r 64x4 --spp 1";
    let line = format!("render sheet.obj {view} --integrator eyelight --layers depth {options} -o depth.exr");
    folder.gnurt(&line).success();
    let picture = picture(folder, "depth.exr");
    let mut channels = picture.layers.iter().flat_map(|layer| &layer.channels);
    let depth = channels.find(|channel| channel.name == "Z").expect("a layer of depths");
    let ChannelData::F32(values) = &depth.data else { panic!("floats") };
    values[128..192].iter().map(|z| 2.0 - z).collect()
}

#[test]
fn displacement_by_shaders_and_numbers() {
    let folder = Folder::new();
    folder.write(
        "sheet.obj",
        "mtllib sheet.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nusemtl m\nf 1//1 2//1 3//1 4//1\n",
    );
    folder.write("sheet.mtl", "newmtl m\nKd 0.5 0.5 0.5\n");
    folder.write("wave.osl", "displacement wave (float k = 1) { displace (k * sin (6.2831853 * P[0])); }");
    let wave = |i: usize| (std::f32::consts::TAU * (i as f32 + 0.5) / 64.0).sin();
    let all_near = |found: &[f32], expected: &dyn Fn(usize) -> f32| {
        found.len() == 64 && found.iter().enumerate().all(|(i, z)| (z - expected(i)).abs() < 0.02)
    };
    let moved = depths(&folder, "--shader m=wave.osl:k=0.1 --set materials.m.displacement_edge=0.02");
    assert!(all_near(&moved, &|i| 0.1 * wave(i)), "{moved:?}");
    let constant = depths(&folder, "--set materials.m.displacement=0.25");
    assert!(all_near(&constant, &|_| 0.25), "{constant:?}");
    // The file of materials names it.
    folder.write("sheet.mtl", "newmtl m\nKd 0.5 0.5 0.5\ngnurt_shader wave.osl k=-0.1\n");
    let named = depths(&folder, "--set materials.m.displacement_levels=6");
    assert!(all_near(&named, &|i| -0.1 * wave(i)), "{named:?}");
    folder
        .gnurt("render sheet.obj --shader wave.osl -o none.png")
        .fails(2, "a displacement needs a material");
}
