// SPDX-License-Identifier: GPL-3.0-or-later
//! Decisions without rounding: on which side of an edge a line passes, on which side of a plane a point lies.
//! Source: [She97] for the plan: doubles first, with a bound of their error, and exact arithmetic only where they cannot tell.

mod ball;
mod dyadic;
mod exact_hit;
mod line;
mod meeting;
mod number;
mod path;
mod plane;
mod twice;
mod weights;

pub use ball::side_of_sphere;
pub(crate) use exact_hit::ExactHit;
pub use line::Line;
pub use meeting::{Along, Corners};
pub use path::{InstancePath, Triangle};
pub use plane::{LOST_SLOPE, Meeting, PLAIN};
pub use weights::EIGHT;
