// SPDX-License-Identifier: GPL-3.0-or-later
//! Meaning of programs: each prints a result that the specification, or arithmetic, defines.

#[path = "meaning/clouds.rs"]
mod clouds;
#[path = "meaning/more.rs"]
mod more;
#[path = "meaning/unwritten.rs"]
mod unwritten;
use crate::common::{body, diagnostics_of, messages, output, shader};
use gnurt_sl::diagnostics::Style;
use gnurt_sl::exec::Event;
use gnurt_sl::group::{Group, read_group, write_group};
use std::sync::Arc;

#[test]
fn arithmetic_does_not_trap() {
    let out = body(
        r#"int z = 0; float f = 0; printf("%d %d %g %g %d", 7 / z, 7 % z, 1.0 / f, sqrt(-1.0), 2147483647 + 1);"#,
    );
    assert_eq!(
        out, "0 0 0 0 -2147483648",
        "division by zero is zero, roots of negative numbers are, ints wrap"
    );
}

#[test]
fn operators_bind_as_in_c() {
    let out = body(
        r#"int a = 2; printf("%d %d %d %d", 1 + 2 * 3 - 4, 1 << 2 + 1, a == 2 && 0 || 1, a > 1 ? 10 : 20);"#,
    );
    assert_eq!(out, "3 8 1 10", "the order of C");
}

#[test]
fn files_are_as_people_write_them() {
    // The compiler has brought the header; two commas are one; a backslash hides a line's end, of either kind, also in a text.
    let text = "#include \"stdosl.h\"\n#include <shaders/stdosl.h>\nshader test(float a = 1 [[ string help = \"b\\\r\n c\" ]],, string s = \"x\\\ny\",)\r\n{ printf(\"%s\\\n%g\", \\\r\n s, a); error(\"\"); }";
    assert_eq!(output(text), "xy1ERROR Shader error [test]: \n", "{text}");
    let line = messages("shader test(string s = \"x\\\ny\") { q = 1; }", Style::Strict);
    assert!(line.starts_with("test.osl:2: error"), "{line}");
}

#[test]
fn logic_works_out_only_what_it_needs() {
    let out = output(
        r#"int say(int x) { printf("%d;", x); return x; }
           shader test() { int a = say(0) && say(1); int b = say(2) || say(3); printf("%d %d", a, b); }"#,
    );
    assert_eq!(out, "0;2;0 1", "the right side only where the left does not decide");
}

#[test]
fn loops_leave_and_go_on() {
    let out = body(
        r#"for (int i = 0; i < 10; ++i) { if (i == 2) continue; if (i == 5) break; printf("%d ", i); }
           int k = 0; do { k += 3; } while (k < 1); while (k > 0) k--; printf("%d", k);"#,
    );
    assert_eq!(out, "0 1 3 4 0", "continue, break, do and while");
}

#[test]
fn functions_return_early_and_write_their_outputs() {
    let out = output(
        r#"void f(float x, output float y) { y = 1; if (x > 0) return; y = 2; }
           shader test() { float a[2]; f(1, a[0]); f(-1, a[1]); color c = 0; f(1, c.g); printf("%g %g (%g)", a[0], a[1], c); }"#,
    );
    assert_eq!(out, "1 2 (0 1 0)", "outputs may be elements and components");
}

#[test]
fn values_are_passed_as_they_were() {
    let out = output(
        r#"shader test() { float g = 1; void set() { g = 5; } float f(float x) { set(); return x; } float r = f(g); printf("%g %g", r, g); }"#,
    );
    assert_eq!(out, "1 5", "an argument keeps its value while the function changes the variable");
}

#[test]
fn structs_nest_and_are_arrays() {
    let out = output(
        r#"struct A { float x; color c; }; struct B { A a; int k[2]; };
           A swapped(A a) { return A(a.c.r, color(a.x)); }
           shader test() {
             B b = { {1, color(2, 3, 4)}, {7, 8} };
             A list[2]; list[1] = b.a; list[1] = swapped(list[1]);
             B other = b; other.a.x = 9;
             printf("%g (%g) %d %g (%g) %g", b.a.x, b.a.c, other.k[1], list[1].x, list[1].c, other.a.x);
           }"#,
    );
    assert_eq!(out, "1 (2 3 4) 8 2 (1 1 1) 9", "members, copies, elements, results");
}

