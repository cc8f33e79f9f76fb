// SPDX-License-Identifier: GPL-3.0-or-later
//! Options for the times of an animation that are rendered. Frames as in film. Frame f is at the time f / N.
//! Tests: `tests/program/animation.rs`.

use clap::Args;

use super::value::{self, FrameRange};
use crate::failure::Failure;

/// Default frames per second: film's.
const FPS: f64 = 24.0;

/// `--at`, `--frames` and related options: time and duration.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Animation")]
pub(crate) struct TimeArguments {
    /// Time of the animation to render, in seconds [default: the scene at rest]
    #[arg(long, value_name = "SECONDS", value_parser = value::seconds, allow_hyphen_values = true, conflicts_with = "frames")]
    pub(crate) at: Option<f64>,
    /// Frames to render, both ends included: 0..47, or every second one: 0..47:2; --output has # for the number: frame.####.png
    #[arg(long, value_name = "FIRST..LAST[:STEP]", value_parser = value::frames, allow_hyphen_values = true)]
    pub(crate) frames: Option<FrameRange>,
    /// Frames per second: frame f is at f / N seconds [default: 24]
    #[arg(hide_short_help = true, long, value_name = "N", value_parser = value::frames_per_second, allow_hyphen_values = true)]
    fps: Option<f64>,
    /// Animation of the scene, by name or number from 0 [default: the first]
    #[arg(hide_short_help = true, long, value_name = "NAME|INDEX", allow_hyphen_values = true)]
    pub(crate) animation: Option<String>,
    /// Shutter time in frames, for motion blur; 0 = none [default: 0]
    #[arg(hide_short_help = true, long, value_name = "X", value_parser = value::shutter, allow_hyphen_values = true)]
    shutter: Option<f64>,
    /// Frames on each side that the denoiser of --frames borrows light from, where a point's light stays the same; 0 = each frame by itself [default: 3]
    #[arg(hide_short_help = true, long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=16), allow_hyphen_values = true, requires = "frames")]
    denoise_window: Option<u8>,
    /// Skip frames whose files exist
    #[arg(hide_short_help = true, long, requires = "frames")]
    pub(crate) skip_existing: bool,
}

impl TimeArguments {
    /// Whether a time is given.
    pub(crate) fn is_given(&self) -> bool {
        self.at.is_some() || self.frames.is_some()
    }

    /// Frames per second.
    pub(crate) fn fps(&self) -> f64 {
        self.fps.unwrap_or(FPS)
    }

    /// The time of a frame.
    pub(crate) fn seconds(&self, frame: u32) -> f64 {
        f64::from(frame) / self.fps()
    }

    /// Whether the shutter is open for some time.
    pub(crate) fn is_open(&self) -> bool {
        self.shutter.is_some_and(|frames| frames > 0.0)
    }

    /// When the shutter closes that opens at a time.
    pub(crate) fn closes(&self, opens: f64) -> f64 {
        opens + self.shutter.unwrap_or(0.0) / self.fps()
    }

    /// Whether that is given.
    pub(crate) fn is_window_given(&self) -> bool {
        self.denoise_window.is_some()
    }

    /// Frames on each side that the denoiser borrows from.
    pub(crate) fn reach(&self) -> usize {
        self.denoise_window.map_or(gnurt::denoise::film::REACH, usize::from)
    }

    /// The frame nearest to a time: that of a sequence of files.
    pub(crate) fn frame_at(&self, seconds: f64) -> u32 {
        // Converting clamps.
        (seconds * self.fps()).round() as u32
    }

    /// Checks that need no scene.
    pub(crate) fn check(&self, is_of_files: bool, has_checkpoint: bool) -> Result<(), Failure> {
        let without = |option: &str| {
            let reason = "the time is missing; give --at SECONDS or --frames FIRST..LAST, too";
            Err(Failure::usage(format_args!("{option}: {reason}")))
        };
        if !self.is_given() {
            if self.shutter.is_some() {
                return without("--shutter");
            }
            return match (&self.animation, self.fps) {
                (Some(_), _) => without("--animation"),
                (None, Some(_)) => without("--fps"),
                (None, None) if is_of_files => Err(Failure::usage(
                    "the scene is a sequence of files; give --frames FIRST..LAST or --at SECONDS",
                )),
                (None, None) => Ok(()),
            };
        }
        if is_of_files && self.is_open() {
            return Err(Failure::usage(
                "--shutter: unsupported for a sequence of files; motion blur needs an animation in one file",
            ));
        }
        if self.frames.is_some() && has_checkpoint {
            return Err(Failure::usage(
                "--checkpoint conflicts with --frames; --skip-existing continues an interrupted sequence",
            ));
        }
        Ok(())
    }
}
