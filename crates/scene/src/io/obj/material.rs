// SPDX-License-Identifier: GPL-3.0-or-later
//! From MTL's Phong materials to ours.
//! Source: Wavefront MTL 4.2 (`illum` models); [WMLT07] for roughness from an exponent: alpha = sqrt(2 / (Ns + 2)).
//!
//! | MTL | here |
//! |---|---|
//! | `illum` 4, 6, 7, 9; or `d` < 1 with `Kd` 0 and `Ni` > 1 or `Tf` | glass of `Ni`, tinted by `Tf` |
//! | `illum` 3 or 5 with `Ks` above `Kd`; or `Kd` 0 and `Ks` >= 0.2 | metal of `Ks`; a mirror if `Ns` is absent or >= 1000 |
//! | `Pm`, `Pr`, `Ps`, `Pc` or `Pcr` (the PBR extension) | metallic-roughness as given, with sheen and clear coat |
//! | `Kd` and `Ks` with `Ns` | plastic whose normal reflectance is the mean of `Ks` |
//! | otherwise | matte |
//!
//! The diffuse colour always stays `Kd` times `map_Kd` (`Material::diffuse`). `Ke` is radiance. `d` < 1 that did not make
//! glass is opacity. Proof: `tests/obj.rs::materials_become_ours`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::directives::MapStatement;
use super::mtl::{Entry, Library};
use crate::id::{MaterialId, TextureId};
use crate::io::textures::{Meaning, Pictures};
use crate::io::{Oddity, Warnings, source};
use crate::material::{Alpha, Color, Material, Opacity, OpacityChannel, Principled, Surface, TextureRef};
use crate::scene::Scene;
use crate::texture::{Filter, Texture, Wrap};

/// Albedo of faces without a material.
const DEFAULT_ALBEDO: f32 = 0.6;
/// Roughness of sheen, of which MTL says only how much there is.
const SHEEN_ROUGHNESS: f32 = 0.5;
/// From this exponent on a highlight is a mirror image.
const MIRROR_EXPONENT: f32 = 1000.0;

