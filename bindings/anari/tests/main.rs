// SPDX-License-Identifier: GPL-3.0-or-later
//! Tests of the device through its table of functions, as programs call it.

mod attributes;
mod cameras;
mod channels;
mod common;
mod frames;
mod instances;
mod introspection;
mod lifetimes;
mod lights;
mod materials;
mod motion;
mod renderers;
mod rounds;
mod shapes;
mod volumes;
mod wrong;
