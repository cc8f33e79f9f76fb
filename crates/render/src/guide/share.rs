// SPDX-License-Identifier: GPL-3.0-or-later
//! The share of directions that a cell's tree chooses, learned from samples that the tree was not built from.
//! Source: [VHH*19], chapter 10 learns it by gradients; here a few shares are compared by their second moments, which
//! needs no order of samples. Tests: crates/render/tests/guide.rs.

/// The shares that are compared: the first is none. Lobes keep some, since trees may be dark where light is.
pub(super) const SHARES: [f32; 5] = [0.0, 0.25, 0.5, 0.7, 0.85];

/// A held-out sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldOut {
    /// Density of its direction when it was taken, by lobes, and by the tree.
    pub(super) pdf: f32,
    pub(super) of_lobes: f32,
    pub(super) of_tree: f32,
    pub(super) guidable: f32,
    /// The square of its light at the eye, relative to the picture there.
    pub(super) square: f32,
}

/// Second moments of the light of samples, had directions been chosen by each of [`SHARES`].
pub(super) fn moments(samples: impl Iterator<Item = HeldOut>) -> [f64; SHARES.len()] {
    let mut sums = [0.0; SHARES.len()];
    for HeldOut { pdf, of_lobes, of_tree, guidable, square } in samples {
        for (sum, share) in sums.iter_mut().zip(SHARES) {
            let share = share * guidable;
            let density = of_lobes * (1.0 - share) + of_tree * share;
            if density > 0.0 {
                *sum += f64::from(square) * f64::from(pdf / density);
            }
        }
    }
    sums
}

/// The best of them, as an index: none unless it is clearly better.
pub(super) fn best(moments: &[f64; SHARES.len()]) -> usize {
    let mut best = 0;
    for k in 1..SHARES.len() {
        let bar = if best == 0 { 0.9 * moments[0] } else { moments[best] };
        if moments[k] < bar {
            best = k;
        }
    }
    best
}
