// SPDX-License-Identifier: GPL-3.0-or-later
//! Radiance HDR: three mantissas and a shared exponent (RGBE), run-length encoded by component.
//! Source: [War91] for the pixel, Radiance's reference manual for the file. In and out: linear light, colour only.
//! Written with `-Y height +X width`, runs from width 8 to 32767 on; read in that orientation, both run encodings.
//! Invariants: a value is off by at most 1/256 of the pixel's largest; NaN and negative values become 0, too large ones
//! the largest. Tests: `tests` here, `tests/{round_trip,broken}.rs`.

use std::io::{BufRead, Read};

use super::format::{PictureFormat, Readers, Signature};
use super::limits::{PICTURE_BYTES, check_density};
use super::source::Source;
use crate::{Budget, Error, Picture};

/// Widths that may be run-length encoded by component.
const RUN_WIDTHS: std::ops::Range<usize> = 8..0x8000;
const MAX_HEADER_BYTES: u64 = 1 << 16;
/// Pixels that a byte holds at most: runs of 127 take eight bytes; the older runs of 255 pixels take four.
const PIXELS_PER_BYTE: u64 = 64;
/// The largest value that a pixel holds.
const LARGEST: f32 = 1.7e38;

/// The format.
pub(super) const FORMAT: PictureFormat = PictureFormat {
    name: "HDR",
    extensions: &["hdr"],
    notes: "RGBE; linear radiance",
    is_for_screens: false,
    has_opacity: false,
    has_layers: false,
    is_whole: true,
    signature: Signature::Head(|head| head.starts_with(b"#?R")),
    read: Readers {
        picture: |source, length, budget, _| decode(source, length, budget),
        texels: None,
        stored: None,
    },
    write: Some(|picture, _, _| Ok(encode(picture))),
    bands: None,
};

fn encode(picture: &Picture) -> Vec<u8> {
    let (width, height) = (picture.width as usize, picture.height);
    let header = format!(
        "#?RADIANCE\nSOFTWARE={}\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n",
        crate::SOFTWARE
    );
    let mut bytes = header.into_bytes();
    for row in picture.color.chunks_exact(width) {
        let pixels: Vec<[u8; 4]> = row.iter().map(|&[r, g, b, _]| rgbe([r, g, b])).collect();
        if RUN_WIDTHS.contains(&width) {
            bytes.extend_from_slice(&[2, 2, (width >> 8) as u8, width as u8]);
            for component in 0..4 {
                let values: Vec<u8> = pixels.iter().map(|pixel| pixel[component]).collect();
                encode_runs(&values, &mut bytes);
            }
        } else {
            bytes.extend(pixels.iter().flatten());
        }
    }
    bytes
}

/// Three mantissas of 8 bits and the exponent, biased by 128, of the largest.
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    // `clamp` keeps a NaN; `max` returns the other number.
    let rgb = rgb.map(|value| value.clamp(0.0, LARGEST).max(0.0));
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    if largest < 1e-32 {
        return [0; 4];
    }
    // largest = m * 2^exponent with m in 0.5..1; the bits of a normal float hold the exponent + 126.
    let exponent = (largest.to_bits() >> 23) as i32 - 126;
    let scale = (8.0 - f64::from(exponent)).exp2();
    // Rounded; just below the next power of two `as` saturates to 255, no farther off.
    let [r, g, b] = rgb.map(|value| (f64::from(value) * scale + 0.5) as u8);
    [r, g, b, (exponent + 128) as u8]
}

fn rgb([r, g, b, exponent]: [u8; 4]) -> [f32; 3] {
    if exponent == 0 {
        return [0.0; 3];
    }
    let scale = (f64::from(exponent) - 136.0).exp2();
    [r, g, b].map(|mantissa| (f64::from(mantissa) * scale) as f32)
}

/// Runs of at least 4 as (128 + length, value); the rest as (length, values).
fn encode_runs(values: &[u8], bytes: &mut Vec<u8>) {
    let run_at =
        |start: usize| values[start..].iter().take(127).take_while(|&&value| value == values[start]).count();
    let mut at = 0;
    while at < values.len() {
        let run = run_at(at);
        if run >= 4 {
            bytes.extend_from_slice(&[128 + run as u8, values[at]]);
            at += run;
        } else {
            let literal = (at..values.len().min(at + 128)).find(|&next| run_at(next) >= 4);
            let end = literal.unwrap_or(values.len().min(at + 128));
            bytes.push((end - at) as u8);
            bytes.extend_from_slice(&values[at..end]);
            at = end;
        }
    }
}

