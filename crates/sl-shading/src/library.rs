// SPDX-License-Identifier: GPL-3.0-or-later
//! The shader library, embedded in the program: `builtin/wood.osl` is `shaders/surfaces/wood.osl`, in every
//! directory. An existing file of that name takes precedence. Tests: `tests`.

use std::path::Path;

use gnurt_shading::script::built_in_name;

/// The folder of carried texts.
const FOLDER: &str = "builtin";

macro_rules! carried {
    ($($folder:literal: $($name:literal)*;)*) => {
        &[$($(($name, include_str!(concat!("../shaders/", $folder, "/", $name))),)*)*]
    };
}

/// Files by name.
const FILES: &[(&str, &str)] = carried! {
    "surfaces": "patterns.h" "bricks.osl" "brushed_metal.osl" "car_paint.osl" "checker.osl" "concrete.osl" "fabric.osl"
        "frosted_glass.osl" "lava.osl" "leather.osl" "marble.osl" "metal.osl" "plastic.osl" "principled.osl" "rust.osl" "skin.osl"
        "snow.osl" "terrain.osl" "tiles.osl" "velvet.osl" "water.osl" "wood.osl";
    "lights": "candle.osl" "point_light.osl" "projector.osl" "softbox.osl" "spot_light.osl" "sun.osl";
    "skies": "gradient_sky.osl" "night.osl" "sunset.osl";
    "cameras": "fisheye.osl" "panorama.osl" "pinhole.osl" "thin_lens.osl";
    "pixels": "distances.osl" "ink.osl" "plain.osl";
};

/// The text of a file that the program carries, if its name is `builtin/NAME` and there is no such file.
pub(crate) fn text(path: &Path) -> Option<&'static str> {
    let name = built_in_name(path)?;
    FILES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// Whether a name is that of a shader that the program carries, and of no file.
#[must_use]
pub fn is_carried(path: &Path) -> bool {
    text(path).is_some()
}

/// Whether a name would be one of them, and is not.
pub(crate) fn unknown(path: &Path) -> Option<String> {
    let is_named = path.parent().is_some_and(|folder| folder == Path::new(FOLDER));
    let shaders: Vec<&str> = FILES.iter().filter_map(|(name, _)| name.strip_suffix(".osl")).collect();
    is_named.then(|| {
        format!(
            "the file does not exist, and no built-in shader has that name; valid are: {}",
            shaders.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Access, Script};

    #[test]
    fn all_of_the_library_is_carried_and_compiles() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        let folders = ["surfaces", "lights", "skies", "cameras", "pixels"].map(|folder| root.join(folder));
        let mut count = 0;
        for file in folders.iter().flat_map(|folder| std::fs::read_dir(folder).expect("a folder")) {
            let name = file.expect("a file").file_name().into_string().expect("a name");
            let path = Path::new(FOLDER).join(&name);
            assert!(text(&path).is_some(), "{name} is carried");
            if name.ends_with(".osl") {
                let script =
                    Script::open(&path, &Access::default()).unwrap_or_else(|why| panic!("{name}: {why}"));
                assert!(script.files().is_empty(), "nobody need watch it");
            }
            count += 1;
        }
        assert_eq!(count, FILES.len(), "nothing else is");
        let why = Script::open("builtin/wod.osl".as_ref(), &Access::default()).expect_err("there is none");
        assert!(why.contains("wood") && why.lines().count() == 1, "{why}");
    }
}