#[test]
fn overloads_are_chosen_by_argument_and_result() {
    let out = output(
        r#"float f(int x) { return 1; } float f(color x) { return 2; } color f(int x) { return 3; }
           shader test() { float a = f(1); color b = f(1); float c = f(color(0)); printf("%g (%g) %g", a, b, c); }"#,
    );
    assert_eq!(out, "1 (3 3 3) 2", "the result that is wanted decides");
}

#[test]
fn operators_of_structs_are_functions() {
    let out = output(
        r#"struct V { float x; }; V __operator__add__(V a, V b) { return V(a.x + b.x); }
           V __operator__neg__(V a) { return V(-a.x); }
           shader test() { V a = V(1); V b = V(2); V c = a + -b; c += a; printf("%g", c.x); }"#,
    );
    assert_eq!(out, "0", "1 - 2 + 1");
}

#[test]
fn derivatives_follow_the_chain_rule() {
    let text = "shader test() { float f = sin(u * 3) * u; printf(\"%.5f %.5f\", Dx(f), Dy(f)); }";
    let mut group = Group::default();
    group.add(Arc::new(shader(text)), None, &[], &mut Vec::new());
    let plan = gnurt_sl::exec::Plan::new(&group, &Default::default()).expect("it is known");
    let world = crate::common::Empty::default();
    let mut machine = gnurt_sl::exec::Machine::new(&plan, &world);
    let (u, dx) = (0.7_f32, 0.25);
    machine.run(&gnurt_sl::exec::Point { u: gnurt_sl_lib::Dual::new(u, dx, 0.0), ..Default::default() });
    let slope = (3.0 * (u * 3.0).cos() * u + (u * 3.0).sin()) * dx;
    assert_eq!(machine.events, [Event::Print(format!("{slope:.5} 0.00000"))], "(f g)' = f' g + f g'");
}

#[test]
fn an_index_out_of_range_is_told_and_moved() {
    let out =
        body("float a[3] = {1, 2, 3}; int i = 5; float x = a[i]; a[-1 - i] = 7; printf(\"%g %g\", x, a[0]);");
    assert!(out.starts_with("ERROR Index [5] out of range a[0..2]: test.osl:1 "), "{out}");
    assert!(out.ends_with("3 7"), "the last and the first element: {out}");
}

#[test]
fn layers_run_when_they_are_asked() {
    let up = Arc::new(shader(r#"shader up(float k = 1, output float o = 0) { printf("up;"); o = k + 1; }"#));
    let idle = Arc::new(shader(r#"shader idle(output float o = 0) { printf("idle;"); o = 3; }"#));
    let down = Arc::new(shader(
        r#"shader down(float a = 0, float b = 0) { printf("down;"); if (a > 1) printf("%g %d", a, isconnected(b)); }"#,
    ));
    let mut find = |name: &str| match name {
        "up" => Some(up.clone()),
        "idle" => Some(idle.clone()),
        "down" => Some(down.clone()),
        _ => None,
    };
    let text =
        "param float k 4 ; shader up u ; shader idle i ; shader down d ; connect u.o d.a ; connect i.o d.b ;";
    let group = read_group("g", text, &mut find, &mut Vec::new()).expect("the text is right");
    let list: Vec<String> = diagnostics_of(&group)
        .into_iter()
        .map(|e| if let Event::Print(t) = e { t } else { format!("{e:?}") })
        .collect();
    assert_eq!(list.concat(), "down;up;5 1", "up only when a is read, idle never");
    let again =
        read_group("g", &write_group(&group), &mut find, &mut Vec::new()).expect("what is written is read");
    assert_eq!(write_group(&again), write_group(&group), "a group's text is read back");
}

#[test]
fn messages_are_refused_twice() {
    let out = body(
        r#"int x = 0; int a = getmessage("m", x); setmessage("n", 5); int b = getmessage("n", x); setmessage("m", 1); printf("%d %d %d", a, b, x);"#,
    );
    assert!(out.contains("message \"m\" was queried before being set"), "{out}");
    assert!(out.ends_with("0 1 5"), "{out}");
}
