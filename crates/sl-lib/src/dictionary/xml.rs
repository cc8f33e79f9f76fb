// SPDX-License-Identifier: GPL-3.0-or-later
//! Reads XML into a tree: elements, attributes, text; comments, declarations and instructions are left out.
//! Source: XML 1.0; messages are worded as by pugixml, which OSL reads with. Text of white space only is left out, as there.
//! Invariants: no text makes it panic or recurse; a tree takes no more than a small multiple of its text.
//! Tests: `tests/dictionary.rs`.

/// A node of the tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Content {
    Element { name: String, attributes: Vec<(String, String)> },
    Text(String),
}

#[derive(Clone, Debug)]
pub(super) struct Node {
    pub(super) content: Content,
    /// The element around it; node 0, the document, is its own.
    pub(super) parent: usize,
    pub(super) children: Vec<usize>,
}

/// A document; node 0 is around all.
#[derive(Clone, Debug)]
pub(super) struct Document {
    pub(super) nodes: Vec<Node>,
}

/// Where and why a text is no XML.
pub(super) type Fault = (usize, &'static str);

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn eat(&mut self, token: &str) -> bool {
        let found = self.rest().starts_with(token);
        self.at += if found { token.len() } else { 0 };
        found
    }

    /// Reads up to a token and past it; returns the text before it.
    fn until(&mut self, token: &str, reason: &'static str) -> Result<&'a str, Fault> {
        let length = self.rest().find(token).ok_or((self.text.len(), reason))?;
        let found = &self.rest()[..length];
        self.at += length + token.len();
        Ok(found)
    }

    fn skip_space(&mut self) {
        self.at += self.rest().len() - self.rest().trim_start().len();
    }

    fn name(&mut self, reason: &'static str) -> Result<&'a str, Fault> {
        let is_end = |c: char| c.is_whitespace() || "<>/=\"'?!&".contains(c);
        let length = self.rest().find(is_end).unwrap_or(self.rest().len());
        if length == 0 {
            return Err((self.at, reason));
        }
        let name = &self.rest()[..length];
        self.at += length;
        Ok(name)
    }

    fn attribute(&mut self) -> Result<(String, String), Fault> {
        const REASON: &str = "Error parsing element attribute";
        let name = self.name(REASON)?;
        self.skip_space();
        if !self.eat("=") {
            return Err((self.at, REASON));
        }
        self.skip_space();
        let quote = if self.eat("\"") {
            "\""
        } else if self.eat("'") {
            "'"
        } else {
            return Err((self.at, REASON));
        };
        Ok((name.to_owned(), decoded(self.until(quote, REASON)?)))
    }

    /// A declaration of the document's type, with anything in its brackets.
    fn doctype(&mut self) -> Result<(), Fault> {
        let mut depth = 0_usize;
        for (i, c) in self.rest().char_indices() {
            match c {
                '[' => depth += 1,
                ']' => depth = depth.saturating_sub(1),
                '>' if depth == 0 => {
                    self.at += i + 1;
                    return Ok(());
                }
                _ => {}
            }
        }
        Err((self.text.len(), "Error parsing document type declaration"))
    }
}

/// Bytes of an entity with its signs before and after.
const LONGEST_ENTITY: usize = 32;

/// Text with its entities replaced; unknown ones stay.
fn decoded(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('&') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        // The search for the end of a name is limited: a text of only such signs would be searched to its end
        // for each.
        let end = rest.bytes().take(LONGEST_ENTITY).position(|byte| byte == b';');
        let known = end.and_then(|end| Some((entity(&rest[1..end])?, end)));
        if let Some((c, end)) = known {
            out.push(c);
            rest = &rest[end + 1..];
        } else {
            out.push('&');
            rest = &rest[1..];
        }
    }
    out + rest
}

fn entity(name: &str) -> Option<char> {
    match name {
        "lt" => Some('<'),
        "gt" => Some('>'),
        "amp" => Some('&'),
        "quot" => Some('"'),
        "apos" => Some('\''),
        _ => {
            let digits = name.strip_prefix('#')?;
            let hex = digits.strip_prefix('x').map(|digits| u32::from_str_radix(digits, 16));
            char::from_u32(hex.unwrap_or_else(|| digits.parse()).ok()?)
        }
    }
}

impl Document {
    /// Reads a document.
    pub(super) fn parse(text: &str) -> Result<Self, Fault> {
        let root = Content::Element { name: String::new(), attributes: vec![] };
        let mut document = Self { nodes: vec![Node { content: root, parent: 0, children: vec![] }] };
        let mut reader = Reader { text, at: 0 };
        let mut around = 0;
        reader.eat("\u{feff}");
        while !reader.rest().is_empty() {
            if reader.eat("<!--") {
                reader.until("-->", "Error parsing comment")?;
            } else if reader.eat("<![CDATA[") {
                let text = reader.until("]]>", "Error parsing CDATA section")?;
                document.add(around, Content::Text(text.to_owned()));
            } else if reader.eat("<!") {
                reader.doctype()?;
            } else if reader.eat("<?") {
                reader.until("?>", "Error parsing document declaration/processing instruction")?;
            } else if reader.eat("</") {
                let at = reader.at;
                let name = reader.name("Error parsing end element tag")?;
                let open = matches!(&document.nodes[around].content, Content::Element { name: open, .. } if open == name);
                if around == 0 || !open {
                    return Err((at, "Start-end tags mismatch"));
                }
                reader.skip_space();
                if !reader.eat(">") {
                    return Err((reader.at, "Error parsing end element tag"));
                }
                around = document.nodes[around].parent;
            } else if reader.eat("<") {
                let name = reader.name("Error parsing start element tag")?.to_owned();
                let mut attributes = Vec::new();
                let closed = loop {
                    reader.skip_space();
                    if reader.eat("/>") {
                        break true;
                    } else if reader.eat(">") {
                        break false;
                    } else if reader.rest().is_empty() {
                        return Err((reader.at, "Error parsing start element tag"));
                    }
                    attributes.push(reader.attribute()?);
                };
                let node = document.add(around, Content::Element { name, attributes });
                if !closed {
                    around = node;
                }
            } else {
                let length = reader.rest().find('<').unwrap_or(reader.rest().len());
                let text = &reader.rest()[..length];
                reader.at += length;
                // Text outside of all elements has no meaning.
                if around != 0 && !text.trim().is_empty() {
                    document.add(around, Content::Text(decoded(text)));
                }
            }
        }
        if around != 0 {
            return Err((text.len(), "Start-end tags mismatch"));
        }
        if document.nodes.len() == 1 {
            return Err((text.len(), "No document element found"));
        }
        Ok(document)
    }

    fn add(&mut self, parent: usize, content: Content) -> usize {
        self.nodes.push(Node { content, parent, children: vec![] });
        let node = self.nodes.len() - 1;
        self.nodes[parent].children.push(node);
        node
    }

    /// All text in a node.
    pub(super) fn text(&self, node: usize) -> String {
        let mut out = String::new();
        let mut open = vec![node];
        while let Some(node) = open.pop() {
            match &self.nodes[node].content {
                Content::Text(text) => out.push_str(text),
                Content::Element { .. } => open.extend(self.nodes[node].children.iter().rev()),
            }
        }
        out
    }

    pub(super) fn attribute(&self, node: usize, name: &str) -> Option<&str> {
        match &self.nodes[node].content {
            Content::Element { attributes, .. } => {
                attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
            }
            Content::Text(_) => None,
        }
    }
}
