// SPDX-License-Identifier: GPL-3.0-or-later
//! Events of a window of winit in the words of [`Input`]. Tests: `crates/cli/tests/program/window.rs`.

use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{Key as WinitKey, NamedKey};

use crate::input::{Button, Input, Key};

/// Pixels of a touch pad per notch of a wheel.
const NOTCH: f64 = 40.0;

/// An event that means something here.
pub(crate) fn input(event: &WindowEvent) -> Option<Input> {
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
            let key = key(&event.logical_key);
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
