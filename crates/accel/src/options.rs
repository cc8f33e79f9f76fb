// SPDX-License-Identifier: GPL-3.0-or-later
//! How a tree is to be built.
//! Source: original; the cost model's names are those of [MB90, WH06].

/// Which ray-triangle test an object uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TriangleTest {
    /// Watertight: no ray passes between triangles that share an edge or a vertex \[WBW13\]. 36 bytes per triangle.
    #[default]
    Watertight,
    /// Badouel's test on triangles that are projected beforehand [Bad90, Wal04]: rays may slip through edges, and
    /// precision falls with the distance from the origin. 40 bytes per triangle.
    Projected,
}

/// Settings of the kd-tree builder. The default suits almost everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// The triangle test that queries use.
    pub triangle_test: TriangleTest,
    /// Cost of a triangle test in units of one step through a node.
    pub triangle_cost: f32,
    /// What the cost of a plane is multiplied with where one of its sides is empty.
    pub empty_factor: f32,
    /// Leaves may hold at most this many references in all, as a multiple of the number of triangles.
    pub reference_budget: f32,
    /// Nodes may not lie deeper; capped by what a traversal stack holds.
    pub max_depth: u32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            triangle_test: TriangleTest::Watertight,
            triangle_cost: 0.5,
            empty_factor: 0.8,
            reference_budget: 6.0,
            max_depth: 48,
        }
    }
}

/// Who does the work of a build. The tree is the same, bit for bit, whatever is chosen.
#[derive(Clone, Copy, Default)]
pub enum Threads<'a> {
    /// The calling thread alone.
    #[default]
    Single,
    /// The threads of this pool; may be called from inside it.
    Pool(&'a rayon::ThreadPool),
}
