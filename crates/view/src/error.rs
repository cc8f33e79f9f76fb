// SPDX-License-Identifier: GPL-3.0-or-later
//! Errors between a picture and the screen.

/// Why nothing is seen.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// No display can be reached, or its libraries are missing.
    #[error("no window can be opened: {0}; set DISPLAY or WAYLAND_DISPLAY, or use --headless")]
    NoDisplay(String),
    /// The scene cannot be read.
    #[error("{0}")]
    Scene(String),
    /// Nothing to render, or a picture that is too large.
    #[error(transparent)]
    Render(#[from] gnurt::render::RenderError),
    /// The camera has no view.
    #[error("the camera has no view: eye and target coincide, or a number is too large")]
    NoView,
    /// A thread cannot be started.
    #[error("a thread cannot be started: {0}")]
    Thread(std::io::Error),
    /// The other program does not answer, or hung up.
    #[error("tev at {address}: {why}; is it running, and does it listen there?")]
    Tev {
        /// Host and port.
        address: String,
        /// The system's words.
        why: String,
    },
}

impl ViewError {
    /// A display's message, without the source position in a library.
    pub(crate) fn no_display(error: &dyn std::fmt::Display) -> Self {
        let message = error.to_string();
        let text = message.strip_prefix("os error at ").and_then(|rest| rest.split_once(": "));
        let text = text.map_or(&message[..], |(_, text)| text);
        Self::NoDisplay(text.trim_end_matches('.').to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_libraries_are_left_out() {
        let message = |text: &str| ViewError::no_display(&text).to_string();
        let expected =
            "no window can be opened: DISPLAY is not set; set DISPLAY or WAYLAND_DISPLAY, or use --headless";
        assert_eq!(
            message("os error at /home/a b/winit/mod.rs:765: DISPLAY is not set."),
            expected,
            "a library's"
        );
        assert_eq!(message("DISPLAY is not set"), expected, "others stay");
    }
}
