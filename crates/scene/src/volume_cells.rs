// SPDX-License-Identifier: GPL-3.0-or-later
//! Cells of sparse grids: those of a box round the active voxels, with a rim of one voxel, where smoke ends.
//! Space: the file's world. Voxels that are not active hold nothing, and densities below 0 count as 0.
//! Tests: the command line's `tests/program/volumes.rs`, and those of readers of scenes.

use gnurt_image::{Budget, Grid, Volume};

use crate::Affine;
use crate::medium::DensityGrid;

/// Most cells of a box around the active ones of a grid: 2 GiB of numbers.
const MOST_CELLS: u64 = 1 << 29;
/// Most bytes of a file of volumes.
pub const MOST_VOLUME_BYTES: usize = 4 << 30;
/// Steps of a table of emission.
const HEATS: usize = 4096;

/// The numbers of a grid of a file, in the cells of a box round its active voxels, with a rim of one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeCells {
    /// The grid's name.
    pub name: String,
    /// Columns, rows and layers.
    pub size: [u32; 3],
    /// Numbers of a cell: 1 or 3.
    pub channels: usize,
    /// x first, then y, then z.
    pub values: Vec<f32>,
    /// From the unit cube, which the cells fill, to the file's world.
    pub world_from_unit: Affine,
}

impl VolumeCells {
    /// A grid of NanoVDB as programs hold it in memory, without the head of a file.
    ///
    /// # Errors
    /// That the bytes are no grid of numbers, or that it has no active voxels or too many cells.
    pub fn of_nanovdb(bytes: &[u8]) -> Result<Self, String> {
        let volume =
            Volume::decode_nanovdb_grid(bytes, MOST_VOLUME_BYTES).map_err(|error| error.to_string())?;
        let cells = volume.grids().first().map_or(Ok(None), Self::of)?;
        cells.ok_or_else(|| "the grid has no active cell".into())
    }

    /// Checks that a grid has not too many cells, without reading them.
    ///
    /// # Errors
    /// That there are too many.
    pub fn check(grid: &Grid) -> Result<(), String> {
        grid.active().map_or(Ok(()), |active| Place::new(active).map(drop))
    }

    /// Those of a grid; `None` without active voxels.
    ///
    /// # Errors
    /// That there are too many cells.
    pub fn of(grid: &Grid) -> Result<Option<Self>, String> {
        let Some(active) = grid.active() else { return Ok(None) };
        let place = Place::new(active)?;
        let mut values = place.room(grid.channels())?;
        place.rows(grid, |value, count| match grid.channels() {
            1 => values.resize(values.len() + count, value[0]),
            channels => (0..count).for_each(|_| values.extend_from_slice(&value[..channels])),
        });
        let (size, world_from_unit) = (place.size.map(|n| n as u32), place.world_from_unit(grid));
        let (name, channels) = (grid.name().to_owned(), grid.channels());
        Ok(Some(Self { name, size, channels, values, world_from_unit }))
    }
}

/// The grids of a file's bytes. Sparse grids grow as compressed pictures do, which the budget allows for.
///
/// # Errors
/// That it is no such file, or that it takes too much memory.
pub fn decode_volume(bytes: &[u8], budget: &Budget) -> Result<Volume, String> {
    budget.add_picture(bytes.len() as u64);
    Volume::decode(bytes, MOST_VOLUME_BYTES).map_err(|error| error.to_string())
}

/// The first grid of a name.
///
/// # Errors
/// That there is none, with the names that there are.
pub fn grid_named<'a>(volume: &'a Volume, name: &str) -> Result<&'a Grid, String> {
    volume.grid(name).ok_or_else(|| {
        let names: Vec<&str> = volume.grids().iter().map(Grid::name).collect();
        format!("no grid '{name}'; it has {}", names.join(", "))
    })
}

/// A box of voxels: the active ones of a grid, with a rim of one voxel.
struct Place {
    low: [i64; 3],
    size: [u64; 3],
    cells: u64,
}

impl Place {
    fn new([first, last]: [[i32; 3]; 2]) -> Result<Self, String> {
        let low = first.map(|i| i64::from(i) - 1);
        let size: [u64; 3] = std::array::from_fn(|k| (i64::from(last[k]) + 1 - low[k] + 1) as u64);
        let cells = size.iter().try_fold(1_u64, |cells, &n| cells.checked_mul(n));
        let cells = cells.filter(|&cells| cells <= MOST_CELLS).ok_or_else(|| {
            format!(
                "{} x {} x {} cells are too many; at most {MOST_CELLS} are shown",
                size[0], size[1], size[2]
            )
        })?;
        Ok(Self { low, size, cells })
    }

    /// Memory for some numbers of each cell.
    fn room<T>(&self, numbers: usize) -> Result<Vec<T>, String> {
        let mut room = Vec::new();
        room.try_reserve_exact(self.cells as usize * numbers).map_err(|_| "too little memory is free")?;
        Ok(room)
    }

