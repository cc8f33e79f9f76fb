// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameter lists: `"float fov" [ 45 ]` and the like, and a mark of each that the reader has used.
//! Source: the section Parameter Lists of the file-format page. Invariant: each unused parameter leads to a
//! warning. Tests: `tests/broken.rs`.

use std::cell::Cell;

use gnurt_scene::io::reader::{Budget, quoted};
use gnurt_scene::io::{Error, Oddity, Warnings};

use crate::color_space::ColorSpace;
use crate::location::Location;
use crate::sources::Source;
use crate::tokens::Token;

/// The type of a parameter's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Integer,
    Float,
    Pair,
    Triple,
    Bool,
    Text,
    Blackbody,
    Rgb,
    Spectrum,
    Texture,
}

/// The names of kinds, and how many numbers make one value.
const KINDS: [(&str, Kind, usize); 16] = [
    ("integer", Kind::Integer, 1),
    ("float", Kind::Float, 1),
    ("point2", Kind::Pair, 2),
    ("vector2", Kind::Pair, 2),
    ("point3", Kind::Triple, 3),
    ("point", Kind::Triple, 3),
    ("vector3", Kind::Triple, 3),
    ("vector", Kind::Triple, 3),
    ("normal3", Kind::Triple, 3),
    ("normal", Kind::Triple, 3),
    ("bool", Kind::Bool, 1),
    ("string", Kind::Text, 1),
    ("blackbody", Kind::Blackbody, 1),
    ("rgb", Kind::Rgb, 3),
    ("spectrum", Kind::Spectrum, 1),
    ("texture", Kind::Texture, 1),
];

/// The values of a parameter.
#[derive(Clone, Debug)]
pub(crate) enum Values {
    Ints(Vec<i32>),
    Floats(Vec<f32>),
    Bools(Vec<bool>),
    Texts(Vec<String>),
}

/// A parameter.
#[derive(Clone, Debug)]
pub(crate) struct Parameter {
    pub(crate) kind: Kind,
    kind_name: &'static str,
    pub(crate) name: String,
    pub(crate) location: Location,
    pub(crate) values: Values,
    /// Of its `rgb`.
    pub(crate) space: ColorSpace,
    used: Cell<bool>,
}

impl Parameter {
    fn of(declaration: &str, location: Location, space: ColorSpace) -> Result<(Self, usize), Error> {
        let mut words = declaration.split_ascii_whitespace();
        let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
            let problem = format!("parameter {} is not a type and a name", quoted(declaration));
            return Err(location.error(problem, "expected the like of \"float fov\""));
        };
        let Some(&(kind_name, kind, width)) = KINDS.iter().find(|(known, ..)| *known == kind) else {
            let known: Vec<&str> = KINDS.iter().map(|(known, ..)| *known).collect();
            let problem = format!("unknown type {} of parameter {}", quoted(kind), quoted(name));
            return Err(location.error(problem, format!("valid are {}", known.join(", "))));
        };
        let values = match kind {
            Kind::Integer => Values::Ints(Vec::new()),
            Kind::Bool => Values::Bools(Vec::new()),
            Kind::Text | Kind::Texture => Values::Texts(Vec::new()),
            _ => Values::Floats(Vec::new()),
        };
        let used = Cell::new(false);
        Ok((Self { kind, kind_name, name: name.to_owned(), location, values, space, used }, width))
    }

    fn push(&mut self, token: &Token, source: &Source) -> Result<(), Error> {
        let location = || source.location();
        let wrong = |what: &str, found: &str| {
            let problem = format!("{} is not {what} of \"{} {}\"", quoted(found), self.kind_name, self.name);
            location().error(problem, "give values of the parameter's type")
        };
        match (token, &mut self.values) {
            (Token::Text(text), Values::Texts(list)) => list.push(text.clone()),
            (Token::Text(text), Values::Floats(list)) if self.kind == Kind::Spectrum && list.is_empty() => {
                self.values = Values::Texts(vec![text.clone()]);
            }
            (Token::Text(text), Values::Bools(list)) => match &text[..] {
                "true" => list.push(true),
                "false" => list.push(false),
                _ => return Err(wrong("a value", text)),
            },
            (Token::Text(text), _) => return Err(wrong("a number", text)),
            (Token::Word(range), values) => {
                let word = source.word(range);
                match values {
                    Values::Floats(list) => {
                        let number = word.parse().ok().filter(|x: &f32| !x.is_nan());
                        list.push(number.ok_or_else(|| wrong("a number", word))?);
                    }
                    Values::Ints(list) => {
                        let whole = word.parse().ok().or_else(|| {
                            let float: f64 = word.parse().ok()?;
                            (float.fract() == 0.0 && float.abs() < 2e9).then_some(float as i32)
                        });
                        list.push(whole.ok_or_else(|| wrong("a whole number", word))?);
                    }
                    Values::Bools(list) => match word {
                        "true" => list.push(true),
                        "false" => list.push(false),
                        _ => return Err(wrong("`true` or `false`", word)),
                    },
                    Values::Texts(_) => return Err(wrong("a text in quotation marks", word)),
                }
            }
            (Token::Open | Token::Close, _) => return Err(wrong("a value", "[")),
        }
        Ok(())
    }

    fn count(&self) -> usize {
        match &self.values {
            Values::Ints(list) => list.len(),
            Values::Floats(list) => list.len(),
            Values::Bools(list) => list.len(),
            Values::Texts(list) => list.len(),
        }
    }

    /// Bytes that it holds.
    fn bytes(&self) -> usize {
        let values = match &self.values {
            Values::Ints(list) => list.capacity() * 4,
            Values::Floats(list) => list.capacity() * 4,
            Values::Bools(list) => list.capacity(),
            Values::Texts(list) => list.iter().map(|text| text.capacity() + 24).sum(),
        };
        values + size_of::<Self>() + self.name.capacity()
    }

    /// Its numbers, if it has some.
    pub(crate) fn floats(&self) -> Option<&[f32]> {
        match &self.values {
            Values::Floats(list) => Some(list),
            _ => None,
        }
    }

    /// Its texts, if it has some.
    pub(crate) fn texts(&self) -> Option<&[String]> {
        match &self.values {
            Values::Texts(list) => Some(list),
            _ => None,
        }
    }

    /// An error about it.
    pub(crate) fn error(&self, problem: &str, remedy: &str) -> Error {
        self.location.error(format!("\"{} {}\" {problem}", self.kind_name, self.name), remedy)
    }
}

