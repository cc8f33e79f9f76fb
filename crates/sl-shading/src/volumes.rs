// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes that shaders read by `texture3d`: each file once, between eight voxels or the nearest one.
//! Grids, options and values beyond a grid's leaves follow OpenImageIO's textures, except that transforms
//! with rotation or shear are right. There is no filtering: a voxel stays a voxel at any distance. Space:
//! world, which is the file's.
//! Tests: `tests/scripts/volumes.rs`.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

use glam::{DMat3, DVec3};
use gnurt_image::{Grid, Volume};
use gnurt_sl::exec::{Subimage, TextureOptions};
use gnurt_sl_lib::Dual;

use crate::wrap::Wrap;

/// Limit of stored names.
const MOST: usize = 4096;
/// Bytes that a file's voxels may take.
const MOST_BYTES: usize = 1 << 31;

type Found = Result<Arc<Volume>, Arc<str>>;

/// Volumes by the names that shaders call them.
#[derive(Debug, Default)]
pub(crate) struct Volumes(Mutex<HashMap<String, Found>>);

impl Volumes {
    /// The volume of a name, which lies at a path or cannot be there.
    pub(crate) fn find(&self, name: &str, path: impl FnOnce() -> Result<Arc<Path>, String>) -> Found {
        let Ok(mut known) = self.0.lock() else { return Err("its memory is lost".into()) };
        if let Some(found) = known.get(name) {
            return found.clone();
        }
        if known.len() >= MOST {
            return Err(format!("more than {MOST} volumes").into());
        }
        let read = |path: Arc<Path>| Volume::read(&path, MOST_BYTES).map_err(|error| error.to_string());
        let found = path().and_then(read).map(Arc::new).map_err(Arc::from);
        known.insert(name.to_owned(), found.clone());
        found
    }
}

/// Four channels of a volume at a position, with derivatives from pixel to pixel; how many of them the grid
/// has. The others are filled.
///
/// # Errors
/// A line for people: the file has no such grid.
pub(crate) fn at_place(
    volume: &Volume,
    file: &str,
    position: [Dual<f32>; 3],
    options: &TextureOptions,
) -> Result<([Dual<f32>; 4], usize), String> {
    let (grid, asked) = match &options.subimage {
        Subimage::Number(number) => {
            let grid = usize::try_from(*number).ok().and_then(|number| volume.grids().get(number));
            (grid, number.to_string())
        }
        Subimage::Name(name) => (volume.grid(name), name.to_string()),
    };
    let grid = grid.ok_or_else(|| {
        let names: Vec<_> = volume.grids().iter().map(Grid::name).collect();
        format!("Unknown subimage \"{asked}\" in texture \"{file}\"; it has {}", names.join(", "))
    })?;
    let map = grid.index_from_world();
    let vector = |part: fn(&Dual<f32>) -> f32| DVec3::from(position.each_ref().map(|x| f64::from(part(x))));
    let wrap = options.wrap.each_ref().map(|wrap_name| Wrap::named(wrap_name).unwrap_or(Wrap::Black));
    let index = map.transform_point3(vector(|x| x.value));
    let read = Read::of(grid, index, wrap, &*options.interpolation == "closest");
    let changes = [vector(|x| x.dx), vector(|x| x.dy)].map(|change| map.transform_vector3(change));
    let channel = |k: usize| {
        let first = usize::try_from(options.first_channel).ok();
        let k = first.and_then(|first| first.checked_add(k)).filter(|&k| k < grid.channels());
        let (value, gradient) = match k {
            Some(k) => (read.values[k], read.gradients.row(k)),
            None => (read.inside * f64::from(options.fill), read.inside_gradient * f64::from(options.fill)),
        };
        let [dx, dy] = changes.map(|change| gradient.dot(change) as f32);
        Dual::new(value as f32, dx, dy)
    };
    Ok((std::array::from_fn(channel), grid.channels()))
}

/// The same as a color: one number is grey, as in pictures.
///
/// # Errors
/// As those of [`at_place`].
pub(crate) fn color_at_place(
    volume: &Volume,
    file: &str,
    position: [Dual<f32>; 3],
    options: &TextureOptions,
) -> Result<[Dual<f32>; 4], String> {
    let (texel, channels) = at_place(volume, file, position, options)?;
    let is_grey = channels == 1 && options.channels >= 3 && options.first_channel == 0;
    Ok(if is_grey { [texel[0], texel[0], texel[0], texel[3]] } else { texel })
}

/// The values of a grid at a position.
struct Read {
    values: DVec3,
    /// How they change with the coordinates of voxels: a row for each value.
    gradients: DMat3,
    /// How much of the footprint lies within the grid, and how that changes.
    inside: f64,
    inside_gradient: DVec3,
}

impl Read {
    fn of(grid: &Grid, index: DVec3, wrap: [Wrap; 3], closest: bool) -> Self {
        let mut read =
            Self { values: DVec3::ZERO, gradients: DMat3::ZERO, inside: 0.0, inside_gradient: DVec3::ZERO };
        let Some([first, last]) = grid.window().filter(|_| index.is_finite()) else { return read };
        let low = if closest { (index + 0.5).floor() } else { index.floor() };
        let share = index - low;
        let voxel = |k: usize, up: i64| {
            let size = (i64::from(last[k]) - i64::from(first[k]) + 1) as usize;
            // There is no voxel outside of this range.
            let at = low[k].clamp(-1e15, 1e15) as i64 + up - i64::from(first[k]);
            wrap[k].texel(at, size).map(|i| (i as i64 + i64::from(first[k])) as i32)
        };
        let axes: [[Option<i32>; 2]; 3] = std::array::from_fn(|k| [voxel(k, 0), voxel(k, 1)]);
        for corner in 0..if closest { 1 } else { 8 } {
            let up = [0, 1, 2].map(|k| corner >> k & 1);
            let [Some(x), Some(y), Some(z)] = std::array::from_fn(|k| axes[k][up[k]]) else { continue };
            let part = |k: usize| {
                if closest { [1.0, 0.0] } else { [[1.0 - share[k], -1.0], [share[k], 1.0]][up[k]] }
            };
            let [[a, da], [b, db], [c, dc]] = [part(0), part(1), part(2)];
            let (weight, gradient) = (a * b * c, DVec3::new(da * b * c, a * db * c, a * b * dc));
            let value = DVec3::from(grid.voxel([x, y, z]).map(f64::from));
            read.values += weight * value;
            read.gradients += DMat3::from_cols(value * gradient.x, value * gradient.y, value * gradient.z);
            read.inside += weight;
            read.inside_gradient += gradient;
        }
        read
    }
}
