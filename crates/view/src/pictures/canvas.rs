// SPDX-License-Identifier: GPL-3.0-or-later
//! A picture at any enlargement as light of the window's pixels: the nearest pixel where it is enlarged, the mean of all pixels below
//! where it is reduced. Tests: `tests`.

use gnurt::ThreadPool;
use gnurt::image::Picture;
use rayon::prelude::*;

use super::controls::Controls;

/// Around the picture.
const OUTSIDE: [f32; 4] = [0.012, 0.012, 0.012, 1.0];

/// Colours of the window.
pub(crate) fn draw(picture: &Picture, controls: &Controls, pool: &ThreadPool, out: &mut Vec<[f32; 4]>) {
    let [columns, rows] = controls.size.map(|side| side as usize);
    out.clear();
    out.resize(columns * rows, OUTSIDE);
    if out.is_empty() {
        return;
    }
    let step = 1.0 / controls.zoom();
    let [left, top] = controls.picture_point([0.0, 0.0]);
    // The pixels of the picture below a pixel of the window, at least one.
    let below = |begin: f64, side: u32| -> Option<std::ops::Range<usize>> {
        let (center, side) = (begin + step / 2.0, f64::from(side));
        if !(0.0..side).contains(&center) {
            return None;
        }
        if step <= 1.0 {
            return Some(center as usize..center as usize + 1);
        }
        let [first, end] = [begin.max(0.0), (begin + step).min(side)].map(|x| x.round() as usize);
        Some(first.min(center as usize)..end.max(center as usize + 1))
    };
    let across: Vec<_> = (0..columns).map(|x| below(left + x as f64 * step, picture.width)).collect();
    let width = picture.width as usize;
    let shown = |[r, g, b, a]: [f32; 4]| match controls.channel {
        None => [r, g, b, 1.0],
        Some(channel) => {
            let value = [r, g, b, a][channel.min(3)];
            [value, value, value, 1.0]
        }
    };
    let fill = |(y, row): (usize, &mut [[f32; 4]])| {
        let Some(down) = below(top + y as f64 * step, picture.height) else { return };
        for (pixel, across) in row.iter_mut().zip(&across) {
            let Some(across) = across else { continue };
            if let (1, 1) = (across.len(), down.len()) {
                *pixel = shown(picture.color[down.start * width + across.start]);
                continue;
            }
            let mut sum = [0.0; 4];
            for row in down.clone() {
                for color in &picture.color[row * width..][across.clone()] {
                    sum = [0, 1, 2, 3].map(|k| sum[k] + color[k]);
                }
            }
            let share = 1.0 / (across.len() * down.len()) as f32;
            *pixel = shown(sum.map(|x| x * share));
        }
    };
    pool.install(|| out.par_chunks_mut(columns).enumerate().for_each(fill));
}

#[cfg(test)]
mod tests {
    use super::super::items::Item;
    use super::*;
    use crate::exposure::Exposure;
    use crate::input::{Input, Key};

    #[test]
    fn pixels_are_repeated_or_averaged() {
        let pool = gnurt::thread_pool(2).expect("two threads");
        let mut picture = Picture::new(4, 2);
        for (i, color) in picture.color.iter_mut().enumerate() {
            *color = [i as f32, 0.0, 1.0, 0.5];
        }
        let drawn = |size: [u32; 2], keys: &str| {
            let mut controls = Controls::new(size, 1, Item::Color, Exposure::default(), 24.0);
            controls.show([4, 2], Vec::new());
            for key in keys.chars() {
                controls.handle(Input::KeyDown { key: Key::Char(key), repeat: false });
            }
            let mut out = Vec::new();
            draw(&picture, &controls, &pool, &mut out);
            out.iter().map(|color| color[0]).collect::<Vec<_>>()
        };
        assert_eq!(drawn([4, 2], ""), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let twice = drawn([8, 4], "");
        assert_eq!(twice[..8], [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0]);
        assert_eq!(twice[24..], [4.0, 4.0, 5.0, 5.0, 6.0, 6.0, 7.0, 7.0]);
        assert_eq!(drawn([2, 1], ""), [2.5, 4.5], "means of four");
        let around = drawn([6, 4], "");
        assert_eq!(around[..7], [OUTSIDE[0]; 7], "around it");
        assert_eq!(around[7..11], [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(drawn([4, 2], "ccc")[3], 1.0, "blue as grey");
        assert_eq!(drawn([4, 2], "cccc")[3], 0.5, "opacity as grey");
        assert!(drawn([0, 5], "").is_empty());
    }
}
