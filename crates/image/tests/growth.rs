// SPDX-License-Identifier: GPL-3.0-or-later
//! Cost of picture files: for any declarations at most 512 MiB and 64 times their length, and a few seconds.
//! Every allocation of the program is counted. One test only, so that nothing else is counted.

#![expect(clippy::print_stdout, reason = "a failing table tells the row that it was at")]

use std::io::Write;
use std::time::{Duration, Instant};

use gnurt_image::{Picture, PictureFormat, WriteOptions, decode, decode_data_texture, decode_texture};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATIONS: PeakAlloc = PeakAlloc;

const BELIEVED: u64 = 512 << 20;
const GROWTH: u64 = 64;
/// A few seconds where nothing else runs.
const LONGEST: Duration = Duration::from_secs(60);

/// Bytes of pixels up to which a picture is really made.
const REAL: u64 = 64 << 20;

fn deflate(bytes: impl Iterator<Item = Vec<u8>>) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::new(4));
    bytes.for_each(|bytes| encoder.write_all(&bytes).expect("memory takes all"));
    encoder.finish().expect("memory takes all")
}

fn chunk(name: &[u8; 4], bytes: &[u8]) -> Vec<u8> {
    let mut sum = flate2::Crc::new();
    sum.update(name);
    sum.update(bytes);
    [&(bytes.len() as u32).to_be_bytes()[..], name, bytes, &sum.sum().to_be_bytes()].concat()
}

/// A black PNG; `more` are further chunks.
fn png([width, height]: [u32; 2], depth: u8, color_type: u8, interlaced: bool, more: &[u8]) -> Vec<u8> {
    let channels = [1, 0, 3, 1, 2, 0, 4][usize::from(color_type)];
    let row = (width as usize * channels * usize::from(depth)).div_ceil(8) + 1;
    let head =
        [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, color_type, 0, 0, interlaced.into()]];
    // An interlaced picture has a few more bytes: each pass has rows of its own.
    let rows = if interlaced { height + height / 4 } else { height };
    let bytes = row as u64 * u64::from(rows);
    let data = if bytes <= REAL {
        deflate((0..rows).map(|_| vec![0; row]))
    } else {
        // As long as the best compression makes it, but nothing: it must not come to reading it.
        vec![0; (bytes / 1032 + 1) as usize]
    };
    let parts = [chunk(b"IHDR", &head.concat()), more.to_vec(), chunk(b"IDAT", &data), chunk(b"IEND", b"")];
    [&b"\x89PNG\r\n\x1a\n"[..], &parts.concat()].concat()
}

