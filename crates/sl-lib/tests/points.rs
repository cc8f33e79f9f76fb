// SPDX-License-Identifier: GPL-3.0-or-later
//! Point clouds: the tree against brute force, files, and invalid files.

use gnurt_sl_lib::points::*;

/// Numbers that look random, on a grid so that many distances are equal.
fn positions(count: usize) -> Vec<[f32; 3]> {
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 27) as f32 / 4.0
    };
    (0..count).map(|_| [next(), next(), next()]).collect()
}

#[test]
fn the_nearest_points_are_found() {
    for count in [0, 1, 7, 9, 40, 500] {
        let mut positions = positions(count);
        if let Some(first) = positions.get_mut(3) {
            first[1] = f32::NAN;
        }
        let cloud = PointCloud::new(positions.clone(), Vec::new()).expect("no columns");
        for (center, radius, most) in [
            ([1.0, 2.0, 3.0], 2.5, 10),
            ([0.1, 7.0, 4.0], 100.0, 33),
            ([4.0, 4.0, 4.0], 1.5, usize::MAX),
            ([4.0, 4.0, 4.0], 0.0, 5),
            ([-9.0, 4.0, 4.0], 1.0, 5),
            ([4.0, 4.0, 4.0], 9.0, 0),
        ] {
            let away = |p: &[f32; 3]| (0..3).map(|k| (p[k] - center[k]) * (p[k] - center[k])).sum::<f32>();
            let mut expected: Vec<(f32, u32)> = positions
                .iter()
                .zip(0..)
                .map(|(p, i)| (away(p), i))
                .filter(|x| x.0 <= radius * radius)
                .collect();
            expected.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
            expected.truncate(most);
            let expected: Vec<(u32, f32)> = expected.into_iter().map(|(d, i)| (i, d.sqrt())).collect();
            assert_eq!(cloud.nearest(center, radius, most), expected, "{count} points around {center:?}");
        }
    }
    let cloud = PointCloud::new(positions(9), Vec::new()).expect("no columns");
    assert!(
        cloud.nearest([f32::NAN; 3], 1.0, 3).is_empty() && cloud.nearest([0.0; 3], f32::NAN, 3).is_empty()
    );
}

fn row(list: &[(&str, Values)]) -> Vec<Column> {
    let width = |values: &Values| if let Values::Float(list) = values { list.len() } else { 1 };
    list.iter()
        .map(|(name, values)| {
            let width = width(values);
            Column { name: (*name).into(), width, is_vector: width == 3, values: values.clone() }
        })
        .collect()
}

#[test]
fn what_is_written_is_read() {
    let mut cloud = PointCloud::default();
    let text = |text: &str| Values::Text(vec![text.into()]);
    assert!(cloud.push([0.1, 1e-7, 3.0], &row(&[("u", Values::Float(vec![0.3])), ("kind", text("oak"))])));
    let more =
        [("c", Values::Float(vec![1.0, 2.0, 1e30])), ("n", Values::Int(vec![-7])), ("kind", text("elm"))];
    assert!(cloud.push([4.0, 5.0, 6.0], &row(&more)));
    assert!(!cloud.push([7.0, 8.0, 9.0], &row(&[("u", Values::Int(vec![3]))])), "it has been a float");
    assert_eq!(cloud.column("u").expect("a column").values, Values::Float(vec![0.3, 0.0, 0.0]));
    assert_eq!(cloud.column("c").expect("a column").values.clone(), {
        Values::Float(vec![0.0, 0.0, 0.0, 1.0, 2.0, 1e30, 0.0, 0.0, 0.0])
    });
    let text = write_cloud(&cloud).expect("a file");
    let back = read_cloud(&text).unwrap_or_else(|why| panic!("{why}\n{text}"));
    assert_eq!((back.positions(), back.columns()), (cloud.positions(), cloud.columns()), "{text}");
    let bare = PointCloud::new(vec![[1.0, 2.0, 3.0]], Vec::new()).expect("no columns");
    assert_eq!(
        read_cloud(&write_cloud(&bare).expect("a file")).expect("a cloud").positions(),
        bare.positions()
    );
    cloud.push([0.0; 3], &row(&[("two words", Values::Int(vec![1]))]));
    assert!(write_cloud(&cloud).expect_err("a name with a space").contains("'two words'"));
}

#[test]
fn what_is_no_cloud_is_refused_by_its_line() {
    let good = "PGEOMETRY V5\nNPoints 2 NPrims 0\nNPointGroups 0 NPrimGroups 0\nNPointAttrib 1 NVertexAttrib 0 NPrimAttrib 0 NAttrib 0\nPointAttrib\nu 1 float 0\n0 0 0 1 (0.5)\n0 0 2 2 (1)\n";
    assert_eq!(read_cloud(good).expect("a cloud").positions()[1], [0.0, 0.0, 1.0], "by their last number");
    for (from, to, said) in [
        ("PGEOMETRY", "GEOMETRY", "line 1: 'GEOMETRY' in place of 'PGEOMETRY'"),
        ("NPoints 2", "NPoints two", "line 2: 'two' is no count"),
        ("NPoints 2", "NPoints 2000000000000", "exceed the length of the file"),
        ("NPoints 2", "NPoints 3", "line 9: the file ends too early"),
        ("u 1 float", "u 0 float", "line 6: an attribute of 0 values"),
        ("u 1 float", "u 1 quark", "of the kind 'quark'"),
        ("(0.5)", "(half)", "line 7: 'half' is no number"),
        ("(0.5)", "(0.5 7)", "line 7: '7' in place of ')'"),
    ] {
        let why = read_cloud(&good.replace(from, to)).expect_err(to);
        assert!(why.contains(said), "{why}");
    }
    // Cut anywhere, it is refused or read, and nothing else.
    for end in 0..good.len() {
        let _ = read_cloud(&good[..end]);
    }
}
