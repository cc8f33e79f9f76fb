// SPDX-License-Identifier: GPL-3.0-or-later
//! Material libraries: the materials of all that a file names.
//! Source: Wavefront MTL 4.2, and the keywords of its PBR extension. Material 0 is the default one, for faces that name
//! none. Messages name the invalid keyword but quote no more of the line, because a library may be any file
//! of the machine. Memory: about [`ENTRY_BYTES`] for each name that is defined. Tests: `tests/obj.rs`,
//! `tests/{broken_files,growth}.rs`.

use std::collections::{HashMap, HashSet};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use crate::io::error::quoted;
use crate::io::lines::LogicalLines;
use crate::io::source::{self, Access};
use crate::io::{Error, Oddity, Warnings};
use gnurt_image::Excess;

/// Bytes of a material, without its name and its texture statements.
const ENTRY_BYTES: usize = size_of::<Entry>() + 2 * size_of::<(Rc<str>, usize)>() + 64;

/// A texture statement, and its line.
pub(super) struct Map {
    pub(super) text: String,
    pub(super) line: u64,
}

/// The entry of a material in a library; `None` where the library gives no value.
#[derive(Default)]
pub(super) struct Entry {
    pub(super) name: Rc<str>,
    /// The library.
    pub(super) path: Rc<PathBuf>,
    pub(super) kd: Option<[f32; 3]>,
    pub(super) ks: Option<[f32; 3]>,
    pub(super) ke: Option<[f32; 3]>,
    pub(super) tf: Option<[f32; 3]>,
    pub(super) ns: Option<f32>,
    pub(super) ni: Option<f32>,
    pub(super) d: Option<f32>,
    pub(super) tr: Option<f32>,
    pub(super) pm: Option<f32>,
    pub(super) pr: Option<f32>,
    pub(super) ps: Option<f32>,
    pub(super) pc: Option<f32>,
    pub(super) pcr: Option<f32>,
    pub(super) aniso: Option<f32>,
    pub(super) anisor: Option<f32>,
    pub(super) illum: Option<u8>,
    pub(super) map_kd: Option<Box<Map>>,
    pub(super) map_ke: Option<Box<Map>>,
    pub(super) map_d: Option<Box<Map>>,
    /// Heights, or else a displacement that is taken for one.
    pub(super) bump: Option<Box<Map>>,
    pub(super) disp: Option<Box<Map>>,
    /// Normals.
    pub(super) norm: Option<Box<Map>>,
    /// Roughness, metalness, sheen, coat and its roughness.
    pub(super) map_pr: Option<Box<Map>>,
    pub(super) map_pm: Option<Box<Map>>,
    pub(super) map_ps: Option<Box<Map>>,
    pub(super) map_pc: Option<Box<Map>>,
    pub(super) map_pcr: Option<Box<Map>>,
    /// A file in the shading language and its parameters; not MTL's.
    pub(super) shader: Option<Box<Map>>,
}

/// The materials of all libraries of a file.
#[derive(Default)]
pub(super) struct Library {
    /// Material `k` of the file is `entries[k - 1]`.
    pub(super) entries: Vec<Entry>,
    by_name: HashMap<Rc<str>, usize>,
    /// The libraries' files, unreadable ones included.
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

