// SPDX-License-Identifier: GPL-3.0-or-later
//! Texts by number, so that a cell can hold one.
//! Invariant: number 0 is the empty text; those of [`WELL_KNOWN`] follow.

use std::collections::HashMap;
use std::sync::Arc;

/// Bytes that a point's texts may take.
const LIMIT: usize = 64 << 20;

/// Texts and their numbers.
#[derive(Clone, Debug)]
pub struct Strings {
    list: Vec<Arc<str>>,
    numbers: HashMap<Arc<str>, u32>,
    bytes: usize,
}

impl Default for Strings {
    fn default() -> Self {
        let mut this = Self { list: Vec::new(), numbers: HashMap::new(), bytes: 0 };
        this.number("");
        WELL_KNOWN.iter().for_each(|text| _ = this.number(text));
        this
    }
}

/// Texts with fixed numbers, by which a host recognises them in closures: the first of this list has 1.
pub const WELL_KNOWN: [&str; 2] = ["beckmann", "default"];

impl Strings {
    /// The number of a text. Past 64 MiB of texts it is that of the empty one.
    pub fn number(&mut self, text: &str) -> u32 {
        if let Some(&number) = self.numbers.get(text) {
            return number;
        }
        self.bytes += text.len() + 16;
        if self.bytes > LIMIT {
            return 0;
        }
        let number = self.list.len() as u32;
        let text: Arc<str> = text.into();
        self.list.push(text.clone());
        self.numbers.insert(text, number);
        number
    }

    /// The number of a text that has one.
    #[must_use]
    pub fn find(&self, text: &str) -> Option<u32> {
        self.numbers.get(text).copied()
    }

    /// The text of a number.
    #[must_use]
    pub fn text(&self, number: u32) -> &Arc<str> {
        &self.list[if (number as usize) < self.list.len() { number as usize } else { 0 }]
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.list.len()
    }

    /// Removes all but the first `count`.
    pub fn truncate(&mut self, count: usize) {
        while self.list.len() > count.max(1 + WELL_KNOWN.len()) {
            if let Some(text) = self.list.pop() {
                self.bytes -= text.len() + 16;
                self.numbers.remove(&text);
            }
        }
    }
}
