// SPDX-License-Identifier: GPL-3.0-or-later
//! Declarations: shaders, functions, structs, variables and metadata.
//! The grammar is OSL's.

use super::reader::{Parse, Parsed, Parser};
use crate::ast::{
    Declarator, Expr, Function, Item, Metadatum, Parameter, Shader, StructDecl, TypeName, TypeRef,
};
use crate::token::Tok;
use crate::types::Base;

/// Types of shaders; the last four are not OSL's.
const KINDS: [&str; 8] =
    ["shader", "surface", "displacement", "volume", "light", "camera", "environment", "pixel"];
const OF_OSL: usize = 4;

impl Parser {
    /// Reads a whole file.
    #[must_use]
    pub fn file(mut self) -> Parsed {
        while self.peek().tok != Tok::End {
            match self.item() {
                Ok(item) => self.out.items.push(item),
                Err(_) => break,
            }
        }
        self.out
    }

    fn item(&mut self) -> Parse<Item> {
        if self.take_keyword("struct") {
            return Ok(Item::Struct(self.structure()?));
        }
        let kind = self.peek().ident().filter(|n| self.is_kind(n)).cloned();
        let ty = self.type_ref()?;
        let function = self.function(ty)?;
        Ok(match kind {
            Some(kind) => Item::Shader(Shader { kind, function }),
            None => Item::Function(function),
        })
    }

    /// Whether it is a type of shader here: the words that OSL does not have may name structs.
    fn is_kind(&self, name: &str) -> bool {
        let is_struct =
            || self.out.items.iter().any(|item| matches!(item, Item::Struct(s) if *s.name == *name));
        match KINDS.iter().position(|kind| *kind == name) {
            Some(number) => number < OF_OSL || !self.strict && !is_struct(),
            None => false,
        }
    }

    /// A type.
    pub(super) fn type_ref(&mut self) -> Parse<TypeRef> {
        let loc = self.loc();
        if self.take_keyword("closure") {
            return match self.peek().ident().and_then(|n| Base::from_keyword(n)) {
                Some(_) => {
                    self.next();
                    Ok(TypeRef { keyword: TypeName::Closure, loc })
                }
                None => Err(self.syntax("'color' after 'closure'")),
            };
        }
        if let Some(base) = self.peek().ident().and_then(|n| Base::from_keyword(n)) {
            self.next();
            return Ok(TypeRef { keyword: TypeName::Simple(base), loc });
        }
        if !self.is_name(0) {
            return Err(self.syntax("a type"));
        }
        let (name, loc) = self.name()?;
        Ok(TypeRef { keyword: TypeName::Named(name), loc })
    }

    /// A function or shader after its type.
    pub(super) fn function(&mut self, returns: TypeRef) -> Parse<Function> {
        let (name, loc) = self.name()?;
        let mut metadata = self.metadata()?;
        self.expect("(")?;
        let mut parameters = Vec::new();
        while !self.is(")") {
            parameters.push(self.parameter()?);
            if !self.take(",") {
                break;
            }
            // OSL takes more than one.
            while self.take(",") {}
        }
        self.expect(")")?;
        metadata.extend(self.metadata()?);
        let body = if self.take(";") {
            None
        } else {
            self.expect("{")?;
            Some(self.statements()?)
        };
        Ok(Function { returns, name, loc, parameters, metadata, body })
    }

    fn parameter(&mut self) -> Parse<Parameter> {
        let output = self.take_keyword("output");
        let ty = self.type_ref()?;
        let declarator = self.declarator()?;
        let metadata = self.metadata()?;
        Ok(Parameter { output, ty, declarator, metadata })
    }

    fn array_length(&mut self) -> Parse<Option<i32>> {
        if !self.take("[") {
            return Ok(None);
        }
        if self.take("]") {
            return Ok(Some(-1));
        }
        let Tok::Int(text) = self.peek().tok.clone() else { return Err(self.syntax("a length")) };
        let loc = self.next().loc;
        let length = text.parse::<i32>().unwrap_or(0);
        if length < 1 {
            self.error(loc, format!("Invalid array length ({length})"));
        }
        self.expect("]")?;
        Ok(Some(length))
    }

    fn declarator(&mut self) -> Parse<Declarator> {
        let (name, loc) = self.name()?;
        let array = self.array_length()?;
        let init = if self.take("=") { Some(self.initial(array.is_some())?) } else { None };
        Ok(Declarator { name, loc, array, init })
    }

    fn initial(&mut self, array: bool) -> Parse<Expr> {
        if array && !self.is("{") {
            return Err(self.syntax("'{' and the array's values"));
        }
        self.expression_or_braces()
    }

    /// Variables up to a semicolon, which is taken.
    pub(super) fn declarators(&mut self) -> Parse<Vec<Declarator>> {
        let mut list = vec![self.declarator()?];
        while self.take(",") {
            list.push(self.declarator()?);
        }
        self.expect(";")?;
        Ok(list)
    }

    fn structure(&mut self) -> Parse<StructDecl> {
        let (name, loc) = self.name()?;
        self.expect("{")?;
        let mut fields = Vec::new();
        while !self.take("}") {
            let ty = self.type_ref()?;
            loop {
                let (name, loc) = self.name()?;
                let array = self.array_length()?;
                fields.push((ty.clone(), Declarator { name, loc, array, init: None }));
                if !self.take(",") {
                    break;
                }
            }
            self.expect(";")?;
        }
        self.expect(";")?;
        Ok(StructDecl { name, loc, fields })
    }

    fn metadata(&mut self) -> Parse<Vec<Metadatum>> {
        let mut list = Vec::new();
        if !self.take("[[") {
            return Ok(list);
        }
        while !self.is("]") {
            let Some(base) = self.peek().ident().and_then(|n| Base::from_keyword(n)) else {
                return Err(self.syntax("a type"));
            };
            self.next();
            let declarator = self.declarator()?;
            if declarator.init.is_none() {
                return Err(self.syntax("'=' and a value"));
            }
            list.push(Metadatum { base, declarator });
            if !self.take(",") {
                break;
            }
        }
        self.expect("]")?;
        self.expect("]")?;
        Ok(list)
    }
}
