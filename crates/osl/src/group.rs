// SPDX-License-Identifier: GPL-3.0-or-later
//! Groups of shaders that are ready to run.

use std::sync::Arc;

use gnurt_sl::exec::{Host, LANES, Plan, Point, Points, Program, Results};
use gnurt_sl::group::Value;

use crate::engine::Engine;
use crate::error::Error;
use crate::faults;
use crate::live::Live;
use crate::needs::Needs;
use crate::shaded::Shaded;
use crate::world::World;

/// Sizes of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Statistics {
    /// Layers.
    pub layers: usize,
    /// Memory of the interpreter for one point, in cells of 4 bytes.
    pub cells: usize,
    /// Bytes of machine code; `None` while there is none.
    pub code_bytes: Option<usize>,
    /// Operations that the interpreter does for it, point by point; `None` while there is no code.
    pub interpreted: Option<usize>,
}

/// A group that is ready to run. All threads may run it at once.
pub struct ShaderGroup {
    pub(crate) name: String,
    pub(crate) plan: Arc<Plan>,
    pub(crate) engine: Engine,
    pub(crate) needs: Needs,
    pub(crate) live: Vec<Live>,
    pub(crate) warnings: Vec<String>,
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

    /// The data that it reads from the renderer.
    #[must_use]
    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    /// Layers that never run, because the group's result does not depend on them; most often they are in the wrong order.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Runs it for any number of points, and returns closures, outputs and messages of each.
    ///
    /// Machine code runs sixteen points in about the time of one, thirty-two with AVX-512. So collect the hits of a group from many
    /// rays, and give all of them in one call: one by one, points take up to seventeen times as long.
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
            wrong(format!("layer '{layer}' has no live parameter '{parameter}'; it is made by live_param"))
        })?;
        let value: Value = value.into();
        match live.set(&value) {
            true => Ok(()),
            false => Err(wrong(format!(
                "layer '{layer}': parameter '{parameter}' is of type {}; the value is {}",
                live.ty,
                faults::described(&value)
            ))),
        }
    }

    /// Waits until it has machine code; returns whether it has some. Groups run before that, too, in the interpreter, with
    /// the same values.
    ///
    /// Call it before a picture that takes minutes: the interpreter may take up to a hundred times as long for each point. An
    /// interactive renderer leaves it out: it shows a picture at once, and later ones faster.
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
