// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters of scripts: declarations, and values given by programs and users. Labels and ranges are OSL's
//! metadata.

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// Numbers: of floats, colours, points, vectors, normals, matrices, and arrays of them.
    Floats(Vec<f32>),
    /// Whole numbers.
    Ints(Vec<i32>),
    /// Texts.
    Texts(Vec<String>),
}

impl ParameterValue {
    /// Its numbers as floats; `None` of texts.
    #[must_use]
    pub fn numbers(&self) -> Option<Vec<f32>> {
        match self {
            Self::Floats(list) => Some(list.clone()),
            Self::Ints(list) => Some(list.iter().map(|&x| x as f32).collect()),
            Self::Texts(_) => None,
        }
    }
}

/// A parameter of a script.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its type as it is written: `float`, `color`, `int[2]`.
    pub ty: String,
    /// Its default, as far as the text states it as a constant.
    pub default: ParameterValue,
    /// The label in user interfaces; empty if there is none.
    pub label: String,
    /// The help text of the source; empty if there is none.
    pub help: String,
    /// The least and the greatest value that is useful.
    pub range: Option<[f32; 2]>,
    /// The least change that is useful: `step`, or `sensitivity` as OSL's manual has it.
    pub step: Option<f32>,
    /// The widget in user interfaces: `number`, `checkBox`, `boolean`, `mapper`, `popup`, `null` for none;
    /// empty if not given.
    pub widget: String,
    /// The choices of `mapper` and `popup`, between bars: `off:0|on:1`.
    pub options: String,
    /// Whether it can be changed without compiling: numbers whose value is known before the shader runs.
    pub is_tunable: bool,
    /// How often the mesh has one, in the text's words: `vertex`, `triangle`, or empty.
    pub rate: String,
    /// Whether the mesh may give it: by vertex or triangle, under its name.
    pub is_of_mesh: bool,
}
