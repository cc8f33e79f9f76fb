// SPDX-License-Identifier: GPL-3.0-or-later
//! An object's tree on its way into a file and back. The format is that of `gnurt_accel_core::store`.
//! Tests: `tests/saved.rs`.

use std::io::{self, Read, Write};
use std::sync::OnceLock;

use gnurt_accel_bvh::{BlockIndex, BvhIndex};
use gnurt_accel_core::geometry::{Numbering, geometry_of};
use gnurt_accel_core::store::{Reader, Writer};

use super::build::both;
use super::kind::Times;
use super::{Index, ObjectTree, Part};
use crate::research::ResearchIndex;
use crate::{Aabb, BadPrimitives, LoadError, MOST_TRIANGLES, Memory, TreeStats, TriangleTest};

const BVH: u64 = 0;
const KD_WATERTIGHT: u64 = 1;
const KD_PROJECTED: u64 = 2;
const COMPACT_BVH: u64 = 4;
// Those of all that is not a triangle are `BlockKind::IN_FILES` of each kind.

impl ObjectTree {
    /// Writes the tree and its triangles, to be loaded instead of built; the same bytes on every machine.
    /// It takes about as many bytes as in memory.
    ///
    /// # Errors
    /// Those of `to`, and `Unsupported` where there is user geometry, an interval hierarchy or a grid: these cannot be saved.
    ///
    /// ```
    /// use gnurt_accel::{BuildOptions, ObjectTree, Ray, Threads, Triangles};
    ///
    /// let mesh = Triangles { positions: &[[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], indices: &[[0, 1, 2]] };
    /// let tree = ObjectTree::build(&[mesh], &BuildOptions::default(), Threads::Single);
    /// let mut file = Vec::new();
    /// tree.save(&mut file)?;
    /// let loaded = ObjectTree::load(&mut &file[..])?;
    /// let ray = Ray::new([0.25, 0.5, 1.0], [0.0, 0.0, -2.0]);
    /// assert_eq!(loaded.intersect(&ray), tree.intersect(&ray));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn save(&self, to: &mut impl Write) -> io::Result<()> {
        let mut writer = Writer::new(to)?;
        let Numbering { starts, quads, too_many: _ } = &self.numbering;
        writer.list(starts)?;
        writer.list(&quads.iter().map(|&quads| u32::from(quads)).collect::<Vec<u32>>())?;
        let BadPrimitives { bad_index, nan, infinite, too_large, zero_area, too_many } = self.bad;
        for count in [bad_index, nan, infinite, too_large, zero_area, too_many] {
            writer.number(count)?;
        }
        save_stats(&mut writer, &self.stats)?;
        writer.number(self.parts.len() as u64)?;
        for Part { mask, index, .. } in &self.parts {
            writer.number(u64::from(*mask))?;
            writer.number(match index {
                Index::Bvh(index) if index.is_compact() => COMPACT_BVH,
                Index::Bvh(_) => BVH,
                Index::Research(index) => match index.saved_test()? {
                    TriangleTest::Watertight => KD_WATERTIGHT,
                    TriangleTest::Projected => KD_PROJECTED,
                },
                Index::Blocks(index) => index.in_files()?,
                Index::Moving(_) | Index::MovingUser(_) => {
                    return Err(io::Error::new(
                        io::ErrorKind::Unsupported,
                        "meshes with several keys cannot be saved",
                    ));
                }
            })?;
            save_stats(&mut writer, &index.stats())?;
            writer.bounds(&index.bounds())?;
            match index {
                Index::Research(index) => index.save(&mut writer)?,
                Index::Bvh(index) => index.save(&mut writer)?,
                Index::Blocks(index) => index.save(&mut writer)?,
                Index::Moving(_) | Index::MovingUser(_) => {}
            }
        }
        writer.end()
    }

    /// Reads the output of [`save`](Self::save), and nothing behind it. Reads in large pieces: `from` needs
    /// no buffer.
    ///
    /// A checksum finds accidental damage. For any file there is no panic, memory stays below three times its
    /// length, and rays through the loaded tree end; but hits are right only if this crate saved it.
    ///
    /// # Errors
    /// The contents are no valid tree: see [`LoadError`].
    ///
    /// ```
    /// use gnurt_accel::{LoadError, ObjectTree};
    ///
    /// let error = ObjectTree::load(&mut &b"solid teapot"[..]).expect_err("no tree");
    /// assert!(matches!(error, LoadError::NotATree));
    /// ```
    pub fn load(from: &mut impl Read) -> Result<Self, LoadError> {
        let mut reader = Reader::new(from)?;
        let starts: Vec<u32> = reader.list(u32::MAX as usize)?;
        let quads: Vec<u32> = reader.list(u32::MAX as usize)?;
        let mut counts = [0; 6];
        for count in &mut counts {
            *count = reader.number()?;
        }
        let [bad_index, nan, infinite, too_large, zero_area, too_many] = counts;
        let bad = BadPrimitives { bad_index, nan, infinite, too_large, zero_area, too_many };
        let stats = load_stats(&mut reader)?;
        let count = reader.number()?;
        if count > quads.len() as u64 {
            return Err(LoadError::Damaged("there are more trees than geometries"));
        }
        let mut parts: Vec<Part> = Vec::new();
        for _ in 0..count {
            let (mask, kind) = (reader.number()?, reader.number()?);
            let mask = u32::try_from(mask).map_err(|_| LoadError::Damaged("a mask has more than 32 bits"))?;
            let stats = load_stats(&mut reader)?;
            let bounds = reader.bounds()?;
            let index = match kind {
                BVH => Index::Bvh(BvhIndex::load(&mut reader, Memory::Fast, bounds)?),
                COMPACT_BVH => Index::Bvh(BvhIndex::load(&mut reader, Memory::Compact, bounds)?),
                KD_WATERTIGHT | KD_PROJECTED => {
                    let test = match kind {
                        KD_PROJECTED => TriangleTest::Projected,
                        _ => TriangleTest::Watertight,
                    };
                    Index::Research(ResearchIndex::load(&mut reader, bounds, stats, test)?)
                }
                _ => match BlockIndex::load(kind, &mut reader, bounds) {
                    Some(index) => Index::Blocks(index?),
                    None => return Err(LoadError::Damaged("a tree is of no kind")),
                },
            };
            parts.push(Part { mask, times: Times::SHUTTER, index });
        }
        reader.end()?;

        let count = starts.last().copied().unwrap_or(u32::MAX);
        if starts.first() != Some(&0) || !starts.is_sorted() || count as usize > MOST_TRIANGLES {
            return Err(LoadError::Damaged("its geometries are not in a row"));
        }
        if quads.len() + 1 != starts.len() || counts.iter().any(|&count| count > u64::MAX / 16) {
            return Err(LoadError::Damaged("its counts do not add up"));
        }
        if stats.primitives > u64::from(count) {
            return Err(LoadError::Damaged("its counts do not add up"));
        }
        let (mut bounds, mut measured) = (Aabb::EMPTY, TreeStats::default());
        for Part { index, .. } in &mut parts {
            if index.bounds().is_empty() {
                return Err(LoadError::Damaged("a tree has no geometry"));
            }
            match index {
                Index::Research(index) => index.check(count)?,
                Index::Bvh(index) => index.check(count)?,
                Index::Blocks(index) => index.check(count)?,
                Index::Moving(_) | Index::MovingUser(_) => {}
            }
            bounds = bounds.union(&index.bounds());
            measured = both(measured, index.stats());
        }
        // Which of them are the same primitive is no longer known.
        let stats = TreeStats { primitives: stats.primitives, ..measured };
        let quads = quads.into_iter().map(|quads| quads != 0).collect();
        let numbering = Numbering { starts, quads, too_many };
        let mut groups = vec![None; numbering.quads.len()];
        let mut is_shared = false;
        for part in &parts {
            let own = part.group();
            part.index.numbers(&mut |_, numbers| {
                for number in numbers.iter().filter(|&&number| number < count) {
                    let group = groups[geometry_of(&numbering.starts, *number)].get_or_insert(own);
                    is_shared |= *group != own;
                }
            });
        }
        // A refit looks for a tree's primitives in the geometries of its own group.
        if is_shared {
            return Err(LoadError::Damaged("a geometry is in several trees"));
        }
        Ok(Self { parts, groups, numbering, bad, bounds, stats, locations: OnceLock::new() })
    }
}

