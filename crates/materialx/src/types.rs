// SPDX-License-Identifier: GPL-3.0-or-later
//! Types of MaterialX, and how values of them are spelled in the shading language: in parts, so that no type needs a structure.

/// A type of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ty {
    Boolean,
    Integer,
    Float,
    Color3,
    Color4,
    Vector2,
    Vector3,
    Vector4,
    Matrix33,
    Matrix44,
    String,
    Filename,
    Bsdf,
    Edf,
    Vdf,
    Surface,
    Displacement,
    Volume,
    Light,
    Material,
}

const NAMES: [(&str, Ty); 20] = [
    ("boolean", Ty::Boolean),
    ("integer", Ty::Integer),
    ("float", Ty::Float),
    ("color3", Ty::Color3),
    ("color4", Ty::Color4),
    ("vector2", Ty::Vector2),
    ("vector3", Ty::Vector3),
    ("vector4", Ty::Vector4),
    ("matrix33", Ty::Matrix33),
    ("matrix44", Ty::Matrix44),
    ("string", Ty::String),
    ("filename", Ty::Filename),
    ("BSDF", Ty::Bsdf),
    ("EDF", Ty::Edf),
    ("VDF", Ty::Vdf),
    ("surfaceshader", Ty::Surface),
    ("displacementshader", Ty::Displacement),
    ("volumeshader", Ty::Volume),
    ("lightshader", Ty::Light),
    ("material", Ty::Material),
];

impl Ty {
    pub(crate) fn of(name: &str) -> Option<Self> {
        NAMES.iter().find(|(known, _)| *known == name).map(|(_, ty)| *ty)
    }

    pub(crate) fn name(self) -> &'static str {
        NAMES.iter().find(|(_, ty)| *ty == self).map_or("", |(name, _)| name)
    }

    /// The types of its parts in the shading language.
    pub(crate) fn parts(self) -> &'static [&'static str] {
        match self {
            Self::Boolean | Self::Integer => &["int"],
            Self::Float => &["float"],
            Self::Color3 => &["color"],
            Self::Color4 => &["color", "float"],
            Self::Vector2 => &["float"; 2],
            Self::Vector3 | Self::Displacement => &["vector"],
            Self::Vector4 => &["float"; 4],
            Self::Matrix33 | Self::Matrix44 => &["matrix"],
            Self::String | Self::Filename => &["string"],
            _ => &["closure color"],
        }
    }

    /// Numbers of a written value.
    fn len(self) -> usize {
        match self {
            Self::Boolean | Self::Integer | Self::Float => 1,
            Self::Vector2 => 2,
            Self::Color3 | Self::Vector3 => 3,
            Self::Color4 | Self::Vector4 => 4,
            Self::Matrix33 => 9,
            Self::Matrix44 => 16,
            _ => 0,
        }
    }

    pub(crate) fn is_text(self) -> bool {
        matches!(self, Self::String | Self::Filename)
    }

    pub(crate) fn is_closure(self) -> bool {
        self.parts() == ["closure color"]
    }

    pub(crate) fn is_color(self) -> bool {
        matches!(self, Self::Color3 | Self::Color4)
    }

    /// The numbers of a written value.
    pub(crate) fn numbers(self, text: &str) -> Result<Vec<f32>, String> {
        let text = text.trim();
        if self == Self::Boolean {
            return match text {
                "true" | "1" | "True" => Ok(vec![1.0]),
                "false" | "0" | "False" | "" => Ok(vec![0.0]),
                _ => Err(format!("'{text}' is not a boolean")),
            };
        }
        let split = |c: char| c == ',' || c.is_whitespace();
        let words: Vec<&str> = text.split(split).filter(|word| !word.is_empty()).collect();
        if words.len() != self.len() {
            return Err(format!("'{text}' is not a {}: it has {} numbers", self.name(), words.len()));
        }
        let number = |word: &&str| match word.parse::<f32>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("'{word}' is not a number")),
        };
        words.iter().map(number).collect()
    }

    /// A value of these numbers, in parts.
    pub(crate) fn spelled(self, n: &[f32]) -> Vec<String> {
        let list = |n: &[f32]| n.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ");
        match self {
            Self::Boolean | Self::Integer => vec![format!("{}", n[0] as i64 as i32)],
            Self::Color3 => vec![format!("color({})", list(n))],
            Self::Vector3 => vec![format!("vector({})", list(n))],
            Self::Color4 => vec![format!("color({})", list(&n[..3])), number(n[3])],
            Self::Matrix33 => {
                let rows: Vec<String> = n.chunks(3).map(list).collect();
                vec![format!("matrix({}, 0, {}, 0, {}, 0, 0, 0, 0, 1)", rows[0], rows[1], rows[2])]
            }
            Self::Matrix44 => vec![format!("matrix({})", list(n))],
            _ => n.iter().map(|x| number(*x)).collect(),
        }
    }

    /// The value of an input without any.
    pub(crate) fn zero(self) -> Vec<String> {
        match self {
            Self::String | Self::Filename => vec!["\"\"".to_owned()],
            Self::Matrix33 | Self::Matrix44 => vec!["matrix(1)".to_owned()],
            Self::Displacement => vec!["vector(0)".to_owned()],
            _ if self.is_closure() => vec!["0".to_owned()],
            _ => self.spelled(&vec![0.0; self.len()]),
        }
    }
}

/// A number in the shading language.
pub(crate) fn number(x: f32) -> String {
    let text = format!("{x:?}");
    if x < 0.0 { format!("({text})") } else { text }
}

/// A text in the shading language.
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => {}
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A value: an expression for each part, which may be repeated, for it is a name or a literal.
#[derive(Clone, Debug)]
pub(crate) struct Value {
    pub(crate) ty: Ty,
    pub(crate) parts: Vec<String>,
    /// The text of a string that is known now.
    pub(crate) text: Option<String>,
    /// The colour space of a file.
    pub(crate) color_space: Option<String>,
}

impl Value {
    pub(crate) fn new(ty: Ty, parts: Vec<String>) -> Self {
        Self { ty, parts, text: None, color_space: None }
    }

    pub(crate) fn zero(ty: Ty) -> Self {
        Self { text: ty.is_text().then(String::new), ..Self::new(ty, ty.zero()) }
    }

    pub(crate) fn word(ty: Ty, text: String) -> Self {
        Self { ty, parts: vec![quoted(&text)], text: Some(text), color_space: None }
    }

    /// Its first part; its only one, if it has one.
    pub(crate) fn first(&self) -> &str {
        &self.parts[0]
    }

    /// Each of its numbers.
    pub(crate) fn scalars(&self) -> Vec<String> {
        let each = |(part, ty): (&String, &&str)| match *ty {
            "color" | "vector" => match part.split_once('(').and_then(|(_, rest)| rest.strip_suffix(')')) {
                // A literal has no index.
                Some(numbers) => numbers.split(", ").cycle().take(3).map(str::to_owned).collect(),
                None => (0..3).map(|i| format!("{part}[{i}]")).collect(),
            },
            _ => vec![part.clone()],
        };
        self.parts.iter().zip(self.ty.parts()).flat_map(each).collect()
    }
}
