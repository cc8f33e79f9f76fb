// SPDX-License-Identifier: GPL-3.0-or-later
//! Regular expressions against the output of OSL's test suite, the rules of ECMAScript, and a matcher by
//! definition.

use gnurt_sl_lib::regex::Regex;
use proptest::prelude::*;

fn spans(pattern: &str, subject: &str) -> Option<Vec<Option<(usize, usize)>>> {
    let regex = Regex::new(pattern).unwrap_or_else(|error| panic!("{error}"));
    regex.find(subject, false).expect("few steps")
}

/// The whole match.
fn found<'a>(pattern: &str, subject: &'a str) -> Option<&'a str> {
    let (start, end) = spans(pattern, subject)?[0]?;
    Some(&subject[start..end])
}

#[test]
fn results_are_osls() {
    let is_whole = |subject: &str, pattern: &str| {
        Regex::new(pattern).expect("a pattern").search(subject, true, &mut []).expect("few steps")
    };
    assert_eq!([is_whole("foo", "f"), is_whole("foo", "f[Oo]{2}"), is_whole("foo", ".*o")], [0, 1, 1]);
    let mut results = [9; 6];
    let regex = Regex::new("(f[Oo]{2}).*(.az)").expect("a pattern");
    assert_eq!(regex.search("foobar.baz", false, &mut results), Ok(1));
    assert_eq!(results, [0, 10, 0, 3, 7, 10]);
    assert_eq!(regex.search("bark", false, &mut results), Ok(0));
    assert_eq!(results, [17; 6], "no match: the pattern's length");
    let mut more = [0; 6];
    assert_eq!(Regex::new("a(b)?").expect("a pattern").search("xa", false, &mut more), Ok(1));
    assert_eq!(more, [1, 2, 2, 2, 5, 5], "a group that took no part, and one that there is not");
}

#[test]
fn syntax_means_what_it_should() {
    let known: [(&str, &str, Option<&str>); 44] = [
        ("a|ab", "ab", Some("a")),
        ("ab|a", "ab", Some("ab")),
        ("(?:a|ab)c", "abc", Some("abc")),
        ("a*?b", "aab", Some("aab")),
        ("a+?", "aaa", Some("a")),
        ("a{2}", "aaa", Some("aa")),
        ("a{2,}", "aaaa", Some("aaaa")),
        ("a{1,2}?", "aaa", Some("a")),
        ("a{0}b", "ab", Some("b")),
        ("(a*)*", "aab", Some("aa")),
        ("(a*)+", "b", Some("")),
        ("(?:)*x", "x", Some("x")),
        ("^b", "ab", None),
        ("a$", "ba", Some("a")),
        ("a$b", "ab", None),
        (".", "\n", None),
        ("x.z", "x\rz", None),
        ("[a-c]+", "xabcd", Some("abc")),
        ("[^a-c]+", "abxyc", Some("xy")),
        ("[]a]", "]", None),
        ("[a-]+", "-a", Some("-a")),
        ("[\\]x]+", "]x", Some("]x")),
        ("[[:digit:]_]+", "a12_", Some("12_")),
        ("\\d+\\D", "12x", Some("12x")),
        ("\\w+", "-a_1-", Some("a_1")),
        ("\\s", "a b", Some(" ")),
        ("\\S+", " ab ", Some("ab")),
        ("\\bfoo\\b", "a foo.", Some("foo")),
        ("\\Boo", "foo", Some("oo")),
        ("(a|b)\\1", "abb", Some("bb")),
        ("(a)?\\1b", "b", Some("b")),
        ("a(?=b)", "acab", Some("a")),
        ("a(?!b)", "abac", Some("a")),
        ("(?=(a+))a*b\\1", "baaabac", Some("aba")),
        ("(?!a).", "ab", Some("b")),
        ("\\x41\\u0042", "AB", Some("AB")),
        ("\\.", "a.", Some(".")),
        ("\\t\\n", "\t\n", Some("\t\n")),
        ("\\cA", "\u{1}", Some("\u{1}")),
        ("", "abc", Some("")),
        ("a||b", "b", Some("")),
        ("(|a)+b", "aab", Some("aab")),
        ("[\\d-x]+", "1-x", Some("1-x")),
        ("z*?$", "azz", Some("zz")),
    ];
    for (pattern, subject, expected) in known {
        assert_eq!(found(pattern, subject), expected, "{pattern} in {subject:?}");
    }
    assert_eq!(spans("a(?=b)", "acab"), Some(vec![Some((2, 3))]), "the second a");
    assert_eq!(spans("a(?!b)", "abac"), Some(vec![Some((2, 3))]));
    let groups = spans("(z)((a+)?(b+)?(c))*", "zaacbbbcac").expect("ECMAScript's example");
    assert_eq!(groups[0], Some((0, 10)));
}

