// SPDX-License-Identifier: GPL-3.0-or-later
//! Logical lines of text files, streamed: byte order mark, CR, CRLF, continuation, stray bytes.
//! Source: Wavefront OBJ and MTL, where a backslash at the end of a line joins the next one. Lines count from 1.
//! Memory: one line at a time, at most [`LONGEST`] bytes.
//! Tests: `tests::{joins_and_counts, refuses_binary_data}`.

use std::io::BufRead;
use std::path::{Path, PathBuf};

use super::Error;

/// Bytes that a logical line may have: more is no text but an attack or an accident.
pub(crate) const LONGEST: usize = 16 << 20;

/// Reads logical lines of one file.
pub(crate) struct LogicalLines<R> {
    reader: R,
    path: PathBuf,
    /// Physical lines read so far.
    line: u64,
    /// Whether the first line may begin with a byte order mark.
    has_mark: bool,
    /// Whether the last line ended with CR, so that LF right after it belongs to it.
    after_cr: bool,
    bytes: Vec<u8>,
    text: String,
}

impl<R: BufRead> LogicalLines<R> {
    /// Reads from `reader`; `path` is for messages.
    pub(crate) fn new(reader: R, path: &Path) -> Self {
        let path = path.to_owned();
        Self {
            reader,
            path,
            line: 0,
            has_mark: true,
            after_cr: false,
            bytes: Vec::new(),
            text: String::new(),
        }
    }

    /// Physical lines read so far.
    pub(crate) fn count(&self) -> u64 {
        self.line
    }

    /// The next line with contents, trimmed, without comments that fill it, and the number of its first
    /// physical line; `None` at the end of the file.
    pub(crate) fn next(&mut self) -> Result<Option<(u64, &str)>, Error> {
        loop {
            self.bytes.clear();
            let first = self.line + 1;
            let mut more = self.physical()?;
            if !more && self.bytes.is_empty() {
                return Ok(None);
            }
            while self.bytes.last() == Some(&b'\\') {
                self.bytes.pop();
                self.bytes.push(b' ');
                // At the end of the file there is nothing to be joined.
                if !more {
                    break;
                }
                more = self.physical()?;
            }
            if std::mem::take(&mut self.has_mark) && self.bytes.starts_with(b"\xef\xbb\xbf") {
                self.bytes.drain(..3);
            }
            // Without a branch for each byte.
            let is_binary = |&b: &u8| (b < b' ') & (b != b'\t') & (b != b'\x0c');
            if self.bytes.iter().fold(false, |any, b| any | is_binary(b)) {
                return Err(Error::data(&self.path, Some(first), "binary data", "expected text in UTF-8"));
            }
            let line = self.bytes.trim_ascii();
            if line.is_empty() || line[0] == b'#' {
                continue;
            }
            // A second look at the bytes, because a loop that may go on cannot lend them.
            let line = self.bytes.trim_ascii();
            return Ok(Some((
                first,
                match std::str::from_utf8(line) {
                    Ok(text) => text,
                    Err(_) => {
                        self.text = String::from_utf8_lossy(line).into_owned();
                        &self.text
                    }
                },
            )));
        }
    }

    /// Appends one physical line to `bytes`, without its end; `false` at the end of the file.
    fn physical(&mut self) -> Result<bool, Error> {
        let mut is_begun = false;
        loop {
            let available = self.reader.fill_buf().map_err(|e| Error::system(&self.path, &e))?;
            if available.is_empty() {
                return Ok(false);
            }
            if std::mem::take(&mut self.after_cr) && available[0] == b'\n' {
                self.reader.consume(1);
                continue;
            }
            self.line += u64::from(!std::mem::replace(&mut is_begun, true));
            let end = line_end(available);
            self.bytes.extend_from_slice(&available[..end.unwrap_or(available.len())]);
            self.after_cr = end.is_some_and(|end| available[end] == b'\r');
            let consumed = end.map_or(available.len(), |end| end + 1);
            self.reader.consume(consumed);
            if self.bytes.len() > LONGEST {
                let problem = format!("a line of more than {} MiB", LONGEST >> 20);
                return Err(Error::data(&self.path, Some(self.line), problem, "expected lines of text"));
            }
            if end.is_some() {
                return Ok(true);
            }
        }
    }
}

impl<'a> LogicalLines<&'a [u8]> {
    /// Reads a block of whole lines; numbers count from its first one.
    pub(crate) fn of_block(bytes: &'a [u8], path: &Path, is_first: bool) -> Self {
        Self { has_mark: is_first, ..Self::new(bytes, path) }
    }

    /// The bytes that are not read yet.
    pub(crate) fn rest(&self) -> &'a [u8] {
        self.reader
    }

    /// Steps over a physical line of this many bytes, its end included.
    pub(crate) fn skip_line(&mut self, length: usize) {
        self.reader = &self.reader[length..];
        self.line += 1;
        (self.after_cr, self.has_mark) = (false, false);
    }
}

/// The position of the first end of a line.
fn line_end(bytes: &[u8]) -> Option<usize> {
    const STEP: usize = 16;
    let is_end = |b: &u8| (*b == b'\n') | (*b == b'\r');
    // Steps without a branch for each byte.
    let clear = bytes
        .chunks_exact(STEP)
        .take_while(|step| !step.iter().fold(false, |any, b| any | is_end(b)))
        .count();
    let begin = clear * STEP;
    bytes[begin..].iter().position(is_end).map(|at| begin + at)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Result<Vec<(u64, String)>, Error> {
        // A tiny buffer, so that every line end falls between two reads once.
        let reader = std::io::BufReader::with_capacity(1, bytes);
        let mut lines = LogicalLines::new(reader, Path::new("t.obj"));
        let mut all = Vec::new();
        while let Some((number, text)) = lines.next()? {
            all.push((number, text.to_owned()));
        }
        Ok(all)
    }

    #[test]
    fn joins_and_counts() {
        let text = b"\xef\xbb\xbfv 1\r\n\t f 1 \\\r\n2 \\\n3\n\n# c\ro\tcaf\xe9\rlast";
        let expected = [(1, "v 1"), (2, "f 1  2  3"), (7, "o\tcaf\u{fffd}"), (8, "last")];
        let expected: Vec<_> = expected.map(|(n, t)| (n, t.to_owned())).into();
        assert_eq!(lines(text).expect("all text"), expected, "every kind of line end");
    }

    #[test]
    fn a_last_backslash_joins_nothing() {
        for text in [&b"f 1 2 3 \\"[..], b"f 1 2 3 \\\n", b"f 1 2 3\\\n"] {
            assert_eq!(lines(text).expect("text"), [(1, "f 1 2 3".to_owned())], "{text:?}");
        }
    }

    #[test]
    fn refuses_binary_data() {
        let error = lines(b"v 1\nv \0\n").expect_err("a NUL is no text");
        assert_eq!(error.line, Some(2), "with its line: {error}");
    }
}
