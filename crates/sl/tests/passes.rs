// SPDX-License-Identifier: GPL-3.0-or-later
//! Passes: their results, and the unchanged meaning of the shader.

use crate::common::{diagnostics_of, shader};
use gnurt_sl::group::{Group, parse_value};
use gnurt_sl::ir::{Shader, SymbolKind, ops};
use gnurt_sl::passes::fold;
use std::collections::HashMap;
use std::sync::Arc;

fn names(shader: &Shader) -> Vec<String> {
    let mut out = Vec::new();
    ops(&shader.code, &mut |op| out.push(op.code.name().to_string()));
    out
}

#[test]
fn a_branch_that_a_parameter_closes_is_left_out() {
    let text = r#"shader test(int k = 0, string s = "a") { if (k == 1 && s != "") printf("one"); else printf("other"); }"#;
    let mut folded = shader(text);
    let known: HashMap<_, _> =
        folded.params().filter_map(|(id, s)| s.value.clone().map(|v| (id, v))).collect();
    fold(&mut folded, &known);
    assert_eq!(names(&folded), ["printf"], "one print is left");
    for (value, expected) in [("1", "one"), ("0", "other")] {
        let mut group = Group::default();
        let values = [("k".to_owned(), parse_value(None, value), Default::default())];
        group.add(Arc::new(shader(text)), None, &values, &mut Vec::new());
        assert_eq!(diagnostics_of(&group), [gnurt_sl::exec::Event::Print(expected.into())], "k = {value}");
    }
}

#[test]
fn derivatives_are_kept_where_they_are_asked_for() {
    let shader = shader(
        "shader test() { float a = u * 2; float b = v * 2; float c = a + 1; printf(\"%g %g\", Dx(c), b); }",
    );
    let derivs = |name: &str| shader.symbol(shader.find(name).expect("it is there")).derivs;
    assert_eq!([derivs("a"), derivs("b"), derivs("c")], [true, false, true], "what c is made of");
}

/// A counter of the compiler's own begins with a constant, and is another in the next round.
#[test]
fn counters_are_no_constants() {
    let text = "shader test() { for (int i = 0; i < 3; i++) printf(\"%d\", i); }";
    let mut folded = shader(text);
    let is_local = |symbol: &&mut gnurt_sl::ir::Symbol| symbol.kind == SymbolKind::Local;
    folded.symbols.iter_mut().filter(is_local).for_each(|counter| counter.kind = SymbolKind::Temp);
    fold(&mut folded, &HashMap::new());
    let mut group = Group::default();
    group.add(Arc::new(folded), None, &[], &mut Vec::new());
    let expected = ["0", "1", "2"].map(|text| gnurt_sl::exec::Event::Print(text.into()));
    assert!(diagnostics_of(&group) == expected, "the loop ends after three rounds");
}

#[test]
fn closures_are_not_weighed_with_nothing_or_one() {
    let mut folded = shader(
        "surface test() { float w = 0; float a = 1 - w; closure color c = w * emission(), d = a * diffuse(N);
         Ci = (1 - a) * c + a * d + 0 * translucent(N); }",
    );
    fold(&mut folded, &HashMap::new());
    assert!(!names(&folded).iter().any(|name| name == "mul" || name == "add"), "{:?}", names(&folded));
}
