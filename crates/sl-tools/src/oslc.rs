// SPDX-License-Identifier: GPL-3.0-or-later
//! The compiler's command line.
//! Options and output are those of OSL's `oslc`.

use super::console::Console;
use gnurt_sl::diagnostics::Style;
use gnurt_sl::ir::write;
use gnurt_sl::{Compiled, Options, compile, preprocess_only as preprocess};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const USAGE: &str = "\
oslc -- compiles a shader
Usage:  oslc [options] file
  Options:
\t--help         Print this usage message
\t-o filename    Specify output filename
\t-v             Verbose mode
\t-q             Quiet mode
\t-Ipath         Add path to the #include search path
\t-Dsym[=val]    Define preprocessor symbol
\t-Usym          Undefine preprocessor symbol
\t-O0, -O1, -O2  Set optimization level (default=1)
\t-d             Debug mode
\t-E             Only preprocess the input and output to stdout
\t-Werror        Treat all warnings as errors
\t-embed-source  Embed preprocessed source in the oso file
\t-buffer        (debugging) Force compile from buffer
\t-MD, -MMD      Write a depfile containing headers used, to a file
\t-M, -MM        Like -MD, but write depfile to stdout
\t-MF filename   Specify the name of the depfile to output (for -MD, -MMD)
\t-MT target     Specify a custom dependency target name for -M...
\t--strict-osl   Messages as OSL's compiler words them, one line each
\t--json         Messages as JSON objects, one line each
";

#[derive(Default)]
struct Call {
    options: Options,
    shown: Vec<String>,
    output: Option<String>,
    input: Option<String>,
    quiet: bool,
    only_preprocess: bool,
    embed: bool,
    dependencies: bool,
    system: bool,
    dependencies_to: Option<String>,
    target: Option<String>,
    style: Style,
}

/// Folders that `#include` searches after those of the command line.
pub(super) fn standard_folders() -> Vec<String> {
    let mut folders = vec![String::new()];
    for name in ["OSL_ROOT", "OSL_ROOT_DIR", "OSLHOME"] {
        if let Ok(home_folder) = std::env::var(name) {
            for end in ["share/OSL/shaders", "share/shaders", "shaders"] {
                let folder = Path::new(&home_folder).join(end);
                if folder.is_dir() {
                    folders.push(folder.to_string_lossy().into_owned());
                }
            }
        }
    }
    folders
}

/// Reads a file for `#include`.
pub(super) fn load(path: &Path) -> Option<String> {
    let bytes = std::fs::read(path).ok()?;
    Some(String::from_utf8_lossy(&bytes).into_owned())
}

fn parse(args: &[String], link: bool) -> Result<Call, Option<String>> {
    let mut call = Call { style: if link { Style::Strict } else { Style::Drawn }, ..Call::default() };
    let mut rest = args.iter();
    while let Some(arg) = rest.next() {
        let mut value =
            |name: &str| rest.next().cloned().ok_or_else(|| Some(format!("{name} needs a value")));
        let mut shown = true;
        match arg.as_str() {
            "--help" | "-h" => return Err(None),
            "-q" => call.quiet = true,
            "-v" | "-d" | "-O" | "-O0" | "-O1" | "-O2" | "-Wall" | "-buffer" => {}
            "-o" => call.output = Some(value("-o")?),
            "-E" => (call.only_preprocess, call.quiet) = (true, true),
            "-Werror" => call.options.warnings_are_errors = true,
            "-embed-source" | "--embed-source" => call.embed = true,
            "-MD" | "--write-dependencies" => (call.dependencies, call.system) = (true, true),
            "-MMD" | "--write-user-dependencies" => call.dependencies = true,
            "-M" | "--dependencies" | "-MM" | "--user-dependencies" => {
                call.dependencies = true;
                call.system = matches!(arg.as_str(), "-M" | "--dependencies");
                (call.only_preprocess, call.quiet) = (true, true);
                call.dependencies_to.get_or_insert_with(|| "stdout".to_owned());
            }
            "-MF" => call.dependencies_to = Some(value("-MF")?),
            "-MT" => call.target = Some(value("-MT")?),
            "--strict-osl" => call.style = Style::Strict,
            "--json" => call.style = Style::Json,
            _ => {
                if let Some(name) = arg.strip_prefix("-MF") {
                    call.dependencies_to = Some(name.to_owned());
                } else if let Some(name) = arg.strip_prefix("-MT") {
                    call.target = Some(name.to_owned());
                } else if matches!(arg.as_str(), "-D" | "-U" | "-I") {
                    return Err(Some(format!("{arg} needs a value, without a space: {arg}VALUE")));
                } else if let Some(macro_text) = arg.strip_prefix("-D") {
                    call.options.defines.push(macro_text.to_owned());
                } else if let Some(name) = arg.strip_prefix("-U") {
                    call.options.undefines.push(name.to_owned());
                } else if let Some(folder) = arg.strip_prefix("-I") {
                    call.options.includes.push(folder.to_owned());
                } else if arg.len() > 1 && arg.starts_with('-') && !Path::new(arg).exists() {
                    return Err(Some(format!("unknown option {arg}; oslc --help lists all")));
                } else {
                    // OSL's compiler takes the last one.
                    if let Some(first) = call.input.replace(arg.clone()).filter(|_| !link) {
                        return Err(Some(format!("{first} and {arg}: one file at a time")));
                    }
                    shown = false;
                }
            }
        }
        if shown {
            call.shown.push(arg.clone());
        }
    }
    call.options.strict = call.style == Style::Strict;
    call.options.includes.extend(standard_folders());
    Ok(call)
}

