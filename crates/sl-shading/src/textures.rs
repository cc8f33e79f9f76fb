// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures that shaders read, each file once.
//! Wrap modes and options are OSL's. Colours of pictures of integers are decoded to linear light, as
//! everywhere in GNU RT, except where a shader declares them linear, or no colours (`"colorspace"`). Where a
//! point covers more than a texel, smaller copies are read: over the ellipse of the changes of s and t, as
//! materials of files do. A name with a pattern such as `<UDIM>` is a file for each unit square of s and t; tiles
//! without a file have the values of a missing file and no message, as with OpenImageIO.
//! Tests: `tests/scripts/{kinds,relief,tiles}.rs`.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, RwLock};

use gnurt_image::udim::{is_tiled, tile_at, tile_name, tiles};
use gnurt_image::{read_data_texture, read_stored, read_texture};
use gnurt_shading::script::sampler;
use gnurt_shading::texture::{TextureSampler, Wrap};
use gnurt_sl::exec::{DualRow, TextureOptions, lanes_of};
use gnurt_sl::hir::Data;
use gnurt_sl::types::Type;
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::points::{PointCloud, read_cloud};

use crate::access::Access;
use crate::texture_info::{TextureInfo, common};
use crate::volumes::{Volumes, color_at_place};

/// Limit of stored names, those that are no pictures among them.
const MOST: usize = 4096;

type Found = Result<Arc<TextureSampler>, Arc<str>>;
type FoundInfo = Result<Arc<TextureInfo>, Arc<str>>;
type FoundCloud = Result<Arc<PointCloud>, Arc<str>>;

/// Pictures by the names that shaders call them.
#[derive(Debug, Default)]
pub(crate) struct Textures {
    access: Access,
    /// The folder to search after the current folder.
    folder: PathBuf,
    /// Those whose values are decoded; those whose values are as they are stored.
    known: [RwLock<HashMap<String, Found>>; 2],
    infos: Mutex<HashMap<String, FoundInfo>>,
    /// The tiles of names with patterns.
    present: RwLock<HashMap<String, Arc<[[u32; 2]]>>>,
    clouds: Mutex<HashMap<String, FoundCloud>>,
    volumes: Volumes,
}

impl Textures {
    pub(crate) fn new(access: Access, folder: PathBuf) -> Self {
        Self {
            access,
            folder,
            known: Default::default(),
            infos: Mutex::default(),
            present: RwLock::default(),
            clouds: Mutex::default(),
            volumes: Volumes::default(),
        }
    }

    /// The picture of a name, of a colour space.
    pub(crate) fn find(&self, name: &str, color_space: &str) -> Found {
        let lost = || Arc::from("its memory is lost");
        if let Some(sampler) = self.access.pictures.get(name) {
            return Ok(sampler.clone());
        }
        let is_raw = is_raw(color_space)?;
        let known = &self.known[usize::from(is_raw)];
        if let Some(found) = known.read().map_err(|_| lost())?.get(name) {
            return found.clone();
        }
        let mut known = known.write().map_err(|_| lost())?;
        if let Some(found) = known.get(name) {
            return found.clone();
        }
        if known.len() >= MOST {
            return Err(format!("more than {MOST} pictures").into());
        }
        let found = self.read(name, is_raw);
        known.insert(name.to_owned(), found.clone());
        found
    }

    /// The picture of a tile; `None` if there is none.
    fn find_tile(
        &self,
        name: &str,
        tile: [u32; 2],
        color_space: &str,
    ) -> Result<Option<Arc<TextureSampler>>, Arc<str>> {
        let is_there = self.tiles_of(name).contains(&tile);
        is_there.then(|| self.find(&tile_name(name, tile), color_space)).transpose()
    }

    /// Whether there is a picture of this name.
    fn has(&self, name: &str) -> bool {
        self.access.pictures.contains_key(name) || self.path(name).is_file()
    }

    /// The tiles that a name has; they are searched once.
    fn tiles_of(&self, name: &str) -> Arc<[[u32; 2]]> {
        if let Some(found) = self.present.read().ok().and_then(|present| present.get(name).cloned()) {
            return found;
        }
        let found: Arc<[[u32; 2]]> = tiles().filter(|&tile| self.has(&tile_name(name, tile))).collect();
        if let Ok(mut present) = self.present.write()
            && present.len() < MOST
        {
            present.insert(name.to_owned(), found.clone());
        }
        found
    }

