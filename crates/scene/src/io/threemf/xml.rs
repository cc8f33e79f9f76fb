// SPDX-License-Identifier: GPL-3.0-or-later
//! Elements of XML one after the other, without a tree.
//! Source: W3C, Extensible Markup Language 1.0, as far as 3MF uses it: prefixes of names are dropped, text
//! between elements is skipped, only the five built-in entities are replaced. Tests: `tests`.

/// An opening, closing or empty element.
#[derive(Debug, PartialEq)]
pub(super) struct Element<'a> {
    /// Its name without the prefix.
    pub(super) name: &'a str,
    /// Whether it opens; an element without contents opens and closes.
    pub(super) opens: bool,
    pub(super) closes: bool,
    attributes: &'a str,
}

impl<'a> Element<'a> {
    /// An attribute by its name without the prefix, as it is written.
    pub(super) fn get(&self, name: &str) -> Option<&'a str> {
        let mut rest = self.attributes;
        while let Some((key, after)) = rest.split_once('=') {
            let after = after.trim_start();
            let quote = after.chars().next().filter(|c| "\"'".contains(*c))?;
            let (value, behind) = after[1..].split_once(quote)?;
            if local(key.trim()) == name {
                return Some(value);
            }
            rest = behind;
        }
        None
    }
}

/// A value with its entities replaced.
pub(super) fn plain(value: &str) -> String {
    let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    entities.iter().fold(value.to_owned(), |text, (from, to)| text.replace(from, to))
}

fn local(name: &str) -> &str {
    name.rsplit(':').next().unwrap_or(name)
}

/// The elements of a text, and the line of the current one.
pub(super) struct Elements<'a> {
    text: &'a str,
    at: usize,
    /// Up to here lines were counted.
    counted: usize,
    line: u64,
}

impl<'a> Elements<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { text, at: 0, counted: 0, line: 1 }
    }

    /// The line of the last element.
    pub(super) fn line(&mut self) -> u64 {
        let new = &self.text.as_bytes()[self.counted..self.at];
        self.line += new.iter().filter(|&&b| b == b'\n').count() as u64;
        self.counted = self.at;
        self.line
    }

    /// The next element; the error is a broken one.
    pub(super) fn next(&mut self) -> Result<Option<Element<'a>>, &'static str> {
        loop {
            let Some(start) = self.text[self.at..].find('<') else { return Ok(None) };
            let from = self.at + start;
            let rest = &self.text[from..];
            let special = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")];
            if let Some((_, end)) = special.iter().find(|(begin, _)| rest.starts_with(begin)) {
                let length = rest.find(end).ok_or("comment or declaration without an end")?;
                self.at = from + length + end.len();
                continue;
            }
            let length = end_of(rest).ok_or("element without an end")?;
            self.at = from + length + 1;
            let inner = &rest[1..length];
            let (closing, inner) = inner.strip_prefix('/').map_or((false, inner), |inner| (true, inner));
            let (empty, inner) = inner.strip_suffix('/').map_or((false, inner), |inner| (true, inner));
            let (name, attributes) = inner.split_once(char::is_whitespace).unwrap_or((inner, ""));
            let closes = closing || empty;
            return Ok(Some(Element { name: local(name), opens: !closing, closes, attributes }));
        }
    }
}

/// Where the `>` is that ends an element; those in quotes do not.
fn end_of(text: &str) -> Option<usize> {
    let mut quote = None;
    for (at, byte) in text.bytes().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(at),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_follow_each_other() {
        let text = "<?xml version='1.0'?>\n<!-- <no> -->\n<a:b x=\"1>2\" p:y = '3'>t<c/>\n</a:b>";
        let mut elements = Elements::new(text);
        let b = elements.next().expect("no fault").expect("an element");
        assert_eq!(
            (b.name, b.opens, b.closes, b.get("x"), b.get("y")),
            ("b", true, false, Some("1>2"), Some("3"))
        );
        assert_eq!(elements.line(), 3, "its line");
        let c = elements.next().expect("no fault").expect("an element");
        assert_eq!((c.name, c.opens, c.closes, c.get("z")), ("c", true, true, None), "an empty one");
        let end = elements.next().expect("no fault").expect("an element");
        assert_eq!((end.name, end.opens, end.closes), ("b", false, true), "its end");
        assert_eq!(elements.next(), Ok(None), "nothing else");
        assert_eq!(plain("a&amp;lt;&lt;"), "a&lt;<", "entities");
        assert!(Elements::new("<a").next().is_err() && Elements::new("<!--").next().is_err(), "no ends");
    }
}