    /// Reads the files of a `mtllib` statement: one file, whose name may have spaces, or several.
    pub(super) fn read(
        &mut self,
        obj: &Path,
        line: u64,
        names: &str,
        access: &Access,
        warnings: &mut Warnings,
    ) -> Result<(), Error> {
        let whole = source::resolve(obj, names);
        let files = if names.is_empty() || !names.contains(char::is_whitespace) || whole.exists() {
            vec![whole]
        } else {
            names.split_whitespace().map(|name| source::resolve(obj, name)).collect()
        };
        for path in files {
            if self.read.contains(&path) {
                continue;
            }
            let outside = |(problem, remedy)| Error::data(obj, Some(line), problem, remedy);
            access.check(&path).map_err(outside)?;
            let excess = |e: Excess| Error::data(obj, Some(line), e.to_string(), Excess::REMEDY);
            access.budget.name_file().map_err(excess)?;
            access.budget.hold(2 * (path.as_os_str().len() + size_of::<PathBuf>())).map_err(excess)?;
            self.read.insert(path.clone());
            let opened = access.open(&path);
            let read = opened.and_then(|(file, length)| {
                access.budget.add_file(length);
                let lines = LogicalLines::new(BufReader::new(file.take(length)), &path);
                self.read_lines(lines, &path, access, warnings)
            });
            match read {
                Ok(None) => {}
                Ok(Some((line, excess))) => {
                    return Err(Error::data(&path, Some(line), excess.to_string(), Excess::REMEDY));
                }
                Err(error) => {
                    warnings.note(Oddity::BadMaterialLibrary, obj, Some(line), error.to_string());
                }
            }
        }
        Ok(())
    }

    /// Reads a library; returns the line at which the budget was exhausted, if it was.
    fn read_lines<R: std::io::BufRead>(
        &mut self,
        mut lines: LogicalLines<R>,
        path: &Path,
        access: &Access,
        warnings: &mut Warnings,
    ) -> Result<Option<(u64, Excess)>, Error> {
        let path = Rc::new(path.to_owned());
        // The first definition of a name counts; later ones are ignored.
        let mut nowhere = Entry::default();
        let mut location = None;
        while let Some((line, text)) = lines.next()? {
            let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
            let rest = rest.trim();
            let mut warn = |why: String| warnings.note(Oddity::BadMaterialLine, &path, Some(line), why);
            if keyword == "newmtl" && rest.is_empty() {
                warn("`newmtl` without a name".into());
            } else if keyword == "newmtl" {
                location = Some(!self.by_name.contains_key(rest));
                nowhere = Entry::default();
                if location == Some(true) {
                    if let Err(excess) = access.budget.hold(ENTRY_BYTES + rest.len()) {
                        return Ok(Some((line, excess)));
                    }
                    let name: Rc<str> = rest.into();
                    self.entries.push(Entry { name: name.clone(), path: path.clone(), ..Entry::default() });
                    self.by_name.insert(name, self.entries.len());
                }
            } else {
                let entry = match location {
                    Some(true) => self.entries.last_mut(),
                    Some(false) => Some(&mut nowhere),
                    None => None,
                };
                let held = if keyword.starts_with("map_")
                    || matches!(keyword, "gnurt_shader" | "bump" | "disp" | "norm")
                {
                    rest.len() + size_of::<Map>()
                } else {
                    0
                };
                if is_lost(keyword) {
                    let detail = format!("`{keyword}` of a material");
                    warnings.note(Oddity::NotShown, &path, Some(line), detail);
                    continue;
                }
                match (statement(keyword, rest, line), entry) {
                    (Ok(None), _) => {}
                    (Ok(Some(_)), None) => warn("before the first `newmtl`".into()),
                    (Ok(Some(say)), Some(entry)) => {
                        if let Err(excess) = access.budget.hold(held) {
                            return Ok(Some((line, excess)));
                        }
                        say.to(entry);
                    }
                    (Err(why), _) => warn(why),
                }
            }
        }
        Ok(None)
    }
}

/// A parsed statement.
enum Statement<'a> {
    Color(fn(&mut Entry) -> &mut Option<[f32; 3]>, [f32; 3]),
    Number(fn(&mut Entry) -> &mut Option<f32>, f32),
    Illum(u8),
    Map(fn(&mut Entry) -> &mut Option<Box<Map>>, &'a str, u64),
}

