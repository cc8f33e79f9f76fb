// SPDX-License-Identifier: GPL-3.0-or-later
//! The shaders in the shading language that a scene's file names for its materials and cameras, compiled and
//! applied.
//! Tests: `tests` below; bindings/python/tests/test_shaders.py.

use std::sync::Arc;

use crate::osl::{Access, CameraScript, Kind, Script, sampler};
use gnurt_image::WorkingSpace;
use gnurt_render::ShaderTable;
use gnurt_scene::displacement::{Displacement, Offset};
use gnurt_scene::{CameraId, MaterialId, Scene, ShaderFile, Surface, TextureId};
use gnurt_shading::DisplacementShader;

/// Compiles a shader that a scene's file names or holds, and gives its parameters their values.
fn script(scene: &Scene, named: &ShaderFile, space: WorkingSpace) -> Result<Script, String> {
    let ShaderFile { file, text, pictures, parameters, confined_to } = named;
    let sampled = |(name, id): &(String, TextureId)| {
        let texture = scene.textures().get(id.index())?;
        Some((name.clone(), Arc::new(sampler(texture.texels.clone()))))
    };
    let pictures = Arc::new(pictures.iter().filter_map(sampled).collect());
    let access = Access { confined_to: confined_to.clone(), pictures, space, ..Access::default() };
    let mut script = match text {
        Some(text) => Script::from_text(file, text, &access)?,
        None => Script::open(file, &access)?,
    };
    parameters.iter().try_for_each(|(name, value)| script.set_text(name, value))?;
    Ok(script)
}

/// Compiles the shader that a scene's file names for a camera, and gives its parameters the values of the file; nothing if it names none.
///
/// # Errors
/// Why it cannot be had, in a line that names the camera.
pub fn named_camera_shader(
    scene: &Scene,
    camera: CameraId,
) -> Result<Option<(Script, CameraScript)>, String> {
    let Some(named) = scene.camera_file(camera) else {
        return Ok(None);
    };
    let made = script(scene, named, WorkingSpace::Rec709).and_then(|script| {
        let camera = script.camera_anywhere()?;
        Ok(Some((script, camera)))
    });
    made.map_err(|why| {
        let name = scene.cameras().get(camera.index()).map_or("", |camera| &camera.name);
        format!("camera '{name}' is used without its shader: {why}")
    })
}

/// The scripts of shaders that a scene's file names.
#[derive(Debug, Default)]
pub struct NamedShaders {
    /// Those of the surfaces that were added, in their order.
    pub surfaces: Vec<Script>,
    /// Those of the displacements that were added, in their order.
    pub displacements: Vec<Script>,
    /// A line for each shader that failed, and the compiler's warnings.
    pub reported: Vec<String>,
}

/// Compiles the shaders that a scene's file names for its materials, adds them to `table` and shows materials by them.
/// A displacement shader, or the output `displacement` of a surface, displaces the surfaces of its material.
/// A material whose shader fails stays as it is without it. Closures are converted to the working space.
pub fn put_named_shaders(scene: &mut Scene, table: &mut ShaderTable, space: WorkingSpace) -> NamedShaders {
    let named: Vec<(MaterialId, ShaderFile)> =
        scene.shader_files().map(|(id, file)| (id, file.clone())).collect();
    let mut all = NamedShaders::default();
    for (id, named) in named {
        let made = script(scene, &named, space).and_then(|script| {
            let is_surface = script.kind() != Kind::Displacement;
            let surface = is_surface.then(|| script.surface()).transpose()?;
            Ok((surface, script.displacement()?, script))
        });
        match made {
            Ok((surface, displacement, script)) => {
                if let Some(displacement) = displacement {
                    put_displacement(scene, table, &[id], displacement);
                    all.displacements.push(script.clone());
                }
                all.reported.extend(script.warnings().iter().map(|warning| warning.trim_end().to_owned()));
                // The material of a displacement stays as it is.
                let Some(surface) = surface else { continue };
                // Its material without the shader is used if all surfaces are forced to be diffuse.
                let diffuse = scene.material(id).diffuse_color();
                let material = scene.edit_material(id);
                material.diffuse.get_or_insert(diffuse);
                material.surface = Surface::Shader(table.surfaces.len() as u32);
                table.surfaces.push(surface);
                all.surfaces.push(script);
            }
            Err(why) => {
                let name = &scene.material(id).name;
                all.reported.push(format!("material '{name}' is shown without its shader: {why}"));
            }
        }
    }
    all
}