    /// A property of a picture, of its tile at `at`, or of all its tiles.
    pub(crate) fn info(&self, name: &str, at: Option<[f32; 2]>, what: &str, ty: Type) -> Option<Data> {
        let flag = |is: bool| (ty == Type::INT).then(|| Data::Int(vec![i32::from(is)]));
        if what == "udim" {
            return flag(is_tiled(name));
        }
        let names: Vec<String> = match (is_tiled(name), at) {
            (false, _) => vec![name.to_owned()],
            (true, Some(at)) => tile_at(at).map(|(tile, _)| tile_name(name, tile)).into_iter().collect(),
            (true, None) => self.tiles_of(name).iter().map(|&tile| tile_name(name, tile)).collect(),
        };
        let infos: Result<Vec<_>, _> = names.iter().map(|name| self.info_of(name)).collect();
        if what == "exists" {
            return flag(infos.is_ok_and(|infos| !infos.is_empty()));
        }
        common(infos.ok()?.iter().map(|info| info.answer(what, ty)))
    }

    fn info_of(&self, name: &str) -> FoundInfo {
        let lost = || Arc::from("its memory is lost");
        if let Some(found) = self.infos.lock().map_err(|_| lost())?.get(name) {
            return found.clone();
        }
        let found = self.find(name, "").and_then(|sampler| {
            let of_file = || read_stored(&self.allowed(name)?).map_err(|error| error.to_string());
            let mut file = match self.access.pictures.contains_key(name) {
                true => gnurt_image::Stored::of_texels(&sampler.texels),
                false => of_file()?,
            };
            file.levels.clear();
            Ok(Arc::new(TextureInfo { file, mean: sampler.mean() }))
        });
        let mut infos = self.infos.lock().map_err(|_| lost())?;
        if infos.len() < MOST {
            infos.insert(name.to_owned(), found.clone());
        }
        found
    }

    /// Where a file is that a shader names.
    fn path(&self, name: &str) -> PathBuf {
        let path = [PathBuf::from(name), self.folder.join(name)].into_iter().find(|path| path.is_file());
        path.unwrap_or_else(|| self.folder.join(name))
    }

    /// The text of a file, if it may be read.
    pub(crate) fn text(&self, name: &str) -> Option<String> {
        self.access.text(&self.path(name)).ok()
    }

    /// The point cloud of a name.
    pub(crate) fn cloud(&self, name: &str) -> FoundCloud {
        let Ok(mut clouds) = self.clouds.lock() else { return Err("its memory is lost".into()) };
        if let Some(found) = clouds.get(name) {
            return found.clone();
        }
        if clouds.len() >= MOST {
            return Err(format!("more than {MOST} point clouds").into());
        }
        let text = self.access.text(&self.path(name));
        let found = text.and_then(|text| read_cloud(&text));
        let found = found.map(Arc::new).map_err(|why| format!("point cloud {name}: {why}").into());
        clouds.insert(name.to_owned(), found.clone());
        found
    }

    /// Where a file is that a shader names, if it may be read.
    fn allowed(&self, name: &str) -> Result<Arc<Path>, String> {
        let path = self.path(name);
        if self.access.allows(&path) {
            return Ok(path.into());
        }
        let why = "missing, or outside of the folder that files may come from";
        Err(format!("texture {}: {why}", path.display()))
    }

    fn read(&self, name: &str, is_raw: bool) -> Found {
        let path = self.allowed(name)?;
        match if is_raw { read_data_texture(&path) } else { read_texture(&path) } {
            Ok(texels) => Ok(Arc::new(sampler(Arc::new(texels)))),
            Err(error) => Err(format!("texture {error}").into()),
        }
    }

