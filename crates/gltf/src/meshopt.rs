// SPDX-License-Identifier: GPL-3.0-or-later
//! Buffer views compressed by meshoptimizer's codecs.
//! Source: EXT_meshopt_compression and KHR_meshopt_compression, appendices A (streams of versions 0 and 1) and
//! B (filters, in `meshopt_filters`). Three codecs: attributes by differences of bytes, triangles by recent
//! edges and vertices, indices by differences. Invariants: the output has the declared length before anything
//! is decoded; no stream reads beyond its end; every stream ends where its tail begins. Tests: `tests`,
//! `tests/extensions.rs::compressed_views_agree`.

use super::json::Meshopt;
use super::meshopt_filters::filter;

/// Elements of a group.
const GROUP: usize = 16;
/// Bytes of a block of attributes.
const BLOCK_BYTES: usize = 8192;
/// Elements of a block of attributes, at most.
const BLOCK: usize = 256;

/// The length of a view as it is declared; the error gives the fault.
pub(super) fn length(view: &Meshopt<'_>) -> Result<usize, String> {
    let stride = usize::try_from(view.byte_stride).unwrap_or(usize::MAX);
    let is_right = match &*view.mode {
        "ATTRIBUTES" => stride.is_multiple_of(4) && (4..=256).contains(&stride),
        "TRIANGLES" => [2, 4].contains(&stride) && view.count.is_multiple_of(3),
        "INDICES" => [2, 4].contains(&stride),
        other => return Err(format!("unknown mode {other}")),
    };
    if !is_right {
        return Err(format!("{} elements of {stride} bytes in mode {}", view.count, &*view.mode));
    }
    let count = usize::try_from(view.count).unwrap_or(usize::MAX);
    // A stream has a bit at least for each group; this also keeps the product small.
    let most = (view.byte_length as usize).saturating_mul(BLOCK * 16);
    match count.checked_mul(stride) {
        Some(length) if count <= most => Ok(length),
        _ => Err(format!("{count} elements in {} bytes", view.byte_length)),
    }
}

/// The bytes of a compressed view of [`length`] bytes.
pub(super) fn decode(view: &Meshopt<'_>, stream: &[u8]) -> Result<Vec<u8>, String> {
    let (count, stride) = (view.count as usize, view.byte_stride as usize);
    let mut out = vec![0; length(view)?];
    let done = match &*view.mode {
        "ATTRIBUTES" => attributes(stream, count, stride, &mut out),
        "TRIANGLES" => triangles(stream, count / 3, stride, &mut out),
        _ => indices(stream, count, stride, &mut out),
    };
    done.ok_or("its stream is broken")?;
    match view.filter.as_deref().unwrap_or("NONE") {
        "NONE" => {}
        _ if *view.mode != *"ATTRIBUTES" => return Err("a filter of indices".to_owned()),
        name => filter(name, stride, &mut out)?,
    }
    Ok(out)
}

/// A stream and the position in it.
struct Bytes<'a> {
    left: &'a [u8],
}

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, tail) = self.left.split_at_checked(count)?;
        self.left = tail;
        Some(head)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// A number in groups of seven bits, the lowest first.
    fn number(&mut self) -> Option<u32> {
        let mut value = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                return Some(value);
            }
        }
        None
    }
}

/// A signed difference that was stored with its sign in the lowest bit.
fn signed(value: u32) -> u32 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}

