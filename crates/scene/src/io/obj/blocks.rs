// SPDX-License-Identifier: GPL-3.0-or-later
//! Whole lines of an OBJ file in blocks, parsed on all threads and handed out in the order of the file.
//! The thread that uses the batches parses blocks as well while it waits. A block ends behind a line that no backslash
//! joins to the next one. Memory: a few blocks for each thread. Tests: `tests`.

use std::collections::VecDeque;
use std::io::Read;
use std::path::Path;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::batch::Batch;
use crate::io::Error;
use crate::io::lines::{LONGEST, LogicalLines};
use crate::io::threads::beside;

/// Bytes of a block, but for its last line.
const BLOCK: usize = 1 << 18;
/// Blocks for each thread that are parsed and not used yet, at most.
const AHEAD: usize = 3;

/// The statements of a block, and how its lines ended.
type Parsed = (Batch, Result<(), Error>);

/// Cuts a file into blocks.
struct Blocks<R> {
    reader: R,
    /// The begin of the next block's bytes.
    rest: Vec<u8>,
    /// Blocks so far.
    count: usize,
    is_over: bool,
}

impl<R: Read> Blocks<R> {
    /// Fills `bytes` with the next block; `false` behind the last one.
    fn next(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<bool> {
        bytes.clear();
        bytes.append(&mut self.rest);
        let mut looked = 0;
        while !self.is_over {
            let read = self.reader.by_ref().take(BLOCK as u64).read_to_end(bytes)?;
            self.is_over = read < BLOCK;
            if self.is_over {
                break;
            }
            if let Some(end) = last_end(bytes, looked) {
                self.rest.extend_from_slice(&bytes[end..]);
                bytes.truncate(end);
                break;
            }
            looked = bytes.len();
            // It is refused as a line that is too long.
            if looked > 2 * LONGEST {
                break;
            }
        }
        self.count += 1;
        Ok(!bytes.is_empty())
    }
}

/// Behind the last line that is whole and is not joined to the next one; it does not begin before `from`.
fn last_end(bytes: &[u8], from: usize) -> Option<usize> {
    let mut end = bytes.len();
    loop {
        let at = from + bytes[from..end].iter().rposition(|&byte| byte == b'\n')?;
        let line = bytes[..at].strip_suffix(b"\r").unwrap_or(&bytes[..at]);
        if !line.ends_with(b"\\") {
            return Some(at + 1);
        }
        end = at;
    }
}

/// Blocks on their way.
#[derive(Default)]
struct Queue {
    /// Parsed blocks from number `used` on; `None` = in progress.
    parsed: VecDeque<Option<Parsed>>,
    used: usize,
    /// A thread has panicked.
    is_broken: bool,
    /// No block is to be begun any more: the file is over, or the user of the batches is gone.
    is_closed: bool,
    /// Memory to use again.
    spare_bytes: Vec<Vec<u8>>,
    spare_batches: Vec<Batch>,
}

struct Shared<'a, R> {
    blocks: Mutex<Blocks<R>>,
    queue: Mutex<Queue>,
    changed: Condvar,
    path: &'a Path,
    most: usize,
}

/// The outcome of a try to parse.
enum Step {
    Parsed,
    /// Enough blocks are parsed.
    Full,
    Over,
}

/// Calls `with` with the statements of all blocks in order, and the error that ended the last one. Up to `threads` threads read
/// and parse.
pub(super) fn for_each<R: Read + Send>(
    reader: R,
    path: &Path,
    threads: usize,
    mut with: impl FnMut(&Batch, Result<(), Error>) -> Result<(), Error>,
) -> Result<(), Error> {
    let blocks = Blocks { reader, rest: Vec::new(), count: 0, is_over: false };
    let most = threads * AHEAD;
    let shared =
        Shared { blocks: Mutex::new(blocks), queue: Mutex::default(), changed: Condvar::new(), path, most };
    let helper = || shared.help();
    beside(threads, &helper, || {
        let outcome = shared.hand_out(&mut with);
        shared.lock().is_closed = true;
        shared.changed.notify_all();
        outcome
    })
}

