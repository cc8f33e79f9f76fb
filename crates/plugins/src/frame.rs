// SPDX-License-Identifier: GPL-3.0-or-later
//! Plugins in a frame: the copies of their blocks, `prepare`, the shaders for the renderer, and faults.
//! Invariant: a plugin that cannot take part is reported and left out. Tests:
//! bindings/openrt/tests/plugins.rs.

use std::collections::BTreeMap;
use std::sync::Arc;

use gnurt::shading::classes::Shader as RenderShader;

use crate::class::PluginClass;
use crate::ffi_block::{PluginBlock, Snapshot};
use crate::ffi_host::{HOST, collect_log};
use crate::ffi_shader;
use crate::ffi_trial::{Trial, try_all};
use crate::frame_shader::FrameShader;
use crate::frame_state::{Faults, FrameState};

/// A class's faults in a frame.
struct ClassFaults {
    class: Arc<PluginClass>,
    faults: Arc<Faults>,
}

/// The plugins of one frame.
#[derive(Default)]
pub struct PluginFrame {
    /// By shader id; `None`: it cannot take part.
    made: BTreeMap<u32, Option<RenderShader>>,
    /// Faults before the frame begins, a line each.
    problems: Vec<String>,
    faults: Vec<ClassFaults>,
}

/// A shader before it is in a frame.
struct Candidate {
    id: u32,
    snapshot: Snapshot,
    problem: Option<String>,
}

impl PluginFrame {
    /// Prepares shaders, given with their ids, for a frame.
    pub fn new<'a>(
        shaders: impl Iterator<Item = (u32, &'a Arc<PluginBlock>)>,
        state: impl FnOnce() -> FrameState,
    ) -> Self {
        let candidate = |(id, block): (u32, &Arc<PluginBlock>)| (id, block.snapshot());
        let candidates =
            shaders.map(candidate).map(|(id, snapshot)| Candidate { id, snapshot, problem: None });
        let mut candidates: Vec<Candidate> = candidates.collect();
        if candidates.is_empty() {
            return Self::default();
        }
        candidates.sort_unstable_by_key(|candidate| candidate.id);
        candidates.dedup_by_key(|candidate| candidate.id);
        try_prepare(&mut candidates);
        candidates.iter_mut().for_each(prepare);
        let mut frame = Self::default();
        let state = Arc::new(state());
        for Candidate { id, snapshot, problem } in candidates {
            let class = snapshot.block.class().clone();
            match problem {
                Some(problem) => {
                    frame
                        .problems
                        .push(format!("{}: {problem}; the frame goes on without it", class.title()));
                    frame.made.insert(id, None);
                }
                None => {
                    let faults = frame.faults_of(&class);
                    frame.made.insert(id, Some(ffi_shader::make(FrameShader::new(snapshot, &state, faults))));
                }
            }
        }
        frame
    }

    fn faults_of(&mut self, class: &Arc<PluginClass>) -> Arc<Faults> {
        let known = self.faults.iter().find(|known| Arc::ptr_eq(&known.class, class));
        if let Some(known) = known {
            return known.faults.clone();
        }
        let faults = Arc::new(Faults::default());
        self.faults.push(ClassFaults { class: class.clone(), faults: faults.clone() });
        faults
    }

    /// The shader of an id as the renderer takes it; `None` if it cannot take part in the frame.
    #[must_use]
    pub fn made(&self, id: u32) -> Option<RenderShader> {
        self.made.get(&id).cloned().flatten()
    }

    /// Faults before the frame.
    #[must_use]
    pub fn problems(&self) -> &[String] {
        &self.problems
    }

    /// Faults in the frame so far, a line for each kind in each class.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let lines = |known: &ClassFaults| {
            let title = known.class.title();
            known.faults.lines().map(move |line| format!("{title}: {line}")).collect::<Vec<_>>()
        };
        self.faults.iter().flat_map(lines).collect()
    }
}

/// Tries those that were not tried with the present values.
fn try_prepare(candidates: &mut [Candidate]) {
    let is_pending = |c: &Candidate| {
        c.snapshot.block.class().calls.prepare.is_some()
            && c.snapshot.block.outcome(c.snapshot.version).is_none()
    };
    let mut pending: Vec<&mut Candidate> = candidates.iter_mut().filter(|c| is_pending(c)).collect();
    let verdicts = try_all(pending.len(), |i| {
        if let Some(prepare) = pending[i].snapshot.block.class().calls.prepare {
            // Its output is repeated by the call that counts.
            let _ = collect_log(|| pending[i].snapshot.prepare(&HOST, prepare), false);
        }
    });
    for (candidate, outcome) in pending.iter().zip(verdicts) {
        let outcome = match outcome {
            Trial::Returned => Ok(()),
            Trial::Crashed(how) => Err(format!("its prepare crashed in a trial: {how}")),
        };
        candidate.snapshot.block.set_result(candidate.snapshot.version, outcome);
    }
}

/// Calls `prepare`, if the trial went well.
fn prepare(candidate: &mut Candidate) {
    let Some(prepare) = candidate.snapshot.block.class().calls.prepare else { return };
    let outcome = candidate.snapshot.block.outcome(candidate.snapshot.version);
    if let Some(Err(crash)) = outcome {
        candidate.problem = Some(crash);
        return;
    }
    let (status, message) = collect_log(|| candidate.snapshot.prepare(&HOST, prepare), true);
    let Ok(status) = status else {
        candidate.problem = Some("an exception left its prepare".to_owned());
        return;
    };
    if status != 0 {
        let message = if message.is_empty() { String::new() } else { format!(" ({})", message.join("; ")) };
        candidate.problem = Some(format!("its prepare failed with {status}{message}"));
    }
}
