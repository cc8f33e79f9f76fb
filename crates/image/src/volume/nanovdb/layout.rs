// SPDX-License-Identifier: GPL-3.0-or-later
//! Where the parts of nodes lie, by the type of a grid's values.
//! Source: the structures of NanoVDB, major version 32 [Mus21]; original code. Each structure begins at a multiple of 32 bytes of
//! its grid, and its members at multiples of their own sizes. After the masks of a node follow four statistics of its values,
//! which are passed over: the smallest and largest value, mean and deviation.
//! Tests: `tests/nano_volumes.rs`.

use crate::volume::values::Number;

/// Bytes of a grid before its tree.
pub(super) const GRID_BYTES: usize = 672;
/// Bytes of the tree before its root.
pub(super) const TREE_BYTES: usize = 64;
/// Bytes of a leaf before its statistics: its first voxel, its size, flags, and the mask of its active voxels.
const LEAF_HEAD: usize = 80;
/// Where a leaf has the mask of its active voxels.
pub(super) const LEAF_MASK: usize = 16;
/// Where a leaf has its flags.
pub(super) const LEAF_FLAGS: usize = 15;
/// Where a node has its masks: active positions, then children.
pub(super) const MASKS: usize = 32;
/// Where the root has the number of its places.
pub(super) const ROOT_PLACES: usize = 24;

/// How leaves store their values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaves {
    /// As everything else.
    Plain,
    /// Whole numbers of 2^`log_bits` bits, between the smallest and the largest value of the leaf.
    Codes { log_bits: u32 },
    /// The same; each leaf states its bits.
    OwnCodes,
}

/// The type of a grid's values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) number: Number,
    /// Numbers of a value: 1 or 3.
    pub(super) channels: usize,
    pub(super) leaves: Leaves,
}

/// Names of the types, by number.
const TYPES: [&str; 27] = [
    "Unknown",
    "Float",
    "Double",
    "Int16",
    "Int32",
    "Int64",
    "Vec3f",
    "Vec3d",
    "Mask",
    "Half",
    "UInt32",
    "Boolean",
    "RGBA8",
    "Fp4",
    "Fp8",
    "Fp16",
    "FpN",
    "Vec4f",
    "Vec4d",
    "Index",
    "OnIndex",
    "IndexMask",
    "OnIndexMask",
    "PointIndex",
    "Vec3u8",
    "Vec3u16",
    "UInt8",
];

impl Layout {
    /// That of a grid's type; its name if it is no number, or three.
    pub(super) fn of_type(number: u32) -> Result<Self, String> {
        let name = TYPES.get(number as usize).copied().unwrap_or("grid of an unknown type");
        let plain = |number, channels| Ok(Self { number, channels, leaves: Leaves::Plain });
        let coded = |leaves| Ok(Self { number: Number::F32, channels: 1, leaves });
        match name {
            "Float" => plain(Number::F32, 1),
            "Double" => plain(Number::F64, 1),
            "UInt8" => plain(Number::U8, 1),
            "Int16" => plain(Number::I16, 1),
            "Int32" => plain(Number::I32, 1),
            "UInt32" => plain(Number::U32, 1),
            "Int64" => plain(Number::I64, 1),
            "Vec3f" => plain(Number::F32, 3),
            "Vec3d" => plain(Number::F64, 3),
            "Fp4" => coded(Leaves::Codes { log_bits: 2 }),
            "Fp8" => coded(Leaves::Codes { log_bits: 3 }),
            "Fp16" => coded(Leaves::Codes { log_bits: 4 }),
            "FpN" => coded(Leaves::OwnCodes),
            _ => Err(name.into()),
        }
    }

    /// Bytes of a value.
    pub(super) fn value(self) -> usize {
        self.number.bytes() * self.channels
    }

    /// The first byte of a value that follows `bytes` others.
    fn after(self, bytes: usize) -> usize {
        bytes.next_multiple_of(self.number.bytes())
    }

    /// The first byte behind the statistics that follow `bytes` others.
    fn after_statistics(self, bytes: usize) -> usize {
        let statistic = self.number.bytes().max(4);
        (self.after(bytes) + 2 * self.value()).next_multiple_of(statistic) + 2 * statistic
    }

    /// Where the root has the value of voxels that are not stored.
    pub(super) fn root_background(self) -> usize {
        self.after(ROOT_PLACES + 4)
    }

    /// Bytes of the root before its places.
    pub(super) fn root(self) -> usize {
        self.after_statistics(self.root_background() + self.value()).next_multiple_of(32)
    }

    /// Where a place of the root has its value: behind its position, its node and its state.
    pub(super) fn place_value(self) -> usize {
        self.after(20)
    }

    /// Bytes of a place of the root.
    pub(super) fn place(self) -> usize {
        (self.place_value() + self.value()).next_multiple_of(32)
    }

    /// Where a node of so many positions has its values and children.
    pub(super) fn table(self, cells: usize) -> usize {
        self.after_statistics(MASKS + 2 * cells / 8).next_multiple_of(32)
    }

    /// Bytes of a value or child of a node.
    pub(super) fn entry(self) -> usize {
        self.value().next_multiple_of(8)
    }

    /// Bytes of a node of so many positions.
    pub(super) fn node(self, cells: usize) -> usize {
        (self.table(cells) + cells * self.entry()).next_multiple_of(32)
    }

    /// Where a leaf has its values.
    pub(super) fn leaf_table(self) -> usize {
        // Codes have two numbers and four short statistics before them, which take as much as those of a float.
        self.after_statistics(LEAF_HEAD).next_multiple_of(32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of constants of NanoVDB's own `PNanoVDB.h`.
    #[test]
    fn places_are_those_of_nanovdb() {
        for (name, root, [place_value, place], upper, lower, leaf) in [
            ("Float", 64, [20, 32], [8256, 270_400], [1088, 33_856], 96),
            ("Double", 96, [24, 32], [8256, 270_400], [1088, 33_856], 128),
            ("Int16", 64, [20, 32], [8256, 270_400], [1088, 33_856], 96),
            ("UInt32", 64, [20, 32], [8256, 270_400], [1088, 33_856], 96),
            ("Int64", 96, [24, 32], [8256, 270_400], [1088, 33_856], 128),
            ("Vec3f", 96, [20, 32], [8256, 532_544], [1088, 66_624], 128),
            ("Vec3d", 128, [24, 64], [8288, 794_720], [1120, 99_424], 160),
            ("FpN", 64, [20, 32], [8256, 270_400], [1088, 33_856], 96),
            ("UInt8", 64, [20, 32], [8256, 270_400], [1088, 33_856], 96),
        ] {
            let number = TYPES.iter().position(|known| *known == name).expect("a type");
            let layout = Layout::of_type(number as u32).expect(name);
            let found = (layout.root(), [layout.place_value(), layout.place()], layout.leaf_table());
            assert_eq!(found, (root, [place_value, place], leaf), "{name}");
            for (cells, expected) in [(1 << 15, upper), (1 << 12, lower)] {
                assert_eq!([layout.table(cells), layout.node(cells)], expected, "{name}, {cells} positions");
            }
        }
        assert_eq!(Layout::of_type(8).map(|_| ()), Err("Mask".into()));
        assert!(Layout::of_type(99).is_err(), "no such type");
    }
}
