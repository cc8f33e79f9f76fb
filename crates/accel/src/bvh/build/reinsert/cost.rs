// SPDX-License-Identifier: GPL-3.0-or-later
//! From places back to knots, with what wide nodes made of them will cost.
//! Source: [YKL17], as in `collapse`. Invariant: as of [`Garden`]. Proof: `super::tests`.

use super::super::collapse::{Costs, Shares, inner_costs, leaf_costs};
use super::{Garden, Knot};

/// Below this height one thread does it.
const LOW: u32 = if cfg!(test) { 4 } else { 10 };

/// How one knot's children share places.
struct Shared {
    knot: u32,
    shares: Shares,
}

impl Garden<'_> {
    /// Brings `knots` up to date; returns the cost of the wide tree.
    pub(super) fn write(&self, knots: &mut [Knot]) -> f32 {
        let mut all = Vec::new();
        let costs = self.costs(self.root, &mut all);
        for Shared { knot, shares } in all {
            let spot = self.spot(knot);
            let back = spot.children.map(|child| knot.wrapping_sub(child));
            knots[knot as usize] = Knot::inner(spot.bounds, back, shares);
        }
        costs[1]
    }

    /// Costs of a knot; how it and all below share places goes to `all`.
    fn costs(&self, at: u32, all: &mut Vec<Shared>) -> Costs {
        let spot = self.spot(at);
        let area = spot.bounds.half_area(self.crew.scale);
        if spot.is_leaf() {
            return leaf_costs(area);
        }
        let [left, right] = spot.children;
        let (left, right) = if self.crew.parallel && spot.height > LOW {
            let mut more = Vec::new();
            let both = self.crew.both(|| self.costs(left, all), || self.costs(right, &mut more));
            all.append(&mut more);
            both
        } else {
            (self.costs(left, all), self.costs(right, all))
        };
        let (costs, shares) = inner_costs(area, &left, &right);
        all.push(Shared { knot: at, shares });
        costs
    }
}
