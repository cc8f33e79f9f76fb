// SPDX-License-Identifier: GPL-3.0-or-later
//! The interpreter against machine code.

mod agreement;
mod batches;
mod chance;
mod world;
