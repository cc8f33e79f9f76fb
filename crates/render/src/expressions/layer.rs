// SPDX-License-Identifier: GPL-3.0-or-later
//! Layers of light: a name and a light path expression each; the usual ones by a word. Values that shaders put out are
//! layers, too, with the output's name in place of an expression.
//! Tests: `tests`; crates/render/tests/light_layers.rs.

use super::automaton::{Automaton, labels_in};
use super::events::{Alphabet, MOST_LABELS};
use super::syntax::{ExpressionError, parse};

/// Most layers of a picture.
const MOST_LAYERS: usize = 512;

/// Words for layers, and their expressions.
const WORDS: [(&str, &str); 15] = [
    ("direct", "C[RTV][LOB]"),
    ("indirect", "C[RTV][RTV]+[LOB]"),
    ("diffuse", "C<RD>[RTV]*[LOB]"),
    ("diffuse_direct", "C<RD>[LOB]"),
    ("diffuse_indirect", "C<RD>[RTV]+[LOB]"),
    ("glossy", "C<R[GS]>[RTV]*[LOB]"),
    ("glossy_direct", "C<R[GS]>[LOB]"),
    ("glossy_indirect", "C<R[GS]>[RTV]+[LOB]"),
    ("transmission", "CT[RTV]*[LOB]"),
    ("transmission_direct", "CT[LOB]"),
    ("transmission_indirect", "CT[RTV]+[LOB]"),
    ("volume", "CV[RTV]*[LOB]"),
    ("volume_direct", "CV[LOB]"),
    ("volume_indirect", "CV[RTV]+[LOB]"),
    ("emission", "C[LO]"),
];
const ENVIRONMENT: (&str, &str) = ("environment", "CB");
/// Expressions of colours of scattering at visible surfaces: light 1 from all sides, W, without shadows. With the expression of
/// the same scattering of the environment's light, and the parts of `Bsdf::albedo_parts` that count.
const COLORS: [(&str, &str, [bool; 4]); 8] = [
    ("C<RD>W", "C<RD>B", [true, false, false, false]),
    ("C<R[GS]>W", "C<R[GS]>B", [false, true, false, false]),
    ("CTW", "CTB", [false, false, true, true]),
    ("C<TD>W", "C<TD>B", [false, false, true, false]),
    ("C<T[GS]>W", "C<T[GS]>B", [false, false, false, true]),
    ("CRW", "CRB", [true, true, false, false]),
    ("C<.D>W", "C<.D>B", [true, false, true, false]),
    ("C[RT]W", "C[RT]B", [true; 4]),
];
/// Words for some of them.
const COLOR_WORDS: [(&str, &str); 3] =
    [("diffuse_color", COLORS[0].0), ("glossy_color", COLORS[1].0), ("transmission_color", COLORS[2].0)];

/// Names of layers of shaders' outputs: this, and the output.
pub const OUTPUT_PREFIX: &str = "shader.";
/// Before the output's name, in place of an expression.
const OUTPUT: &str = "output ";

/// What layers of light groups are called: this, and the group.
pub const GROUP_PREFIX: &str = "light.";
/// The layer of lights without a group.
pub const UNGROUPED: &str = "light_rest";

/// A part of light that integrators with virtual lights can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Emission,
    Environment,
    /// Scattered once.
    Direct,
    /// Scattered more than once.
    Indirect,
}

/// A layer of a picture: the part of its light whose paths an expression matches.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightLayer {
    /// The name of the layer in files.
    pub name: String,
    /// Its light path expression.
    pub expression: String,
}

impl LightLayer {
    /// A layer by an expression.
    ///
    /// # Errors
    /// The expression cannot be read, or matches no path.
    pub fn new(name: impl Into<String>, expression: impl Into<String>) -> Result<Self, ExpressionError> {
        let layer = Self { name: name.into(), expression: expression.into() };
        check(std::slice::from_ref(&layer))?;
        Ok(layer)
    }

