// SPDX-License-Identifier: GPL-3.0-or-later
//! All kinds of objects, and the extensions that the device has. Tests: tests/introspection.rs.

use std::sync::LazyLock;

use super::entry::Entry;
use super::{geometries, lights, materials, scenes, views};
use crate::types::DataType;

/// The extensions, as queries name them, each ended by a zero byte. The device has all of each.
pub(crate) const EXTENSIONS: [&str; 49] = [
    "ANARI_KHR_ARRAY1D_REGION\0",
    "ANARI_KHR_CAMERA_DEPTH_OF_FIELD\0",
    "ANARI_KHR_CAMERA_MOTION_TRANSFORMATION\0",
    "ANARI_KHR_CAMERA_OMNIDIRECTIONAL\0",
    "ANARI_KHR_CAMERA_ORTHOGRAPHIC\0",
    "ANARI_KHR_CAMERA_PERSPECTIVE\0",
    "ANARI_KHR_CAMERA_SHUTTER\0",
    "ANARI_KHR_DEVICE_SYNCHRONIZATION\0",
    "ANARI_KHR_FRAME_ACCUMULATION\0",
    "ANARI_KHR_FRAME_CHANNEL_ALBEDO\0",
    "ANARI_KHR_FRAME_CHANNEL_INSTANCE_ID\0",
    "ANARI_KHR_FRAME_CHANNEL_NORMAL\0",
    "ANARI_KHR_FRAME_CHANNEL_OBJECT_ID\0",
    "ANARI_KHR_FRAME_CHANNEL_PRIMITIVE_ID\0",
    "ANARI_KHR_FRAME_COMPLETION_CALLBACK\0",
    "ANARI_KHR_GEOMETRY_CONE\0",
    "ANARI_KHR_GEOMETRY_CURVE\0",
    "ANARI_KHR_GEOMETRY_CYLINDER\0",
    "ANARI_KHR_GEOMETRY_ISOSURFACE\0",
    "ANARI_KHR_GEOMETRY_QUAD\0",
    "ANARI_KHR_GEOMETRY_SPHERE\0",
    "ANARI_KHR_GEOMETRY_TRIANGLE\0",
    "ANARI_KHR_INSTANCE_MOTION_SCALE_ROTATION_TRANSLATION\0",
    "ANARI_KHR_INSTANCE_MOTION_TRANSFORM\0",
    "ANARI_KHR_INSTANCE_TRANSFORM\0",
    "ANARI_KHR_INSTANCE_TRANSFORM_ARRAY\0",
    "ANARI_KHR_LIGHT_DIRECTIONAL\0",
    "ANARI_KHR_LIGHT_HDRI\0",
    "ANARI_KHR_LIGHT_POINT\0",
    "ANARI_KHR_LIGHT_PRIMARY_VISIBILITY\0",
    "ANARI_KHR_LIGHT_QUAD\0",
    "ANARI_KHR_LIGHT_RING\0",
    "ANARI_KHR_LIGHT_SPOT\0",
    "ANARI_KHR_MATERIAL_MATTE\0",
    "ANARI_KHR_MATERIAL_PHYSICALLY_BASED\0",
    "ANARI_KHR_RENDERER_AMBIENT_LIGHT\0",
    "ANARI_KHR_RENDERER_BACKGROUND_COLOR\0",
    "ANARI_KHR_RENDERER_BACKGROUND_IMAGE\0",
    "ANARI_KHR_RENDERER_DENOISE\0",
    "ANARI_KHR_SAMPLER_IMAGE1D\0",
    "ANARI_KHR_SAMPLER_IMAGE2D\0",
    "ANARI_KHR_SAMPLER_IMAGE3D\0",
    "ANARI_KHR_SAMPLER_IMAGExD_CLAMP_TO_BORDER\0",
    "ANARI_KHR_SAMPLER_PRIMITIVE\0",
    "ANARI_KHR_SAMPLER_TRANSFORM\0",
    "ANARI_KHR_SPATIAL_FIELD_NANOVDB\0",
    "ANARI_KHR_SPATIAL_FIELD_STRUCTURED_REGULAR\0",
    "ANARI_KHR_SPATIAL_FIELD_STRUCTURED_REGULAR_FILTER_CUBIC\0",
    "ANARI_KHR_VOLUME_TRANSFER_FUNCTION1D\0",
];

static ALL: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    [views::entries(), geometries::entries(), materials::entries(), lights::entries(), scenes::entries()]
        .concat()
});

/// The entry of a kind and a subtype.
pub(crate) fn find(kind: DataType, subtype: &str) -> Option<&'static Entry> {
    ALL.iter().find(|entry| entry.kind == kind && (entry.subtype == subtype || entry.subtype.is_empty()))
}

/// Subtypes of a kind; none for kinds that have no subtypes.
pub(crate) fn subtypes(kind: DataType) -> Vec<&'static str> {
    ALL.iter()
        .filter(|entry| entry.kind == kind && !entry.subtype.is_empty())
        .map(|entry| entry.subtype)
        .collect()
}

/// The place of an extension in the list, without `ANARI_`.
pub(crate) fn extension_number(name: &str) -> Option<i32> {
    let is_it = |full: &&str| full.trim_end_matches('\0').strip_prefix("ANARI_") == Some(name);
    EXTENSIONS.iter().position(is_it).map(|index| index as i32)
}
