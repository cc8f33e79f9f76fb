// SPDX-License-Identifier: GPL-3.0-or-later
//! Documents: a file and all that it includes, with namespaces, prefixes and inherited colour spaces.
//! Source: [MaterialX], "MaterialX XML", "Inclusion", "Namespaces". Tests: `tests/documents.rs`, `tests/hostile.rs`.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::error::Error;
use crate::xml::{Element, parse};

/// Files within files.
const DEEPEST: usize = 16;

/// Files of a document.
const MOST: usize = 256;

/// Bytes of a document.
const LONGEST: usize = 64 << 20;

/// The reader of a document's files.
pub type Load<'a> = dyn FnMut(&Path) -> Result<String, String> + 'a;

/// A file of a document.
#[derive(Debug)]
pub(crate) struct File {
    pub(crate) path: PathBuf,
    /// What its names begin with where other files use them.
    pub(crate) namespace: String,
}

/// A document.
#[derive(Debug)]
pub struct Document {
    pub(crate) files: Vec<File>,
    /// The elements of all roots.
    pub(crate) root: Element,
    by_name: HashMap<String, usize>,
    pub(crate) warnings: Vec<String>,
}

struct Opener<'a> {
    load: &'a mut Load<'a>,
    document: Document,
    open: Vec<PathBuf>,
    bytes: usize,
}

impl Document {
    /// Reads a file, and those that it includes.
    ///
    /// # Errors
    /// A file cannot be read, is no MaterialX, includes itself or is too large.
    pub fn open<'a>(path: &Path, load: &'a mut Load<'a>) -> Result<Self, Error> {
        let text = load(path).map_err(|why| Error::new(path, 0, why))?;
        Self::of_text(path, &text, load)
    }

    /// Reads a text as if a file of this name held it.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of_text<'a>(path: &Path, text: &str, load: &'a mut Load<'a>) -> Result<Self, Error> {
        let empty = || Self {
            files: Vec::new(),
            root: Element::default(),
            by_name: HashMap::new(),
            warnings: Vec::new(),
        };
        let mut opener = Opener { load, document: empty(), open: Vec::new(), bytes: 0 };
        opener.add(path, text, "")?;
        let mut document = opener.document;
        document.index();
        Ok(document)
    }

    fn index(&mut self) {
        for (i, element) in self.root.children.iter().enumerate() {
            let namespace = &self.files[element.file as usize].namespace;
            let name = match namespace.is_empty() {
                true => element.name().to_owned(),
                false => format!("{namespace}:{}", element.name()),
            };
            if !name.is_empty()
                && self.by_name.insert(name.clone(), i).is_some()
                && element.get("name").is_some()
            {
                let (path, line) = (self.files[element.file as usize].path.display(), element.line);
                self.warnings.push(format!("{path}:{line}: '{name}' is there twice, the last one counts"));
            }
        }
    }

    /// The names of all files, the document's own first.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.files.iter().map(|file| &*file.path)
    }

    /// An element of a root, as an element of the same document, or nothing, calls it.
    pub(crate) fn find(&self, name: &str, user: Option<&Element>) -> Option<&Element> {
        let namespace =
            user.and_then(|user| self.files.get(user.file as usize)).map_or("", |f| &*f.namespace);
        let own = (!namespace.is_empty()).then(|| self.by_name.get(&format!("{namespace}:{name}"))).flatten();
        own.or_else(|| self.by_name.get(name)).map(|i| &self.root.children[*i])
    }

    /// The name by which all files of the document may call an element of a root.
    pub(crate) fn full_name(&self, element: &Element) -> String {
        match self.files.get(element.file as usize).map_or("", |file| &*file.namespace) {
            "" => element.name().to_owned(),
            namespace => format!("{namespace}:{}", element.name()),
        }
    }

    /// A fault at an element.
    pub(crate) fn fault(&self, element: &Element, message: impl Into<String>) -> Error {
        let path = self.files.get(element.file as usize).map_or(Path::new(""), |file| &file.path);
        Error::new(path, element.line, message)
    }

    /// The names of its materials, in order.
    #[must_use]
    pub fn materials(&self) -> Vec<String> {
        let is_material = |element: &&Element| {
            *element.tag == *"material" || (element.ty() == "material" && *element.tag != *"nodedef")
        };
        self.root.children.iter().filter(is_material).map(|element| self.full_name(element)).collect()
    }

    /// Names of all that could be shown, materials apart: nodes and outputs of graphs.
    #[must_use]
    pub fn shown(&self) -> Vec<String> {
        let mut names = Vec::new();
        for element in &self.root.children {
            match &*element.tag {
                "nodegraph" if element.get("nodedef").is_none() => {
                    let name = self.full_name(element);
                    names.extend(element.all("output").map(|output| format!("{name}/{}", output.name())));
                }
                "nodegraph" | "nodedef" | "typedef" | "implementation" | "look" | "collection" | "token" => {}
                _ if !element.ty().is_empty() && element.ty() != "material" => {
                    names.push(self.full_name(element))
                }
                _ => {}
            }
        }
        names
    }
}