/// Adds a displacement to the table, and displaces the surfaces of some materials by it. The refinement of their meshes stays.
pub fn put_displacement(
    scene: &mut Scene,
    table: &mut ShaderTable,
    materials: &[MaterialId],
    shader: Arc<dyn DisplacementShader>,
) {
    let offset = Offset::Shader(table.displacements.len() as u32);
    table.displacements.push(shader);
    for &material in materials {
        let refinement = scene.displacement(material).map(|before| before.refinement).unwrap_or_default();
        scene.set_displacement(material, Some(Displacement { refinement, ..Displacement::new(offset) }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_scene::Material;

    #[test]
    fn displacement_shaders_leave_materials_as_they_are() {
        let mut scene = Scene::new();
        let mut named = |text: &str| {
            let id = scene.add_material(Material::matte("", [0.5; 3]));
            let file = ShaderFile { file: "a.osl".into(), text: Some(text.into()), ..ShaderFile::default() };
            scene.set_shader_file(id, file);
            id
        };
        let moved = named("displacement up () { displace (0.5); }");
        let both =
            named("surface s (output vector displacement = 0) { displacement = N; Ci = diffuse (N); }");
        let mut table = ShaderTable::default();
        let NamedShaders { surfaces, displacements, reported } =
            put_named_shaders(&mut scene, &mut table, WorkingSpace::Rec709);
        assert_eq!([surfaces.len(), table.surfaces.len()], [1; 2]);
        assert_eq!([displacements.len(), table.displacements.len()], [2; 2]);
        assert_eq!(reported, Vec::<String>::new());
        assert_eq!(scene.material(moved).surface, Material::matte("", [0.5; 3]).surface, "as it was");
        let number = |id| scene.displacement(id).map(|displacement| displacement.offset);
        assert_eq!([moved, both].map(number), [Some(Offset::Shader(0)), Some(Offset::Shader(1))]);
    }

    #[test]
    fn shaders_that_cannot_be_had_change_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("grey.osl");
        std::fs::write(&file, "surface grey(float k = 0.5) { Ci = k * diffuse(N); }").expect("a file");
        let mut scene = Scene::new();
        let mut named = |parameters: &[(&str, &str)], file| {
            let id = scene.add_material(Material::matte("", [0.5; 3]));
            let parameters = parameters.iter().map(|(name, value)| (name.to_string(), value.to_string()));
            let parameters = parameters.collect();
            scene.set_shader_file(id, ShaderFile { file, parameters, ..ShaderFile::default() });
            id
        };
        let good = named(&[("k", "0.25")], file.clone());
        let bad = [named(&[("j", "1")], file), named(&[], folder.path().join("none.osl"))];
        let mut table = ShaderTable::default();
        let NamedShaders { surfaces, reported, .. } =
            put_named_shaders(&mut scene, &mut table, WorkingSpace::Rec709);
        assert_eq!((surfaces.len(), table.surfaces.len()), (1, 1));
        assert!(matches!(scene.material(good).surface, Surface::Shader(0)), "the good one");
        for id in bad {
            assert_eq!(scene.material(id).surface, Material::matte("", [0.5; 3]).surface, "as it was");
        }
        assert!(
            reported.len() == 2
                && reported[0].contains("unknown parameter 'j'")
                && reported[1].contains("none.osl"),
            "{reported:?}"
        );
    }
}