/// Without bytes, which are counted again.
fn save_stats(writer: &mut Writer<'_, impl Write>, stats: &TreeStats) -> io::Result<()> {
    let TreeStats { primitives, nodes, leaves, empty_leaves, references, depth, sah_cost, .. } = *stats;
    for number in [primitives, nodes, leaves, empty_leaves, references, u64::from(depth), sah_cost.to_bits()]
    {
        writer.number(number)?;
    }
    Ok(())
}

/// No tree has more of anything; those of as many trees as a file can hold add up to a number.
const MOST_OF_A_TREE: u64 = 1 << 36;

fn load_stats(reader: &mut Reader<'_, impl Read>) -> Result<TreeStats, LoadError> {
    let mut numbers = [0; 7];
    for number in &mut numbers {
        *number = reader.number()?;
    }
    let [primitives, nodes, leaves, empty_leaves, references, depth, sah_cost] = numbers;
    if [primitives, nodes, leaves, empty_leaves, references].iter().any(|&count| count > MOST_OF_A_TREE) {
        return Err(LoadError::Damaged("its counts do not add up"));
    }
    let depth = u32::try_from(depth).map_err(|_| LoadError::Damaged("a depth has more than 32 bits"))?;
    let sah_cost = f64::from_bits(sah_cost);
    if !(0.0..=f64::MAX).contains(&sah_cost) {
        return Err(LoadError::Damaged("invalid cost"));
    }
    let bytes = TreeStats::default();
    Ok(TreeStats { primitives, nodes, leaves, empty_leaves, references, depth, sah_cost, ..bytes })
}
