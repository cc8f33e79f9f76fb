// SPDX-License-Identifier: GPL-3.0-or-later
//! Dictionaries that shaders ask: documents in XML.

mod dictionaries;
mod path;
mod xml;

pub use dictionaries::{Dictionaries, DictionaryError, numbers};
