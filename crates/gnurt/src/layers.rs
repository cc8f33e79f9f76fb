// SPDX-License-Identifier: GPL-3.0-or-later
//! The layers of a picture's file: words for those of surfaces and of light, lights by name, and light path expressions.
//! Tests: `tests`, crates/cli/tests/program/layers.rs.

use gnurt_image::{BACKGROUND, Picture};
use gnurt_render::{GROUP_PREFIX, LightLayer, MatteKind, OUTPUT_PREFIX, UNGROUPED};

use crate::mattes::is_matte;

/// Words of the command line, and layers of a picture.
const WORDS: [(&str, &[&str]); 10] = [
    ("albedo", &["albedo"]),
    ("background", &[BACKGROUND]),
    (
        "denoise",
        &[
            "albedo",
            "N",
            "variance",
            "unscattered",
            "depth",
            "id",
            "motion",
            BACKGROUND,
            "seen_albedo",
            "seen_N",
            "seen_light",
            "seen_split",
            "seen_direct",
            "seen_direct_variance",
            "seen_indirect_variance",
            "seen_P",
            "seen_depth",
            "seen_id",
        ],
    ),
    ("depth", &["depth", ""]),
    ("ids", &["id"]),
    ("motion", &["motion"]),
    ("normal", &["N"]),
    ("position", &["P"]),
    ("unscattered", &["unscattered"]),
    ("variance", &["variance"]),
];
/// Words of the command line, and kinds of mattes.
const MATTES: [(&str, &[MatteKind]); 4] = [
    ("cryptomatte", &MatteKind::ALL),
    ("crypto_object", &[MatteKind::Object]),
    ("crypto_material", &[MatteKind::Material]),
    ("crypto_asset", &[MatteKind::Asset]),
];
/// Begins the names of layers that follow mirrors and glass.
const SEEN: &str = "seen_";
const ALL: &str = "all";
const NONE: &str = "none";
/// Before the name of a light or of a light group.
const LIGHT: &str = "light:";

/// A choice of layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LayerList {
    /// Those of surfaces that are kept by name, and whether all of them are.
    names: Vec<&'static str>,
    has_all: bool,
    /// Those of light.
    pub light: Vec<LightLayer>,
    /// Those of Cryptomatte.
    pub mattes: Vec<MatteKind>,
    /// As it was given.
    pub text: String,
}

/// A list that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LayerError {
    /// A word that is no layer.
    #[error("unknown layer '{word}'; valid are: {words}; {FORMS}", words = known_words().join(", "))]
    Unknown {
        /// The word.
        word: String,
    },
    /// Another fault.
    #[error("{0}")]
    Invalid(String),
}

/// The other entries of a list.
pub const FORMS: &str =
    "light:NAME is a light group, shader.NAME an output of shaders, NAME=EXPRESSION a light path expression";

/// Words of a list.
#[must_use]
pub fn known_words() -> Vec<&'static str> {
    let of_surfaces = [ALL, NONE].into_iter().chain(WORDS.iter().map(|(word, _)| *word));
    of_surfaces.chain(LightLayer::words()).chain(MATTES.iter().map(|(word, _)| *word)).collect()
}

/// Reads `all`, `none`, or words, `light:NAME`, `shader.NAME` and `NAME=EXPRESSION` between commas.
///
/// # Errors
/// [`LayerError`] names the entry at fault.
pub fn layers(text: &str) -> Result<LayerList, LayerError> {
    let (mut names, mut has_all) = (Vec::new(), false);
    let (mut light, mut mattes): (Vec<LightLayer>, Vec<MatteKind>) = Default::default();
    let parts = parts(text);
    for part in &parts {
        let part = part.trim();
        let word = &part.replace('-', "_")[..];
        if let Some((_, layers)) = WORDS.iter().find(|(known, _)| *known == word) {
            names.extend_from_slice(layers);
        } else if let Some((_, kinds)) = MATTES.iter().find(|(known, _)| *known == word) {
            mattes.extend(kinds.iter().filter(|kind| !mattes.contains(kind)).copied().collect::<Vec<_>>());
        } else if part == ALL {
            has_all = true;
        } else if part == NONE && parts.len() == 1 {
        } else {
            let layer = LightLayer::of_word(word).map_or_else(|| light_layer(part), Ok)?;
            if light.iter().any(|known| known.name == layer.name) {
                return Err(LayerError::Invalid(format!("two layers are called '{}'", layer.name)));
            }
            light.push(layer);
        }
    }
    Ok(LayerList { names, has_all, light, mattes, text: text.replace(char::is_control, " ") })
}

