// SPDX-License-Identifier: GPL-3.0-or-later
//! The animation under construction: the file's moving nodes, the things attached to them, and their
//! channels.
//! Source: glTF 2.0 sections 3.5, 3.7.3 and 3.11; KHR_node_visibility. A node moves if a channel moves it or
//! an ancestor; only moving nodes become nodes of the animation. Tests: `tests/animation.rs`.

use std::collections::HashMap;

use super::animation::Drafts;
use super::document::Document;
use super::json::{self, Index};
use super::pointer::{Aim, NodePart, WeightsOf};
use gnurt_scene::Scene;
use gnurt_scene::affine::Affine;
use gnurt_scene::animation::{
    Animation, Attachment, Channel, Clip, Joint, LightFactors, Local, MovingMaterial, Node, Skin, Target,
    Trs, stretches,
};
use gnurt_scene::io::{Error, Oddity, Warnings};

/// Bytes of a node of the animation, without its name.
const NODE_BYTES: usize = size_of::<Node>() + 2 * size_of::<(Index, u32)>();

/// The unfinished animation, and the indices of the file's elements in it.
pub(super) struct Rig<'a> {
    document: &'a Document<'a>,
    pub(super) drafts: Drafts,
    pub(super) made: Animation,
    nodes: HashMap<Index, u32>,
    /// Whether nodes of the animation are seen at rest, with all above them.
    visible: Vec<bool>,
    weights: HashMap<WeightsOf, u32>,
    skins: HashMap<Index, u32>,
    angles: HashMap<Index, u32>,
    lights: HashMap<Index, u32>,
    materials: HashMap<Index, u32>,
    /// The attachments of joints, and their rest transforms.
    joints: HashMap<Index, (Attachment, Affine)>,
}

impl<'a> Rig<'a> {
    /// The joints of the document's skins, and `materials`, the driven ones.
    pub(super) fn new(
        document: &'a Document<'a>,
        drafts: Drafts,
        materials: Vec<MovingMaterial>,
    ) -> Result<Self, Error> {
        let driven = |i: &u32| drafts.drives_material(Index(*i));
        let numbers = (0..document.root.materials.len() as u32).filter(driven).map(Index).zip(0..).collect();
        Ok(Self {
            document,
            drafts,
            made: Animation { materials, ..Animation::default() },
            nodes: HashMap::new(),
            visible: Vec::new(),
            weights: HashMap::new(),
            skins: HashMap::new(),
            angles: HashMap::new(),
            lights: HashMap::new(),
            materials: numbers,
            joints: joints_of_all_skins(document)?,
        })
    }

    /// Whether no traversal for joints and channels is needed.
    pub(super) fn is_still(&self) -> bool {
        self.joints.is_empty() && self.drafts.list.is_empty()
    }

    /// The transform of a node under `parent`; it becomes a node of the animation if it moves.
    pub(super) fn enter(
        &mut self,
        index: Index,
        node: &json::Node,
        parent: Attachment,
        world_from_node: Affine,
    ) -> Result<Attachment, Error> {
        let visible = node.extensions.visibility.as_ref().is_none_or(|v| v.visible);
        let attachment = match (self.nodes.get(&index), parent) {
            (Some(&known), _) => Attachment::On(known),
            (None, Attachment::Fixed { visible: above, .. }) if !self.drafts.drives_node(index) => {
                Attachment::Fixed { world_from_node, visible: above && visible }
            }
            (None, parent) => {
                let name = node.name.clone().unwrap_or_default();
                self.document.hold(NODE_BYTES + name.len(), "nodes")?;
                let number = self.made.nodes.len() as u32;
                self.visible.push(self.is_visible(parent) && visible);
                self.made.nodes.push(Node { name, parent, rest: local(node), visible });
                self.nodes.insert(index, number);
                Attachment::On(number)
            }
        };
        if let Some(joint) = self.joints.get_mut(&index) {
            *joint = (attachment, world_from_node);
        }
        Ok(attachment)
    }

    /// Whether things attached there are visible at rest.
    pub(super) fn is_visible(&self, attachment: Attachment) -> bool {
        match attachment {
            Attachment::On(node) => self.visible[node as usize],
            Attachment::Fixed { visible, .. } => visible,
        }
    }

