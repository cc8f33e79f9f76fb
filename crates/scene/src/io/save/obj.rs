// SPDX-License-Identifier: GPL-3.0-or-later
//! OBJ with an MTL library and PNG textures in the same folder.
//! Source: Wavefront OBJ and MTL 4.2; `Pm` and `Pr` of the PBR extension for metalness and roughness.
//! The library is called NAME.mtl, textures NAME-K.png. Tests: `tests/save.rs`.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use gnurt_image::srgb;

use super::files::{check_writable, leave_out, write};
use super::losses;
use super::{png, world};
use crate::detail::{Anisotropy, Interior};
use crate::id::TextureId;
use crate::io::{Error, Warnings};
use crate::material::{Alpha, Color, Material, OpacityChannel, Principled, Surface, TextureRef};
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::texture::Wrap;

pub(in crate::io) fn save(scene: &Scene, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
    let stem = stem(path);
    let library_file = library_file(path);
    let textures: Vec<_> = texture_files(scene, path).collect();
    check_writable(&textures)?;
    check_writable(&[library_file.clone(), path.to_owned()])?;
    let measures = png::measures(scene);
    for (k, (texture, file)) in scene.textures().iter().zip(&textures).enumerate() {
        let is_measure = measures.contains(&TextureId(k as u32));
        write(file, &png::encode(&texture.texels, is_measure, file)?)?;
    }
    let names = material_names(scene);
    write(&library_file, library(scene, &names, &stem).as_bytes())?;
    leave_out_maps(scene, path, warnings);
    leave_out_layers(scene, path, warnings);
    losses::of_layer_textures(scene, path, warnings);
    losses::of_texcoords(scene, path, warnings);
    leave_out(scene.cameras().len(), "camera", path, warnings);
    leave_out(scene.lights().len(), "light", path, warnings);
    write(path, geometry(scene, &names, &stem).as_bytes())
}

/// The companions of the geometry's file: the library and the textures.
pub(in crate::io) fn companion_files(scene: &Scene, path: &Path) -> Vec<PathBuf> {
    std::iter::once(library_file(path)).chain(texture_files(scene, path)).collect()
}

fn library_file(path: &Path) -> PathBuf {
    path.with_file_name(format!("{}.mtl", stem(path)))
}

fn texture_files(scene: &Scene, path: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = stem(path);
    (0..scene.textures().len()).map(move |k| path.with_file_name(texture_name(&stem, k)))
}

fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// MTL's layers, glass and textures are fewer than ours.
fn leave_out_layers(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let principled = || {
        scene.materials().iter().filter_map(|material| match &material.surface {
            Surface::Principled(principled) => Some(principled),
            _ => None,
        })
    };
    let mut count = |is: &dyn Fn(&Principled) -> bool, what: &str| {
        leave_out(principled().filter(|p| is(p)).count(), what, path, warnings);
    };
    count(&|p| p.specular != 1.0 || p.specular_color != [1.0; 3], "specular weight and colour");
    count(&|p| p.transmission > 0.0, "transmission of a layered material");
    count(&|p| p.iridescence.factor > 0.0, "thin film");
    count(&|p| p.diffuse_transmission.factor > 0.0, "diffuse transmission");
    count(&|p| p.anisotropy.texture.is_some(), "texture of anisotropy");
    count(&|p| p.sheen_color.iter().any(|&x| x != p.sheen_color[0]), "colour of sheen, written as grey");
    let interiors = scene.materials().iter().filter(|material| match &material.surface {
        Surface::Dielectric { interior, .. } | Surface::RoughDielectric { interior, .. } => {
            *interior != Interior::default()
        }
        _ => false,
    });
    leave_out(interiors.count(), "absorption and dispersion of glass", path, warnings);
    let unlit = scene.materials().iter().filter(|material| matches!(material.surface, Surface::Unlit { .. }));
    leave_out(unlit.count(), "unlit colour, written as emission", path, warnings);
    let panes = scene
        .materials()
        .iter()
        .filter(|material| matches!(material.surface, Surface::RoughDielectric { thin: true, .. }));
    leave_out(panes.count(), "pane, written as solid glass", path, warnings);
    let masks = scene.materials().iter().filter(|material| matches!(material.alpha, Alpha::Mask { .. }));
    leave_out(masks.count(), "alpha cutoff, written as opacity", path, warnings);
    let used = || scene.materials().iter().flat_map(Material::textures).map(|(used, _)| used);
    let turned = used().filter(|used| used.uv_from_mesh[1] != 0.0 || used.uv_from_mesh[2] != 0.0);
    leave_out(turned.count(), "rotation of a texture", path, warnings);
    let mirrored = scene
        .textures()
        .iter()
        .filter(|texture| texture.wrap.contains(&Wrap::MirroredRepeat) || texture.wrap[0] != texture.wrap[1]);
    leave_out(mirrored.count(), "how a texture goes on beyond its edges", path, warnings);
}

