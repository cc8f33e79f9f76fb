// SPDX-License-Identifier: GPL-3.0-or-later
//! Makes the group that the command line describes.
//! The words are OSL's.

use super::options::{Options, Setup};
use crate::console::Console;
use crate::oslc::{load, standard_folders};
use gnurt_sl::diagnostics::Style;
use gnurt_sl::exec::unknown_operation;
use gnurt_sl::group::{Group, Hint, Value, read_group, write_group};
use gnurt_sl::ir::{Shader, read};
use gnurt_sl::{Options as CompileOptions, compile};
use std::collections::HashMap;
use std::sync::Arc;

/// Loads shaders once.
#[derive(Default)]
struct Loader {
    known: HashMap<String, Option<Arc<Shader>>>,
}

impl Loader {
    fn find(&mut self, name: &str, console: &mut Console<'_>) -> Option<Arc<Shader>> {
        if let Some(found) = self.known.get(name) {
            return found.clone();
        }
        let file = if name.ends_with(".oso") { name.to_owned() } else { format!("{name}.oso") };
        let found = match std::fs::read(&file) {
            Err(_) => {
                console.complain(&format!("ERROR: No .oso file could be found for shader \"{name}\"\n"));
                None
            }
            Ok(bytes) => match read(&String::from_utf8_lossy(&bytes)) {
                Ok(shader) => match unknown_operation(&shader) {
                    None => Some(Arc::new(shader)),
                    Some(op) => {
                        console.complain(&format!(
                            "ERROR: Parsing shader \"{}\": instruction \"{op}\" is not known. Maybe compiled with a too-new oslc?\nERROR: Unable to read \"{file}\"\n",
                            shader.name
                        ));
                        None
                    }
                },
                Err(message) => {
                    console.complain(&format!("ERROR: Unable to read \"{file}\": {message}\n"));
                    None
                }
            },
        };
        self.known.insert(name.to_owned(), found.clone());
        found
    }

    fn compile(&mut self, name: &str, text: &str, console: &mut Console<'_>) -> Option<Arc<Shader>> {
        let options =
            CompileOptions { includes: standard_folders(), strict: true, ..CompileOptions::default() };
        let compiled = compile("<buffer>", text, &options, &load);
        for diagnostic in &compiled.diagnostics.list {
            console.complain(&diagnostic.render(&compiled.sources, Style::Strict));
        }
        let Some(shader) = compiled.shader else {
            console.complain(&format!("Could not compile \"{name}\"\n"));
            return None;
        };
        let shader = Arc::new(shader);
        self.known.insert(name.to_owned(), Some(shader.clone()));
        Some(shader)
    }
}

fn expression(name: &str, text: &str) -> String {
    format!(
        "shader {name} (\n    float s = u [[ int interpolated=1 ]],\n    float t = v [[ int interpolated=1 ]],\n    output color result = 0,\n    output float alpha = 1,\n  )\n{{\n    {text}\n    ;\n}}\n"
    )
}

/// The group; none if it cannot be made, which has been reported.
pub(super) fn group(options: &Options, console: &mut Console<'_>) -> Option<Group> {
    let mut loader = Loader::default();
    let mut groups = 1;
    let name_of = |number: usize| {
        if options.groupname.is_empty() {
            format!("unnamed_group_{number}")
        } else {
            options.groupname.clone()
        }
    };
    let mut group = Group { name: name_of(1), ..Group::default() };
    let mut layer: Option<String> = None;
    let mut pending: Vec<(String, Value, Hint)> = Vec::new();
    let mut connections = Vec::new();
    let mut expressions = 0;
    let complain = |printed: &mut Vec<String>, console: &mut Console<'_>| {
        for message in printed.drain(..) {
            console.complain(&format!("WARNING: {message}\n"));
        }
    };
    for step in &options.setup {
        let mut printed = Vec::new();
        match step {
            Setup::Layer(name) => layer = Some(name.clone()),
            Setup::Param(name, value, hint) => pending.push((name.clone(), value.clone(), *hint)),
            Setup::Reparam(..) => {}
            Setup::Connect(tokens) => connections.push(tokens.clone()),
            Setup::Shader(name, given) => {
                let shader = if options.in_buffer {
                    let file = if name.ends_with(".osl") { name.clone() } else { format!("{name}.osl") };
                    let Ok(text) = std::fs::read_to_string(&file) else {
                        console.complain(&format!("Could not open \"{file}\"\n"));
                        return None;
                    };
                    Some(loader.compile(name, &text, console)?)
                } else {
                    loader.find(name, console)
                };
                let given = given.clone().or_else(|| layer.take());
                match shader {
                    Some(shader) => group.add(shader, given.as_deref(), &pending, &mut printed),
                    None => {
                        if !console.link && std::path::Path::new(name).extension().is_some_and(|e| e == "osl")
                        {
                            console.complain(&format!("{name} is source text: `oslc {name}` compiles it\n"));
                        }
                        let message = format!(
                            "ERROR: Could not find shader \"{name}\"\n        group: {}\n",
                            group.name
                        );
                        console.complain(&message);
                    }
                }
                pending.clear();
                layer = None;
            }
            Setup::Expr(text) => {
                let name = format!("expr_{expressions}");
                expressions += 1;
                let text = expression(&name, text);
                if options.verbose {
                    console.print(&format!("Expression-based shader text is:\n---\n{text}---\n"));
                }
                let shader = loader.compile(&name, &text, console)?;
                group.add(shader, layer.take().as_deref(), &pending, &mut printed);
                pending.clear();
            }
            Setup::Group(spec) => {
                let text = std::fs::read_to_string(spec).unwrap_or_else(|_| spec.clone());
                groups += 1;
                if options.verbose {
                    console.print(&format!("Processing group specification:\n---\n{text}\n---\n"));
                }
                let mut find = |name: &str| loader.find(name, console);
                match read_group(&name_of(groups), &text, &mut find, &mut printed) {
                    Ok(made) => group = made,
                    Err(messages) => {
                        complain(&mut printed, console);
                        for message in messages {
                            console.complain(&format!("ERROR: {message}\n"));
                        }
                        console.complain("ERROR: Invalid shader group. Exiting testshade.\n");
                        return None;
                    }
                }
            }
        }
        complain(&mut printed, console);
    }
    if !pending.is_empty() {
        let names: Vec<String> = pending.iter().map(|p| format!(" {}", p.0)).collect();
        console.complain(&format!(
            "ERROR: Pending parameters without a shader:{}\nDid you mistakenly put --param after the shader declaration?\n",
            names.concat()
        ));
        return None;
    }
    for [a, b, c, d] in &connections {
        console.print(&format!("Connect {a}.{b} to {c}.{d}\n"));
        if let Err(message) = group.connect(a, b, c, d) {
            console.complain(&format!("ERROR: {message}\n"));
            return None;
        }
    }
    if options.verbose || options.query {
        describe(&group, options, console);
    }
    Some(group)
}

fn describe(group: &Group, options: &Options, console: &mut Console<'_>) {
    console.print(&format!("Shader group:\n---\n{}\n---\n\n", write_group(group)));
    console.print(&format!("Shader group \"{}\" layers are:\n", group.name));
    for layer in &group.layers {
        console.print(&format!("    {}\n", layer.name));
        if options.query {
            for (_, symbol) in layer.shader.params() {
                let output =
                    if symbol.kind == gnurt_sl::ir::SymbolKind::OutputParam { "output " } else { "" };
                let ty = symbol.ty.display(&layer.shader.structs);
                console.print(&format!("\t{output}{ty} {}\n", symbol.name));
            }
        }
    }
    console.print("\n");
}