fn attributes(stream: &[u8], count: usize, stride: usize, out: &mut [u8]) -> Option<()> {
    let (&header, body) = stream.split_first()?;
    let is_second = match header {
        0xa0 => false,
        0xa1 => true,
        _ => return None,
    };
    let modes_length = if is_second { stride / 4 } else { 0 };
    let tail_length = (stride + modes_length).max(if is_second { 24 } else { 32 });
    let (body, tail) = body.split_at_checked(body.len().checked_sub(tail_length)?)?;
    let tail = &tail[tail_length - stride - modes_length..];
    let (baseline, modes) = tail.split_at(stride);
    let mut from = Bytes { left: body };
    let mut last = baseline.to_vec();
    let most = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(BLOCK);
    // Differences of a block, byte by byte of the element.
    let mut deltas = vec![0_u8; stride * most];
    for first in (0..count).step_by(most) {
        let size = most.min(count - first);
        let groups = size.div_ceil(GROUP);
        let controls = from.take(modes_length)?;
        for k in 0..stride {
            let to = &mut deltas[k * most..][..groups * GROUP];
            let control = if is_second { controls[k / 4] >> (2 * (k % 4)) & 3 } else { 4 };
            column(&mut from, control, size, to)?;
        }
        for (channel, bytes) in (0..stride).step_by(4).enumerate() {
            let mode = modes.get(channel).copied().unwrap_or(0);
            if mode & 15 > 2 || (mode & 15 < 2 && mode >> 4 != 0) {
                return None;
            }
            let mut value: [u8; 4] = last[bytes..bytes + 4].try_into().ok()?;
            for i in 0..size {
                let delta = [0, 1, 2, 3].map(|k| deltas[(bytes + k) * most + i]);
                value = undo(mode, value, delta);
                out[(first + i) * stride + bytes..][..4].copy_from_slice(&value);
            }
            last[bytes..bytes + 4].copy_from_slice(&value);
        }
    }
    from.left.is_empty().then_some(())
}

/// Four bytes behind those of the element before, by the mode of their channel.
fn undo(mode: u8, before: [u8; 4], delta: [u8; 4]) -> [u8; 4] {
    match mode & 15 {
        0 => std::array::from_fn(|k| {
            let delta = (delta[k] >> 1) ^ (delta[k] & 1).wrapping_neg();
            before[k].wrapping_add(delta)
        }),
        1 => {
            let pair = |k: usize, of: [u8; 4]| u16::from_le_bytes([of[2 * k], of[2 * k + 1]]);
            let [low, high] = [0, 1].map(|k| {
                let delta = pair(k, delta);
                let delta = (delta >> 1) ^ (delta & 1).wrapping_neg();
                pair(k, before).wrapping_add(delta).to_le_bytes()
            });
            [low[0], low[1], high[0], high[1]]
        }
        _ => {
            let delta = u32::from_le_bytes(delta).rotate_left(u32::from(mode >> 4));
            (u32::from_le_bytes(before) ^ delta).to_le_bytes()
        }
    }
}

/// The differences of one byte of all elements of a block: `to` has whole groups. `control` 4 is that of the
/// first version.
fn column(from: &mut Bytes<'_>, control: u8, size: usize, to: &mut [u8]) -> Option<()> {
    let widths: [u32; 4] = match control {
        0 => [0, 1, 2, 4],
        1 => [1, 2, 4, 8],
        2 => {
            to.fill(0);
            return Some(());
        }
        3 => {
            to[..size].copy_from_slice(from.take(size)?);
            return Some(());
        }
        _ => [0, 2, 4, 8],
    };
    let header = from.take((to.len() / GROUP).div_ceil(4))?;
    for (k, group) in to.chunks_exact_mut(GROUP).enumerate() {
        match widths[usize::from(header[k / 4] >> (2 * (k % 4)) & 3)] {
            0 => group.fill(0),
            8 => group.copy_from_slice(from.take(GROUP)?),
            width => sentinels(from, width, group)?,
        }
    }
    Some(())
}

/// A group of narrow numbers; one with all bits set stands for a byte behind them.
fn sentinels(from: &mut Bytes<'_>, width: u32, group: &mut [u8]) -> Option<()> {
    let packed = from.take(GROUP * width as usize / 8)?;
    let in_byte = 8 / width as usize;
    let largest = (1_u8 << width) - 1;
    for (i, to) in group.iter_mut().enumerate() {
        let place = (i % in_byte) as u32;
        // Single bits begin with the lowest one, others with the highest.
        let shift = if width == 1 { place } else { 8 - width * (place + 1) };
        let value = packed[i / in_byte] >> shift & largest;
        *to = if value == largest { from.byte()? } else { value };
    }
    Some(())
}

