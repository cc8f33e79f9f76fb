// SPDX-License-Identifier: GPL-3.0-or-later
//! Groups of shaders: layers with parameters and connections.

use std::sync::Arc;

use gnurt_sl::exec::{Host, LANES, Plan, PlanOptions, Point, Points, Program, Results};
use gnurt_sl::group::{Group, Hint, Value};

use crate::engine::{Engine, Engines};
use crate::error::Error;
use crate::live::Live;
use crate::needs::Needs;
use crate::shaded::Shaded;
use crate::shader::Shader;
use crate::world::World;

/// A group in the making. Faults are kept until [`build`](Self::build).
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

    /// A parameter of the next shader: a number, a text, three floats, a matrix, a slice of floats, or a
    /// [`Value`].
    #[must_use]
    pub fn param(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.values.push((name.to_owned(), value.into(), Hint::default()));
        self
    }

    /// A parameter of the next shader that [`ShaderGroup::set`] may change: numbers, not texts.
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
        let values = std::mem::take(&mut self.values);
        for (name, value, hint) in &values {
            if !hint.interactive {
                continue;
            }
            let ty = shader.shader.find(name).map(|id| shader.shader.symbol(id).ty);
            let fitted = ty.and_then(|ty| value.fit(ty));
            // A parameter that is not there is reported with the others.
            let Some((ty, data)) = fitted else { continue };
            let Some(made) = Live::new(layer, name, ty, &data) else {
                self.faults
                    .push(format!("layer '{layer}': parameter '{name}' is a text, which cannot be live"));
                continue;
            };
            if let Some(other) = self.live.iter().find(|live| live.name == *name) {
                let other = &other.layer;
                self.faults
                    .push(format!("layers '{other}' and '{layer}' both have a live parameter '{name}'"));
            }
            self.live.push(made);
        }
        self.group.add(shader.shader.clone(), Some(layer), &values, &mut self.faults);
        self
    }

    /// Connects an output of a layer, or a part of it (`out[0]`, `out.member`), to an input of a later one.
    #[must_use]
    pub fn connect(mut self, from_layer: &str, from: &str, to_layer: &str, to: &str) -> Self {
        self.faults.extend(self.group.connect(from_layer, from, to_layer, to).err());
        self
    }

    /// Keeps an output of floats or ints, as `name` of the last layer or `layer.name`, for
    /// [`Shaded::output`].
    #[must_use]
    pub fn output(mut self, name: &str) -> Self {
        self.outputs.push(name.to_owned());
        self
    }

    /// Finishes the group. Its machine code is made by another thread, while the interpreter runs it.
    ///
    /// # Errors
    /// [`Error::Group`]: a parameter, connection or output that is not there or has another type, a group without layers, one that
    /// is too large.
    pub fn build(mut self) -> Result<ShaderGroup, Error> {
        let name = self.group.name.clone();
        let wrong = |why: String| Error::Group { group: name.clone(), why };
        if let Some((parameter, ..)) = self.values.first() {
            self.faults.push(format!("parameter '{parameter}' has no shader after it"));
        }
        if self.group.layers.is_empty() {
            self.faults.push("it has no layers".to_owned());
        }
        if !self.faults.is_empty() {
            return Err(wrong(self.faults.join("; ")));
        }
        let options =
            PlanOptions { outputs: self.outputs.clone(), drops_outputs: true, ..PlanOptions::default() };
        let plan = Arc::new(Plan::new(&self.group, &options).map_err(wrong)?);
        let kept = |output: &&String| plan.retained().iter().all(|kept| kept.name != **output);
        if let Some(output) = self.outputs.iter().find(kept) {
            return Err(wrong(format!("there is no output '{output}' of floats or ints")));
        }
        let needs =
            Needs::of(&self.group, &self.live.iter().map(|live| live.name.as_str()).collect::<Vec<_>>());
        Ok(ShaderGroup { engine: Engine::new(&self.engines, &plan), plan, needs, live: self.live, name })
    }
}

/// Sizes of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Statistics {
    /// Layers.
    pub layers: usize,
    /// Numbers that a point takes in the interpreter, 4 bytes each.
    pub cells: usize,
    /// Bytes of machine code; `None` while there is none.
    pub code_bytes: Option<usize>,
    /// Operations that the interpreter does for it, point by point; `None` while there is no code.
    pub interpreted: Option<usize>,
}

/// A group that is ready to run. All threads may run it at once.
pub struct ShaderGroup {
    name: String,
    plan: Arc<Plan>,
    engine: Engine,
    needs: Needs,
    live: Vec<Live>,
}

impl std::fmt::Debug for ShaderGroup {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ShaderGroup").field("name", &self.name).finish_non_exhaustive()
    }
}

impl ShaderGroup {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its demands on the renderer.
    #[must_use]
    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    /// Runs it for any number of points, and returns closures, outputs and messages of each.
    #[must_use]
    pub fn run(&self, host: &dyn Host, points: &[Point]) -> Shaded {
        let world = World { host, live: &self.live };
        let mut shaded = Shaded::new(self.plan.retained(), points.len());
        let (mut batches, mut results) = (<[Points; 2]>::default(), <[Results; 2]>::default());
        for (number, some) in points.chunks(2 * LANES).enumerate() {
            for (batch, some) in batches.iter_mut().zip(some.chunks(LANES)) {
                batch.count = some.len();
                some.iter().enumerate().for_each(|(lane, point)| batch.set(lane, point));
            }
            let program = self.engine.program();
            if some.len() > LANES {
                program.run_pair(&world, &batches, &mut results);
            } else {
                program.run(&world, &batches[0], &mut results[0]);
            }
            for (k, (some, results)) in some.chunks(LANES).zip(&results).enumerate() {
                shaded.add((2 * number + k) * LANES, some.len(), results, world.closures(), &self.plan);
            }
        }
        shaded
    }

    /// Gives a live parameter another value. Points that run now may see both.
    ///
    /// # Errors
    /// [`Error::Group`]: there is no such live parameter, or the value has another type.
    pub fn set(&self, layer: &str, parameter: &str, value: impl Into<Value>) -> Result<(), Error> {
        let wrong = |why: String| Error::Group { group: self.name.clone(), why };
        let found = self.live.iter().find(|live| live.layer == layer && live.name == parameter);
        let live = found.ok_or_else(|| {
            wrong(format!("layer '{layer}' has no live parameter '{parameter}'; see live_param"))
        })?;
        let value: Value = value.into();
        match live.set(&value) {
            true => Ok(()),
            false => Err(wrong(format!(
                "layer '{layer}': parameter '{parameter}' is of type {}, not {}",
                live.ty, value.ty
            ))),
        }
    }

    /// Waits until it has machine code; returns whether it has some. Groups run before that, too.
    pub fn wait_for_code(&self) -> bool {
        self.engine.wait()
    }

    /// Its sizes.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let sizes = self.engine.sizes();
        Statistics {
            layers: self.plan.layer_count(),
            cells: self.plan.memory.len(),
            code_bytes: sizes.map(|[bytes, _]| bytes),
            interpreted: sizes.map(|[_, calls]| calls),
        }
    }
}
