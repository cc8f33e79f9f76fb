// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures as OSL's own tools read them: for `testshade`, whose output is compared with theirs.
//! The computation follows OpenImageIO, whose texture system OSL's tools use: `filter` chooses the ellipse
//! and the levels of a file, `sample` reads a level at a position, `copies` makes missing levels. Values are
//! the stored ones, without a colour space; renderings read pictures otherwise (`textures`).
//! Tests: `tests/scripts/stored.rs`; OSL's suite (bench/record/osl-suite.md).

mod copies;
mod filter;
mod sample;

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::{Arc, Mutex};

use gnurt_image::udim::{COLUMNS, ROWS, is_tiled, tile_name, tiles};
use gnurt_image::{Stored, read_stored};
use gnurt_sl::exec::TextureOptions;
use gnurt_sl::hir::Data;
use gnurt_sl::stored::Textures;
use gnurt_sl::types::Type;
use gnurt_sl_lib::Dual;

use crate::texture_info::{answer, common};
use crate::volumes::{Volumes, at_place};
use crate::wrap::Wrap;
use sample::Read;

/// Limit of stored names.
const MOST: usize = 4096;

type Found = Result<Arc<Stored>, Arc<str>>;

/// Pictures by their files' names, each read once.
#[derive(Debug, Default)]
pub struct StoredTextures {
    known: Mutex<HashMap<String, Found>>,
    volumes: Volumes,
    /// The files of names of tiles, in the order of their numbers.
    tiles: Mutex<HashMap<String, Arc<[String]>>>,
    /// Files about which was complained.
    reported: Mutex<HashSet<String>>,
}

/// The file that a name with a pattern means at a position, and the position in it.
fn tile(name: &str, [s, t]: [f32; 2]) -> Option<(String, [f32; 2])> {
    let tile = [(s, COLUMNS), (t, ROWS)].map(|(x, count)| x.floor().clamp(0.0, (count - 1) as f32) as u32);
    is_tiled(name).then(|| (tile_name(name, tile), [s - s.floor(), t - t.floor()]))
}

impl StoredTextures {
    fn find(&self, name: &str) -> Found {
        let Ok(mut known) = self.known.lock() else { return Err("its memory is lost".into()) };
        if let Some(found) = known.get(name) {
            return found.clone();
        }
        if known.len() >= MOST {
            return Err(format!("more than {MOST} pictures").into());
        }
        let found = read(name);
        known.insert(name.to_owned(), found.clone());
        found
    }

    /// The files that a name of tiles has; they are searched once.
    fn tiles_of(&self, name: &str) -> Arc<[String]> {
        if let Some(found) = self.tiles.lock().ok().and_then(|known| known.get(name).cloned()) {
            return found;
        }
        let found: Arc<[String]> =
            tiles().map(|tile| tile_name(name, tile)).filter(|name| Path::new(name).is_file()).collect();
        if let Ok(mut known) = self.tiles.lock()
            && known.len() < MOST
        {
            known.insert(name.to_owned(), found.clone());
        }
        found
    }

    /// The reason, if it has not been given before.
    fn once(&self, name: &str, why: &str) -> String {
        let is_new = self
            .reported
            .lock()
            .is_ok_and(|mut reported| reported.len() < MOST && reported.insert(name.to_owned()));
        if is_new { why.to_owned() } else { String::new() }
    }

    /// The picture, its wrap modes, and its subimage.
    fn open(&self, name: &str, options: &TextureOptions) -> Result<(Arc<Stored>, [Wrap; 2], usize), String> {
        let file = self.find(name).map_err(|why| self.once(name, &why))?;
        let first = usize::try_from(options.first_channel).unwrap_or(0);
        let of_file = file.text("wrapmodes").map(Wrap::of_file).unwrap_or([Wrap::Black; 2]);
        let wrap = [0, 1].map(|k: usize| Wrap::named(&options.wrap[k]).unwrap_or(of_file[k]));
        Ok((file, wrap, first))
    }
}

/// Where a file is, if it is there.
fn path_of(name: &str) -> Result<&Path, String> {
    if name.is_empty() {
        return Err("ImageInput::create() called with no filename".into());
    }
    let path = Path::new(name);
    let is_there = path.exists().then_some(path);
    is_there.ok_or_else(|| format!("Could not open file: {name}: No such file or directory"))
}

