// SPDX-License-Identifier: GPL-3.0-or-later
//! How a tree is to be built.
//! The cost model's names are those of [MB90, WH06].

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

/// The acceleration structure of an object. All but BVHs need the feature `research`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Structure {
    /// A SAH kd-tree with nodes of 8 bytes: the paper's structure.
    #[cfg(feature = "research")]
    Kd,
    /// A bounding volume hierarchy whose nodes have eight children.
    #[default]
    Bvh,
    /// A bounding interval hierarchy \[WK06\]: nodes of 12 bytes with two planes along one axis. Triangles
    /// are divided by the surface area heuristic, with clips where a child does not fill its region. Can be
    /// refitted.
    #[cfg(feature = "research")]
    Bih,
    /// The same as published: space is halved, and empty space stays. For comparison.
    #[cfg(feature = "research")]
    PlainBih,
    /// A B-KD tree \[WMS06\]: nodes of 20 bytes with four planes along one axis, and clips as above. Can be refitted.
    #[cfg(feature = "research")]
    BKd,
    /// A grid of cells of one size \[WIK*06\]: quick to build, for geometry that is rebuilt each frame; slow
    /// to trace, most of all where triangles are spread unevenly. All qualities are equal.
    #[cfg(feature = "research")]
    Grid,
}

/// How much time a build may take for faster rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The least: for moving geometry. Kd-trees are built from samples of the cost \[HMS06\].
    Fast,
    /// Binned surface area heuristic and a little optimisation for BVHs, the exact sweep for kd-trees.
    #[default]
    Medium,
    /// More optimisation \[MB18\], and spatial splits \[SFD09\] where they pay, for BVHs; kd-trees as for medium.
    High,
}

/// The memory layout of a BVH.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Memory {
    /// Rays: about 50 bytes per triangle.
    #[default]
    Fast,
    /// The smaller one: about 25 bytes per triangle of a mesh, for the same hits, bit for bit. Tiles of rays
    /// are 10 to 20 % slower, single rays about 30 %. Boxes are rounded to bytes, outwards \[YKL17\]; corners
    /// are shared.
    Compact,
}

/// Settings of the builders. The default suits almost everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// The structure to build.
    pub structure: Structure,
    /// How carefully.
    pub quality: Quality,
    /// For speed, or to be small. Kd-trees take no notice.
    pub memory: Memory,
    /// The triangle test that queries use. A BVH always uses the watertight one.
    pub triangle_test: TriangleTest,
    /// Kd-tree: cost of a triangle test in units of one step through a node. Little, since triangles are tested eight at
    /// a time, and discarded eight at a time for a whole tile of rays.
    pub triangle_cost: f32,
    /// Kd-tree: factor of the cost of a plane with an empty side.
    pub empty_factor: f32,
    /// Leaves of a kd-tree, of a BVH with spatial splits, or cells of a grid may hold at most this many references in all, as a multiple
    /// of the number of triangles. A BVH stays below 2.
    pub reference_budget: f32,
    /// Kd-tree: the largest depth of nodes; limited by the traversal stack.
    pub max_depth: u32,
}

impl Default for BuildOptions {
    fn default() -> Self {
        Self {
            structure: Structure::default(),
            quality: Quality::default(),
            memory: Memory::default(),
            triangle_test: TriangleTest::Watertight,
            triangle_cost: 0.1,
            empty_factor: 0.8,
            reference_budget: 6.0,
            max_depth: 48,
        }
    }
}
