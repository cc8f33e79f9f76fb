// SPDX-License-Identifier: GPL-3.0-or-later
//! The writer: its files in their order. Tests: `tests/save.rs`.

use std::path::{Path, PathBuf};

use gnurt_scene::io::writer::{
    check_writable, encode_texture, leave_out, measures, of_layer_textures, of_texcoords, write,
};
use gnurt_scene::io::{Error, SceneWriter, Warnings};
use gnurt_scene::texture::TexelData;
use gnurt_scene::{Light, Scene, TextureId};

use super::text::Text;
use super::{binary, lights, materials, prims, strands};

/// The writer.
pub(crate) const WRITER: SceneWriter = SceneWriter {
    save,
    companions: texture_files,
    has_materials: true,
    has_animations: false,
    has_strands: true,
    is_whole: false,
};

fn save(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if extension == "usdz" {
        let remedy = "valid are .usda and .usdc; `usdzip` makes a package of these";
        return Err(Error::data(path, None, "packages are read, not written", remedy));
    }
    let files = texture_files(scene, path);
    check_writable(&files)?;
    check_writable(&[path.to_owned()])?;
    let measures = measures(scene);
    for (k, (texture, file)) in scene.textures().iter().zip(&files).enumerate() {
        let bytes = match file.extension().is_some_and(|extension| extension == "exr") {
            true => lights::encode(&texture.texels, file)?,
            false => encode_texture(&texture.texels, measures.contains(&TextureId(k as u32)), file)?,
        };
        write(file, &bytes)?;
    }
    let names: Vec<String> = files
        .iter()
        .map(|file| format!("./{}", file.file_name().unwrap_or_default().to_string_lossy()))
        .collect();
    let mut text = Text::default();
    prims::write(scene, &names, &mut text);
    leave_out_rest(scene, path, warnings);
    let text = text.finish();
    if extension == "usda" {
        return write(path, text.as_bytes());
    }
    let binary = gnurt_image::expecting_panics(|| binary::from_text(&text));
    let binary = binary.unwrap_or_else(|| Err("the binary writer failed".into()));
    write(path, &binary.map_err(|fault| Error::data(path, None, fault, "write a .usda file"))?)
}

fn leave_out_rest(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let backdrops = scene.lights().iter().filter(|light| matches!(light, Light::Backdrop { .. })).count();
    leave_out(backdrops, "backdrop", path, warnings);
    materials::leave_out_layers(scene, path, warnings);
    of_layer_textures(scene, path, warnings);
    of_texcoords(scene, path, warnings);
    strands::leave_out_properties(scene, path, warnings);
}

/// The files of textures.
fn texture_files(scene: &Scene, path: &Path) -> Vec<PathBuf> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let of_environment = |k: usize| {
        let is_it =
            |light: &Light| matches!(light, Light::Environment { texture: Some(id), .. } if id.index() == k);
        scene.lights().iter().any(is_it)
    };
    let name = |(k, texture): (usize, &gnurt_scene::Texture)| {
        let is_float = matches!(texture.texels.data, TexelData::Float(_)) || texture.texels.is_float();
        let extension = if is_float && of_environment(k) { "exr" } else { "png" };
        path.with_file_name(format!("{stem}-{k}.{extension}"))
    };
    scene.textures().iter().enumerate().map(name).collect()
}
