// SPDX-License-Identifier: GPL-3.0-or-later
//! Dictionaries for shaders: documents in XML.

mod dictionaries;
mod path;
mod xml;

pub use dictionaries::{Dictionaries, DictionaryError, numbers};
