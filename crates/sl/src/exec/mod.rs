// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter, which defines the meaning of a shader, one point at a time.
//!
//! A group of shaders is laid out in one memory of 32-bit cells (`layout`); a [`Machine`] runs it for a point
//! and queries a [`Host`] for the renderer's data; a [`Program`] runs sixteen points. `compute` does operations on
//! numbers, and `direct` those of common operands by functions that are chosen beforehand; `table` lists the others, which `math`, `noise`, `space`, `texts`, `print`, `message`, `closure` and
//! `state` implement.

mod batch;
mod batch_ops;
mod cells;
mod closure;
mod components;
mod compute;
mod dictionary;
mod direct;
mod host;
mod known;
mod lanes;
mod layout;
mod light;
mod machine;
mod math;
mod message;
mod nesting;
mod noise;
mod points;
mod print;
mod rows;
mod run;
mod scalar;
mod single_op;
mod slot;
mod space;
mod standard;
mod state;
mod strings;
mod table;
mod texts;
mod texture;
mod unwritten;
mod values;

pub use batch::{Points, Program, Results};
pub use batch_ops::queries_in_batches;
pub use cells::{Batch, Cells, DualRow, LANES, Row, lanes_of};
pub use closure::{Bound, makes_closures};
pub use components::{Closure, ClosureDecl, ClosureParam, Closures, Component, Part};
pub use compute::{Values, chooses, compute, is_computed, transfer, writes_all};
pub use host::{Arriving, Given, Host, Point, Subimage, TextureOptions, TraceOptions, longitude_latitude};
pub(crate) use known::result as known_result;
pub use layout::PlanOptions;
pub use machine::{
    Copy, Event, Flow, Instruction, LayerPlan, Loop, Machine, Memory, Message, Param, Plan, Source, Step,
};
pub use slot::{RetainedOutput, Slot};
pub use standard::standard_closures;
pub use strings::{Strings, WELL_KNOWN};
pub use table::unknown_operation;
