// SPDX-License-Identifier: GPL-3.0-or-later
//! A kind of object and its parameters, as the device describes them to programs.
//! Source: ANARI 1.1, introspection; descriptions are our own words. Tests: tests/introspection.rs.

use crate::types::{self, DataType};

/// Values that a parameter may have.
#[derive(Clone, Debug, Default)]
pub(crate) enum Values {
    /// All of its types.
    #[default]
    Any,
    /// These strings.
    Texts(Vec<&'static str>),
    /// These data types.
    Types(Vec<DataType>),
}

/// A default, or an end of a range, in the form of the parameter's first type.
#[derive(Clone, Debug)]
pub(crate) enum Info {
    /// Floats: numbers, vectors, boxes and matrices.
    Floats(Vec<f32>),
    /// A whole number.
    Whole(u64),
    /// A truth.
    Truth(bool),
    /// A string.
    Text(&'static str),
}

/// A parameter.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    pub(crate) name: &'static str,
    pub(crate) types: Vec<DataType>,
    pub(crate) default: Option<Info>,
    pub(crate) minimum: Option<Info>,
    pub(crate) maximum: Option<Info>,
    pub(crate) values: Values,
    /// Of arrays.
    pub(crate) elements: Vec<DataType>,
    pub(crate) required: bool,
    /// Meaning of its numbers: color, point, direction or vector.
    pub(crate) meaning: Option<&'static str>,
    pub(crate) extension: &'static str,
    pub(crate) about: &'static str,
}

/// A parameter of these types.
pub(super) fn p(name: &'static str, types: &[DataType], about: &'static str) -> Parameter {
    Parameter {
        name,
        types: types.to_vec(),
        default: None,
        minimum: None,
        maximum: None,
        values: Values::Any,
        elements: Vec::new(),
        required: false,
        meaning: None,
        extension: "",
        about,
    }
}

/// A number.
pub(super) fn number(name: &'static str, default: f32, about: &'static str) -> Parameter {
    p(name, &[types::FLOAT32], about).or(&[default])
}

/// A place, direction or colour.
pub(super) fn vector(
    name: &'static str,
    meaning: &'static str,
    default: [f32; 3],
    about: &'static str,
) -> Parameter {
    p(name, &[types::FLOAT32_VEC3], about).or(&default).means(meaning)
}

/// One of some words, the first by default.
pub(super) fn word(name: &'static str, words: &[&'static str], about: &'static str) -> Parameter {
    let mut word = p(name, &[types::STRING], about);
    word.default = words.first().copied().map(Info::Text);
    word.values = Values::Texts(words.to_vec());
    word
}

/// A truth.
pub(super) fn truth(name: &'static str, default: bool, about: &'static str) -> Parameter {
    Parameter { default: Some(Info::Truth(default)), ..p(name, &[types::BOOL], about) }
}

/// An array of one dimension.
pub(super) fn list(name: &'static str, elements: &[DataType], about: &'static str) -> Parameter {
    Parameter { elements: elements.to_vec(), ..p(name, &[types::ARRAY1D], about) }
}

impl Parameter {
    /// The same with a default of floats.
    pub(super) fn or(self, default: &[f32]) -> Self {
        Self { default: Some(Info::Floats(default.to_vec())), ..self }
    }

    /// The same with a default of a whole number.
    pub(super) fn or_whole(self, default: u64) -> Self {
        Self { default: Some(Info::Whole(default)), ..self }
    }

    /// The same, which objects cannot do without.
    pub(super) fn needed(self) -> Self {
        Self { required: true, ..self }
    }

    /// The same with a meaning.
    pub(super) fn means(self, meaning: &'static str) -> Self {
        Self { meaning: Some(meaning), ..self }
    }

    /// The same, of numbers from 0 to 1.
    pub(super) fn share(self) -> Self {
        self.least(0.0).most(1.0)
    }

    /// The same, of numbers from this on.
    pub(super) fn least(self, minimum: f32) -> Self {
        let count = self.default_len();
        Self { minimum: Some(Info::Floats(vec![minimum; count])), ..self }
    }

    fn most(self, maximum: f32) -> Self {
        let count = self.default_len();
        Self { maximum: Some(Info::Floats(vec![maximum; count])), ..self }
    }

    fn default_len(&self) -> usize {
        match &self.default {
            Some(Info::Floats(floats)) => floats.len(),
            _ => 1,
        }
    }

    /// The same by an extension of its own.
    pub(super) fn by(self, extension: &'static str) -> Self {
        Self { extension, ..self }
    }

    /// The same whose arrays have these elements.
    pub(super) fn of(self, elements: &[DataType]) -> Self {
        Self { elements: elements.to_vec(), ..self }
    }
}

/// A kind of object.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) kind: DataType,
    /// Nothing for kinds without subtypes.
    pub(crate) subtype: &'static str,
    pub(crate) extension: &'static str,
    pub(crate) about: &'static str,
    pub(crate) parameters: Vec<Parameter>,
}

/// A kind of object with parameters of its extension.
pub(super) fn entry(
    kind: DataType,
    subtype: &'static str,
    extension: &'static str,
    about: &'static str,
    parameters: Vec<Parameter>,
) -> Entry {
    let name = p("name", &[types::STRING], "For people: messages have it");
    let all = std::iter::once(name).chain(parameters);
    let parameters = all
        .map(|parameter| if parameter.extension.is_empty() { parameter.by(extension) } else { parameter })
        .collect();
    Entry { kind, subtype, extension, about, parameters }
}

/// Numbers of colours and other attributes.
pub(super) const COLORS: [DataType; 20] = [
    types::UFIXED8,
    types::UFIXED8_VEC2,
    types::UFIXED8_VEC3,
    types::UFIXED8_VEC4,
    types::UFIXED8_R_SRGB,
    types::UFIXED8_RA_SRGB,
    types::UFIXED8_RGB_SRGB,
    types::UFIXED8_RGBA_SRGB,
    types::UFIXED16,
    types::UFIXED16_VEC2,
    types::UFIXED16_VEC3,
    types::UFIXED16_VEC4,
    types::UFIXED32,
    types::UFIXED32_VEC2,
    types::UFIXED32_VEC3,
    types::UFIXED32_VEC4,
    types::FLOAT32,
    types::FLOAT32_VEC2,
    types::FLOAT32_VEC3,
    types::FLOAT32_VEC4,
];

/// Names of attributes that materials and samplers read.
pub(super) const ATTRIBUTES: [&str; 10] = [
    "attribute0",
    "attribute1",
    "attribute2",
    "attribute3",
    "color",
    "worldPosition",
    "worldNormal",
    "objectPosition",
    "objectNormal",
    "primitiveId",
];