/// Writes an index of two or four bytes.
fn put(out: &mut [u8], stride: usize, i: usize, index: u32) {
    out[i * stride..][..stride].copy_from_slice(&index.to_le_bytes()[..stride]);
}

fn indices(stream: &[u8], count: usize, stride: usize, out: &mut [u8]) -> Option<()> {
    let body = stream.strip_prefix(&[0xd1])?;
    let mut from = Bytes { left: &body[..body.len().checked_sub(4)?] };
    let mut last = [0_u32; 2];
    for i in 0..count {
        let value = from.number()?;
        let base = &mut last[(value & 1) as usize];
        *base = base.wrapping_add(signed(value >> 1));
        put(out, stride, i, *base);
    }
    from.left.is_empty().then_some(())
}

/// The last sixteen of a kind.
struct Recent<T> {
    list: [Option<T>; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new() -> Self {
        Self { list: [None; 16], next: 0 }
    }

    fn push(&mut self, value: T) {
        self.list[self.next] = Some(value);
        self.next = (self.next + 1) % 16;
    }

    /// The one `back` before the last.
    fn get(&self, back: u8) -> Option<T> {
        self.list[(self.next + 15 - usize::from(back)) % 16]
    }
}

/// The state of the codec of triangles.
struct Corners<'a> {
    data: Bytes<'a>,
    next: u32,
    last: u32,
    edges: Recent<[u32; 2]>,
    vertices: Recent<u32>,
}

impl Corners<'_> {
    fn fresh(&mut self) -> u32 {
        self.next = self.next.wrapping_add(1);
        self.next.wrapping_sub(1)
    }

    fn explicit(&mut self) -> Option<u32> {
        self.last = self.last.wrapping_add(signed(self.data.number()?));
        Some(self.last)
    }

    /// A corner by four bits, and whether it is new to the list of vertices.
    fn by_nibble(&mut self, nibble: u8, may_be_explicit: bool) -> Option<(u32, bool)> {
        Some(match nibble {
            0 => (self.fresh(), true),
            15 if may_be_explicit => (self.explicit()?, true),
            _ => (self.vertices.get(nibble - 1)?, false),
        })
    }

    /// A triangle at a recent edge.
    fn at_edge(&mut self, code: u8) -> Option<[u32; 3]> {
        let [a, b] = self.edges.get(code >> 4)?;
        let (c, is_new) = match code & 15 {
            0 => (self.fresh(), true),
            13 => (self.last.wrapping_sub(1), true),
            14 => (self.last.wrapping_add(1), true),
            15 => (self.explicit()?, true),
            back => (self.vertices.get(back)?, false),
        };
        if matches!(code & 15, 13 | 14) {
            self.last = c;
        }
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if is_new {
            self.vertices.push(c);
        }
        Some([a, b, c])
    }

    /// A triangle of its own.
    fn alone(&mut self, code: u8, table: &[u8]) -> Option<[u32; 3]> {
        let is_explicit = code >= 0xfe;
        let corners = if is_explicit { self.data.byte()? } else { table[usize::from(code & 15)] };
        if is_explicit && corners == 0 {
            self.next = 0;
        }
        let a = if code == 0xff { self.explicit()? } else { self.fresh() };
        let (b, b_is_new) = self.by_nibble(corners >> 4, is_explicit)?;
        let (c, c_is_new) = self.by_nibble(corners & 15, is_explicit)?;
        [[b, a], [c, b], [a, c]].into_iter().for_each(|edge| self.edges.push(edge));
        let new = [(a, true), (b, b_is_new), (c, c_is_new)];
        new.into_iter().filter(|(_, is_new)| *is_new).for_each(|(vertex, _)| self.vertices.push(vertex));
        Some([a, b, c])
    }
}

