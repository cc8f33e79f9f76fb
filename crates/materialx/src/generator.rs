// SPDX-License-Identifier: GPL-3.0-or-later
//! From a node to one text in the shading language: all nodes behind it are emitted, each once, graphs expanded.
//! Source: [MaterialX], "Node Graphs", "Inputs", "Outputs", "Units", "Color Spaces". Tests: `tests`.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::fmt::Write;

use crate::document::Document;
use crate::error::Error;
use crate::library::{Definitions, embedded};
use crate::matching::Known;
use crate::names::identifier;
use crate::parts::{converted, swizzled};
use crate::types::{Ty, Value};
use crate::xml::Element;

/// Nodes that a node may expand to.
const MOST: usize = 1 << 14;

/// Nodes that may follow on one another.
const LONGEST: usize = 1500;

/// Where nodes have their inputs from.
struct Scope<'a> {
    /// The graph; the document's roots if there is none.
    graph: Option<&'a Element>,
    /// The scope of the graph's user; itself for the document.
    outer: usize,
    /// The node that the graph implements, and its definition.
    instance: Option<(&'a Element, &'a Element)>,
    /// Whether its values are the document's, and may be changed.
    is_document: bool,
    /// What its parameters' names begin with.
    path: String,
    /// The document's element that faults are reported at.
    site: &'a Element,
    known: HashMap<String, Value>,
    nodes: HashMap<&'a str, &'a Element>,
}

type Place<'a> = (usize, *const Element);

/// A node that is emitted.
pub(crate) struct Call<'a> {
    pub(crate) node: &'a Element,
    pub(crate) def: &'a Element,
    pub(crate) scope: usize,
    /// The type of the first output.
    pub(crate) out: Ty,
}

impl Call<'_> {
    pub(crate) fn category(&self) -> &str {
        self.def.get("node").unwrap_or(&self.node.tag)
    }
}

/// Outputs by name.
pub(crate) type Outputs = Vec<(String, Value)>;

/// The nodes that no graph defines.
pub(crate) trait Primitives {
    /// The outputs of a node.
    fn emit<'a>(&self, g: &mut Generator<'a>, call: &Call<'a>) -> Result<Outputs, Error>;

    /// Those of a node of a former version, which has no definition.
    fn without_definition<'a>(
        &self,
        g: &mut Generator<'a>,
        scope: usize,
        node: &'a Element,
    ) -> Result<Option<Outputs>, Error>;

    /// A geometric property by its kind, space and index.
    fn property(
        &self,
        g: &mut Generator<'_>,
        ty: Ty,
        kind: &str,
        space: &str,
        index: &str,
    ) -> Result<Value, String>;
}

pub(crate) struct Generator<'a> {
    document: &'a Document,
    primitives: &'static dyn Primitives,
    pub(crate) known: Known<'a>,
    scopes: Vec<Scope<'a>>,
    graphs: HashMap<Place<'a>, usize>,
    done: HashMap<Place<'a>, Outputs>,
    open: HashSet<(Place<'a>, String)>,
    count: usize,
    pub(crate) body: String,
    params: Vec<String>,
    names: HashSet<String>,
    /// Whether both sides of glass are one surface.
    pub(crate) is_thin: bool,
    /// The node whose inputs have parameters without a path.
    main: Option<*const Element>,
    pub(crate) helpers: BTreeSet<&'static str>,
    /// The offset of the material's surfaces, a vector.
    pub(crate) displacement: Option<String>,
    pub(crate) warnings: Vec<String>,
}

