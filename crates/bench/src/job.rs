// SPDX-License-Identifier: GPL-3.0-or-later
//! Jobs that can be timed: an engine, its structure and its kind of query; and the selection of jobs.
//! Tests: `tests`.

use std::fmt;

use gnurt::accel::{BuildOptions, Coherence, Memory, Quality, Structure};

use crate::{Error, research};

/// One measurement. Its [`mode`](Self::mode) is its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Job {
    /// One of our trees.
    Own {
        /// The built structure.
        kind: OwnKind,
        /// The kind of query.
        query_kind: QueryKind,
    },
    /// A scene of Embree's.
    Embree {
        /// How it is built.
        kind: EmbreeKind,
        /// The kind of query.
        packets: Packets,
    },
}

/// How we build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OwnKind {
    /// The structure.
    pub structure: Structure,
    /// How carefully it is built.
    pub quality: Quality,
    /// Whether it is to be fast or small.
    pub memory: Memory,
}

/// How one of our trees is queried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    /// One ray per call.
    One,
    /// A batch per call, with this coherence.
    Batch(Coherence),
}

/// How Embree builds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmbreeKind {
    /// Medium quality.
    Medium,
    /// High quality: spatial splits.
    High,
    /// Medium quality, watertight: the fair comparison with our trees. (With high quality, robust scenes are
    /// the same as these.)
    Robust,
    /// Medium quality in less memory: the fair comparison with our compact trees.
    Compact,
}

/// How Embree is queried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packets {
    /// Rays per call: 1, 4, 8 or 16.
    pub size: usize,
    /// Whether they are marked as coherent.
    pub coherent: bool,
}

impl EmbreeKind {
    pub(crate) const ALL: [Self; 4] = [Self::Medium, Self::High, Self::Robust, Self::Compact];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Medium => "medium",
            Self::High => "high",
            Self::Robust => "robust",
            Self::Compact => "compact",
        }
    }
}

impl OwnKind {
    pub(crate) const MEDIUM: Self = Self::new(Structure::Bvh, Quality::Medium);
    pub(crate) const FAST: Self = Self::new(Structure::Bvh, Quality::Fast);
    pub(crate) const HIGH: Self = Self::new(Structure::Bvh, Quality::High);

    /// All that are compiled in.
    pub(crate) fn all() -> Vec<Self> {
        let mut all =
            vec![Self::FAST, Self::MEDIUM, Self::HIGH, Self { memory: Memory::Compact, ..Self::MEDIUM }];
        if let Some(kd) = research::find("kd") {
            all.extend([Quality::Fast, Quality::Medium, Quality::High].map(|quality| Self::new(kd, quality)));
        }
        all.extend(research::find("grid").map(|grid| Self::new(grid, Quality::Fast)));
        all
    }

    /// Kd-trees of high quality equal those of medium quality; grids are measured on request.
    pub(crate) fn is_second(self) -> bool {
        match research::name(self.structure) {
            "grid" => true,
            "kd" => self.quality == Quality::High,
            _ => false,
        }
    }

    pub(crate) const fn new(structure: Structure, quality: Quality) -> Self {
        Self { structure, quality, memory: Memory::Fast }
    }

    pub(crate) fn options(self) -> BuildOptions {
        let Self { structure, quality, memory } = self;
        BuildOptions { structure, quality, memory, ..BuildOptions::default() }
    }

    /// `bvh-medium`, `bvh-compact`, `kd-fast`, ...; grids have one quality.
    pub(crate) fn name(self) -> String {
        let structure = research::name(self.structure);
        if structure == "grid" {
            return structure.to_owned();
        }
        let quality = match (self.memory, self.quality) {
            (Memory::Compact, _) => "compact",
            (_, Quality::Fast) => "fast",
            (_, Quality::Medium) => "medium",
            (_, Quality::High) => "high",
        };
        format!("{structure}-{quality}")
    }
}

