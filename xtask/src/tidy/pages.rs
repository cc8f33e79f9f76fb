// SPDX-License-Identifier: GPL-3.0-or-later
//! Links of Markdown pages: files and anchors that they lead to, and references to files outside of the repository.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A Markdown page, with its path from the root with forward slashes.
pub(super) struct Page {
    pub(super) path: String,
    pub(super) text: String,
}

/// Phrases that point at something that readers of the repository do not have.
const OUTSIDE: [&str; 4] =
    ["contract of the command line", "references/README", "../shared/", "issue's review"];

/// Pages that name the shared scenes, which tests use where they are present.
const MAY_NAME_SHARED: [&str; 2] = ["CONTRIBUTING.md", "bench/record/"];

/// Dead links and anchors, and references to files outside of the repository.
pub(super) fn check(root: &Path, pages: &[Page]) -> Vec<String> {
    let anchors: BTreeMap<&str, BTreeSet<String>> =
        pages.iter().map(|page| (&page.path[..], anchors(&page.text))).collect();
    let exists = |path: &str| root.join(path).exists();
    pages.iter().flat_map(|page| page_complaints(page, &anchors, &exists)).collect()
}

fn page_complaints(
    page: &Page,
    anchors: &BTreeMap<&str, BTreeSet<String>>,
    exists: &dyn Fn(&str) -> bool,
) -> Vec<String> {
    let mut complaints = Vec::new();
    for (number, line) in prose_lines(&page.text) {
        let mut complain = |what: String| complaints.push(format!("{}:{number}: {what}", page.path));
        for target in links(line).filter(|target| !target.contains("://") && !target.starts_with("mailto:")) {
            let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() { page.path.clone() } else { resolved(&page.path, file) };
            if !exists(&path) {
                complain(format!("dead link: '{target}'"));
            } else if let Some(known) = anchors.get(&path[..])
                && !anchor.is_empty()
                && !known.contains(anchor)
            {
                complain(format!("dead anchor: '{target}'"));
            }
        }
        for phrase in OUTSIDE.iter().filter(|phrase| line.contains(**phrase)) {
            if *phrase != "../shared/" || !MAY_NAME_SHARED.iter().any(|start| page.path.starts_with(start)) {
                complain(format!("'{phrase}' is not in the repository"));
            }
        }
    }
    complaints
}

/// The path of `file` as written on the page at `page`, from the root.
fn resolved(page: &str, file: &str) -> String {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in file.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// Line numbers from 1 and lines outside of code blocks.
pub(super) fn prose_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut in_code = false;
    text.lines().enumerate().filter_map(move |(number, line)| {
        let is_fence = line.trim_start().starts_with("```");
        in_code ^= is_fence;
        (!in_code && !is_fence).then_some((number + 1, line))
    })
}

/// Targets of `[text](target)`.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target.trim())
}

/// Anchors that a page's headings make, as GitHub names them: lower case, punctuation dropped, blanks as hyphens.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut anchors = BTreeSet::new();
    for (_, line) in prose_lines(text).filter(|(_, line)| line.starts_with('#')) {
        let name: String = line
            .trim_start_matches('#')
            .trim()
            .chars()
            .filter_map(|c| match c {
                ' ' => Some('-'),
                c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c.to_ascii_lowercase()),
                _ => None,
            })
            .collect();
        let taken = |name: &String| anchors.contains(name);
        let repeated = (1..).map(|n| format!("{name}-{n}")).find(|name| !taken(name));
        anchors.insert(if taken(&name) { repeated.unwrap_or(name) } else { name });
    }
    anchors
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaints(text: &str) -> Vec<String> {
        let page = |path: &str, text: &str| Page { path: path.into(), text: text.into() };
        let pages = [page("docs/a.md", text), page("docs/b/c.md", "# One `x`: two\n## Same\n## Same\n")];
        let anchors = pages.iter().map(|page| (&page.path[..], anchors(&page.text))).collect();
        let exists = |path: &str| ["docs/a.md", "docs/b/c.md", "README.md"].contains(&path);
        page_complaints(&pages[0], &anchors, &exists)
    }

    #[test]
    fn dead_links_and_anchors_are_found() {
        for good in
            ["[c](b/c.md#one-x-two)", "[c](b/c.md#same-1)", "[r](../README.md)", "[w](https://x.org/y)"]
        {
            assert_eq!(complaints(good), [""; 0], "{good}");
        }
        for bad in ["[c](b/d.md)", "[c](b/c.md#three)", "[r](README.md)", "[own](#none)"] {
            assert_eq!(complaints(bad).len(), 1, "{bad}");
        }
        assert_eq!(complaints("```\n[c](b/d.md)\n```\n"), [""; 0], "code is no link");
    }

    #[test]
    fn references_outside_are_found() {
        assert_eq!(complaints("as ../shared/design/x.md says").len(), 1, "a file outside of the repository");
    }
}