impl<'a> Generator<'a> {
    pub(crate) fn new(document: &'a Document, primitives: &'static dyn Primitives) -> Self {
        let known = Known { own: Definitions::of(document.root.children.iter()), embedded: embedded() };
        let mut generator = Self {
            document,
            primitives,
            known,
            scopes: Vec::new(),
            graphs: HashMap::new(),
            done: HashMap::new(),
            open: HashSet::new(),
            count: 0,
            body: String::new(),
            params: Vec::new(),
            names: HashSet::new(),
            is_thin: false,
            main: None,
            helpers: BTreeSet::new(),
            displacement: None,
            warnings: document.warnings.clone(),
        };
        generator.scopes.push(Scope {
            graph: None,
            outer: 0,
            instance: None,
            is_document: true,
            path: String::new(),
            site: &document.root,
            known: HashMap::new(),
            nodes: HashMap::new(),
        });
        generator
    }

    /// Makes a node's inputs parameters without a path.
    pub(crate) fn set_main(&mut self, node: &'a Element) {
        self.main = Some(std::ptr::from_ref(node));
        self.is_thin = ["thin_walled", "geometry_thin_walled"]
            .iter()
            .any(|name| node.child("input", name).is_some_and(|input| input.get("value") == Some("true")));
    }

    /// The parameters, each with a comma at its end.
    pub(crate) fn parameters(&self) -> &[String] {
        &self.params
    }

    /// A fault at the document's element that leads to a node.
    pub(crate) fn fault(&self, scope: usize, node: &'a Element, why: impl Into<String>) -> Error {
        let scope = &self.scopes[scope];
        match scope.is_document {
            true => self.document.fault(node, why),
            false => self.document.fault(scope.site, format!("{} within: {}", node.name(), why.into())),
        }
    }

    /// Reports a part that is left out, once.
    pub(crate) fn warn(&mut self, call: &Call<'a>, what: impl Into<String>) {
        let fault = self.fault(call.scope, call.node, what).to_string();
        if !self.warnings.contains(&fault) {
            self.warnings.push(fault);
        }
    }

    /// Gives an expression for each part names, unless it has one.
    pub(crate) fn bind(&mut self, ty: Ty, parts: Vec<String>) -> Value {
        let mut named = Vec::new();
        for (part, kind) in parts.into_iter().zip(ty.parts()) {
            let is_short = part.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.'));
            named.push(if is_short { part } else { self.name(kind, &part) });
        }
        Value::new(ty, named)
    }

    /// A variable with a value.
    pub(crate) fn name(&mut self, kind: &str, value: &str) -> String {
        self.count += 1;
        let name = format!("_{}", self.count);
        let _ = writeln!(self.body, "    {kind} {name} = {value};");
        name
    }

    /// A list of numbers, with values unless there are none.
    pub(crate) fn list(&mut self, len: usize, values: &str) -> String {
        self.count += 1;
        let name = format!("_{}", self.count);
        let values = if values.is_empty() { String::new() } else { format!(" = {{{values}}}") };
        let _ = writeln!(self.body, "    float {name}[{len}]{values};");
        name
    }

    /// Asks for a function of the text's head.
    pub(crate) fn needs(&mut self, helper: &'static str) {
        self.helpers.insert(helper);
    }

    /// An input of a node.
    pub(crate) fn arg(&mut self, call: &Call<'a>, name: &str) -> Result<Value, Error> {
        self.input(call.scope, call.node, call.def, name)
    }

    /// Whether an input is connected to something, or has a value that is not empty.
    pub(crate) fn is_given(&self, call: &Call<'a>, name: &str) -> bool {
        call.node.child("input", name).is_some_and(|input| {
            ["value", "nodename", "nodegraph", "interfacename", "output"]
                .iter()
                .any(|a| input.given(a).is_some())
        })
    }

    /// The text of an input that chooses between variants.
    pub(crate) fn word(&mut self, call: &Call<'a>, name: &str) -> Result<String, Error> {
        let value = self.arg(call, name)?;
        match value.text {
            Some(text) => Ok(text),
            None => Err(self.fault(call.scope, call.node, format!("'{name}' is not a fixed text"))),
        }
    }