    /// Whether a skin may stretch the normals of its mesh: a node or an ancestor is scaled unevenly.
    fn may_stretch(&self) -> bool {
        let uneven = |node: &Node| {
            let above = match node.parent {
                Attachment::Fixed { world_from_node, .. } => stretches(&world_from_node),
                Attachment::On(_) => false,
            };
            above || stretches(&node.rest.affine())
        };
        self.drafts.stretches || self.made.nodes.iter().any(uneven)
    }

    /// The joints of a skin, and their world-from-mesh matrices at rest.
    pub(super) fn skin(&self, index: Index, warnings: &mut Warnings) -> Result<(Skin, Vec<Affine>), Error> {
        let document = self.document;
        let skin_place = format!("skins[{}]", index.0);
        let skin: json::Skin = document.get(&document.root.skins, index, &skin_place, "skin")?;
        let bytes = (size_of::<Affine>() + size_of::<Joint>()) * skin.joints.len();
        document.work(bytes, &skin_place)?;
        document.hold(bytes, &skin_place)?;
        let inverse_binds = match skin.inverse_bind_matrices {
            Some(accessor) => super::accessor::floats::<16>(document, accessor, &skin_place, None)?,
            None => Vec::new(),
        };
        if !inverse_binds.is_empty() && inverse_binds.len() < skin.joints.len() {
            let problem = format!("{} matrices for {} joints", inverse_binds.len(), skin.joints.len());
            return Err(document.error(&skin_place, problem, "expected one for each"));
        }
        let mut at_rest = Vec::with_capacity(skin.joints.len());
        let mut joints = Vec::with_capacity(skin.joints.len());
        for (k, joint) in skin.joints.iter().enumerate() {
            let (attachment, world_from_joint) =
                self.joints.get(joint).copied().unwrap_or((NOWHERE, Affine::IDENTITY));
            let bind = inverse_binds.get(k).map(|m| Affine::from_column_major(&m.map(f64::from)));
            let is_finite = |m: &Affine| m.columns.as_flattened().iter().all(|x| x.is_finite());
            if bind.as_ref().is_some_and(|bind| !is_finite(bind)) {
                let detail = format!("{skin_place}: inverse bind matrix {k}");
                warnings.note(Oddity::BadAttribute, &document.path, None, detail);
            }
            let joint_from_mesh = bind.filter(is_finite).unwrap_or_default();
            at_rest.push(world_from_joint * joint_from_mesh);
            joints.push(Joint { attachment, joint_from_mesh });
        }
        let moves = joints.iter().any(|joint| matches!(joint.attachment, Attachment::On(_)));
        let stretches = at_rest.iter().any(stretches) || (moves && self.may_stretch());
        Ok((Skin { joints, stretches }, at_rest))
    }

    /// The animation's number of a skin.
    pub(super) fn add_skin(&mut self, index: Index, skin: &Skin) -> Result<u32, Error> {
        if let Some(&known) = self.skins.get(&index) {
            return Ok(known);
        }
        self.document.hold(size_of_val(&skin.joints[..]), "skins")?;
        let number = self.made.skins.len() as u32;
        self.made.skins.push(skin.clone());
        self.skins.insert(index, number);
        Ok(number)
    }

    /// The animation's number of a set of weights of `count` targets.
    pub(super) fn add_weights(&mut self, of: WeightsOf, rest: &[f32], count: usize) -> Result<u32, Error> {
        if let Some(&known) = self.weights.get(&of) {
            return Ok(known);
        }
        self.document.hold(size_of::<f32>() * count, "weights")?;
        let mut rest = rest.to_vec();
        rest.resize(count, 0.0);
        let number = self.made.weights.len() as u32;
        self.made.weights.push(rest);
        self.weights.insert(of, number);
        Ok(number)
    }

    /// The animation's number of a camera's angle.
    pub(super) fn add_angle(&mut self, camera: Index, rest: f32) -> u32 {
        let list = &mut self.made.fields_of_view;
        *self.angles.entry(camera).or_insert_with(|| {
            list.push(rest);
            list.len() as u32 - 1
        })
    }

    /// The animation's number of a light's factors.
    pub(super) fn add_light(&mut self, light: Index, rest: LightFactors) -> u32 {
        let list = &mut self.made.light_factors;
        *self.lights.entry(light).or_insert_with(|| {
            list.push(rest);
            list.len() as u32 - 1
        })
    }