    /// Four channels of a volume at a position.
    pub(crate) fn sample3d(
        &self,
        file: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String> {
        let volume = self.volumes.find(file, || self.allowed(file)).map_err(|why| why.to_string())?;
        color_at_place(&volume, file, at, options)
    }

    /// Four channels at `s` and `t`, t downwards, with derivatives if those are requested.
    pub(crate) fn sample(
        &self,
        file: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String> {
        if !is_tiled(file) {
            let sampler = self.find(file, &options.color_space).map_err(|why| why.to_string())?;
            return Ok(WrapOptions::of(&sampler, options).read(at));
        }
        let Some((tile, within)) = tile_at([at[0].value, at[1].value]) else { return Err(String::new()) };
        let sampler = self.find_tile(file, tile, &options.color_space).map_err(|why| why.to_string())?;
        // A missing tile is no fault.
        let sampler = sampler.ok_or_else(String::new)?;
        Ok(WrapOptions::of_tile(&sampler, options).read(moved(at, within)))
    }

    /// The same for many points; false if there is no such picture.
    pub(crate) fn sample_each(
        &self,
        file: &str,
        lanes: u32,
        [s, t]: &[DualRow; 2],
        options: &TextureOptions,
        out: &mut [DualRow; 4],
    ) -> bool {
        if is_tiled(file) {
            return self.sample_tiles(file, lanes, [s, t], options, out);
        }
        let Ok(sampler) = self.find(file, &options.color_space) else { return false };
        let wrap_options = WrapOptions::of(&sampler, options);
        for i in lanes_of(lanes) {
            // Written out: mapping arrays becomes calls.
            let texel = wrap_options.read([s.get(i), t.get(i)]);
            for (row, x) in out.iter_mut().zip(texel) {
                row.set(i, x);
            }
        }
        true
    }

    /// The same for a name of tiles; false if a point is in none.
    fn sample_tiles(
        &self,
        file: &str,
        mut lanes: u32,
        [s, t]: [&DualRow; 2],
        options: &TextureOptions,
        out: &mut [DualRow; 4],
    ) -> bool {
        let place = |i: usize| {
            let at = [s.get(i), t.get(i)];
            let (tile, within) = tile_at([at[0].value, at[1].value])?;
            Some((tile, moved(at, within)))
        };
        while lanes != 0 {
            // All points in the tile of the first one.
            let Some((tile, _)) = place(lanes.trailing_zeros() as usize) else { return false };
            let Ok(Some(sampler)) = self.find_tile(file, tile, &options.color_space) else { return false };
            let wrap_options = WrapOptions::of_tile(&sampler, options);
            for i in lanes_of(lanes) {
                let Some((_, at)) = place(i).filter(|(other, _)| *other == tile) else { continue };
                for (row, x) in out.iter_mut().zip(wrap_options.read(at)) {
                    row.set(i, x);
                }
                lanes &= !(1 << i);
            }
        }
        true
    }
}

/// A position with these values, and its own derivatives.
fn moved(at: [Dual<f32>; 2], to: [f32; 2]) -> [Dual<f32>; 2] {
    std::array::from_fn(|k| Dual { value: to[k], ..at[k] })
}

/// Whether values of this colour space are as they are stored.
fn is_raw(color_space: &str) -> Result<bool, Arc<str>> {
    match color_space.to_ascii_lowercase().as_str() {
        "" | "auto" | "srgb" | "srgb_texture" | "srgb_rec709_scene" => Ok(false),
        "raw" | "data" | "linear" | "scene_linear" | "lin_rec709" | "lin_srgb" | "lin_rec709_scene" => Ok(true),
        _ => Err(format!(
            "texture: unknown colour space \"{color_space}\"; valid are \"srgb\" (the default), \"linear\" and \"raw\""
        )
        .into()),
    }
}

/// How a picture is read.
struct WrapOptions<'a> {
    sampler: Cow<'a, TextureSampler>,
    options: &'a TextureOptions,
    /// Whether it is black beyond its borders, along s and t.
    is_bordered: [bool; 2],
}

impl<'a> WrapOptions<'a> {
    /// Of a tile: what is beyond its border is another tile, so its border goes on.
    fn of_tile(sampler: &'a TextureSampler, options: &'a TextureOptions) -> Self {
        let linear = &*options.interpolation != "closest";
        let sampler = Cow::Owned(TextureSampler { wrap: [Wrap::Clamp; 2], linear, ..sampler.clone() });
        Self { sampler, options, is_bordered: [false; 2] }
    }

