// SPDX-License-Identifier: GPL-3.0-or-later
//! Animations as the file writes them: channels with their keys, before the node tree is known.
//! Source: glTF 2.0 section 3.11, KHR_animation_pointer.
//! An animation that cannot be played (invalid times, wrong counts, an unknown interpolation) is dropped with
//! a warning, because the scene at rest is valid. An index out of range is an error, as everywhere. Keys are
//! shared where channels share them. Tests: `tests/animation.rs`, `tests/broken_files.rs`, `tests/growth.rs`.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::accessor::floats;
use super::animation_json;
use super::document::Document;
use super::json::Index;
use super::pointer::{Aim, NodePart, WeightsOf};
use gnurt_scene::affine::Affine;
use gnurt_scene::animation::{Interpolation, Sampler, stretches};
use gnurt_scene::io::reader::quoted;
use gnurt_scene::io::{Error, Oddity, Warnings};

/// An animation of the file.
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) channels: Vec<DraftChannel>,
}

pub(super) struct DraftChannel {
    pub(super) aim: Aim,
    pub(super) sampler: Arc<Sampler>,
    /// Its index in the file.
    pub(super) number: u32,
}

/// All animations of a file and their targets.
#[derive(Default)]
pub(super) struct Drafts {
    pub(super) list: Vec<Draft>,
    /// Nodes that are moved, shown or hidden.
    nodes: HashSet<Index>,
    weights: HashSet<WeightsOf>,
    angles: HashSet<Index>,
    lights: HashSet<Index>,
    materials: HashSet<Index>,
    /// Whether a node is scaled by more in one direction than in another.
    pub(super) stretches: bool,
}

impl Drafts {
    pub(super) fn drives_node(&self, node: Index) -> bool {
        self.nodes.contains(&node)
    }

    pub(super) fn drives_weights(&self, of: WeightsOf) -> bool {
        self.weights.contains(&of)
    }

    pub(super) fn drives_angle(&self, camera: Index) -> bool {
        self.angles.contains(&camera)
    }

    pub(super) fn drives_light(&self, light: Index) -> bool {
        self.lights.contains(&light)
    }

    pub(super) fn drives_material(&self, material: Index) -> bool {
        self.materials.contains(&material)
    }

    fn note(&mut self, aim: Aim, sampler: &Sampler) {
        match aim {
            Aim::Node(node, part) => {
                self.nodes.insert(node);
                let is_uneven = |s: &[f32]| stretches(&Affine::scale([s[0], s[1], s[2]].map(f64::from)));
                self.stretches |= part == NodePart::Scale && sampler.keys().any(is_uneven);
            }
            Aim::Weights(of, _) => _ = self.weights.insert(of),
            Aim::FieldOfView(camera) => _ = self.angles.insert(camera),
            Aim::Light(light, _) => _ = self.lights.insert(light),
            Aim::Material(material, _) => _ = self.materials.insert(material),
        }
    }
}

/// Bytes of a channel with its entries in the sets.
const CHANNEL_BYTES: usize = size_of::<DraftChannel>() + size_of::<gnurt_scene::animation::Channel>() + 64;
/// Bytes that an animation takes.
const CLIP_BYTES: usize = size_of::<Draft>() + size_of::<gnurt_scene::animation::Clip>();

/// Reads all animations of a document.
pub(super) fn read(document: &Document<'_>, warnings: &mut Warnings) -> Result<Drafts, Error> {
    let count = document.root.animations.len();
    document.hold(count * CLIP_BYTES, "animations")?;
    let mut drafts = Drafts { list: Vec::with_capacity(count), ..Drafts::default() };
    let mut times = HashMap::new();
    for (i, piece) in document.root.animations.iter().enumerate() {
        let location = format!("animations[{i}]");
        let from: animation_json::Animation<'_> = document.read(piece, &location)?;
        let mut reader =
            Reader { document, from: &from, location, times: &mut times, samplers: HashMap::new() };
        let mut channels = Vec::new();
        for k in 0..from.channels.len() as u32 {
            if let Some(channel) = reader.channel(Index(k), warnings)? {
                drafts.note(channel.aim, &channel.sampler);
                channels.push(channel);
            }
        }
        channels.shrink_to_fit();
        let name = from.name.unwrap_or_default();
        document.hold(name.len(), "animations")?;
        drafts.list.push(Draft { name, channels });
    }
    Ok(drafts)
}

/// The channels of one animation.
struct Reader<'a, 'd> {
    document: &'a Document<'d>,
    from: &'a animation_json::Animation<'d>,
    location: String,
    /// Times of keys, by their accessors.
    times: &'a mut HashMap<Index, Arc<[f32]>>,
    /// Keys already read, by sampler and width; `None` = unplayable ones.
    samplers: HashMap<(Index, Option<usize>), Option<Arc<Sampler>>>,
}

