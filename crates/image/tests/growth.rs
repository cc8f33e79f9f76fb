// SPDX-License-Identifier: GPL-3.0-or-later
//! What picture files cost: whatever they declare, at most 512 MiB and 64 times their length, and only a few seconds.
//! Source: original; every allocation of the program is counted. One test only, so that nothing else is counted.

#![expect(clippy::print_stdout, reason = "a failing table tells the row that it was at")]

use std::io::Write;
use std::time::{Duration, Instant};

use gnurt_image::{OutputFormat, Picture, WriteOptions, decode, decode_data_texture, decode_texture};
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
    for format in [OutputFormat::Exr, OutputFormat::Hdr, OutputFormat::Pfm] {
        let bytes = gnurt_image::encode(&picture, format, &WriteOptions::default()).expect("a picture");
        case("black", format.extension(), bytes);
    }
    drop(picture);
    let exr = |size: [u32; 2]| {
        let small = Picture::new(64, 64);
        let bytes =
            gnurt_image::encode(&small, OutputFormat::Exr, &WriteOptions::default()).expect("a picture");
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
    cases
}

type Read = fn(&[u8], &str) -> Result<(), gnurt_image::Error>;

#[test]
fn pictures_cost_what_their_lengths_account_for() {
    for (name, file, bytes) in cases() {
        let allowed = BELIEVED + GROWTH * bytes.len() as u64;
        let ways: [(&str, Read); 3] = [
            ("picture", |bytes, name| decode(bytes, name).map(drop)),
            ("texture", |bytes, name| decode_texture(bytes, name).map(drop)),
            ("data texture", |bytes, name| decode_data_texture(bytes, name).map(drop)),
        ];
        for (way, read) in ways {
            let begin = Instant::now();
            ALLOCATIONS.reset_peak_usage();
            let before = ALLOCATIONS.current_usage();
            let said = read(&bytes, &file).map_or_else(|error| error.to_string(), |()| "read".into());
            let peak = (ALLOCATIONS.peak_usage() - before) as u64;
            let (mib, kib, time) = (peak >> 20, bytes.len() >> 10, begin.elapsed());
            println!("{file} {name} as a {way}: {mib} MiB for {kib} KiB in {time:?}: {said}");
            assert!(peak <= allowed, "{file} {name} as a {way}: {mib} MiB for {kib} KiB: {said}");
            assert!(time <= LONGEST, "{file} {name} as a {way}: {time:?}");
        }
    }
}
