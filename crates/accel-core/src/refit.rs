// SPDX-License-Identifier: GPL-3.0-or-later
//! Why a tree cannot be fitted to geometry that has moved.

/// Why a tree cannot be refitted: it is to be built again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefitError {
    /// There are more or fewer geometries or primitives than the tree was built over, or they are of other kinds or masks.
    OtherGeometry,
    /// An untraceable primitive has become traceable; or all primitives of a leaf have become untraceable.
    OtherPrimitives,
    /// A kd-tree or a grid: it divides space, and triangles that move are elsewhere in it. Or a tree with several keys.
    Structure,
}

impl std::fmt::Display for RefitError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::OtherGeometry => {
                "geometries are not those that the tree was built over: their numbers, kinds, masks and numbers of primitives have to be the same"
            }
            Self::OtherPrimitives => "other primitives than before can be traced: the tree has to be built again",
            Self::Structure => {
                "a kd-tree or grid, or a tree over meshes with several keys, cannot be refitted: use Structure::Bvh and meshes with one key"
            }
        })
    }
}

impl std::error::Error for RefitError {}
