// SPDX-License-Identifier: GPL-3.0-or-later
//! The contents of a window, and its frame buffers while the program prepares the next frame.
//! Invariant: memory that libOpenRT may write to is neither read, moved nor freed: only a query of libOpenRT
//! (`frames.rs`) determines which that is. Tests: tests of `frames`.

use super::pixels::{Format, to_screen};

/// The contents of a window.
pub(crate) struct Stage {
    /// Of the window.
    pub(crate) size: [u32; 2],
    pub(crate) title: String,
    /// Whether a program has requested a window.
    pub(crate) is_requested: bool,
    /// Whether a new frame is needed.
    pub(crate) is_stale: bool,
    pub(crate) is_leaving: bool,
    /// Wakes the window that is open, which may rest until something happens.
    pub(super) waker: Option<Waker>,
    /// The picture, the uppermost row first, and its size.
    pub(crate) screen: Vec<u32>,
    pub(crate) screen_size: [u32; 2],
    /// Pictures so far.
    pub(crate) pictures: u64,
    buffers: Vec<Buffer>,
    flight: Option<Flight>,
}

/// The function that wakes a window, from any thread.
pub(super) type Waker = Box<dyn Fn() + Send>;

/// A frame buffer of RGB bytes.
struct Buffer {
    bytes: Vec<u8>,
    size: [u32; 2],
}

/// The frame that was begun last.
#[derive(Clone, Copy)]
pub(crate) struct Flight {
    /// Where its buffer begins.
    pub(crate) memory: usize,
    /// Whether its start is known: the callback for an error meanwhile may have left by an exception.
    pub(crate) has_begun: bool,
}

/// The largest side of a window.
pub(crate) const LARGEST: u32 = 16384;

impl Default for Stage {
    fn default() -> Self {
        Self {
            size: [640, 480],
            title: String::new(),
            is_requested: false,
            is_stale: true,
            is_leaving: false,
            waker: None,
            screen: Vec::new(),
            screen_size: [0; 2],
            pictures: 0,
            buffers: Vec::new(),
            flight: None,
        }
    }
}

impl Stage {
    /// Requests a new frame, also of a window at rest.
    pub(crate) fn redisplay(&mut self) {
        self.is_stale = true;
        self.wake();
    }

    /// The main loop is to end, also if it rests.
    pub(crate) fn leave(&mut self) {
        self.is_leaving = true;
        self.wake();
    }

    fn wake(&self) {
        if let Some(wake) = &self.waker {
            wake();
        }
    }

    /// As at the beginning of a main loop: no pictures, and one is needed.
    pub(crate) fn begin(&mut self) {
        (self.pictures, self.is_stale, self.is_leaving) = (0, true, false);
    }

    /// The frame that was begun last and is not shown yet.
    pub(crate) fn flight(&self) -> Option<Flight> {
        self.flight
    }

    /// Stores a frame, or that there is none.
    pub(crate) fn set_flight(&mut self, flight: Option<Flight>) {
        self.flight = flight;
    }

    /// Where all buffers begin.
    pub(crate) fn memories(&self) -> Vec<usize> {
        self.buffers.iter().map(|buffer| buffer.bytes.as_ptr().addr()).collect()
    }

    /// Memory of the window's size for a frame, with that size: none of the `busy` ones. Buffers that neither
    /// are nor have the right size go. `None` if there is no memory for another one.
    pub(crate) fn target(&mut self, busy: &[usize]) -> Option<(usize, [u32; 2])> {
        let size = self.size;
        let is_busy = |buffer: &Buffer| busy.contains(&buffer.bytes.as_ptr().addr());
        self.buffers.retain(|buffer| buffer.size == size || is_busy(buffer));
        let free = self.buffers.iter().position(|buffer| buffer.size == size && !is_busy(buffer));
        let pixel_position = match free {
            Some(pixel_position) => pixel_position,
            None => {
                let length = 3 * size[0] as usize * size[1] as usize;
                let mut bytes = Vec::new();
                bytes.try_reserve_exact(length).ok()?;
                bytes.resize(length, 0);
                self.buffers.push(Buffer { bytes, size });
                self.buffers.len() - 1
            }
        };
        // libOpenRT will write there, behind the back of the compiler.
        Some((self.buffers[pixel_position].bytes.as_mut_ptr().expose_provenance(), size))
    }

    /// Shows the buffer that begins there; nothing writes to it any more.
    pub(crate) fn land(&mut self, memory: usize) {
        self.flight = None;
        let landed = self.buffers.iter().find(|buffer| buffer.bytes.as_ptr().addr() == memory);
        if let Some(Buffer { bytes, size }) = landed {
            to_screen(bytes, size[0] as usize, Format::RGB_8, &mut self.screen);
            self.screen_size = *size;
            self.pictures += 1;
        }
    }

    /// Shows pixels of the program; they are all there.
    pub(crate) fn show(&mut self, bytes: &[u8], size: [u32; 2], format: Format) {
        to_screen(bytes, size[0] as usize, format, &mut self.screen);
        self.screen_size = size;
        self.pictures += 1;
    }
}
