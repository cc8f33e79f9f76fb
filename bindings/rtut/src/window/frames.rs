// SPDX-License-Identifier: GPL-3.0-or-later
//! Frames of a window: one is rendered while the program prepares the next.
//! Invariants: no lock is held while libOpenRT is called, which may report an error to the program, which may
//! call back or leave by an exception. After each call its use of a buffer is queried, because calls may
//! fail: only a buffer that no frame uses, present or future, is freed, and only one that is not in flight is
//! read. Tests: `tests`, and tests/c/window_hostile.c under AddressSanitizer.

use super::program::Program;
use super::stage::Flight;

/// libOpenRT's use of a frame buffer (rtFrameBufferUse).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Use {
    /// Frames that start from now on are written to it.
    pub(crate) next: bool,
    /// The frame in flight is written to it.
    pub(crate) in_flight: bool,
}

/// libOpenRT's frames; each call may fail, and reports that to the program.
pub(crate) trait Renderer {
    /// The use of the buffer that begins there; calls nothing of the program.
    fn usage(&self, memory: usize) -> Use;
    /// Gives it a buffer of RGB bytes for the frames that start from now on.
    fn aim(&self, memory: usize, size: [u32; 2]);
    /// Begins a frame.
    fn start(&self);
    /// Waits for the frame in flight.
    fn end(&self);
}

/// Waits for the frame that was begun last, if there is one, and shows it. False if it continues: it could
/// not be ended.
pub(crate) fn finish(program: &dyn Program, renderer: &dyn Renderer) -> bool {
    let mut flight = None;
    program.stage(&mut |stage| flight = stage.flight());
    let Some(Flight { memory, has_begun }) = flight else { return true };
    // The program may have ended it itself, or begun another one with the same buffer.
    let is_in_flight = renderer.usage(memory).in_flight;
    if is_in_flight {
        renderer.end();
        if renderer.usage(memory).in_flight {
            return false;
        }
    }
    program.stage(&mut |stage| {
        if is_in_flight || has_begun {
            stage.land(memory);
        } else {
            stage.set_flight(None);
        }
    });
    true
}

