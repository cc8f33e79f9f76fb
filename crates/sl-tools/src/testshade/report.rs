// SPDX-License-Identifier: GPL-3.0-or-later
//! Prints the output of shaders, without recent repetitions. The rule for repetitions is OSL's.

use crate::console::Console;
use gnurt_sl::exec::Event;
use std::collections::VecDeque;
use std::io::Write;

/// Messages are compared with this many before them.
const HISTORY: usize = 25;

/// Recent output.
#[derive(Default)]
pub(super) struct Recent {
    errors: VecDeque<String>,
    warnings: VecDeque<String>,
}

fn is_new(list: &mut VecDeque<String>, text: &str) -> bool {
    if list.iter().any(|old| old == text) {
        return false;
    }
    if list.len() == HISTORY {
        list.pop_front();
    }
    list.push_back(text.to_owned());
    true
}

/// Prints events in order.
pub(super) fn report(events: &[Event], repeats: bool, recent: &mut Recent, console: &mut Console<'_>) {
    for event in events {
        match event {
            Event::Print(text) => console.print(text),
            Event::Error(text) => {
                if repeats || is_new(&mut recent.errors, text) {
                    console.complain(&format!("ERROR: {text}\n"));
                }
            }
            Event::Warning(text) => {
                if repeats || is_new(&mut recent.warnings, text) {
                    console.complain(&format!("WARNING: {text}\n"));
                }
            }
            Event::File(name, text) => {
                let file = std::fs::OpenOptions::new().create(true).append(true).open(name);
                if file.and_then(|mut f| f.write_all(text.as_bytes())).is_err() {
                    console.complain(&format!("ERROR: cannot write to \"{name}\"\n"));
                }
            }
        }
    }
}
