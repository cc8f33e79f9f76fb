// SPDX-License-Identifier: GPL-3.0-or-later
//! A hierarchy over the program's boxes, whose nodes the program makes. Source: \[Wald07\], binned surface area heuristic.
//! Invariant: each primitive is in one leaf, and no leaf is larger or deeper than the limits. One thread.
//! Tests: `tests/c/build.c`.

use crate::ffi_catch::Thrown;

/// `RTCBuildPrimitive`.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Primitive {
    lower: [f32; 3],
    geom_id: u32,
    upper: [f32; 3],
    prim_id: u32,
}

/// How a hierarchy is to be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) branching: usize,
    /// Of levels, leaves included.
    pub(crate) depth: usize,
    /// Primitives that are tested at once.
    pub(crate) block: usize,
    pub(crate) leaf: [usize; 2],
    pub(crate) traversal: f32,
    pub(crate) intersection: f32,
}

/// Why there is no hierarchy.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Stop {
    Thrown(Thrown),
    /// By the program.
    Cancelled,
    /// Leaves would have to be larger.
    TooDeep,
}

impl From<Thrown> for Stop {
    fn from(thrown: Thrown) -> Self {
        Self::Thrown(thrown)
    }
}

/// The program's functions.
pub(crate) trait Program {
    /// A node or a leaf.
    type Node: Copy;
    fn node(&mut self, children: usize) -> Result<Self::Node, Thrown>;
    fn set_bounds(&mut self, node: Self::Node, bounds: &[Around]) -> Result<(), Thrown>;
    fn set_children(&mut self, node: Self::Node, children: &[Self::Node]) -> Result<(), Thrown>;
    fn leaf(&mut self, primitives: &[Primitive]) -> Result<Self::Node, Thrown>;
    /// Whether to go on after this share.
    fn goes_on(&mut self, done: f64) -> Result<bool, Thrown>;
}

/// A box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Around {
    pub(crate) lower: [f32; 3],
    pub(crate) upper: [f32; 3],
}

impl Around {
    const EMPTY: Self = Self { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };

    fn add(&mut self, other: &Self) {
        for k in 0..3 {
            self.lower[k] = self.lower[k].min(other.lower[k]);
            self.upper[k] = self.upper[k].max(other.upper[k]);
        }
    }

    fn of(primitives: &[Primitive]) -> Self {
        let mut all = Self::EMPTY;
        primitives.iter().for_each(|primitive| all.add(&primitive.around()));
        all
    }

    fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| (self.upper[k] - self.lower[k]).max(0.0));
        x * y + y * z + z * x
    }
}

impl Primitive {
    fn around(&self) -> Around {
        Around { lower: self.lower, upper: self.upper }
    }

    /// Twice the middle.
    fn middle(&self, k: usize) -> f32 {
        self.lower[k] + self.upper[k]
    }
}

const BINS: usize = 16;

/// Where primitives are parted.
struct Split {
    axis: usize,
    from: f32,
    scale: f32,
    bin: usize,
    /// Without that of the node.
    cost: f32,
}

impl Split {
    fn bin_of(&self, primitive: &Primitive) -> usize {
        (((primitive.middle(self.axis) - self.from) * self.scale) as usize).min(BINS - 1)
    }
}

/// A range that becomes a child.
struct Part<'a> {
    primitives: &'a mut [Primitive],
    around: Around,
}

/// Builds, and returns the root.
///
/// # Errors
/// [`Stop`].
pub(crate) fn build<P: Program>(
    primitives: &mut [Primitive],
    limits: &Limits,
    program: &mut P,
) -> Result<P::Node, Stop> {
    let total = primitives.len();
    let around = Around::of(primitives);
    let mut building = Building { limits, program, done: 0, told: 0, total };
    building.node(Part { primitives, around }, 1)
}

struct Building<'a, P> {
    limits: &'a Limits,
    program: &'a mut P,
    done: usize,
    told: usize,
    total: usize,
}

