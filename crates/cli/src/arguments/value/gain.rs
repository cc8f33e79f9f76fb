// SPDX-License-Identifier: GPL-3.0-or-later
//! The gain of a light group. Tests: `tests`.

use gnurt::relight::Gain;

/// `NAME=NUMBER` or `NAME=R,G,B`; numbers of at least 0.
pub(crate) fn gain(text: &str) -> Result<Gain, String> {
    let form = || "give a group and its gain, such as key=2 or sky=1,0.8,0.6".to_owned();
    let (group, value) = text.rsplit_once('=').filter(|(group, _)| !group.is_empty()).ok_or_else(form)?;
    let number = |text: &str| text.trim().parse::<f32>().ok().filter(|gain| gain.is_finite() && *gain >= 0.0);
    let numbers: Option<Vec<f32>> = value.split(',').map(number).collect();
    let color = match numbers.as_deref() {
        Some(&[all]) => [all; 3],
        Some(&[r, g, b]) => [r, g, b],
        _ => return Err(form()),
    };
    Ok(Gain { group: group.into(), color })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_numbers() {
        assert_eq!(gain("key=2"), Ok(Gain { group: "key".into(), color: [2.0; 3] }), "one");
        assert_eq!(gain("a=b=1,0.5,0"), Ok(Gain { group: "a=b".into(), color: [1.0, 0.5, 0.0] }), "three");
        for bad in ["key", "=1", "key=", "key=1,2", "key=-1", "key=nan", "key=x"] {
            assert!(gain(bad).is_err(), "{bad}");
        }
    }
}
