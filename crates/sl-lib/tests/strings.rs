// SPDX-License-Identifier: GPL-3.0-or-later
//! Strings and numbers as text, against the output of OSL's test suite and of C.

use gnurt_sl_lib::text::*;
use proptest::prelude::*;

fn filled(format: &str, arguments: &[Argument]) -> String {
    Format::new(format).fill(arguments).expect("enough arguments")
}

#[test]
fn hashes_are_farmhashs() {
    assert_eq!([hash_string(""), hash_string("Hello World!")], [0, -16_050_688]);
    let text: String = (0..300_u32).map(|i| char::from(b'a' + (i * 7 % 26) as u8)).collect();
    // OpenImageIO's hash of the first letters.
    let known: [(usize, u64); 22] = [
        (1, 0xb3454265b6df75e3),
        (2, 0x65c94e7de3fd684f),
        (3, 0x2d5b0cbcc48fdc6b),
        (4, 0x7b803bc75cee3292),
        (7, 0xed26868869003b0a),
        (8, 0x93b52af6d9b92820),
        (9, 0xef002a726b27544e),
        (15, 0xa3a2d5a9cab38c6b),
        (16, 0xf496a3696582095e),
        (17, 0x1f0c64814df23a1a),
        (31, 0x08b2aebb06a4ade5),
        (32, 0x9636decce0f119bc),
        (33, 0xb0b8caf511da15b0),
        (63, 0x24a2424101bc92f1),
        (64, 0x28d7b31d1d69208d),
        (65, 0x6ed6772e39738fa7),
        (100, 0xd771e5caf34ad868),
        (127, 0x44d86f1dc468d399),
        (128, 0x917472f7f980118d),
        (129, 0x0eb7d4a2cddb5078),
        (200, 0xd137238fe25cbe34),
        (300, 0xcd7bec0f11601f12),
    ];
    for (length, hash) in known {
        assert_eq!(hash64(&text[..length]), hash, "of {length} bytes");
    }
}

#[test]
fn strings_are_cut_and_asked_as_osls() {
    let cut = [(0, 7), (3, 7), (-2, 7), (3, 2), (0, 20), (0, -4), (-20, 3), (20, 3), (i32::MIN, i32::MAX)];
    let parts = cut.map(|(start, length)| substr("abcdefg", start, length));
    assert_eq!(parts, ["abcdefg", "defg", "fg", "de", "abcdefg", "", "abc", "", "abcdefg"]);
    assert_eq!(substr("\u{e4}b", 1, 2), "\u{fffd}b", "half a letter");
    assert_eq!([0, 11, -1, 12].map(|i| getchar("Hello World!", i)), [72, 33, 0, 0]);
    assert_eq!([startswith("", "abc"), startswith("abc", ""), endswith("abcdef", "def")], [0, 1, 1]);
    assert_eq!([strlen(""), strlen("abc")], [0, 3]);
}

#[test]
fn strings_are_split_as_osls() {
    assert_eq!(split(" 2 4\t6    8", "", 10), ["2", "4", "6", "8"]);
    assert_eq!(split("3,6,9,12", ",", 10), ["3", "6", "9", "12"]);
    assert_eq!(split("3,6,9,12", ",", 2), ["3", "6,9,12"], "the last one is the rest");
    assert_eq!(split(" a b  c ", "", 2), ["a", "b  c "]);
    assert_eq!(split(",,", ",", 9), ["", "", ""]);
    assert!(split("", ",", 9).is_empty() && split("a", ",", 0).is_empty());
}

#[test]
fn numbers_are_read_as_far_as_they_go() {
    let whole = ["-23", " +7x", "x", "", "99999999999", "-99999999999", "0x1f"];
    assert_eq!(whole.map(stoi), [-23, 7, 0, 0, i32::MAX, i32::MIN, 0]);
    let floats = ["3.25", " -2.5e3z", "1e", ".5", "5.", "x", "-", ".", "1e+", "1e99", "-inf", "7e-2"];
    let expected = [3.25, -2500.0, 1.0, 0.5, 5.0, 0.0, 0.0, 0.0, 1.0, f32::INFINITY, f32::NEG_INFINITY, 0.07];
    assert_eq!(floats.map(stof), expected);
    assert!(stof("NaN").is_nan());
}

