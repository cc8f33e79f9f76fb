// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours: spaces by name, luminance, black bodies, light of one wavelength.

mod convert;
mod matching;
mod spectrum;
mod system;

pub use spectrum::wavelength_xyz;
pub use system::{ColorSystem, UnknownColorSpace};
