// SPDX-License-Identifier: GPL-3.0-or-later
//! The clip that `--animation` names. Tests: `tests/program/animation.rs`.

use gnurt::scene::{Animation, Scene};

use crate::failure::Failure;
use crate::nearest::nearest;

/// The index of the requested clip; `None` where the scene has none and none was named.
pub(crate) fn clip(scene: &Scene, name: Option<&str>) -> Result<Option<usize>, Failure> {
    let clips = scene.animation().map_or(&[][..], |animation: &Animation| &animation.clips);
    let Some(name) = name else {
        return Ok((!clips.is_empty()).then_some(0));
    };
    let by_name = clips.iter().position(|clip| clip.name == name);
    let by_number = || name.parse().ok().filter(|&index: &usize| index < clips.len());
    if let Some(clip) = by_name.or_else(by_number) {
        return Ok(Some(clip));
    }
    if clips.is_empty() {
        return Err(Failure::usage(format_args!("--animation '{name}': the scene has no animation")));
    }
    let names: Vec<&str> = clips.iter().map(|clip| &clip.name[..]).collect();
    let meant = nearest(name, &names).map(|meant| format!("did you mean '{meant}'? ")).unwrap_or_default();
    let list: Vec<String> = names.iter().enumerate().map(|(i, name)| format!("{i} '{name}'")).collect();
    let list = list.join(", ");
    Err(Failure::usage(format_args!("--animation '{name}': no such animation; {meant}valid are: {list}")))
}
