// SPDX-License-Identifier: GPL-3.0-or-later
//! The definition of a node: by name, or by category, type of output, inputs, version and target.
//! Source: [MaterialX], "Custom Nodes", "NodeDef". Tests: `tests/documents.rs`.

use crate::library::Definitions;
use crate::xml::Element;

/// Definitions that may inherit from one another.
const LONGEST: usize = 16;

/// The targets whose definitions are used: those for any, and for the shading language.
fn is_for_us(def: &Element) -> bool {
    let target = def.get("target").unwrap_or("");
    target.is_empty() || target.split(',').any(|target| matches!(target.trim(), "osl" | "genosl"))
}

/// A document's definitions, and those embedded.
pub(crate) struct Known<'a> {
    pub(crate) own: Definitions<'a>,
    pub(crate) embedded: &'static Definitions<'static>,
}

impl<'a> Known<'a> {
    pub(crate) fn nodedef(&self, name: &str) -> Option<&'a Element> {
        // The files of a namespace may call their own definitions without it.
        let short = match name.rsplit(':').next().unwrap_or(name) {
            // Its name until 1.38.
            "ND_normalmap" => "ND_normalmap_float",
            short => short,
        };
        self.own.nodedef(name).or_else(|| self.own.nodedef(short)).or_else(|| self.embedded.nodedef(short))
    }

    pub(crate) fn graph(&self, def: &Element) -> Option<&'a Element> {
        self.own.graph(def.name()).or_else(|| self.embedded.graph(def.name()))
    }

    /// The definition and those that it inherits from, the closest first.
    pub(crate) fn line(&self, def: &'a Element) -> Vec<&'a Element> {
        let mut line = vec![def];
        while let Some(parent) =
            line.last().and_then(|def| def.given("inherit")).and_then(|name| self.nodedef(name))
            && line.len() < LONGEST
        {
            line.push(parent);
        }
        line
    }

    /// The definition's input of this name.
    pub(crate) fn input(&self, def: &'a Element, name: &str) -> Option<&'a Element> {
        self.line(def).into_iter().find_map(|def| def.child("input", name))
    }

    /// The outputs of a definition.
    pub(crate) fn outputs(&self, def: &'a Element) -> Vec<&'a Element> {
        let mut outputs: Vec<&Element> = Vec::new();
        for output in self.line(def).into_iter().flat_map(|def| def.all("output")) {
            if outputs.iter().all(|known| known.name() != output.name()) {
                outputs.push(output);
            }
        }
        outputs
    }

    /// The definition of a node.
    ///
    /// # Errors
    /// There is none.
    pub(crate) fn of(&self, node: &Element) -> Result<&'a Element, String> {
        if let Some(name) = node.given("nodedef") {
            return self.nodedef(name).ok_or_else(|| format!("there is no nodedef '{name}'"));
        }
        let category = node.tag.rsplit(':').next().unwrap_or(&node.tag);
        let of_category = self.own.of_node(&node.tag).iter().chain(self.own.of_node(category));
        let of_category = of_category.chain(self.embedded.of_node(category));
        let all: Vec<&'a Element> = of_category.copied().filter(|def| is_for_us(def)).collect();
        if all.is_empty() {
            return Err(format!("there is no node '{}'", node.tag));
        }
        let outputs = |def: &'a Element| {
            let outputs = self.outputs(def);
            match node.ty() {
                "" => true,
                "multioutput" => outputs.len() > 1,
                ty => outputs.len() == 1 && outputs[0].ty() == ty,
            }
        };
        let typed: Vec<&'a Element> = all.iter().copied().filter(|def| outputs(def)).collect();
        if typed.is_empty() {
            let mut types: Vec<&str> =
                all.iter().flat_map(|def| self.outputs(def)).map(|output| output.ty()).collect();
            types.sort_unstable();
            types.dedup();
            let (tag, ty) = (&node.tag, node.ty());
            return Err(format!("there is no node '{tag}' of type '{ty}'; types are {}", types.join(", ")));
        }
        let version =
            |def: &&&'a Element| node.given("version").is_none_or(|v| def.get("version") == Some(v));
        let versioned: Vec<&'a Element> = typed.iter().filter(version).copied().collect();
        let candidates = if versioned.is_empty() { typed } else { versioned };
        // The one with most of the node's inputs; of equal ones the default version.
        let fits = |def: &'a Element| {
            let inputs = node
                .all("input")
                .filter(|input| self.input(def, input.name()).is_some_and(|known| known.ty() == input.ty()));
            (inputs.count(), def.get("isdefaultversion") == Some("true"), def.given("version").is_none())
        };
        let mut best = candidates[0];
        for def in candidates {
            if fits(def) > fits(best) {
                best = def;
            }
        }
        Ok(best)
    }
}
