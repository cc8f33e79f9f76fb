// SPDX-License-Identifier: GPL-3.0-or-later
//! The numbers over a finished picture, and the explanation of its keys. Tests: `tests`.

use gnurt::image::Picture;

use super::composed::Comparison;
use super::controls::Controls;

/// The keys, a line each.
pub const PICTURE_KEYS: &str = "\
drag                move the picture
wheel, + -          larger, smaller
Z                   one to one
X                   all of it
Tab, up, down       another layer
C                   red, green, blue, opacity or all
b B                 brighter, darker
T                   tone curve
I                   histogram
, .  left, right    a frame back, a frame on
space               play, stop
1 2                 the first picture, the second one
3                   both beside a line
right, shift drag   move that line
4 5                 differences, those that people see
R                   back to the beginning
F12, Ctrl-S         write a picture
F                   fill the screen
G                   numbers
H                   these keys
Esc, Ctrl-Q         leave";

/// The lines of numbers. `names` are those of the files of this frame.
pub(crate) fn lines(controls: &Controls, names: &[String], pictures: [Option<&Picture>; 2]) -> Vec<String> {
    let Controls { frame, frames, item, .. } = controls;
    let exposure = controls.shown_exposure();
    let film = if *frames > 1 { format!("  frame {} of {frames}", frame + 1) } else { String::new() };
    let [columns, rows] = controls.picture;
    let channel =
        controls.channel.map_or("", |channel| ["  red", "  green", "  blue", "  opacity"][channel.min(3)]);
    let mut lines = vec![
        format!("{}{film}", names.join("  and  ")),
        format!("{item}{channel}  {columns}x{rows}  {:.0} %", controls.zoom() * 100.0),
        format!("EV {:+.2}  {}", exposure.stops, exposure.tone),
    ];
    if names.len() > 1 {
        lines.push(match controls.comparison {
            Comparison::Flip => "differences that people see (FLIP)".to_owned(),
            other => other.to_string(),
        });
    }
    if let Some(at @ [x, y]) = controls.pixel() {
        for (k, picture) in pictures.into_iter().flatten().enumerate() {
            let place = if k == 0 { format!("{x},{y}") } else { " ".repeat(format!("{x},{y}").len()) };
            lines.push(format!("{place}  {}", item.values(picture, at)));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::super::items::{Item, items};
    use super::*;
    use crate::exposure::Exposure;
    use crate::input::{Input, Key};

    #[test]
    fn all_numbers_are_shown() {
        let mut picture = Picture::new(10, 10);
        picture.color[34] = [0.5, 0.25, 0.125, 1.0];
        let mut controls = Controls::new([100, 100], 5, Item::Color, Exposure::default(), 24.0);
        controls.show([10, 10], items(&picture));
        controls.handle(Input::Cursor([45.0, 35.0]));
        for key in ['b', '.', '4'] {
            controls.handle(Input::KeyDown { key: Key::Char(key), repeat: false });
        }
        let names = ["a.exr".to_owned(), "b.exr".to_owned()];
        let text = lines(&controls, &names, [Some(&picture), Some(&Picture::new(10, 10))]).join("\n");
        for part in [
            "a.exr  and  b.exr",
            "frame 2 of 5",
            "color",
            "10x10",
            "1000 %",
            "+0.25",
            "difference",
            "4,3  0.50000  0.25000  0.12500",
            "0.00000  0.00000",
        ] {
            assert!(text.contains(part), "'{part}' is in:\n{text}");
        }
    }
}