fn cases() -> Vec<(String, String, Vec<u8>)> {
    let mut cases = Vec::new();
    let mut case = |name: &str, extension: &str, bytes| {
        cases.push((name.to_owned(), format!("t.{extension}"), bytes));
    };
    let large = [1 << 14, 1 << 14];
    for (name, depth, color_type) in [("RGB, 16 bits", 16, 2), ("grey", 8, 0), ("one bit", 1, 0)] {
        case(name, "png", png(large, depth, color_type, false, b""));
    }
    let palette = [chunk(b"PLTE", &[1, 2, 3]), chunk(b"tRNS", &[9])].concat();
    case("palette", "png", png([1 << 13, 1 << 13], 1, 3, false, &palette));
    case("interlaced", "png", png([1 << 11, 1 << 11], 16, 6, true, b""));
    case("grey, 16 bits", "png", png([1 << 11, 1 << 11], 16, 0, false, b""));
    let zeros = [b"x\0\0".to_vec(), deflate((0..16).map(|_| vec![0; 1 << 24]))].concat();
    case("a profile of 256 MiB", "png", png([4, 4], 8, 2, false, &chunk(b"iCCP", &zeros)));
    case("a text of 256 MiB", "png", png([4, 4], 8, 2, false, &chunk(b"zTXt", &zeros)));
    let animation = [chunk(b"acTL", &[0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0])].concat();
    case("an animation", "png", png([64, 64], 8, 2, false, &animation));

    let picture = Picture::new(1 << 11, 1 << 11);
    for format in [PictureFormat::EXR, PictureFormat::HDR, PictureFormat::PFM] {
        let bytes = gnurt_image::encode(&picture, format, &WriteOptions::default()).expect("a picture");
        case("black", format.extension(), bytes);
    }
    drop(picture);
    let exr = |size: [u32; 2]| {
        let small = Picture::new(64, 64);
        let bytes =
            gnurt_image::encode(&small, PictureFormat::EXR, &WriteOptions::default()).expect("a picture");
        let windows = [63_u32, 63].map(u32::to_le_bytes).concat();
        let others = size.map(|side| (side - 1).to_le_bytes()).concat();
        let mut changed = bytes.clone();
        for at in 0..bytes.len() - 8 {
            if bytes[at..at + 8] == windows[..] {
                changed[at..at + 8].copy_from_slice(&others);
            }
        }
        changed
    };
    case("declared wide", "exr", exr([1 << 27, 2]));
    case("declared high", "exr", exr([2, 1 << 27]));
    case("declared large", "exr", exr([1 << 13, 1 << 13]));
    case("declared", "hdr", b"#?RADIANCE\n\n-Y 16384 +X 16384\n".to_vec());
    case("declared", "pfm", b"PF\n16384 16384\n-1.0\n".to_vec());
    let run = |count: usize| [0xff_u8, 1, 2, 3].repeat(count);
    let tga =
        [&[0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x10, 0, 0x10, 24, 0][..], &run((1 << 24) / 128)].concat();
    case("runs", "tga", tga);
    let mut bmp = vec![0; 1078];
    bmp[..2].copy_from_slice(b"BM");
    bmp[10..14].copy_from_slice(&1078_u32.to_le_bytes());
    bmp[14..18].copy_from_slice(&40_u32.to_le_bytes());
    bmp[18..22].copy_from_slice(&(1_u32 << 12).to_le_bytes());
    bmp[22..26].copy_from_slice(&(1_u32 << 12).to_le_bytes());
    bmp[26..30].copy_from_slice(&[1, 0, 8, 0]);
    bmp[30] = 1;
    bmp.extend([0xff_u8, 1].repeat((1 << 24) / 255));
    case("runs", "bmp", bmp);
    jpeg_cases().into_iter().for_each(|(name, bytes)| case(name, "jpg", bytes));
    webp_cases().into_iter().for_each(|(name, bytes)| case(name, "webp", bytes));
    let mut flat = std::io::Cursor::new(Vec::new());
    let picture = image::RgbImage::new(1 << 11, 1 << 11);
    picture.write_to(&mut flat, image::ImageFormat::WebP).expect("memory takes all");
    case("black", "webp", flat.into_inner());
    cases
}

/// Output bit by bit.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    used: usize,
}

impl Bits {
    /// Bits of `value`, the lowest first, each into the lowest free place of a byte, as WebP has them.
    fn lowest_first(&mut self, value: u32, count: usize) {
        (0..count).for_each(|i| self.bit(value >> i & 1, |bit_index| bit_index));
    }

    /// Bits of `value`, the highest first, each into the highest free place of a byte, as JPEG has them.
    fn highest_first(&mut self, value: u32, count: usize) {
        (0..count).rev().for_each(|i| self.bit(value >> i & 1, |bit_index| 7 - bit_index));
    }

    fn bit(&mut self, bit: u32, bit_index: impl Fn(usize) -> usize) {
        if self.used.is_multiple_of(8) {
            self.bytes.push(0);
        }
        *self.bytes.last_mut().expect("one was pushed") |= (bit as u8) << bit_index(self.used % 8);
        self.used += 1;
    }
}