impl<R: Read> Shared<'_, R> {
    fn lock(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'q>(&self, queue: MutexGuard<'q, Queue>) -> MutexGuard<'q, Queue> {
        self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner)
    }

    /// Parses blocks until there are none.
    fn help(&self) {
        loop {
            match self.step() {
                Step::Parsed => {}
                Step::Over => return,
                Step::Full => {
                    let queue = self.lock();
                    if queue.parsed.len() >= self.most && !queue.is_closed {
                        drop(self.wait(queue));
                    }
                }
            }
        }
    }

    /// Parses one block.
    fn step(&self) -> Step {
        // Numbers are given in the order of the file.
        let mut blocks = self.blocks.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut bytes, mut batch) = {
            let mut queue = self.lock();
            if queue.is_closed {
                return Step::Over;
            }
            if queue.parsed.len() >= self.most {
                return Step::Full;
            }
            (queue.spare_bytes.pop().unwrap_or_default(), queue.spare_batches.pop().unwrap_or_default())
        };
        let read = blocks.next(&mut bytes);
        let is_first = blocks.count == 1;
        let number = {
            let mut queue = self.lock();
            if matches!(read, Ok(false)) {
                queue.is_closed = true;
                self.changed.notify_all();
                return Step::Over;
            }
            queue.is_closed |= read.is_err();
            queue.parsed.push_back(None);
            queue.used + queue.parsed.len() - 1
        };
        drop(blocks);
        let alarm = Alarm(self);
        let outcome = match read {
            Ok(_) => batch.fill(LogicalLines::of_block(&bytes, self.path, is_first)),
            Err(error) => Err(Error::system(self.path, &error)),
        };
        drop(alarm);
        let mut queue = self.lock();
        let slot = number - queue.used;
        queue.parsed[slot] = Some((batch, outcome));
        queue.spare_bytes.push(bytes);
        drop(queue);
        self.changed.notify_all();
        Step::Parsed
    }

    fn hand_out(
        &self,
        with: &mut impl FnMut(&Batch, Result<(), Error>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        loop {
            let mut queue = self.lock();
            if let Some(Some(_)) = queue.parsed.front() {
                let parsed = queue.parsed.pop_front().flatten();
                queue.used += 1;
                drop(queue);
                self.changed.notify_all();
                let Some((batch, outcome)) = parsed else { continue };
                with(&batch, outcome)?;
                self.lock().spare_batches.push(batch);
                continue;
            }
            // The panic goes on where the threads are joined.
            if queue.is_broken || queue.parsed.is_empty() && queue.is_closed {
                return Ok(());
            }
            drop(queue);
            if !matches!(self.step(), Step::Parsed) {
                // Another thread parses the block that is next, or has closed the queue.
                let queue = self.lock();
                let waits = matches!(queue.parsed.front(), Some(None)) && !queue.is_broken;
                if waits {
                    drop(self.wait(queue));
                }
            }
        }
    }
}

/// Ends the wait for a block if the thread that parses it panics.
struct Alarm<'a, 'b, R: Read>(&'a Shared<'b, R>);

impl<R: Read> Drop for Alarm<'_, '_, R> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let mut queue = self.0.lock();
            (queue.is_broken, queue.is_closed) = (true, true);
            drop(queue);
            self.0.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_whole_lines() {
        let mut text = b"# begins\n".to_vec();
        while text.len() < 5 * BLOCK {
            let line = format!("v {} 1 2 \\\n 3\r\n", text.len());
            text.extend_from_slice(line.as_bytes());
        }
        text.extend_from_slice(b"f 1 2 3");
        let mut blocks = Blocks { reader: &text[..], rest: Vec::new(), count: 0, is_over: false };
        let (mut bytes, mut all) = (Vec::new(), Vec::new());
        while blocks.next(&mut bytes).expect("memory can be read") {
            all.extend_from_slice(&bytes);
            assert!(blocks.is_over || bytes.ends_with(b" 3\r\n"), "a whole logical line");
        }
        assert!(all == text && (5..=8).contains(&blocks.count), "all of it, in {} blocks", blocks.count);
        assert_eq!(last_end(b"a\nb\\\nc", 0), Some(2), "a backslash joins");
        assert_eq!(last_end(b"a\\\r\nc", 0), None, "in front of CR LF, too");
    }

    #[test]
    fn order_and_lines_do_not_depend_on_threads() {
        let mut text = String::new();
        for i in 0..60_000 {
            text += &format!("v {i} 0 0\n");
            text += ["", "# x\n\n", "vt 1 \\\n 2\n", "f 1 2 3 # odd\r\n", "vn 0 0 1\n"][i % 5];
        }
        text += "v 1 \u{1} 2\n";
        let read = |threads: usize| {
            let (mut seen, mut lines) = (Vec::new(), 0);
            let outcome = for_each(text.as_bytes(), Path::new("a.obj"), threads, |batch, outcome| {
                seen.extend(batch.runs().map(|(line, read)| (lines + line, read.to_string())));
                outcome.map_err(|error| Error { line: error.line.map(|line| line + lines), ..error })?;
                lines += batch.lines;
                Ok(())
            });
            (seen, outcome.expect_err("binary data at the end").line)
        };
        let one = read(1);
        let expected = text.lines().count() as u64;
        assert_eq!(one.1, Some(expected), "the last line");
        for threads in [2, 3, 8] {
            assert!(read(threads) == one, "{threads} threads");
        }
    }
}
