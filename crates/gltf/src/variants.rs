// SPDX-License-Identifier: GPL-3.0-or-later
//! Variants of a model: other materials for its primitives, chosen by name.
//! Source: KHR_materials_variants. Without a choice each primitive has its own material. Tests:
//! `tests/extensions.rs::variants_choose_materials`.

use super::json::{Index, Primitive, Root};
use gnurt_scene::io::VariantChoice;
use gnurt_scene::io::reader::quoted;

/// Names in a message.
const MOST_NAMES: usize = 20;

/// The number of the chosen variant; the error gives fault and remedy. The last choice counts.
pub(super) fn chosen(root: &Root<'_>, choices: &[VariantChoice]) -> Result<Option<u32>, (String, String)> {
    let Some(choice) = choices.last() else { return Ok(None) };
    if !choice.prim.is_empty() {
        let whole = format!("{}:{}={}", choice.prim, choice.set, choice.variant);
        return Err((format!("variant {}", quoted(&whole)), "glTF has variants by name: NAME".into()));
    }
    let named = root.extensions.variants.as_ref().map_or(&[][..], |variants| &variants.variants);
    match named.iter().position(|variant| *variant.name == *choice.variant) {
        Some(number) => Ok(Some(number as u32)),
        None if named.is_empty() => {
            Err((format!("unknown variant {}", quoted(&choice.variant)), "the file has no variants".into()))
        }
        None => {
            let names: Vec<_> = named.iter().take(MOST_NAMES).map(|variant| quoted(&variant.name)).collect();
            let more = if named.len() > MOST_NAMES { " and others" } else { "" };
            let remedy = format!("valid are {}{more}", names.join(", "));
            Err((format!("unknown variant {}", quoted(&choice.variant)), remedy))
        }
    }
}

/// The material of a primitive in the chosen variant.
pub(super) fn material_of(primitive: &Primitive, chosen: Option<u32>) -> Option<Index> {
    let mappings = primitive.extensions.variants.as_ref();
    let is_chosen = |variants: &[Index]| variants.iter().any(|variant| Some(variant.0) == chosen);
    let mapped = mappings.and_then(|all| all.mappings.iter().find(|mapping| is_chosen(&mapping.variants)));
    mapped.map_or(primitive.material, |mapping| Some(mapping.material))
}