/// Runs the compiler; returns the exit status.
pub fn oslc(args: &[String], console: &mut Console<'_>) -> i32 {
    if args.is_empty() {
        console.print(USAGE);
        return 0;
    }
    let call = match parse(args, console.link) {
        Ok(call) => call,
        Err(None) => {
            console.print(USAGE);
            return 0;
        }
        Err(Some(message)) => {
            console.complain(&format!("error: {message}\n"));
            return 2;
        }
    };
    let Some(input) = call.input.clone() else {
        console.print(&format!("ERROR: Missing shader path\n\n{USAGE}"));
        return 1;
    };
    let done = run(&call, &input, console);
    match done {
        Some(output) => {
            if !call.quiet {
                console.print(&format!("Compiled {input} -> {output}\n"));
            }
            0
        }
        None => {
            if call.style != Style::Json {
                console.print(&format!("FAILED {input}\n"));
            }
            1
        }
    }
}

fn run(call: &Call, input: &str, console: &mut Console<'_>) -> Option<String> {
    let bytes = match std::fs::read(input) {
        Ok(bytes) => bytes,
        Err(why) if console.link || why.kind() == ErrorKind::NotFound => {
            console.complain(&format!("error: Input file \"{input}\" not found\n"));
            return None;
        }
        Err(why) => {
            console.complain(&format!("error: Input file \"{input}\" cannot be read: {why}\n"));
            return None;
        }
    };
    let text = String::from_utf8_lossy(&bytes);
    let (expanded, first) = if call.only_preprocess || call.embed {
        let (text, found) = preprocess(input, &text, &call.options, &load);
        (text, Some(found))
    } else {
        (String::new(), None)
    };
    if call.only_preprocess && !call.dependencies {
        let found = first?;
        report(&found, call.style, console);
        console.print(&expanded);
        return (found.diagnostics.errors == 0).then(String::new);
    }
    let compiled = compile(input, &text, &call.options, &load);
    report(&compiled, call.style, console);
    if call.dependencies && !dependencies(call, input, &compiled, console) {
        return None;
    }
    let shader = compiled.shader.as_ref()?;
    let output = call.output.clone().unwrap_or_else(|| format!("{}.oso", shader.name));
    let mut oso = write(shader, &call.shown.join(" "));
    if call.embed {
        oso.push_str(&format!("%preprocessed_source\n{expanded}\n"));
    }
    if let Err(why) = std::fs::write(&output, oso) {
        let why = if console.link { String::new() } else { format!(": {why}") };
        console.complain(&format!("error: Could not open \"{output}\"{why}\n"));
        return None;
    }
    Some(output)
}

fn report(compiled: &Compiled, style: Style, console: &mut Console<'_>) {
    for diagnostic in &compiled.diagnostics.list {
        console.complain(&diagnostic.render(&compiled.sources, style));
    }
}

fn dependencies(call: &Call, input: &str, compiled: &Compiled, console: &mut Console<'_>) -> bool {
    let renamed =
        |extension: &str| PathBuf::from(input).with_extension(extension).to_string_lossy().into_owned();
    let target = call.target.clone().or_else(|| call.output.clone()).unwrap_or_else(|| renamed("oso"));
    let mut text = format!("{target}: {input}");
    let mut read_files = vec![input.to_owned()];
    for file in compiled.sources.files() {
        let name = file.name.to_string();
        if (!file.system || call.system) && !name.starts_with('<') && !read_files.contains(&name) {
            text.push_str(&format!(" \\\n  {name}"));
            read_files.push(name);
        }
    }
    text.push('\n');
    let to = call.dependencies_to.clone().unwrap_or_else(|| renamed("d"));
    if to == "stdout" {
        console.print(&text);
        return true;
    }
    if std::fs::write(&to, text).is_err() {
        console.complain(&format!("error: Could not open dependency file '{to}' for writing\n"));
        return false;
    }
    true
}
