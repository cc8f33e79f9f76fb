// SPDX-License-Identifier: GPL-3.0-or-later
//! Names of textures in tiles, one file for each unit square of texture coordinates.
//! A name has one or more patterns: `<UDIM>`, `<UVTILE>` and the others of `PATTERNS`. Every unit square of the
//! coordinates (u, v), v upwards, has a file: the patterns are replaced by its column and its row.
//! Source: OpenImageIO's documentation of UDIM texture atlases; MaterialX 1.39, section on filename substitutions.
//! Tests: `tests`.

/// Columns of tiles: a UDIM number has one digit for them.
pub const COLUMNS: u32 = 10;
/// Rows of tiles: UDIM numbers have four digits.
pub const ROWS: u32 = 900;

/// How a pattern writes a tile.
#[derive(Clone, Copy)]
enum Form {
    /// 1001 + column + 10 row.
    Number,
    /// `u2_v5`, from one.
    Pair,
    /// `u01v04`, from zero.
    Digits,
    /// A letter and the column or the row from this number on.
    Axis(char, u32),
}

/// The patterns.
const PATTERNS: [(&str, Form); 10] = [
    ("<UDIM>", Form::Number),
    ("<udim>", Form::Number),
    ("%(UDIM)d", Form::Number),
    ("<UVTILE>", Form::Pair),
    ("<uvtile>", Form::Pair),
    ("u##v##", Form::Digits),
    ("<u>", Form::Axis('u', 0)),
    ("<v>", Form::Axis('v', 0)),
    ("<U>", Form::Axis('u', 1)),
    ("<V>", Form::Axis('v', 1)),
];

impl Form {
    fn text(self, [column, row]: [u32; 2]) -> String {
        match self {
            Self::Number => (1001 + column + COLUMNS * row).to_string(),
            Self::Pair => format!("u{}_v{}", column + 1, row + 1),
            Self::Digits => format!("u{column:02}v{row:02}"),
            Self::Axis(axis, first) => format!("{axis}{}", first + if axis == 'u' { column } else { row }),
        }
    }
}

/// Whether a name stands for tiles.
#[must_use]
pub fn is_tiled(name: &str) -> bool {
    PATTERNS.iter().any(|(pattern, _)| name.contains(pattern))
}

/// The name of the file of a tile, by column and row from 0 on.
#[must_use]
pub fn tile_name(name: &str, tile: [u32; 2]) -> String {
    let mut found = name.to_owned();
    for (pattern, form) in PATTERNS {
        if found.contains(pattern) {
            found = found.replace(pattern, &form.text(tile));
        }
    }
    found
}

/// The tile of a position, and the position in it; `None` beyond the tiles that have a name.
#[must_use]
pub fn tile_at(at: [f32; 2]) -> Option<([u32; 2], [f32; 2])> {
    let tile = at.map(f32::floor);
    let is_named = (0.0..COLUMNS as f32).contains(&tile[0]) && (0.0..ROWS as f32).contains(&tile[1]);
    is_named.then(|| (tile.map(|x| x as u32), [at[0] - tile[0], at[1] - tile[1]]))
}

/// All tiles that have a name, row by row.
pub fn tiles() -> impl Iterator<Item = [u32; 2]> {
    (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| [column, row]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_are_those_of_the_field() {
        let names = [
            ("a.<UDIM>.png", "a.1042.png"),
            ("a.%(UDIM)d.png", "a.1042.png"),
            ("a_<UVTILE>.png", "a_u2_v5.png"),
            ("a_u##v##.png", "a_u01v04.png"),
            ("a_<u>_<v>.png", "a_u1_v4.png"),
            ("a_<U>_<V>.png", "a_u2_v5.png"),
            ("<udim>/<UDIM>.png", "1042/1042.png"),
        ];
        for (name, expected) in names {
            assert!(is_tiled(name), "{name}");
            assert_eq!(tile_name(name, [1, 4]), expected, "{name}");
        }
        assert!(!is_tiled("a.1042.png") && !is_tiled("<x>.png"), "plain names");
    }

    #[test]
    fn tiles_are_unit_squares() {
        assert_eq!(tile_at([1.25, 4.5]), Some(([1, 4], [0.25, 0.5])));
        assert_eq!(tile_at([0.0, 0.0]), Some(([0, 0], [0.0, 0.0])));
        assert_eq!(tile_at([9.5, 899.5]), Some(([9, 899], [0.5, 0.5])));
        for outside in [[10.0, 0.0], [-0.1, 0.0], [0.0, -0.1], [0.0, 900.0], [f32::NAN, 0.0]] {
            assert_eq!(tile_at(outside), None, "{outside:?}");
        }
    }
}
