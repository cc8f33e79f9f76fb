// SPDX-License-Identifier: GPL-3.0-or-later
//! Targets of animation channels, as the file names them.
//! Source: glTF 2.0 section 3.11; KHR_animation_pointer and the object model; KHR_node_visibility, KHR_lights_punctual,
//! KHR_texture_transform and the material extensions that are read. Tests: `tests`, `tests/animation.rs`.

use super::factor_paths::part_of;
use super::json::Index;
use gnurt_scene::animation::{FactorPart, LightPart};

/// The target of a channel; indices are the file's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Aim {
    Node(Index, NodePart),
    /// All morph weights, or one of them.
    Weights(WeightsOf, Option<u32>),
    FieldOfView(Index),
    Light(Index, LightPart),
    Material(Index, FactorPart),
}

/// Whose morph weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum WeightsOf {
    Node(Index),
    Mesh(Index),
}

/// Parts of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum NodePart {
    Translation,
    Rotation,
    Scale,
    Visible,
}

impl Aim {
    /// The target that `target.path` of a node names.
    pub(super) fn of_path(node: Index, path: &str) -> Option<Self> {
        Some(match path {
            "translation" => Self::Node(node, NodePart::Translation),
            "rotation" => Self::Node(node, NodePart::Rotation),
            "scale" => Self::Node(node, NodePart::Scale),
            "weights" => Self::Weights(WeightsOf::Node(node), None),
            _ => return None,
        })
    }

    /// The target that a pointer names, if this program supports the value.
    pub(super) fn of_pointer(pointer: &str) -> Option<Self> {
        let parts: Vec<&str> = pointer.strip_prefix('/')?.split('/').take(10).collect();
        let index = |text: &str| text.parse().ok().map(Index);
        Some(match parts[..] {
            ["nodes", n, "extensions", "KHR_node_visibility", "visible"] => {
                Self::Node(index(n)?, NodePart::Visible)
            }
            ["nodes", n, "weights", k] => Self::Weights(WeightsOf::Node(index(n)?), Some(index(k)?.0)),
            ["nodes", n, path] => return Self::of_path(index(n)?, path),
            ["meshes", n, "weights"] => Self::Weights(WeightsOf::Mesh(index(n)?), None),
            ["meshes", n, "weights", k] => Self::Weights(WeightsOf::Mesh(index(n)?), Some(index(k)?.0)),
            ["cameras", n, "perspective", "yfov"] => Self::FieldOfView(index(n)?),
            ["extensions", "KHR_lights_punctual", "lights", n, ref part @ ..] => {
                let part = match part {
                    ["color"] => LightPart::Color,
                    ["intensity"] => LightPart::Intensity,
                    ["spot", "innerConeAngle"] => LightPart::InnerAngle,
                    ["spot", "outerConeAngle"] => LightPart::OuterAngle,
                    _ => return None,
                };
                Self::Light(index(n)?, part)
            }
            ["materials", n, ref part @ ..] => Self::Material(index(n)?, part_of(&part.join("/"))?),
            _ => return None,
        })
    }

    /// Numbers of its value; `None` where that is the mesh's business.
    pub(super) fn width(self) -> Option<usize> {
        Some(match self {
            Self::Node(_, NodePart::Translation | NodePart::Scale) => 3,
            Self::Node(_, NodePart::Rotation) => 4,
            Self::Node(_, NodePart::Visible) | Self::FieldOfView(_) | Self::Weights(_, Some(_)) => 1,
            Self::Weights(_, None) => return None,
            Self::Light(_, part) => part.width(),
            Self::Material(_, part) => part.width(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt_scene::animation::TexturePart;

    #[test]
    fn pointers_name_values() {
        let aim = Aim::of_pointer;
        assert_eq!(aim("/nodes/3/rotation"), Some(Aim::Node(Index(3), NodePart::Rotation)), "a node");
        let transform =
            "/materials/1/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/offset";
        let offset = FactorPart::BaseTexture(TexturePart::Offset);
        assert_eq!(aim(transform), Some(Aim::Material(Index(1), offset)), "a texture's transform");
        let cone = "/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle";
        assert_eq!(aim(cone), Some(Aim::Light(Index(0), LightPart::OuterAngle)), "a cone");
        assert_eq!(aim("/meshes/2/weights/5"), Some(Aim::Weights(WeightsOf::Mesh(Index(2)), Some(5))), "one");
        for nothing in
            ["", "/", "nodes/3/rotation", "/nodes/x/rotation", "/nodes/-1/scale", "/materials/0/doubleSided"]
        {
            assert_eq!(aim(nothing), None, "{nothing}");
        }
    }
}
