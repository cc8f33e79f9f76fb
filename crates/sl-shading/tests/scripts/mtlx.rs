// SPDX-License-Identifier: GPL-3.0-or-later
//! Documents of MaterialX as surfaces: lobes of their closures, parameters, included files, values read again.

use gnurt_shading::SurfaceShader;
use gnurt_shading::bsdf::{ClosureBatch, Kind};
use gnurt_sl_shading::{Access, Script, materials_of_document, shaders_by_material};

use super::floor::floor;
use super::kinds::emitted;

const LIBRARY: &str = "<materialx version=\"1.39\"><standard_surface name=\"S\" type=\"surfaceshader\">\
    <input name=\"specular\" type=\"float\" value=\"0\"/></standard_surface></materialx>";
const DOCUMENT: &str = "<materialx version=\"1.39\"><xi:include href=\"library.mtlx\"/>\
    <surfacematerial name=\"M\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\
    </surfacematerial><surfacematerial name=\"N\" type=\"material\"/></materialx>";

fn kinds(script: &Script) -> Vec<Kind> {
    let (hits, mut out) = (floor(1), ClosureBatch::default());
    out.reset(1);
    let surface: std::sync::Arc<dyn SurfaceShader> = script.surface().expect("a surface");
    surface.evaluate(&hits, &mut out);
    out.point(0).bsdf.lobes().as_slice().iter().map(|lobe| lobe.kind).collect()
}

#[test]
fn documents_are_surfaces() {
    let [folder, library] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let file = folder.path().join("d.mtlx");
    std::fs::write(&file, DOCUMENT).expect("a file");
    std::fs::write(library.path().join("library.mtlx"), LIBRARY).expect("a file");
    let none = Access::default();
    assert!(Script::open(&file, &none).expect_err("a file is missing").contains("library.mtlx"));
    let includes = vec![library.path().to_string_lossy().into_owned()];
    let access = Access { includes, ..Access::default() };
    assert_eq!(materials_of_document(&file, &access).expect("a document"), ["M", "N"]);
    let why = Script::open(&file, &access).expect_err("two materials");
    assert!(why.contains("name one of them: M, N"), "{why}");
    let named = format!("{}:M", file.display());
    let mut script = Script::open(named.as_ref(), &access).expect("a script");
    assert_eq!(kinds(&script), [Kind::Diffuse], "nothing else has a weight");
    script.set_text("coat", "1").expect("a parameter");
    assert_eq!(kinds(&script), [Kind::Microfacets, Kind::Diffuse]);
    let again = script.again().expect("it is read again");
    assert_eq!(kinds(&again), kinds(&script), "with its values");
}

#[test]
fn materials_get_the_ones_of_their_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("d.mtlx");
    std::fs::write(&file, DOCUMENT.replace("<xi:include href=\"library.mtlx\"/>", "")).expect("a file");
    let document = file.display().to_string();
    let found = |shader: &str, material| {
        let names = ["floor", "N", "M", "N"].into_iter();
        shaders_by_material(shader, material, names, &Access::default()).expect("a document")
    };
    let pair = |name: &str, shader: String| (name.to_owned(), shader);
    let [m, n] = ["M", "N"].map(|name| format!("{document}:{name}"));
    assert_eq!(found(&document, "*"), [pair("N", n.clone()), pair("M", m.clone())]);
    assert_eq!(found(&document, "N"), [pair("N", n)], "one of them");
    assert_eq!(found(&document, "floor"), [pair("floor", document.clone())], "none has the name");
    assert_eq!(found(&m, "*"), [pair("*", m.clone())], "a node is named");
    assert_eq!(found("a.osl", "*"), [pair("*", "a.osl".to_owned())], "no document");
}

#[test]
fn tiles_of_pictures_have_v_upwards() {
    let folder = tempfile::tempdir().expect("a folder");
    for (number, level) in [(1001, 0.25), (1012, 0.5)] {
        let mut picture = gnurt_image::Picture::new(1, 2);
        // The upper row is twice as bright.
        picture.color = vec![[2.0 * level, level, 0.0, 1.0], [level, level, 0.0, 1.0]];
        let at = folder.path().join(format!("t.{number}.pfm"));
        gnurt_image::write(&picture, &at, &gnurt_image::WriteOptions::default()).expect("a picture");
    }
    let document = "<materialx version=\"1.39\"><image name=\"I\" type=\"color3\">\
        <input name=\"file\" type=\"filename\" value=\"t.&lt;UDIM&gt;.pfm\"/>\
        <input name=\"default\" type=\"color3\" value=\"0, 0, 1\"/>\
        <input name=\"uaddressmode\" type=\"string\" value=\"constant\"/></image>\
        <surface_unlit name=\"S\" type=\"surfaceshader\">\
        <input name=\"emission_color\" type=\"color3\" nodename=\"I\"/></surface_unlit>\
        <surfacematerial name=\"M\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\
        </surfacematerial></materialx>";
    let file = folder.path().join("d.mtlx");
    std::fs::write(&file, document).expect("a file");
    let script = Script::open(&file, &Access::default()).expect("a script");
    let mut hits = floor(4);
    let at = [[0.5, 0.1], [0.5, 0.9], [1.5, 1.9], [2.5, 1.9]];
    for (i, [u, v]) in at.into_iter().enumerate() {
        [hits.texcoord[0][i], hits.texcoord[1][i]] = [u, v];
    }
    let found = emitted(&*script.surface().expect("a surface"), &hits);
    let expected = [[0.25, 0.25, 0.0], [0.5, 0.25, 0.0], [1.0, 0.5, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(found, expected.map(glam::Vec3::from), "rows upwards, and the default where there is no tile");
}

#[test]
fn displacement_shaders_are_offsets() {
    let document = |ty: &str, value: &str| {
        let text = format!(
            "<materialx version=\"1.39\"><standard_surface name=\"S\" type=\"surfaceshader\"/><displacement name=\"D\" \
             type=\"displacementshader\"><input name=\"displacement\" type=\"{ty}\" value=\"{value}\"/><input name=\"scale\" \
             type=\"float\" value=\"0.5\"/></displacement><surfacematerial name=\"M\" type=\"material\"><input \
             name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/><input name=\"displacementshader\" \
             type=\"displacementshader\" nodename=\"D\"/></surfacematerial></materialx>"
        );
        let script = Script::from_text("d.mtlx".as_ref(), &text, &Access::default()).expect("a script");
        assert!(script.surface().is_ok(), "it is a surface, too");
        script
    };
    for (script, expected) in [
        (document("float", "3"), [0.0, 1.5, 0.0]),
        // The floor's u grows along x, its v against z, and its normal is y.
        (document("vector3", "1, 2, 4"), [0.5, 2.0, -1.0]),
    ] {
        for offset in super::displacement::offsets(&script) {
            let near = (0..3).all(|k| (offset[k] - expected[k]).abs() < 1e-6);
            assert!(near, "{offset:?} instead of {expected:?}");
        }
    }
}
