// SPDX-License-Identifier: GPL-3.0-or-later
//! Queries of documents: the part of `XPath` 1.0 that dictionaries support.
//! Source: `XPath` 1.0, abbreviated syntax: `/`, `//`, `|`, names, `*`, `.`, `..`, `text()`, `node()`, and in brackets a number, `last()`,
//! `@name`, a child's name or `text()`, alone or with `=` or `!=` and a string, joined by `and` and `or`. No other functions and axes.
//! Tests: `tests/dictionary.rs`.

use std::collections::BTreeSet;

use super::xml::{Content, Document};

#[derive(Debug)]
enum Test {
    Name(String),
    Any,
    Text,
    Node,
    Here,
    Parent,
}

/// A condition in brackets.
#[derive(Debug)]
enum Condition {
    Position(usize),
    Last,
    /// One of these groups, of which all must hold.
    OneOf(Vec<Vec<Comparison>>),
}

#[derive(Debug)]
enum Operand {
    Attribute(String),
    Child(String),
    Text,
}

#[derive(Debug)]
struct Comparison {
    operand: Operand,
    /// Whether it must be equal or must not, and the text to compare; `None` requires only presence.
    to: Option<(bool, String)>,
}

#[derive(Debug)]
struct Step {
    /// Whether it searches all descendants, too.
    deep: bool,
    test: Test,
    conditions: Vec<Condition>,
}

#[derive(Debug)]
struct Axis {
    absolute: bool,
    steps: Vec<Step>,
}

/// A query that was read.
#[derive(Debug)]
pub(super) struct Query(Vec<Axis>);

struct Reader<'a>(&'a str);

impl<'a> Reader<'a> {
    fn eat(&mut self, token: &str) -> bool {
        self.0 = self.0.trim_start();
        let after = self.0.strip_prefix(token);
        self.0 = after.unwrap_or(self.0);
        after.is_some()
    }

    fn next_name(&mut self) -> Option<&'a str> {
        self.0 = self.0.trim_start();
        let is_end = |c: char| c.is_whitespace() || "/[]()|@=!'\"<>,$*+".contains(c);
        let length = self.0.find(is_end).unwrap_or(self.0.len());
        let (next_name, rest) = self.0.split_at(length);
        self.0 = rest;
        (length > 0).then_some(next_name)
    }

    fn axis(&mut self) -> Option<Axis> {
        let mut deep = self.eat("//");
        let absolute = deep || self.eat("/");
        let mut steps = Vec::new();
        self.0 = self.0.trim_start();
        if absolute && !deep && (self.0.is_empty() || self.0.starts_with('|')) {
            return Some(Axis { absolute, steps });
        }
        loop {
            let test = if self.eat("..") {
                Test::Parent
            } else if self.eat("*") {
                Test::Any
            } else {
                match self.next_name()? {
                    "." => Test::Here,
                    "text" if self.eat("(") => self.eat(")").then_some(Test::Text)?,
                    "node" if self.eat("(") => self.eat(")").then_some(Test::Node)?,
                    name => Test::Name(name.to_owned()),
                }
            };
            let mut conditions = Vec::new();
            while self.eat("[") {
                conditions.push(self.condition()?);
                self.eat("]").then_some(())?;
            }
            steps.push(Step { deep, test, conditions });
            deep = self.eat("//");
            if !deep && !self.eat("/") {
                return Some(Axis { absolute, steps });
            }
        }
    }

    fn condition(&mut self) -> Option<Condition> {
        self.0 = self.0.trim_start();
        if self.0.starts_with(|c: char| c.is_ascii_digit()) {
            return Some(Condition::Position(self.next_name()?.parse().ok()?));
        }
        if self.eat("last()") {
            return Some(Condition::Last);
        }
        let mut groups = vec![vec![self.comparison()?]];
        loop {
            if self.eat("and ") {
                let comparison = self.comparison()?;
                groups.last_mut()?.push(comparison);
            } else if self.eat("or ") {
                groups.push(vec![self.comparison()?]);
            } else {
                return Some(Condition::OneOf(groups));
            }
        }
    }

    fn comparison(&mut self) -> Option<Comparison> {
        let operand = if self.eat("@") {
            Operand::Attribute(self.next_name()?.to_owned())
        } else if self.eat("text()") || self.eat(".") {
            Operand::Text
        } else {
            Operand::Child(self.next_name()?.to_owned())
        };
        let equal = if self.eat("!=") {
            false
        } else if self.eat("=") {
            true
        } else {
            return Some(Comparison { operand, to: None });
        };
        let quote = if self.eat("'") { '\'' } else { self.eat("\"").then_some('"')? };
        let (value, rest) = self.0.split_once(quote)?;
        self.0 = rest;
        Some(Comparison { operand, to: Some((equal, value.to_owned())) })
    }
}

