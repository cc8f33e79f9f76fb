// SPDX-License-Identifier: GPL-3.0-or-later
//! Crates have a vocabulary: a word that a crate must not use, as part of an identifier, belongs to another
//! crate. Comments and strings are free.

use super::files::SourceFile;

/// A crate and the words that it must not use.
const FORBIDDEN: [(&str, &[&str]); 5] = [
    ("crates/accel/src/", &["material", "pixel", "texture", "shader"]),
    ("crates/accel-core/src/", &["material", "pixel", "texture", "shader"]),
    ("crates/accel-bvh/src/", &["material", "pixel", "texture", "shader"]),
    ("crates/accel-kd/src/", &["material", "pixel", "texture", "shader"]),
    ("crates/image/src/", &["thread", "ray", "rayon"]),
];

/// No identifier of a crate contains a word that the crate must not use.
pub(super) fn check(file: &SourceFile) -> Vec<(usize, String)> {
    let Some((_, forbidden)) = FORBIDDEN.iter().find(|(crate_path, _)| file.path.starts_with(crate_path))
    else {
        return vec![];
    };
    let wrong = |identifier: &str| parts(identifier).into_iter().find(|part| forbidden.contains(&&part[..]));
    file.identifiers()
        .filter_map(|(line, identifier)| Some((line, identifier, wrong(identifier)?)))
        .map(|(line, identifier, part)| (line, format!("'{identifier}': this room must not know '{part}'")))
        .collect()
}

/// The words of `snake_case` and `CamelCase`, in lower case, without a plural's s.
fn parts(identifier: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    for letter in identifier.chars() {
        if letter == '_' || letter.is_uppercase() {
            parts.push(String::new());
        }
        if let Some(part) = parts.last_mut().filter(|_| letter != '_') {
            part.extend(letter.to_lowercase());
        }
    }
    parts.iter().map(|part| part.strip_suffix('s').unwrap_or(part).to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_other_rooms_are_found() {
        let count = |path: &str, text: &str| check(&SourceFile::new(path, text)).len();
        for text in ["let material = 1;", "let pixel_x = 1;", "struct TextureId;", "fn pixels() {}"] {
            assert_eq!(count("crates/accel/src/a.rs", text), 1, "accel must not know: {text}");
            assert_eq!(count("crates/render/src/a.rs", text), 0, "render may know: {text}");
        }
        assert_eq!(count("crates/image/src/a.rs", "use std::thread; let array = ray;"), 2, "array is no ray");
        assert_eq!(count("crates/accel/src/a.rs", "// a pixel\nlet a = \"pixel\";"), 0, "talk is not code");
    }
}
