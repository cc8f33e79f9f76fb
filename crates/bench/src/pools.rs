// SPDX-License-Identifier: GPL-3.0-or-later
//! Pools of compared modes: ours and Embree's over trees of one quality, the same number of each. The best of
//! many is better than the best of few by chance, so the larger side of a pair drops its weakest modes, by a
//! fixed list, before the measurement.
//! Invariant: both sides of a pool have the same number of modes. Tests: `tests`.

use crate::Row;

/// A comparison.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pool {
    /// As tables head it: our trees over Embree's.
    pub(crate) name: &'static str,
    /// Kinds of our trees, each with the kind of Embree's whose modes it meets.
    pairs: &'static [(&'static str, &'static str)],
    /// Only calls that take one ray.
    one: bool,
}

/// All of them. Our trees are watertight, as Embree's `robust` scenes are; its `medium` and `high` ones are not.
pub(crate) const POOLS: [Pool; 7] = [
    Pool { name: "med/rob", pairs: &[("bvh-medium", "robust")], one: false },
    Pool { name: "med/med", pairs: &[("bvh-medium", "medium")], one: false },
    Pool { name: "high/high", pairs: &[("bvh-high", "high")], one: false },
    Pool { name: "any/any", pairs: &[("bvh-medium", "medium"), ("bvh-high", "high")], one: false },
    Pool { name: "1: m/rob", pairs: &[("bvh-medium", "robust")], one: true },
    Pool { name: "1: m/med", pairs: &[("bvh-medium", "medium")], one: true },
    Pool { name: "kd/med", pairs: &[("kd-medium", "medium")], one: false },
];

/// The pool whose winners are named in tables and pictures.
pub(crate) const ANY: Pool = POOLS[3];

/// Modes of our trees, the weakest last.
const OWN: [&str; 4] = ["coherent", "fanned", "one", "incoherent"];
/// Modes of Embree's scenes, widest packets first, the weakest last: single rays before narrower packets.
const EMBREE: [&str; 7] = ["16-coherent", "16", "8-coherent", "8", "1", "4-coherent", "4"];
const EMBREE_WIDE: [&str; 7] = ["16-coherent", "16", "1", "8-coherent", "8", "4-coherent", "4"];

/// The sides of a pool.
pub(crate) struct Sides<'a> {
    pub(crate) own: Vec<&'a Row>,
    pub(crate) embree: Vec<&'a Row>,
}

impl Pool {
    /// Those of `rows`, of one class and scene, that take part.
    pub(crate) fn of<'a>(&self, rows: &'a [Row]) -> Sides<'a> {
        let mut sides = Sides { own: Vec::new(), embree: Vec::new() };
        for (own, embree) in self.pairs {
            let find = |engine: &str, kind: &str, kind_name: &str| {
                rows.iter().find(|row| {
                    row.engine == engine
                        && row.mode.strip_prefix(kind).and_then(|rest| rest.strip_prefix('-'))
                            == Some(kind_name)
                })
            };
            let has_wide = EMBREE[..2].iter().any(|kind_name| find("embree4", embree, kind_name).is_some());
            let kind_names: &[&str] = if has_wide { &EMBREE_WIDE } else { &EMBREE };
            let (own_kinds, kind_names): (&[&str], &[&str]) =
                if self.one { (&["one"], &["1"]) } else { (&OWN, kind_names) };
            let mut ours: Vec<&Row> =
                own_kinds.iter().filter_map(|kind_name| find("gnurt", own, kind_name)).collect();
            let mut theirs: Vec<&Row> =
                kind_names.iter().filter_map(|kind_name| find("embree4", embree, kind_name)).collect();
            let size = ours.len().min(theirs.len());
            ours.truncate(size);
            theirs.truncate(size);
            sides.own.extend(ours);
            sides.embree.extend(theirs);
        }
        sides
    }
}

impl<'a> Sides<'a> {
    /// The fastest of each side.
    pub(crate) fn winners(&self) -> Option<[&'a Row; 2]> {
        let best = |rows: &[&'a Row]| rows.iter().copied().max_by(|a, b| a.mrays_cpu.total_cmp(&b.mrays_cpu));
        Some([best(&self.own)?, best(&self.embree)?])
    }

    /// Our best over Embree's.
    pub(crate) fn ratio(&self) -> Option<f64> {
        self.winners().map(|[own, embree]| own.mrays_cpu / embree.mrays_cpu)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::sample;
    use crate::{Class, Job};

    #[test]
    fn sides_are_of_one_size() {
        let row = |job: &Job| sample("a", Class::Ao, job.engine(), &job.mode(), 1.0);
        let all: Vec<Row> = Job::all().iter().map(row).collect();
        for widest in [16, 8, 4] {
            let has_code = |row: &&Row| {
                let size = row.mode.split('-').nth(1).and_then(|part| part.parse::<u32>().ok());
                size.is_none_or(|size| size <= widest && (size != 4 || widest < 16))
            };
            let rows: Vec<Row> = all.iter().filter(has_code).cloned().collect();
            for pool in POOLS {
                let Sides { own, embree } = pool.of(&rows);
                assert_eq!(own.len(), embree.len(), "{} with {widest} at most", pool.name);
                let expected = if pool.one { 1 } else { 4.min(widest as usize - 1) * pool.pairs.len() };
                assert_eq!(own.len(), expected, "{} with {widest} at most", pool.name);
                let widest_is_in =
                    embree.iter().any(|row| row.mode.ends_with(&format!("-{widest}-coherent")));
                assert!(widest_is_in || pool.one, "{}: {embree:?}", pool.name);
            }
        }
        let without = ANY.of(&all[..28]);
        assert!(without.own.is_empty() && without.ratio().is_none(), "nobody is compared with nobody");
    }

    #[test]
    fn like_meets_like() {
        let rows = [
            sample("a", Class::Ao, "gnurt", "bvh-high-one", 9.0),
            sample("a", Class::Ao, "gnurt", "bvh-medium-one", 6.0),
            sample("a", Class::Ao, "embree4", "robust-1", 3.0),
            sample("a", Class::Ao, "embree4", "medium-1", 4.0),
            sample("a", Class::Ao, "embree4", "high-1", 6.0),
        ];
        let ratios = POOLS.map(|pool| pool.of(&rows).ratio());
        let expected = [Some(2.0), Some(1.5), Some(1.5), Some(1.5), Some(2.0), Some(1.5), None];
        assert_eq!(ratios, expected, "a high tree of ours does not meet a medium one of Embree's");
    }
}
