// SPDX-License-Identifier: GPL-3.0-or-later
//! Mathematics with the language's safe meaning: nothing that is given numbers gives NaN or infinity.

mod arithmetic;
mod exponential;
mod steps;
mod trigonometry;
pub mod vectors;

pub use arithmetic::{
    abs, abs_int, cbrt, ceil, clamp, degrees, div, div_int, floor, fmod, hypot, hypot3, inversesqrt, max,
    min, mod_int, modulo, radians, rem_int, round, sign, sqrt, trunc,
};
pub use exponential::{erf, erfc, exp, exp2, expm1, log, log2, log10, logb, pow};
pub use steps::{aastep, filterwidth, linearstep, mix, select, smooth_linearstep, smoothstep, step};
pub use trigonometry::{acos, asin, atan, atan2, cos, cosh, sin, sincos, sinh, tan, tanh};
