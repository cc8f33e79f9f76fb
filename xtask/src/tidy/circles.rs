// SPDX-License-Identifier: GPL-3.0-or-later
//! No file imports, directly or through others, one that imports it. Strongly connected components after
//! Tarjan, "Depth-first search and linear graph algorithms", SIAM Journal on Computing 1 (1972). `modules.rs`
//! defines an import. Remaining circles are listed, file by file, in `known_circles.rs`, and the list only
//! gets shorter: a file that has left its circle must leave the list, and no other may come in.

use std::collections::{BTreeMap, VecDeque};

use super::files::SourceFile;
use super::known_circles::KNOWN;
use super::modules::Crate;

/// Complains about files in circles that are not listed, and about listed files that are in none.
pub(super) fn check(files: &[SourceFile]) -> Vec<String> {
    compare(files, KNOWN)
}

fn compare(files: &[SourceFile], known: &[&str]) -> Vec<String> {
    let mut complaints = Vec::new();
    let mut standing = Vec::new();
    for root in roots(files) {
        let code = |path: &str| files.iter().find(|file| file.path == path).map(|file| &file.code[..]);
        let of_crate = Crate::load(root, &code);
        let imports = of_crate.imports();
        for (file, import_chain) in ways_back(&imports) {
            let path = of_crate.path(file);
            standing.push(path.to_string());
            if !known.contains(&path) {
                complaints.push(expected(&of_crate, &imports, file, &import_chain));
            }
        }
    }
    let gone = known.iter().filter(|path| !standing.iter().any(|file| file == *path));
    complaints.extend(gone.map(|path| {
        format!("{path}: is in no circle of imports any more: take it off xtask/src/tidy/known_circles.rs")
    }));
    complaints
}

/// Where crates begin.
fn roots(files: &[SourceFile]) -> impl Iterator<Item = &str> {
    let is_root = |path: &str| ["/src/lib.rs", "/src/main.rs"].iter().any(|end| path.ends_with(end));
    files.iter().map(|file| &file.path[..]).filter(move |path| is_root(path))
}

fn expected(
    of_crate: &Crate,
    imports: &[BTreeMap<usize, usize>],
    file: usize,
    import_chain: &[usize],
) -> String {
    let folder = of_crate.path(0).rsplit_once('/').map_or(0, |(folder, _)| folder.len() + 1);
    let line = |from: usize, to: usize| imports[from].get(&to).copied().unwrap_or(1);
    let first = import_chain.first().copied().unwrap_or(file);
    let mut from = first;
    let mut steps = String::new();
    for &to in import_chain.iter().skip(1).chain([&file]) {
        steps += &format!(" imports {} (line {}), which", &of_crate.path(to)[folder..], line(from, to));
        from = to;
    }
    let steps = steps.trim_end_matches(", which");
    let path = of_crate.path(file);
    format!(
        "{path}:{}: imports {}, which{steps}: a circle",
        line(file, first),
        &of_crate.path(first)[folder..]
    )
}

/// For each file that imports itself through others, the shortest path: the files after it, it itself left
/// out.
fn ways_back(imports: &[BTreeMap<usize, usize>]) -> Vec<(usize, Vec<usize>)> {
    let parts = parts(imports);
    let mut chains = Vec::new();
    for file in 0..imports.len() {
        let shares = parts.iter().filter(|&&part| part == parts[file]).count() > 1;
        if shares && let Some(import_chain) = way_back(imports, file) {
            chains.push((file, import_chain));
        }
    }
    chains
}

fn way_back(imports: &[BTreeMap<usize, usize>], file: usize) -> Option<Vec<usize>> {
    let mut before: Vec<Option<usize>> = vec![None; imports.len()];
    let mut todo = VecDeque::from([file]);
    while let Some(at) = todo.pop_front() {
        for &to in imports[at].keys() {
            if to == file {
                let mut import_chain = vec![at];
                while let Some(step) = import_chain.last().and_then(|&step| before[step]) {
                    import_chain.push(step);
                }
                // The last one is the file itself.
                import_chain.pop();
                import_chain.reverse();
                return Some(import_chain);
            }
            if before[to].is_none() {
                before[to] = Some(at);
                todo.push_back(to);
            }
        }
    }
    None
}

/// The number of each file's strongly connected component.
fn parts(imports: &[BTreeMap<usize, usize>]) -> Vec<usize> {
    let unseen = usize::MAX;
    let mut state = Search {
        imports,
        order: vec![unseen; imports.len()],
        lowest: vec![unseen; imports.len()],
        part: vec![unseen; imports.len()],
        stack: Vec::new(),
        visited: 0,
    };
    for file in 0..imports.len() {
        if state.order[file] == unseen {
            state.visit(file);
        }
    }
    state.part
}

struct Search<'a> {
    imports: &'a [BTreeMap<usize, usize>],
    /// When each file was met.
    order: Vec<usize>,
    /// The earliest one that is reachable from it and is not in a component yet.
    lowest: Vec<usize>,
    part: Vec<usize>,
    stack: Vec<usize>,
    visited: usize,
}