#[test]
fn what_is_no_pattern_says_why() {
    let wrong = [
        ("(a", 0, "not closed"),
        ("a)", 1, "unmatched closing parenthesis"),
        ("*a", 0, "repeat"),
        ("a**", 2, "repeat"),
        ("[a", 0, "not closed"),
        ("a{2", 3, "brace"),
        ("a{3,1}", 2, "below"),
        ("a{x}", 2, "count"),
        ("\\", 0, "backslash"),
        ("\\q", 0, "letter"),
        ("(?<a)", 1, "only"),
        ("[z-a]", 1, "above"),
        ("\\2(a)", 5, "group"),
        ("[[:none:]]", 0, "class"),
        ("\\xZ", 2, "hexadecimal"),
        ("^*", 1, "repeat"),
        ("((a{999}){999}){999}", 0, "too large"),
    ];
    for (pattern, at, reason) in wrong {
        let error = Regex::new(pattern).expect_err(pattern);
        assert!(error.reason.contains(reason), "{error}");
        assert!(error.at == at || at == 0, "{error}");
    }
    assert!(Regex::new(&"(".repeat(1000)).is_err(), "no deep recursion");
    let slow = Regex::new("(a*)*(a*)*(a*)*(a*)*c").expect("a pattern");
    let error = slow.find(&"a".repeat(200), false).expect_err("too many ways");
    assert!(error.to_string().contains("given up"), "{error}");
}

/// A tree of a regular expression, and all ends of its matches by definition.
#[derive(Clone, Debug)]
enum Tree {
    Letter(char),
    Then(Box<Tree>, Box<Tree>),
    Or(Box<Tree>, Box<Tree>),
    Many(Box<Tree>),
}

impl Tree {
    fn text(&self) -> String {
        match self {
            Self::Letter(c) => c.to_string(),
            Self::Then(a, b) => format!("{}{}", a.text(), b.text()),
            Self::Or(a, b) => format!("(?:{}|{})", a.text(), b.text()),
            Self::Many(a) => format!("(?:{})*", a.text()),
        }
    }

    fn ends(&self, s: &[u8], at: usize) -> std::collections::BTreeSet<usize> {
        match self {
            Self::Letter(c) => (s.get(at) == Some(&(*c as u8))).then_some(at + 1).into_iter().collect(),
            Self::Then(a, b) => a.ends(s, at).into_iter().flat_map(|i| b.ends(s, i)).collect(),
            Self::Or(a, b) => a.ends(s, at).union(&b.ends(s, at)).copied().collect(),
            Self::Many(a) => {
                let mut all = std::collections::BTreeSet::from([at]);
                loop {
                    let more: std::collections::BTreeSet<_> =
                        all.iter().flat_map(|i| a.ends(s, *i)).collect();
                    let count = all.len();
                    all.extend(more);
                    if all.len() == count {
                        return all;
                    }
                }
            }
        }
    }
}

/// Comparisons and copies of characters count, too, beside steps.
#[test]
fn long_groups_are_not_compared_for_ever() {
    let subject = "a".repeat(1 << 20);
    let start = std::time::Instant::now();
    for pattern in ["(a*)\\1b", "((a*)\\2)*c", "(a*)(?=\\1c)b"] {
        let regex = Regex::new(pattern).expect("a pattern");
        assert!(regex.find(&subject, false).is_err(), "{pattern} is given up");
    }
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}

fn tree() -> impl Strategy<Value = Tree> {
    let leaf = prop::char::range('a', 'c').prop_map(Tree::Letter);
    leaf.prop_recursive(4, 12, 2, |inner| {
        let two = (inner.clone(), inner.clone()).prop_map(|(a, b)| (Box::new(a), Box::new(b)));
        prop_oneof![
            two.clone().prop_map(|(a, b)| Tree::Then(a, b)),
            two.prop_map(|(a, b)| Tree::Or(a, b)),
            inner.prop_map(|a| Tree::Many(Box::new(a))),
        ]
    })
}

proptest! {
    #[test]
    fn matches_are_those_of_the_definition(tree in tree(), subject in "[a-c]{0,8}") {
        let regex = Regex::new(&tree.text()).expect("a pattern");
        let whole = regex.find(&subject, true).expect("few steps").is_some();
        prop_assert_eq!(whole, tree.ends(subject.as_bytes(), 0).contains(&subject.len()), "{} of {}", tree.text(), &subject);
        let first = regex.find(&subject, false).expect("few steps").and_then(|groups| groups[0]);
        let expected = (0..=subject.len()).find(|&i| !tree.ends(subject.as_bytes(), i).is_empty());
        prop_assert_eq!(first.map(|(start, _)| start), expected);
    }

    #[test]
    fn any_text_is_a_pattern_or_an_error(pattern in "[a-c(|)*+?{},1-3\\\\^$.\\[\\]:=!-]{0,16}", subject in "[a-c1]{0,12}") {
        if let Ok(regex) = Regex::new(&pattern) {
            let _ = regex.search(&subject, false, &mut [0; 8]);
        }
    }
}
