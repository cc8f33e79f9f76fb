// SPDX-License-Identifier: GPL-3.0-or-later
//! The layers of a picture's file. Tests: `tests`, `tests/program/layers.rs`.

use gnurt::image::{BACKGROUND, Picture};

use crate::nearest::unknown;

/// Words of the command line, and layers of a picture.
const WORDS: [(&str, &[&str]); 10] = [
    ("albedo", &["albedo"]),
    ("background", &[BACKGROUND]),
    ("denoise", &["albedo", "N", "variance", "emission", "depth", "id", "motion", BACKGROUND]),
    ("depth", &["depth", ""]),
    ("emission", &["emission"]),
    ("ids", &["id"]),
    ("motion", &["motion"]),
    ("normal", &["N"]),
    ("position", &["P"]),
    ("variance", &["variance"]),
];
const ALL: &str = "all";
const NONE: &str = "none";

/// A choice of layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct LayerList(Option<Vec<&'static str>>);

/// `all`, `none`, or words between commas.
pub(crate) fn layers(text: &str) -> Result<LayerList, String> {
    let mut names = Vec::new();
    for word in text.split(',').map(str::trim) {
        match WORDS.iter().find(|(known, _)| *known == word) {
            Some((_, layers)) => names.extend_from_slice(layers),
            None if text == ALL => return Ok(LayerList(None)),
            None if text == NONE => return Ok(LayerList(Some(Vec::new()))),
            None => {
                let known: Vec<&str> =
                    [ALL, NONE].into_iter().chain(WORDS.iter().map(|(word, _)| *word)).collect();
                return Err(unknown("layer", word, &known));
            }
        }
    }
    Ok(LayerList(Some(names)))
}

impl LayerList {
    /// Drops the layers that are not in it.
    pub(crate) fn apply(&self, picture: &mut Picture) {
        let Some(names) = &self.0 else { return };
        let is_kept = |name: &str| names.contains(&name);
        if !is_kept(BACKGROUND) {
            picture.drop_background();
        }
        picture.layers.retain(|layer| is_kept(&layer.name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::image::Layer;

    #[test]
    fn lists_name_layers() {
        let kept = |text: &str| {
            let mut picture = Picture::new(1, 1);
            for name in ["albedo", "N", "P", "depth", "", "id"] {
                picture.layers.push(Layer::floats(name, [("X", vec![0.0])]));
            }
            layers(text).expect("known words").apply(&mut picture);
            picture.layers.iter().map(|layer| layer.name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(kept("normal, depth"), ["N", "depth", ""], "two of them");
        assert_eq!((kept("none").len(), kept("all").len()), (0, 6), "none and all");
        assert!(layers("normals").expect_err("no such layer").contains("normal"), "the nearest word");
        assert!(layers("all,none").is_err(), "words of their own");
    }
}
