// SPDX-License-Identifier: GPL-3.0-or-later
//! What a window shows and what is rendered for it: two frame buffers, of which one is rendered to while the program
//! prepares the next frame. Source: original. Invariant: a frame buffer that is rendered to is neither moved nor freed.
//! Proof: `tests`.

use super::pixels::{Format, to_screen};

/// libOpenRT's frames.
pub(crate) trait Renderer: Send {
    /// Begins a frame in a buffer of RGB bytes, which stays where it is until [`end`](Self::end); whether it has begun.
    fn start(&self, buffer: &mut [u8], size: [u32; 2]) -> bool;
    /// Waits for it.
    fn end(&self);
}

/// What a window shows.
pub(crate) struct Stage {
    renderer: Box<dyn Renderer>,
    /// Of the window.
    pub(crate) size: [u32; 2],
    pub(crate) title: String,
    /// Whether a program has asked for a window.
    pub(crate) is_wanted: bool,
    /// Whether a new frame is wanted.
    pub(crate) is_stale: bool,
    pub(crate) is_leaving: bool,
    /// The picture, the uppermost row first, and its size.
    pub(crate) screen: Vec<u32>,
    pub(crate) screen_size: [u32; 2],
    /// Pictures so far.
    pub(crate) pictures: u64,
    buffers: [Vec<u8>; 2],
    /// Which buffer is being rendered to, and the size it was begun with.
    flight: Option<(usize, [u32; 2])>,
}

/// The largest side of a window.
pub(crate) const LARGEST: u32 = 16384;

impl Stage {
    pub(crate) fn new(renderer: Box<dyn Renderer>) -> Self {
        Self {
            renderer,
            size: [640, 480],
            title: String::new(),
            is_wanted: false,
            is_stale: true,
            is_leaving: false,
            screen: Vec::new(),
            screen_size: [0; 2],
            pictures: 0,
            buffers: [Vec::new(), Vec::new()],
            flight: None,
        }
    }

    /// As at the beginning of a main loop: no pictures, and one is wanted.
    pub(crate) fn begin(&mut self) {
        self.finish();
        (self.pictures, self.is_stale, self.is_leaving) = (0, true, false);
    }

    /// Whether a frame is being rendered.
    pub(crate) fn is_rendering(&self) -> bool {
        self.flight.is_some()
    }

    /// Waits for the frame that is being rendered, and shows it.
    pub(crate) fn finish(&mut self) {
        if let Some((buffer, size)) = self.flight.take() {
            self.renderer.end();
            to_screen(&self.buffers[buffer], size[0] as usize, Format::RGB_8, &mut self.screen);
            self.screen_size = size;
            self.pictures += 1;
        }
    }

    /// Shows the frame that was being rendered, if there was one, and begins the next.
    pub(crate) fn swap(&mut self) {
        let next = self.flight.map_or(0, |(buffer, _)| 1 - buffer);
        self.finish();
        let size = self.size;
        let buffer = &mut self.buffers[next];
        buffer.resize(3 * size[0] as usize * size[1] as usize, 0);
        if self.renderer.start(buffer, size) {
            self.flight = Some((next, size));
        }
    }

    /// Shows pixels of the program; they are all there.
    pub(crate) fn show(&mut self, bytes: &[u8], size: [u32; 2], format: Format) {
        to_screen(bytes, size[0] as usize, format, &mut self.screen);
        self.screen_size = size;
        self.pictures += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// Renders at the end only, as late as may be.
    #[derive(Clone, Default)]
    struct Late(Arc<Mutex<(Option<usize>, u8)>>);

    impl Renderer for Late {
        fn start(&self, buffer: &mut [u8], _: [u32; 2]) -> bool {
            let mut state = self.0.lock().expect("no panic");
            assert_eq!(state.0.replace(buffer.as_ptr() as usize), None, "one frame at a time");
            state.1 += 1;
            buffer.fill(state.1);
            true
        }

        fn end(&self) {
            assert!(self.0.lock().expect("no panic").0.take().is_some(), "a frame was begun");
        }
    }

    #[test]
    fn frames_are_shown_one_later() {
        let mut stage = Stage::new(Box::new(Late::default()));
        stage.size = [2, 1];
        stage.swap();
        assert!(stage.is_rendering() && stage.pictures == 0, "nothing to show yet");
        stage.size = [1, 1];
        stage.swap();
        assert_eq!((&stage.screen[..], stage.screen_size), (&[0x01_0101; 2][..], [2, 1]), "the first one");
        stage.finish();
        assert_eq!((&stage.screen[..], stage.screen_size), (&[0x02_0202][..], [1, 1]), "of the new size");
        stage.finish();
        assert_eq!(stage.pictures, 2, "no more");
    }
}
