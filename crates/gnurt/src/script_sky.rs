// SPDX-License-Identifier: GPL-3.0-or-later
//! Skies in the shading language as pictures, so that all integrators can sample their light.
//! The shader's z is the up direction; its y is in the middle of the picture. Tests: `tests`.

use std::path::Path;

use crate::osl::{Access, Script};

use crate::image::{TexelData, Texels};
use crate::shading::{EnvironmentShader, Vec3s};
use crate::threads::cores;

/// Columns and rows: a texel is a third of a degree wide.
const SIZE: [u32; 2] = [1024, 512];
/// Neighbours whose relative difference is less than this have no edge between them.
const EVEN: f32 = 0.05;
/// Parts along each side of a texel that has an edge.
const PARTS: usize = 4;
/// Texels that are computed together.
const AT_ONCE: usize = 256;

/// Whether surroundings are a file in the shading language.
pub(crate) fn is_script(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "osl" || end == "oso" || end == "oslgroup")
}

/// The latitude-longitude picture of a sky with these values of its parameters, by all cores; and the picture
/// for rays of the camera where it is another.
pub(crate) fn texels(path: &Path, given: &[(String, String)]) -> Result<(Texels, Option<Texels>), String> {
    let mut script = Script::open(path, &Access::default())?;
    for (name, text) in given {
        script.set_text(name, text).map_err(|why| format!("{}: {why}", script.name()))?;
    }
    texels_of(&script)
}

/// The same of a script that has its values.
pub(crate) fn texels_of(script: &Script) -> Result<(Texels, Option<Texels>), String> {
    let sky = picture(&*script.environment()?);
    let backdrop = script.backdrop()?.map(|sky| picture(&*sky));
    Ok((sky, backdrop))
}

/// A sky as a picture: a texel in an even region has the radiance of its centre, any other the mean of its
/// parts, so that a small sun has the right total.
fn picture(sky: &dyn EnvironmentShader) -> Texels {
    let [width, height] = SIZE.map(|n| n as usize);
    let mut texels = vec![[0.0_f32; 4]; width * height];
    let middles = [[0.5; 2]];
    let all: Vec<usize> = (0..texels.len()).collect();
    for (index, sampled) in all.iter().zip(means(sky, &all, &middles)) {
        texels[*index] = sampled;
    }
    let differs = |a: [f32; 4], b: [f32; 4]| (0..3).any(|k| (a[k] - b[k]).abs() > EVEN * a[k].max(b[k]));
    let is_edge = |&index: &usize| {
        let (row, column) = (index / width, index % width);
        let beside = [row * width + (column + 1) % width, row * width + (column + width - 1) % width];
        let over = [row.saturating_sub(1), (row + 1).min(height - 1)].map(|row| row * width + column);
        beside.into_iter().chain(over).any(|other| differs(texels[index], texels[other]))
    };
    let edges: Vec<usize> = all.into_iter().filter(is_edge).collect();
    let parts: Vec<[f32; 2]> =
        (0..PARTS * PARTS).map(|k| [k % PARTS, k / PARTS].map(|n| (n as f32 + 0.5) / PARTS as f32)).collect();
    for (index, sampled) in edges.iter().zip(means(sky, &edges, &parts)) {
        texels[*index] = sampled;
    }
    Texels { width: SIZE[0], height: SIZE[1], data: TexelData::Float(texels) }
}

/// Radiance of texels, the mean of these parts of each, by all cores.
fn means(sky: &dyn EnvironmentShader, indices: &[usize], parts: &[[f32; 2]]) -> Vec<[f32; 4]> {
    let of_one = indices.len().div_ceil(cores().clamp(1, 64)).max(1);
    let mut found = vec![[0.0, 0.0, 0.0, 1.0]; indices.len()];
    std::thread::scope(|scope| {
        for (indices, found) in indices.chunks(of_one).zip(found.chunks_mut(of_one)) {
            scope.spawn(move || {
                for (indices, found) in indices.chunks(AT_ONCE).zip(found.chunks_mut(AT_ONCE)) {
                    let (mut dirs, mut sampled) = (Vec3s::default(), Vec3s::default());
                    indices
                        .iter()
                        .flat_map(|&index| parts.iter().map(move |&part| direction(index, part)))
                        .for_each(|[x, y, z]| {
                            dirs.x.push(x);
                            dirs.y.push(y);
                            dirs.z.push(z);
                        });
                    sampled.resize(dirs.len());
                    sky.miss(&dirs, &mut sampled);
                    for (i, texel) in found.iter_mut().enumerate() {
                        for k in 0..parts.len() {
                            let light = sampled.get(i * parts.len() + k).to_array();
                            texel.iter_mut().zip(light).for_each(|(sum, x)| *sum += x.max(0.0));
                        }
                        texel[..3].iter_mut().for_each(|sum| *sum /= parts.len() as f32);
                    }
                }
            });
        }
    });
    found
}

