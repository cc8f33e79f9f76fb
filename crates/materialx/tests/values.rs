// SPDX-License-Identifier: GPL-3.0-or-later
//! Values of nodes against closed forms. `tests/judge` compares them with those of MaterialX's own generator.

use crate::made::{generated, value};

fn near(elements: &str, expected: f32) {
    let found = value(elements, "n");
    assert!(
        (found - expected).abs() < 1e-5 * expected.abs().max(1.0),
        "{elements}: {found} is not {expected}"
    );
}

/// A node of floats.
fn node(category: &str, inputs: &[(&str, f32)]) -> String {
    let inputs: String = inputs
        .iter()
        .map(|(name, value)| format!("<input name=\"{name}\" type=\"float\" value=\"{value}\"/>"))
        .collect();
    format!("<{category} name=\"n\" type=\"float\">{inputs}</{category}>")
}

#[test]
fn arithmetic_is_as_specified() {
    let two = |a: f32, b: f32| [("in1", a), ("in2", b)];
    near(&node("add", &two(1.5, -4.0)), -2.5);
    near(&node("modulo", &two(-1.25, 1.0)), 0.75);
    near(&node("power", &two(2.0, 3.5)), 2.0_f32.powf(3.5));
    near(&node("invert", &[("in", 0.2)]), 0.8);
    near(&node("invert", &[("in", 0.2), ("amount", 2.0)]), 1.8);
    near(&node("clamp", &[("in", 3.0), ("low", -1.0), ("high", 2.0)]), 2.0);
    near(&node("remap", &[("in", 0.25), ("outlow", 2.0), ("outhigh", 6.0)]), 3.0);
    near(&node("smoothstep", &[("in", 0.25)]), 0.156_25);
    near(&node("atan2", &[("iny", 1.0), ("inx", -1.0)]), 1.0_f32.atan2(-1.0));
    near(&node("ifgreater", &[("value1", 2.0), ("value2", 1.0), ("in1", 7.0), ("in2", 9.0)]), 7.0);
    near(&node("switch", &[("in1", 1.0), ("in3", 8.0), ("which", 2.5)]), 8.0);
    near(&node("screen", &[("fg", 0.5), ("bg", 0.2), ("mix", 1.0)]), 0.6);
    near(&node("burn", &[("fg", 0.5), ("bg", 0.8), ("mix", 1.0)]), 0.6);
}

#[test]
fn units_are_converted() {
    let turned = |unit: &str| {
        format!(
            "<rotate2d name=\"r\" type=\"vector2\"><input name=\"in\" type=\"vector2\" value=\"1, 0\"/>\
             <input name=\"amount\" type=\"float\" value=\"0.5\" unit=\"{unit}\" unittype=\"angle\"/></rotate2d>\
             <extract name=\"n\" type=\"float\"><input name=\"in\" type=\"vector2\" nodename=\"r\"/></extract>"
        )
    };
    near(&turned("radian"), 0.5_f32.cos());
    near(&turned("degree"), 0.5_f32.to_radians().cos());
    let length = "<constant name=\"n\" type=\"float\"><input name=\"value\" type=\"float\" value=\"3\" unit=\"inch\" \
                  unittype=\"distance\"/></constant>";
    near(length, 3.0 * 0.0254);
    let why = generated(&length.replace("inch", "ell"), None).expect_err("no unit");
    assert!(why.contains("unknown unit 'ell'") && why.contains("t.mtlx:3"), "{why}");
}

#[test]
fn colours_are_made_linear() {
    let red = "<constant name=\"c\" type=\"color3\"><input name=\"value\" type=\"color3\" value=\"0.5, 0, 0\" \
               colorspace=\"srgb_texture\"/></constant>\
               <extract name=\"n\" type=\"float\"><input name=\"in\" type=\"color3\" nodename=\"c\"/></extract>";
    near(red, ((0.5_f32 + 0.055) / 1.055).powf(2.4));
    near(&red.replace("srgb_texture", "lin_rec709"), 0.5);
    let why = generated(&red.replace("srgb_texture", "mauve"), Some("n")).expect_err("no space");
    assert!(why.contains("unknown colour space 'mauve'"), "{why}");
}
