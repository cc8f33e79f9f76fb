// SPDX-License-Identifier: GPL-3.0-or-later
//! Lists the parameters of compiled shaders.
//! Options and output are those of OSL's `oslinfo`.

use super::console::Console;
use gnurt_sl::format::{escape, general};
use gnurt_sl::hir::{Data, Meta};
use gnurt_sl::ir::{Shader, Symbol, read};
use gnurt_sl::types::{Base, Type};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const USAGE: &str = "\
oslinfo -- list parameters of a compiled OSL shader
oslinfo [options] file0 [file1 ...]
    --help             Print help message
    -v                 Verbose output
    --runstats         Benchmark shader loading time for queries
    -p SEARCHPATH      Set searchpath for shaders
    --param NAME       Output information about just this parameter
";

/// Runs the tool; returns the exit status.
pub fn oslinfo(args: &[String], console: &mut Console<'_>) -> i32 {
    let (mut verbose, mut times, mut path, mut only, mut files) =
        (false, false, String::new(), None, Vec::new());
    let mut rest = args.iter();
    while let Some(arg) = rest.next() {
        match arg.trim_start_matches('-') {
            _ if !arg.starts_with('-') => files.push(arg.clone()),
            "v" => verbose = true,
            "runstats" => times = true,
            name @ ("p" | "param") => match rest.next() {
                Some(value) if name == "p" => path.clone_from(value),
                Some(value) => only = Some(value.clone()),
                None => {
                    console.complain(&format!("error: {arg} needs a value\n"));
                    return 1;
                }
            },
            "help" | "h" => files.clear(),
            _ => {
                console.complain(&format!("Invalid option \"{arg}\"\n{USAGE}"));
                return 1;
            }
        }
    }
    if files.is_empty() {
        console.print(USAGE);
    }
    let mut status = 0;
    for file in files {
        let start = std::time::Instant::now();
        match load(&file, &path) {
            Ok(_) if times => {
                console.print(&format!("{} sec for {file}\n", general(start.elapsed().as_secs_f64(), 6)))
            }
            Ok(shader) => console.print(&describe(&shader, verbose, only.as_deref())),
            Err(message) => {
                console.print(&format!("ERROR opening shader \"{file}\" ({message})\n"));
                // OSL's tool continues as if nothing were wrong.
                status = i32::from(!console.link);
                if !console.link && file.ends_with(".osl") {
                    console.complain(&format!("{file} is source text: `oslc {file}` compiles it\n"));
                }
            }
        }
    }
    status
}

fn load(name: &str, path: &str) -> Result<Shader, String> {
    let file = if name.ends_with(".oso") { name.to_owned() } else { format!("{name}.oso") };
    let mut candidates = vec![PathBuf::from(&file)];
    candidates.extend(path.split(':').filter(|p| !p.is_empty()).map(|folder| Path::new(folder).join(&file)));
    let found = candidates
        .into_iter()
        .find(|p| p.is_file())
        .ok_or_else(|| format!("File \"{file}\" could not be found."))?;
    let bytes = std::fs::read(&found).map_err(|e| e.to_string())?;
    read(&String::from_utf8_lossy(&bytes))
}

fn tokens(value: &Data) -> Vec<String> {
    match value {
        Data::Int(list) => list.iter().map(ToString::to_string).collect(),
        Data::Float(list) => list.iter().map(|&f| general(f64::from(f), 6)).collect(),
        Data::Str(list) => list.iter().map(|s| format!("\"{}\"", escape(s))).collect(),
    }
}

fn metadatum(out: &mut String, meta: &Meta) {
    let _ = writeln!(out, "\t\tmetadata: {} {} = {}", meta.ty, meta.name, tokens(&meta.value).join(" "));
}

fn type_keyword(ty: Type) -> String {
    if ty.base == Base::Closure { "closure color".to_owned() } else { ty.to_string() }
}

fn describe(shader: &Shader, verbose: bool, only: Option<&str>) -> String {
    let mut out = String::new();
    if only.is_none() {
        let _ = writeln!(out, "{} \"{}\"", shader.kind, shader.name);
        if verbose {
            for meta in &shader.meta {
                metadatum(&mut out, meta);
            }
        }
    }
    for (_, symbol) in shader.params() {
        if only.is_some_and(|name| name != &*symbol.name) {
            continue;
        }
        parameter(&mut out, shader, symbol, verbose);
    }
    out
}

fn parameter(out: &mut String, shader: &Shader, symbol: &Symbol, verbose: bool) {
    let output = if symbol.kind == gnurt_sl::ir::SymbolKind::OutputParam { "output " } else { "" };
    let spec = symbol.ty.struct_id().and_then(|id| shader.structs.get(id));
    let ty = spec.map_or_else(|| type_keyword(symbol.ty), |s| format!("struct {}", s.name));
    if verbose {
        let _ = writeln!(out, "    \"{}\" \"{output}{ty}\"", symbol.name);
    } else {
        let _ = write!(out, "{output}{ty} {} ", symbol.name);
    }
    if let Some(spec) = spec {
        let fields: Vec<String> = spec
            .fields
            .iter()
            .map(|field| {
                let found = shader.find(&format!("{}.{}", symbol.name, field.name));
                found.map_or("UNKNOWN".to_owned(), |id| {
                    format!("{} {}", type_keyword(shader.symbol(id).ty), field.name)
                })
            })
            .collect();
        let _ = writeln!(out, "{}fields: {{{}}}", if verbose { "\t\t" } else { "" }, fields.join(", "));
    } else if !symbol.init.is_empty() || symbol.ty.base == Base::Closure {
        out.push_str(if verbose { "\t\tUnknown default value\n" } else { "nodefault\n" });
    } else if let Some(value) = &symbol.value {
        let list = tokens(value);
        let many = symbol.ty.is_array() || symbol.ty.base.components() > 1;
        match value {
            Data::Str(_) if verbose => {
                for text in list {
                    let _ = writeln!(out, "\t\tDefault value: {text}");
                }
            }
            Data::Str(_) => {
                let _ = writeln!(out, "{} ", list.join(" "));
            }
            _ => {
                out.push_str(if verbose { "\t\tDefault value:" } else { "" });
                let text = list.join(" ");
                let _ = if many { writeln!(out, " [ {text} ]") } else { writeln!(out, " {text}") };
            }
        }
    }
    if verbose {
        for meta in &symbol.meta {
            metadatum(out, meta);
        }
    }
}