/// Where a part of a texel lies, as the shader sees it: both in [0, 1] from its left upper corner.
fn direction(index: usize, [x, y]: [f32; 2]) -> [f32; 3] {
    let [width, height] = SIZE;
    let (row, column) = (index / width as usize, index % width as usize);
    let (sin, up) = (std::f32::consts::PI * (row as f32 + y) / height as f32).sin_cos();
    let rotation = std::f32::consts::TAU * ((column as f32 + x) / width as f32 - 0.5);
    [sin * rotation.sin(), sin * rotation.cos(), up]
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
        let (sky, backdrop) = texels(&path, &[]).expect("a sky");
        assert!(backdrop.is_none(), "all rays see the same");
        let TexelData::Float(plain) = &sky.data else { panic!("floats") };
        let near = |at: usize, expected: [f32; 3]| {
            let found = plain[at];
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 0.01), "{found:?}, not {expected:?}");
        };
        near(0, [0.0, 0.0, 1.0]);
        near(1024 * 256 + 512, [0.0, 1.0, 0.0]);
        near(1024 * 256 + 768, [1.0, 0.0, 0.0]);
        near(1024 * 511, [0.0; 3]);
        let text = "environment sky (color tint = 0) { Ci = tint * background (); }";
        std::fs::write(&path, text).expect("a file");
        let given = |name: &str| [(name.to_owned(), "0.25,0.5,2".to_owned())];
        let (sky, _) = texels(&path, &given("tint")).expect("a sky");
        let TexelData::Float(plain) = &sky.data else { panic!("floats") };
        assert_eq!(plain[7][..3], [0.25, 0.5, 2.0], "the value that was given");
        let why = texels(&path, &given("tnt")).expect_err("there is none of that name");
        assert!(why.contains("sky.osl: unknown parameter 'tnt'"), "{why}");
        let text = "environment sky () { Ci = raytype (\"camera\") * background (); }";
        std::fs::write(&path, text).expect("a file");
        let (sky, backdrop) = texels(&path, &[]).expect("a sky");
        let first = |texels: &Texels| match &texels.data {
            TexelData::Float(plain) => plain[0][0],
            _ => f32::NAN,
        };
        assert_eq!([first(&sky), first(&backdrop.expect("another one"))], [0.0, 1.0], "what the camera sees");
        std::fs::write(&path, "surface sky () { }").expect("a file");
        let why = texels_error(&path);
        assert!(why.contains("of type surface"), "{why}");
    }

    #[test]
    fn a_small_sun_is_as_bright_as_it_should_be() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("sky.osl");
        let text = "environment sky () { float c = cos (radians (2.5));
            Ci = (dot (normalize (I), normalize (vector (1, -1, 1))) > c ? 1 / (1 - c) : 0) * background (); }";
        std::fs::write(&path, text).expect("a file");
        let (sky, _) = texels(&path, &[]).expect("a sky");
        let TexelData::Float(plain) = &sky.data else { panic!("floats") };
        let edge = |row: usize| (std::f64::consts::PI * row as f64 / 512.0).cos();
        let share = |row: usize| (edge(row) - edge(row + 1)) * std::f64::consts::TAU / 1024.0;
        let sum: f64 = plain.iter().enumerate().map(|(i, texel)| f64::from(texel[0]) * share(i / 1024)).sum();
        assert!(
            (sum / std::f64::consts::TAU - 1.0).abs() < 4e-3,
            "{} of its light",
            sum / std::f64::consts::TAU
        );
    }

    fn texels_error(path: &Path) -> String {
        texels(path, &[]).expect_err("it is wrong")
    }
}
