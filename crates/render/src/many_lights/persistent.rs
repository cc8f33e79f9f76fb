// SPDX-License-Identifier: GPL-3.0-or-later
//! Virtual lights that persist from picture to picture while only the camera moves. They form several parts;
//! each picture replaces the oldest part, from the same random numbers, so that the picture neither flickers
//! nor lags.
//! Source: after [WBS03b] and [LSK*07] (virtual lights that are valid over frames); the division into parts
//! is our own.
//! Space: world. Each part is an unbiased estimate with its own weights, for any camera that it was chosen
//! for: so is the mean of all. Parts for a camera with another view are dropped, because they are noisy.
//! Invariants: a function of the previous pictures; a change of options starts over. Lights that do not
//! depend on the camera persist; for a camera at rest nothing changes after all parts were made for it. After
//! an edit of the world all parts are made again, each from its own random numbers and the same number of
//! light paths, which start at the same lights. A path with the same hits brings the same lights, bit for
//! bit; other paths see the edited world. The choice of lights and the number of paths are only a choice of
//! samples: valid for any world, right in the mean. It is learned again after an edit of a light, and after
//! the number of lights has drifted too far from the requested one.
//! Tests: `tests`, crates/render/tests/persistent_lights.rs.

use std::collections::VecDeque;
use std::sync::Arc;

use glam::Vec3;

use super::bound::bound_of;
use super::learned_lights;
use super::light_choice::LightChoice;
use super::pass::PassLights;
use super::vpl::Vpl;
use super::{bidirectional, instant, metropolis};
use crate::job::Job;
use crate::options::{Integrator, RenderOptions};
use crate::stats::RenderStats;
use crate::world::WorldMark;

/// Parts in use together.
const PARTS: u32 = 8;
/// The same if pixels use few lights: small ones, made occasionally, so that no picture waits for many.
const SMALL_PARTS: u32 = 32;
/// The number kept when the world changes.
const KEPT_PARTS: usize = 4;
/// The number made at once for each of the first pictures: fewer lights are limited more, and are darker.
const FIRST_PARTS: usize = 8;
const FIRST_PICTURES: u32 = 4;
/// Pictures between two of them, where nothing calls for more.
const SELDOM: u32 = 4;
/// Cosine between directions of view that are one view still, at least.
const SAME_VIEW: f32 = 0.8;
/// Motion of the eye, relative to the scene's extent, after which it counts as elsewhere.
const SAME_PLACE: f32 = 0.1;

/// Virtual lights of the pictures before, for the next one; see [`Accumulation::pass_in_motion`].
///
/// [`Accumulation::pass_in_motion`]: crate::Accumulation::pass_in_motion
#[derive(Default)]
pub struct PersistentLights {
    of: Option<(WorldMark, RenderOptions)>,
    /// The oldest one first; each has the random numbers of its number.
    parts: VecDeque<Part>,
    /// Parts made so far.
    made: u32,
    /// Parts in use once all exist; 0 = none yet. Pictures since then.
    size: u32,
    pictures: u32,
    /// The learned choice of lights, after its first use, and the number of light paths that gives the
    /// requested number of virtual lights.
    light_choices: Option<Option<LightChoice>>,
    paths: Option<u32>,
    /// Lights for pixels that use few of them, as long as no part changes.
    few: Option<Arc<PassLights>>,
}

struct Part {
    vpls: Vec<Vpl>,
    number: u32,
    /// The view that it was made for.
    view: View,
}

/// Where the middle of the picture is seen from, and its direction.
#[derive(Clone, Copy)]
struct View {
    eye: Vec3,
    forward: Vec3,
}

impl View {
    fn of(job: &Job) -> Self {
        Self { eye: job.eye, forward: job.forward }
    }

    fn is_near(&self, other: &Self, extent: f32) -> bool {
        self.forward.dot(other.forward) >= SAME_VIEW && self.eye.distance(other.eye) <= SAME_PLACE * extent
    }
}

