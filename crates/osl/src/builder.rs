// SPDX-License-Identifier: GPL-3.0-or-later
//! A group in the making: layers with parameters, connections, outputs.

use std::sync::Arc;

use gnurt_sl::exec::{Plan, PlanOptions, Program};
use gnurt_sl::group::{Group, Hint, Value};

use crate::engine::{Engine, Engines};
use crate::error::Error;
use crate::faults;
use crate::group::ShaderGroup;
use crate::live::Live;
use crate::needs::Needs;
use crate::shader::Shader;

/// A group in the making. Faults are kept until [`build`](Self::build), which reports all of them.
///
/// The last layer is the result: the `Ci` that counts is the one that is there when it ends. Other layers run only if a
/// connection leads from them to a layer that runs, or if one of their outputs is kept; see
/// [`ShaderGroup::warnings`]. So patterns come first, and the surface last.
#[derive(Debug)]
pub struct GroupBuilder {
    engines: Engines,
    group: Group,
    /// Of the next shader.
    values: Vec<(String, Value, Hint)>,
    outputs: Vec<String>,
    live: Vec<Live>,
    faults: Vec<String>,
}

impl GroupBuilder {
    pub(crate) fn new(engines: Engines, name: &str) -> Self {
        let group = Group { name: name.to_owned(), ..Group::default() };
        Self { engines, group, values: Vec::new(), outputs: Vec::new(), live: Vec::new(), faults: Vec::new() }
    }

    /// A parameter of the next shader: a number, a text, three floats, a matrix, an array, or another
    /// [`Value`]. Numbers fit all types that are made of floats; ints fit floats. Members of structs are named
    /// `struct.member`.
    #[must_use]
    pub fn param(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.values.push((name.to_owned(), value.into(), Hint::default()));
        self
    }

    /// A parameter of the next shader that [`ShaderGroup::set`] may change: ints, floats, triples, matrices, and
    /// arrays of them, whose lengths stay. Texts and connected parameters cannot be live. The name must be the only one of a live or
    /// interpolated parameter in the group.
    ///
    /// The value is not built into the machine code, so that it cannot be simplified by it.
    #[must_use]
    pub fn live_param(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.values.push((name.to_owned(), value.into(), Hint { interpolated: true, interactive: true }));
        self
    }

    /// Adds a shader with the parameters before, as a layer of this name.
    #[must_use]
    pub fn shader(mut self, shader: &Shader, layer: &str) -> Self {
        if self.group.find(layer).is_some() {
            self.faults.push(format!("two layers are named '{layer}'"));
        }
        let mut values = std::mem::take(&mut self.values);
        values.retain(|(name, value, _)| {
            let fault = faults::of_value(&shader.shader, layer, name, value);
            let is_fine = fault.is_none();
            self.faults.extend(fault);
            is_fine
        });
        for (name, value, _) in values.iter().filter(|(_, _, hint)| hint.interactive) {
            let ty = shader.shader.find(name).map(|id| shader.shader.symbol(id).ty);
            let Some((ty, data)) = ty.and_then(|ty| value.fit(ty)) else { continue };
            // The last of several values counts.
            self.live.retain(|other| other.layer != layer || other.name != *name);
            match Live::new(layer, name, ty, &data) {
                Some(made) => self.live.push(made),
                None => self
                    .faults
                    .push(format!("layer '{layer}': parameter '{name}' is a text, which cannot be live")),
            }
        }
        self.group.add(shader.shader.clone(), Some(layer), &values, &mut self.faults);
        self
    }

    /// Connects an output of a layer, or a part of it (`out[0]`, `out.member`), to an input of a later one. Both layers have been
    /// added before. The source may also be an input, whose value is handed on.
    #[must_use]
    pub fn connect(mut self, from_layer: &str, from: &str, to_layer: &str, to: &str) -> Self {
        if let Err(why) = self.group.connect(from_layer, from, to_layer, to) {
            let why = faults::of_connection(&self.group, [from_layer, from], [to_layer, to], &why);
            self.faults.push(why);
        }
        self
    }