/// A JPEG of a frame's kind, with scans of some channels and a spectrum: their data, without stuffed bytes.
fn jpeg(frame: u8, [width, height]: [u16; 2], channels: u8, scans: &[(&[u8], [u8; 2], Vec<u8>)]) -> Vec<u8> {
    let segment = |marker: u8, bytes: &[u8]| {
        let length = (bytes.len() as u16 + 2).to_be_bytes();
        [&[0xff, marker][..], &length, bytes].concat()
    };
    let mut file = vec![0xff, 0xd8];
    file.extend(segment(0xdb, &[&[0][..], &[1; 64]].concat()));
    let mut head = [&[8][..], &height.to_be_bytes(), &width.to_be_bytes(), &[channels]].concat();
    (1..=channels).for_each(|channel| head.extend([channel, 0x11, 0]));
    file.extend(segment(frame, &head));
    // One code of one bit each: no difference; the rest of a block, or of 16,384 blocks and more, is zero.
    let one = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let rest = if frame == 0xc2 { 0xe0 } else { 0 };
    file.extend(segment(0xc4, &[&[0][..], &one, &[0], &[0x10], &one, &[rest]].concat()));
    for (of, spectrum, data) in scans {
        let mut head = vec![of.len() as u8];
        of.iter().for_each(|&channel| head.extend([channel, 0]));
        head.extend([spectrum[0], spectrum[1], 0]);
        file.extend(segment(0xda, &head));
        data.iter().for_each(|&byte| file.extend(if byte == 0xff { vec![byte, 0] } else { vec![byte] }));
    }
    file.extend([0xff, 0xd9]);
    file
}

fn jpeg_cases() -> Vec<(&'static str, Vec<u8>)> {
    const BLOCKS: usize = (1 << 24) / 64;
    // All blocks without a difference, then each time nothing for all of them: 8 runs of nearly 32,768.
    let mut nothing = Bits::default();
    (0..BLOCKS.div_ceil(32_766)).for_each(|_| nothing.highest_first(0x3ffe, 15));
    let mut scans = vec![(&[1][..], [0, 0], vec![0; BLOCKS / 8])];
    scans.extend((0..200).map(|_| (&[1][..], [1, 63], nothing.bytes.clone())));
    // Two bits a block, in scans of one channel each, between which all channels are kept.
    let channels: [&[u8]; 4] = [&[1], &[2], &[3], &[4]];
    let apart = channels.map(|of| (of, [0, 63], vec![0; (1 << 26) / 64 / 4 + (1 << 17)]));
    vec![
        ("scans", jpeg(0xc2, [1 << 12, 1 << 12], 4, &scans)),
        ("channels apart", jpeg(0xc0, [1 << 13, 1 << 13], 4, &apart)),
        ("declared", jpeg(0xc2, [u16::MAX, u16::MAX], 3, &scans[..1])),
        ("declared narrow", jpeg(0xc2, [1, u16::MAX], 4, &scans[..1])),
    ]
}

fn riff(name: &[u8; 4], bytes: &[u8]) -> Vec<u8> {
    let padding = if bytes.len() % 2 == 1 { &[0][..] } else { &[] };
    [&name[..], &(bytes.len() as u32).to_le_bytes(), bytes, padding].concat()
}

fn webp(chunks: &[Vec<u8>]) -> Vec<u8> {
    riff(b"RIFF", &[&b"WEBP"[..], &chunks.concat()].concat())
}

fn vp8x(flags: u8, [width, height]: [u32; 2]) -> Vec<u8> {
    let [w, h] = [width - 1, height - 1].map(u32::to_le_bytes);
    riff(b"VP8X", &[&[flags, 0, 0, 0][..], &w[..3], &h[..3]].concat())
}

/// A lossy frame that only says how large it is.
fn lossy([width, height]: [u16; 2], length: usize) -> Vec<u8> {
    let size = [width, height].map(u16::to_le_bytes).concat();
    riff(b"VP8 ", &[&[0x10, 0, 0, 0x9d, 1, 0x2a][..], &size, &vec![0; length]].concat())
}

