// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures as scripts read them.

use std::sync::Arc;

use gnurt_image::Texels;

use crate::mipmap::{Minify, MipMap};
use crate::texture::{TextureSampler, Wrap};

/// As shaders read a picture, if they give no options.
#[must_use]
pub fn sampler(texels: Arc<Texels>) -> TextureSampler {
    let mips = Arc::new(MipMap::new(texels.clone()));
    let minify = Some((Minify::Ellipse, mips));
    TextureSampler { wrap: [Wrap::Clamp; 2], minify, ..TextureSampler::new(texels) }
}