fn decode(source: &mut dyn Source, length: u64, budget: &Budget) -> Result<Picture, Error> {
    let header = read_header(source)?;
    let size = [u64::from(header.width), u64::from(header.height)];
    check_density("HDR", size, length, PIXELS_PER_BYTE)?;
    budget.check("HDR", size, PICTURE_BYTES)?;
    let width = header.width as usize;
    let mut picture = Picture { width: header.width, height: header.height, ..Picture::default() };
    picture.color.reserve_exact(picture.pixel_count());
    let mut row = vec![[0; 4]; width];
    for _ in 0..header.height {
        read_row(source, &mut row)?;
        picture.color.extend(row.iter().map(|&pixel| {
            let values = rgb(pixel);
            let [r, g, b] = std::array::from_fn(|k| values[k] / header.exposure[k]);
            [r, g, b, 1.0]
        }));
    }
    Ok(picture)
}

struct Header {
    width: u32,
    height: u32,
    /// The factors of each channel's values.
    exposure: [f32; 3],
}

fn read_header(source: &mut dyn Source) -> Result<Header, Error> {
    let mut exposure = [1.0; 3];
    let mut rest = MAX_HEADER_BYTES;
    loop {
        let line = read_line(source, &mut rest)?;
        if line.is_empty() {
            break;
        }
        let Some((name, value)) = line.split_once('=') else { continue };
        match name {
            "FORMAT" if value.trim() != "32-bit_rle_rgbe" => {
                let what = format!("pixels in '{}' are not read, only 32-bit_rle_rgbe", value.trim());
                return Err(Error::corrupt("HDR", what));
            }
            "EXPOSURE" => {
                let factor = value.trim().parse::<f32>().unwrap_or(1.0);
                exposure.iter_mut().for_each(|exposure| *exposure *= factor);
            }
            "COLORCORR" => {
                for (exposure, token) in exposure.iter_mut().zip(value.split_whitespace()) {
                    *exposure *= token.parse::<f32>().unwrap_or(1.0);
                }
            }
            _ => {}
        }
    }
    let line = read_line(source, &mut rest)?;
    let bad_size = || Error::corrupt("HDR", format!("'{line}' is not a size like '-Y height +X width'"));
    let parts: Vec<&str> = line.split_whitespace().collect();
    let ["-Y", height, "+X", width] = parts[..] else { return Err(bad_size()) };
    let number = |token: &str| token.parse::<u32>().map_err(|_| bad_size());
    let exposure = exposure.map(|x| if x.is_finite() && x > 0.0 { x } else { 1.0 });
    Ok(Header { width: number(width)?, height: number(height)?, exposure })
}

fn read_line(source: &mut dyn Source, rest: &mut u64) -> Result<String, Error> {
    let mut line = Vec::new();
    let read = source.take(*rest).read_until(b'\n', &mut line).map_err(Error::reading)?;
    *rest -= read as u64;
    match line.pop() {
        Some(b'\n') => Ok(String::from_utf8_lossy(&line).trim_end_matches('\r').to_string()),
        _ => Err(Error::corrupt("HDR", "the header does not end")),
    }
}

fn read_row(source: &mut dyn Source, row: &mut [[u8; 4]]) -> Result<(), Error> {
    let first = read_bytes::<4>(source)?;
    let by_component = first[0] == 2 && first[1] == 2 && first[2] < 128 && RUN_WIDTHS.contains(&row.len());
    if !by_component {
        return read_pixels(source, first, row);
    }
    let declared = usize::from(first[2]) << 8 | usize::from(first[3]);
    if declared != row.len() {
        return Err(Error::corrupt(
            "HDR",
            format!("a row of {declared} pixels in a picture of {}", row.len()),
        ));
    }
    (0..4).try_for_each(|component| read_runs(source, row, component))
}

fn read_runs(source: &mut dyn Source, row: &mut [[u8; 4]], component: usize) -> Result<(), Error> {
    let mut rest = row;
    while !rest.is_empty() {
        let [count] = read_bytes(source)?;
        let run = (count > 128).then(|| read_bytes::<1>(source)).transpose()?;
        let length = usize::from(if run.is_some() { count - 128 } else { count });
        if length == 0 || length > rest.len() {
            return Err(Error::corrupt(
                "HDR",
                format!("a run of {length} where {} pixels are left", rest.len()),
            ));
        }
        let (now, later) = std::mem::take(&mut rest).split_at_mut(length);
        for pixel in now {
            pixel[component] = run.map_or_else(|| read_bytes(source), Ok)?[0];
        }
        rest = later;
    }
    Ok(())
}