    pub(crate) fn input(
        &mut self,
        scope: usize,
        node: &'a Element,
        def: &'a Element,
        name: &str,
    ) -> Result<Value, Error> {
        let known = self.known.input(def, name);
        let declared = known.map(|known| known.ty());
        // Names of former versions.
        let former = match (def.get("node"), name) {
            (Some("atan2"), "iny") => "in1",
            (Some("atan2"), "inx") => "in2",
            _ => name,
        };
        let port = node.child("input", name).or_else(|| node.child("input", former));
        let ty = declared.or(port.map(|port| port.ty())).unwrap_or("");
        let Some(ty) = Ty::of(ty) else {
            let why = format!("input '{name}' has the type '{ty}', which is not supported");
            return Err(self.fault(scope, node, why));
        };
        if let Some(port) = port {
            // The definition's graph computes with the definition's unit.
            let unit = known.and_then(|known| known.given("unit"));
            if let Some(value) = self.source(scope, Some(node), port, ty, unit)? {
                return self.coerced(scope, node, name, value, ty);
            }
        }
        let Some(known) = known else {
            return Err(self.fault(scope, node, format!("input '{name}' has no value")));
        };
        if let Some(property) = known.given("defaultgeomprop") {
            return self.property(scope, node, property);
        }
        let Some(text) = known.get("value").filter(|value| !value.is_empty() || ty.is_text()) else {
            return Ok(Value::zero(ty));
        };
        let is_main = self.main == Some(std::ptr::from_ref(node)) && self.scopes[scope].is_document;
        let parameter = is_main.then(|| name.to_owned());
        self.literal(scope, node, ty, text, known.color_space.as_deref(), parameter)
    }

    /// The value that an input or an output of a graph has or is connected to.
    fn source(
        &mut self,
        scope: usize,
        owner: Option<&'a Element>,
        port: &'a Element,
        ty: Ty,
        unit: Option<&str>,
    ) -> Result<Option<Value>, Error> {
        let mut value = if let Some(name) = port.given("interfacename") {
            self.interface(scope, port, name)?
        } else if let Some(name) = port.given("nodename") {
            let Some(node) = self.node(scope, port, name) else {
                return Err(self.fault(scope, port, format!("there is no node '{name}'")));
            };
            Some(self.output(scope, node, port.given("output"), port)?)
        } else if let Some(name) = port.given("nodegraph") {
            let outer = if self.scopes[scope].graph.is_some() { self.scopes[scope].outer } else { scope };
            let found =
                [scope, outer, 0].into_iter().find_map(|at| self.node(at, port, name).map(|node| (at, node)));
            let Some((at, graph)) = found.filter(|(_, graph)| *graph.tag == *"nodegraph") else {
                return Err(self.fault(scope, port, format!("there is no node graph '{name}'")));
            };
            Some(self.output(at, graph, port.given("output"), port)?)
        } else if let Some(name) = port.given("output") {
            let found =
                [scope, 0].into_iter().find_map(|at| self.node(at, port, name).map(|node| (at, node)));
            let Some((at, output)) = found else {
                return Err(self.fault(scope, port, format!("there is no output '{name}'")));
            };
            Some(self.output(at, output, None, port)?)
        } else if let Some(text) = port.get("value").filter(|value| !value.is_empty() || ty.is_text()) {
            let is_main = owner.is_some_and(|owner| self.main == Some(std::ptr::from_ref(owner)));
            let owner = owner.map_or("", |owner| owner.name());
            let parameter = self.scopes[scope].is_document.then(|| match is_main {
                true => port.name().to_owned(),
                false => [&*self.scopes[scope].path, owner, port.name()]
                    .into_iter()
                    .filter(|part| !part.is_empty())
                    .collect::<Vec<_>>()
                    .join("_"),
            });
            let own = Ty::of(port.ty()).unwrap_or(ty);
            let value = self.literal(scope, port, own, text, port.color_space.as_deref(), parameter)?;
            Some(self.in_unit(scope, port, value, unit)?)
        } else {
            None
        };
        if let (Some(channels), Some(found)) = (port.given("channels"), &mut value) {
            let picked = swizzled(found, channels, ty);
            let picked = picked.map_err(|why| self.fault(scope, port, why))?;
            value = Some(self.bind(ty, picked));
        }
        Ok(value)
    }