    /// Visits the voxels, x first.
    fn each(&self, mut visit: impl FnMut([i32; 3])) {
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                for x in 0..self.size[0] {
                    visit(std::array::from_fn(|k| (self.low[k] + [x, y, z][k] as i64) as i32));
                }
            }
        }
    }

    /// Visits the values of its voxels in a grid in the same order, and how many voxels in turn have each.
    fn rows(&self, grid: &Grid, mut visit: impl FnMut([f32; 3], usize)) {
        for z in 0..self.size[2] {
            for y in 0..self.size[1] {
                let first = std::array::from_fn(|k| (self.low[k] + [0, y, z][k] as i64) as i32);
                grid.row(first, self.size[0] as usize, &mut visit);
            }
        }
    }

    /// From the unit cube, which the box fills, to the file's world.
    fn world_from_unit(&self, grid: &Grid) -> Affine {
        let world = grid.index_from_world().inverse();
        let column = |k: usize| world.matrix3.col(k).to_array();
        let world_from_index =
            Affine { columns: [column(0), column(1), column(2), world.translation.to_array()] };
        let low = Affine::translation(self.low.map(|i| i as f64 - 0.5));
        world_from_index * low * Affine::scale(self.size.map(|n| n as f64))
    }
}

/// A grid whose numbers say how much light each place gives off, as a grid of temperatures does.
pub struct Heat<'a> {
    /// Its numbers.
    pub grid: &'a Grid,
    /// The emission of a number, which is not below 0.
    pub emission: &'a dyn Fn(f32) -> [f32; 3],
}

/// Emissions of the numbers from 0 to the highest one of a grid.
struct Emissions {
    step: f32,
    table: Vec<[f32; 3]>,
}

impl Emissions {
    fn upto(most: f32, emission: &dyn Fn(f32) -> [f32; 3]) -> Self {
        let step = most.max(f32::MIN_POSITIVE) / (HEATS - 1) as f32;
        Self { step, table: (0..HEATS).map(|i| emission(i as f32 * step)).collect() }
    }

    fn at(&self, number: f32) -> [f32; 3] {
        let place = (number / self.step).clamp(0.0, (HEATS - 1) as f32);
        let i = (place as usize).min(HEATS - 2);
        let rest = place - i as f32;
        std::array::from_fn(|c| self.table[i][c] * (1.0 - rest) + self.table[i + 1][c] * rest)
    }
}

/// A density for each cell of a box around the active ones, with a rim of one cell; emission is that of two grids, multiplied.
///
/// # Errors
/// That there are no cells, too many, or too little memory for them by the budget or at all.
pub fn density_grid(
    grid: &Grid,
    glow: Option<&Grid>,
    heat: Option<&Heat>,
    budget: Option<&Budget>,
) -> Result<DensityGrid, String> {
    let place = Place::new(grid.active().ok_or("its grid has no active cell")?)?;
    let sound = |x: f32| if x.is_finite() { x.max(0.0) } else { 0.0 };
    let has_emission = glow.is_some() || heat.is_some();
    if let Some(budget) = budget {
        let bytes = if has_emission { size_of::<[f32; 4]>() } else { size_of::<f32>() };
        budget.hold(place.cells as usize * bytes).map_err(|excess| excess.to_string())?;
    }
    let mut density = place.room(1)?;
    let mut emission = if has_emission { place.room(1)? } else { Vec::new() };
    // All grids may have cells of their own.
    let world_from_index = grid.index_from_world().inverse();
    let reader = |other: &Grid| {
        let (other, there) = (other.clone(), other.index_from_world() * world_from_index);
        move |at: [i32; 3]| {
            let place = there.transform_point3(at.map(f64::from).into());
            other.voxel(place.to_array().map(|x| x.round() as i32)).map(sound)
        }
    };
    let glow = glow.map(|glow| (glow.channels(), reader(glow)));
    let heat = heat.map(|heat| (reader(heat.grid), heat.emission));
    place.rows(grid, |value, count| density.resize(density.len() + count, sound(value[0])));
    let mut hottest = 0.0_f32;
    if has_emission {
        place.each(|at| {
            emission.push(glow.as_ref().map_or([1.0; 3], |(channels, glow)| {
                let value = glow(at);
                if *channels == 1 { [value[0]; 3] } else { value }
            }));
            if let Some((heat, _)) = &heat {
                hottest = hottest.max(heat(at)[0]);
            }
        });
    }
    if let Some((heat, of_number)) = heat {
        let emissions = Emissions::upto(hottest, of_number);
        let mut cells = emission.iter_mut();
        place.each(|at| {
            if let Some(cell) = cells.next() {
                let color = emissions.at(heat(at)[0]);
                *cell = std::array::from_fn(|c| cell[c] * color[c]);
            }
        });
    }
    let size = place.size.map(|n| n as u32);
    Ok(DensityGrid { size, density, emission, world_from_unit: place.world_from_unit(grid) })
}
