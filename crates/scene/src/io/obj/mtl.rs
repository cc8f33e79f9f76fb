// SPDX-License-Identifier: GPL-3.0-or-later
//! Material libraries: checks their lines, hands the good ones to `tobj`, and keeps the materials of all libraries.
//! Source: Wavefront MTL 4.2. Material 0 is the default one, for faces that name none.
//! Proof: `tests/obj.rs`, `tests/broken_files.rs`.

use std::collections::{HashMap, HashSet};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use crate::io::error::quoted;
use crate::io::lines::LogicalLines;
use crate::io::{Error, Oddity, Warnings, source};

/// A material and the place that messages about it name.
pub(super) struct Entry {
    pub(super) material: tobj::Material,
    pub(super) path: PathBuf,
    /// Lines of its keywords.
    pub(super) lines: HashMap<String, u64>,
}

/// The materials of all libraries of a file.
#[derive(Default)]
pub(super) struct Library {
    /// Material `k` of the file is `entries[k - 1]`.
    pub(super) entries: Vec<Entry>,
    by_name: HashMap<String, usize>,
    /// The libraries' files, those that could not be read included.
    pub(super) read: HashSet<PathBuf>,
}

impl Library {
    /// The number of the material of this name; 0 with a warning if there is none.
    pub(super) fn number_of(&self, name: &str, path: &Path, line: u64, warnings: &mut Warnings) -> usize {
        self.by_name.get(name).copied().unwrap_or_else(|| {
            warnings.note(Oddity::UnknownMaterial, path, Some(line), quoted(name));
            0
        })
    }

    /// Reads what a `mtllib` statement names: one file, whose name may have spaces, or several.
    pub(super) fn read(&mut self, obj: &Path, line: u64, names: &str, warnings: &mut Warnings) {
        let whole = source::resolve(obj, names);
        let files = if whole.exists() || names.is_empty() {
            vec![whole]
        } else {
            names.split_whitespace().map(|name| source::resolve(obj, name)).collect()
        };
        for path in files {
            if !self.read.insert(path.clone()) {
                continue;
            }
            if let Err(error) = self.read_file(&path, warnings) {
                warnings.note(Oddity::BadMaterialLibrary, obj, Some(line), error.to_string());
            }
        }
    }

    fn read_file(&mut self, path: &Path, warnings: &mut Warnings) -> Result<(), Error> {
        let (file, length) = source::open(path)?;
        let mut lines = LogicalLines::new(BufReader::new(file.take(length)), path);
        let mut plain = String::new();
        let mut places: Vec<HashMap<String, u64>> = Vec::new();
        while let Some((line, text)) = lines.next()? {
            let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
            let rest = rest.trim();
            if keyword == "newmtl" && !rest.is_empty() {
                places.push(HashMap::new());
            }
            match statement(keyword, rest) {
                Ok(Some(statement)) => match places.last_mut() {
                    Some(place) => {
                        place.insert(keyword.to_owned(), line);
                        plain.push_str(&statement);
                        plain.push('\n');
                    }
                    None => {
                        warnings.note(Oddity::BadMaterialLine, path, Some(line), "before the first `newmtl`")
                    }
                },
                Ok(None) => {}
                Err(why) => warnings.note(Oddity::BadMaterialLine, path, Some(line), why),
            }
        }
        let (materials, _) = tobj::load_mtl_buf(&mut plain.as_bytes())
            .map_err(|e| Error::data(path, None, e.to_string(), "expected a Wavefront MTL library"))?;
        for (material, lines) in materials.into_iter().zip(places) {
            let number = self.entries.len() + 1;
            // The first definition of a name counts.
            self.by_name.entry(material.name.clone()).or_insert(number);
            self.entries.push(Entry { material, path: path.to_owned(), lines });
        }
        Ok(())
    }
}

/// A statement in the form that `tobj` reads; `None` for keywords that say nothing here; the error says what is wrong.
fn statement(keyword: &str, rest: &str) -> Result<Option<String>, String> {
    let statement = match keyword {
        "newmtl" if rest.is_empty() => return Err("`newmtl` without a name".into()),
        "newmtl" => format!("newmtl {rest}"),
        "Kd" | "Ks" | "Ke" | "Tf" => {
            let [r, g, b] =
                color(rest).ok_or_else(|| format!("{keyword} {}: expected 3 numbers", quoted(rest)))?;
            format!("{keyword} {r} {g} {b}")
        }
        "Ns" | "Ni" | "d" | "Tr" | "Pr" | "Pm" | "Ps" | "Pc" | "Pcr" => {
            // `d -halo 0.5` fades towards edges; its number is the opacity in the middle.
            let token = rest.trim_start_matches("-halo").split_whitespace().next().unwrap_or("");
            let x = finite(token).ok_or_else(|| format!("{keyword} {}: expected a number", quoted(rest)))?;
            format!("{keyword} {x}")
        }
        "illum" => {
            let token = rest.split_whitespace().next().unwrap_or("");
            let model =
                token.parse::<u8>().map_err(|_| format!("illum {}: expected 0 to 10", quoted(rest)))?;
            format!("illum {model}")
        }
        "map_Kd" | "map_Ke" | "map_d" | "map_kd" | "map_ke" if rest.is_empty() => {
            return Err(format!("{keyword} without a file name"));
        }
        "map_Kd" | "map_kd" => format!("map_Kd {rest}"),
        "map_Ke" | "map_ke" => format!("map_Ke {rest}"),
        "map_d" => format!("map_d {rest}"),
        _ => return Ok(None),
    };
    Ok(Some(statement))
}

fn finite(token: &str) -> Option<f32> {
    token.parse::<f32>().ok().filter(|x| x.is_finite())
}

/// Three numbers, or one that counts for all.
fn color(rest: &str) -> Option<[f32; 3]> {
    let mut tokens = rest.split_whitespace().take_while(|t| !t.starts_with('#'));
    let first = finite(tokens.next()?)?;
    match tokens.next() {
        None => Some([first; 3]),
        Some(second) => Some([first, finite(second)?, finite(tokens.next()?)?]),
    }
}
