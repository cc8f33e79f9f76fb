// SPDX-License-Identifier: GPL-3.0-or-later
//! The noise of films: a frame borrows light from the frames on both sides of it, then is filtered by itself.
//! Reprojection as in \[NSL*07\], but with frames on both sides, exact motion, and tests for changed light that
//! compare measured differences with measured variances.
//!
//! ```text
//! frame t-2 --+                                      layers: light / albedo, variance, normals, ids, distances, motion
//! frame t-1 --+- tracks: the same point there -+
//! frame t ----+                                +- weights: has its light changed? --> mean --> filter of one picture
//! frame t+1 --+
//! ```
//! Invariants: memory is that of the window's frames; the same bits on any number of threads.
//! Tests: crates/denoise/tests/film.rs; bench/films/films.py judges it beside many samples.

mod change;
mod frame;
mod gather;
mod track;

use std::collections::VecDeque;

use gnurt_image::Picture;

pub use frame::{FilmFrame, MOTION};

use crate::error::Error;
use crate::{Options, Used, denoise, noisy_layer};

/// Frames on each side that light is borrowed from, by default.
pub const REACH: usize = 3;

/// The frames of a film on their way through the filter. `T` is anything that belongs to a frame.
pub struct Film<T> {
    options: Options,
    reach: usize,
    /// The number of all frames.
    count: usize,
    /// The window; the first has the index `first`.
    frames: VecDeque<FilmFrame>,
    first: usize,
    /// Frames that wait for later ones, with their indices.
    waiting: VecDeque<(usize, Picture, T)>,
}

impl<T> Film<T> {
    /// A film of `count` frames, with this number of frames on each side.
    #[must_use]
    pub fn new(options: Options, reach: usize, count: usize) -> Self {
        Self { options, reach, count, frames: VecDeque::new(), first: 0, waiting: VecDeque::new() }
    }

    /// Whether each frame is filtered by itself.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.reach == 0
    }

    /// First and last index of the frames that frame `i` borrows from. At both ends of the film it has as many
    /// frames as elsewhere.
    fn window(&self, i: usize) -> [usize; 2] {
        let width = 2 * self.reach;
        let first = i.saturating_sub(self.reach).min((self.count.max(1) - 1).saturating_sub(width));
        [first, (first + width).min(self.count.max(1) - 1)]
    }

    /// Whether frame `i` is needed for one of the frames that `is_wanted` names.
    pub fn is_needed(&self, i: usize, is_wanted: &dyn Fn(usize) -> bool) -> bool {
        let near = i.saturating_sub(2 * self.reach)..(i + 2 * self.reach + 1).min(self.count);
        near.into_iter().any(|other| {
            let [first, last] = self.window(other);
            (first..=last).contains(&i) && is_wanted(other)
        })
    }

    /// Adds the next frame, number `i` of the film, and returns those that are finished. A gap in the numbers begins a new shot.
    ///
    /// # Errors
    /// [`Error`] if a layer is missing, or the pictures differ in size; the frame is dropped then.
    pub fn push(
        &mut self,
        i: usize,
        picture: Picture,
        with: T,
        pool: &rayon::ThreadPool,
    ) -> Result<Vec<(Picture, T, Used)>, Error> {
        let mut done = Vec::new();
        if !self.frames.is_empty() && i != self.first + self.frames.len() {
            done = self.finish(pool)?;
        }
        if self.frames.is_empty() {
            self.first = i;
        }
        let frame = FilmFrame::of(&picture)?;
        if let Some(other) = self.frames.front()
            && other.size() != frame.size()
        {
            return Err(Error::Shape("the frames of a film differ in size".into()));
        }
        self.frames.push_back(frame);
        self.waiting.push_back((i, picture, with));
        while self.waiting.front().is_some_and(|(i, ..)| self.window(*i)[1] < self.first + self.frames.len())
        {
            done.extend(self.next(pool)?);
        }
        Ok(done)
    }

    /// Ends the film, and returns the frames that are left.
    ///
    /// # Errors
    /// As [`denoise`].
    pub fn finish(&mut self, pool: &rayon::ThreadPool) -> Result<Vec<(Picture, T, Used)>, Error> {
        let mut done = Vec::new();
        while !self.waiting.is_empty() {
            done.extend(self.next(pool)?);
        }
        self.frames.clear();
        Ok(done)
    }

    /// Filters the frame that has waited longest.
    fn next(&mut self, pool: &rayon::ThreadPool) -> Result<Option<(Picture, T, Used)>, Error> {
        let Some((i, mut picture, with)) = self.waiting.pop_front() else { return Ok(None) };
        let window = self.window(i);
        let within = |other: usize| window[0] <= other && other <= window[1];
        let all: Vec<&FilmFrame> =
            (self.first..).zip(&self.frames).filter(|(k, _)| within(*k)).map(|(_, f)| f).collect();
        let at = i - self.first.max(window[0]);
        let mut gathered = pool.install(|| gather::gather(&all, at));
        let used = denoise(&mut gathered, &self.options, pool)?;
        picture.layers.push(noisy_layer(&picture));
        for (pixel, clean) in picture.color.iter_mut().zip(&gathered.color) {
            pixel[..3].copy_from_slice(&clean[..3]);
        }
        // Frames that no later one borrows from.
        let next = self.waiting.front().map_or(i + 1, |(next, ..)| *next);
        while self.first < self.window(next)[0] && self.first < next && !self.frames.is_empty() {
            self.frames.pop_front();
            self.first += 1;
        }
        Ok(Some((picture, with, used)))
    }
}
