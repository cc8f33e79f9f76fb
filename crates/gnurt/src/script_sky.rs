// SPDX-License-Identifier: GPL-3.0-or-later
//! Skies in the shading language as pictures, so that all integrators can sample their light.
//! Source: original. The shader's z is what is above; its y lies in the middle of the picture. Proof: `tests`.

use std::path::Path;

use gnurt_sl_shading::{Access, Script};

use crate::image::{TexelData, Texels};
use crate::shading::Vec3s;
use crate::threads::cores;

/// Columns and rows: a texel is a third of a degree wide.
const SIZE: [u32; 2] = [1024, 512];

/// Whether surroundings are a file in the shading language.
pub(crate) fn is_script(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "osl" || end == "oso" || end == "oslgroup")
}

/// The latitude-longitude picture of a sky with these values of its parameters, by all cores.
pub(crate) fn texels(path: &Path, given: &[(String, String)]) -> Result<Texels, String> {
    let mut script = Script::open(path, &Access::default())?;
    for (name, text) in given {
        script.set_text(name, text).map_err(|why| format!("{}: {why}", script.name()))?;
    }
    let sky = script.environment()?;
    let [width, height] = SIZE;
    let mut texels = vec![[0.0_f32; 4]; (width * height) as usize];
    let rows_of_one = height.div_ceil(cores().clamp(1, 64) as u32);
    std::thread::scope(|scope| {
        for (part, texels) in texels.chunks_mut((rows_of_one * width) as usize).enumerate() {
            let sky = &*sky;
            scope.spawn(move || {
                for (row, texels) in texels.chunks_mut(width as usize).enumerate() {
                    let row = part as u32 * rows_of_one + row as u32;
                    let (dirs, mut seen) = (directions(row), Vec3s::default());
                    seen.resize(dirs.len());
                    sky.miss(&dirs, &mut seen);
                    for (i, texel) in texels.iter_mut().enumerate() {
                        let [r, g, b] = seen.get(i).to_array().map(|x| x.max(0.0));
                        *texel = [r, g, b, 1.0];
                    }
                }
            });
        }
    });
    Ok(Texels { width, height, data: TexelData::Float(texels) })
}

/// Where the middles of a row's texels lie, as the shader sees them.
fn directions(row: u32) -> Vec3s {
    let [width, height] = SIZE;
    let (sin, up) = (std::f32::consts::PI * (row as f32 + 0.5) / height as f32).sin_cos();
    let mut dirs = Vec3s::default();
    dirs.resize(width as usize);
    for column in 0..width as usize {
        let turn = std::f32::consts::TAU * ((column as f32 + 0.5) / width as f32 - 0.5);
        (dirs.x[column], dirs.y[column], dirs.z[column]) = (sin * turn.sin(), sin * turn.cos(), up);
    }
    dirs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_above_lies_at_the_upper_edge() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sky.osl");
        std::fs::write(&path, "environment sky () { Ci = color (max (I, 0)) * background (); }")
            .expect("a file");
        let sky = texels(&path, &[]).expect("a sky");
        let TexelData::Float(plain) = &sky.data else { panic!("floats") };
        let near = |at: usize, wanted: [f32; 3]| {
            let found = plain[at];
            assert!((0..3).all(|k| (found[k] - wanted[k]).abs() < 0.01), "{found:?}, not {wanted:?}");
        };
        near(0, [0.0, 0.0, 1.0]);
        near(1024 * 256 + 512, [0.0, 1.0, 0.0]);
        near(1024 * 256 + 768, [1.0, 0.0, 0.0]);
        near(1024 * 511, [0.0; 3]);
        let text = "environment sky (color tint = 0) { Ci = tint * background (); }";
        std::fs::write(&path, text).expect("a file");
        let given = |name: &str| [(name.to_owned(), "0.25,0.5,2".to_owned())];
        let sky = texels(&path, &given("tint")).expect("a sky");
        let TexelData::Float(plain) = &sky.data else { panic!("floats") };
        assert_eq!(plain[7][..3], [0.25, 0.5, 2.0], "the value that was given");
        let why = texels(&path, &given("tnt")).expect_err("there is none of that name");
        assert!(why.contains("sky.osl: no parameter 'tnt'"), "{why}");
        std::fs::write(&path, "surface sky () { }").expect("a file");
        let why = texels_error(&path);
        assert!(why.contains("of type surface"), "{why}");
    }

    fn texels_error(path: &Path) -> String {
        texels(path, &[]).expect_err("it is wrong")
    }
}
