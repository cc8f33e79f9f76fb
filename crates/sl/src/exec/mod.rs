// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter: what a shader means, one point at a time.
//! Source: original.
//!
//! A group of shaders is laid out in one memory of 32-bit cells (`layout`); a [`Machine`] runs it for a point and asks a [`Host`]
//! for all that only a renderer knows. `table` names the operations; `arithmetic`, `assign`, `element`, `math`, `noise`,
//! `space`, `texts`, `print`, `message`, `closure` and `state` do them.

mod arithmetic;
mod assign;
mod closure;
mod components;
mod element;
mod host;
mod layout;
mod machine;
mod math;
mod message;
mod noise;
mod print;
mod run;
mod slot;
mod space;
mod state;
mod strings;
mod table;
mod texts;
mod values;

pub use components::{Closure, ClosureDecl, ClosureParam, Component};
pub use host::{Given, Host, Point};
pub use layout::PlanOptions;
pub use machine::{Event, Machine, Plan};
pub use strings::Strings;
pub use table::unknown_operation;
