// SPDX-License-Identifier: GPL-3.0-or-later
//! Views against the numbers of OpenColorIO 2.6.0 (the Python package `opencolorio`), and errors of configurations.

use gnurt_image::{Picture, ToneCurve, WriteOptions, read, srgb, write};
use gnurt_ocio::{Error, Request, View};

const CG: &str = "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1";
const COLORS: [[f32; 3]; 6] =
    [[0.18; 3], [1.0; 3], [4.0, 0.2, 0.05], [0.02, 0.5, 0.1], [20.0, 30.0, 40.0], [0.0; 3]];

fn assert_view(request: &Request, expected: [[f32; 3]; 6]) {
    let view = View::new(request).expect("a view");
    let mut colors = COLORS.map(|[r, g, b]| [r, g, b, 0.5]);
    view.apply(&mut colors);
    for (found, expected) in colors.iter().zip(expected) {
        let is_near = (0..3).all(|c| (found[c] - expected[c]).abs() < 3e-5);
        assert!(is_near && found[3] == 0.5, "{request:?}: {found:?}, {expected:?}");
    }
}

#[test]
fn views_have_the_numbers_of_open_color_io() {
    let request = Request { config: CG, ..Request::default() };
    assert_view(
        &request,
        [
            [0.35595, 0.35595, 0.35595],
            [0.81197, 0.81198, 0.81197],
            [1.04178, 0.61211, 0.30502],
            [-0.06364, 0.64227, 0.26802],
            [1.00385, 1.00812, 1.01137],
            [0.0; 3],
        ],
    );
    let gamut = Request { looks: Some("ACES 1.3 Reference Gamut Compression"), ..request };
    assert_view(
        &gamut,
        [
            [0.35595, 0.35595, 0.35595],
            [0.81197, 0.81198, 0.81197],
            [1.04057, 0.61253, 0.36086],
            [-0.06364, 0.64227, 0.26802],
            [1.00385, 1.00812, 1.01137],
            [0.0; 3],
        ],
    );
    let plain = Request { view: Some("un-tone-mapped"), ..request };
    let view = View::new(&plain).expect("a view, in any case of its letters");
    assert_eq!(
        [view.display(), view.view(), view.source()],
        ["sRGB - Display", "Un-tone-mapped", "Linear Rec.709 (sRGB)"]
    );
    assert_view(&plain, COLORS.map(|color| color.map(srgb::encode)));
    let aces = Request {
        config: "ocio://studio-config-v4.0.0_aces-v2.0_ocio-v2.5",
        display: Some("Rec.2100-PQ - Display"),
        view: Some("ACES 2.0 - HDR 1000 nits (P3 D65)"),
        ..Request::default()
    };
    assert_view(
        &aces,
        [
            [0.32984, 0.32984, 0.32984],
            [0.51447, 0.51447, 0.51447],
            [0.60479, 0.45691, 0.36468],
            [0.34152, 0.42808, 0.3173],
            [0.72865, 0.73022, 0.73265],
            [0.0; 3],
        ],
    );
}

/// A configuration of a file, whose view is a gamma of 2 behind a space of its own.
const OWN: &str = "ocio_profile_version: 2
roles: {default: lin, scene_linear: lin, aces_interchange: aces}
displays:
  screen: [!<View> {name: half, colorspace: root}]
colorspaces:
  - !<ColorSpace> {name: aces, isdata: false}
  - !<ColorSpace> {name: lin, to_scene_reference: !<MatrixTransform> {matrix: [0.439632981919491, 0.382988698151554, 0.177378319928955, 0, 0.0897764429588424, 0.813439428748981, 0.0967841282921771, 0, 0.0175411703831727, 0.111546553302387, 0.87091227631444, 0, 0, 0, 0, 1]}}
  - !<ColorSpace> {name: root, to_scene_reference: !<GroupTransform> {children: [!<ExponentTransform> {value: [2, 2, 2, 1]}, !<ColorSpaceTransform> {src: lin, dst: aces}]}}
";

#[test]
fn configurations_of_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.ocio");
    std::fs::write(&path, OWN).expect("a file");
    let config = path.to_str().expect("a name");
    // Found by its colours: no name of it is known.
    let view = View::new(&Request { config, ..Request::default() }).expect("a view");
    assert_eq!(view.source(), "lin");
    let picture = Picture { color: vec![[0.25, 0.04, 4.0, 1.0]; 40_000], ..Picture::new(200, 200) };
    let workers = &|count: usize, job: &(dyn Fn(usize) + Sync)| (0..count).rev().for_each(job);
    let shown = view.shown(&picture, -2.0, workers);
    let file = folder.path().join("a.png");
    write(
        &shown,
        &file,
        &WriteOptions { tone: ToneCurve::Clamp, png_16_bits: true, ..WriteOptions::default() },
    )
    .expect("a file");
    for pixel in read(&file).expect("a picture").color {
        for (found, expected) in pixel.into_iter().map(srgb::encode).zip([0.25, 0.1, 1.0]) {
            assert!((found - expected).abs() < 1e-4, "{pixel:?}");
        }
    }
    for (text, part) in [
        ("", "a.ocio"),
        ("ocio_profile_version: 9\n", "a.ocio"),
        (&OWN[..200], "a.ocio"),
        ("\u{1}: [", "a.ocio"),
    ] {
        std::fs::write(&path, text).expect("a file");
        let error =
            View::new(&Request { config, ..Request::default() }).expect_err("no configuration").to_string();
        assert!(error.contains(part) && error.len() > part.len() + 5, "{error}");
    }
}

#[test]
fn wrong_names_list_the_valid_ones() {
    let of = |request: Request| View::new(&request).expect_err("a wrong name");
    let request = Request { config: CG, ..Request::default() };
    for (request, part) in [
        (Request { display: Some("screen"), ..request }, "sRGB - Display"),
        (Request { view: Some("nice"), ..request }, "Un-tone-mapped"),
        (Request { looks: Some("+nice"), ..request }, "Reference Gamut"),
        (Request { source: Some("mine"), ..request }, "ACEScg"),
    ] {
        let error = of(request);
        assert!(matches!(error, Error::UnknownName { .. }) && error.to_string().contains(part), "{error}");
    }
    for config in ["ocio://nothing", "nothing.ocio", "/dev/null", "."] {
        let error = of(Request { config, ..Request::default() });
        assert!(matches!(error, Error::Config { .. }), "{error}");
    }
}