    fn of(sampler: &'a TextureSampler, options: &'a TextureOptions) -> Self {
        let wrap = |k: usize| match &*options.wrap[k] {
            "periodic" => Wrap::Repeat,
            "mirror" => Wrap::Mirror,
            _ => Wrap::Clamp,
        };
        let wrap = [wrap(0), wrap(1)];
        let linear = &*options.interpolation != "closest";
        let sampler = if sampler.wrap == wrap && linear {
            Cow::Borrowed(sampler)
        } else {
            Cow::Owned(TextureSampler { wrap, linear, ..sampler.clone() })
        };
        let is_black = |k: usize| matches!(&*options.wrap[k], "black" | "default" | "");
        Self { sampler, options, is_bordered: [is_black(0), is_black(1)] }
    }

    /// The texel, and its derivatives from pixel to pixel by the picture's slopes.
    fn read(&self, [s, t]: [Dual<f32>; 2]) -> [Dual<f32>; 4] {
        let Self { options, is_bordered, .. } = self;
        let outside = |k: usize, x: f32| is_bordered[k] && !(0.0..=1.0).contains(&x);
        if outside(0, s.value) || outside(1, t.value) {
            return [0.0; 4].map(Dual::from);
        }
        let uv = [s.value, 1.0 - t.value];
        let [across, along] = options.width;
        let axes = [[s.dx * across, -t.dx * along], [s.dy * across, -t.dy * along]];
        let axes = blurred(axes, options.blur);
        let texel = self.channels(uv, axes);
        let is_still = [s, t].iter().all(|x| x.dx == 0.0 && x.dy == 0.0);
        // Nearest texels are flat.
        if !options.derivs || is_still || &*options.interpolation == "closest" {
            return texel.map(Dual::from);
        }
        let [by_s, by_t] = self.slopes(uv, axes);
        std::array::from_fn(|k| {
            let change = |ds: f32, dt: f32| by_s[k] * ds + by_t[k] * dt;
            Dual::new(texel[k], change(s.dx, t.dx), change(s.dy, t.dy))
        })
    }

    /// Derivatives of channels by s and t around a position: over a texel, or over a larger footprint, so
    /// that slopes have no steps at texels' borders. Bump maps of materials do the same.
    fn slopes(&self, [u, v]: [f32; 2], axes: [[f32; 2]; 2]) -> [[f32; 4]; 2] {
        let [[ux, vx], [uy, vy]] = axes;
        let stands_for = (ux * vy - uy * vx).abs().sqrt();
        let texels = &self.sampler.texels;
        // Over all of it there is no slope.
        let [du, dv] =
            [texels.width, texels.height].map(|count| (1.0 / count as f32).max(stands_for).min(1.0));
        let between = |a: [f32; 4], b: [f32; 4], step: f32| std::array::from_fn(|k| (b[k] - a[k]) / step);
        let at = |u: f32, v: f32| self.channels([u, v], axes);
        let by_s = between(at(u - 0.5 * du, v), at(u + 0.5 * du, v), du);
        // t goes downwards.
        let by_t = between(at(u, v + 0.5 * dv), at(u, v - 0.5 * dv), dv);
        [by_s, by_t]
    }

    /// The requested channels, over an ellipse.
    fn channels(&self, uv: [f32; 2], axes: [[f32; 2]; 2]) -> [f32; 4] {
        let Self { sampler, options, .. } = self;
        let texel = sampler.sample_over(uv, axes);
        let first = options.first_channel;
        if first == 0 {
            return texel;
        }
        std::array::from_fn(|k| {
            let k = first.saturating_add(k as i32);
            usize::try_from(k).ok().and_then(|k| texel.get(k).copied()).unwrap_or(options.fill)
        })
    }
}

/// The axes of an ellipse that is wider by `blur` along s and t: squares of widths add up.
fn blurred([x, y]: [[f32; 2]; 2], blur: [f32; 2]) -> [[f32; 2]; 2] {
    if blur == [0.0; 2] {
        return [x, y];
    }
    let (ss, st, tt) = (
        x[0] * x[0] + y[0] * y[0] + blur[0] * blur[0],
        x[0] * x[1] + y[0] * y[1],
        x[1] * x[1] + y[1] * y[1] + blur[1] * blur[1],
    );
    // A triangular root of that matrix is as good a pair of axes as any.
    let first = ss.sqrt();
    let shear = if first > 0.0 { st / first } else { 0.0 };
    [[first, shear], [0.0, (tt - shear * shear).max(0.0).sqrt()]]
}