fn triangles(stream: &[u8], count: usize, stride: usize, out: &mut [u8]) -> Option<()> {
    let body = stream.strip_prefix(&[0xe1])?;
    let (body, table) = body.split_at_checked(body.len().checked_sub(16)?)?;
    let (codes, data) = body.split_at_checked(count)?;
    if table.iter().any(|byte| byte >> 4 == 15 || byte & 15 == 15) || table[14..] != [0, 0] {
        return None;
    }
    let mut state = Corners {
        data: Bytes { left: data },
        next: 0,
        last: 0,
        edges: Recent::new(),
        vertices: Recent::new(),
    };
    for (i, &code) in codes.iter().enumerate() {
        let triangle = if code < 0xf0 { state.at_edge(code)? } else { state.alone(code, table)? };
        triangle.into_iter().enumerate().for_each(|(k, index)| put(out, stride, 3 * i + k, index));
    }
    state.data.left.is_empty().then_some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_examples_of_the_specification_are_read() {
        let mut group = [0; GROUP];
        let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
        let mut from = Bytes { left: &packed };
        sentinels(&mut from, 4, &mut group).expect("a group");
        let deltas = group.map(|byte| undo(0, [0; 4], [byte, 0, 0, 0])[0] as i8);
        assert_eq!(deltas, [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0], "differences");
        assert!(from.left.is_empty(), "all of it");
        assert_eq!(Bytes { left: &[0x81, 0x04] }.number(), Some(0x201), "two groups of seven bits");
        assert_eq!(Bytes { left: &[0x80; 6] }.number(), None, "no end");
    }

    /// A stream of the file of streams, decoded.
    fn decoded(name: &str, count: usize, stride: usize, mode: &str, filter: &str) -> Vec<u8> {
        let streams = include_str!("../tests/data/meshopt.txt");
        let line =
            streams.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')).expect("a stream");
        let byte = |pair: &[u8]| {
            u8::from_str_radix(std::str::from_utf8(pair).expect("digits"), 16).expect("two digits")
        };
        let stream: Vec<u8> = line.as_bytes().chunks(2).map(byte).collect();
        let json = format!(
            r#"{{"buffer":0,"byteLength":{},"byteStride":{stride},"count":{count},"mode":"{mode}","filter":"{filter}"}}"#,
            stream.len()
        );
        let view: Meshopt<'_> = serde_json::from_str(&json).expect("a view");
        for cut in 0..stream.len() {
            assert!(decode(&view, &stream[..cut]).is_err(), "{name} cut off at {cut}");
        }
        decode(&view, &stream).unwrap_or_else(|why| panic!("{name}: {why}"))
    }

    fn floats(bytes: &[u8]) -> Vec<f32> {
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    /// A grid of 9 x 9 points.
    fn grid() -> impl Iterator<Item = (u32, u32)> {
        (0..81).map(|v| (v % 9, v / 9))
    }

    #[test]
    fn streams_of_both_versions_are_read() {
        let points: Vec<f32> = grid()
            .flat_map(|(i, j)| [i as f32 / 8.0 - 0.5, j as f32 / 8.0 - 0.5, (i * j % 5) as f32 / 64.0])
            .collect();
        for (name, version) in [("p0", 0), ("p1", 1)] {
            let found = floats(&decoded(name, 81, 12, "ATTRIBUTES", "NONE"));
            assert_eq!(found, points, "positions of version {version}");
        }
        let corners: Vec<u16> = (0..64)
            .flat_map(|k| {
                let a = k / 8 * 9 + k % 8;
                [a, a + 1, a + 10, a, a + 10, a + 9]
            })
            .collect();
        let numbers = |bytes: Vec<u8>| -> Vec<u16> {
            bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()
        };
        assert_eq!(numbers(decoded("i", 384, 2, "INDICES", "NONE")), corners, "indices");
        let triangles = numbers(decoded("t", 384, 2, "TRIANGLES", "NONE"));
        // The codec may begin a triangle at another corner.
        for (found, expected) in triangles.chunks(3).zip(corners.chunks(3)) {
            let turns = (0..3).map(|k| [0, 1, 2].map(|c| expected[(c + k) % 3]));
            assert!(turns.into_iter().any(|turned| found == turned), "{found:?}, {expected:?}");
        }
        let words = decoded("w", 300, 4, "ATTRIBUTES", "NONE");
        let mut seed = 7_u32;
        for (k, word) in (0..).zip(words.chunks_exact(4)) {
            seed = seed.wrapping_mul(1_103_515_245).wrapping_add(12345);
            let found = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
            assert!(found.wrapping_sub(k * 70000) < 16, "word {k}: {found}");
        }
        for (k, found) in floats(&decoded("f", 400, 4, "ATTRIBUTES", "NONE")).into_iter().enumerate() {
            let expected = (k as f32 / 20.0).sin() * 100.0;
            assert!((found - expected).abs() < 1e-3, "float {k}: {found}, {expected}");
        }
    }

    #[test]
    fn filtered_streams_are_read() {
        let normals: Vec<[f32; 3]> = grid()
            .map(|(i, j)| {
                let [x, y] = [i, j].map(|n| (n as f32 - 4.0) / 8.0);
                let length = (x * x + y * y + 1.0).sqrt();
                [x / length, y / length, 1.0 / length]
            })
            .collect();
        let narrow = decoded("n0", 81, 4, "ATTRIBUTES", "OCTAHEDRAL");
        let wide = decoded("n1", 81, 8, "ATTRIBUTES", "OCTAHEDRAL");
        for (v, normal) in normals.iter().enumerate() {
            for (k, expected) in normal.iter().enumerate() {
                let byte = f32::from(narrow[4 * v + k] as i8) / 127.0;
                let word = [wide[8 * v + 2 * k], wide[8 * v + 2 * k + 1]];
                let word = f32::from(i16::from_le_bytes(word)) / 32767.0;
                assert!((byte - expected).abs() < 0.02, "normal {v}: {byte}, {expected}");
                assert!((word - expected).abs() < 0.002, "normal {v}: {word}, {expected}");
            }
        }
        let points = floats(&decoded("e", 81, 12, "ATTRIBUTES", "EXPONENTIAL"));
        for (v, (i, j)) in grid().enumerate() {
            let expected = [i as f32 / 8.0 - 0.5, j as f32 / 8.0 - 0.5, (i * j % 5) as f32 / 64.0];
            let found = &points[3 * v..][..3];
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-4), "{found:?}, {expected:?}");
        }
        let turns = decoded("q", 16, 8, "ATTRIBUTES", "QUATERNION");
        for (k, turn) in turns.chunks_exact(8).enumerate() {
            let x = k as f32;
            let expected = [x.sin(), (2.0 * x).cos(), 0.3 * x, 1.0 - x / 9.0];
            let length = expected.iter().map(|x| x * x).sum::<f32>().sqrt();
            let found =
                [0, 1, 2, 3].map(|c| f32::from(i16::from_le_bytes([turn[2 * c], turn[2 * c + 1]])) / 32767.0);
            let cosine: f32 = (0..4).map(|c| found[c] * expected[c] / length).sum();
            assert!(cosine.abs() > 0.999, "rotation {k}: {found:?}, {expected:?}");
        }
        let colors = decoded("c", 16, 4, "ATTRIBUTES", "COLOR");
        for (k, found) in colors.chunks_exact(4).enumerate() {
            let x = k as f32;
            let expected = [x / 15.0, 1.0 - x / 15.0, (k % 4) as f32 / 3.0, 0.5 + x / 30.0];
            let close = |c: usize| (f32::from(found[c]) / 255.0 - expected[c]).abs() < 0.015;
            assert!((0..4).all(close), "colour {k}: {found:?}, {expected:?}");
        }
    }

    #[test]
    fn broken_streams_are_refused() {
        let mut out = [0; 64];
        let streams: [&[u8]; 6] = [&[], &[0xa0], &[0xa0; 40], &[0xa1; 40], &[0xe1; 40], &[0xd1; 40]];
        for stream in streams {
            let refused = [
                attributes(stream, 16, 4, &mut out),
                triangles(stream, 4, 4, &mut out),
                indices(stream, 16, 4, &mut out),
            ];
            assert_eq!(refused, [None; 3], "{stream:?}");
        }
    }
}