    /// Keeps an output of floats or ints, as `layer.name`, or as `name` of the last layer that has it. [`Shaded::output`] finds it
    /// by the same text.
    ///
    /// [`Shaded::output`]: crate::Shaded::output
    #[must_use]
    pub fn output(mut self, name: &str) -> Self {
        self.outputs.push(name.to_owned());
        self
    }

    /// Finishes the group. Its machine code is made by another thread, while the interpreter runs it.
    ///
    /// # Errors
    /// [`Error::Group`], with all faults: a parameter, connection or output that is not there or has another type, a live
    /// parameter that is connected, a group without layers, one that is too large.
    pub fn build(mut self) -> Result<ShaderGroup, Error> {
        let name = self.group.name.clone();
        let wrong = |why: String| Error::Group { group: name.clone(), why };
        if let Some((parameter, ..)) = self.values.first() {
            self.faults.push(format!("parameter '{parameter}' has no shader after it"));
        }
        if self.group.layers.is_empty() {
            self.faults.push("it has no layers".to_owned());
        }
        self.check_live();
        if !self.faults.is_empty() {
            return Err(wrong(self.faults.join("; ")));
        }
        let options =
            PlanOptions { outputs: self.outputs.clone(), drops_outputs: true, ..PlanOptions::default() };
        let plan = Arc::new(Plan::new(&self.group, &options).map_err(wrong)?);
        let kept = |output: &&String| plan.retained().iter().all(|kept| kept.name != **output);
        if let Some(output) = self.outputs.iter().find(kept) {
            return Err(wrong(faults::of_output(&self.group, output)));
        }
        let live: Vec<&str> = self.live.iter().map(|live| live.name.as_str()).collect();
        let needs = Needs::of(&self.group, &plan, &live);
        let warnings = idle_layers(&self.group, &plan);
        Ok(ShaderGroup {
            engine: Engine::new(&self.engines, &plan),
            plan,
            needs,
            live: self.live,
            name,
            warnings,
        })
    }

    /// Reports live parameters that could not be set: connected ones, and names that more than one parameter has.
    fn check_live(&mut self) {
        let Group { layers, connections, .. } = &self.group;
        let is_connected = |number: usize, id| {
            connections.iter().any(|made| made.to_layer == number && made.to.symbol == id)
        };
        for (k, Live { layer, name, .. }) in self.live.iter().enumerate() {
            let earlier = self.live[..k].iter().find(|other| other.name == *name);
            if let Some(other) = earlier.filter(|other| other.layer != *layer) {
                let other = &other.layer;
                self.faults
                    .push(format!("layers '{other}' and '{layer}' both have a live parameter '{name}'"));
            }
            for (number, other) in layers.iter().enumerate() {
                let Some(id) = other.shader.find(name) else { continue };
                let is_own = *other.name == **layer;
                if is_own && is_connected(number, id) {
                    self.faults.push(format!(
                        "layer '{layer}': live parameter '{name}' is connected: its own value would never be read"
                    ));
                }
                let is_live = self.live.iter().any(|live| *live.layer == *other.name && live.name == *name);
                let is_given = other.interpolated(id) && !is_live && !is_connected(number, id);
                if !is_own && is_given {
                    let other = &other.name;
                    self.faults.push(format!(
                        "layer '{layer}': live parameter '{name}' has the name of an interpolated parameter of layer '{other}'"
                    ));
                }
            }
        }
    }
}

/// Warnings about layers that never run.
fn idle_layers(group: &Group, plan: &Plan) -> Vec<String> {
    let mut runs: Vec<bool> = plan.layers.iter().map(|layer| !layer.lazy).collect();
    for number in (0..runs.len()).rev() {
        let sources = group.connections.iter().filter(|made| made.to_layer == number && runs[number]);
        sources
            .map(|made| made.from_layer)
            .collect::<Vec<_>>()
            .into_iter()
            .for_each(|from| runs[from] = true);
    }
    let idle = group.layers.iter().zip(&runs).filter(|(_, runs)| !**runs);
    let text = |layer: &gnurt_sl::group::Layer| {
        format!(
            "layer '{}' never runs: it is not the last one, no connection leads from it to a layer that runs, and no output of it is kept",
            layer.name
        )
    };
    idle.map(|(layer, _)| text(layer)).collect()
}
