// SPDX-License-Identifier: GPL-3.0-or-later
//! Output of shaders during their runs: each line once, up to a limit.
//! Tests: `tests/scripts/wrong.rs`.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use gnurt_sl::exec::Event;

/// Limit of stored lines.
const MOST: usize = 16;

/// Lines of all threads.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    lines: Mutex<Vec<String>>,
    is_full: AtomicBool,
}

impl Faults {
    /// Records a line, if the limit is not reached and it is new.
    pub(crate) fn note(&self, line: &str) {
        if self.is_full.load(Ordering::Relaxed) {
            return;
        }
        let Ok(mut lines) = self.lines.lock() else { return };
        let mut end = line.len().min(400);
        while !line.is_char_boundary(end) {
            end -= 1;
        }
        let line = line[..end].trim_end();
        if line.is_empty() || lines.iter().any(|known| known == line) {
            return;
        }
        if lines.len() == MOST {
            lines.push("and more, which is not printed".to_owned());
            self.is_full.store(true, Ordering::Relaxed);
            return;
        }
        lines.push(line.to_owned());
    }

    /// Notes the output of a shader.
    pub(crate) fn note_event(&self, name: &str, event: &Event) {
        if self.is_full.load(Ordering::Relaxed) {
            return;
        }
        match event {
            Event::Print(text) => self.note(&format!("{name} prints: {text}")),
            Event::Error(text) => self.note(&format!("{name}: {text}")),
            Event::Warning(text) => self.note(&format!("{name}: warning: {text}")),
            // Shaders write no files.
            Event::File(file, text) => self.note(&format!("{name} prints to \"{file}\": {text}")),
        }
    }

    /// All lines.
    pub(crate) fn lines(&self) -> Vec<String> {
        self.lines.lock().map(|lines| lines.clone()).unwrap_or_default()
    }
}