/// The parameters of a statement.
#[derive(Clone, Debug)]
pub(crate) struct Parameters {
    list: Vec<Parameter>,
    /// Of the statement.
    pub(crate) location: Location,
}

impl Parameters {
    /// None.
    pub(crate) fn none(location: Location) -> Self {
        Self { list: Vec::new(), location }
    }

    /// Reads those that follow.
    pub(crate) fn read(
        source: &mut Source,
        location: Location,
        space: ColorSpace,
        budget: &Budget,
    ) -> Result<Self, Error> {
        let mut list: Vec<Parameter> = Vec::new();
        while source.peek() == Some(b'"') {
            let at = source.location();
            let Some(Token::Text(declaration)) = source.next()? else { break };
            let (mut parameter, width) = Parameter::of(&declaration, at, space)?;
            read_values(source, &mut parameter, budget)?;
            if parameter.count() == 0 {
                return Err(parameter.error("has no value", "give at least one"));
            }
            if parameter.count() % width != 0 {
                let problem = format!("has {} numbers, not a multiple of {width}", parameter.count());
                return Err(parameter.error(&problem, "give whole values"));
            }
            if list.iter().any(|known| known.name == parameter.name && known.kind == parameter.kind) {
                return Err(parameter.error("is given twice", "leave one of them out"));
            }
            list.push(parameter);
        }
        Ok(Self { list, location })
    }

    /// Adds those of `Attribute` statements, which come after its own.
    pub(crate) fn extend(&mut self, attributes: &[Parameter]) {
        for attribute in attributes {
            if !self.list.iter().any(|own| own.name == attribute.name) {
                attribute.used.set(true);
                self.list.push(attribute.clone());
            }
        }
    }

    /// Takes them apart.
    pub(crate) fn into_list(self) -> Vec<Parameter> {
        self.list
    }

    /// Gives back the bytes of its parameters.
    pub(crate) fn release(&self, budget: &Budget) {
        budget.release(self.list.iter().map(Parameter::bytes).sum());
    }

    /// One of a name, of one of these kinds.
    pub(crate) fn find(&self, name: &str, kinds: &[Kind]) -> Option<&Parameter> {
        let found = self.list.iter().find(|p| p.name == name && kinds.contains(&p.kind))?;
        found.used.set(true);
        Some(found)
    }

    /// Warns of unused parameters.
    pub(crate) fn warn_unused(&self, of: &str, warnings: &mut Warnings) {
        for parameter in self.list.iter().filter(|parameter| !parameter.used.get()) {
            let detail = format!("\"{} {}\" of {of}", parameter.kind_name, parameter.name);
            parameter.location.warn(warnings, Oddity::UnknownParameter, detail);
        }
    }

    /// Marks all as known.
    pub(crate) fn ignore(&self) {
        self.list.iter().for_each(|parameter| parameter.used.set(true));
    }