impl Job {
    /// `gnurt` or `embree4`.
    #[must_use]
    pub fn engine(&self) -> &'static str {
        match self {
            Self::Own { .. } => ENGINES[0],
            Self::Embree { .. } => ENGINES[1],
        }
    }

    /// `bvh-medium-coherent`, `kd-fast-one`, `robust-16-coherent`, ...
    #[must_use]
    pub fn mode(&self) -> String {
        match self {
            Self::Own { kind, query_kind } => {
                let query_kind = match query_kind {
                    QueryKind::One => "one",
                    QueryKind::Batch(Coherence::Coherent) => "coherent",
                    QueryKind::Batch(Coherence::Fanned) => "fanned",
                    QueryKind::Batch(Coherence::Incoherent) => "incoherent",
                };
                format!("{}-{query_kind}", kind.name())
            }
            Self::Embree { kind, packets } => {
                let coherent = if packets.coherent { "-coherent" } else { "" };
                format!("{}-{}{coherent}", kind.name(), packets.size)
            }
        }
    }

    /// All that there is, ours first. The coherent flag has no meaning for single rays.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let mut jobs = Vec::new();
        for kind in OwnKind::all() {
            let batches =
                [Coherence::Coherent, Coherence::Fanned, Coherence::Incoherent].map(QueryKind::Batch);
            let query_kind = [QueryKind::One].into_iter().chain(batches);
            jobs.extend(query_kind.map(|query_kind| Self::Own { kind, query_kind }));
        }
        for kind in EmbreeKind::ALL {
            jobs.push(Self::Embree { kind, packets: Packets { size: 1, coherent: false } });
            for (size, coherent) in [4, 8, 16].into_iter().flat_map(|size| [(size, false), (size, true)]) {
                jobs.push(Self::Embree { kind, packets: Packets { size, coherent } });
            }
        }
        jobs
    }

    /// Whether it is timed by default: fast builds, grids and compact trees are not, and of kd-trees only one
    /// quality, because high is medium.
    fn is_usual(&self) -> bool {
        match self {
            Self::Own { kind, .. } => {
                !kind.is_second() && kind.quality != Quality::Fast && kind.memory == Memory::Fast
            }
            Self::Embree { kind, .. } => *kind != EmbreeKind::Compact,
        }
    }
}

impl fmt::Display for Job {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.engine(), self.mode())
    }
}

/// Names of the engines.
pub const ENGINES: [&str; 2] = ["gnurt", "embree4"];

/// Which jobs are selected.
#[derive(Clone, Debug, Default)]
pub struct Filter {
    /// Names of engines; empty = all.
    pub engines: Vec<String>,
    /// Parts of names of modes, any of which will do; empty = the usual ones.
    pub modes: Vec<String>,
}

impl Filter {
    /// Whether an engine is selected.
    #[must_use]
    pub fn has_engine(&self, engine: &str) -> bool {
        self.engines.is_empty() || self.engines.iter().any(|name| name == engine)
    }

    /// The selected jobs.
    ///
    /// # Errors
    /// [`Error::NothingToDo`] if a part of a name is in no mode of the selected engines.
    pub fn jobs(&self) -> Result<Vec<Job>, Error> {
        let mut jobs = Job::all();
        jobs.retain(|job| self.has_engine(job.engine()));
        let modes: Vec<String> = jobs.iter().map(Job::mode).collect();
        if !self.modes.iter().all(|part| modes.iter().any(|mode| mode.contains(part))) {
            return Err(Error::NothingToDo { valid: modes });
        }
        jobs.retain(|job| match self.modes.is_empty() {
            true => job.is_usual(),
            false => self.modes.iter().any(|part| job.mode().contains(part)),
        });
        Ok(jobs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        let mut names: Vec<String> = Job::all().iter().map(ToString::to_string).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!((count, names.len()), (32 + 28, 32 + 28), "one name each");
    }

    #[test]
    fn filters() {
        let modes = |engines: &[&str], modes: &[&str]| {
            let list = |names: &[&str]| names.iter().map(ToString::to_string).collect();
            let filter = Filter { engines: list(engines), modes: list(modes) };
            filter.jobs().map(|jobs| jobs.iter().map(ToString::to_string).collect::<Vec<_>>())
        };
        let two = modes(&[], &["bvh-fast-one", "robust-1"]).expect("there are such");
        assert_eq!(
            two,
            ["gnurt bvh-fast-one", "embree4 robust-1", "embree4 robust-16", "embree4 robust-16-coherent"],
            "parts of names"
        );
        let usual = modes(&["gnurt"], &[]).expect("there are such");
        assert_eq!(usual.len(), 12, "medium and high, and one kd-tree: {usual:?}");
        let small = modes(&[], &["compact-one", "compact-16"]).expect("there are such");
        assert_eq!(
            small,
            ["gnurt bvh-compact-one", "embree4 compact-16", "embree4 compact-16-coherent"],
            "small trees"
        );
        assert!(modes(&["gnurt"], &["kd-medium", "robust"]).is_err(), "a name that is in none is a slip");
    }
}