impl<'d> Reader<'_, 'd> {
    fn channel(&mut self, number: Index, warnings: &mut Warnings) -> Result<Option<DraftChannel>, Error> {
        let document = self.document;
        let location = format!("{}.channels[{}]", self.location, number.0);
        let channel: animation_json::Channel<'_> =
            document.get(&self.from.channels, number, &location, "channel")?;
        let aim = match (&channel.target.extensions.pointer, channel.target.node) {
            (Some(pointer), _) if &*channel.target.path == "pointer" => Aim::of_pointer(&pointer.pointer),
            (_, Some(node)) => Aim::of_path(node, &channel.target.path),
            _ => None,
        };
        let Some(aim) = aim else {
            let pointer = channel.target.extensions.pointer.as_ref().map(|pointer| &*pointer.pointer);
            let detail =
                format!("{location}: animation of {}", quoted(pointer.unwrap_or(&channel.target.path)));
            warnings.note(Oddity::NotShown, &document.path, None, detail);
            return Ok(None);
        };
        self.check(aim, &location)?;
        document.hold(CHANNEL_BYTES, &location)?;
        let sampler = self.sampler(channel.sampler, aim, &location, warnings)?;
        Ok(sampler.map(|sampler| DraftChannel { aim, sampler, number: number.0 }))
    }

    /// Whether the target exists.
    fn check(&self, aim: Aim, location: &str) -> Result<(), Error> {
        let root = &self.document.root;
        let lights = root.extensions.lights.as_ref().map_or(0, |lights| lights.lights.len());
        let (what, index, count) = match aim {
            Aim::Node(node, _) | Aim::Weights(WeightsOf::Node(node), _) => ("node", node, root.nodes.len()),
            Aim::Weights(WeightsOf::Mesh(mesh), _) => ("mesh", mesh, root.meshes.len()),
            Aim::FieldOfView(camera) => ("camera", camera, root.cameras.len()),
            Aim::Light(light, _) => ("light", light, lights),
            Aim::Material(material, _) => ("material", material, root.materials.len()),
        };
        match index.value() < count {
            true => Ok(()),
            false => Err(self.document.error(location, format!("{what} {} does not exist", index.0), "")),
        }
    }

    fn sampler(
        &mut self,
        index: Index,
        aim: Aim,
        channel: &str,
        warnings: &mut Warnings,
    ) -> Result<Option<Arc<Sampler>>, Error> {
        let key = (index, aim.width());
        if let Some(known) = self.samplers.get(&key) {
            return Ok(known.clone());
        }
        let document = self.document;
        let location = format!("{}.samplers[{}]", self.location, index.0);
        let curve: animation_json::Curve<'_> =
            document.get(&self.from.samplers, index, channel, "sampler")?;
        let interpolation = match curve.interpolation.as_deref() {
            None | Some("LINEAR") => Ok(Interpolation::Linear),
            Some("STEP") => Ok(Interpolation::Step),
            Some("CUBICSPLINE") => Ok(Interpolation::CubicSpline),
            Some(other) => Err(format!("unknown interpolation {}", quoted(other))),
        };
        let read = match interpolation {
            Ok(interpolation) => self.keys(&curve, interpolation, aim.width(), &location)?,
            Err(problem) => Err(problem),
        };
        let sampler = match read {
            Ok(sampler) => {
                if sampler.has_equal_times() {
                    warnings.note(Oddity::RepeatedKey, &document.path, None, &location[..]);
                }
                Some(Arc::new(sampler))
            }
            Err(problem) => {
                let detail = format!("{location} of {channel}: {problem}");
                warnings.note(Oddity::BadAnimation, &document.path, None, detail);
                None
            }
        };
        self.samplers.insert(key, sampler.clone());
        Ok(sampler)
    }

    /// The keys; the inner error gives the reason that they cannot be played.
    fn keys(
        &mut self,
        curve: &animation_json::Curve<'_>,
        interpolation: Interpolation,
        width: Option<usize>,
        location: &str,
    ) -> Result<Result<Sampler, String>, Error> {
        let document = self.document;
        let times = match self.times.get(&curve.input) {
            Some(times) => times.clone(),
            None => {
                let times: Arc<[f32]> = flat::<1>(document, curve.input, location)?.into();
                self.times.insert(curve.input, times.clone());
                times
            }
        };
        let values = match width {
            Some(2) => flat::<2>(document, curve.output, location)?,
            Some(3) => flat::<3>(document, curve.output, location)?,
            Some(4) => flat::<4>(document, curve.output, location)?,
            _ => flat::<1>(document, curve.output, location)?,
        };
        let sets = times.len() * interpolation.sets();
        let width = match width {
            Some(width) => width,
            // The number of morph targets, which is checked where the mesh is known.
            None if sets > 0 && !values.is_empty() && values.len() % sets == 0 => values.len() / sets,
            None => return Ok(Err(format!("{} weights for {} keys", values.len(), times.len()))),
        };
        Ok(Sampler::new(times, values, width, interpolation).map_err(|error| error.to_string()))
    }
}

/// The first `N` components of each element, one after the other.
fn flat<const N: usize>(document: &Document<'_>, index: Index, location: &str) -> Result<Vec<f32>, Error> {
    let before = document.budget().held();
    let values = floats::<N>(document, index, location, None)?.into_flattened();
    document.budget().settle(before);
    document.hold(size_of_val(&values[..]), location)?;
    Ok(values)
}
