// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures of a camera in motion, at full size: all pixels find their surface, but only some sample its
//! light. The others reuse the light of previous pictures on the same surface, and filter over their
//! neighbours. Flow: first surfaces -> previous light (`before`) -> choice of pixels -> fresh samples by the
//! integrator -> filter -> colours. Where that takes too long, one pixel of four is traced in each frame, and
//! the others are made from earlier pictures (`whole`).
//! Source: see each file; the combination as [NSL*07] (reprojection), [DSHL10] (filter), [WKB*02] (light and
//! surface apart).

mod around;
mod before;
mod choose;
mod earlier;
mod frame;
mod lattice;
mod noise;
mod picture;
mod smooth;
mod surface_key;
mod surface_sample;
mod texel;
mod whole;

pub use picture::{MotionCost, MotionShare, PictureHistory};