    /// An input of the graph of a scope.
    fn interface(&mut self, scope: usize, port: &'a Element, name: &str) -> Result<Option<Value>, Error> {
        if let Some(known) = self.scopes[scope].known.get(name) {
            return Ok(Some(known.clone()));
        }
        let Scope { graph, outer, instance, .. } = self.scopes[scope];
        let value = match (instance, graph) {
            (Some((node, def)), _) => {
                if self.known.input(def, name).is_none() && node.child("input", name).is_none() {
                    return Err(self.fault(scope, port, format!("'{}' has no input '{name}'", def.name())));
                }
                Some(self.input(outer, node, def, name)?)
            }
            (None, Some(graph)) => {
                let Some(input) = graph.child("input", name) else {
                    return Err(self.fault(scope, port, format!("the graph has no input '{name}'")));
                };
                let ty = Ty::of(input.ty()).unwrap_or(Ty::Float);
                let value = match input.given("defaultgeomprop") {
                    Some(property) if input.given("nodename").is_none() && input.given("value").is_none() => {
                        Some(self.property(outer, input, property)?)
                    }
                    _ => self.source(outer, Some(graph), input, ty, None)?,
                };
                Some(value.unwrap_or_else(|| Value::zero(ty)))
            }
            _ => return Err(self.fault(scope, port, format!("interface '{name}' outside of a graph"))),
        };
        if let Some(value) = &value {
            self.scopes[scope].known.insert(name.to_owned(), value.clone());
        }
        Ok(value)
    }

