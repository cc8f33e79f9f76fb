// SPDX-License-Identifier: GPL-3.0-or-later
//! Values for pixels: sizes, pieces, rectangles. See docs/reference/cli.md. Tests: `tests`.

use std::fmt::Display;

use gnurt::render::Piece;

use super::plain::list;

/// Columns and rows of a picture, at least 1 each and 2^31 together at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resolution {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Column and row of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pixel {
    pub(crate) x: u32,
    pub(crate) y: u32,
}

/// A rectangle of pixels as it was given: it may reach beyond the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crop {
    corners: [i64; 4],
}

const MOST_PIXELS: u64 = 1 << 31;

impl Crop {
    /// The part of it that lies in the frame: `[x0, y0, x1, y1]`, ends exclusive; `None` if there is none.
    pub(crate) fn within(self, frame: Resolution) -> Option<[u32; 4]> {
        let clip = |value: i64, end: u32| u32::try_from(value.clamp(0, i64::from(end))).unwrap_or(end);
        let [x0, y0, x1, y1] = self.corners;
        let [w, h] = [frame.width, frame.height];
        let clipped = [clip(x0, w), clip(y0, h), clip(x1, w), clip(y1, h)];
        (clipped[0] < clipped[2] && clipped[1] < clipped[3]).then_some(clipped)
    }
}

impl Display for Crop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x0, y0, x1, y1] = self.corners;
        write!(f, "{x0},{y0},{x1},{y1}")
    }
}

impl Display for Resolution {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// `1280x720`.
pub(crate) fn resolution(text: &str) -> Result<Resolution, String> {
    let form = || "give width and height like 1280x720".to_owned();
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(form)?;
    let side = |digits: &str| match digits.parse::<u64>() {
        Ok(side) => Ok(side),
        // Too many digits for a number is a large number all the same.
        Err(_) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => Ok(u64::MAX),
        Err(_) => Err(form()),
    };
    let (width, height) = (side(width)?, side(height)?);
    if width == 0 || height == 0 {
        return Err("a picture without pixels; width and height must be at least 1".into());
    }
    if width.saturating_mul(height) > MOST_PIXELS {
        return Err(format!("too many pixels; at most {MOST_PIXELS} in all"));
    }
    let side = |side: u64| u32::try_from(side).map_err(|_| form());
    Ok(Resolution { width: side(width)?, height: side(height)? })
}

/// `12,34`.
pub(crate) fn pixel(text: &str) -> Result<Pixel, String> {
    let form = "give column and row like 12,34, counted from 0 at the upper left corner";
    let [x, y] = list::<2, u32>(text, form)?;
    Ok(Pixel { x, y })
}

/// `0,0,640,360`.
pub(crate) fn crop(text: &str) -> Result<Crop, String> {
    let form = "give x0,y0,x1,y1 in pixels like 0,0,640,360; x1 and y1 are excluded";
    Ok(Crop { corners: list(text, form)? })
}

/// `2/8`.
pub(crate) fn piece(text: &str) -> Result<Piece, String> {
    const MOST: u32 = 1 << 20;
    let form = || format!("give the number of the piece and how many there are like 2/8, from 1 to {MOST}");
    let (index, count) = text.split_once('/').ok_or_else(form)?;
    let number = |text: &str| text.parse::<u32>().ok().filter(|number| (1..=MOST).contains(number));
    let (index, count) = number(index).zip(number(count)).ok_or_else(form)?;
    if index > count {
        return Err(format!("piece {index} of {count} is out of range; pieces count from 1"));
    }
    Ok(Piece { index: index - 1, count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(resolution("640x480"), Ok(Resolution { width: 640, height: 480 }), "the usual form");
        assert!(resolution("65536x32768").is_ok(), "2^31 pixels are allowed");
        for bad in
            ["", "640", "0x0", "10x0", "-1x5", "65536x32769", "99999999999999999999x1", "1x2x3", "1.5x2", "x"]
        {
            assert!(resolution(bad).is_err(), "'{bad}' is no size");
        }
    }

    #[test]
    fn crops_are_clipped_to_the_frame() {
        let frame = Resolution { width: 10, height: 8 };
        let clipped = |text| crop(text).expect("four numbers").within(frame);
        assert_eq!(clipped("-5,2,99,99"), Some([0, 2, 10, 8]), "the part inside");
        assert_eq!(clipped("10,0,20,8"), None, "beside the frame");
        assert_eq!(clipped("5,5,5,6"), None, "no width");
        assert_eq!(clipped("6,0,5,8"), None, "turned round");
        assert!(
            crop("1,2,3").is_err() && crop("1,2,3,4,5").is_err() && crop("a,b,c,d").is_err(),
            "four numbers"
        );
    }
}
