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

#[test]
fn a_wrong_name_is_not_proposed_again() {
    // Formals of the library's functions, such as q of `distance`, do not hold in shaders.
    let drawn = messages("shader test() { float x = q; }", Style::Drawn);
    assert!(drawn.contains("'q' was not declared") && !drawn.contains("did you mean 'q'"), "{drawn}");
    let drawn =
        messages("float f(float inner) { return inner; } shader test() { float x = iner; }", Style::Drawn);
    assert!(!drawn.contains("did you mean"), "names of other functions: {drawn}");
}

#[test]
fn called_functions_need_a_body() {
    let drawn = messages("closure color my(normal n); surface test() { Ci = my(N) + my(Ng); }", Style::Drawn);
    assert!(drawn.contains("function 'my' is declared and called, but has no body"), "{drawn}");
    assert!(drawn.contains("[[ int builtin = 1 ]]") && drawn.matches("has no body").count() == 1, "{drawn}");
    let drawn = messages("float f(float x); shader test() { float y = f(u); }", Style::Drawn);
    assert!(drawn.contains("'f' is declared and called") && drawn.contains("in braces"), "{drawn}");
    for fine in [
        "closure color my(normal n) [[ int builtin = 1 ]]; surface test() { Ci = my(N); }",
        "float f(float x); shader test() { float y = f(u); } float f(float x) { return x; }",
        "float f(float x); shader test() { float y = u; }",
    ] {
        assert_eq!(messages(fine, Style::Drawn), "", "{fine}");
    }
    let drawn = messages("void f(float x); shader test() { f(u); }", Style::Drawn);
    assert!(drawn.contains("warning") && !drawn.contains("error"), "as OSL's compiler: {drawn}");
}
