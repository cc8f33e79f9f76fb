// SPDX-License-Identifier: GPL-3.0-or-later
//! Unpacks the output of the library Blosc, version 1, with LZ4 or zlib, as OpenVDB uses it by default.
//! Source: the chunk format of c-blosc (README_CHUNK_FORMAT.rst); original code. A chunk is a head of 16
//! bytes, the starts of its blocks, and the blocks, each of one or more packed streams, whose bytes may be
//! sorted by their position in a number.
//! Tests: `tests/volumes.rs`.

use super::bytes::{Bytes, corrupt};
use crate::Error;

/// Blocks shorter than this, over the size of a number, are one stream.
const SHORTEST_SPLIT: usize = 128;
/// Numbers of more bytes are not parted.
const WIDEST_SPLIT: usize = 16;

/// The `length` bytes of a chunk.
pub(super) fn unpack(chunk: &[u8], length: usize) -> Result<Vec<u8>, Error> {
    let mut bytes = Bytes::new(chunk);
    let [_, _, flags, width] = bytes.array()?;
    let [unpacked, block, _] = [bytes.u32()?, bytes.u32()?, bytes.u32()?].map(|n| n as usize);
    if unpacked != length {
        return Err(corrupt(format!("a block holds {unpacked} bytes in place of {length}")));
    }
    if flags & 2 != 0 {
        return Ok(bytes.take(length)?.to_vec());
    }
    if flags & 4 != 0 {
        return Err(corrupt("its blocks are sorted by bits, which is not read"));
    }
    if block == 0 && length > 0 {
        return Err(corrupt("a block of no bytes"));
    }
    let starts: Vec<i32> =
        (0..length.div_ceil(block.max(1))).map(|_| bytes.i32()).collect::<Result<_, _>>()?;
    let width = usize::from(width).max(1);
    let mut out = vec![0; length];
    for (out, start) in out.chunks_mut(block.max(1)).zip(starts) {
        bytes.seek(i64::from(start))?;
        let splits = flags & 16 == 0
            && width <= WIDEST_SPLIT
            && block / width >= SHORTEST_SPLIT
            && out.len() == block
            && block.is_multiple_of(width);
        let stream = if splits { block / width } else { out.len() };
        for part in out.chunks_mut(stream.max(1)) {
            let packed =
                usize::try_from(bytes.i32()?).map_err(|_| corrupt("a stream of fewer than 0 bytes"))?;
            let packed = bytes.take(packed)?;
            if packed.len() == part.len() {
                part.copy_from_slice(packed);
            } else {
                stream_of(flags >> 5, packed, part)?;
            }
        }
        if flags & 1 != 0 && width > 1 {
            unsort(out, width);
        }
    }
    Ok(out)
}

/// Unpacks a stream that fills `out`.
fn stream_of(format: u8, packed: &[u8], out: &mut [u8]) -> Result<(), Error> {
    match format {
        1 => {
            let filled = lz4_flex::block::decompress_into(packed, out).ok();
            if filled == Some(out.len()) { Ok(()) } else { Err(corrupt("broken LZ4 data")) }
        }
        3 => inflate(packed, out),
        _ => Err(corrupt(format!("unsupported Blosc format {format}; LZ4 and zlib are supported"))),
    }
}

/// Unpacks zlib's data that fill `out`.
pub(super) fn inflate(packed: &[u8], out: &mut [u8]) -> Result<(), Error> {
    let mut reader = flate2::read::ZlibDecoder::new(packed);
    std::io::Read::read_exact(&mut reader, out).map_err(|_| corrupt("broken zlib data"))
}

/// Brings the bytes of numbers together: the first bytes of all come first, then the second ones.
fn unsort(bytes: &mut [u8], width: usize) {
    let sorted = bytes.to_vec();
    let count = bytes.len() / width;
    for (i, number) in bytes.chunks_exact_mut(width).enumerate() {
        for (k, byte) in number.iter_mut().enumerate() {
            *byte = sorted[k * count + i];
        }
    }
}