impl<P: Program> Building<'_, P> {
    fn blocks(&self, count: usize) -> f32 {
        count.div_ceil(self.limits.block) as f32
    }

    /// The best split, by the cost of both sides.
    fn best_split(&self, part: &Part) -> Option<Split> {
        let mut middles = [[f32::INFINITY, f32::NEG_INFINITY]; 3];
        for primitive in part.primitives.iter() {
            for (k, [from, to]) in middles.iter_mut().enumerate() {
                *from = from.min(primitive.middle(k));
                *to = to.max(primitive.middle(k));
            }
        }
        let mut best: Option<Split> = None;
        for (axis, [from, to]) in middles.into_iter().enumerate() {
            let scale = BINS as f32 * 0.9999 / (to - from);
            if !(scale.is_finite() && scale > 0.0) {
                continue;
            }
            let mut split = Split { axis, from, scale, bin: 0, cost: f32::INFINITY };
            let mut bins = [(0_usize, Around::EMPTY); BINS];
            for primitive in part.primitives.iter() {
                let (count, around) = &mut bins[split.bin_of(primitive)];
                *count += 1;
                around.add(&primitive.around());
            }
            let mut above = [0.0; BINS];
            let (mut count, mut around) = (0, Around::EMPTY);
            for bin in (1..BINS).rev() {
                count += bins[bin].0;
                around.add(&bins[bin].1);
                above[bin] = if count > 0 { self.blocks(count) * around.half_area() } else { f32::INFINITY };
            }
            let (mut count, mut around) = (0, Around::EMPTY);
            for bin in 1..BINS {
                count += bins[bin - 1].0;
                around.add(&bins[bin - 1].1);
                let cost = self.blocks(count) * around.half_area() + above[bin];
                if count > 0 && cost < split.cost {
                    (split.bin, split.cost) = (bin, cost);
                }
            }
            if split.cost < best.as_ref().map_or(f32::INFINITY, |best| best.cost) {
                best = Some(split);
            }
        }
        best
    }

    /// Levels below that halves would need.
    fn levels(&self, count: usize) -> usize {
        count.div_ceil(self.limits.leaf[1]).next_power_of_two().ilog2() as usize
    }

    /// Two parts of one; `None` where it is better a leaf.
    fn parted<'b>(&self, part: Part<'b>, depth: usize) -> Result<[Part<'b>; 2], Part<'b>> {
        let (count, [least, most]) = (part.primitives.len(), self.limits.leaf);
        if count <= least.max(1) {
            return Err(part);
        }
        let split = self.best_split(&part);
        if count <= most {
            let as_leaf = self.limits.intersection * self.blocks(count) * part.around.half_area();
            let as_node = |split: &Split| {
                self.limits.traversal * part.around.half_area() + self.limits.intersection * split.cost
            };
            if depth >= self.limits.depth || split.as_ref().is_none_or(|split| as_node(split) >= as_leaf) {
                return Err(part);
            }
        }
        // Where levels run out, halves.
        let is_tight = depth + 1 + self.levels(count) >= self.limits.depth;
        let middle = match &split {
            Some(split) if is_tight => {
                let axis = split.axis;
                let by_middle = |a: &Primitive, b: &Primitive| a.middle(axis).total_cmp(&b.middle(axis));
                part.primitives.select_nth_unstable_by(count / 2, by_middle);
                count / 2
            }
            Some(split) => {
                let mut left = 0;
                for i in 0..count {
                    if split.bin_of(&part.primitives[i]) < split.bin {
                        part.primitives.swap(left, i);
                        left += 1;
                    }
                }
                left
            }
            None => count / 2,
        };
        let (left, right) = part.primitives.split_at_mut(middle);
        Ok([left, right].map(|primitives| Part { around: Around::of(primitives), primitives }))
    }

    fn node(&mut self, part: Part, depth: usize) -> Result<P::Node, Stop> {
        let mut parts = match self.parted(part, depth) {
            Ok(parts) => Vec::from(parts),
            Err(part) => {
                if part.primitives.len() > self.limits.leaf[1] {
                    return Err(Stop::TooDeep);
                }
                self.done += part.primitives.len();
                if self.done - self.told > self.total / 64 {
                    self.told = self.done;
                    if !self.program.goes_on(self.done as f64 / self.total as f64)? {
                        return Err(Stop::Cancelled);
                    }
                }
                return Ok(self.program.leaf(part.primitives)?);
            }
        };
        if depth >= self.limits.depth {
            return Err(Stop::TooDeep);
        }
        // The largest is parted again, until there are enough; parts that are better leaves stay whole.
        let mut leaves = Vec::new();
        while parts.len() + leaves.len() < self.limits.branching {
            let areas = parts.iter().map(|part| part.around.half_area()).enumerate();
            let Some((largest, _)) = areas.max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            match self.parted(parts.swap_remove(largest), depth + 1) {
                Ok(both) => parts.extend(both),
                Err(leaf) => leaves.push(leaf),
            }
        }
        parts.extend(leaves);
        let node = self.program.node(parts.len())?;
        let around: Vec<Around> = parts.iter().map(|part| part.around).collect();
        self.program.set_bounds(node, &around)?;
        let children: Vec<P::Node> =
            parts.into_iter().map(|part| self.node(part, depth + 1)).collect::<Result<_, _>>()?;
        self.program.set_children(node, &children)?;
        Ok(node)
    }
}
