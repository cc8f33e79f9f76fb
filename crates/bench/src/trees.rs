// SPDX-License-Identifier: GPL-3.0-or-later
//! The structures for the jobs of a scene: our trees and Embree's scenes, each built once.

use gnurt::ThreadPool;
use gnurt::accel::{ObjectTree, Threads};
use gnurt::simd::Level;

use crate::comparison::Contestant;
use crate::embree::EmbreeEngine;
use crate::event::BenchEvent;
use crate::ffi_embree::{Device, Scene};
use crate::job::{EmbreeKind, OwnKind, QueryKind};
use crate::own::OwnEngine;
use crate::{EmbreeLibrary, Error, Job, Subject};

/// A library, and a device of it.
pub(crate) type Reference<'a> = (&'a EmbreeLibrary, &'a Device<'a>);

/// The request.
pub(crate) struct Trees<'a> {
    own: Vec<(OwnKind, ObjectTree)>,
    embree: Vec<(EmbreeKind, Scene<'a>)>,
    device: Option<&'a Device<'a>>,
}

impl<'a> Trees<'a> {
    /// Builds the structures for the jobs. Jobs of an absent engine need none.
    pub(crate) fn build(
        subject: &'a Subject,
        jobs: &[Job],
        reference_engine: Option<Reference<'a>>,
        pool: &ThreadPool,
        report: &mut dyn FnMut(BenchEvent),
    ) -> Result<Self, Error> {
        let mut trees =
            Self { own: Vec::new(), embree: Vec::new(), device: reference_engine.map(|(_, device)| device) };
        // The reference tree for primary rays comes first: the same for all measurements.
        trees.add_own(subject, OwnKind::MEDIUM, pool, report);
        for job in jobs {
            match *job {
                Job::Own { kind, .. } => trees.add_own(subject, kind, pool, report),
                Job::Embree { kind, .. } => trees.add_embree(subject, kind, reference_engine, report)?,
            }
        }
        Ok(trees)
    }

    fn add_own(
        &mut self,
        subject: &Subject,
        kind: OwnKind,
        pool: &ThreadPool,
        report: &mut dyn FnMut(BenchEvent),
    ) {
        if self.own(kind).is_none() {
            let tree = ObjectTree::build(&[subject.triangles()], &kind.options(), Threads::Pool(pool));
            report(BenchEvent::Built(format!("{}: gnurt {}", subject.name, kind.name())));
            self.own.push((kind, tree));
        }
    }

    fn add_embree(
        &mut self,
        subject: &'a Subject,
        kind: EmbreeKind,
        reference_engine: Option<Reference<'a>>,
        report: &mut dyn FnMut(BenchEvent),
    ) -> Result<(), Error> {
        let Some((library, device)) = reference_engine else { return Ok(()) };
        if self.embree.iter().any(|(known, _)| *known == kind) {
            return Ok(());
        }
        let (quality, flags) = kind.settings();
        let scene = Scene::build(device, &subject.padded, &subject.indices, quality, flags);
        self.embree.push((kind, scene.map_err(|why| library.failed(why))?));
        report(BenchEvent::Built(format!("{}: embree4 {}", subject.name, kind.name())));
        Ok(())
    }

    fn own(&self, kind: OwnKind) -> Option<&ObjectTree> {
        self.own.iter().find(|(known, _)| *known == kind).map(|(_, tree)| tree)
    }

    /// The reference tree for primary rays.
    pub(crate) fn reference(&self) -> &ObjectTree {
        &self.own[0].1
    }

    /// The engine of a job. `None` for jobs without code for this CPU; single calls use the CPU's best level
    /// only.
    pub(crate) fn contestant(&'a self, job: Job, level: Level) -> Option<Contestant<'a>> {
        let (engine, mode, isa) = (job.engine(), job.mode(), level.name());
        match job {
            Job::Own { kind, query_kind } => {
                let is_possible = query_kind != QueryKind::One || level == Level::best();
                let tree = self.own(kind).filter(|_| is_possible)?;
                Some(Contestant {
                    engine,
                    mode,
                    isa,
                    tracer: Box::new(OwnEngine { tree, query_kind, level }),
                })
            }
            Job::Embree { kind, packets } => {
                // Packets of four are for CPUs that have none of sixteen: the two widest take part.
                let has = |size| self.device.is_some_and(|device| device.has_packets(size));
                let has_code = has(packets.size) && (packets.size != 4 || !has(16));
                let (_, scene) = self.embree.iter().find(|(known, _)| has_code && *known == kind)?;
                Some(Contestant { engine, mode, isa, tracer: Box::new(EmbreeEngine { scene, packets }) })
            }
        }
    }
}
