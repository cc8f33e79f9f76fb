// SPDX-License-Identifier: GPL-3.0-or-later
//! Dictionaries in XML: `dict_find`, `dict_next` and `dict_value`.
//! Source: the OSL 1.14 language reference, "Dictionary lookups". Nodes are numbers above 0, good as long as the
//! dictionaries are; documents and queries are read once.
//! Tests: `tests/dictionary.rs`.

use std::collections::HashMap;

use super::path::Query;
use super::xml::{Content, Document};

/// Limits of stored documents and nodes; further ones are not found.
const DOCUMENTS: usize = 1 << 10;
const NODES: usize = 1 << 20;

/// All documents that were queried, and the nodes that were found.
#[derive(Debug, Default)]
pub struct Dictionaries {
    documents: Vec<Document>,
    /// By name or text; `None` where it could not be read, which is reported once.
    by_name: HashMap<String, Option<usize>>,
    found: Vec<Found>,
    /// The first node of each query: document, node of the document, text.
    cache: HashMap<(usize, usize, String), i32>,
}

#[derive(Clone, Copy, Debug)]
struct Found {
    document: usize,
    node: usize,
    /// The next one of the same query.
    next: i32,
}

/// A failure to read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DictionaryError {
    /// A document.
    Document {
        /// Why.
        reason: &'static str,
        /// At which byte.
        at: usize,
    },
    /// A query.
    Query(String),
}

impl DictionaryError {
    /// The result of `dict_find` in this case.
    #[must_use]
    pub fn result(&self) -> i32 {
        if matches!(self, Self::Document { .. }) { -1 } else { 0 }
    }
}

impl std::fmt::Display for DictionaryError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Document { reason, at } => write!(f, "XML parsed with errors: {reason}, at offset {at}"),
            Self::Query(query) => write!(
                f,
                "Invalid dict_find query '{query}': a path of names is expected, as \"//node[@name='x']/child\""
            ),
        }
    }
}

impl std::error::Error for DictionaryError {}

impl Dictionaries {
    /// `dict_find(dictionary, query)`: the first node that a query finds, 0 if there is none, -1 in a dictionary that could not be
    /// read. A name that ends in `.xml` is that of a file, which `load` reads; any other is the XML itself.
    ///
    /// # Errors
    /// If the dictionary or the query cannot be read; a dictionary is complained about once.
    pub fn find(
        &mut self,
        dictionary: &str,
        query: &str,
        load: impl FnOnce(&str) -> Option<String>,
    ) -> Result<i32, DictionaryError> {
        if !self.by_name.contains_key(dictionary) {
            if self.by_name.len() >= DOCUMENTS {
                return Ok(-1);
            }
            self.by_name.insert(dictionary.to_owned(), None);
            let missing = DictionaryError::Document { reason: "File was not found", at: 0 };
            let file =
                if dictionary.ends_with(".xml") { Some(load(dictionary).ok_or(missing)?) } else { None };
            let document = Document::parse(file.as_deref().unwrap_or(dictionary))
                .map_err(|(at, reason)| DictionaryError::Document { reason, at })?;
            self.documents.push(document);
            self.by_name.insert(dictionary.to_owned(), Some(self.documents.len() - 1));
        }
        match self.by_name.get(dictionary) {
            Some(Some(document)) => self.ask(*document, 0, query),
            _ => Ok(-1),
        }
    }

    /// `dict_find(node, query)`: the same from a node on; 0 where there is no such node.
    ///
    /// # Errors
    /// If the query cannot be read.
    pub fn find_from(&mut self, node: i32, query: &str) -> Result<i32, DictionaryError> {
        match self.found(node) {
            Some(Found { document, node, .. }) => self.ask(document, node, query),
            None => Ok(0),
        }
    }

    fn ask(&mut self, document: usize, node: usize, query: &str) -> Result<i32, DictionaryError> {
        let key = (document, node, query.to_owned());
        if let Some(first) = self.cache.get(&key) {
            return Ok(*first);
        }
        if self.found.len() >= NODES {
            return Ok(0);
        }
        let read = Query::parse(query).ok_or_else(|| DictionaryError::Query(query.to_owned()))?;
        let nodes = read.run(&self.documents[document], node);
        let first = if nodes.is_empty() { 0 } else { self.found.len() as i32 + 1 };
        for (i, node) in nodes.iter().enumerate() {
            let next = if i + 1 < nodes.len() { first + i as i32 + 1 } else { 0 };
            self.found.push(Found { document, node: *node, next });
        }
        self.cache.insert(key, first);
        Ok(first)
    }

    fn found(&self, node: i32) -> Option<Found> {
        self.found.get(usize::try_from(node).ok()?.checked_sub(1)?).copied()
    }

    /// `dict_next`: the next node of the query that found this one; 0 behind the last one.
    #[must_use]
    pub fn next(&self, node: i32) -> i32 {
        self.found(node).map_or(0, |found| found.next)
    }

    /// `dict_value` as text: an attribute's, or, of the empty name, the text of a node that is text.
    #[must_use]
    pub fn value(&self, node: i32, attribute: &str) -> Option<&str> {
        let Found { document, node, .. } = self.found(node)?;
        let document = &self.documents[document];
        if !attribute.is_empty() {
            return document.attribute(node, attribute);
        }
        match &document.nodes[node].content {
            Content::Text(text) => Some(text),
            Content::Element { .. } => Some(""),
        }
    }
}

/// `dict_value` as numbers: those that a text holds, with white space or a comma between; zeros where it ends early.
pub fn numbers<T: Default>(text: &str, out: &mut [T], read: impl Fn(&str) -> T) {
    let mut parts = text.split(|c: char| c == ',' || c.is_ascii_whitespace()).filter(|part| !part.is_empty());
    for x in out {
        *x = parts.next().map_or_else(T::default, &read);
    }
}
