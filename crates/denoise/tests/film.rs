// SPDX-License-Identifier: GPL-3.0-or-later
//! The filter over frames on made pictures: still light stands still, changes are followed, hidden points leave no ghosts.

use gnurt_denoise::film::Film;
use gnurt_denoise::{Method, Options};
use gnurt_image::{Layer, Picture};

const SIZE: usize = 32;
const FRAMES: usize = 7;

/// A grey wall of this light with noise, and another surface that hides the columns in `front`.
fn frame(light: f32, seed: u32, front: std::ops::Range<usize>) -> Picture {
    let mut picture = Picture::new(SIZE as u32, SIZE as u32);
    let mut state = seed.wrapping_mul(0x9e37_79b9) | 1;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let is_front = |p: usize| front.contains(&(p % SIZE));
    for (p, pixel) in picture.color.iter_mut().enumerate() {
        let mean = if is_front(p) { 4.0 } else { light };
        let value = mean * (1.0 + 0.6 * noise());
        *pixel = [value, value, value, 1.0];
    }
    let plane = |value: &dyn Fn(usize) -> f32| (0..SIZE * SIZE).map(value).collect::<Vec<f32>>();
    let grey = || plane(&|_| 0.5);
    // Of a uniform number times 0.6.
    let variance = || plane(&|p| (if is_front(p) { 4.0_f32 } else { light }).powi(2) * 0.03);
    let still = || plane(&|_| 0.0);
    let far = || plane(&|p| if is_front(p) { 1.0 } else { 5.0 });
    let ids = || (0..SIZE * SIZE).map(|p| u32::from(is_front(p))).collect::<Vec<u32>>();
    picture.layers = vec![
        Layer::floats("albedo", [("R", grey()), ("G", grey()), ("B", grey())]),
        Layer::floats("variance", [("R", variance()), ("G", variance()), ("B", variance())]),
        Layer::floats("N", [("X", still()), ("Y", still()), ("Z", plane(&|_| 1.0))]),
        Layer::floats("depth", [("Z", far())]),
        Layer::ids("id", [("instance", ids()), ("object", ids()), ("material", ids())]),
        Layer::floats(
            "motion",
            [
                ("X", plane(&|p| if is_front(p) { -2.0 } else { 0.0 })),
                ("Y", still()),
                ("Z", plane(&|p| if is_front(p) { 2.0 } else { 0.0 })),
                ("W", still()),
                ("before", far()),
                ("after", far()),
            ],
        ),
    ];
    picture
}

/// The frames after the filter.
fn filtered(frames: Vec<Picture>, reach: usize) -> Vec<Picture> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    let options = Options { method: Method::BuiltIn, ..Options::default() };
    let mut film = Film::new(options, reach, frames.len());
    let mut done = Vec::new();
    for (i, frame) in frames.into_iter().enumerate() {
        done.extend(film.push(i, frame, i, &pool).expect("the layers are there"));
    }
    done.extend(film.finish(&pool).expect("frames"));
    assert!(done.iter().enumerate().all(|(k, (_, i, _))| k == *i), "all frames, in order");
    done.into_iter().map(|(picture, ..)| picture).collect()
}

/// Mean of a function of a pixel's value over pixels right of a column.
fn mean(picture: &Picture, from: usize, of: impl Fn(usize, f32) -> f32) -> f32 {
    let pixels: Vec<usize> = (0..SIZE * SIZE).filter(|p| p % SIZE >= from).collect();
    pixels.iter().map(|&p| of(p, picture.color[p][0])).sum::<f32>() / pixels.len() as f32
}

#[test]
fn what_stands_still_stands_still() {
    let frames = || (0..FRAMES).map(|i| frame(1.0, i as u32 + 1, 0..0)).collect::<Vec<_>>();
    let flicker = |film: &[Picture]| {
        film.windows(2).map(|pair| mean(&pair[1], 0, |p, x| (x - pair[0].color[p][0]).abs())).sum::<f32>()
    };
    let (film, single) = (filtered(frames(), 2), filtered(frames(), 0));
    assert!(flicker(&film) < 0.45 * flicker(&single), "{} and {}", flicker(&film), flicker(&single));
}

#[test]
fn changed_light_is_followed_within_a_frame() {
    let frames = (0..FRAMES).map(|i| frame(if i < 4 { 1.0 } else { 2.0 }, i as u32 + 1, 0..0)).collect();
    for (i, picture) in filtered(frames, 3).iter().enumerate() {
        let (found, expected) = (mean(picture, 0, |_, x| x), if i < 4 { 1.0 } else { 2.0 });
        assert!((found / expected - 1.0).abs() < 0.03, "frame {i}: {found}, and not {expected}");
    }
}

#[test]
fn what_was_hidden_has_no_ghost() {
    // A bright surface moves to the right by two pixels a frame, before a dark wall.
    let frames = (0..FRAMES).map(|i| frame(0.2, i as u32 + 1, 2 * i + 2..2 * i + 8)).collect();
    for (i, picture) in filtered(frames, 3).iter().enumerate() {
        let wall = (0..SIZE * SIZE).filter(|p| !(2 * i + 1..2 * i + 9).contains(&(p % SIZE)));
        let most = wall.map(|p| picture.color[p][0]).fold(0.0, f32::max);
        assert!(most < 0.4, "frame {i}: the wall is 0.2, and shows {most}");
    }
}