/// Adds the default material and those of the library to the scene, in the order of their numbers; tells the files of
/// their textures, too.
pub(super) fn add_all(
    library: &Library,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> (Vec<MaterialId>, Vec<PathBuf>) {
    let mut textures = Textures { pictures: Pictures::default(), known: HashMap::new() };
    let default = scene.add_material(Material::matte("default", [DEFAULT_ALBEDO; 3]));
    let rest = library.entries.iter().map(|entry| {
        let material = convert(entry, scene, &mut textures, warnings);
        scene.add_material(material)
    });
    let materials = std::iter::once(default).chain(rest).collect();
    (materials, textures.pictures.paths())
}

fn convert(entry: &Entry, scene: &mut Scene, textures: &mut Textures, warnings: &mut Warnings) -> Material {
    let mtl = &entry.material;
    let mut map = |keyword: &str, text: Option<&str>, meaning| {
        text.and_then(|text| textures.add(entry, keyword, text, meaning, scene, warnings))
    };
    let map_kd = map("map_Kd", mtl.diffuse_texture.as_deref(), Meaning::Color);
    let map_ke = map("map_Ke", mtl.unknown_param.get("map_Ke").map(String::as_str), Meaning::Color);
    let map_d = map("map_d", mtl.dissolve_texture.as_deref(), Meaning::Data);

    let phong = Phong::of(entry);
    let diffuse = Color { factor: phong.kd, texture: map_kd };
    let surface = phong.surface(diffuse);
    let lost = matches!(surface, Surface::Dielectric { .. } | Surface::Mirror { .. })
        || matches!(&surface, Surface::MetallicRoughness { base_color, .. } if *base_color != diffuse);
    let glass = matches!(surface, Surface::Dielectric { .. });
    let opacity = Opacity { factor: phong.d, texture: map_d, channel: OpacityChannel::Red };
    let alpha =
        if glass || (phong.d >= 1.0 && map_d.is_none()) { Alpha::Opaque } else { Alpha::Blend { opacity } };
    Material {
        diffuse: lost.then_some(diffuse),
        emission: phong.ke.unwrap_or(if map_ke.is_some() { [1.0; 3] } else { [0.0; 3] }),
        emission_texture: map_ke,
        alpha,
        ..Material::of(mtl.name.clone(), surface)
    }
}

/// The numbers of an MTL material.
struct Phong {
    kd: [f32; 3],
    ks: [f32; 3],
    ke: Option<[f32; 3]>,
    tf: Option<[f32; 3]>,
    ns: Option<f32>,
    ni: Option<f32>,
    d: f32,
    illum: u8,
    metallic: Option<f32>,
    roughness: Option<f32>,
    sheen: Option<f32>,
    coat: Option<f32>,
    coat_roughness: Option<f32>,
}

impl Phong {
    fn of(entry: &Entry) -> Self {
        let mtl = &entry.material;
        let text = |key: &str| mtl.unknown_param.get(key);
        let number = |key: &str| text(key).and_then(|t| t.parse::<f32>().ok());
        let triple = |key: &str| {
            let mut numbers = text(key)?.split_whitespace().map_while(|t| t.parse::<f32>().ok());
            Some([numbers.next()?, numbers.next()?, numbers.next()?])
        };
        let not_negative = |c: [f32; 3]| c.map(|x| x.max(0.0));
        let ke = mtl.emissive.map(not_negative);
        // Without `Kd`: white under a map, black where anything else is said, grey where nothing is.
        let says_else =
            ke.is_some() || mtl.specular.is_some() || mtl.illumination_model.is_some_and(|m| m > 2);
        let default_kd = match (mtl.diffuse_texture.is_some(), says_else) {
            (true, _) => 1.0,
            (false, true) => 0.0,
            (false, false) => DEFAULT_ALBEDO,
        };
        Self {
            kd: not_negative(mtl.diffuse.unwrap_or([default_kd; 3])),
            ks: not_negative(mtl.specular.unwrap_or([0.0; 3])),
            ke,
            tf: triple("Tf").map(not_negative),
            ns: mtl.shininess,
            ni: mtl.optical_density.filter(|&ni| ni > 0.0),
            d: mtl.dissolve.or(number("Tr").map(|tr| 1.0 - tr)).unwrap_or(1.0).clamp(0.0, 1.0),
            illum: mtl.illumination_model.unwrap_or(2),
            metallic: number("Pm").map(|x| x.clamp(0.0, 1.0)),
            roughness: number("Pr").map(|x| x.clamp(0.0, 1.0)),
            sheen: number("Ps").map(|x| x.clamp(0.0, 1.0)),
            coat: number("Pc").map(|x| x.clamp(0.0, 1.0)),
            coat_roughness: number("Pcr").map(|x| x.clamp(0.0, 1.0)),
        }
    }

    fn surface(&self, diffuse: Color) -> Surface {
        let mean = |c: [f32; 3]| c.iter().sum::<f32>() / 3.0;
        let (kd, ks) = (mean(self.kd), mean(self.ks));
        let black = kd == 0.0;
        let refracts = self.tf.is_some() || self.ni.is_some_and(|ni| ni > 1.0);
        if matches!(self.illum, 4 | 6 | 7 | 9) || (self.d < 1.0 && black && refracts) {
            return Surface::Dielectric {
                ior: self.ni.unwrap_or(1.5),
                reflectance: [1.0; 3],
                transmittance: self.tf.unwrap_or([1.0; 3]),
            };
        }
        let layers = [self.sheen, self.coat].map(|x| x.unwrap_or(0.0));
        if layers != [0.0; 2] {
            return Surface::Principled(Box::new(Principled {
                base_color: diffuse,
                metallic: self.metallic.unwrap_or(0.0),
                roughness: self.roughness.unwrap_or(0.5),
                sheen_color: [layers[0]; 3],
                sheen_roughness: if layers[0] > 0.0 { SHEEN_ROUGHNESS } else { 0.0 },
                clearcoat: layers[1],
                clearcoat_roughness: self.coat_roughness.unwrap_or(0.0),
                ..Principled::default()
            }));
        }
        if self.metallic.is_some() || self.roughness.is_some() {
            return metallic_roughness(
                diffuse,
                self.metallic.unwrap_or(0.0),
                self.roughness.unwrap_or(0.5),
                1.5,
            );
        }
        if (matches!(self.illum, 3 | 5) && ks > kd) || (black && ks >= 0.2) {
            let reflectance = Color::constant(self.ks);
            return match self.ns {
                Some(ns) if ns < MIRROR_EXPONENT => metallic_roughness(reflectance, 1.0, roughness(ns), 1.5),
                _ => Surface::Mirror { reflectance },
            };
        }
        match self.ns {
            Some(ns) if ks > 0.0 && !black => {
                let root = ks.min(0.95).sqrt();
                metallic_roughness(diffuse, 0.0, roughness(ns), (1.0 + root) / (1.0 - root))
            }
            _ => Surface::Matte { base_color: diffuse },
        }
    }
}

fn metallic_roughness(base_color: Color, metallic: f32, roughness: f32, ior: f32) -> Surface {
    Surface::MetallicRoughness {
        base_color,
        metallic,
        roughness,
        metallic_roughness_texture: None,
        ior,
        normal_texture: None,
    }
}

/// Perceptual roughness, the root of alpha, of a Phong exponent.
fn roughness(ns: f32) -> f32 {
    (2.0 / (ns.max(0.0) + 2.0)).sqrt().sqrt()
}

/// Textures of the scene by what names them.
struct Textures {
    pictures: Pictures,
    known: HashMap<(PathBuf, Meaning, Wrap), TextureId>,
}

impl Textures {
    fn add(
        &mut self,
        entry: &Entry,
        keyword: &str,
        text: &str,
        meaning: Meaning,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> Option<TextureRef> {
        let line = entry.lines.get(keyword).copied();
        let mut warn = |path: &Path, why: String| warnings.note(Oddity::BadTexture, path, line, why);
        let Some(map) = MapStatement::parse(text) else {
            warn(&entry.path, "no file is named".into());
            return None;
        };
        let path = source::resolve(&entry.path, &map.file);
        let key = (path, meaning, map.wrap);
        let texture = match self.known.get(&key) {
            Some(&texture) => texture,
            None => {
                let texels = match self.pictures.file(&key.0, meaning) {
                    Ok(texels) => texels,
                    Err(why) => {
                        warn(&entry.path, why);
                        return None;
                    }
                };
                let (wrap, filter) = ([map.wrap; 2], Filter::Linear);
                let texture = scene.add_texture(Texture { name: map.file.clone(), texels, wrap, filter });
                self.known.insert(key, texture);
                texture
            }
        };
        Some(TextureRef { texture, uv_from_mesh: map.uv_from_mesh() })
    }
}
