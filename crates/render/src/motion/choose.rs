// SPDX-License-Identifier: GPL-3.0-or-later
//! The pixels of a picture in motion that get a fresh sample: those with the least samples first, the others
//! in rotation. Positions by the R2 sequence [Rob18], frames by the golden section: each part of the picture
//! and each span of frames gets its share. Invariant: a function of the counts and the number of the frame.
//! Tests: `tests`.

use super::surface_key::{Light, SurfaceKey};

/// Steps of the R2 sequence, and of the golden section.
const STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// The need of a pixel for a sample, relative to a pixel with known light.
#[inline(always)]
pub(super) fn need(surface_key: &SurfaceKey, light: &Light) -> f32 {
    if !surface_key.is_surface() {
        return 0.0;
    }
    match light.count {
        count if count < 0.5 => 4.0,
        count if count < 4.0 => 2.0,
        _ => 1.0,
    }
}

/// A pixel's rank in the rotation of a frame, from 0 to 1.
pub(super) fn rank_of(x: u32, y: u32, frame: u32) -> f32 {
    let at = f64::from(x) * STEPS[0] + f64::from(y) * STEPS[1] + f64::from(frame) * GOLDEN_RATIO;
    at.fract() as f32
}

/// The factor of needs at which about `requested` pixels are chosen; `counts` are the pixels with the needs
/// 1, 2 and 4.
pub(super) fn scale(counts: [u64; 3], requested: f64) -> f32 {
    let (mut low, mut high) = (0.0, 1.0);
    let chosen = |scale: f64| -> f64 {
        let share = |need: f64| (need * scale).min(1.0);
        counts.iter().zip([1.0, 2.0, 4.0]).map(|(&count, need)| count as f64 * share(need)).sum()
    };
    if chosen(1.0) <= requested {
        return 1.0;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if chosen(middle) < requested { &mut low } else { &mut high }) = middle;
    }
    high as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pixels_have_their_turns() {
        let (size, frames, share) = (64_u32, 64_u32, 1.0 / 16.0);
        let mut times = vec![0_u32; (size * size) as usize];
        for frame in 0..frames {
            let mut chosen = 0;
            for (y, x) in (0..size).flat_map(|y| (0..size).map(move |x| (y, x))) {
                if rank_of(x, y, frame) < share {
                    times[(y * size + x) as usize] += 1;
                    chosen += 1;
                }
            }
            assert!((240..=272).contains(&chosen), "frame {frame}: {chosen} instead of 256");
        }
        let (least, most) = (times.iter().min(), times.iter().max());
        assert!(least >= Some(&3) && most <= Some(&5), "about four times each: {least:?} to {most:?}");
    }

    #[test]
    fn as_many_are_chosen_as_are_wanted() {
        for counts in [[1000, 0, 0], [900, 50, 50], [0, 0, 300], [10, 10, 980]] {
            let scale = f64::from(scale(counts, 100.0));
            let found: f64 =
                counts.iter().zip([1.0, 2.0, 4.0]).map(|(&n, need)| n as f64 * (need * scale).min(1.0)).sum();
            assert!((found - 100.0).abs() < 0.1, "{counts:?}: {found}");
        }
        assert_eq!(scale([50, 0, 0], 100.0), 1.0, "no more than there are");
    }
}
