// SPDX-License-Identifier: GPL-3.0-or-later
//! Scripts of recipes are those that the recipes were made of, also when their files are gone.

use std::path::Path;
use std::sync::Arc;

use gnurt_image::{TexelData, Texels};
use gnurt_sl_shading::{Access, ParameterValue, Script, sampler};

use super::floor::floor;
use super::kinds::emitted;

const GLOW: &str = "#include \"half.h\"\nsurface glow (float k = 1, string which = \"none\") {
    Ci = HALF * k * (color) texture (which, 0.5, 0.5) * emission (); }";

fn light(script: &Script) -> [f32; 3] {
    emitted(&*script.surface().expect("a surface"), &floor(1))[0].to_array()
}

fn access(includes: &Path) -> Access {
    let texels = Texels { width: 1, height: 1, data: TexelData::Float(vec![[0.5, 1.0, 2.0, 1.0]]) };
    let pictures = [("p".to_owned(), Arc::new(sampler(Arc::new(texels))))].into();
    let includes = vec![includes.to_string_lossy().into_owned()];
    Access { includes, pictures: Arc::new(pictures), ..Access::default() }
}

#[test]
fn files_may_be_gone() {
    let [folder, library] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let write = |path: &Path, text: &str| std::fs::write(path, text).expect("a file");
    write(&library.path().join("half.h"), "#define HALF 0.5\n");
    write(&folder.path().join("glow.osl"), GLOW);
    write(
        &folder.path().join("twice.osl"),
        "shader twice (float k = 1, output float out = 0) { out = 2 * k; }",
    );
    let group = "param float k 3 ; shader twice first ; shader glow last ; connect first.out last.k ;";
    write(&folder.path().join("both.oslgroup"), group);
    let access = access(library.path());
    let which = ParameterValue::Texts(vec!["p".into()]);
    let mut scripts = Vec::new();
    for (file, factor) in [("glow.osl", 0.5), ("both.oslgroup", 3.0)] {
        let mut script = Script::open(&folder.path().join(file), &access).expect("a script");
        script.set("which", &which).expect("a parameter");
        assert_eq!(light(&script), [0.5 * factor, factor, 2.0 * factor], "{file}");
        scripts.push(script);
    }
    let text = GLOW.replace("HALF", "HALF * HALF");
    let mut in_memory = Script::from_text(Path::new("a.osl"), &text, &access).expect("a script");
    in_memory.set("which", &which).expect("a parameter");
    in_memory.set("k", &ParameterValue::Floats(vec![4.0])).expect("a parameter");
    scripts.push(in_memory);
    let carried = Script::open(Path::new("builtin/wood.osl"), &Access::default()).expect("a script");
    drop((folder, library));
    for script in &scripts {
        let recipe = script.recipe();
        let again = Script::of_recipe(recipe.clone()).expect("a script");
        assert_eq!(light(&again), light(script), "{}", script.name());
        assert_eq!(again.recipe(), recipe, "the same once more");
        assert_eq!(again.parameters(), script.parameters());
        let mut without = recipe.clone();
        without.texts.pop();
        let why = Script::of_recipe(without).expect_err("a text is missing");
        assert!(!why.is_empty());
        let wrong = vec![("k".to_owned(), ParameterValue::Texts(vec!["much".into()]))];
        let why =
            Script::of_recipe(gnurt_sl_shading::Recipe { values: wrong, ..recipe }).expect_err("a text");
        assert!(why.contains("parameter 'k'"), "{why}");
    }
    assert_eq!(Script::of_recipe(carried.recipe()).expect("a script").parameters(), carried.parameters());
}

#[cfg(feature = "materialx")]
#[test]
fn documents_may_be_gone() {
    const LIBRARY: &str = "<materialx version=\"1.39\"><surface_unlit name=\"S\" type=\"surfaceshader\">\
        <input name=\"emission\" type=\"float\" value=\"0.25\"/></surface_unlit></materialx>";
    const DOCUMENT: &str = "<materialx version=\"1.39\"><xi:include href=\"library.mtlx\"/>\
        <surfacematerial name=\"M\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"S\"/>\
        </surfacematerial></materialx>";
    let [folder, library] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    let file = folder.path().join("d.mtlx");
    std::fs::write(&file, DOCUMENT).expect("a file");
    std::fs::write(library.path().join("library.mtlx"), LIBRARY).expect("a file");
    let access = access(library.path());
    let named = format!("{}:M", file.display());
    let scripts = [
        Script::open(named.as_ref(), &access).expect("a script"),
        Script::from_text(Path::new("d.mtlx"), DOCUMENT, &access).expect("a script"),
    ];
    drop((folder, library));
    for script in &scripts {
        let again = Script::of_recipe(script.recipe()).expect("a script");
        assert_eq!(light(&again), light(script));
        assert_eq!(light(&again), [0.25; 3]);
        assert_eq!(again.files(), script.files());
    }
}