impl Statement<'_> {
    fn to(self, entry: &mut Entry) {
        match self {
            Self::Color(slot, color) => *slot(entry) = Some(color),
            Self::Number(slot, x) => *slot(entry) = Some(x),
            Self::Illum(model) => entry.illum = Some(model),
            Self::Map(slot, text, line) => *slot(entry) = Some(Box::new(Map { text: text.to_owned(), line })),
        }
    }
}

/// Parses a line; `None` for unsupported keywords; the error gives the fault.
fn statement<'a>(keyword: &str, rest: &'a str, line: u64) -> Result<Option<Statement<'a>>, String> {
    let color = |slot| match color(rest) {
        Some(color) => Ok(Some(Statement::Color(slot, color))),
        None => Err(format!("`{keyword}`: expected 3 numbers")),
    };
    let number = |slot| {
        // `d -halo 0.5` fades towards edges; its number is the opacity in the middle.
        let token = rest.trim_start_matches("-halo").split_whitespace().next().unwrap_or("");
        match finite(token) {
            Some(x) => Ok(Some(Statement::Number(slot, x))),
            None => Err(format!("`{keyword}`: expected a number")),
        }
    };
    let map = |slot| match rest.is_empty() {
        false => Ok(Some(Statement::Map(slot, rest, line))),
        true => Err(format!("`{keyword}` without a file name")),
    };
    match keyword {
        "Kd" => color(|e| &mut e.kd),
        "Ks" => color(|e| &mut e.ks),
        "Ke" => color(|e| &mut e.ke),
        "Tf" => color(|e| &mut e.tf),
        "Ns" => number(|e| &mut e.ns),
        "Ni" => number(|e| &mut e.ni),
        "d" => number(|e| &mut e.d),
        "Tr" => number(|e| &mut e.tr),
        "Pm" => number(|e| &mut e.pm),
        "Pr" => number(|e| &mut e.pr),
        "Ps" => number(|e| &mut e.ps),
        "Pc" => number(|e| &mut e.pc),
        "Pcr" => number(|e| &mut e.pcr),
        "aniso" => number(|e| &mut e.aniso),
        "anisor" => number(|e| &mut e.anisor),
        "illum" => match rest.split_whitespace().next().unwrap_or("").parse() {
            Ok(model) => Ok(Some(Statement::Illum(model))),
            Err(_) => Err("`illum`: expected 0 to 10".into()),
        },
        "map_Kd" | "map_kd" => map(|e| &mut e.map_kd),
        "map_Ke" | "map_ke" => map(|e| &mut e.map_ke),
        "map_d" => map(|e| &mut e.map_d),
        "bump" | "map_bump" | "map_Bump" => map(|e| &mut e.bump),
        "disp" | "map_disp" | "map_Disp" => map(|e| &mut e.disp),
        "norm" | "map_Norm" | "map_norm" => map(|e| &mut e.norm),
        "map_Pr" => map(|e| &mut e.map_pr),
        "map_Pm" => map(|e| &mut e.map_pm),
        "map_Ps" => map(|e| &mut e.map_ps),
        "map_Pc" => map(|e| &mut e.map_pc),
        "map_Pcr" => map(|e| &mut e.map_pcr),
        "gnurt_shader" => map(|e| &mut e.shader),
        _ => Ok(None),
    }
}

/// Textures that change the appearance of a surface, and are not read. `map_Ka` is not among them: there is
/// no ambient light.
fn is_lost(keyword: &str) -> bool {
    matches!(keyword, "map_Ks" | "map_Ns" | "map_aniso" | "decal" | "refl")
}

fn finite(token: &str) -> Option<f32> {
    token.parse::<f32>().ok().filter(|x| x.is_finite())
}

/// Three numbers, or one for all.
fn color(rest: &str) -> Option<[f32; 3]> {
    let mut tokens = rest.split_whitespace().take_while(|t| !t.starts_with('#'));
    let first = finite(tokens.next()?)?;
    match tokens.next() {
        None => Some([first; 3]),
        Some(second) => Some([first, finite(second)?, finite(tokens.next()?)?]),
    }
}
