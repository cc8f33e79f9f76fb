// SPDX-License-Identifier: GPL-3.0-or-later
//! Volumes: a field seen through colours and opacities, along one ray.
//! Source: ANARI 1.1, KHR_VOLUME_TRANSFER_FUNCTION1D; emission and absorption alone. Only rays of the camera see volumes, and
//! before surfaces: they cast no shadow and are in no mirror. Space: world; marching is in the field's space.
//! Tests: tests/volumes.rs.

use std::sync::Arc;

use glam::Vec3;
use gnurt::scene::Affine;

use crate::attribute::Color;
use crate::ffi_array::Array;
use crate::field::Field;
use crate::object::{Object, Snapshot, Value};
use crate::transforms::{linear, point};
use crate::types;

/// Steps along a ray, at most.
const MOST_STEPS: f32 = 20_000.0;

/// Colours and opacities of a field's values.
pub(crate) struct Transfer {
    colors: Vec<Color>,
    opacities: Vec<f32>,
    range: [f32; 2],
    unit_distance: f32,
}

/// A volume in its place.
pub(crate) struct Volume {
    pub(crate) field: Arc<Field>,
    pub(crate) transfer: Arc<Transfer>,
    pub(crate) object_from_world: Affine,
    pub(crate) id: u32,
    pub(crate) instance: u32,
}

impl Transfer {
    /// That of a volume's object; an error in words where it means nothing.
    pub(crate) fn new(object: &Object) -> Result<Self, String> {
        let now = object.committed();
        let list = |name: &str| now.object(name, types::ARRAY1D).and_then(|array| Array::of(array)?.colors());
        let colors = list("color").filter(|list| !list.is_empty());
        let opacities = list("opacity").filter(|list| !list.is_empty());
        let unit_distance = now.f32("unitDistance").unwrap_or(1.0);
        if unit_distance <= 0.0 || unit_distance.is_nan() {
            return Err(format!(
                "parameter 'unitDistance': {unit_distance}: out of range; it must be above 0"
            ));
        }
        Ok(Self {
            colors: colors.unwrap_or_else(|| vec![now.color("color").unwrap_or([1.0; 4])]),
            opacities: opacities.map_or_else(
                || vec![now.f32("opacity").unwrap_or(1.0)],
                |list| list.into_iter().map(|value| value[0]).collect(),
            ),
            range: range(&now),
            unit_distance,
        })
    }

    /// Colour and opacity per unit distance of a value.
    fn of(&self, value: f32) -> (Vec3, f32) {
        let [low, high] = self.range;
        let fraction = ((value - low) / (high - low)).clamp(0.0, 1.0);
        let fraction = if fraction.is_finite() { fraction } else { 0.0 };
        let [r, g, b, a] = crate::attribute::between(&self.colors, fraction);
        let list = &self.opacities;
        let x = fraction * (list.len() - 1) as f32;
        let first = x as usize;
        let (from, to) = (list[first], list[(first + 1).min(list.len() - 1)]);
        (Vec3::new(r, g, b), ((from + (to - from) * (x - first as f32)) * a).clamp(0.0, 1.0))
    }
}

fn range(now: &Snapshot) -> [f32; 2] {
    if let Some(range) = now.floats("valueRange", &[types::FLOAT32_BOX1, types::FLOAT32_VEC2]) {
        return range;
    }
    let double = |k: usize| match now.get("valueRange") {
        Some(Value::Plain(types::FLOAT64_BOX1, bytes)) => {
            Some(f64::from_ne_bytes(bytes.get(8 * k..8 * k + 8)?.try_into().ok()?) as f32)
        }
        _ => None,
    };
    double(0).zip(double(1)).map_or([0.0, 1.0], |(low, high)| [low, high])
}

impl Volume {
    /// Where a ray enters and leaves it, in multiples of `dir`; `None` where it misses.
    pub(crate) fn span(&self, org: Vec3, dir: Vec3, far: f32) -> Option<[f32; 2]> {
        let (org, dir) = (point(&self.object_from_world, org), linear(&self.object_from_world) * dir);
        let [low, high] = self.field.bounds().map(Vec3::from);
        let (mut enter, mut leave) = (0.0_f32, far);
        for k in 0..3 {
            if dir[k] == 0.0 {
                if org[k] < low[k] || org[k] > high[k] {
                    return None;
                }
                continue;
            }
            let [a, b] = [low[k], high[k]].map(|plane| (plane - org[k]) / dir[k]);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        (enter < leave).then_some([enter, leave])
    }

    /// Light that comes from between two places of a ray, and the share of light from behind that it stops. `random` in [0, 1).
    pub(crate) fn march(&self, org: Vec3, dir: Vec3, [enter, leave]: [f32; 2], random: f32) -> (Vec3, f32) {
        let (org, dir) = (point(&self.object_from_world, org), linear(&self.object_from_world) * dir);
        let length = dir.length();
        let finest = self.field.spacing.iter().copied().fold(f32::INFINITY, f32::min) / 2.0;
        let way = (leave - enter) * length;
        let step = finest.max(way / MOST_STEPS);
        let count = (way / step).ceil().max(1.0);
        let step = way / count;
        let (mut light, mut left) = (Vec3::ZERO, 1.0_f32);
        for k in 0..count as u32 {
            let t = enter + (k as f32 + random) * step / length;
            let Some(value) = self.field.value((org + dir * t).to_array()).filter(|value| !value.is_nan())
            else {
                continue;
            };
            let (color, opacity) = self.transfer.of(value);
            let passes = (1.0 - opacity).powf(step / self.transfer.unit_distance);
            light += color * (left * (1.0 - passes));
            left *= passes;
            if left < 1e-3 {
                return (light, 1.0);
            }
        }
        (light, 1.0 - left)
    }
}
