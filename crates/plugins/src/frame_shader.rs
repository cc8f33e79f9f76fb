// SPDX-License-Identifier: GPL-3.0-or-later
//! A plugin's shader in one frame: its copy of the block, its inputs, and the positions of its parameters in
//! a batch.
//! Tests: bindings/openrt/tests/plugins.rs.

use std::sync::Arc;

use gnurt::shading::AttributeRequest;
use gnurt::shading::classes::ParameterRate;

use crate::class::PluginClass;
use crate::ffi_block::Snapshot;
use crate::frame_state::{Faults, FrameState};

/// The data of a shader's callbacks, and of the host's functions for them.
pub(crate) struct FrameShader {
    pub(crate) snapshot: Snapshot,
    pub(crate) frame: Arc<FrameState>,
    pub(crate) faults: Arc<Faults>,
    /// The attribute of each parameter that varies, by the parameter's number.
    attribute_of: Vec<Option<usize>>,
}

impl FrameShader {
    pub(crate) fn new(snapshot: Snapshot, frame: &Arc<FrameState>, faults: Arc<Faults>) -> Self {
        let mut indices = 0..;
        let parameters = snapshot.block.class().parameters.iter();
        let varies = parameters.map(|p| p.description.rate != ParameterRate::Shader);
        let attribute_of = varies.map(|varies| if varies { indices.next() } else { None }).collect();
        Self { snapshot, frame: frame.clone(), faults, attribute_of }
    }

    /// Its class.
    pub(crate) fn class(&self) -> &Arc<PluginClass> {
        self.snapshot.block.class()
    }

    /// Its requests to meshes: one attribute per varying parameter, in the order of the parameters.
    pub(crate) fn varying(&self) -> Vec<AttributeRequest> {
        let varying = self.class().parameters.iter().map(|p| &p.description);
        let varying = varying.filter(|p| p.rate != ParameterRate::Shader);
        varying
            .map(|p| (p.name.clone(), p.count as u32, p.default.clone()))
            .map(|(name, components, default)| AttributeRequest { name, components, default })
            .collect()
    }

    /// Where the attribute of a parameter that varies is among those of a batch.
    pub(crate) fn attribute(&self, parameter: usize) -> Option<usize> {
        self.attribute_of.get(parameter).copied().flatten()
    }
}