/// The codes of a lossless picture of 65,536 groups, in each of which each code makes a table of 4 KiB of 12 bytes.
fn many_codes() -> Vec<u8> {
    let mut bits = Bits::default();
    // No transform, no cache; groups, for squares of 4 pixels: one flat picture, whose pixels name the last group.
    [(0, 1), (0, 1), (1, 1), (0, 3), (0, 1)].into_iter().for_each(|(value, n)| bits.lowest_first(value, n));
    (0..2).for_each(|_| bits.lowest_first(0xff << 3 | 0b101, 11));
    (0..3).for_each(|_| bits.lowest_first(1, 4));
    for _ in 0..5 * 65_536 {
        bits.lowest_first(10 << 1, 5);
        for length in [0, 0, 0, 3, 3, 3, 3, 3, 0, 3, 4, 4, 4, 4] {
            bits.lowest_first(length, 3);
        }
        bits.lowest_first(9 << 4 | 1 << 1 | 1, 8);
        for length in [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 10_u32] {
            let (code, count) = if length < 7 { (length - 1, 3) } else { (length + 5, 4) };
            bits.lowest_first(code.reverse_bits() >> (32 - count), count);
        }
    }
    bits.bytes
}

fn lossless([width, height]: [u32; 2], codes: &[u8]) -> Vec<u8> {
    let size = (width - 1) | (height - 1) << 14;
    riff(b"VP8L", &[&[0x2f][..], &size.to_le_bytes(), codes].concat())
}

fn webp_cases() -> Vec<(&'static str, Vec<u8>)> {
    let codes = many_codes();
    let anim = riff(b"ANIM", &[0; 6]);
    let frame = |chunks: &[u8]| {
        riff(b"ANMF", &[&[0, 0, 0, 0, 0, 0, 3, 0, 0, 3, 0, 0, 0, 0, 0, 0][..], chunks].concat())
    };
    let alpha = riff(b"ALPH", &[&[1][..], &codes].concat());
    let small = frame(&lossless([4, 4], &[0; 20]));
    let animated = |frames: Vec<u8>| webp(&[vp8x(2, [4, 4]), anim.clone(), frames]);
    vec![
        ("codes", webp(&[lossless([4, 4], &codes)])),
        ("codes of opacity", webp(&[vp8x(0x10, [4, 4]), alpha.clone(), lossy([4, 4], 4000)])),
        ("codes of a frame", animated(frame(&lossless([4, 4], &codes)))),
        ("codes of a frame's opacity", animated(frame(&[alpha, lossy([4, 4], 4000)].concat()))),
        ("frames", animated(small.repeat(100_000))),
        ("chunks", webp(&[vp8x(0, [4, 4]), riff(b"JUNK", b"").repeat(1 << 20), lossless([4, 4], &[0; 20])])),
        ("declared", webp(&[lossless([1 << 14, 1 << 14], &[0; 1 << 16])])),
        ("declared lossy", webp(&[lossy([16_383; 2], 1 << 18)])),
        ("a large frame", webp(&[vp8x(0, [4, 4]), lossy([16_383; 2], 1 << 18)])),
    ]
}

type Read = fn(&[u8], &str) -> Result<(), gnurt_image::Error>;

#[test]
fn pictures_cost_what_their_lengths_account_for() {
    for (name, file, bytes) in cases() {
        let allowed = BELIEVED + GROWTH * bytes.len() as u64;
        let readers: [(&str, Read); 3] = [
            ("picture", |bytes, name| decode(bytes, name).map(drop)),
            ("texture", |bytes, name| decode_texture(bytes, name).map(drop)),
            ("data texture", |bytes, name| decode_data_texture(bytes, name).map(drop)),
        ];
        for (direction, read) in readers {
            let begin = Instant::now();
            ALLOCATIONS.reset_peak_usage();
            let before = ALLOCATIONS.current_usage();
            let said = read(&bytes, &file).map_or_else(|error| error.to_string(), |()| "read".into());
            let peak = (ALLOCATIONS.peak_usage() - before) as u64;
            let (mib, kib, time) = (peak >> 20, bytes.len() >> 10, begin.elapsed());
            println!("{file} {name} as a {direction}: {mib} MiB for {kib} KiB in {time:?}: {said}");
            assert!(peak <= allowed, "{file} {name} as a {direction}: {mib} MiB for {kib} KiB: {said}");
            assert!(time <= LONGEST, "{file} {name} as a {direction}: {time:?}");
        }
    }
}
