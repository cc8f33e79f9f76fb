// SPDX-License-Identifier: GPL-3.0-or-later
//! The output of a tool: two streams whose texts keep their order; and the program's services.

use gnurt_sl::engine::Engine;
use gnurt_sl::stored::Textures;
use std::io::Write;

/// Standard output and standard error, or their replacement in a test.
pub struct Console<'a> {
    out: &'a mut dyn Write,
    err: &'a mut dyn Write,
    /// Whether the tool was called by its own name, by a link, and so replaces OSL's.
    pub link: bool,
    /// Another engine for running shaders.
    pub engine: Option<Engine>,
    /// The pictures that shaders read, if it can read any.
    pub textures: Option<&'a dyn Textures>,
}

impl<'a> Console<'a> {
    /// On two streams.
    pub fn new(out: &'a mut dyn Write, err: &'a mut dyn Write, link: bool) -> Self {
        Self { out, err, link, engine: None, textures: None }
    }

    /// Writes to standard output. A reader that has gone away is no reason to stop.
    pub fn print(&mut self, text: &str) {
        let _ = self.out.write_all(text.as_bytes());
    }

    /// Writes bytes to standard output.
    pub fn print_bytes(&mut self, bytes: &[u8]) {
        let _ = self.out.write_all(bytes);
    }

    /// Writes to standard error, after all that was printed before.
    pub fn complain(&mut self, text: &str) {
        let _ = self.out.flush();
        let _ = self.err.write_all(text.as_bytes());
        let _ = self.err.flush();
    }

    /// Flushes buffered text.
    pub fn flush(&mut self) {
        let _ = self.out.flush();
    }
}