impl PersistentLights {
    /// The lights of the next picture; `None` if the integrator needs none.
    pub(crate) fn next(&mut self, job: &Job) -> Option<PassLights> {
        let mut stats = RenderStats::default();
        self.renew(job, PARTS, &mut stats)?;
        Some(PassLights::of(job.world, job.options, self.vpls(), stats))
    }

    /// The same for pixels that use few of them, each its own, and the cost of new ones.
    pub(crate) fn next_few(&mut self, job: &Job) -> Option<(Arc<PassLights>, RenderStats)> {
        let mut stats = RenderStats::default();
        let is_new = self.renew(job, SMALL_PARTS, &mut stats)?;
        let kept = self.few.take().filter(|_| !is_new);
        let make = || PassLights::few(job.world, job.options, self.vpls(), RenderStats::default());
        let few = kept.unwrap_or_else(|| Arc::new(make()));
        self.few = Some(few.clone());
        Some((few, stats))
    }

    /// Makes the parts of the next picture; returns whether some are new or gone.
    fn renew(&mut self, job: &Job, size: u32, stats: &mut RenderStats) -> Option<bool> {
        let options = job.options;
        if !options.integrator.has_virtual_lights() {
            return None;
        }
        let edited = match &self.of {
            Some((mark, of)) if alike(of, options) && self.size == size => !mark.is_of(job.world),
            _ => {
                *self = Self { size, ..Self::default() };
                false
            }
        };
        let before = (self.made, self.parts.len());
        let view = View::of(job);
        let extent = job.world.bounds().map_or(0.0, |(low, high)| Vec3::from(low).distance(Vec3::from(high)));
        let is_of_paths = options.integrator == Integrator::InstantRadiosity;
        let hangs_on_view = !is_of_paths || learned_lights::has_many_lights(job.world);
        let are_small = size == SMALL_PARTS;
        if edited && are_small {
            self.parts.truncate(KEPT_PARTS);
        }
        if hangs_on_view && !are_small {
            self.parts.retain(|part| part.view.is_near(&view, extent));
        }
        if edited {
            self.follow_edits(job, view, stats);
        } else {
            // The importance of lights depends on the view, too; it is updated once in a round of parts.
            if self.made.is_multiple_of(size) || self.parts.is_empty() {
                self.light_choices = None;
            }
            let is_due = !are_small
                || self.pictures.is_multiple_of(SELDOM)
                || self.parts.front().is_some_and(|part| !part.view.is_near(&view, extent));
            if hangs_on_view && is_due && self.parts.len() == size as usize {
                self.parts.pop_front();
            }
        }
        self.pictures = self.pictures.wrapping_add(1);
        if edited || self.of.is_none() {
            self.of = Some((job.world.mark(), options.clone()));
        }
        let at_once = match self.parts.len() {
            _ if !are_small => size as usize,
            0 => FIRST_PARTS,
            _ if !edited && self.pictures <= FIRST_PICTURES => FIRST_PARTS,
            _ => 1,
        };
        for number in self.missing().take(at_once).collect::<Vec<u32>>() {
            let vpls = self.part(job, number, stats);
            self.parts.push_back(Part { vpls, number, view });
            self.made += 1;
        }
        Some(edited || before != (self.made, self.parts.len()))
    }

    /// The lights of all parts.
    fn vpls(&self) -> Vec<Vpl> {
        let share = 1.0 / self.parts.len() as f32;
        // In the order of their numbers, so that the same lights are the same picture.
        let mut parts: Vec<&Part> = self.parts.iter().collect();
        parts.sort_by_key(|part| part.number);
        let all = parts.into_iter().flat_map(|part| &part.vpls);
        all.map(|vpl| vpl.scaled(share)).collect()
    }

