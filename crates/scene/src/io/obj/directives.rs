// SPDX-License-Identifier: GPL-3.0-or-later
//! Texture statements of MTL: options, then a file name that may have spaces.
//! Source: Wavefront MTL 4.2, "Options for texture map statements". `-o`, `-s`, `-clamp` and `-bm` are obeyed; the other options
//! are known well enough to be stepped over.
//! Tests: `tests::options_and_names`.

use crate::texture::Wrap;

/// A `map_Kd` statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MapStatement {
    pub(super) file: String,
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
    pub(super) wrap: Wrap,
    /// The factor of heights.
    pub(super) bump: f32,
}

impl MapStatement {
    /// Reads everything after the keyword; `None` if no file is named.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut map =
            Self { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], wrap: Wrap::Repeat, bump: 1.0 };
        let mut rest = text.trim();
        while let Some((option, after)) =
            rest.split_once(char::is_whitespace).filter(|(o, _)| o.starts_with('-'))
        {
            let after = after.trim_start();
            rest = match option {
                "-o" => numbers(after, &mut map.offset),
                "-s" => numbers(after, &mut map.scale),
                "-t" => numbers(after, &mut [0.0; 2]),
                "-mm" => numbers(after, &mut [0.0; 2]),
                "-clamp" => {
                    let (value, after) = token(after);
                    if value == "on" {
                        map.wrap = Wrap::ClampToEdge;
                    }
                    after
                }
                "-bm" => {
                    let (value, after) = token(after);
                    map.bump = value.parse().ok().filter(|x: &f32| x.is_finite()).unwrap_or(1.0);
                    after
                }
                "-blendu" | "-blendv" | "-cc" | "-imfchan" | "-type" | "-boost" | "-texres" => token(after).1,
                // Not an option: a file name that begins with a minus.
                _ => break,
            };
        }
        map.file = rest.trim().trim_matches('"').to_owned();
        (!map.file.is_empty()).then_some(map)
    }

    /// `uv' = scale uv + offset`.
    pub(super) fn uv_from_mesh(&self) -> [f32; 6] {
        [self.scale[0], 0.0, 0.0, self.scale[1], self.offset[0], self.offset[1]]
    }
}

fn token(text: &str) -> (&str, &str) {
    let (token, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (token, rest.trim_start())
}

/// Up to three numbers, of which the first two are stored; the rest of the text.
fn numbers<'a>(mut text: &'a str, to: &mut [f32; 2]) -> &'a str {
    for k in 0..3 {
        let (number, rest) = token(text);
        // A file may be called `7` or `nan`: the last word is never a number.
        match number.parse::<f32>() {
            Ok(x) if !rest.is_empty() => {
                if let Some(slot) = to.get_mut(k).filter(|_| x.is_finite()) {
                    *slot = x;
                }
                text = rest;
            }
            _ => break,
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_names() {
        let map = MapStatement::parse("-s 2 3 1 -o .5 -clamp on -bm 0.2 my oak.png").expect("a file");
        assert_eq!(map.file, "my oak.png", "a name with a space");
        assert_eq!(map.uv_from_mesh(), [2.0, 0.0, 0.0, 3.0, 0.5, 0.0], "scale and offset");
        assert_eq!((map.wrap, map.bump), (Wrap::ClampToEdge, 0.2), "-clamp on -bm 0.2");
        assert_eq!(MapStatement::parse("-odd.png x").expect("a file").file, "-odd.png x", "not an option");
        assert_eq!(MapStatement::parse("-s 1 1 7").expect("a file").file, "7", "a file called 7");
        assert_eq!(MapStatement::parse("-clamp on"), None, "no file");
        assert_eq!(
            MapStatement::parse(r"C:\maps\a.png").expect("a file").file,
            r"C:\maps\a.png",
            "a Windows path"
        );
    }
}
