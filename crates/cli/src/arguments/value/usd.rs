// SPDX-License-Identifier: GPL-3.0-or-later
//! Choices of what of a scene is loaded. Tests: `tests`.

use gnurt::scene::io::{UpAxis, VariantChoice};

/// `/World/Chair:fabric=red`, or the name of a variant of the whole file.
pub(crate) fn variant(text: &str) -> Result<VariantChoice, String> {
    const FORM: &str = "expected NAME (glTF) or /PRIM:SET=NAME (USD), such as /World/Chair:fabric=red";
    if !text.starts_with('/') {
        return match text.is_empty() {
            true => Err(FORM.into()),
            false => Ok(VariantChoice { prim: String::new(), set: String::new(), variant: text.into() }),
        };
    }
    let (prim, choice) = text.split_once(':').ok_or(FORM)?;
    let (set, variant) = choice.split_once('=').ok_or(FORM)?;
    if prim.len() < 2 || set.is_empty() || variant.is_empty() {
        return Err(FORM.into());
    }
    Ok(VariantChoice { prim: prim.into(), set: set.into(), variant: variant.into() })
}

/// `x`, `y` or `z`.
pub(crate) fn up_axis(text: &str) -> Result<UpAxis, String> {
    match text.to_ascii_lowercase().as_str() {
        "x" => Ok(UpAxis::X),
        "y" => Ok(UpAxis::Y),
        "z" => Ok(UpAxis::Z),
        _ => Err("expected x, y or z".into()),
    }
}

/// From 0 to 6.
pub(crate) fn subdivision(text: &str) -> Result<u32, String> {
    text.parse().ok().filter(|&level| level <= 6).ok_or_else(|| "expected a whole number from 0 to 6".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variants_have_three_names() {
        let choice = variant("/World/Chair:fabric=red").expect("a choice");
        assert_eq!(
            (&choice.prim[..], &choice.set[..], &choice.variant[..]),
            ("/World/Chair", "fabric", "red")
        );
        let plain = variant("World:a=b").expect("a name");
        assert_eq!((&plain.prim[..], &plain.variant[..]), ("", "World:a=b"), "of glTF");
        for bad in ["", "/World", "/World:a", "/:a=b", "/W:=b", "/W:a="] {
            assert!(variant(bad).is_err(), "'{bad}' is no choice");
        }
        assert!(
            subdivision("6").is_ok() && subdivision("7").is_err() && subdivision("-1").is_err(),
            "levels"
        );
    }
}