/// MTL has no standard maps of roughness, and opacity only in a separate picture.
fn leave_out_maps(scene: &Scene, path: &Path, warnings: &mut Warnings) {
    let details = scene.materials().iter().filter(|material| match &material.surface {
        Surface::MetallicRoughness { metallic_roughness_texture, .. } => metallic_roughness_texture.is_some(),
        Surface::Principled(p) => p.metallic_roughness_texture.is_some(),
        _ => false,
    });
    leave_out(details.count(), "map of roughness", path, warnings);
    let opacity = scene.materials().iter().filter(|material| {
        matches!(material.alpha, Alpha::Mask { opacity, .. } | Alpha::Blend { opacity }
            if opacity.texture.is_some() && opacity.channel == OpacityChannel::Alpha)
    });
    leave_out(opacity.count(), "opacity in a colour texture", path, warnings);
}

fn texture_name(stem: &str, k: usize) -> String {
    format!("{stem}-{k}.png")
}

/// Names that differ and fill one line.
fn material_names(scene: &Scene) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut taken_names = HashSet::new();
    for (k, material) in scene.materials().iter().enumerate() {
        let plain: String = material.name.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
        // A line that ends in a backslash continues in the next one.
        let plain = plain.trim().trim_end_matches('\\');
        let mut name = plain.to_owned();
        while name.is_empty() || taken_names.contains(&name) {
            name = format!("{name}_{k}");
        }
        taken_names.insert(name.clone());
        names.push(name);
    }
    names
}

fn geometry(scene: &Scene, names: &[String], stem: &str) -> String {
    let used = || world::world_meshes(scene).map(|(id, transformed)| (scene.mesh(id), transformed));
    let colored = used().any(|(mesh, _)| !mesh.colors.is_empty());
    let mut text = format!("# {}\nmtllib {stem}.mtl\n", gnurt_image::SOFTWARE);
    let mut base = [1_usize; 3];
    for (mesh, transformed) in used() {
        // Writing to a string cannot fail, here and below.
        for (i, [x, y, z]) in world::positions(mesh, transformed).enumerate() {
            let _ = match mesh.colors.get(i) {
                _ if !colored => writeln!(text, "v {x} {y} {z}"),
                Some(&[r, g, b, _]) => {
                    let [r, g, b] = [r, g, b].map(srgb::encode);
                    writeln!(text, "v {x} {y} {z} {r} {g} {b}")
                }
                None => writeln!(text, "v {x} {y} {z} 1 1 1"),
            };
        }
        for [u, v] in &mesh.texcoords {
            let _ = writeln!(text, "vt {u} {v}");
        }
        for [x, y, z] in world::normals(mesh, transformed) {
            let _ = writeln!(text, "vn {x} {y} {z}");
        }
        let _ = writeln!(text, "usemtl {}", names[mesh.material.index()]);
        for triangle in world::triangles(mesh, transformed) {
            text.push('f');
            triangle.iter().for_each(|&i| push_corner(&mut text, mesh, base, i as usize));
            text.push('\n');
        }
        let counts = [mesh.positions.len(), mesh.texcoords.len(), mesh.normals.len()];
        base = [0, 1, 2].map(|k| base[k] + counts[k]);
    }
    text
}

fn push_corner(text: &mut String, mesh: &Mesh, base: [usize; 3], i: usize) {
    let [v, t, n] = base.map(|b| b + i);
    let _ = match (mesh.texcoords.is_empty(), mesh.normals.is_empty()) {
        (true, true) => write!(text, " {v}"),
        (false, true) => write!(text, " {v}/{t}"),
        (true, false) => write!(text, " {v}//{n}"),
        (false, false) => write!(text, " {v}/{t}/{n}"),
    };
}

fn library(scene: &Scene, names: &[String], stem: &str) -> String {
    let mut text = format!("# {}\n", gnurt_image::SOFTWARE);
    for (material, name) in scene.materials().iter().zip(names) {
        let _ = writeln!(text, "\nnewmtl {name}");
        push_material(&mut text, material, scene, stem);
    }
    text
}