    /// Makes all parts again, for the world as it is.
    fn follow_edits(&mut self, job: &Job, view: View, stats: &mut RenderStats) {
        let same_lights = self.of.as_ref().is_some_and(|(mark, _)| mark.has_lights_of(job.world));
        if !same_lights {
            (self.light_choices, self.paths) = (None, None);
        }
        if self.parts.is_empty() {
            self.light_choices = None;
        }
        let are_as_many = self.paths.is_some();
        self.make_again(job, view, stats);
        let found: usize = self.parts.iter().map(|part| part.vpls.len()).sum();
        let requested = job.options.vpls as usize * self.parts.len() / self.size.max(1) as usize;
        if are_as_many && (4 * found < 3 * requested || 3 * found > 4 * requested) {
            self.paths = None;
            self.make_again(job, view, stats);
        }
    }

    /// Makes all parts again, each from its numbers.
    fn make_again(&mut self, job: &Job, view: View, stats: &mut RenderStats) {
        for mut part in std::mem::take(&mut self.parts) {
            (part.vpls, part.view) = (self.part(job, part.number, stats), view);
            self.parts.push_back(part);
        }
    }

    /// A part from the random numbers of its number.
    fn part(&mut self, job: &Job, number: u32, stats: &mut RenderStats) -> Vec<Vpl> {
        if job.options.integrator == Integrator::InstantRadiosity {
            self.of_paths(job, number, stats)
        } else {
            chosen(job, number, self.size, stats)
        }
    }

    /// Numbers of the parts that are not there.
    fn missing(&self) -> impl Iterator<Item = u32> {
        let is_there = move |number: u32| self.parts.iter().any(|part| part.number == number);
        (0..self.size).filter(move |&number| !is_there(number))
    }

    /// A part of the light paths of a set: all parts are a whole one.
    fn of_paths(&mut self, job: &Job, number: u32, stats: &mut RenderStats) -> Vec<Vpl> {
        let light_choices =
            self.light_choices.get_or_insert_with(|| learned_lights::learned(job, stats)).as_ref();
        let requested = job.options.vpls;
        let all = *self.paths.get_or_insert_with(|| instant::paths_for(job, light_choices, requested, stats));
        let paths = all.div_ceil(self.size.max(1));
        let found = instant::vertices(job, light_choices, 0, number * paths..(number + 1) * paths, stats);
        found.iter().map(|v| v.vpl.scaled(1.0 / paths as f32)).collect()
    }
}

/// Fewer lights, chosen for the camera.
fn chosen(job: &Job, number: u32, size: u32, stats: &mut RenderStats) -> Vec<Vpl> {
    let few = RenderOptions { vpls: job.options.vpls.div_ceil(size), ..job.options.clone() };
    let bound = bound_of(job.world, job.options);
    let job = Job::new(job.world, job.camera, &few, job.watch);
    match few.integrator {
        Integrator::BidirectionalInstantRadiosity => {
            bidirectional::virtual_lights(&job, number, bound, stats)
        }
        _ => metropolis::virtual_lights(&job, number, bound, stats),
    }
}

