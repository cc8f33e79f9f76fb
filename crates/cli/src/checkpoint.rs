// SPDX-License-Identifier: GPL-3.0-or-later
//! `--checkpoint FILE`: the state of a rendering, written to a temporary file and renamed, so that a kill
//! loses one interval. An existing file is continued; one that does not match is an error, never overwritten.
//! Tests: `tests/program/checkpoint.rs` (a real kill).

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Duration;

use gnurt::image::{self, system_reason};
use gnurt::render::{Accumulation, CheckpointError, RenderOptions};

use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::signals::{is_leaving, while_writing};

/// A checkpoint file.
pub(crate) struct Checkpoint {
    path: PathBuf,
    /// Of the picture that it is for.
    fingerprint: u64,
    /// Time between two savings.
    pub(crate) every: Duration,
}

impl Checkpoint {
    pub(crate) fn new(path: &Path, fingerprint: u64, every: Duration) -> Self {
        Self { path: path.to_owned(), fingerprint, every }
    }

    /// The rendering so far: the file's, or none if there is no file.
    pub(crate) fn begin(&self, options: &RenderOptions, messages: Messages) -> Result<Accumulation, Failure> {
        // A pipe or a device might never end.
        if std::fs::metadata(&self.path).is_ok_and(|found| !found.is_file()) {
            return Err(self.failure("is not a regular file; give another name"));
        }
        let file = match File::open(&self.path) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Accumulation::new(options.clone()).map_err(Failure::usage);
            }
            Err(error) => return Err(self.failure(system_reason(&error))),
        };
        // A longer file is no checkpoint of this picture: one more word is enough to detect that.
        let most = Accumulation::new(options.clone()).map_err(Failure::usage)?.byte_count() + 8;
        let mut bytes = Vec::new();
        file.take(most).read_to_end(&mut bytes).map_err(|error| self.failure(system_reason(&error)))?;
        let found = Accumulation::from_bytes(options.clone(), self.fingerprint, &bytes).map_err(|error| {
            let remedy = match error {
                CheckpointError::MoreSamples { .. } => "request more, or delete it to begin again",
                CheckpointError::NoCheckpoint => "give another file",
                _ => "use the scene and options that it was made with, or delete it to begin again",
            };
            self.failure(format_args!("{error}; {remedy}"))
        })?;
        let taken = found.samples().min(found.options().spp);
        messages.note(format_args!("going on from {}: {taken} samples per pixel", self.path.display()));
        Ok(found)
    }

    /// Writes it, whole or not at all.
    pub(crate) fn save(&self, picture: &Accumulation) -> Outcome {
        let bytes = picture.to_bytes(self.fingerprint);
        let replaced = while_writing(|| image::replace_file_if(&self.path, &bytes, || !is_leaving()));
        replaced.map(drop).map_err(Failure::data)
    }

    fn failure(&self, why: impl std::fmt::Display) -> Failure {
        Failure::data(format_args!("--checkpoint {}: {why}", self.path.display()))
    }
}