fn push_material(text: &mut String, material: &Material, scene: &Scene, stem: &str) {
    let triple = |[r, g, b]: [f32; 3]| format!("{r} {g} {b}");
    let diffuse = match material.surface {
        // A light that scatters nothing is the nearest equivalent.
        Surface::Unlit { .. } => Color::constant([0.0; 3]),
        // A mirror is one by its `Kd` of 0.
        Surface::Mirror { .. } => material.diffuse.unwrap_or(Color::constant([0.0; 3])),
        // Glass and shaders have no colour of their own; of all others `Kd` is the colour that `Pm` makes a metal's.
        Surface::Dielectric { .. } | Surface::RoughDielectric { .. } | Surface::Shader(_) => {
            material.diffuse_color()
        }
        _ => material.surface.base_color(),
    };
    let _ = writeln!(text, "Kd {}", triple(diffuse.factor));
    push_map(text, "map_Kd", diffuse.texture, scene, stem);
    let mut normals = None;
    let _ = match &material.surface {
        Surface::MetallicRoughness { metallic, roughness, ior, normal_texture, .. } => {
            normals = *normal_texture;
            writeln!(text, "Pm {metallic}\nPr {roughness}\nNi {ior}")
        }
        Surface::Principled(p) => {
            normals = p.normal_texture;
            let [r, g, b] = p.sheen_color;
            let (sheen, coat) = (r.max(g).max(b), p.clearcoat);
            let more = if sheen > 0.0 || coat > 0.0 {
                format!("\nPs {sheen}\nPc {coat}\nPcr {}", p.clearcoat_roughness)
            } else {
                String::new()
            };
            let Anisotropy { strength, rotation, .. } = p.anisotropy;
            let brushed = if strength > 0.0 {
                format!("\naniso {strength}\nanisor {}", rotation / std::f32::consts::TAU)
            } else {
                String::new()
            };
            writeln!(text, "Pm {}\nPr {}\nNi {}{more}{brushed}", p.metallic, p.roughness, p.ior)
        }
        Surface::Metal { roughness, .. } => writeln!(text, "Pm 1\nPr {roughness}"),
        Surface::RoughDielectric { ior, transmittance, roughness, .. } => {
            writeln!(text, "Ni {ior}\nTf {}\nPr {roughness}\nillum 7", triple(*transmittance))
        }
        Surface::Mirror { reflectance } => writeln!(text, "Ks {}\nillum 3", triple(reflectance.factor)),
        Surface::Dielectric { ior, transmittance, .. } => {
            writeln!(text, "Ni {ior}\nTf {}\nillum 7", triple(*transmittance))
        }
        Surface::Unlit { color } => {
            let _ = writeln!(text, "Ke {}", triple(color.factor));
            push_map(text, "map_Ke", color.texture, scene, stem);
            Ok(())
        }
        Surface::Matte { .. }
        | Surface::RoughMatte { .. }
        | Surface::ShadowCatcher { .. }
        | Surface::Shader(_) => Ok(()),
    };
    if let Some(normals) = normals {
        push_map(text, &format!("norm -bm {}", normals.scale), Some(normals.texture), scene, stem);
    }
    if material.emits() {
        let _ = writeln!(text, "Ke {}", triple(material.emission));
        push_map(text, "map_Ke", material.emission_texture, scene, stem);
    }
    if let Some(bump) = material.bump {
        push_map(text, &format!("bump -bm {}", bump.height), Some(bump.texture), scene, stem);
    }
    if let Alpha::Mask { opacity, .. } | Alpha::Blend { opacity } = material.alpha {
        let _ = writeln!(text, "d {}", opacity.factor);
        let map = opacity.texture.filter(|_| opacity.channel == OpacityChannel::Red);
        push_map(text, "map_d", map, scene, stem);
    }
}

fn push_map(text: &mut String, keyword: &str, texture: Option<TextureRef>, scene: &Scene, stem: &str) {
    let Some(TextureRef { texture, uv_from_mesh: [a, _, _, d, e, f], .. }) = texture else {
        return;
    };
    let clamp = if scene.texture(texture).wrap == [Wrap::ClampToEdge; 2] { "-clamp on " } else { "" };
    let options = if [a, d, e, f] == [1.0, 1.0, 0.0, 0.0] {
        String::new()
    } else {
        format!("-s {a} {d} 1 -o {e} {f} 0 ")
    };
    let _ = writeln!(text, "{keyword} {clamp}{options}{}", texture_name(stem, texture.index()));
}
