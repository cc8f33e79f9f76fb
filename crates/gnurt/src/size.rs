// SPDX-License-Identifier: GPL-3.0-or-later
//! Sizes for people. Tests: `tests`.

/// A size for people: `1.5 GiB`.
#[must_use]
pub fn format_bytes(count: u64) -> String {
    let (mut size, mut unit) = (count as f64, "B");
    for larger in ["KiB", "MiB", "GiB", "TiB"] {
        if size < 1024.0 {
            break;
        }
        (size, unit) = (size / 1024.0, larger);
    }
    if unit == "B" { format!("{count} B") } else { format!("{size:.1} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_for_people() {
        assert_eq!(format_bytes(17), "17 B", "few");
        assert_eq!(format_bytes(1536), "1.5 KiB", "more");
        assert_eq!(format_bytes(3 << 30), "3.0 GiB", "many");
    }
}
