// SPDX-License-Identifier: GPL-3.0-or-later
//! Writes the pictures that reach the screen into numbered files, for films: take-001-00001.png, take-001-00002.png, ...
//! A thread writes; a few pictures may wait for it, then the next one waits until the queue is shorter: none
//! is left out. Old files are not overwritten: each take has a number that none had before; a file appears
//! whole or not at all.
//! Tests: `tests`, and `crates/cli/tests/program/window.rs`.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use gnurt::image::{encode_screen, replace_file};

/// Pictures that may wait.
const WAITING: usize = 4;

/// A picture as it is on the screen.
struct Shot {
    size: [u32; 2],
    /// `0x00RRGGBB`.
    pixels: Vec<u32>,
}

/// Writes pictures until it ends.
pub(crate) struct Recorder {
    folder: PathBuf,
    take: u32,
    /// Pictures so far.
    count: u32,
    /// `None` once it has ended.
    shots: Option<SyncSender<Shot>>,
    thread: Option<JoinHandle<Result<(), String>>>,
}

impl Recorder {
    /// Begins a take.
    pub(crate) fn begin(folder: &Path) -> Result<Self, String> {
        let is_free = |&take: &u32| !file(folder, take, 1).exists();
        let take = (1..u32::MAX).find(is_free).ok_or("all file names are in use")?;
        let (sender, shots) = sync_channel(WAITING);
        let to = folder.to_owned();
        let thread = std::thread::Builder::new().name("gnurt-recorder".into());
        let thread = thread.spawn(move || write_all(&to, take, &shots));
        let thread = thread.map_err(|error| format!("a thread cannot be started: {error}"))?;
        Ok(Self { folder: folder.to_owned(), take, count: 0, shots: Some(sender), thread: Some(thread) })
    }

    /// Adds a picture; returns whether it can still be written. [`end`](Self::end) reports a failure.
    pub(crate) fn add(&mut self, size: [u32; 2], pixels: &[u32]) -> bool {
        let Some(shots) = &self.shots else { return false };
        let is_taken = shots.send(Shot { size, pixels: pixels.to_vec() }).is_ok();
        self.count += u32::from(is_taken);
        is_taken
    }

    /// The status line during a recording: the take, and its number of pictures.
    pub(crate) fn status(&self) -> String {
        format!("recording take {}: {}", self.take, self.count)
    }

    /// Waits for all writes; returns a line about the files, or the failure.
    pub(crate) fn end(mut self) -> Result<String, String> {
        self.finish()?;
        let name = |number| file(&self.folder, self.take, number);
        Ok(match self.count {
            0 => "recorded nothing: no picture came".into(),
            1 => format!("recorded 1 picture: {}", name(1).display()),
            count => {
                format!("recorded {count} pictures: {} to {}", name(1).display(), name(count).display())
            }
        })
    }

    fn finish(&mut self) -> Result<(), String> {
        self.shots = None;
        let Some(thread) = self.thread.take() else { return Ok(()) };
        thread.join().unwrap_or_else(|_| Err("the recorder has crashed".into()))
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // A caller that needs the result calls `end`.
        let _ = self.finish();
    }
}

/// Writes pictures until the channel closes, or a write fails.
fn write_all(folder: &Path, take: u32, shots: &Receiver<Shot>) -> Result<(), String> {
    for (number, Shot { size, pixels }) in (1..).zip(shots) {
        let bytes = encode_screen(size, &pixels).map_err(|error| error.to_string())?;
        replace_file(&file(folder, take, number), &bytes).map_err(|error| error.to_string())?;
    }
    Ok(())
}

fn file(folder: &Path, take: u32, number: u32) -> PathBuf {
    folder.join(format!("take-{take:03}-{number:05}.png"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_and_pictures_count_up() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for take in 1..=2 {
            let mut recorder = Recorder::begin(folder.path()).expect("a thread");
            for shade in 0..7 {
                let pixels = [shade, 0x00ff_0000, 0x0012_3456];
                assert!(recorder.add([3, 1], &pixels), "it is taken");
            }
            assert_eq!(recorder.status(), format!("recording take {take}: 7"));
            let reported = recorder.end().expect("it can be written");
            assert!(
                reported.contains("7 pictures") && reported.contains(&format!("take-00{take}-00007.png")),
                "{reported}"
            );
            let last = gnurt::image::read(&file(folder.path(), take, 7)).expect("a picture");
            let bytes = |x| {
                let color = last.pixel(x, 0).expect("a pixel");
                gnurt::image::screen_bytes(color, gnurt::image::ToneCurve::Clamp, 0.0)
            };
            assert_eq!([0, 1, 2].map(bytes), [[0, 0, 6, 255], [255, 0, 0, 255], [0x12, 0x34, 0x56, 255]]);
        }
        let nothing = Recorder::begin(folder.path()).and_then(Recorder::end);
        assert!(nothing.is_ok_and(|reported| reported.contains("nothing")), "no picture came");
    }

    #[test]
    fn what_cannot_be_written_is_told() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut recorder = Recorder::begin(&folder.path().join("none")).expect("a thread");
        // A caller that adds pictures notices at the latest when the queue is full.
        let ended = (0..100).any(|_| !recorder.add([1, 1], &[0]));
        assert!(ended, "it stops");
        assert!(recorder.end().is_err_and(|why| why.contains("none")), "the file is named");
    }
}
