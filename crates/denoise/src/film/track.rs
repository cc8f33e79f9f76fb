// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the points of a frame are in other frames of the window: motion is followed from frame to frame.
//! A point that is hidden in a frame between is lost. Invariant: a position is within the frame.
//! Tests: `tests/film.rs`.

use rayon::prelude::*;

use super::frame::FilmFrame;
use crate::noisy::Triple;

/// A point of a frame in another one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Track {
    /// Centre of pixel (0, 0) is (0, 0).
    pub(super) at: [f32; 2],
    pub(super) distance: f32,
    pub(super) normal: Triple,
    id: u32,
}

/// Tracks of all pixels, `None` where a point is lost.
pub(super) type Tracks = Vec<Option<Track>>;

/// Every point where it is.
pub(super) fn begin(frame: &FilmFrame) -> Tracks {
    let track = |p: usize| Track {
        at: [(p % frame.width) as f32, (p / frame.width) as f32],
        distance: frame.distance[p],
        normal: frame.noisy.normal[p],
        id: frame.id[p],
    };
    (0..frame.id.len()).map(|p| Some(track(p))).collect()
}

/// Follows points of `frame` to the frame before (`way` 0) or after (1).
pub(super) fn follow(tracks: &mut Tracks, frame: &FilmFrame, way: usize) {
    tracks.par_iter_mut().for_each(|track| {
        *track = track.and_then(|track| {
            let q = nearest(frame, &track)?;
            let step = frame.steps[way][q];
            let at = [track.at[0] + step.by[0], track.at[1] + step.by[1]];
            let is_inside = |x: f32, size: usize| x >= -0.5 && x <= size as f32 - 0.5;
            // What it differs by from the pixel's point stays.
            let distance = if step.distance > 0.0 && frame.distance[q] > 0.0 {
                track.distance * step.distance / frame.distance[q]
            } else {
                0.0
            };
            let is_seen = is_inside(at[0], frame.width) && is_inside(at[1], frame.height);
            is_seen.then_some(Track { at, distance, normal: frame.noisy.normal[q], ..track })
        });
    });
}

/// The nearest pixel that shows the surface, among those around.
fn nearest(frame: &FilmFrame, track: &Track) -> Option<usize> {
    let [x, y] = [track.at[0].round() as i64, track.at[1].round() as i64];
    let offsets = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]];
    let inside = |[dx, dy]: [i64; 2]| {
        let (x, y) = (x + dx, y + dy);
        let is_inside = x >= 0 && y >= 0 && x < frame.width as i64 && y < frame.height as i64;
        is_inside.then(|| y as usize * frame.width + x as usize)
    };
    let shows = |q: &usize| frame.shows(*q, track.id, &track.normal, track.distance);
    offsets.into_iter().filter_map(inside).find(shows)
}