#[test]
fn numbers_are_written_as_by_c() {
    let general = [
        (0.0, "0"),
        (1.0, "1"),
        (0.1, "0.1"),
        (1e-5, "1e-05"),
        (0.0001, "0.0001"),
        (123_456.0, "123456"),
        (1_234_567.0, "1.23457e+06"),
        (100_000.0, "100000"),
        (999_999.5, "1e+06"),
        (-0.5, "-0.5"),
        (1.0 / 3.0, "0.333333"),
        (3.4e38, "3.4e+38"),
        (1e-40, "9.99995e-41"),
        (f32::INFINITY, "inf"),
        (f32::NAN, "nan"),
        (-0.0, "-0"),
    ];
    for (x, expected) in general {
        assert_eq!(super_general(x), expected);
    }
    let one = |format: &str, x: f32| filled(format, &[Argument::Floats(&[x])]);
    let floats = [
        ("%f", 1.5, "1.500000"),
        ("%.0f", 2.5, "2"),
        ("%#.0f", 2.0, "2."),
        ("%5.1f|", 3.2, "  3.2|"),
        ("%-7.2f|", 3.25, "3.25   |"),
        ("%09.3f", -3.25, "-0003.250"),
        ("%+g", 2.0, "+2"),
        ("% g", 2.0, " 2"),
        ("%e", 12345.678, "1.234568e+04"),
        ("%.2e", 45.3, "4.53e+01"),
        ("%#g", 2.0, "2.00000"),
        ("%.3g", 1234.0, "1.23e+03"),
        ("%d", 2.5, "2.500000"),
        ("%s", 2.5, "2.500000"),
        ("%x", 2.5, "2.500000"),
        ("%.8f", 1.232_32, "1.23231995"),
        ("%06f", f32::INFINITY, "   inf"),
        ("%G", 1e-9, "1E-09"),
    ];
    for (format, x, expected) in floats {
        assert_eq!(one(format, x), expected, "{format} of {x}");
    }
    let one = |format: &str, x: i32| filled(format, &[Argument::Ints(&[x])]);
    let ints = [
        ("%d", -5, "-5"),
        ("%5d|", 5, "    5|"),
        ("%-5d|", 5, "5    |"),
        ("%05d", -5, "-0005"),
        ("%+05d", 12, "+0012"),
        ("%i", 7, "7"),
        ("%x", 255, "ff"),
        ("%X", -1, "FFFFFFFF"),
        ("%#x", 10, "0xa"),
        ("%o", 9, "11"),
        ("%#o", 9, "011"),
        ("%u", -1, "4294967295"),
        ("%f", 7, "7"),
        ("%s", 7, "7"),
        ("%g", 7, "7"),
        ("%c", 7, "7"),
        ("%.3d", 7, "007"),
        ("%ld", 7, "7"),
        ("%d", i32::MIN, "-2147483648"),
    ];
    for (format, x, expected) in ints {
        assert_eq!(one(format, x), expected, "{format} of {x}");
    }
}

fn super_general(x: f32) -> String {
    let text = general(x.into(), 6);
    assert_eq!(filled("%g", &[Argument::Floats(&[x])]), text);
    text
}

#[test]
fn formats_take_strings_arrays_and_anything() {
    let all = [Argument::Strings(&["spam"]), Argument::Floats(&[0.5, 0.5, 1.0]), Argument::Ints(&[1, 2])];
    assert_eq!(filled("%s: %g {%d} 100%%", &all), "spam: 0.5 0.5 1 {1 2} 100%");
    assert_eq!(filled("%d|%6s|%-6s|%.2s", &[Argument::Strings(&["abc"]); 4]), "abc|abc   |abc   |ab");
    assert_eq!(filled("%", &all), "%", "no letter");
    assert_eq!(filled("no place", &all), "no place");
    assert_eq!(filled("%s", &[Argument::Floats(&[])]), "", "an empty array");
    assert_eq!(Format::new("%d %d").placeholders(), 2);
    let error = Format::new("%d %d").fill(&all[..1]).expect_err("one is missing");
    assert!(error.to_string().contains("Mismatch between format string and arguments"), "{error}");
    assert!(filled("%999999999999d", &[Argument::Ints(&[1])]).len() <= 512, "no memory for nothing");
}

proptest! {
    #[test]
    fn text_reads_back(x in any::<f32>(), n in any::<i32>()) {
        prop_assume!(x.is_finite());
        let nine = filled("%.9g", &[Argument::Floats(&[x])]);
        prop_assert_eq!(stof(&nine).to_bits(), x.to_bits(), "{}", nine);
        prop_assert_eq!(stoi(&filled("%d", &[Argument::Ints(&[n])])), n);
    }

    #[test]
    fn no_text_is_too_much(format in "[%a-g0-9.#+ -]{0,12}", s in "\\PC{0,8}", separator in "\\PC{0,2}", at in any::<i32>(), most in 0_usize..5) {
        let format = Format::new(&format);
        let arguments = vec![Argument::Floats(&[1.5, -2.5]); format.placeholders()];
        prop_assert!(format.fill(&arguments).is_ok());
        let _ = (substr(&s, at, at / 2), getchar(&s, at), stoi(&s), stof(&s), hash_string(&s));
        prop_assert!(split(&s, &separator, most).len() <= most);
    }
}