    /// Gives the scene its animation, now that all is known.
    pub(super) fn finish(mut self, scene: &mut Scene, warnings: &mut Warnings) -> Result<(), Error> {
        let drafts = std::mem::take(&mut self.drafts).list;
        if drafts.is_empty() {
            return Ok(());
        }
        for (i, draft) in drafts.into_iter().enumerate() {
            let mut clip = Clip { name: draft.name, channels: Vec::with_capacity(draft.channels.len()) };
            for channel in draft.channels {
                match self.target(channel.aim, channel.sampler.width()) {
                    Ok(Some(target)) => clip.channels.push(Channel { target, sampler: channel.sampler }),
                    // A target that is not shown need not move.
                    Ok(None) => {}
                    Err(problem) => {
                        let detail = format!("animations[{i}].channels[{}]: {problem}", channel.number);
                        warnings.note(Oddity::BadAnimation, &self.document.path, None, detail);
                    }
                }
            }
            self.made.clips.push(clip);
        }
        let path = &self.document.path;
        scene.animate(self.made).map_err(|error| Error::data(path, None, error.to_string(), ""))
    }

    /// The target of a channel of `width` numbers; `None` if it is not shown; the error gives the fault.
    fn target(&self, aim: Aim, width: usize) -> Result<Option<Target>, String> {
        Ok(match aim {
            Aim::Node(index, part) => {
                let Some(&node) = self.nodes.get(&index) else { return Ok(None) };
                let is_matrix = matches!(self.made.nodes[node as usize].rest, Local::Matrix(_));
                if is_matrix && part != NodePart::Visible {
                    return Err(format!("nodes[{}] has a matrix, which cannot be driven by parts", index.0));
                }
                Some(match part {
                    NodePart::Translation => Target::Translation(node),
                    NodePart::Rotation => Target::Rotation(node),
                    NodePart::Scale => Target::Scale(node),
                    NodePart::Visible => Target::Visible(node),
                })
            }
            Aim::Weights(of, one) => {
                let Some(&set) = self.weights.get(&of) else { return Ok(None) };
                let count = self.made.weights[set as usize].len();
                match one {
                    None if width == count => Some(Target::Weights(set)),
                    None => return Err(format!("{width} weights for {count} morph targets")),
                    Some(k) if (k as usize) < count => Some(Target::Weight(set, k)),
                    Some(k) => return Err(format!("weight {k} of {count} morph targets")),
                }
            }
            Aim::FieldOfView(camera) => self.angles.get(&camera).map(|&n| Target::FieldOfView(n)),
            Aim::Light(light, part) => self.lights.get(&light).map(|&n| Target::Light(n, part)),
            Aim::Material(material, part) => {
                self.materials.get(&material).map(|&n| Target::Material(n, part))
            }
        })
    }
}

/// Where joints are that are not shown.
const NOWHERE: Attachment = Attachment::Fixed { world_from_node: Affine::IDENTITY, visible: true };

/// Where a node is on its parent, at rest.
pub(super) fn local(node: &json::Node) -> Local {
    if let Some(matrix) = &node.matrix {
        return Local::Matrix(Affine::from_column_major(&matrix.map(f64::from)));
    }
    Local::Parts(Trs {
        translation: node.translation.unwrap_or([0.0; 3]).map(f64::from),
        rotation: node.rotation.map(|q| q.map(f64::from)),
        scale: node.scale.unwrap_or([1.0; 3]).map(f64::from),
    })
}

/// The attachments of all joints are found once, before any deformation.
fn joints_of_all_skins(document: &Document<'_>) -> Result<HashMap<Index, (Attachment, Affine)>, Error> {
    let mut joints = HashMap::new();
    for k in 0..document.root.skins.len() {
        let attachment = format!("skins[{k}]");
        let skin: json::Skin = document.get(&document.root.skins, Index(k as u32), &attachment, "skin")?;
        for joint in skin.joints {
            if joint.value() >= document.root.nodes.len() {
                return Err(document.error(&attachment, format!("joint {} does not exist", joint.0), ""));
            }
            if joints.insert(joint, (NOWHERE, Affine::IDENTITY)).is_none() {
                // A table is up to half empty.
                document.hold(2 * size_of::<(Index, (Attachment, Affine))>(), &attachment)?;
            }
        }
    }
    Ok(joints)
}
