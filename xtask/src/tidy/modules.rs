// SPDX-License-Identifier: GPL-3.0-or-later
//! The files of a crate and which of them imports which. Tests: the tests of `circles`.
//!
//! A file imports another if it names an item that is written there, wherever it gets the name from: a path that goes
//! through a list (`pub use`) leads to the file behind it. So a `mod.rs` that only declares and reexports is
//! on no path, and one with its own items is a file like all others: a child that names such an item imports
//! it.

use std::collections::BTreeMap;

use super::imports::Imports;

/// A crate's files; the first is its root.
pub(super) struct Crate {
    files: Vec<File>,
}

struct File {
    path: String,
    parent: Option<usize>,
    children: BTreeMap<String, usize>,
    read: Imports,
}

/// The target of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    /// A module that has a file.
    Module(usize),
    /// Something written in a file.
    Item(usize),
    /// Of another crate.
    Elsewhere,
}

/// Lists that pass names on to each other end somewhere.
const MOST_STEPS: usize = 32;

impl Crate {
    /// The files that are reached from `root` by `mod`; `code` gives the code of a path, if there is such a file.
    pub(super) fn load<'a>(root: &str, code: &impl Fn(&str) -> Option<&'a str>) -> Self {
        let mut found = Self { files: Vec::new() };
        found.add(root, None, code);
        found
    }

    fn add<'a>(
        &mut self,
        path: &str,
        parent: Option<usize>,
        code: &impl Fn(&str) -> Option<&'a str>,
    ) -> Option<usize> {
        let read = Imports::of(code(path)?);
        let modules = read.modules.clone();
        let this = self.files.len();
        self.files.push(File { path: path.into(), parent, children: BTreeMap::new(), read });
        let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
        let is_list = parent.is_none() || name == "mod.rs";
        let below =
            if is_list { folder.into() } else { format!("{folder}/{}", name.trim_end_matches(".rs")) };
        for module in modules {
            let chains = [format!("{below}/{module}.rs"), format!("{below}/{module}/mod.rs")];
            if let Some(child) = chains.iter().find_map(|chain| self.add(chain, Some(this), code)) {
                self.files[this].children.insert(module, child);
            }
        }
        Some(this)
    }

    /// Paths of the files, by their numbers.
    pub(super) fn path(&self, file: usize) -> &str {
        &self.files[file].path
    }

    /// For each file its imports, with the line of the first.
    pub(super) fn imports(&self) -> Vec<BTreeMap<usize, usize>> {
        (0..self.files.len()).map(|file| self.imports_of(file)).collect()
    }

    fn imports_of(&self, file: usize) -> BTreeMap<usize, usize> {
        let read = &self.files[file].read;
        let mut found: BTreeMap<usize, usize> = BTreeMap::new();
        let mut note = |to: usize, line: usize| {
            if to != file {
                let first = found.entry(to).or_insert(line);
                *first = line.min(*first);
            }
        };
        for import in &read.imports {
            let target = self.resolve(file, &import.within, &import.path, 0);
            match (&import.name, target) {
                // A re-export is no use here.
                (Some(name), Target::Item(to)) if !import.is_public || read.names.contains(name) => {
                    note(to, import.line);
                }
                (None, Target::Item(to)) => note(to, import.line),
                (None, Target::Module(to)) => {
                    let names = self.names(to);
                    // A glob imports everything: its uses can be found only where the names are known.
                    let used = read.names.iter().filter(|used| names.contains(used));
                    for used in used {
                        if let Target::Item(to) = self.walk(to, &[used], 0) {
                            note(to, import.line);
                        }
                    }
                }
                _ => {}
            }
        }
        for mention in &read.mentions {
            if let Target::Item(to) = self.resolve(file, &mention.within, &mention.path, 0) {
                note(to, mention.line);
            }
        }
        for (line, name) in &read.macro_calls {
            let known =
                read.macros.contains(name) || read.imports.iter().any(|i| i.name.as_ref() == Some(name));
            let parent_folder = self.files.iter().position(|other| other.read.macros.contains(name));
            if let Some(parent_folder) = parent_folder.filter(|_| !known) {
                note(parent_folder, *line);
            }
        }
        found
    }

    /// All names that a file has for others.
    fn names(&self, file: usize) -> Vec<&String> {
        let mut names = Vec::new();
        let mut visited = vec![false; self.files.len()];
        let mut todo = vec![file];
        while let Some(file) = todo.pop() {
            if std::mem::replace(&mut visited[file], true) {
                continue;
            }
            let read = &self.files[file].read;
            names.extend(&read.defined);
            names.extend(read.imports.iter().filter_map(|import| import.name.as_ref()));
            let stars = read.imports.iter().filter(|import| import.name.is_none());
            todo.extend(stars.filter_map(|star| match self.resolve(file, &star.within, &star.path, 0) {
                Target::Module(to) | Target::Item(to) => Some(to),
                Target::Elsewhere => None,
            }));
        }
        names
    }

    /// Follows a path that is written in a file, within modules of that file.
    fn resolve(&self, file: usize, within: &[String], path: &[String], steps: usize) -> Target {
        if steps > MOST_STEPS {
            return Target::Elsewhere;
        }
        let (mut at, mut within, mut rest) = (file, within, path);
        let mut anchored = false;
        while let Some((first, after)) = rest.split_first() {
            match &first[..] {
                "crate" => {
                    (at, within) = (0, &[]);
                }
                "self" => {}
                "super" => {
                    if let Some((_, around)) = within.split_last() {
                        within = around;
                    } else {
                        at = self.files[at].parent.unwrap_or(0);
                    }
                }
                _ => break,
            }
            (rest, anchored) = (after, true);
        }
        let names: Vec<&String> = rest.iter().collect();
        if !within.is_empty() {
            // A module of the file itself: its imports, or its definitions.
            let imported = self.import(at, within, rest);
            return match imported {
                Some(path) => self.follow(at, within, path, &names[1..], steps),
                None if anchored || rest.first().is_some_and(|n| self.files[at].read.defined.contains(n)) => {
                    Target::Item(at)
                }
                None => Target::Elsewhere,
            };
        }
        let known = |name: &String| {
            let file = &self.files[at];
            file.children.contains_key(name)
                || file.read.defined.contains(name)
                || self.import(at, &[], std::slice::from_ref(name)).is_some()
        };
        if anchored || rest.first().is_some_and(known) {
            self.walk(at, &names, steps)
        } else {
            Target::Elsewhere
        }
    }

    /// The path behind the first of these names, if it is imported.
    fn import(&self, file: usize, within: &[String], names: &[String]) -> Option<&[String]> {
        let name = names.first()?;
        let mut imports = self.files[file].read.imports.iter();
        let import = imports.find(|i| i.within == within && i.name.as_ref() == Some(name))?;
        // `use png;` would lead to itself.
        (import.path.first() != Some(name)).then_some(&import.path[..])
    }

    fn follow(
        &self,
        file: usize,
        within: &[String],
        path: &[String],
        rest: &[&String],
        steps: usize,
    ) -> Target {
        match self.resolve(file, within, path, steps + 1) {
            Target::Module(to) => self.walk(to, rest, steps + 1),
            other => other,
        }
    }

    /// Follows names from a file's module.
    fn walk(&self, file: usize, names: &[&String], steps: usize) -> Target {
        let Some((first, rest)) = names.split_first() else { return Target::Module(file) };
        if steps > MOST_STEPS {
            return Target::Item(file);
        }
        let this = &self.files[file];
        if let Some(&child) = this.children.get(*first) {
            return self.walk(child, rest, steps);
        }
        let imported =
            this.read.imports.iter().find(|i| i.within.is_empty() && i.name.as_ref() == Some(*first));
        if let Some(import) = imported {
            // `pub use mesh::mesh;` begins with a child, `use png;` with another crate.
            let begins_with_itself = import.path.first() == Some(*first);
            if begins_with_itself {
                return Target::Elsewhere;
            }
            return self.follow(file, &[], &import.path, rest, steps);
        }
        if this.read.defined.contains(*first) {
            return Target::Item(file);
        }
        let stars =
            this.read.imports.iter().filter(|import| import.within.is_empty() && import.name.is_none());
        for star in stars {
            match self.resolve(file, &[], &star.path, steps + 1) {
                Target::Module(to) if self.names(to).contains(first) => {
                    return self.walk(to, names, steps + 1);
                }
                Target::Item(to) if self.files[to].read.names.contains(*first) => return Target::Item(to),
                _ => {}
            }
        }
        Target::Item(file)
    }
}
