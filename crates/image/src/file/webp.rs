// SPDX-License-Identifier: GPL-3.0-or-later
//! WebP: its chunks are traversed before it is decoded, to check their presence, the size of frames, and the
//! memory of lossless codes' tables, which a decoder makes as a file requests them. From RFC 9649, section 2.
//! Invariant: every part that the decoder reads is checked here. Tests: `tests/{broken,growth}.rs`.

use std::io::SeekFrom;

use super::source::Source;
use super::vp8l;
use crate::{Budget, Error};

/// Sizes of the head of a file, of a chunk, and of a frame of an animation.
const HEAD: u64 = 12;
const CHUNK_HEAD: u64 = 8;
const FRAME_HEAD: u64 = 16;

/// A chunk, and where its contents begin.
#[derive(Clone, Copy)]
struct Chunk {
    name: [u8; 4],
    begin: u64,
    length: u64,
}

impl Chunk {
    /// Chunks have even lengths.
    fn next(self) -> u64 {
        self.begin + self.length + self.length % 2
    }
}

/// Checks the lengths and sizes that a file declares; returns the memory of its codes' tables, in bytes.
pub(super) fn check(source: &mut dyn Source, length: u64, budget: &Budget) -> Result<u64, Error> {
    let head: [u8; HEAD as usize] = read(source, 0)?.ok_or_else(|| truncated(length, HEAD))?;
    let declared = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]])) + CHUNK_HEAD;
    if declared > length {
        // The decoder takes some truncated files for whole ones.
        return Err(truncated(length, declared));
    }
    let mut walk = Walk { source, size: None, budget, tables: 0 };
    walk.file(length)?;
    let tables = walk.tables;
    source.seek(SeekFrom::Start(0)).map_err(Error::reading)?;
    Ok(tables)
}

fn truncated(length: u64, declared: u64) -> Error {
    Error::corrupt("WebP", format!("{length} of {declared} bytes are there; it is truncated"))
}

struct Walk<'a> {
    source: &'a mut dyn Source,
    /// Of the picture or the frame.
    size: Option<[u32; 2]>,
    budget: &'a Budget,
    /// The largest tables of any part, in bytes.
    tables: u64,
}

impl Walk<'_> {
    /// The chunks of a file. A decoder takes the first one of each kind.
    fn file(&mut self, length: u64) -> Result<(), Error> {
        let [mut has_frame, mut has_codes, mut has_alpha] = [false; 3];
        let mut at = HEAD;
        while let Some(chunk) = self.chunk(at, length)? {
            at = chunk.next();
            match &chunk.name {
                b"VP8X" if chunk.begin == HEAD + CHUNK_HEAD => {
                    let Some([_, _, _, _, size @ ..]) = read::<10>(self.source, chunk.begin)? else { break };
                    self.size = Some(three_bytes(size));
                }
                b"VP8 " => self.lossy(chunk)?,
                b"VP8L" if !has_codes => {
                    has_codes = true;
                    self.lossless(chunk)?;
                }
                b"ALPH" if !has_alpha => {
                    has_alpha = true;
                    self.opacity(chunk)?;
                }
                b"ANMF" if !has_frame => {
                    has_frame = true;
                    self.frame(chunk, length)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The first frame of an animation: its opacity, if it has one, and its colours.
    fn frame(&mut self, frame: Chunk, length: u64) -> Result<(), Error> {
        let Some([_, _, _, _, _, _, size @ ..]) = read::<12>(self.source, frame.begin)? else {
            return Ok(());
        };
        let canvas = self.size.replace(three_bytes(size));
        let mut at = frame.begin + FRAME_HEAD;
        for _ in 0..2 {
            let Some(chunk) = self.chunk(at, length)? else { break };
            match &chunk.name {
                b"VP8 " => self.lossy(chunk)?,
                b"VP8L" => self.lossless(chunk)?,
                b"ALPH" => self.opacity(chunk)?,
                _ => {}
            }
            at = chunk.next();
        }
        self.size = canvas;
        Ok(())
    }

    /// A decoder makes a frame of the size in the frame's header before it reads the picture's.
    fn lossy(&mut self, chunk: Chunk) -> Result<(), Error> {
        let Some([.., w0, w1, h0, h1]) = read::<10>(self.source, chunk.begin)? else { return Ok(()) };
        let side = |low, high| u32::from(u16::from_le_bytes([low, high]) & 0x3fff);
        let (frame, size) = ([side(w0, w1), side(h0, h1)], self.size);
        let Some(size) = size.filter(|size| frame[0] > size[0] || frame[1] > size[1]) else { return Ok(()) };
        let [[fw, fh], [w, h]] = [frame, size];
        Err(Error::corrupt(
            "WebP",
            format!("a frame of {fw} x {fh} pixels is larger than its picture, {w} x {h}"),
        ))
    }

    fn lossless(&mut self, chunk: Chunk) -> Result<(), Error> {
        let Some([_, size @ ..]) = read::<5>(self.source, chunk.begin)? else { return Ok(()) };
        let packed = u32::from_le_bytes(size);
        let size = [packed, packed >> 14].map(|side| (side & 0x3fff) + 1);
        self.codes(chunk.begin + 5, chunk.length.saturating_sub(5), size)
    }

    fn opacity(&mut self, chunk: Chunk) -> Result<(), Error> {
        let Some([info]) = read::<1>(self.source, chunk.begin)? else { return Ok(()) };
        match (info & 3, self.size) {
            (1, Some(size)) => self.codes(chunk.begin + 1, chunk.length.saturating_sub(1), size),
            _ => Ok(()),
        }
    }

    fn codes(&mut self, begin: u64, length: u64, size: [u32; 2]) -> Result<(), Error> {
        self.source.seek(SeekFrom::Start(begin)).map_err(Error::reading)?;
        let tables =
            vp8l::table_bytes(self.source, length, size, self.budget.left()).map_err(Error::reading)?;
        self.tables = self.tables.max(tables);
        self.budget.check_bytes(size.map(u64::from), tables)
    }

    fn chunk(&mut self, at: u64, length: u64) -> Result<Option<Chunk>, Error> {
        if at >= length {
            return Ok(None);
        }
        let head: Option<[u8; CHUNK_HEAD as usize]> = read(self.source, at)?;
        Ok(head.map(|[n0, n1, n2, n3, l0, l1, l2, l3]| Chunk {
            name: [n0, n1, n2, n3],
            begin: at + CHUNK_HEAD,
            length: u32::from_le_bytes([l0, l1, l2, l3]).into(),
        }))
    }
}

/// Columns and rows, each written as one less in three bytes.
fn three_bytes([w0, w1, w2, h0, h1, h2]: [u8; 6]) -> [u32; 2] {
    [[w0, w1, w2, 0], [h0, h1, h2, 0]].map(|bytes| u32::from_le_bytes(bytes) + 1)
}

/// Bytes at an offset; `None` if the file ends before.
fn read<const N: usize>(source: &mut dyn Source, at: u64) -> Result<Option<[u8; N]>, Error> {
    let mut bytes = [0; N];
    source.seek(SeekFrom::Start(at)).map_err(Error::reading)?;
    match source.read_exact(&mut bytes) {
        Ok(()) => Ok(Some(bytes)),
        Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(Error::reading(error)),
    }
}
