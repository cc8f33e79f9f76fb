// SPDX-License-Identifier: GPL-3.0-or-later
//! A number that identifies a picture: same scene, same camera, same options. Levels, threads, times and
//! pieces do not count; nor does the number of samples, so that a finished picture can be given more of them,
//! unless it decides where samples go. Not meant against forgery.
//! Tests: `tests::only_what_matters_counts`.

use std::fmt::{self, Debug, Write};

use gnurt_image::{TexelData, Texels};
use gnurt_scene::Scene;
use gnurt_simd::Level;

use crate::options::RenderOptions;
use crate::pixel_noise::PixelNoise;

/// The fingerprint of rendering `scene` under these options; `camera` is any identification of the camera.
#[must_use]
pub fn fingerprint(scene: &Scene, force_diffuse: bool, camera: &dyn Debug, options: &RenderOptions) -> u64 {
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    let options = RenderOptions {
        level: Level::Scalar,
        time_limit: None,
        piece: None,
        rows: None,
        spp: if options.noise.is_some() || options.pixel_noise == PixelNoise::Blue { options.spp } else { 1 },
        ..options.clone()
    };
    hash.debug(&(env!("CARGO_PKG_VERSION"), options, force_diffuse));
    hash.debug(camera);
    hash.debug(&(scene.objects(), scene.instances(), scene.materials(), scene.lights()));
    if scene.displacements().next().is_some() {
        hash.debug(&scene.displacements().collect::<Vec<_>>());
    }
    for mesh in scene.meshes() {
        hash.debug(&mesh.material);
        hash.floats(mesh.positions.as_flattened());
        hash.floats(mesh.normals.as_flattened());
        hash.floats(mesh.texcoords.as_flattened());
        hash.floats(mesh.tangents.as_flattened());
        hash.floats(mesh.colors.as_flattened());
        mesh.indices.as_flattened().iter().for_each(|&i| hash.mix_number(u64::from(i)));
        hash.debug(&(&mesh.primitives, &mesh.attributes));
    }
    for medium in scene.media() {
        hash.debug(&gnurt_scene::Medium { grid: None, name: String::new(), ..medium.clone() });
        if let Some(grid) = &medium.grid {
            hash.debug(&(grid.size, grid.world_from_unit));
            hash.floats(&grid.density);
            hash.floats(grid.emission.as_flattened());
        }
    }
    for texture in scene.textures() {
        hash.debug(&(texture.wrap, texture.filter, texture.texels.width, texture.texels.height));
        // Texels in tiles count as those in memory.
        let tiled = matches!(texture.texels.data, TexelData::Tiled(_));
        let resident = tiled.then(|| Texels::clone(&texture.texels).resident());
        match &resident.as_ref().unwrap_or(&texture.texels).data {
            TexelData::Tiled(_) => {}
            TexelData::Srgb8(texels) | TexelData::Linear8(texels) => {
                texels.iter().for_each(|&texel| hash.mix_number(u64::from(u32::from_le_bytes(texel))));
            }
            TexelData::Linear16(texels) => {
                texels.iter().flatten().for_each(|&number| hash.mix_number(u64::from(number)));
            }
            TexelData::Float(texels) => hash.floats(texels.as_flattened()),
        }
    }
    hash.0
}

struct Hash(u64);

impl Hash {
    fn mix_number(&mut self, mix_number: u64) {
        let mixed = (self.0 ^ mix_number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 29);
    }

    /// Their number counts, too, so that arrays cannot run into each other.
    fn floats(&mut self, floats: &[f32]) {
        self.mix_number(floats.len() as u64);
        floats.iter().for_each(|x| self.mix_number(u64::from(x.to_bits())));
    }

    fn debug(&mut self, value: &dyn Debug) {
        // Writing to a hash never fails.
        let _ = writeln!(self, "{value:?}");
    }
}

impl Write for Hash {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.mix_number(u64::from(byte)));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_scene::Material;

    #[test]
    fn only_what_matters_counts() {
        let options = RenderOptions::default();
        let mut scene = Scene::new();
        let material = scene.add_material(Material::matte("grey", [0.5; 3]));
        let mesh = gnurt_scene::Mesh { positions: vec![[0.0; 3]; 3], material, ..Default::default() };
        let id = scene.add_mesh(mesh);
        let print = |scene: &Scene, options: &RenderOptions| fingerprint(scene, false, &1, options);
        let one = print(&scene, &options);
        assert_eq!(one, print(&scene.clone(), &RenderOptions { spp: 99, ..options.clone() }), "more samples");
        assert_ne!(one, print(&scene, &RenderOptions { seed: 1, ..options.clone() }), "another seed");
        assert_ne!(one, fingerprint(&scene, true, &1, &options), "other materials");
        assert_ne!(one, fingerprint(&scene, false, &2, &options), "another camera");
        scene.edit_mesh(id).positions[1][2] = 1e-30;
        assert_ne!(one, print(&scene, &options), "another shape");
    }
}