impl Comparison {
    fn holds(&self, document: &Document, node: usize) -> bool {
        let satisfies = |value: &str| self.to.as_ref().is_none_or(|(equal, to)| (value == to) == *equal);
        match &self.operand {
            Operand::Attribute(name) => document.attribute(node, name).is_some_and(satisfies),
            Operand::Text => satisfies(&document.text(node)),
            Operand::Child(name) => document.nodes[node].children.iter().any(|&child| {
                matches!(&document.nodes[child].content, Content::Element { name: known, .. } if known == name)
                    && (self.to.is_none() || satisfies(&document.text(child)))
            }),
        }
    }
}

impl Step {
    /// The nodes that a step leads to from one, in the document's order.
    fn from(&self, document: &Document, node: usize) -> Vec<usize> {
        let candidates = match self.test {
            Test::Here => vec![node],
            Test::Parent if node == 0 => vec![],
            Test::Parent => vec![document.nodes[node].parent],
            _ => document.nodes[node].children.clone(),
        };
        let satisfies = |&node: &usize| match (&self.test, &document.nodes[node].content) {
            (Test::Name(expected), Content::Element { name, .. }) => expected == name,
            (Test::Any, Content::Element { .. }) | (Test::Text, Content::Text(_)) => true,
            (Test::Node | Test::Here | Test::Parent, _) => true,
            _ => false,
        };
        let mut found: Vec<usize> = candidates.into_iter().filter(satisfies).collect();
        for condition in &self.conditions {
            found = match condition {
                Condition::Position(position) => {
                    position.checked_sub(1).and_then(|i| found.get(i)).into_iter().copied().collect()
                }
                Condition::Last => found.last().into_iter().copied().collect(),
                Condition::OneOf(groups) => {
                    let holds =
                        |&node: &usize| groups.iter().any(|all| all.iter().all(|c| c.holds(document, node)));
                    found.into_iter().filter(holds).collect()
                }
            };
        }
        found
    }
}

/// Nodes and all that is below them, each once.
fn below(document: &Document, nodes: &BTreeSet<usize>) -> BTreeSet<usize> {
    let mut all = BTreeSet::new();
    let mut open: Vec<usize> = nodes.iter().copied().collect();
    while let Some(node) = open.pop() {
        if all.insert(node) {
            open.extend(&document.nodes[node].children);
        }
    }
    all
}

impl Query {
    /// Reads a query; `None` if it is none that is known.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut reader = Reader(text);
        let mut axes = vec![reader.axis()?];
        while reader.eat("|") {
            axes.push(reader.axis()?);
        }
        reader.0.trim().is_empty().then_some(Self(axes))
    }

    /// The nodes that it finds from one on, in the document's order, each once. Nodes are numbered in that order.
    pub(super) fn run(&self, document: &Document, from: usize) -> Vec<usize> {
        let mut all = BTreeSet::new();
        for axis in &self.0 {
            let mut here = BTreeSet::from([if axis.absolute { 0 } else { from }]);
            for step in &axis.steps {
                if step.deep {
                    here = below(document, &here);
                }
                here = here.into_iter().flat_map(|node| step.from(document, node)).collect();
            }
            all.append(&mut here);
        }
        all.into_iter().collect()
    }
}
