// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs shaders on a small artificial world and prints or saves their results. Options, world and output are
//! those of OSL's `testshade`.
//!
//! `options` reads the command line, `build` makes the group, `world` answers the shaders' queries, `shade`
//! runs the points, `report` prints their output.

mod build;
mod clouds;
mod options;
mod report;
mod shade;
mod world;

use super::console::Console;

/// Runs the tool; returns the exit status.
pub fn testshade(args: &[String], console: &mut Console<'_>) -> i32 {
    let options = match options::read(args) {
        Ok(options) => options,
        Err(None) => {
            console.print(options::USAGE);
            return 0;
        }
        Err(Some(message)) => {
            console.complain(&format!("ERROR: {message}\n"));
            return 1;
        }
    };
    let Some(group) = build::group(&options, console) else { return 1 };
    shade::shade(&options, group, console)
}