fn read(name: &str) -> Found {
    let file = read_stored(path_of(name)?).map_err(|error| error.to_string())?;
    Ok(Arc::new(copies::with_copies(file)))
}

/// A property of a file. The mean of a file that fills a part of its window is 0 unless the file notes it: OpenImageIO reads it
/// beside the single texel of the smallest copy.
fn property(file: &Stored, what: &str, ty: Type) -> Option<Data> {
    let found = answer(file, what, ty)?;
    let is_beside =
        what == "averagecolor" && file.window != file.display && file.text("oiio:AverageColor").is_none();
    Some(match found {
        Data::Float(list) if is_beside => Data::Float(vec![0.0; list.len()]),
        found => found,
    })
}

/// A single channel becomes red, and missing channels are filled.
fn completed(mut texel: Read, file: &Stored, options: &TextureOptions, first: usize) -> Read {
    if file.channels == 1 && options.channels >= 3 && first == 0 {
        (texel[1], texel[2]) = (texel[0], texel[0]);
    } else if file.channels == 2 && options.channels == 4 && first == 0 && file.alpha == Some(1) {
        texel = [texel[0], texel[0], texel[0], texel[1]];
    }
    texel
}

impl Textures for StoredTextures {
    fn texture(
        &self,
        name: &str,
        at: [Dual<f32>; 2],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String> {
        let mut path_of = [at[0].value, at[1].value];
        let tile = tile(name, path_of);
        if let Some((_, within)) = &tile {
            path_of = *within;
        }
        let name = tile.as_ref().map_or(name, |(name, _)| name);
        let (file, wrap, first) = self.open(name, options)?;
        let [dx, dy] = [[at[0].dx, at[1].dx], [at[0].dy, at[1].dy]];
        let texel = filter::over_ellipse(&file, path_of, [dx, dy], options, (wrap, first));
        Ok(completed(texel, &file, options, first)
            .map(|[value, ds, dt]| Dual::new(value, ds * dx[0] + dt * dx[1], ds * dy[0] + dt * dy[1])))
    }

    fn environment(
        &self,
        name: &str,
        direction: [Dual<f32>; 3],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String> {
        let (file, _, first) = self.open(name, options)?;
        let texel = filter::around(&file, direction, options, first);
        Ok(completed(texel, &file, options, first).map(|[value, ..]| value.into()))
    }

    fn texture3d(
        &self,
        name: &str,
        at: [Dual<f32>; 3],
        options: &TextureOptions,
    ) -> Result<[Dual<f32>; 4], String> {
        let volume = self.volumes.find(name, || path_of(name).map(Arc::from));
        let volume = volume.map_err(|why| self.once(name, &why))?;
        at_place(&volume, name, at, options).map(|(texel, _)| texel)
    }

    fn info(&self, name: &str, at: Option<[f32; 2]>, what: &str, ty: Type) -> Result<Option<Data>, String> {
        let tiled = is_tiled(name);
        let flag = |is: bool| Ok((ty == Type::INT).then(|| Data::Int(vec![i32::from(is)])));
        if what == "udim" {
            return flag(tiled);
        }
        if tiled && at.is_none() {
            let files: Result<Vec<_>, _> = self.tiles_of(name).iter().map(|name| self.find(name)).collect();
            return match (what, files) {
                ("exists", files) => flag(files.is_ok_and(|files| !files.is_empty())),
                (_, Ok(files)) => Ok(common(files.iter().map(|file| property(file, what, ty)))),
                _ => Ok(None),
            };
        }
        let named = at.and_then(|at| tile(name, at)).map_or_else(|| name.to_owned(), |(name, _)| name);
        let found = self.find(&named);
        if what == "exists" {
            return flag(found.is_ok());
        }
        let file = match found {
            Ok(file) => file,
            // A missing tile is empty.
            Err(_) if tiled => return Ok(None),
            Err(_) => {
                return Err(format!(
                    "Invalid image file \"{name}\": Image \"{name}\" does not exist. Also, it is not the name of an image format that OpenImageIO recognizes."
                ));
            }
        };
        Ok(property(&file, what, ty))
    }
}
