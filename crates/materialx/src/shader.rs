// SPDX-License-Identifier: GPL-3.0-or-later
//! The shader of a document's material or node. Tests: `tests`.

use std::fmt::Write;

use crate::document::Document;
use crate::error::Error;
use crate::generator::Generator;
use crate::names::identifier;
use crate::primitives::{All, helpers};
use crate::types::Value;
use crate::xml::Element;

/// Stack of the thread that generates: nodes follow on one another.
const STACK: usize = 256 << 20;

/// A text in the shading language.
#[derive(Clone, Debug)]
pub struct Shader {
    /// The material's or node's name in the document.
    pub name: String,
    /// The text.
    pub text: String,
    /// What is left out: a line each, with file and line.
    pub warnings: Vec<String>,
}

impl Document {
    /// The shader of a material, a node or a graph's output (`graph/output`); without a name of the only material, or of
    /// the only thing that could be shown.
    ///
    /// # Errors
    /// There is none of this name, or the document has faults that keep it from being one.
    pub fn shader(&self, name: Option<&str>) -> Result<Shader, Error> {
        let path = self.paths().next().unwrap_or(std::path::Path::new("")).to_owned();
        let name = match name {
            Some(name) => name.to_owned(),
            None => self.only().map_err(|why| Error::new(&path, 0, why))?,
        };
        let fault = |why: String| Error::new(&path, 0, why);
        std::thread::scope(|scope| {
            let generate = || self.generated(&name);
            let made = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, generate);
            let made = made.map_err(|error| fault(format!("no thread: {error}")))?;
            made.join().unwrap_or_else(|_| Err(fault("the document cannot be understood".to_owned())))
        })
    }

    fn only(&self) -> Result<String, String> {
        let materials = self.materials();
        let all = if materials.is_empty() { self.shown() } else { materials };
        match &all[..] {
            [one] => Ok(one.clone()),
            [] => Err("there is no material in the document".to_owned()),
            several => Err(format!("there are several; name one of them: {}", listed(several))),
        }
    }

    fn generated(&self, name: &str) -> Result<Shader, Error> {
        let (node, output) = match (self.find(name, None), name.split_once('/')) {
            (Some(node), _) => (Some(node), None),
            (None, Some((graph, output))) => (self.find(graph, None), Some(output)),
            (None, None) => (None, None),
        };
        let Some(node) = node.filter(|node| !matches!(&*node.tag, "nodedef" | "look" | "implementation"))
        else {
            let mut all = self.materials();
            all.extend(self.shown());
            let path = self.paths().next().unwrap_or(std::path::Path::new(""));
            return Err(Error::new(path, 0, format!("there is no '{name}'; there are {}", listed(&all))));
        };
        let mut g = Generator::new(self, &All);
        g.set_main(self.shader_of(node).unwrap_or(node));
        let value = g.output(0, node, output, node)?;
        let text = written(name, &g, &value);
        Ok(Shader { name: name.to_owned(), text, warnings: g.warnings })
    }

    /// The shader node of a material.
    fn shader_of<'a>(&'a self, material: &'a Element) -> Option<&'a Element> {
        self.find(material.child("input", "surfaceshader")?.given("nodename")?, Some(material))
    }
}

/// Names in a message.
fn listed(names: &[String]) -> String {
    let mut list: Vec<&str> = names.iter().take(20).map(|name| &**name).collect();
    if names.len() > list.len() {
        list.push("...");
    }
    if list.is_empty() { "none".to_owned() } else { list.join(", ") }
}

/// The whole text: closures are `Ci`; other values are outputs, and shine. The offset of a material with a displacement shader is
/// the output `displacement`.
fn written(name: &str, g: &Generator<'_>, value: &Value) -> String {
    let mut text = String::from("// Made of a MaterialX document.\n");
    for (helper, body) in helpers::ALL {
        if g.helpers.contains(helper) {
            text.push_str(body);
        }
    }
    let mut parameters: Vec<String> = g.parameters().to_vec();
    let kinds = value.ty.parts();
    let mut set = String::new();
    if value.ty.is_closure() {
        let _ = writeln!(set, "    Ci = {};", value.first());
    } else if value.ty.is_text() {
        let _ = writeln!(set, "    Ci = 0;");
    } else {
        for (i, (kind, part)) in kinds.iter().zip(&value.parts).enumerate() {
            let out = if i == 0 { "result".to_owned() } else { format!("result_{i}") };
            parameters.push(format!("output {kind} {out} = 0"));
            let _ = writeln!(set, "    {out} = {part};");
        }
        let color = match kinds[0] {
            "color" | "vector" => "color(result)".to_owned(),
            "matrix" => "color(0)".to_owned(),
            _ => match kinds.len() {
                1 => "color(result)".to_owned(),
                2 => "color(result, result_1, 0)".to_owned(),
                _ => "color(result, result_1, result_2)".to_owned(),
            },
        };
        let _ = writeln!(set, "    Ci = uniform_edf({color});");
    }
    if let Some(displacement) = &g.displacement {
        parameters.push("output vector displacement = 0".to_owned());
        let _ = writeln!(set, "    displacement = {displacement};");
    }
    let parameters: Vec<String> = parameters.into_iter().map(|line| format!("    {line}")).collect();
    let _ =
        write!(text, "surface {}(\n{}\n) {{\n{}{set}}}\n", identifier(name), parameters.join(",\n"), g.body);
    text
}
