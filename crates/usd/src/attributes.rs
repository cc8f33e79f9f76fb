// SPDX-License-Identifier: GPL-3.0-or-later
//! Values over a mesh: one for all, per face, per point or per corner, named directly or by indices.
//! Source: UsdGeomPrimvar. Invariant: every element that a corner has is there. Tests: `tests/meshes.rs`.

use gnurt_scene::io::Oddity;
use gnurt_scene::subdivision::{Channel, Faces, Refined};
use openusd::sdf::Path;

use crate::reader::Reader;
use crate::value;

/// Which element each place of the mesh has.
#[derive(Clone, Debug)]
pub(crate) enum Spread {
    Constant,
    Faces(Elements),
    /// By point, and whether they are interpolated linearly in subdivision.
    Points(Elements, bool),
    Corners(Elements),
}

/// Elements by faces, points or corners.
#[derive(Clone, Debug)]
pub(crate) enum Elements {
    /// As many in their order.
    InOrder(usize),
    Listed(Vec<u32>),
}

impl Elements {
    fn get(&self, place: usize) -> u32 {
        match self {
            Self::InOrder(_) => place as u32,
            Self::Listed(all) => all[place],
        }
    }

    fn len(&self) -> usize {
        match self {
            Self::InOrder(count) => *count,
            Self::Listed(all) => all.len(),
        }
    }

    fn to_list(&self) -> Vec<u32> {
        (0..self.len()).map(|place| self.get(place)).collect()
    }
}

/// Values over a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Attribute {
    pub(crate) width: usize,
    pub(crate) values: Vec<f32>,
    pub(crate) spread: Spread,
}

impl Attribute {
    /// The element of a corner.
    pub(crate) fn element(&self, face: usize, corner: usize, point: u32) -> u32 {
        match &self.spread {
            Spread::Constant => 0,
            Spread::Faces(elements) => elements.get(face),
            Spread::Points(elements, _) => elements.get(point as usize),
            Spread::Corners(elements) => elements.get(corner),
        }
    }

    /// An element of `N` numbers; missing ones are those of `fill`.
    pub(crate) fn get<const N: usize>(&self, element: u32, fill: [f32; N]) -> [f32; N] {
        let at = element as usize * self.width;
        std::array::from_fn(|k| if k < self.width { self.values[at + k] } else { fill[k] })
    }

    /// Whether every corner of a point has the same element.
    pub(crate) fn is_of_points(&self) -> bool {
        matches!(self.spread, Spread::Constant | Spread::Points(..))
    }

    /// As something to be refined; `None` where refinement leaves the values as they are.
    pub(crate) fn channel(&self) -> Option<Channel> {
        let (width, values) = (self.width, &self.values);
        match &self.spread {
            Spread::Constant | Spread::Faces(_) => None,
            Spread::Points(elements, is_linear) => {
                let of = |place: usize| &values[elements.get(place) as usize * width..][..width];
                let values = (0..elements.len()).flat_map(of).copied().collect();
                Some(Channel { width, values, corners: None, is_linear: *is_linear })
            }
            Spread::Corners(elements) => Some(Channel {
                width,
                values: values.clone(),
                corners: Some(elements.to_list()),
                is_linear: false,
            }),
        }
    }

    /// The same values over the refined mesh; `channel` is the refined [`channel`](Self::channel).
    pub(crate) fn refined(self, refined: &Refined, channel: Option<Channel>) -> Self {
        let width = self.width;
        match (self.spread, channel) {
            (Spread::Faces(elements), _) => {
                let parents = refined.parents.iter();
                let elements = parents.map(|&parent| elements.get(parent as usize)).collect();
                Self { width, values: self.values, spread: Spread::Faces(Elements::Listed(elements)) }
            }
            (Spread::Points(_, is_linear), Some(channel)) => {
                let elements = Elements::InOrder(channel.values.len() / width.max(1));
                Self { width, values: channel.values, spread: Spread::Points(elements, is_linear) }
            }
            (Spread::Corners(_), Some(channel)) => {
                let corners = Elements::Listed(channel.corners.unwrap_or_default());
                Self { width, values: channel.values, spread: Spread::Corners(corners) }
            }
            (spread, _) => Self { width, values: self.values, spread },
        }
    }
}

impl Reader {
    /// A primvar or another attribute of a mesh that has values over it. `widths`: how many numbers an element may have.
    /// Values that do not fit the mesh are ignored with a warning.
    pub(crate) fn attribute(
        &self,
        prim: &Path,
        name: &str,
        faces: &Faces,
        widths: std::ops::RangeInclusive<usize>,
        fallback: &str,
    ) -> Option<Attribute> {
        let [found, indices] = self.values(prim, [name, &format!("{name}:indices")]);
        let found = found?;
        let (width, values) = value::into_floats(found).filter(|(width, _)| widths.contains(width))?;
        let interpolation = self.metadata(prim, name, "interpolation").as_ref().and_then(value::word);
        let interpolation = interpolation.unwrap_or_else(|| fallback.to_owned());
        let places = match &interpolation[..] {
            "constant" => 1,
            "uniform" => faces.len(),
            "vertex" | "varying" => faces.vertices(),
            "faceVarying" => faces.corners().len(),
            other => {
                self.note(
                    Oddity::BadAttribute,
                    prim,
                    format_args!("{name} has the unknown interpolation '{other}'"),
                );
                return None;
            }
        };
        let count = values.len() / width;
        let elements = match indices.and_then(value::into_integers) {
            Some(indices) => {
                let index = |index: i32| u32::try_from(index).unwrap_or(u32::MAX);
                Elements::Listed(indices.into_iter().map(index).collect())
            }
            None => Elements::InOrder(count),
        };
        let in_range = match &elements {
            Elements::InOrder(_) => true,
            Elements::Listed(all) => all.iter().all(|&element| (element as usize) < count),
        };
        // One value too many does no harm where one is meant for all.
        let fits = elements.len() == places || interpolation == "constant" && elements.len() > 0;
        if !fits || !in_range {
            let fault =
                format!("{name} ({interpolation}) has {} values, the mesh needs {places}", elements.len());
            let fault = if fits { format!("{name} has indices out of range") } else { fault };
            self.note(Oddity::BadAttribute, prim, fault);
            return None;
        }
        let spread = match &interpolation[..] {
            "constant" if elements.get(0) == 0 => Spread::Constant,
            "constant" => Spread::Faces(Elements::Listed(vec![elements.get(0); faces.len()])),
            "uniform" => Spread::Faces(elements),
            "faceVarying" => Spread::Corners(elements),
            other => Spread::Points(elements, other == "varying"),
        };
        Some(Attribute { width, values, spread })
    }
}
