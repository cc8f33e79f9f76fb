// SPDX-License-Identifier: GPL-3.0-or-later
//! The layers of a picture's file. Tests: `tests/program/layers.rs`.

use gnurt::layers::{FORMS, LayerError, LayerList, known_words};

use crate::nearest::unknown;

/// A list as the library reads it; slips get the nearest word.
pub(crate) fn layers(text: &str) -> Result<LayerList, String> {
    gnurt::layers::layers(text).map_err(|error| match error {
        LayerError::Unknown { word } => format!("{}; {FORMS}", unknown("layer", &word, &known_words())),
        LayerError::Invalid(why) => why,
    })
}