impl Search<'_> {
    fn visit(&mut self, file: usize) {
        self.order[file] = self.visited;
        self.lowest[file] = self.visited;
        self.visited += 1;
        self.stack.push(file);
        let imports = self.imports;
        for &to in imports[file].keys() {
            if self.order[to] == usize::MAX {
                self.visit(to);
                self.lowest[file] = self.lowest[file].min(self.lowest[to]);
            } else if self.part[to] == usize::MAX {
                self.lowest[file] = self.lowest[file].min(self.order[to]);
            }
        }
        if self.lowest[file] == self.order[file] {
            while let Some(member) = self.stack.pop() {
                self.part[member] = file;
                if member == file {
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A made-up crate: paths below its `src` with their text.
    fn sources(texts: &[(&str, &str)]) -> Vec<SourceFile> {
        texts.iter().map(|(path, text)| SourceFile::new(&format!("crates/x/src/{path}"), text)).collect()
    }

    /// The files in a circle, below `src`.
    fn standing(texts: &[(&str, &str)]) -> Vec<String> {
        let complaints = compare(&sources(texts), &[]);
        let path = |complaint: &String| complaint.split(':').next().map(|p| p.replace("crates/x/src/", ""));
        complaints.iter().filter_map(path).collect()
    }

    const ROOT: (&str, &str) = ("lib.rs", "mod a;\nmod b;\nmod c;\n");

    #[test]
    fn circles_are_found() {
        let nothing = ("c.rs", "");
        for (a, b) in [
            ("use crate::b::B;", "use crate::a::A;"),
            ("use super::b::{self, C};", "fn f() { crate::a::g() }"),
            ("use crate::b; fn f() { b::g() }", "mod x { fn f() { super::super::a::g() } }"),
            ("use crate::b::*; struct X(B);", "pub struct B; use super::{a::A};"),
            ("#[macro_export] macro_rules! m { () => {} } use crate::b::B;", "struct B; fn f() { m!() }"),
            ("use crate::b::B as D;", "impl crate::a::Trait for B {}"),
        ] {
            assert_eq!(standing(&[ROOT, ("a.rs", a), ("b.rs", b), nothing]), ["a.rs", "b.rs"], "{a} and {b}");
        }
        let corner =
            [ROOT, ("a.rs", "use super::b::B;"), ("b.rs", "use super::c::C;"), ("c.rs", "use super::a::A;")];
        assert_eq!(standing(&corner), ["a.rs", "b.rs", "c.rs"], "around a corner");
        let expected = compare(&sources(&corner), &[]);
        assert_eq!(
            expected[0],
            "crates/x/src/a.rs:1: imports b.rs, which imports c.rs (line 1), which imports a.rs (line 1): a circle",
            "the way is told"
        );
    }

    #[test]
    fn one_way_is_no_circle() {
        for (a, b) in [
            ("use crate::b::B;", ""),
            ("use crate::b::B;", "// use crate::a::A;\nconst S: &str = \"crate::a::A\";"),
            ("use crate::b::B;", "#[cfg(test)]\nmod tests { use crate::a::A; }"),
            ("use crate::b::B;", "pub(in crate::a) struct B;"),
            ("use b::B;", "use a::A;"),
            ("use crate::b::*; struct X(B);", "pub struct B; use super::a;"),
        ] {
            let texts = [ROOT, ("a.rs", a), ("b.rs", b), ("c.rs", "use crate::{a::A, b::B};")];
            assert_eq!(standing(&texts), [""; 0], "{a} and {b}");
        }
    }

    #[test]
    fn lists_pass_names_on() {
        let list = "mod mesh;\nmod light;\npub use mesh::Mesh;\npub use light::*;\n";
        let tree = |list: &str, light: &str| {
            standing(&[
                ("lib.rs", "pub mod scene;\npub use scene::Mesh;\n"),
                ("scene/mod.rs", list),
                ("scene/mesh.rs", "pub struct Mesh;"),
                ("scene/light.rs", light),
            ])
        };
        let light = "use super::Mesh;\npub struct Light(Mesh);";
        assert_eq!(tree(list, light), [""; 0], "the list is not on the way");
        assert_eq!(tree(list, "use crate::Mesh; pub struct Light(Mesh);"), [""; 0], "nor are two");
        // A list with an item that uses a re-exported name.
        let own = format!("{list}pub struct Scene(Light);");
        assert_eq!(tree(&own, light), [""; 0], "from above to below only");
        let back = "use super::Scene;\npub struct Light(Scene);";
        assert_eq!(tree(&own, back), ["scene/mod.rs", "scene/light.rs"], "and back");
        assert_eq!(
            tree(list, "pub struct Light; use super::Light as Same;"),
            [""; 0],
            "itself by way of the list"
        );
        let called = format!("{list}pub fn load() {{ mesh::load(); light::load() }}");
        assert_eq!(
            tree(&called, "fn f() {{ super::load() }}"),
            ["scene/mod.rs", "scene/light.rs"],
            "by a path"
        );
        assert_eq!(
            standing(&[
                ROOT,
                ("a.rs", "mod deep; fn f() { deep::g() }"),
                ("a/deep.rs", "use super::super::a::f;"),
                ("b.rs", ""),
                ("c.rs", "")
            ]),
            ["a.rs", "a/deep.rs"],
            "files beside folders"
        );
    }

    #[test]
    fn the_list_only_gets_shorter() {
        let circle =
            [ROOT, ("a.rs", "use super::b::B;"), ("b.rs", "use super::a::A;"), ("c.rs", "use super::a::A;")];
        let listed = |known: &[&str]| compare(&sources(&circle), known);
        assert_eq!(listed(&["crates/x/src/a.rs", "crates/x/src/b.rs"]), [""; 0], "both are known");
        let missing = listed(&["crates/x/src/a.rs"]);
        assert!(missing.len() == 1 && missing[0].contains("b.rs:1"), "a new one: {missing:?}");
        let gone =
            listed(&["crates/x/src/a.rs", "crates/x/src/b.rs", "crates/x/src/c.rs", "crates/x/src/no.rs"]);
        assert!(gone.len() == 2 && gone.iter().all(|c| c.contains("take it off")), "no longer: {gone:?}");
    }
}
