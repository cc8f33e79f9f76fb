// SPDX-License-Identifier: GPL-3.0-or-later
//! Messages: fault, place and remedy.

use crate::common::messages;
use gnurt_sl::diagnostics::Style;

#[test]
fn a_message_shows_place_line_and_help() {
    let text = "shader test()\n{\n    color Cd = 1;\n    float x = Cd.y + roughnes;\n}\n";
    let drawn = messages(text, Style::Drawn);
    assert!(drawn.contains("test.osl:4:17"), "file, line and column: {drawn}");
    assert!(drawn.contains("float x = Cd.y + roughnes;"), "the source line: {drawn}");
    assert!(drawn.contains("its members are .r, .g, .b"), "what would be right: {drawn}");
    let strict = messages(text, Style::Strict);
    let lines: Vec<&str> = strict.lines().collect();
    assert_eq!(
        lines,
        [
            "test.osl:4: error: type 'color' does not have a member 'y'",
            "test.osl:4: error: 'roughnes' was not declared in this scope"
        ],
        "OSL's words"
    );
    let json = messages(text, Style::Json);
    assert!(
        json.starts_with("{\"severity\":\"error\",\"file\":\"test.osl\",\"line\":4,\"column\":17,"),
        "{json}"
    );
}

#[test]
fn a_wrong_name_is_compared_with_known_ones() {
    let drawn =
        messages("shader test() { float distnce = 1; float y = distnc; float z = lenght(P); }", Style::Drawn);
    assert!(drawn.contains("did you mean 'distnce'?") && drawn.contains("did you mean 'length'?"), "{drawn}");
}

#[test]
fn a_syntax_error_says_what_was_wanted() {
    let drawn = messages("shader test() { float x = 1 }", Style::Drawn);
    assert!(drawn.contains("expected ';', found '}'"), "{drawn}");
    let drawn = messages("shader test() { const float x = 1; }", Style::Drawn);
    assert!(drawn.contains("'const' is a reserved word"), "{drawn}");
}

#[test]
fn functions_cannot_call_themselves() {
    let strict = messages(
        "float f(float x); float g(float x) { return f(x); } float f(float x) { return g(x); } shader test() { float y = f(u); }",
        Style::Strict,
    );
    assert!(strict.contains("cannot be recursive"), "{strict}");
}
