// SPDX-License-Identifier: GPL-3.0-or-later
//! Events of a window of winit in the words of [`Input`]. Tests: `crates/cli/tests/program/window.rs`.

use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{Key as WinitKey, KeyCode, NamedKey, PhysicalKey};

use crate::input::{Button, Input, Key};

/// Pixels of a touch pad per notch of a wheel.
const NOTCH: f64 = 40.0;

/// Letters that count by their place on the keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ByPlace {
    None,
    /// Those that fly: W A S D, Q E of an American keyboard, which lie side by side on all others, too.
    Flight {
        is_control_held: bool,
    },
}

/// An event that means something here.
pub(crate) fn input(event: &WindowEvent, by_place: ByPlace) -> Option<Input> {
    let button = |button: &MouseButton| match button {
        MouseButton::Left => Some(Button::Left),
        MouseButton::Middle => Some(Button::Middle),
        MouseButton::Right => Some(Button::Right),
        _ => None,
    };
    match event {
        WindowEvent::CloseRequested => Some(Input::Close),
        WindowEvent::Resized(size) => Some(Input::Size((*size).into())),
        WindowEvent::Focused(false) => Some(Input::FocusLost),
        WindowEvent::ModifiersChanged(modifiers) => {
            let state = modifiers.state();
            Some(Input::Modifiers { shift: state.shift_key(), control: state.control_key() })
        }
        WindowEvent::CursorMoved { position, .. } => Some(Input::Cursor([position.x, position.y])),
        WindowEvent::MouseInput { state: ElementState::Pressed, button: pressed, .. } => {
            button(pressed).map(Input::ButtonDown)
        }
        WindowEvent::MouseInput { state: ElementState::Released, button: released, .. } => {
            button(released).map(Input::ButtonUp)
        }
        WindowEvent::MouseWheel { delta, .. } => Some(Input::Wheel(match delta {
            MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / NOTCH,
        })),
        WindowEvent::KeyboardInput { event, is_synthetic, .. } => {
            let is_down = event.state == ElementState::Pressed;
            let key = match by_place {
                ByPlace::None => key(&event.logical_key),
                // A key that moved something is let go by its place, whatever is held by then.
                ByPlace::Flight { is_control_held } if is_down && is_control_held => key(&event.logical_key),
                ByPlace::Flight { .. } => flight_key(&event.physical_key, &event.logical_key),
            };
            match event.state {
                // Keys that were down before the window had the focus are not meant for it.
                ElementState::Pressed if *is_synthetic => None,
                ElementState::Pressed => key.map(|key| Input::KeyDown { key, repeat: event.repeat }),
                ElementState::Released => key.map(Input::KeyUp),
            }
        }
        _ => None,
    }
}

/// The letter that flies, by its place; any other key by its character, unless that is one of these letters.
fn flight_key(place: &PhysicalKey, character: &WinitKey) -> Option<Key> {
    const FLIGHT: [(KeyCode, char); 6] = [
        (KeyCode::KeyW, 'w'),
        (KeyCode::KeyA, 'a'),
        (KeyCode::KeyS, 's'),
        (KeyCode::KeyD, 'd'),
        (KeyCode::KeyQ, 'q'),
        (KeyCode::KeyE, 'e'),
    ];
    let PhysicalKey::Code(place) = place else { return key(character) };
    if let Some((_, letter)) = FLIGHT.iter().find(|(code, _)| code == place) {
        return Some(Key::Char(*letter));
    }
    let is_free = |key: &Key| match key {
        Key::Char(c) => !FLIGHT.iter().any(|(_, letter)| c.to_ascii_lowercase() == *letter),
        _ => true,
    };
    key(character).filter(is_free)
}

fn key(key: &WinitKey) -> Option<Key> {
    match key {
        WinitKey::Character(text) => text.chars().next().map(Key::Char),
        WinitKey::Named(named) => match named {
            NamedKey::ArrowLeft => Some(Key::Left),
            NamedKey::ArrowRight => Some(Key::Right),
            NamedKey::ArrowUp => Some(Key::Up),
            NamedKey::ArrowDown => Some(Key::Down),
            NamedKey::Escape => Some(Key::Escape),
            NamedKey::Tab => Some(Key::Tab),
            NamedKey::Space => Some(Key::Char(' ')),
            NamedKey::F1 => Some(Key::F(1)),
            NamedKey::F11 => Some(Key::F(11)),
            NamedKey::F12 => Some(Key::F(12)),
            _ => None,
        },
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flight_keys_are_those_beside_each_other() {
        let typed = |place: KeyCode, character: &str| {
            flight_key(&PhysicalKey::Code(place), &WinitKey::Character(character.into()))
        };
        assert_eq!(typed(KeyCode::KeyW, "w"), Some(Key::Char('w')));
        // French keyboards have Z where W is, and W elsewhere.
        assert_eq!(typed(KeyCode::KeyW, "z"), Some(Key::Char('w')));
        assert_eq!(typed(KeyCode::KeyQ, "A"), Some(Key::Char('q')));
        assert_eq!(typed(KeyCode::KeyZ, "w"), None);
        assert_eq!(typed(KeyCode::KeyT, "T"), Some(Key::Char('T')));
    }
}
