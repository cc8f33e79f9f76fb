// SPDX-License-Identifier: GPL-3.0-or-later
//! How deep the blocks of layers nest in each other: the interpreter runs a layer where its value is needed,
//! within the blocks of the reading layer, and calls itself for each. Chains that are too long are cut:
//! layers far up run before the others.
//! Invariant: from the last layer no more than [`MOST_NESTED`] blocks are open, and those of one layer. Tests: `tests/hostile.rs`.

use super::machine::{Instruction, LayerPlan};

/// Blocks that may be open at once: the limit of one layer.
pub(super) const MOST_NESTED: usize = 1000;
/// The cost of a layer in addition to its blocks, in blocks.
pub(super) const LAYER: usize = 4;

/// How deep blocks nest.
fn depth(list: &[Instruction]) -> usize {
    let inner = |instruction: &Instruction| match instruction {
        Instruction::If { yes, no, .. } => depth(yes).max(depth(no)),
        Instruction::Loop(iterations) => {
            let parts = [&iterations.init, &iterations.test, &iterations.body, &iterations.step];
            parts.into_iter().map(|part| depth(part)).max().unwrap_or(0)
        }
        Instruction::Call(body) => depth(body),
        Instruction::Do(_) | Instruction::Leave(_) => 0,
    };
    1 + list.iter().map(inner).max().unwrap_or(0)
}

/// Sets how deep the layers' blocks nest, and runs layers first where the nesting would be too deep.
pub(super) fn bound(layers: &mut [LayerPlan]) {
    // With all layers that it may run.
    let mut hangs: Vec<usize> = Vec::with_capacity(layers.len());
    for number in 0..layers.len() {
        let layer = &layers[number];
        let inits = layer.params.iter().map(|param| depth(&param.init));
        let blocks = inits.chain([depth(&layer.code)]).max().unwrap_or(0);
        let own = LAYER + blocks;
        let mut above: Vec<usize> = layer.copies.iter().map(|copy| copy.layer).collect();
        above.sort_unstable();
        above.dedup();
        let mut most = 0;
        for requested in above {
            if own + hangs[requested] > MOST_NESTED {
                layers[requested].lazy = false;
                hangs[requested] = 0;
            }
            most = most.max(hangs[requested]);
        }
        layers[number].depth = blocks;
        hangs.push(if layers[number].lazy || number + 1 == layers.len() { own + most } else { 0 });
    }
}
