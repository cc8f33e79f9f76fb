// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures that are made in parts, by other threads and levels, and after a break: their bytes are those of the whole.

use gnurt_image::Picture;
use gnurt_render::{Accumulation, Piece, RenderOptions, SceneCamera, Silent, World, render};
use gnurt_simd::Level;

use super::pool;

pub fn picture_of((world, view): &(World, SceneCamera), options: &RenderOptions, threads: usize) -> Picture {
    render(world, view, options, &pool(threads), &Silent).expect("sound options").picture
}

pub fn bits(picture: &Picture) -> Vec<[u32; 4]> {
    picture.color.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

/// Threads, levels, pieces and checkpoints show nothing in the bytes of `whole`; pieces cover `off`, another picture of that size.
pub fn same_bytes_divided(
    of: &(World, SceneCamera),
    options: &RenderOptions,
    whole: &Picture,
    off: &Picture,
) {
    let (world, view) = of;
    assert!(bits(whole) == bits(&picture_of(of, options, 3)), "three threads");
    for level in Level::available() {
        let other = picture_of(of, &RenderOptions { level, ..options.clone() }, 2);
        assert!(bits(whole) == bits(&other), "at {level}");
    }
    let mut joined = bits(off);
    for index in 0..3 {
        let piece = Some(Piece { index, count: 3 });
        let part = picture_of(of, &RenderOptions { piece, ..options.clone() }, 2);
        for (joined, part) in joined.iter_mut().zip(bits(&part)) {
            if f32::from_bits(part[3]) > 0.0 {
                *joined = part;
            }
        }
    }
    assert!(bits(whole) == joined, "three pieces");
    let mut first = Accumulation::new(options.clone()).expect("sound");
    first.pass(world, view, 1, &pool(2), &Silent);
    let bytes = first.to_bytes(7);
    let mut resumed = Accumulation::from_bytes(options.clone(), 7, &bytes).expect("it was just written");
    while !resumed.is_complete() {
        resumed.pass(world, view, 1, &pool(2), &Silent);
    }
    assert!(bits(whole) == bits(&resumed.picture()), "broken off and gone on");
}
