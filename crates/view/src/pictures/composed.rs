// SPDX-License-Identifier: GPL-3.0-or-later
//! Colours of a part of one picture, or of two that are compared. Tests: `tests`.

use std::fmt;
use std::str::FromStr;

use gnurt::image::{Picture, flip, heat_color};

use super::items::Item;

/// How two pictures are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Comparison {
    /// The first one left of a line, the second one right of it.
    #[default]
    Split,
    /// The first one alone.
    First,
    /// The second one alone.
    Second,
    /// The absolute difference of each value.
    Difference,
    /// Differences as people see them, as false colours.
    Flip,
}

impl Comparison {
    /// All, in the order of the keys from 1 on.
    pub const ALL: [Self; 5] = [Self::First, Self::Second, Self::Split, Self::Difference, Self::Flip];
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Split => "split",
            Self::First => "first",
            Self::Second => "second",
            Self::Difference => "difference",
            Self::Flip => "flip",
        })
    }
}

impl FromStr for Comparison {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|comparison| comparison.to_string() == name);
        found.ok_or_else(|| "expected first, second, split, difference or flip".to_owned())
    }
}

/// A part of one or two pictures as a picture of its own; `split` is the first column of the second picture in
/// [`Comparison::Split`].
///
/// # Errors
/// A picture lacks the part, or the two have other sizes.
pub fn compose(
    first: &Picture,
    second: Option<&Picture>,
    item: &Item,
    comparison: Comparison,
    split: u32,
) -> Result<Picture, String> {
    let colors = |picture| item.colors(picture).ok_or_else(|| format!("there is no layer '{item}'"));
    let of = |from: &Picture, color: Vec<[f32; 4]>| Picture {
        width: from.width,
        height: from.height,
        color,
        opacity: from.opacity,
        ..Picture::default()
    };
    let (Some(second), false) = (second, comparison == Comparison::First) else {
        return Ok(of(first, colors(first)?.into_owned()));
    };
    if comparison == Comparison::Second {
        return Ok(of(second, colors(second)?.into_owned()));
    }
    if [first.width, first.height] != [second.width, second.height] {
        return Err(format!(
            "pictures of {}x{} and {}x{} pixels cannot be compared",
            first.width, first.height, second.width, second.height
        ));
    }
    let [a, b] = [colors(first)?, colors(second)?];
    let color = match comparison {
        Comparison::Difference => {
            let differ = |(a, b): (&[f32; 4], &[f32; 4])| [0, 1, 2].map(|k| (a[k] - b[k]).abs());
            a.iter().zip(&*b).map(differ).map(|[r, g, b]| [r, g, b, 1.0]).collect()
        }
        Comparison::Flip => {
            let [a, b] = [a, b].map(|colors| of(first, colors.into_owned()));
            let seen = flip(&a, &b).map_err(|error| error.to_string())?;
            seen.into_iter().map(heat_color).map(|[r, g, b]| [r, g, b, 1.0]).collect()
        }
        _ => {
            let mut color = a.into_owned();
            let (width, split) = (first.width.max(1) as usize, split.min(first.width) as usize);
            for (row, other) in color.chunks_exact_mut(width).zip(b.chunks_exact(width)) {
                row[split..].copy_from_slice(&other[split..]);
            }
            color
        }
    };
    Ok(of(first, color))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pictures_in_five_ways() {
        let filled = |value: f32| {
            let mut picture = Picture::new(4, 2);
            picture.color.fill([value, 0.5, 0.0, 1.0]);
            picture
        };
        let (a, b) = (filled(0.25), filled(1.0));
        let shown = |comparison| compose(&a, Some(&b), &Item::Color, comparison, 3).expect("one size").color;
        assert_eq!(shown(Comparison::First), a.color);
        assert_eq!(shown(Comparison::Second), b.color);
        let reds = |colors: Vec<[f32; 4]>| colors.iter().map(|color| color[0]).collect::<Vec<_>>();
        assert_eq!(reds(shown(Comparison::Split)), [0.25, 0.25, 0.25, 1.0].repeat(2));
        assert_eq!(shown(Comparison::Difference), [[0.75, 0.0, 0.0, 1.0]; 8]);
        assert!(shown(Comparison::Flip)[0][0] > 0.1, "they differ");
        let same = compose(&a, Some(&a), &Item::Color, Comparison::Flip, 0).expect("one size");
        assert_eq!(same.color[0], [0.0, 0.0, 0.0, 1.0]);
        let wide = Picture::new(5, 2);
        let error = compose(&a, Some(&wide), &Item::Color, Comparison::Difference, 0);
        assert!(error.is_err_and(|why| why.contains("4x2") && why.contains("5x2")));
        let error = compose(&a, None, &Item::Layer("N".into()), Comparison::First, 0);
        assert!(error.is_err_and(|why| why.contains("'N'")));
        for comparison in Comparison::ALL {
            assert_eq!(comparison.to_string().parse(), Ok(comparison));
        }
        assert!("both".parse::<Comparison>().is_err());
    }
}
