// SPDX-License-Identifier: GPL-3.0-or-later
//! Machine code as an engine of `testshade`.

use gnurt_simd::Level;
use gnurt_sl::engine::Batch;
use gnurt_sl::exec::{Event, Host, Plan, Points};
use gnurt_sl::hir::Data;
use gnurt_sl::types::Type;
use std::sync::Arc;

use crate::{Compiled, Lanes, NoCode};

impl Batch for Lanes<'_> {
    fn lanes(&self) -> usize {
        self.width()
    }

    fn run(&mut self, points: &[Points]) {
        Lanes::run_all(self, points);
    }

    fn begin(&mut self, points: &[Points]) {
        Lanes::begin(self, points);
    }

    fn layer(&mut self, layer: usize) {
        Lanes::layer(self, layer);
    }

    fn output(&self, lane: usize, layer: usize, name: &str) -> Option<(Type, Data)> {
        Lanes::output(self, lane, Some(layer), name)
    }

    fn take_events(&mut self) -> Vec<(usize, Event)> {
        Lanes::take_events(self)
    }
}

/// Compiles a group for the engine of a name: `machine` for the best level of the CPU, or a level's name. `-scalar` after it is for
/// one point at a time, and `-pair` for two batches at once.
///
/// # Errors
/// As [`Compiled::new`]; a name that is not known.
pub fn engine(
    name: &str,
    plan: &Arc<Plan>,
    host: &dyn Host,
    with: &mut dyn FnMut(&mut dyn Batch),
) -> Result<(), String> {
    type Make = fn(Arc<Plan>, Level) -> Result<Compiled, NoCode>;
    let kinds: [(&str, Make); 2] = [("-scalar", Compiled::scalar), ("-pair", Compiled::pair)];
    let found = kinds.into_iter().find_map(|(suffix, make)| Some((name.strip_suffix(suffix)?, make)));
    let (level_name, make) = found.unwrap_or((name, Compiled::new));
    let level: Level = match level_name {
        "machine" => Level::best(),
        level_name => level_name.parse().map_err(|wrong| format!("unknown engine '{name}': {wrong}"))?,
    };
    let code = make(plan.clone(), level).map_err(|why| why.to_string())?;
    with(&mut Lanes::new(&code, host));
    Ok(())
}
