// SPDX-License-Identifier: GPL-3.0-or-later
//! From MTL's Phong materials to ours.
//! Source: Wavefront MTL 4.2 (`illum` models); [WMLT07] for roughness from an exponent: alpha = sqrt(2 / (Ns + 2)).
//!
//! | MTL | here |
//! |---|---|
//! | `illum` 4, 6, 7, 9; or `d` < 1 with `Kd` 0 and `Ni` > 1 or `Tf` | glass of `Ni`, tinted by `Tf`; rough where there is a `Pr` |
//! | `illum` 3 or 5 with `Ks` above `Kd`; or `Kd` 0 and `Ks` >= 0.2 | metal of `Ks`; a mirror if `Ns` is absent or >= 1000 |
//! | `Pm`, `Pr`, `Ps`, `Pc`, `Pcr`, `aniso` or `anisor` (the PBR extension; the last in full rotations) | metallic-roughness as given, of the index `Ni` if it is above 1, with sheen, clear coat, anisotropic microfacets |
//! | `Kd` and `Ks` with `Ns` | plastic whose normal reflectance is the mean of `Ks` |
//! | otherwise | matte |
//!
//! `bump` and its `-bm` are heights, and `disp` where there is no `bump`: 1 = white lies a texel's width above black. A picture of
//! `bump` that is blue as normal maps are is one ([`holds_normals`]): Blender writes them so. `norm` is one, too.
//! The diffuse colour always stays `Kd` times `map_Kd` (`Material::diffuse`). `Ke` is radiance. `d` < 1 that did not make
//! glass is opacity. Tests: `tests/obj.rs::materials_become_ours`.

use std::collections::HashMap;
use std::path::PathBuf;

use super::directives::MapStatement;
use super::maps;
use super::mtl::{Entry, Library, Map};
use super::normals::{holds_normals, with_normals};
use crate::detail::{Anisotropy, Interior};
use crate::id::{MaterialId, TextureId};
use crate::io::error::quoted;
use crate::io::source::{self, Access};
use crate::io::textures::{Meaning, Pictures};
use crate::io::{Error, Oddity, Warnings};
use crate::layer_textures::LayerTextures;
use crate::material::{
    Alpha, BumpMap, Color, DEFAULT_ALBEDO, Material, NormalMap, Opacity, OpacityChannel, Principled, Surface,
    TextureRef,
};
use crate::scene::Scene;
use crate::shader_file::ShaderFile;
use crate::texture::{Filter, Texture, Wrap};
use gnurt_image::Excess;

/// Bytes of a material of the scene, without its name.
const MATERIAL_BYTES: usize = size_of::<Material>() + size_of::<Principled>() + 64;
/// Bytes of a texture of the scene, without its names and its texels.
const TEXTURE_BYTES: usize = 256;
/// Roughness of sheen, of which MTL gives only the strength.
const SHEEN_ROUGHNESS: f32 = 0.5;
/// From this exponent on a highlight is a mirror image.
const MIRROR_EXPONENT: f32 = 1000.0;

/// Adds the default material and those of the library to the scene, in the order of their numbers; also
/// returns the files of their textures.
pub(super) fn add_all(
    library: &Library,
    access: &Access,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<(Vec<MaterialId>, Vec<PathBuf>), Error> {
    for entry in &library.entries {
        let excess = |e: Excess| Error::data(&entry.path, None, e.to_string(), Excess::REMEDY);
        access.budget.hold(MATERIAL_BYTES + entry.name.len()).map_err(excess)?;
        if access.is_confined() {
            check_maps(entry, access)?;
        }
    }
    let mut textures = Textures { access, pictures: Pictures::new(access), known: HashMap::new() };
    let default = scene.add_material(Material::matte("default", [DEFAULT_ALBEDO; 3]));
    let mut materials = vec![default];
    for entry in &library.entries {
        let material = convert(entry, scene, &mut textures, warnings);
        let id = scene.add_material(material);
        materials.push(id);
        if let Some(map_statement) = &entry.shader {
            match shader_file(entry, map_statement, access) {
                Ok(file) => scene.set_shader_file(id, file),
                Err(why) => {
                    warnings.note(Oddity::BadMaterialLine, &entry.path, Some(map_statement.line), why)
                }
            }
        }
    }
    Ok((materials, textures.pictures.paths()))
}

/// `FILE [NAME=VALUE ...]`: the file's name ends where the first parameter begins.
fn shader_file(entry: &Entry, map_statement: &Map, access: &Access) -> Result<ShaderFile, String> {
    let parts: Vec<&str> = map_statement.text.split_whitespace().collect();
    let first = parts.iter().position(|part| part.contains('=')).unwrap_or(parts.len());
    if first == 0 {
        return Err("`gnurt_shader` without a file name".into());
    }
    let pair = |part: &&str| match part.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("`gnurt_shader`: expected NAME=VALUE behind the file".to_owned()),
    };
    let parameters = parts[first..].iter().map(pair).collect::<Result<_, _>>()?;
    let file = source::resolve(&entry.path, &parts[..first].join(" "));
    Ok(ShaderFile { file, parameters, confined_to: access.confined_to(), ..ShaderFile::default() })
}