    /// Words for layers, such as `direct`.
    pub fn words() -> impl Iterator<Item = &'static str> {
        WORDS.iter().chain([&ENVIRONMENT]).chain(&COLOR_WORDS).map(|(word, _)| *word)
    }

    /// The values that shaders put out by this name; `None` if no output can have it.
    #[must_use]
    pub fn of_output(output: &str) -> Option<Self> {
        let layer =
            Self { name: format!("{OUTPUT_PREFIX}{output}"), expression: format!("{OUTPUT}{output}") };
        layer.output().is_some().then_some(layer)
    }

    /// The output of shaders that it shows in place of light.
    #[must_use]
    pub fn output(&self) -> Option<&str> {
        const LONGEST: usize = 200;
        let name = self.expression.strip_prefix(OUTPUT)?;
        let is_word = |part: &str| {
            part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
                && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        (name.len() <= LONGEST && name.split('.').all(is_word)).then_some(name)
    }

    /// The part of light that it is, if integrators with virtual lights can tell it.
    pub(crate) fn part(&self) -> Option<Part> {
        let words = [
            ("emission", Part::Emission),
            ("environment", Part::Environment),
            ("direct", Part::Direct),
            ("indirect", Part::Indirect),
        ];
        let is_of = |word: &str| Self::of_word(word).is_some_and(|layer| layer.expression == self.expression);
        words.into_iter().find(|(word, _)| is_of(word)).map(|(_, part)| part)
    }

    /// Whether it needs the events of each path: it is neither a simple part of the light, nor a colour or an output.
    pub(crate) fn needs_events(&self) -> bool {
        self.part().is_none() && self.color().is_none() && self.output().is_none()
    }

    fn known_color(&self) -> Option<&'static (&'static str, &'static str, [bool; 4])> {
        COLORS.iter().find(|(expression, ..)| *expression == self.expression)
    }

    /// The parts of [`albedo_parts`](gnurt_shading::bsdf::Bsdf::albedo_parts) that it shows in place of light.
    pub(crate) fn color(&self) -> Option<[bool; 4]> {
        self.known_color().map(|(_, _, parts)| *parts)
    }

    /// The expression of paths, also of a colour or an output, whose light is replaced.
    pub(super) fn of_paths(&self) -> &str {
        if self.output().is_some() {
            return ENVIRONMENT.1;
        }
        self.known_color().map_or(&self.expression[..], |(_, expression, _)| expression)
    }

    /// The layer of a word.
    #[must_use]
    pub fn of_word(word: &str) -> Option<Self> {
        let mut all = WORDS.iter().chain([&ENVIRONMENT]).chain(&COLOR_WORDS);
        all.find(|(known, _)| *known == word)
            .map(|&(name, expression)| Self { name: name.into(), expression: expression.into() })
    }

    /// All light of a light group; of a light, if it has this name.
    #[must_use]
    pub fn of_light(label: &str) -> Self {
        let expression = format!("C.*<[LOB].'{label}'>");
        Self { name: format!("{GROUP_PREFIX}{label}"), expression }
    }

    /// One layer for each group, and one for all other light: together they are the picture.
    #[must_use]
    pub fn of_groups(groups: &[&str]) -> Vec<Self> {
        let of_group = |group: &&str| Self {
            expression: format!("C.*<[LOB].'@{group}'>"),
            name: format!("{GROUP_PREFIX}{group}"),
        };
        let rest = Self { name: UNGROUPED.into(), expression: "C.*<[LOB].'@'>".into() };
        groups.iter().map(of_group).chain([rest]).collect()
    }
}

/// The labels that the expressions of layers name, each once.
pub(crate) fn labels_of(layers: &[LightLayer]) -> Result<Vec<String>, ExpressionError> {
    let mut labels = Vec::new();
    for layer in layers {
        labels_in(&parse(layer.of_paths())?, &mut labels);
    }
    labels.sort_unstable();
    labels.dedup();
    Ok(labels)
}

/// Checks that layers can be rendered, whatever the scene is.
pub(crate) fn check(layers: &[LightLayer]) -> Result<(), ExpressionError> {
    let labels = labels_of(layers)?;
    let fault = |problem: String| ExpressionError { expression: String::new(), position: None, problem };
    if labels.len() > MOST_LABELS {
        return Err(fault(format!("{} labels; at most {MOST_LABELS} are distinguished", labels.len())));
    }
    if layers.len() > MOST_LAYERS {
        return Err(fault(format!("{} layers of light; at most {MOST_LAYERS}", layers.len())));
    }
    let expressions: Vec<&str> = layers.iter().map(LightLayer::of_paths).collect();
    Automaton::new(&expressions, &Alphabet::new(labels, vec![0], vec![0])).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_sound() {
        for word in LightLayer::words() {
            let layer = LightLayer::of_word(word).expect("a word");
            assert_eq!(LightLayer::new(word, layer.expression.clone()), Ok(layer), "{word}");
        }
        let groups = LightLayer::of_groups(&["key", "fill"]);
        assert_eq!(check(&groups), Ok(()), "all groups");
        assert_eq!(labels_of(&groups).expect("sound"), ["@", "@fill", "@key"], "their labels");
        let output = LightLayer::of_output("a_1.b").expect("an output");
        assert_eq!((&output.name[..], output.output()), ("shader.a_1.b", Some("a_1.b")), "an output");
        assert_eq!(LightLayer::new("shader.a_1.b", output.expression.clone()), Ok(output), "from a piece");
        for bad in ["", "1a", "a..b", "a b", "a.", "a'"] {
            assert_eq!(LightLayer::of_output(bad), None, "{bad}");
        }
        assert!(LightLayer::new("x", "C<RD").is_err() && LightLayer::of_word("beauty").is_none(), "faults");
    }
}
