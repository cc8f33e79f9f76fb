// SPDX-License-Identifier: GPL-3.0-or-later
//! Letters drawn into the pixels of a screen: white on a darkened ground.
//! Source: the public-domain 8x8 font of the crate `font8x8`. Characters missing from the font are drawn as
//! `?`; parts outside of the screen are not drawn. Tests: `tests`.

use font8x8::legacy::BASIC_LEGACY;

/// Columns and rows of a letter.
const LETTER: usize = 8;
/// Rows from line to line.
const LINE: usize = 11;
/// Pixels around the text.
const MARGIN: usize = 4;
const INK: u32 = 0x00f4_f4f4;

/// Draws lines from a position on, each pixel of a letter `scale` pixels wide.
pub(crate) fn draw(
    screen: &mut [u32],
    [width, height]: [u32; 2],
    [left, top]: [usize; 2],
    scale: usize,
    lines: &[String],
) {
    let [width, height] = [width as usize, height as usize];
    if screen.len() < width * height || lines.is_empty() {
        return;
    }
    let columns = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let right = (left + (columns * LETTER + 2 * MARGIN) * scale).min(width);
    let bottom = (top + (lines.len() * LINE + 2 * MARGIN - (LINE - LETTER)) * scale).min(height);
    for y in top..bottom {
        for pixel in &mut screen[y * width + left.min(right)..y * width + right] {
            // A quarter of each channel.
            *pixel = *pixel >> 2 & 0x003f_3f3f;
        }
    }
    for (row, line) in lines.iter().enumerate() {
        for (column, letter) in line.chars().enumerate() {
            let x = left + (MARGIN + column * LETTER) * scale;
            let y = top + (MARGIN + row * LINE) * scale;
            if x < width && y < height {
                draw_letter(screen, [width, height], [x, y], scale, letter);
            }
        }
    }
}

fn draw_letter(
    screen: &mut [u32],
    [width, height]: [usize; 2],
    [left, top]: [usize; 2],
    scale: usize,
    letter: char,
) {
    let known = BASIC_LEGACY.get(letter as usize).filter(|_| !letter.is_control());
    let rows = known.unwrap_or(&BASIC_LEGACY[usize::from(b'?')]);
    for y in 0..LETTER * scale {
        for x in 0..LETTER * scale {
            let ink = rows[y / scale] >> (x / scale) & 1 == 1;
            if ink && left + x < width && top + y < height {
                screen[(top + y) * width + left + x] = INK;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(size: [u32; 2], at: [usize; 2], scale: usize, lines: &[&str]) -> Vec<u32> {
        let mut screen = vec![0x0040_8080; (size[0] * size[1]) as usize];
        let lines: Vec<String> = lines.iter().map(ToString::to_string).collect();
        draw(&mut screen, size, at, scale, &lines);
        screen
    }

    #[test]
    fn letters_can_be_read() {
        let screen = drawn([16, 16], [0, 0], 1, &["T"]);
        let rows: Vec<String> = screen[4 * 16..12 * 16]
            .chunks(16)
            .map(|row| row[4..12].iter().map(|&p| if p == INK { '#' } else { '.' }).collect())
            .collect();
        assert_eq!(rows[0], "######..", "the bar of the letter: {rows:#?}");
        assert_eq!(rows[5], "..##....", "its stem: {rows:#?}");
        assert_eq!(screen[0], 0x0010_2020, "the ground is darkened");
        assert_eq!(screen[15 * 16 + 15], 0x0010_2020, "to the margin's end");
    }

    #[test]
    fn nothing_is_drawn_outside() {
        for size in [[1, 1], [5, 7], [30, 9]] {
            for at in [[0, 0], [3, 3], [100, 100]] {
                let screen = drawn(size, at, 2, &["Hello \u{7}\u{fc}", "", "World"]);
                assert_eq!(screen.len() as u32, size[0] * size[1], "no pixel more");
            }
        }
        assert_eq!(drawn([3, 1], [0, 0], 1, &[]), [0x0040_8080; 3], "no text, no ground");
        draw(&mut [], [9, 9], [0, 0], 1, &["too small".into()]);
    }
}