/// Whether virtual lights for one are good for the other.
pub(crate) fn alike(a: &RenderOptions, b: &RenderOptions) -> bool {
    let what = |o: &RenderOptions| {
        (o.integrator, o.vpls, o.max_depth, o.clamp, o.seed_of_lights(), o.white, o.ray_epsilon)
    };
    what(a) == what(b)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use gnurt_scene::{InstanceId, Scene};

    use super::*;
    use crate::camera::SceneCamera;
    use crate::progress::Unwatched;
    use crate::world::{CommitOptions, ShaderTable, World};

    /// Positions of the lights of the next picture.
    fn light_positions(
        persistent: &mut PersistentLights,
        world: &World,
        scene: &Scene,
        options: &RenderOptions,
    ) -> Vec<[u32; 3]> {
        let camera = SceneCamera::new(&scene.cameras()[0]).expect("a view");
        let pass = persistent.next(&Job::new(world, &camera, options, &Unwatched)).expect("virtual lights");
        pass.vpls.iter().map(|vpl| vpl.point.p.to_array().map(f32::to_bits)).collect()
    }

    /// Nothing is prepared again where no light is new.
    #[test]
    fn few_lights_are_kept_as_long_as_they_last() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
        let mut scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
        let integrator = Integrator::InstantRadiosity;
        let options = RenderOptions { width: 8, height: 8, vpls: 64, integrator, ..RenderOptions::default() };
        let (mut world, mut persistent) = (World::new(), PersistentLights::default());
        let how = CommitOptions::default();
        world.commit(&scene, &ShaderTable::default(), &how, &pool).expect("the scene is sound");
        let camera = SceneCamera::new(&scene.cameras()[0]).expect("a view");
        let mut next = |world: &World| {
            let job = Job::new(world, &camera, &options, &Unwatched);
            persistent.next_few(&job).expect("virtual lights")
        };
        let pictures = 2 * SMALL_PARTS;
        let all: Vec<_> = (0..pictures).map(|_| next(&world)).collect();
        let new = all.windows(2).filter(|two| !Arc::ptr_eq(&two[0].0, &two[1].0)).count();
        assert_eq!(new, FIRST_PICTURES as usize - 1, "all are made for the first pictures");
        let (last, cost) = &all[all.len() - 1];
        assert_eq!(cost.rays(), 0, "kept ones cost nothing");
        let last_instance = InstanceId(scene.instances().len() as u32 - 1);
        scene.edit_instance(last_instance).visible = false;
        world.commit(&scene, &ShaderTable::default(), &how, &pool).expect("the scene is sound");
        let (edited, cost) = next(&world);
        assert!(!Arc::ptr_eq(last, &edited) && cost.rays() > 0, "an edit makes all of them again");
    }

    /// An object goes and comes back: lights whose paths never hit it stay in place.
    #[test]
    fn paths_that_meet_nothing_new_bring_the_same_lights() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads start");
        let mut scene = gnurt_scene::builtin::load("cornell").expect("it is built in");
        let integrator = Integrator::InstantRadiosity;
        let options =
            RenderOptions { width: 8, height: 8, vpls: 512, integrator, ..RenderOptions::default() };
        let (mut world, mut persistent) = (World::new(), PersistentLights::default());
        let commit = |world: &mut World, scene: &Scene| {
            let how = CommitOptions::default();
            world.commit(scene, &ShaderTable::default(), &how, &pool).expect("the scene is sound");
        };
        commit(&mut world, &scene);
        // Enough lights that their importance is learned: if it were learned again, all paths would start
        // elsewhere.
        let [low, high] = world.bounds().map(|(low, high)| [low, high]).expect("a room");
        for i in 1..6 {
            let at = |k: usize| low[k] + (high[k] - low[k]) * ((i * (k + 2)) as f32 * 0.37).fract();
            let intensity = [0.02 * (high[0] - low[0]).powi(2) * i as f32; 3];
            scene.add_light(gnurt_scene::Light::Point {
                position: [0, 1, 2].map(at),
                intensity,
                radius: 0.0,
            });
        }
        commit(&mut world, &scene);
        let first = light_positions(&mut persistent, &world, &scene, &options);
        let last = InstanceId(scene.instances().len() as u32 - 1);
        scene.edit_instance(last).visible = false;
        commit(&mut world, &scene);
        let without = light_positions(&mut persistent, &world, &scene, &options);
        let anew = light_positions(&mut PersistentLights::default(), &world, &scene, &options);
        let before: HashSet<_> = first.iter().collect();
        let staying =
            |now: &[[u32; 3]]| now.iter().filter(|light_position| before.contains(light_position)).count();
        let [stay, by_chance] = [&without, &anew].map(|now| staying(now));
        assert!(2 * stay > without.len(), "{stay} of {} stay", without.len());
        assert!(10 * stay > 11 * by_chance, "{stay} stay, and {by_chance} would if all were learned anew");
        scene.edit_instance(last).visible = true;
        commit(&mut world, &scene);
        assert_eq!(
            light_positions(&mut persistent, &world, &scene, &options),
            first,
            "all as it was, bit for bit"
        );
    }
}
