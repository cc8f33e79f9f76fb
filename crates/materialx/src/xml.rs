// SPDX-License-Identifier: GPL-3.0-or-later
//! The elements of an XML file: names, attributes and children, with lines. Comments, texts and declarations are skipped;
//! entities other than XML's own five are errors, so that nothing expands.
//! Source: [MaterialX], "MaterialX XML". Tests: `tests/hostile.rs`.

use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Elements within elements. MaterialX has four levels.
const DEEPEST: usize = 64;

/// Elements of a file.
const MOST: usize = 1 << 18;

/// An element.
#[derive(Debug, Default)]
pub(crate) struct Element {
    pub(crate) tag: Box<str>,
    pub(crate) attributes: Vec<(Box<str>, Box<str>)>,
    pub(crate) children: Vec<Element>,
    pub(crate) line: u32,
    /// The number of its file in the document.
    pub(crate) file: u32,
    /// The colour space of its values, its own or inherited.
    pub(crate) color_space: Option<Arc<str>>,
    /// All prefixes of file names from the root to here.
    pub(crate) file_prefix: Arc<str>,
}

impl Element {
    /// An attribute.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| **known == *name).map(|(_, value)| &**value)
    }

    /// An attribute, unless it is empty.
    pub(crate) fn given(&self, name: &str) -> Option<&str> {
        self.get(name).filter(|value| !value.is_empty())
    }

    pub(crate) fn name(&self) -> &str {
        self.get("name").unwrap_or("")
    }

    /// The type of a node, an input or an output.
    pub(crate) fn ty(&self) -> &str {
        self.get("type").unwrap_or("")
    }

    pub(crate) fn all<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |child| *child.tag == *tag)
    }

    /// The child with this tag and name.
    pub(crate) fn child(&self, tag: &str, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| *child.tag == *tag && child.name() == name)
    }
}

/// The line, and the fault.
pub(crate) type Fault = (u32, String);

/// The root of a text.
pub(crate) fn parse(text: &str, file: u32) -> Result<Element, Fault> {
    let mut reader = Reader::from_str(text);
    let (mut line, mut counted) = (1, 0);
    let mut open: Vec<Element> = Vec::new();
    let (mut root, mut count) = (None, 0);
    loop {
        let event = reader.read_event();
        // Events that failed are where the reader says.
        let at = match &event {
            Err(_) => reader.error_position(),
            Ok(_) => reader.buffer_position(),
        };
        let at = usize::try_from(at).unwrap_or(usize::MAX).min(text.len());
        let start = line;
        let passed = text.as_bytes().get(counted..at).unwrap_or_default();
        line += passed.iter().filter(|byte| **byte == b'\n').count() as u32;
        counted = counted.max(at);
        let mut added = |element: Element, open: &mut Vec<Element>| match open.last_mut() {
            Some(parent) => {
                parent.children.push(element);
                Ok(())
            }
            None if root.is_some() => Err((start, "a second root element".to_owned())),
            None => {
                root = Some(element);
                Ok(())
            }
        };
        match event.map_err(|error| (line, error.to_string()))? {
            Event::Start(tag) => {
                if open.len() >= DEEPEST {
                    return Err((line, format!("elements are nested deeper than {DEEPEST}")));
                }
                open.push(element(&tag, file, line)?);
                count += 1;
            }
            Event::Empty(tag) => {
                added(element(&tag, file, line)?, &mut open)?;
                count += 1;
            }
            Event::End(_) => {
                let Some(element) = open.pop() else { return Err((line, "an end without a start".into())) };
                added(element, &mut open)?;
            }
            Event::Eof => break,
            _ => {}
        }
        if count > MOST {
            return Err((line, format!("more than {MOST} elements")));
        }
    }
    if let Some(element) = open.last() {
        return Err((element.line, format!("<{}> is not closed", element.tag)));
    }
    root.ok_or_else(|| (1, "no element is in it".to_owned()))
}

fn element(tag: &BytesStart, file: u32, line: u32) -> Result<Element, Fault> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned().into_boxed_str();
    let mut attributes = Vec::new();
    for attribute in tag.attributes() {
        let attribute = attribute.map_err(|error| (line, error.to_string()))?;
        let value = std::str::from_utf8(&attribute.value).map_err(|error| (line, error.to_string()))?;
        let value = quick_xml::escape::unescape(value).map_err(|error| (line, error.to_string()))?;
        attributes.push((text(attribute.key.as_ref()), value.into_owned().into_boxed_str()));
    }
    let tag = text(tag.name().as_ref());
    Ok(Element { tag, attributes, line, file, ..Element::default() })
}