/// Whole pixels; (1, 1, 1, n) repeats the pixel before n times, n * 256 times if it follows another such one.
fn read_pixels(source: &mut dyn Source, first: [u8; 4], row: &mut [[u8; 4]]) -> Result<(), Error> {
    row[0] = first;
    let mut at = 1;
    let mut shift = 0;
    while at < row.len() {
        let pixel = read_bytes::<4>(source)?;
        if pixel[..3] != [1, 1, 1] {
            row[at] = pixel;
            at += 1;
            shift = 0;
            continue;
        }
        // A third repeat in a row would be longer than any row may be.
        let length = usize::from(pixel[3]) << shift;
        if shift > 16 || length > row.len() - at {
            return Err(Error::corrupt(
                "HDR",
                format!("a run of {length} where {} pixels are left", row.len() - at),
            ));
        }
        let value = row[at - 1];
        row[at..at + length].fill(value);
        at += length;
        shift += 8;
    }
    Ok(())
}

fn read_bytes<const N: usize>(source: &mut dyn Source) -> Result<[u8; N], Error> {
    let mut bytes = [0; N];
    let ended = |_| Error::corrupt("HDR", "the file ends before its last row; it is truncated");
    source.read_exact(&mut bytes).map_err(ended)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_kept_within_a_256th_of_the_largest() {
        for i in -300..=380 {
            let largest = (f64::from(i) * 0.3).exp2() as f32;
            let color = [largest, largest * 0.37, largest * 0.01];
            let back = rgb(rgbe(color));
            for c in 0..3 {
                let error = (back[c] - color[c]).abs();
                assert!(error <= largest / 256.0 + 1e-32, "{color:?} became {back:?}");
            }
        }
    }

    #[test]
    fn encoding_twice_changes_nothing() {
        for pixel in [[128, 0, 255, 128], [200, 17, 3, 1], [255, 255, 255, 254], [0, 0, 0, 0]] {
            let expected = if pixel[3] < 25 { [0; 4] } else { pixel };
            assert_eq!(rgbe(rgb(pixel)), expected, "{pixel:?} changed");
        }
    }

    #[test]
    fn odd_values_become_the_nearest_possible() {
        assert_eq!(rgbe([f32::NAN, -1.0, 0.0]), [0; 4], "NaN and negative light are black");
        assert!(rgb(rgbe([f32::INFINITY, 0.0, 0.0]))[0] > 1e38, "infinity is the largest value");
        assert_eq!(rgb(rgbe([0.0, 1e-40, 0.0])), [0.0; 3], "what is too small is black");
    }

    #[test]
    fn runs_come_back() {
        let mixed: Vec<u8> =
            (0..1000_u32).map(|i| if i % 300 < 150 { 7 } else { ((i * i) >> 3) as u8 }).collect();
        for values in [vec![3; 300], mixed, vec![1, 2, 3, 3, 3, 3, 4, 4]] {
            let mut bytes = Vec::new();
            encode_runs(&values, &mut bytes);
            let mut row = vec![[0; 4]; values.len()];
            read_runs(&mut std::io::Cursor::new(bytes), &mut row, 2).expect("our own runs are whole");
            assert!(row.iter().zip(&values).all(|(pixel, value)| pixel[2] == *value), "a run changed");
        }
    }

    #[test]
    fn old_runs_are_read() {
        let bytes =
            b"#?RADIANCE\nEXPOSURE=2\n\n-Y 1 +X 300\n\x80\x40\x20\x81\x01\x01\x01\x2b\x01\x01\x01\x01";
        let picture = decode(&mut std::io::Cursor::new(bytes), 1000, &Budget::of_picture(1000))
            .expect("1 + 43 + 256 pixels");
        assert_eq!(picture.color.len(), 300, "all pixels are there");
        assert!(picture.color.iter().all(|p| *p == picture.color[0]), "all pixels are alike");
        assert!((picture.color[0][0] - 0.5).abs() < 3e-3, "exposure is undone: {:?}", picture.color[0]);
    }

    #[test]
    fn corrections_of_channels_are_undone() {
        let bytes = b"#?RADIANCE\nCOLORCORR= 2 1 0.5\n\n-Y 1 +X 1\n\x80\x80\x80\x81";
        let picture =
            decode(&mut std::io::Cursor::new(bytes), 1000, &Budget::of_picture(1000)).expect("a pixel");
        let [r, g, b, _] = picture.color[0];
        assert!((r / g - 0.5).abs() < 1e-3 && (b / g - 2.0).abs() < 1e-3, "{:?}", picture.color[0]);
    }
}
