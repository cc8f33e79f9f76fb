// SPDX-License-Identifier: GPL-3.0-or-later
//! Light from all directions: the square picture of pbrt as a latitude-longitude picture in the renderer's world.
//! Rule: at least as fine as the square one; each texel is the mean of parts of it, and the whole is scaled to the same light.
//! Tests: `tests`, `tests/lights.rs`.

use std::f64::consts::{PI, TAU};

use gnurt_scene::Affine;
use gnurt_scene::texture::{TexelData, Texels};

use crate::octahedral;
use crate::transform::unit;

/// Rows that a picture has at most.
const MOST_ROWS: u32 = 2048;
/// Parts of a texel along each side.
const PARTS: u32 = 3;

/// Columns and rows for a square of this side.
pub(crate) fn size(side: u32) -> [u32; 2] {
    let rows = side.clamp(16, MOST_ROWS);
    [2 * rows, rows]
}

/// Where a place of the picture, both in [0, 1] from the left upper corner, lies in the renderer's world.
fn direction(x: f64, y: f64) -> [f64; 3] {
    let ((sin, up), turn) = ((PI * y).sin_cos(), TAU * (x - 0.5));
    [sin * turn.sin(), up, -sin * turn.cos()]
}

/// The picture; `light_from_world` takes directions of the renderer's world to the light's.
pub(crate) fn picture(square: &Texels, light_from_world: &Affine) -> Texels {
    let [columns, rows] = size(square.width.max(square.height));
    let mut texels = Vec::with_capacity((columns * rows) as usize);
    let radiance_from = |dir: [f64; 3]| -> [f64; 3] {
        let dir = unit(light_from_world.vector(dir)).unwrap_or([0.0, 0.0, 1.0]);
        let [u, v] = octahedral::square(dir);
        let location = |t: f64, count: u32| ((t * f64::from(count)) as u32).min(count - 1) as usize;
        let [r, g, b, _] = square.texel(location(u, square.width), location(v, square.height));
        [r, g, b].map(f64::from)
    };
    let mut sum = [0.0; 3];
    for row in 0..rows {
        let edge = |row: u32| (PI * f64::from(row) / f64::from(rows)).cos();
        let share = (edge(row) - edge(row + 1)) * TAU / f64::from(columns);
        for column in 0..columns {
            let mut mean = [0.0; 3];
            for part in 0..PARTS * PARTS {
                let within = [part % PARTS, part / PARTS].map(|i| (f64::from(i) + 0.5) / f64::from(PARTS));
                let x = (f64::from(column) + within[0]) / f64::from(columns);
                let y = (f64::from(row) + within[1]) / f64::from(rows);
                let radiance = radiance_from(direction(x, y));
                mean.iter_mut().zip(radiance).for_each(|(mean, x)| *mean += x / f64::from(PARTS * PARTS));
            }
            sum.iter_mut().zip(mean).for_each(|(sum, x)| *sum += x * share);
            let [r, g, b] = mean.map(|x| x as f32);
            texels.push([r, g, b, 1.0]);
        }
    }
    let whole = total(square);
    let scale: [f32; 3] =
        std::array::from_fn(|k| if sum[k] > 0.0 { (whole[k] / sum[k]) as f32 } else { 1.0 });
    for texel in &mut texels {
        (0..3).for_each(|k| texel[k] *= scale[k]);
    }
    Texels { width: columns, height: rows, data: TexelData::Float(texels) }
}

/// Light of a square picture over all directions.
fn total(square: &Texels) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for_each(square, |_, texel| sum.iter_mut().zip(texel).for_each(|(sum, x)| *sum += f64::from(x)));
    let share = 2.0 * TAU / (f64::from(square.width) * f64::from(square.height));
    sum.map(|x| x * share)
}

/// The illuminance of the upper half, to compare with pbrt's "illuminance".
pub(crate) fn upward(square: &Texels) -> f32 {
    let mut sum = 0.0;
    for_each(square, |[x, y], [r, g, b, _]| {
        let at = [(x as f64 + 0.5) / f64::from(square.width), (y as f64 + 0.5) / f64::from(square.height)];
        let up = octahedral::direction(at)[2];
        if up > 0.0 {
            sum += up * f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b);
        }
    });
    // pbrt has this factor, half of the whole sphere's.
    (sum * TAU / (f64::from(square.width) * f64::from(square.height))) as f32
}

fn for_each(square: &Texels, mut with: impl FnMut([usize; 2], [f32; 4])) {
    for y in 0..square.height as usize {
        for x in 0..square.width as usize {
            with([x, y], square.texel(x, y));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_light_stay() {
        let side = 64;
        let mut texels = vec![[0.1, 0.1, 0.1, 1.0]; side * side];
        // The middle is the light's z.
        (28..36).for_each(|y| (28..36).for_each(|x| texels[y * side + x] = [50.0, 0.1, 0.1, 1.0]));
        let square = Texels { width: 64, height: 64, data: TexelData::Float(texels) };
        // The light's z is the world's y.
        let light_from_world = Affine::rotation([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2);
        let made = picture(&square, &light_from_world);
        assert!(made.texel(3, 0)[0] > 40.0 && made.texel(3, 60)[0] < 0.2, "it lies above");
        let mut sum = 0.0;
        for y in 0..made.height as usize {
            let edge = |row: usize| (PI * row as f64 / f64::from(made.height)).cos();
            let share = (edge(y) - edge(y + 1)) * TAU / f64::from(made.width);
            sum += (0..made.width as usize).map(|x| f64::from(made.texel(x, y)[0]) * share).sum::<f64>();
        }
        assert!((sum / total(&square)[0] - 1.0).abs() < 1e-4, "{sum}");
    }
}