impl Opener<'_> {
    fn add(&mut self, path: &Path, text: &str, outer: &str) -> Result<(), Error> {
        let fault = |line, message: String| Error::new(path, line, message);
        self.bytes += text.len();
        if self.bytes > LONGEST {
            return Err(fault(0, format!("the document is longer than {} MiB", LONGEST >> 20)));
        }
        let number = self.document.files.len() as u32;
        let mut root = parse(text, number).map_err(|(line, why)| fault(line, why))?;
        if *root.tag != *"materialx" {
            return Err(fault(root.line, format!("<{}> is not <materialx>", root.tag)));
        }
        let version = root.given("version").unwrap_or("1.39");
        let parts: Vec<u32> = version.split('.').map_while(|part| part.parse().ok()).collect();
        match parts[..] {
            [1, 36..=39] => {}
            [1, _] | [_, _] => self.document.warnings.push(format!(
                "{}: MaterialX {version} is read as 1.39; known are 1.36 to 1.39",
                path.display()
            )),
            _ => return Err(fault(root.line, format!("'{version}' is not a version of MaterialX"))),
        }
        let namespace = root.given("namespace").unwrap_or(outer).to_owned();
        self.document.files.push(File { path: path.to_owned(), namespace: namespace.clone() });
        inherit(&mut root, None, &Arc::from(""));
        self.open.push(clean(path));
        for element in root.children {
            if &*element.tag != "xi:include" && &*element.tag != "include" {
                self.document.root.children.extend(with_shader(element));
                continue;
            }
            let href = element
                .given("href")
                .ok_or_else(|| fault(element.line, "xi:include names no file".into()))?;
            let target = path.parent().unwrap_or(Path::new("")).join(href);
            if self.open.contains(&clean(&target)) {
                return Err(fault(element.line, format!("'{href}' includes itself")));
            }
            if self.open.len() >= DEEPEST || self.document.files.len() >= MOST {
                let message = format!("files are included deeper than {DEEPEST}, or more than {MOST} files");
                return Err(fault(element.line, message));
            }
            let text = (self.load)(&target)
                .map_err(|why| fault(element.line, format!("xi:include of '{href}': {why}")))?;
            self.add(&target, &text, &namespace)?;
        }
        self.open.pop();
        Ok(())
    }
}

/// A path without `.` and, where that is safe, `..`.
fn clean(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(clean.components().next_back(), Some(Component::Normal(_))) => {
                clean.pop();
            }
            part => clean.push(part),
        }
    }
    clean
}

/// A material as versions until 1.37 have it, with its shader within, as nodes.
fn with_shader(mut material: Element) -> Vec<Element> {
    if &*material.tag != "material" {
        return vec![material];
    }
    material.tag = "surfacematerial".into();
    let attribute = |name: &str, value: &str| (Box::from(name), Box::from(value));
    let name = format!("{}_shader", material.name());
    let mut parts = std::mem::take(&mut material.children).into_iter();
    let shader = parts.find(|part| &*part.tag == "shaderref").map(|mut shader| {
        shader.tag = shader.get("node").unwrap_or("node").into();
        shader.attributes.retain(|(key, _)| matches!(&**key, "nodedef" | "version"));
        shader.attributes.extend([attribute("name", &name), attribute("type", "surfaceshader")]);
        for input in &mut shader.children {
            input.tag = "input".into();
        }
        let attributes = vec![
            attribute("name", "surfaceshader"),
            attribute("type", "surfaceshader"),
            attribute("nodename", &name),
        ];
        let (tag, line, file) = ("input".into(), shader.line, shader.file);
        material.children.push(Element { tag, attributes, line, file, ..Element::default() });
        shader
    });
    material.attributes.push(attribute("type", "material"));
    std::iter::once(material).chain(shader).collect()
}

/// Hands colour spaces and prefixes of files down; XML's depth is limited.
pub(crate) fn inherit(element: &mut Element, color_space: Option<&Arc<str>>, file_prefix: &Arc<str>) {
    if &*element.tag == "parameter" {
        // Its name until 1.36.
        element.tag = "input".into();
    }
    element.color_space = element.given("colorspace").map(Arc::from).or_else(|| color_space.cloned());
    element.file_prefix = match element.given("fileprefix") {
        // Prefixes add up from the outside to the inside.
        Some(prefix) => format!("{file_prefix}{prefix}").into(),
        None => file_prefix.clone(),
    };
    let (color_space, file_prefix) = (element.color_space.clone(), element.file_prefix.clone());
    for child in &mut element.children {
        inherit(child, color_space.as_ref(), &file_prefix);
    }
}