/// Shows the frame that was begun last, if there was one, and begins the next.
pub(crate) fn swap(program: &dyn Program, renderer: &dyn Renderer) {
    if !finish(program, renderer) {
        return;
    }
    let mut busy = Vec::new();
    program.stage(&mut |stage| busy = stage.memories());
    busy.retain(|&memory| renderer.usage(memory) != Use::default());
    let mut target = None;
    program.stage(&mut |stage| target = stage.target(&busy));
    let Some((memory, size)) = target else { return };
    renderer.aim(memory, size);
    if !renderer.usage(memory).next {
        return;
    }
    program.stage(&mut |stage| stage.set_flight(Some(Flight { memory, has_begun: false })));
    renderer.start();
    let has_begun = renderer.usage(memory).in_flight;
    program.stage(&mut |stage| stage.set_flight(has_begun.then_some(Flight { memory, has_begun })));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::Stage;
    use std::cell::RefCell;

    /// A window without hands.
    #[derive(Default)]
    struct Window(RefCell<Stage>);

    impl Program for Window {
        fn display(&self) {}
        fn reshape(&self, _: [u32; 2]) {}
        fn keyboard(&self, _: u8, _: [i32; 2]) {}
        fn special(&self, _: i32, _: [i32; 2]) {}
        fn mouse(&self, _: i32, _: bool, _: [i32; 2]) {}
        fn motion(&self, _: [i32; 2], _: bool) {}
        fn idle(&self) -> bool {
            false
        }
        fn finish(&self) {}
        fn stage(&self, with: &mut dyn FnMut(&mut Stage)) {
            with(&mut self.0.borrow_mut());
        }
    }

    /// The state of libOpenRT, with an open object, in which frames neither start nor end, and a block, in
    /// which even the buffer is fixed.
    #[derive(Default)]
    struct Late {
        next: usize,
        in_flight: Option<usize>,
        is_open: bool,
        is_block: bool,
        /// Frames that ended, which is when this one writes.
        ended: u8,
    }

    #[derive(Default)]
    struct Model<'a>(RefCell<Late>, Option<&'a Window>);

    impl Model<'_> {
        /// Nothing of the program's is locked.
        fn called(&self) {
            assert!(self.1.is_none_or(|window| window.0.try_borrow_mut().is_ok()), "a lock is held");
        }
    }

    impl Renderer for Model<'_> {
        fn usage(&self, memory: usize) -> Use {
            let state = self.0.borrow();
            Use { next: state.next == memory, in_flight: state.in_flight == Some(memory) }
        }

        fn aim(&self, memory: usize, _: [u32; 2]) {
            self.called();
            let mut state = self.0.borrow_mut();
            if !state.is_block {
                state.next = memory;
            }
        }

        fn start(&self) {
            self.called();
            let mut state = self.0.borrow_mut();
            if !state.is_open && !state.is_block && state.in_flight.is_none() {
                state.in_flight = Some(state.next);
            }
        }

        fn end(&self) {
            self.called();
            let mut state = self.0.borrow_mut();
            if !state.is_open && !state.is_block && state.in_flight.take().is_some() {
                state.ended += 1;
            }
        }
    }

    fn pictures(window: &Window) -> u64 {
        window.0.borrow().pictures
    }

    #[test]
    fn frames_are_shown_one_later() {
        let window = Window::default();
        let model = Model(RefCell::default(), Some(&window));
        window.0.borrow_mut().size = [2, 1];
        swap(&window, &model);
        assert!(window.0.borrow().flight().is_some() && pictures(&window) == 0, "nothing to show yet");
        window.0.borrow_mut().size = [1, 1];
        swap(&window, &model);
        assert_eq!((pictures(&window), window.0.borrow().screen_size), (1, [2, 1]), "the first one");
        assert!(finish(&window, &model), "it ends");
        assert_eq!((pictures(&window), window.0.borrow().screen_size), (2, [1, 1]), "of the new size");
        assert!(finish(&window, &model) && pictures(&window) == 2, "no more");
        for side in 2..40 {
            window.0.borrow_mut().size = [side, 1];
            swap(&window, &model);
            assert!(window.0.borrow().memories().len() <= 3, "old buffers go");
        }
    }

    /// After any failure, no memory is freed that libOpenRT may write to, and none is shown before it is
    /// whole.
    #[test]
    fn failed_calls_keep_memory() {
        // Each digit of `way` is a step: the open construct, and the size of the window.
        for way in 0..6_u32.pow(6) {
            let window = Window::default();
            let model = Model(RefCell::default(), Some(&window));
            let mut rest = way;
            for step in 0..6 {
                let (open, size) = (rest % 3, rest / 3 % 2);
                rest /= 6;
                (model.0.borrow_mut().is_open, model.0.borrow_mut().is_block) = (open == 1, open == 2);
                window.0.borrow_mut().size = [4 + 4 * size, 1];
                let before = (pictures(&window), model.0.borrow().ended);
                if step % 3 == 2 {
                    finish(&window, &model);
                } else {
                    swap(&window, &model);
                }
                let (state, stage) = (model.0.borrow(), window.0.borrow());
                let retained = stage.memories();
                for memory in
                    [Some(state.next).filter(|&next| next != 0), state.in_flight].into_iter().flatten()
                {
                    assert!(retained.contains(&memory), "way {way}, step {step}: freed while in use");
                }
                assert!(retained.len() <= 3, "way {way}, step {step}: {} buffers", retained.len());
                let ended = u64::from(state.ended - before.1);
                assert_eq!(
                    stage.pictures - before.0,
                    ended,
                    "way {way}, step {step}: each frame is shown once"
                );
            }
        }
    }

    #[test]
    fn frames_of_the_program_itself() {
        let window = Window::default();
        let model = Model(RefCell::default(), Some(&window));
        swap(&window, &model);
        model.end();
        assert!(finish(&window, &model) && pictures(&window) == 1, "ended by the program, and shown");
        model.start();
        swap(&window, &model);
        assert!(window.0.borrow().flight().is_none(), "the program's own frame is in flight");
        let busy = model.0.borrow().in_flight.expect("in flight");
        assert!(window.0.borrow().memories().contains(&busy), "and keeps its memory");
        // The callback for an error at the start has left by an exception: the frame exists, but is unknown.
        let window = Window::default();
        let model = Model(RefCell::default(), Some(&window));
        swap(&window, &model);
        let memory = window.0.borrow().memories()[0];
        window.0.borrow_mut().set_flight(Some(Flight { memory, has_begun: false }));
        assert!(finish(&window, &model) && pictures(&window) == 1, "it is found and shown");
    }
}
