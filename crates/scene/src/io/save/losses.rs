// SPDX-License-Identifier: GPL-3.0-or-later
//! Losses common to all our formats: each kind is one warning with its count.
//! Tests: `tests/save.rs::what_is_lost_is_told`.

use std::path::Path;

use super::files::leave_out;
use crate::io::Warnings;
use crate::material::{Material, Surface};
use crate::mesh::{Attribute, TEXCOORD_1};
use crate::scene::Scene;
use crate::texture::{TexelData, Texels};

/// Shaders, attributes and instances of a scene that no format holds.
pub(in crate::io) fn of_scene(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let is_named = |attribute: &&Attribute| attribute.name != TEXCOORD_1;
    let attributes = scene.meshes().iter().map(|mesh| mesh.attributes.iter().filter(is_named).count()).sum();
    leave_out(attributes, "attribute of a mesh", path, warnings);
    let moves = |id: usize| {
        scene.animation().is_some_and(|a| a.instances.iter().any(|moving| moving.instance.index() == id))
    };
    let hidden = scene.instances().iter().enumerate().filter(|(id, it)| !it.visible && !moves(*id)).count();
    leave_out(hidden, "hidden instance", path, warnings);
}

/// Meshes of curves or spheres, in formats without them.
pub(in crate::io) fn of_primitives(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let count = scene.meshes().iter().filter(|mesh| !mesh.has_triangles()).count();
    leave_out(count, "mesh of curves or spheres", path, warnings);
}

/// Second texture coordinates, in formats with one set.
pub fn of_texcoords(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let second = scene.meshes().iter().filter(|mesh| !mesh.second_texcoords().is_empty()).count();
    leave_out(second, "second set of texture coordinates", path, warnings);
}

/// Textures of layers, in formats that have numbers only.
pub fn of_layer_textures(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let has_some = |material: &&Material| match &material.surface {
        Surface::Principled(p) => !p.layer_textures.is_empty(),
        _ => false,
    };
    let count = scene.materials().iter().filter(has_some).count();
    leave_out(count, "textures of the layers of a material", path, warnings);
}

/// Parts of materials that are lost in all formats with materials.
pub(in crate::io) fn of_materials(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    leave_out(scene.shader_files().count(), "shader file of a material", path, warnings);
    leave_out(scene.displacements().count(), "displacement of a material", path, warnings);
    let count = |is: fn(&Material) -> bool| scene.materials().iter().filter(|material| is(material)).count();
    let is_shader = |material: &Material| matches!(material.surface, Surface::Shader(_));
    leave_out(count(is_shader), "shader of a material, written as matte", path, warnings);
    let catches = |material: &Material| matches!(material.surface, Surface::ShadowCatcher { .. });
    leave_out(count(catches), "shadow catcher, written as matte", path, warnings);
    let is_rough = |material: &Material| matches!(material.surface, Surface::RoughMatte { roughness, .. } if roughness > 0.0);
    leave_out(count(is_rough), "roughness of a matte surface", path, warnings);
    let is_metal = |material: &Material| matches!(material.surface, Surface::Metal { .. });
    leave_out(count(is_metal), "index and extinction of metal, written as its colour", path, warnings);
    let glows_below = |material: &Material| matches!(&material.surface, Surface::Principled(p) if p.subsurface.factor > 0.0);
    leave_out(count(glows_below), "light below the surface, written as diffuse", path, warnings);
    let is_tinted = |material: &Material| match &material.surface {
        Surface::Dielectric { reflectance, .. } | Surface::RoughDielectric { reflectance, .. } => {
            *reflectance != [1.0; 3]
        }
        _ => false,
    };
    leave_out(count(is_tinted), "tint of the reflection of glass", path, warnings);
    let bright = scene.textures().iter().filter(|texture| is_beyond_one(&texture.texels)).count();
    leave_out(bright, "texture values outside of 0 to 1, cut off", path, warnings);
}

/// Whether a texture has values that PNG cannot hold.
fn is_beyond_one(texels: &Texels) -> bool {
    let outside = |pixels: &[[f32; 4]]| pixels.as_flattened().iter().any(|x| !(0.0..=1.0).contains(x));
    match &texels.data {
        TexelData::Float(pixels) => outside(pixels),
        TexelData::Tiled(_) if texels.is_float() => match texels.clone().resident().data {
            TexelData::Float(pixels) => outside(&pixels),
            _ => false,
        },
        _ => false,
    }
}
