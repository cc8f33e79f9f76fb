// SPDX-License-Identifier: GPL-3.0-or-later
//! Textures of the layers of a principled material, each multiplied to a number.
//! Source: KHR_materials_{clearcoat, diffuse_transmission, iridescence, sheen, specular, transmission}, which
//! define the channels. Without a texture the factor counts alone. Tests: `tests/gltf.rs::layers_have_textures`.

use serde::{Deserialize, Serialize};

/// The textures, of whatever form a texture has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayerTextures<T> {
    /// Alpha: strength of the dielectric reflection.
    pub specular: Option<T>,
    /// Red, green, blue: its colour.
    pub specular_color: Option<T>,
    /// Red: share of the coat.
    pub clearcoat: Option<T>,
    /// Green: roughness of the coat.
    pub clearcoat_roughness: Option<T>,
    /// Tangent-space normals of the coat. Without them its normals are those of the mesh.
    pub clearcoat_normal: Option<T>,
    /// Multiplied to x and y of these normals.
    pub clearcoat_normal_scale: f32,
    /// Red, green, blue: colour of the sheen.
    pub sheen_color: Option<T>,
    /// Alpha: roughness of the sheen.
    pub sheen_roughness: Option<T>,
    /// Red: share of glass.
    pub transmission: Option<T>,
    /// Red: share of the film.
    pub iridescence: Option<T>,
    /// Green: from the least thickness of the film (0) to the greatest (1).
    pub iridescence_thickness: Option<T>,
    /// Alpha: share of the light that the body scatters through.
    pub diffuse_transmission: Option<T>,
    /// Red, green, blue: its colour.
    pub diffuse_transmission_color: Option<T>,
}

impl<T> Default for LayerTextures<T> {
    /// None.
    fn default() -> Self {
        Self {
            specular: None,
            specular_color: None,
            clearcoat: None,
            clearcoat_roughness: None,
            clearcoat_normal: None,
            clearcoat_normal_scale: 1.0,
            sheen_color: None,
            sheen_roughness: None,
            transmission: None,
            iridescence: None,
            iridescence_thickness: None,
            diffuse_transmission: None,
            diffuse_transmission_color: None,
        }
    }
}

impl<T: Copy> LayerTextures<T> {
    /// The textures in another form.
    pub fn map<U>(&self, mut to: impl FnMut(T) -> U) -> LayerTextures<U> {
        LayerTextures {
            specular: self.specular.map(&mut to),
            specular_color: self.specular_color.map(&mut to),
            clearcoat: self.clearcoat.map(&mut to),
            clearcoat_roughness: self.clearcoat_roughness.map(&mut to),
            clearcoat_normal: self.clearcoat_normal.map(&mut to),
            clearcoat_normal_scale: self.clearcoat_normal_scale,
            sheen_color: self.sheen_color.map(&mut to),
            sheen_roughness: self.sheen_roughness.map(&mut to),
            transmission: self.transmission.map(&mut to),
            iridescence: self.iridescence.map(&mut to),
            iridescence_thickness: self.iridescence_thickness.map(&mut to),
            diffuse_transmission: self.diffuse_transmission.map(&mut to),
            diffuse_transmission_color: self.diffuse_transmission_color.map(&mut to),
        }
    }

    /// Those that hold colours.
    pub fn colors(&self) -> impl Iterator<Item = T> + use<T> {
        [self.specular_color, self.sheen_color, self.diffuse_transmission_color].into_iter().flatten()
    }

    /// Those that hold other numbers.
    pub fn data(&self) -> impl Iterator<Item = T> + use<T> {
        let all = [
            self.specular,
            self.clearcoat,
            self.clearcoat_roughness,
            self.clearcoat_normal,
            self.sheen_roughness,
            self.transmission,
            self.iridescence,
            self.iridescence_thickness,
            self.diffuse_transmission,
        ];
        all.into_iter().flatten()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.colors().chain(self.data()).next().is_none()
    }
}
