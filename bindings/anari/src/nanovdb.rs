// SPDX-License-Identifier: GPL-3.0-or-later
//! Grids of NanoVDB in memory, as values at the points of a box along the axes.
//! Space: object. Tests: `tests`, with values of NanoVDB's own reader; bytes that are broken: `gnurt-image`'s tests.

use gnurt::scene::volume_cells::VolumeCells;

/// Values in a box, x fastest.
#[derive(Debug, PartialEq)]
pub(crate) struct Dense {
    /// Values along each axis.
    pub(crate) dims: [usize; 3],
    /// Place of the first value, object space.
    pub(crate) origin: [f32; 3],
    /// From value to value, object space.
    pub(crate) spacing: [f32; 3],
    pub(crate) values: Vec<f32>,
}

/// The values of a grid around its active ones, with a rim of one; an error in words where it is none, or damaged.
pub(crate) fn dense(bytes: &[u8]) -> Result<Dense, String> {
    let cells = VolumeCells::of_nanovdb(bytes)?;
    if cells.channels != 1 {
        return Err(format!("{} numbers at each point: unsupported; allowed: one", cells.channels));
    }
    let (columns, dims) = (cells.world_from_unit.columns, cells.size.map(|n| n as usize));
    // From cell to cell along each axis.
    let step = |k: usize, row: usize| columns[k][row] / dims[k] as f64;
    let spacing: [f64; 3] = std::array::from_fn(|k| step(k, k));
    let most = 1e-6 * spacing.iter().copied().fold(0.0, f64::max);
    let is_straight = (0..9).all(|i| i / 3 == i % 3 || step(i / 3, i % 3).abs() <= most);
    if !is_straight || !spacing.iter().all(|x| *x > 0.0 && x.is_finite()) {
        return Err("its transform turns or mirrors, which is unsupported".into());
    }
    // Cells fill the box; values are at their middles.
    let origin = std::array::from_fn(|k| (columns[3][k] + 0.5 * spacing[k]) as f32);
    Ok(Dense { dims, origin, spacing: spacing.map(|x| x as f32), values: cells.values })
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    /// A file that NanoVDB wrote, and its grid of this number.
    fn grid(number: usize) -> (Vec<u8>, Vec<u8>) {
        let packed = include_bytes!("../../../crates/image/tests/data/nano/grids.nvdb.gz");
        let mut file = Vec::new();
        flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut file).expect("packed");
        let number_at = |at: usize, n: usize| {
            let mut bytes = [0; 8];
            bytes[..n].copy_from_slice(&file[at..at + n]);
            u64::from_le_bytes(bytes) as usize
        };
        // Segments of one grid each: a head of 16 bytes, a description of 176, its name, the grid.
        let mut at = 0;
        for i in 0.. {
            let first = at + 192 + number_at(at + 152, 4);
            let end = first + number_at(at + 24, 8);
            if i == number {
                return (file.clone(), file[first..end].to_vec());
            }
            at = end;
        }
        unreachable!("a file has an end")
    }

    #[test]
    fn values_and_places_are_those_of_the_file() {
        let (file, bytes) = grid(3);
        let path = std::env::temp_dir().join(format!("gnurt-anari-{}.nvdb", std::process::id()));
        std::fs::write(&path, &file).expect("a file");
        let all = gnurt::read_volume(&path, Some(&["density".into()])).expect("read");
        std::fs::remove_file(&path).expect("removed");
        let (expected, found) = (&all[0], dense(&bytes).expect("a grid"));
        assert!(found.values == expected.values && found.values.len() > 1000);
        let unit = |k: usize, i: usize| (i as f64 + 0.5) / found.dims[k] as f64;
        let cell = [3, 1, 2];
        let place = expected.world_from_unit.point(std::array::from_fn(|k| unit(k, cell[k])));
        for k in 0..3 {
            let there = f64::from(found.origin[k] + found.spacing[k] * cell[k] as f32);
            assert!((there - place[k]).abs() < 1e-4, "axis {k}: {there}, not {}", place[k]);
        }
    }

    #[test]
    fn grids_that_are_none_or_turn_are_errors() {
        let (_, whole) = grid(3);
        let error = |edit: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = whole.clone();
            edit(&mut bytes);
            dense(&bytes).expect_err("it is damaged")
        };
        assert!(error(&|bytes| bytes.truncate(2000)).contains("not in its grid"));
        assert!(error(&|bytes| bytes[0] = 0).contains("NanoVDB"));
        // The map's second number.
        let turned = error(&|bytes| bytes[392..400].copy_from_slice(&1_f64.to_le_bytes()));
        assert!(turned.contains("turns"), "{turned}");
    }
}
