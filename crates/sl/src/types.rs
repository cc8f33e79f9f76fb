// SPDX-License-Identifier: GPL-3.0-or-later
//! Types of the language and the rules by which one value may replace another. The rules are OSL's.
//!
//! A type is a base and an array length; structs are named by their number in a [`Structs`] table.

use std::fmt;

/// The element type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Base {
    /// Not known, because of an error before.
    Unknown,
    /// No value.
    Void,
    /// 32-bit integer.
    Int,
    /// 32-bit float.
    Float,
    /// Linear colour of three floats.
    Color,
    /// Position.
    Point,
    /// Direction.
    Vector,
    /// Surface normal.
    Normal,
    /// 4x4 matrix, rows first; points are rows on its left.
    Matrix,
    /// Text.
    String,
    /// Scattering of a surface: a weighted sum of named parts.
    Closure,
    /// A struct, by its number.
    Struct(u16),
}

/// A base and an array length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Type {
    /// The type of one element.
    pub base: Base,
    /// 0: no array; -1: an array whose length the caller gives; else the length.
    pub array: i32,
}

/// One member of a struct.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
}

/// A struct.
#[derive(Clone, Debug, PartialEq)]
pub struct Struct {
    /// Its name.
    pub name: String,
    /// Number of the scope it was declared in; 0 is the file.
    pub scope: u32,
    /// Its members.
    pub fields: Vec<Field>,
}

/// All structs of a shader, by number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structs(pub Vec<Struct>);

impl Type {
    /// See [`Base::Unknown`].
    pub const UNKNOWN: Self = Self::of(Base::Unknown);
    /// See [`Base::Void`].
    pub const VOID: Self = Self::of(Base::Void);
    /// See [`Base::Int`].
    pub const INT: Self = Self::of(Base::Int);
    /// See [`Base::Float`].
    pub const FLOAT: Self = Self::of(Base::Float);
    /// See [`Base::Color`].
    pub const COLOR: Self = Self::of(Base::Color);
    /// See [`Base::Point`].
    pub const POINT: Self = Self::of(Base::Point);
    /// See [`Base::Vector`].
    pub const VECTOR: Self = Self::of(Base::Vector);
    /// See [`Base::Normal`].
    pub const NORMAL: Self = Self::of(Base::Normal);
    /// See [`Base::Matrix`].
    pub const MATRIX: Self = Self::of(Base::Matrix);
    /// See [`Base::String`].
    pub const STRING: Self = Self::of(Base::String);
    /// See [`Base::Closure`].
    pub const CLOSURE: Self = Self::of(Base::Closure);

    /// A base without an array.
    #[must_use]
    pub const fn of(base: Base) -> Self {
        Self { base, array: 0 }
    }

    /// An array of this base; `length` as in [`Type::array`].
    #[must_use]
    pub const fn array_of(self, length: i32) -> Self {
        Self { base: self.base, array: length }
    }

    /// The type of one element.
    #[must_use]
    pub const fn element(self) -> Self {
        Self::of(self.base)
    }

    /// Whether this is an array of any kind.
    #[must_use]
    pub const fn is_array(self) -> bool {
        self.array != 0
    }

    /// Whether nothing is known of it.
    #[must_use]
    pub fn is_unknown(self) -> bool {
        self.base == Base::Unknown
    }

    /// Whether this is a single struct.
    #[must_use]
    pub fn is_struct(self) -> bool {
        matches!(self.base, Base::Struct(_)) && self.array == 0
    }

    /// The struct's number, of arrays of structs as well.
    #[must_use]
    pub fn struct_id(self) -> Option<u16> {
        match self.base {
            Base::Struct(id) => Some(id),
            _ => None,
        }
    }

    /// Whether this is a single colour, point, vector or normal.
    #[must_use]
    pub fn is_triple(self) -> bool {
        self.array == 0 && self.base.is_triple()
    }

    /// A single int or float.
    #[must_use]
    pub fn is_scalar(self) -> bool {
        self.array == 0 && matches!(self.base, Base::Int | Base::Float)
    }

    /// A single number of any size: int, float, triple or matrix.
    #[must_use]
    pub fn is_numeric(self) -> bool {
        self.is_scalar() || self.is_triple() || self == Self::MATRIX
    }

    /// How many elements: 1 without an array, 0 when the length is not known.
    #[must_use]
    pub fn elements(self) -> usize {
        match self.array {
            0 => 1,
            n => usize::try_from(n).unwrap_or(0),
        }
    }

    /// Numbers (or texts, or closures) in all elements.
    #[must_use]
    pub fn size(self) -> usize {
        self.base.components() * self.elements()
    }

