// SPDX-License-Identifier: GPL-3.0-or-later
//! The table of closures has the declarations of `stdosl.h`.

use gnurt_sl::exec::standard_closures;

/// Declarations without a body: `name (type name, ...)`.
fn declared() -> Vec<String> {
    let text = include_str!("../include/stdosl.h");
    let statements = text.split("closure color ").skip(1);
    let with_body = |text: &str| text.find('{').unwrap_or(usize::MAX) < text.find(';').unwrap_or(0);
    let one_spaced = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let mut found = Vec::new();
    for statement in statements.filter(|text| !with_body(text)) {
        let Some((declaration, _)) = statement.split_once(" LIB;") else { continue };
        found.push(one_spaced(declaration).replacen('(', " (", 1));
    }
    found
}

#[test]
fn standard_closures_are_those_of_the_library() {
    let ours: Vec<String> = standard_closures()
        .iter()
        .map(|decl| {
            let text = decl.to_string();
            let plain = text.split(", \"").next().unwrap_or_default();
            if plain.len() < text.len() { format!("{plain})") } else { text.clone() }
        })
        .collect();
    // A parameter that is a closure ends a part of `layer`.
    let mut library: Vec<String> = declared().into_iter().filter(|text| !text.starts_with("base")).collect();
    library.push("layer (closure color top, closure color base)".to_owned());
    assert!(library.len() > 30, "{library:?}");
    for text in &ours {
        assert!(library.contains(text), "{text} is not in stdosl.h: {library:#?}");
    }
    for text in library.iter().filter(|text| text.contains('(')) {
        assert!(ours.contains(text), "{text} is in stdosl.h only");
    }
}

#[test]
fn keywords_are_printed_in_quotes() {
    let sheen = standard_closures().iter().find(|decl| &*decl.name == "sheen_bsdf").expect("it is there");
    assert_eq!(sheen.to_string(), "sheen_bsdf (normal N, color albedo, float roughness, \"mode\" int)");
}
