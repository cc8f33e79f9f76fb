// SPDX-License-Identifier: GPL-3.0-or-later
//! Keys and mouse, independent of any window system. Positions are pixels of the window from its upper left
//! corner.

/// A key that means something here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A key that writes a character, as it would be written: `b` or `B`.
    Char(char),
    /// Arrow keys.
    Left,
    /// Arrow keys.
    Right,
    /// Arrow keys.
    Up,
    /// Arrow keys.
    Down,
    /// Leave.
    Escape,
    /// Next of a list.
    Tab,
    /// Function keys, by their number.
    F(u8),
}

/// A button of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// The first one.
    Left,
    /// The wheel, pressed.
    Middle,
    /// The last one.
    Right,
}

/// One event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// A key went down; `repeat` if the system repeats it because it was held.
    KeyDown {
        /// Which.
        key: Key,
        /// Whether it was down before.
        repeat: bool,
    },
    /// A key went up.
    KeyUp(Key),
    /// Which of shift and control are held from now on.
    Modifiers {
        /// Shift.
        shift: bool,
        /// Control.
        control: bool,
    },
    /// A button went down where the cursor is.
    ButtonDown(Button),
    /// A button went up where the cursor is.
    ButtonUp(Button),
    /// The cursor is here now.
    Cursor([f64; 2]),
    /// The wheel moved by this many notches, away from the hand positive.
    Wheel(f64),
    /// The window has this many pixels now.
    Size([u32; 2]),
    /// Keys and buttons go to another window now: none is held.
    FocusLost,
    /// The window is to be closed.
    Close,
}