    /// Whether values can be taken for each other as they are: same shape, triples of any meaning.
    #[must_use]
    pub fn equivalent(self, other: Self, structs: &Structs) -> bool {
        if self == other {
            return true;
        }
        if self.array != other.array {
            let open = self.array != 0 && other.array != 0 && (self.array < 0 || other.array < 0);
            if !open {
                return false;
            }
        }
        match (self.base, other.base) {
            (Base::Struct(a), Base::Struct(b)) => structs.same_shape(a, b),
            (a, b) => a == b || (a.is_triple() && b.is_triple()),
        }
    }

    /// Whether a value of `source` may be assigned to this type.
    #[must_use]
    pub fn assignable_from(self, source: Self, structs: &Structs) -> bool {
        let closure = |t: Self| t == Self::CLOSURE;
        if closure(self) || closure(source) {
            return closure(self) && closure(source);
        }
        self.equivalent(source, structs)
            || (self.base.is_float_based() && !self.is_array() && source.is_scalar())
    }

    /// The type as it is written, with struct names.
    #[must_use]
    pub fn display(self, structs: &Structs) -> String {
        let base = match self.base {
            Base::Struct(id) => format!("struct {}", structs.get(id).map_or("unknown", |s| &s.name)),
            base => base.keyword().to_owned(),
        };
        match self.array {
            0 => base,
            n if n < 0 => format!("{base}[]"),
            n => format!("{base}[{n}]"),
        }
    }
}

/// The letters of types in signatures and `.oso` files.
const LETTERS: [(char, Base); 10] = [
    ('x', Base::Void),
    ('i', Base::Int),
    ('f', Base::Float),
    ('c', Base::Color),
    ('p', Base::Point),
    ('v', Base::Vector),
    ('n', Base::Normal),
    ('m', Base::Matrix),
    ('s', Base::String),
    ('C', Base::Closure),
];

impl Base {
    /// The base of a letter in signatures and `.oso` files; unknown if it has none.
    #[must_use]
    pub fn of_letter(letter: char) -> Self {
        LETTERS.iter().find(|known| known.0 == letter).map_or(Self::Unknown, |known| known.1)
    }

    /// The letter, and for a struct its number.
    #[must_use]
    pub fn letters(self) -> String {
        match self {
            Self::Struct(id) => format!("S{}", id + 1),
            _ => LETTERS.iter().find(|known| known.1 == self).map_or('x', |known| known.0).to_string(),
        }
    }

    /// Colour, point, vector or normal.
    #[must_use]
    pub const fn is_triple(self) -> bool {
        matches!(self, Self::Color | Self::Point | Self::Vector | Self::Normal)
    }

    /// Point, vector or normal: a quantity in space.
    #[must_use]
    pub const fn is_spatial(self) -> bool {
        matches!(self, Self::Point | Self::Vector | Self::Normal)
    }

    /// Made of floats.
    #[must_use]
    pub const fn is_float_based(self) -> bool {
        self.is_triple() || matches!(self, Self::Float | Self::Matrix)
    }

    /// Numbers in one: 1, 3 or 16; 0 where there is no value.
    #[must_use]
    pub const fn components(self) -> usize {
        match self {
            Self::Unknown | Self::Void | Self::Struct(_) => 0,
            Self::Int | Self::Float | Self::String | Self::Closure => 1,
            Self::Color | Self::Point | Self::Vector | Self::Normal => 3,
            Self::Matrix => 16,
        }
    }

    /// The word for it in source text.
    #[must_use]
    pub const fn keyword(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Void => "void",
            Self::Int => "int",
            Self::Float => "float",
            Self::Color => "color",
            Self::Point => "point",
            Self::Vector => "vector",
            Self::Normal => "normal",
            Self::Matrix => "matrix",
            Self::String => "string",
            Self::Closure => "closure color",
            Self::Struct(_) => "struct",
        }
    }

    /// The simple type that a word names; closures and structs are not simple.
    #[must_use]
    pub fn from_keyword(keyword: &str) -> Option<Self> {
        const SIMPLE: [Base; 9] = [
            Base::Void,
            Base::Int,
            Base::Float,
            Base::Color,
            Base::Point,
            Base::Vector,
            Base::Normal,
            Base::Matrix,
            Base::String,
        ];
        SIMPLE.into_iter().find(|base| base.keyword() == keyword)
    }
}

impl Structs {
    /// The struct of a number.
    #[must_use]
    pub fn get(&self, id: u16) -> Option<&Struct> {
        self.0.get(usize::from(id))
    }

    fn same_shape(&self, a: u16, b: u16) -> bool {
        if a == b {
            return true;
        }
        let (Some(a), Some(b)) = (self.get(a), self.get(b)) else { return false };
        // A struct's fields have lower numbers than itself, so this ends.
        a.fields.len() == b.fields.len()
            && a.fields.iter().zip(&b.fields).all(|(x, y)| x.ty.equivalent(y.ty, self))
    }
}

impl fmt::Display for Type {
    /// As written, but structs without their names; [`Type::display`] gives those.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.display(&Structs::default()))
    }
}