/// Rejects textures outside of the folder that confines the file.
fn check_maps(entry: &Entry, access: &Access) -> Result<(), Error> {
    let maps = [&entry.map_kd, &entry.map_ke, &entry.map_d, &entry.bump, &entry.disp, &entry.norm];
    let layers = [&entry.map_pr, &entry.map_pm, &entry.map_ps, &entry.map_pc, &entry.map_pcr];
    for map in maps.into_iter().chain(layers).flatten() {
        if let Some(statement) = MapStatement::parse(&map.text) {
            let outside = |(problem, remedy)| Error::data(&entry.path, Some(map.line), problem, remedy);
            access.check(&source::resolve(&entry.path, &statement.file)).map_err(outside)?;
        }
    }
    if let Some(map_statement) = &entry.shader
        && let Ok(shader) = shader_file(entry, map_statement, access)
    {
        let outside = |(problem, remedy)| Error::data(&entry.path, Some(map_statement.line), problem, remedy);
        access.check(&shader.file).map_err(outside)?;
    }
    Ok(())
}

fn convert(entry: &Entry, scene: &mut Scene, textures: &mut Textures, warnings: &mut Warnings) -> Material {
    let mut map = |map: &Option<Box<Map>>, meaning| {
        map.as_ref().and_then(|map| textures.add(entry, map, meaning, scene, warnings))
    };
    let map_kd = map(&entry.map_kd, Meaning::Color);
    let map_ke = map(&entry.map_ke, Meaning::Color);
    let map_d = map(&entry.map_d, Meaning::Data);
    let heights = if entry.bump.is_some() { &entry.bump } else { &entry.disp };
    let height_of = |map: &Option<Box<Map>>| {
        let map_statement = map.as_ref().and_then(|map| MapStatement::parse(&map.text));
        map_statement.map_or(1.0, |map_statement| map_statement.bump)
    };
    let mut normals =
        map(&entry.norm, Meaning::Data).map(|texture| NormalMap { texture, scale: height_of(&entry.norm) });
    let mut bump = map(heights, Meaning::Data).map(|texture| BumpMap { texture, height: height_of(heights) });
    if let Some(map) = bump.filter(|map| holds_normals(&scene.texture(map.texture.texture).texels)) {
        bump = None;
        let line = heights.as_ref().map(|map| map.line);
        let name = &scene.texture(map.texture.texture).name;
        warnings.note(Oddity::NormalsForHeights, &entry.path, line, quoted(name));
        normals = normals.or(Some(NormalMap { texture: map.texture, scale: map.height }));
    }

    let [map_pr, map_pm, map_ps, map_pc, map_pcr] =
        [&entry.map_pr, &entry.map_pm, &entry.map_ps, &entry.map_pc, &entry.map_pcr]
            .map(|of| textures.add_some(entry, of, scene, warnings));
    let details = maps::packed(textures.access, scene, map_pr, map_pm).unwrap_or_else(|why| {
        warnings.note(Oddity::BadTexture, &entry.path, None, why);
        None
    });
    let layers = LayerTextures {
        sheen_color: map_ps,
        clearcoat: map_pc,
        clearcoat_roughness: map_pcr,
        ..LayerTextures::default()
    };

    let phong = Phong::of(entry, warnings);
    let diffuse = Color { factor: phong.kd, texture: map_kd };
    let plain = maps::with_maps(phong.surface(diffuse), details, layers);
    let surface = match normals {
        None => plain,
        Some(normals) => with_normals(plain, normals).unwrap_or_else(|plain| {
            let detail = format!("normal map of glass, {}", quoted(&entry.name));
            warnings.note(Oddity::NotShown, &entry.path, None, detail);
            plain
        }),
    };
    let glass = matches!(surface, Surface::Dielectric { .. } | Surface::RoughDielectric { .. });
    let lost = glass || matches!(surface, Surface::Mirror { .. }) || surface.base_color() != diffuse;
    let opacity = Opacity { factor: phong.d, texture: map_d, channel: OpacityChannel::Red };
    let alpha =
        if glass || (phong.d >= 1.0 && map_d.is_none()) { Alpha::Opaque } else { Alpha::Blend { opacity } };
    Material {
        diffuse: lost.then_some(diffuse),
        emission: phong.ke.unwrap_or(if map_ke.is_some() { [1.0; 3] } else { [0.0; 3] }),
        emission_texture: map_ke,
        alpha,
        bump,
        ..Material::of(&*entry.name, surface)
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
    anisotropy: Anisotropy,
}

impl Phong {
    fn of(entry: &Entry, warnings: &mut Warnings) -> Self {
        warn_out_of_range(entry, warnings);
        let not_negative = |c: [f32; 3]| c.map(|x| x.max(0.0));
        let unit = |x: f32| x.clamp(0.0, 1.0);
        let whole = |map: &Option<Box<Map>>| map.as_ref().map(|_| 1.0);
        let ke = entry.ke.map(not_negative);
        // Without `Kd`: white under a map, black with other keywords, grey with none.
        let says_else = ke.is_some() || entry.ks.is_some() || entry.illum.is_some_and(|model| model > 2);
        let default_kd = match (entry.map_kd.is_some(), says_else) {
            (true, _) => 1.0,
            (false, true) => 0.0,
            (false, false) => DEFAULT_ALBEDO,
        };
        Self {
            kd: not_negative(entry.kd.unwrap_or([default_kd; 3])),
            ks: not_negative(entry.ks.unwrap_or([0.0; 3])),
            ke,
            tf: entry.tf.map(not_negative),
            ns: entry.ns,
            ni: entry.ni.filter(|&ni| ni > 0.0),
            d: unit(entry.d.or(entry.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0)),
            illum: entry.illum.unwrap_or(2),
            // A map alone counts as it is.
            metallic: entry.pm.map(unit).or(whole(&entry.map_pm)),
            roughness: entry.pr.map(unit).or(whole(&entry.map_pr)),
            sheen: entry.ps.map(unit).or(whole(&entry.map_ps)),
            coat: entry.pc.map(unit).or(whole(&entry.map_pc)),
            coat_roughness: entry.pcr.map(unit).or(whole(&entry.map_pcr)),
            anisotropy: Anisotropy {
                strength: entry.aniso.map_or(0.0, unit),
                rotation: entry.anisor.unwrap_or(0.0) * std::f32::consts::TAU,
                texture: None,
            },
        }
    }

    fn surface(&self, diffuse: Color) -> Surface {
        let mean = |c: [f32; 3]| c.iter().sum::<f32>() / 3.0;
        let (kd, ks) = (mean(self.kd), mean(self.ks));
        let black = kd == 0.0;
        let refracts = self.tf.is_some() || self.ni.is_some_and(|ni| ni > 1.0);
        if matches!(self.illum, 4 | 6 | 7 | 9) || (self.d < 1.0 && black && refracts) {
            let (ior, transmittance) = (self.ni.unwrap_or(1.5), self.tf.unwrap_or([1.0; 3]));
            let (reflectance, interior) = ([1.0; 3], Interior::default());
            return match self.roughness.filter(|&roughness| roughness > 0.0) {
                None => Surface::Dielectric { ior, reflectance, transmittance, interior },
                Some(roughness) => {
                    let thin = false;
                    Surface::RoughDielectric { ior, roughness, reflectance, transmittance, thin, interior }
                }
            };
        }
        // Many programs write an index of 1 if it is unknown.
        let ior = self.ni.filter(|&ni| ni > 1.0).unwrap_or(1.5);
        let layers = [self.sheen, self.coat].map(|x| x.unwrap_or(0.0));
        if layers != [0.0; 2] || self.anisotropy.strength > 0.0 {
            return Surface::Principled(Box::new(Principled {
                base_color: diffuse,
                metallic: self.metallic.unwrap_or(0.0),
                roughness: self.roughness.unwrap_or(0.5),
                ior,
                sheen_color: [layers[0]; 3],
                sheen_roughness: if layers[0] > 0.0 { SHEEN_ROUGHNESS } else { 0.0 },
                clearcoat: layers[1],
                clearcoat_roughness: self.coat_roughness.unwrap_or(0.0),
                anisotropy: self.anisotropy,
                ..Principled::default()
            }));
        }
        if self.metallic.is_some() || self.roughness.is_some() {
            return metallic_roughness(
                diffuse,
                self.metallic.unwrap_or(0.0),
                self.roughness.unwrap_or(0.5),
                ior,
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

/// Numbers that are brought into their range before they are used.
fn warn_out_of_range(entry: &Entry, warnings: &mut Warnings) {
    let mut tell = |keyword: &str, value: f32, range: &str| {
        let detail = format!("`{keyword} {value}` of {}; {range}", quoted(&entry.name));
        warnings.note(Oddity::NumberOutOfRange, &entry.path, None, detail);
    };
    let shares = [
        ("d", entry.d),
        ("Tr", entry.tr),
        ("Pm", entry.pm),
        ("Pr", entry.pr),
        ("Ps", entry.ps),
        ("Pc", entry.pc),
        ("Pcr", entry.pcr),
        ("aniso", entry.aniso),
    ];
    for (keyword, value) in shares {
        if let Some(value) = value.filter(|value| !(0.0..=1.0).contains(value)) {
            tell(keyword, value, "expected 0 to 1");
        }
    }
    for (keyword, color) in [("Kd", entry.kd), ("Ks", entry.ks), ("Ke", entry.ke), ("Tf", entry.tf)] {
        if let Some(value) = color.and_then(|color| color.into_iter().find(|&x| x < 0.0)) {
            tell(keyword, value, "expected 0 or more");
        }
    }
    if let Some(value) = entry.ni.filter(|&ni| ni <= 0.0) {
        tell("Ni", value, "expected more than 0");
    }
    if let Some(value) = entry.ns.filter(|&ns| ns < 0.0) {
        tell("Ns", value, "expected 0 or more");
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

/// Textures of the scene by their names.
struct Textures<'a> {
    access: &'a Access,
    pictures: Pictures<'a>,
    known: HashMap<(PathBuf, Meaning, Wrap), TextureId>,
}

impl Textures<'_> {
    /// A texture of numbers, if it is named.
    fn add_some(
        &mut self,
        entry: &Entry,
        map: &Option<Box<Map>>,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> Option<TextureRef> {
        self.add(entry, map.as_ref()?, Meaning::Data, scene, warnings)
    }

    fn add(
        &mut self,
        entry: &Entry,
        map: &Map,
        meaning: Meaning,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> Option<TextureRef> {
        let mut warn = |why: String| warnings.note(Oddity::BadTexture, &entry.path, Some(map.line), why);
        let Some(map) = MapStatement::parse(&map.text) else {
            warn("no file is named".into());
            return None;
        };
        let path = source::resolve(&entry.path, &map.file);
        let key = (path, meaning, map.wrap);
        let texture = match self.known.get(&key) {
            Some(&texture) => texture,
            None => {
                let held = self.access.budget.hold(TEXTURE_BYTES + map.file.len() + key.0.as_os_str().len());
                let texels = held.map_err(|e| e.to_string());
                let texels = match texels.and_then(|()| self.pictures.file(&key.0, meaning)) {
                    Ok(texels) => texels,
                    Err(why) => {
                        warn(why);
                        return None;
                    }
                };
                let (wrap, filter) = ([map.wrap; 2], Filter::Linear);
                let texture = scene.add_texture(Texture { name: map.file.clone(), texels, wrap, filter });
                self.known.insert(key, texture);
                texture
            }
        };
        Some(TextureRef { uv_from_mesh: map.uv_from_mesh(), ..TextureRef::new(texture) })
    }
}
