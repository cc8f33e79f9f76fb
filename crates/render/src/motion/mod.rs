// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures of a camera in motion, whole and full-size: all pixels are looked at anew, but light only by some of them; the others
//! remember what the pictures before knew of the light on the surface that they see, and ask their neighbours.
//! Flow: look (first surfaces) -> before (light remembered) -> choose -> fresh samples by the integrator -> smooth -> colours.
//! Source: see each file; taken together as [NSL*07] (reprojection), [DSHL10] (filter), [WKB*02] (light and surface apart).

mod before;
mod choose;
mod picture;
mod smooth;
mod surface_key;
mod surface_sample;

pub use picture::{MotionCost, PictureHistory};