    /// A node or an output of a scope.
    fn node(&mut self, scope: usize, user: &'a Element, name: &str) -> Option<&'a Element> {
        let Some(graph) = self.scopes[scope].graph else {
            return self.document.find(name, Some(user));
        };
        let nodes = &mut self.scopes[scope].nodes;
        if nodes.is_empty() {
            for child in graph.children.iter().rev().filter(|child| *child.tag != *"input") {
                // A node comes before an output of its name.
                if *child.tag != *"output" || !nodes.contains_key(child.name()) {
                    nodes.insert(child.name(), child);
                }
            }
        }
        nodes.get(name).copied()
    }

    /// An output of a node, of a graph, or the value of an output.
    pub(crate) fn output(
        &mut self,
        scope: usize,
        node: &'a Element,
        name: Option<&str>,
        user: &'a Element,
    ) -> Result<Value, Error> {
        let place = (scope, std::ptr::from_ref(node));
        let key = (place, name.unwrap_or("").to_owned());
        if self.open.len() >= LONGEST {
            return Err(self.fault(scope, user, format!("more than {LONGEST} nodes follow on one another")));
        }
        if !self.open.insert(key.clone()) {
            return Err(self.fault(scope, node, format!("'{}' depends on itself", node.name())));
        }
        let value = self.output_of(scope, node, name, user);
        self.open.remove(&key);
        value
    }

    fn output_of(
        &mut self,
        scope: usize,
        node: &'a Element,
        name: Option<&str>,
        user: &'a Element,
    ) -> Result<Value, Error> {
        match &*node.tag {
            "output" => {
                let ty = Ty::of(node.ty()).unwrap_or(Ty::Float);
                let value = self.source(scope, None, node, ty, None)?;
                return value.ok_or_else(|| self.fault(scope, node, "the output has no source"));
            }
            "nodegraph" => {
                let inner = self.graph(scope, node, node, None)?;
                return self.result(inner, scope, node, name, user);
            }
            _ => {}
        }
        let place = (scope, std::ptr::from_ref(node));
        if !self.done.contains_key(&place) {
            if let Some(outputs) = self.primitives.without_definition(self, scope, node)? {
                self.done.insert(place, outputs);
            } else {
                let def = self.known.of(node).map_err(|why| self.fault(scope, node, why))?;
                if let Some(graph) = self.known.graph(def) {
                    let inner = self.graph(scope, node, graph, Some(def))?;
                    return self.result(inner, scope, node, name, user);
                }
                self.charge(scope, node)?;
                let out = self.known.outputs(def).first().and_then(|output| Ty::of(output.ty()));
                let Some(out) = out else {
                    return Err(self.fault(
                        scope,
                        node,
                        format!("'{}' has no output of a known type", def.name()),
                    ));
                };
                let _ = writeln!(
                    self.body,
                    "    // {}{}",
                    comment(&self.scopes[scope].path),
                    comment(node.name())
                );
                let outputs = self.primitives.emit(self, &Call { node, def, scope, out })?;
                self.done.insert(place, outputs);
            }
        }
        let outputs = &self.done[&place];
        let found = match name {
            // A node with one output has it by any name.
            Some(name) if outputs.len() > 1 => outputs.iter().find(|(known, _)| known == name),
            _ => outputs.first(),
        };
        let value = found.map(|(_, value)| value.clone());
        value.ok_or_else(|| {
            self.fault(scope, user, format!("'{}' has no output '{}'", node.name(), name.unwrap_or("")))
        })
    }

    fn charge(&mut self, scope: usize, node: &'a Element) -> Result<(), Error> {
        self.count += 1;
        match self.count > MOST {
            true => Err(self.fault(scope, node, format!("the node expands to more than {MOST} nodes"))),
            false => Ok(()),
        }
    }

    /// The scope of a graph: of its own, or of a node that it implements.
    fn graph(
        &mut self,
        outer: usize,
        node: &'a Element,
        graph: &'a Element,
        def: Option<&'a Element>,
    ) -> Result<usize, Error> {
        let place = (outer, std::ptr::from_ref(node));
        if let Some(known) = self.graphs.get(&place) {
            return Ok(*known);
        }
        self.charge(outer, node)?;
        let user = &self.scopes[outer];
        let is_main = self.main == Some(std::ptr::from_ref(node));
        let path = match (user.path.is_empty(), is_main) {
            (_, true) => String::new(),
            (true, _) => node.name().to_owned(),
            (false, _) => format!("{}_{}", user.path, node.name()),
        };
        let scope = Scope {
            graph: Some(graph),
            outer,
            instance: def.map(|def| (node, def)),
            is_document: user.is_document && def.is_none(),
            path,
            site: if user.is_document { node } else { user.site },
            known: HashMap::new(),
            nodes: HashMap::new(),
        };
        self.scopes.push(scope);
        self.graphs.insert(place, self.scopes.len() - 1);
        Ok(self.scopes.len() - 1)
    }

    /// An output of a graph's scope.
    fn result(
        &mut self,
        inner: usize,
        scope: usize,
        node: &'a Element,
        name: Option<&str>,
        user: &'a Element,
    ) -> Result<Value, Error> {
        let graph = self.scopes[inner].graph.unwrap_or(node);
        let outputs: Vec<&'a Element> =
            graph.children.iter().filter(|child| *child.tag == *"output").collect();
        let found = match (name, &outputs[..]) {
            // A graph with one output has it by any name.
            (_, [only]) => Some(*only),
            (Some(name), all) => all.iter().copied().find(|output| output.name() == name),
            (None, all) => all.first().copied(),
        };
        let Some(found) = found else {
            let why = format!("'{}' has no output '{}'", node.name(), name.unwrap_or(""));
            return Err(self.fault(scope, user, why));
        };
        let value = self.output(inner, found, None, user)?;
        let declared = Ty::of(found.ty()).unwrap_or(value.ty);
        self.coerced(scope, node, found.name(), value, declared)
    }

    /// The value as another type.
    fn coerced(
        &mut self,
        scope: usize,
        node: &'a Element,
        name: &str,
        value: Value,
        ty: Ty,
    ) -> Result<Value, Error> {
        if value.ty == ty || value.ty.parts() == ty.parts() {
            return Ok(Value { ty, ..value });
        }
        match converted(&value, ty) {
            Some(parts) => Ok(self.bind(ty, parts)),
            None => {
                let (from, to) = (value.ty.name(), ty.name());
                Err(self.fault(scope, node, format!("'{name}' is a {to}, and is connected to a {from}")))
            }
        }
    }

    /// A value that is written in a document.
    fn literal(
        &mut self,
        scope: usize,
        at: &'a Element,
        ty: Ty,
        text: &str,
        color_space: Option<&str>,
        parameter: Option<String>,
    ) -> Result<Value, Error> {
        if ty.is_text() {
            let mut text = self.untokened(scope, text, 0);
            if ty == Ty::Filename && !text.is_empty() {
                text = format!("{}{text}", at.file_prefix);
            }
            let mut value = Value::word(ty, text);
            value.color_space = color_space.map(str::to_owned);
            if let (Ty::Filename, Some(path)) = (ty, parameter) {
                value.parts = vec![self.parameter("string", &path, value.first())];
            }
            return Ok(value);
        }
        if ty.is_closure() || ty == Ty::Displacement {
            return Ok(Value::zero(ty));
        }
        let numbers = ty.numbers(text).map_err(|why| self.fault(scope, at, why))?;
        let mut value = Value::new(ty, ty.spelled(&numbers));
        if matches!(ty, Ty::Boolean | Ty::Integer) {
            value.text = Some(text.trim().to_owned());
        }
        if let Some(path) = parameter {
            let kinds = ty.parts();
            value.parts = if kinds.len() == 1 {
                vec![self.parameter(kinds[0], &path, value.first())]
            } else {
                let list = numbers.iter().map(|x| crate::types::number(*x)).collect::<Vec<_>>().join(", ");
                let name =
                    self.parameter(&format!("float[{}]", numbers.len()), &path, &format!("{{{list}}}"));
                match ty {
                    Ty::Color4 => {
                        vec![format!("color({name}[0], {name}[1], {name}[2])"), format!("{name}[3]")]
                    }
                    _ => (0..numbers.len()).map(|i| format!("{name}[{i}]")).collect(),
                }
            };
            value = Value { text: value.text.take(), ..self.bind(ty, value.parts) };
        }
        match color_space {
            Some(space) if ty.is_color() => self.in_linear(scope, at, value, space),
            _ => Ok(value),
        }
    }

    /// Adds a parameter, and gives its name.
    fn parameter(&mut self, kind: &str, path: &str, default: &str) -> String {
        let plain = identifier(path);
        let mut name = plain.clone();
        let mut again = 1;
        while !self.names.insert(name.clone()) {
            again += 1;
            name = format!("{plain}_{again}");
        }
        let (kind, array) = kind.split_at(kind.find('[').unwrap_or(kind.len()));
        self.params.push(format!("{kind} {name}{array} = {default}"));
        name
    }

    /// A colour in linear Rec. 709.
    pub(crate) fn in_linear(
        &mut self,
        scope: usize,
        at: &'a Element,
        value: Value,
        space: &str,
    ) -> Result<Value, Error> {
        if is_linear(space) {
            return Ok(value);
        }
        let ty = value.ty;
        let def = self.known.nodedef(&format!("ND_{space}_to_lin_rec709_{}", ty.name()));
        let Some((def, graph)) = def.and_then(|def| Some((def, self.known.graph(def)?))) else {
            return Err(self.fault(scope, at, format!("unknown colour space '{space}'")));
        };
        self.charge(scope, at)?;
        let user = &self.scopes[scope];
        let (path, site) = (user.path.clone(), if user.is_document { at } else { user.site });
        self.scopes.push(Scope {
            graph: Some(graph),
            outer: scope,
            instance: Some((at, def)),
            is_document: false,
            path,
            site,
            known: HashMap::from([("in".to_owned(), value)]),
            nodes: HashMap::new(),
        });
        self.result(self.scopes.len() - 1, scope, at, None, at)
    }

    /// A value in the unit that a definition counts in.
    fn in_unit(
        &mut self,
        scope: usize,
        port: &'a Element,
        value: Value,
        wanted: Option<&str>,
    ) -> Result<Value, Error> {
        let Some(given) = port.given("unit").filter(|given| Some(*given) != wanted) else { return Ok(value) };
        let (own, all) = (&self.known.own, self.known.embedded);
        let ty = own.unit_type(given).or_else(|| all.unit_type(given));
        let scale = |unit: &str| ty.and_then(|ty| own.unit(ty, unit).or_else(|| all.unit(ty, unit)));
        let Some(from) = scale(given) else {
            return Err(self.fault(scope, port, format!("unknown unit '{given}'")));
        };
        // Distances are metres and angles degrees where the definition says nothing.
        let factor = from / wanted.and_then(scale).unwrap_or(1.0);
        if factor == 1.0 || !matches!(value.ty, Ty::Float | Ty::Vector2 | Ty::Vector3 | Ty::Vector4) {
            return Ok(value);
        }
        let factor = crate::types::number(factor);
        let parts = value.parts.iter().map(|part| format!("{part} * {factor}")).collect();
        Ok(self.bind(value.ty, parts))
    }

    /// A text with its tokens replaced.
    fn untokened(&self, scope: usize, text: &str, depth: usize) -> String {
        let mut out = String::new();
        let mut rest = text;
        while let Some((before, after)) = rest.split_once('[') {
            out.push_str(before);
            let found =
                after.split_once(']').and_then(|(name, after)| Some((self.token(scope, name)?, after)));
            match found {
                // Tokens within tokens end somewhere.
                Some((value, after)) if depth < 4 && out.len() < 4096 => {
                    out.push_str(&self.untokened(scope, value, depth + 1));
                    rest = after;
                }
                _ => {
                    out.push('[');
                    rest = after;
                }
            }
        }
        out.push_str(rest);
        out
    }

    fn token(&self, scope: usize, name: &str) -> Option<&'a str> {
        let mut scope = scope;
        loop {
            let Scope { graph, outer, instance, .. } = &self.scopes[scope];
            let own = instance.iter().flat_map(|(node, def)| [*node, *def]).chain(*graph);
            let root = graph.is_none().then_some(&self.document.root);
            let found = own.chain(root).find_map(|element| element.child("token", name)?.get("value"));
            if found.is_some() || *outer == scope {
                return found;
            }
            scope = *outer;
        }
    }

    /// A geometric property that inputs have by default.
    fn property(&mut self, scope: usize, at: &'a Element, name: &str) -> Result<Value, Error> {
        let def =
            self.known.own.geomprops.get(name).or_else(|| self.known.embedded.geomprops.get(name)).copied();
        let Some(def) = def else {
            return Err(self.fault(scope, at, format!("unknown geometric property '{name}'")));
        };
        let ty = Ty::of(def.ty()).unwrap_or(Ty::Vector3);
        let kind = def.get("geomprop").unwrap_or("").to_owned();
        self.primitives
            .property(self, ty, &kind, def.get("space").unwrap_or(""), def.get("index").unwrap_or("0"))
            .map_err(|why| self.fault(scope, at, why))
    }
}

/// Whether values of a colour space need no change.
pub(crate) fn is_linear(space: &str) -> bool {
    matches!(space, "" | "none" | "raw" | "data" | "linear" | "lin_rec709" | "lin_rec709_scene" | "lin_srgb")
}

/// A name within a comment.
fn comment(name: &str) -> String {
    name.chars().filter(|c| !c.is_control()).take(80).collect::<String>() + " "
}
