// SPDX-License-Identifier: GPL-3.0-or-later
//! No work of a pool's threads inside of a lazy initialization (`OnceLock::get_or_init` and the like). A
//! thread that waits for others executes other tasks of the pool; if one of these needs the same value, the
//! thread waits for itself. Values are made outside and stored afterwards: a second thread drops its own. The
//! rule checks words, not types: a call with a pool, or with a value that has one, counts as parallel.

use super::files::SourceFile;

/// Functions that run their argument while others wait.
const ONCE: [&str; 4] = ["get_or_init(", "get_or_try_init(", "call_once(", "LazyLock::new("];

/// Names of functions that start parallel work; those of values that can, unless they are fields.
const CALLS: [&str; 4] = ["install", "broadcast", "in_place_scope", "Pool"];
const VALUES: [&str; 3] = ["threads", "pool", "job"];

/// No word of parallel work between the parentheses.
pub(super) fn check(file: &SourceFile) -> Vec<(usize, String)> {
    let mut complaints = Vec::new();
    // A fuzz target has no other user of its pool.
    if file.path.starts_with("fuzz/") {
        return complaints;
    }
    for opening in ONCE {
        for (at, _) in file.code.match_indices(opening) {
            let inside = inside(&file.code[at + opening.len()..]);
            if let Some(token) = parallel_word(inside) {
                let line = file.code[..at].matches('\n').count() + 1;
                let name = opening.trim_end_matches('(');
                complaints.push((
                    line,
                    format!(
                        "'{token}' within {name}: threads may wait for themselves; make the value before"
                    ),
                ));
            }
        }
    }
    complaints
}

/// Up to the parenthesis that closes.
fn inside(code: &str) -> &str {
    let mut depth = 1_usize;
    for (at, letter) in code.char_indices() {
        depth = match letter {
            '(' => depth + 1,
            ')' => depth - 1,
            _ => depth,
        };
        if depth == 0 {
            return &code[..at];
        }
    }
    code
}

fn parallel_word(code: &str) -> Option<&str> {
    let is_letter = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = 0;
    while let Some(from) = code[rest..].find(is_letter).map(|at| rest + at) {
        let token = code[from..].split(|c| !is_letter(c)).next().unwrap_or_default();
        rest = from + token.len();
        let is_field = code[..from].ends_with('.');
        let is_parallel = CALLS.contains(&token)
            || token.starts_with("par_")
            || token.starts_with("into_par_")
            || (VALUES.contains(&token) && !is_field);
        if is_parallel {
            return Some(token);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_work_is_found() {
        let lines = |text: &str| -> Vec<usize> {
            check(&SourceFile::new("a.rs", text)).iter().map(|(line, _)| *line).collect()
        };
        for text in [
            "a.get_or_init(|| build(list, threads))",
            "a.get_or_init(|| {\n list.par_iter().sum() })",
            "a.get_or_init(|| Set::new(parts, Threads::Pool(b)))",
            "a.get_or_init(|| b.pool.install(|| c))",
            "LazyLock::new(|| job.f())",
        ] {
            assert_eq!(lines(text), [1], "{text}");
        }
        for text in [
            "a.get_or_init(|| Set::new(parts, Threads::Single)); b(threads)",
            "a.get_or_init(|| built)",
            "a.get_or_init(|| Builder::new().num_threads(self.threads).build())",
            "a.get_or_init(|| /* by the pool */ 1)",
        ] {
            assert_eq!(lines(text), [0; 0], "{text}");
        }
    }
}