/// A list at its commas, but those in counts, brackets and labels of expressions.
fn parts(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut is_label) = (vec![String::new()], 0_u32, false);
    for c in text.chars() {
        match c {
            '\'' => is_label = !is_label,
            '{' | '[' | '<' | '(' if !is_label => depth += 1,
            '}' | ']' | '>' | ')' if !is_label => depth = depth.saturating_sub(1),
            ',' if !is_label && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts
}

fn light_layer(part: &str) -> Result<LightLayer, LayerError> {
    let sound = |layer: LightLayer| {
        LightLayer::new(layer.name, layer.expression).map_err(|error| LayerError::Invalid(error.to_string()))
    };
    if let Some(name) = part.strip_prefix(LIGHT) {
        check_name(name)?;
        return sound(LightLayer::of_light(name));
    }
    if let Some(output) = part.strip_prefix(OUTPUT_PREFIX).filter(|output| !output.contains('=')) {
        return LightLayer::of_output(output).ok_or_else(|| {
            LayerError::Invalid(format!("invalid output '{output}' of shaders; give NAME or LAYER.NAME"))
        });
    }
    let Some((name, expression)) = part.split_once('=') else {
        return Err(LayerError::Unknown { word: part.into() });
    };
    let name = name.trim();
    check_name(name)?;
    let is_taken = WORDS.iter().any(|(word, layers)| *word == name || layers.contains(&name));
    let is_color = ["R", "G", "B", "A", "Z"].contains(&name);
    let is_matte = MatteKind::ALL.iter().any(|kind| name.starts_with(kind.layer()));
    let is_group = is_matte
        || [GROUP_PREFIX, OUTPUT_PREFIX, SEEN].iter().any(|prefix| name.starts_with(prefix))
        || name == UNGROUPED;
    if is_taken || is_color || is_group || LightLayer::of_word(name).is_some() {
        return Err(LayerError::Invalid(format!("'{name}' is the name of another layer; give another one")));
    }
    sound(LightLayer { name: name.into(), expression: expression.replace(char::is_control, " ") })
}

/// Drops the layers that follow mirrors and glass, for denoisers only.
pub fn drop_seen(picture: &mut Picture) {
    picture.layers.retain(|layer| !layer.name.starts_with(SEEN));
}

fn check_name(name: &str) -> Result<(), LayerError> {
    const LONGEST: usize = 100;
    let is_fine = |c: char| c.is_alphanumeric() || "_-. /".contains(c);
    match !name.is_empty() && name.len() <= LONGEST && name.chars().all(is_fine) {
        true => Ok(()),
        false => Err(LayerError::Invalid(format!(
            "invalid name '{name}'; give letters, digits, _ - . and /, up to {LONGEST}"
        ))),
    }
}

impl LayerList {
    /// Whether it has the layers that follow mirrors and glass.
    #[must_use]
    pub fn has_seen(&self) -> bool {
        self.names.iter().any(|name| name.starts_with(SEEN))
    }

    /// Drops the layers that are not in it; `light`: the layers of light of the picture.
    pub fn apply(&self, picture: &mut Picture, light: &[LightLayer]) {
        if self.has_all {
            return;
        }
        // Parts of the light make the whole of it, with the background.
        let is_part = |name: &str| name == BACKGROUND || light.iter().any(|layer| layer.name == name);
        let is_kept = |name: &str| self.names.contains(&name) || (!light.is_empty() && is_part(name));
        if !is_kept(BACKGROUND) {
            picture.drop_background();
        }
        picture.layers.retain(|layer| is_kept(&layer.name) || is_matte(&layer.name));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_image::Layer;

    #[test]
    fn lists_name_layers() {
        let kept = |text: &str| {
            let mut picture = Picture::new(1, 1);
            for name in ["albedo", "N", "P", "depth", "", "id", "direct", "x"] {
                picture.layers.push(Layer::floats(name, [("X", vec![0.0])]));
            }
            let list = layers(text).expect("known words");
            list.apply(&mut picture, &list.light);
            picture.layers.iter().map(|layer| layer.name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(kept("normal, depth"), ["N", "depth", ""], "two of them");
        assert_eq!((kept("none").len(), kept("all").len()), (0, 8), "none and all");
        assert_eq!(kept("normal,direct,x=C<RD>{1,2}[LO]"), ["N", "direct", "x"], "of light as well");
        assert_eq!(kept("shader.x,x=C.*"), ["x"], "of shaders");
        assert_eq!(kept("all,direct").len(), 8, "all of surfaces and one of light");
        let seen = ["all,denoise", "denoise,all", "denoise", "all"]
            .map(|text| layers(text).expect("known words").has_seen());
        assert_eq!(
            (seen, kept("all,denoise").len()),
            ([true, true, true, false], 8),
            "more than all of surfaces"
        );
        let mattes = layers("crypto-material,cryptomatte").expect("known words").mattes;
        assert_eq!(mattes, [MatteKind::Material, MatteKind::Object, MatteKind::Asset], "each kind once");
        for (bad, words) in [
            ("all,none", "unknown layer 'none'"),
            ("direct,direct", "two layers"),
            ("CryptoObject00=C.*", "another layer"),
            ("x=C<R", "character 2"),
            ("N=C.*", "another layer"),
            ("a*b=C.*", "invalid name"),
            ("light:", "invalid name"),
            ("shader.", "invalid output ''"),
            ("shader.a b", "invalid output 'a b'"),
            ("shader.a=C.*", "another layer"),
            ("shader.a,shader.a", "two layers"),
            ("light:a'b", "invalid name"),
        ] {
            let message = layers(bad).expect_err(bad).to_string();
            assert!(message.contains(words), "{bad}: {message}");
        }
    }
}