    fn one<'a, T>(
        &'a self,
        name: &str,
        kinds: &[Kind],
        list: fn(&Values) -> Option<&[T]>,
    ) -> Result<Option<&'a T>, Error> {
        let Some(found) = self.find(name, kinds) else { return Ok(None) };
        match list(&found.values) {
            Some([one]) => Ok(Some(one)),
            _ => Err(found.error(&format!("has {} values", found.count()), "give one")),
        }
    }

    /// A number, if it is given.
    pub(crate) fn float(&self, name: &str) -> Result<Option<f32>, Error> {
        fn floats(values: &Values) -> Option<&[f32]> {
            match values {
                Values::Floats(list) => Some(list),
                _ => None,
            }
        }
        Ok(self.one(name, &[Kind::Float], floats)?.copied())
    }

    /// A number.
    pub(crate) fn float_or(&self, name: &str, default: f32) -> Result<f32, Error> {
        Ok(self.float(name)?.unwrap_or(default))
    }

    /// A whole number.
    pub(crate) fn int(&self, name: &str) -> Result<Option<i32>, Error> {
        fn ints(values: &Values) -> Option<&[i32]> {
            match values {
                Values::Ints(list) => Some(list),
                _ => None,
            }
        }
        Ok(self.one(name, &[Kind::Integer], ints)?.copied())
    }

    /// Yes or no.
    pub(crate) fn bool_or(&self, name: &str, default: bool) -> Result<bool, Error> {
        fn bools(values: &Values) -> Option<&[bool]> {
            match values {
                Values::Bools(list) => Some(list),
                _ => None,
            }
        }
        Ok(self.one(name, &[Kind::Bool], bools)?.copied().unwrap_or(default))
    }

    /// A text, if it is given.
    pub(crate) fn text(&self, name: &str) -> Result<Option<&str>, Error> {
        self.text_of(name, Kind::Text)
    }

    /// The name of a texture, if it is given.
    pub(crate) fn texture(&self, name: &str) -> Result<Option<&str>, Error> {
        self.text_of(name, Kind::Texture)
    }

    fn text_of(&self, name: &str, kind: Kind) -> Result<Option<&str>, Error> {
        fn texts(values: &Values) -> Option<&[String]> {
            match values {
                Values::Texts(list) => Some(list),
                _ => None,
            }
        }
        Ok(self.one(name, &[kind], texts)?.map(|text| &text[..]))
    }

    /// A point or a direction.
    pub(crate) fn triple_or(&self, name: &str, default: [f32; 3]) -> Result<[f32; 3], Error> {
        match self.triples(name) {
            None => Ok(default),
            Some([one]) => Ok(*one),
            Some(_) => Err(self.find(name, &[Kind::Triple]).map_or_else(
                || self.location.error("a point is missing", ""),
                |p| p.error("has more than one value", "give one"),
            )),
        }
    }

    /// Points or directions.
    pub(crate) fn triples(&self, name: &str) -> Option<&[[f32; 3]]> {
        let found = self.find(name, &[Kind::Triple])?;
        Some(found.floats()?.as_chunks().0)
    }

    /// Pairs of numbers.
    pub(crate) fn pairs(&self, name: &str) -> Option<&[[f32; 2]]> {
        let found = self.find(name, &[Kind::Pair])?;
        Some(found.floats()?.as_chunks().0)
    }

    /// Numbers.
    pub(crate) fn floats(&self, name: &str) -> Option<&[f32]> {
        self.find(name, &[Kind::Float])?.floats()
    }

    /// Whole numbers.
    pub(crate) fn ints(&self, name: &str) -> Option<&[i32]> {
        match &self.find(name, &[Kind::Integer])?.values {
            Values::Ints(list) => Some(list),
            _ => None,
        }
    }
}

/// One value, or many between brackets.
fn read_values(source: &mut Source, parameter: &mut Parameter, budget: &Budget) -> Result<(), Error> {
    let mut held = parameter.bytes();
    let excess = |source: &Source, e| source.location().excess(e);
    budget.hold(held).map_err(|e| excess(source, e))?;
    let missing =
        |parameter: &Parameter| parameter.error("has no value", "give one, or some between [ and ]");
    if source.peek() != Some(b'[') {
        let token = source.next()?.ok_or_else(|| missing(parameter))?;
        return parameter.push(&token, source);
    }
    source.next()?;
    let mut count = 0_usize;
    loop {
        match source.next()? {
            None => {
                let problem = "has no `]` to the end of the file";
                return Err(parameter.error(problem, "end its values with ]"));
            }
            Some(Token::Close) => break,
            Some(token) => parameter.push(&token, source)?,
        }
        count += 1;
        // Before lists grow to twice their size.
        if count.is_power_of_two() {
            let now = parameter.bytes() + count * 4;
            if now > held {
                budget.hold(now - held).map_err(|e| excess(source, e))?;
                held = now;
            }
        }
    }
    let now = parameter.bytes();
    budget.release(held.saturating_sub(now));
    budget.hold(now.saturating_sub(held)).map_err(|e| excess(source, e))
}
