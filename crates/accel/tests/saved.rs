// SPDX-License-Identifier: GPL-3.0-or-later
//! Trees that were saved and loaded are the same, and files that are no trees are refused.

use crate::common::{QueryTarget, TESTS, batch, build, run_queries};
use std::sync::Arc;

use gnurt_accel::{
    Aabb, Coherence, Geometry, LARGEST_COORDINATE, Level, LoadError, Memory, ObjectTree, Quads, Query, Ray,
    Spheres, Structure, Threads, TriangleTest, Triangles, UserGeometry, UserHit,
};
use gnurt_testkit::{Random, Soup, closed};

/// Triangles of all kinds, bad ones too.
fn mixed(n: usize) -> Soup {
    Soup::degenerate(2, n)
}

fn save(tree: &ObjectTree) -> Vec<u8> {
    let mut file = Vec::new();
    tree.save(&mut file).expect("memory takes all");
    file
}

#[test]
fn what_is_loaded_is_what_was_saved() {
    let meshes = [mixed(500), closed::torus(20), mixed(40)];
    let mut random = Random::new(3);
    let rays = batch(&(0..500).map(|_| (random.point(), random.point())).collect::<Vec<_>>());
    for (kind, _) in TESTS {
        for meshes in [&meshes[..], &meshes[1..2], &[]] {
            let tree = build(meshes, kind);
            let mut file = save(&tree);
            file.push(77);
            let mut rest = &file[..];
            let loaded = ObjectTree::load(&mut rest).expect("it was saved");
            assert_eq!(rest, [77], "{kind:?}: what lies behind it is not touched");
            assert!(loaded.same_tree(&tree), "{kind:?}: node for node");
            assert_eq!(loaded.stats(), tree.stats(), "{kind:?}: measured alike");
            assert_eq!(loaded.bounds(), tree.bounds(), "{kind:?}: bounds");
            assert_eq!(loaded.bad_primitives(), tree.bad_primitives(), "{kind:?}: what was left out");
            assert_eq!(run_queries(&loaded, &rays), run_queries(&tree, &rays), "{kind:?}: hits");
            assert_eq!(save(&loaded), file[..file.len() - 1], "{kind:?}: saved again");
        }
    }
}

#[test]
fn quads_and_spheres_are_saved_but_no_user_geometry() {
    let mesh = closed::torus(12);
    let triangles = Triangles { positions: &mesh.positions, indices: &mesh.indices };
    let corners = [[-1.0, -1.0, 0.5], [1.0, -1.0, 0.5], [1.0, 1.0, 0.5], [-1.0, 1.0, 0.5]];
    let quads = Quads { positions: &corners, indices: &[[0, 1, 2, 3]] };
    let (centers, radii) = ([[0.0; 3], [0.5, 0.5, 0.5]], [0.25, 0.5]);
    let spheres = Spheres { centers: &centers, radii: &radii };
    let mut random = Random::new(5);
    let rays = batch(&(0..500).map(|_| (random.point(), random.point())).collect::<Vec<_>>());
    for (kind, _) in TESTS {
        let geometries = [Geometry::from(triangles), quads.into(), spheres.into()];
        let tree = ObjectTree::build_from(&geometries, &crate::common::options(kind), Threads::Single);
        let mut file = save(&tree);
        let loaded = ObjectTree::load(&mut &file[..]).expect("it was saved");
        assert!(loaded.same_tree(&tree), "{kind:?}: node for node");
        assert_eq!(loaded.stats(), tree.stats(), "{kind:?}: measured alike");
        assert_eq!(run_queries(&loaded, &rays), run_queries(&tree, &rays), "{kind:?}: hits");
        for _ in 0..500 {
            let mut file = file.clone();
            let at = random.below(file.len() - 8);
            file[at] ^= 1 << random.below(8);
            crate::signed::sign(&mut file);
            if let Ok(tree) = ObjectTree::load(&mut &file[..]) {
                tree.run_queries(
                    &Query { level: Level::best(), coherence: Coherence::Coherent, mask: u32::MAX },
                    &rays,
                );
            }
        }
        file.truncate(file.len() / 2);
        assert!(matches!(ObjectTree::load(&mut &file[..]), Err(LoadError::Truncated)), "half of it");
    }
    let user = Geometry::user(Arc::new(Point));
    let tree = ObjectTree::build_from(&[user], &crate::common::options(TESTS[0].0), Threads::Single);
    let error = tree.save(&mut Vec::new()).expect_err("nobody can save it");
    assert_eq!(error.kind(), std::io::ErrorKind::Unsupported, "{error}");
}

#[derive(Debug)]
struct Point;

impl UserGeometry for Point {
    fn count(&self) -> u32 {
        1
    }

    fn bounds(&self, _: u32) -> Aabb {
        Aabb::around(&[[0.0; 3]])
    }

    fn intersect(&self, _: u32, _: &Ray, _: &mut dyn FnMut(UserHit)) {}
}

/// Boxes reach beyond the greatest coordinate there is: those of spheres, by their radius, and of compact nodes, by a step.
#[test]
fn trees_as_large_as_can_be_are_loaded() {
    let far = 0.999 * LARGEST_COORDINATE;
    let triangle = [[-far; 3], [far, far, -far], [0.1 * far, far, far]];
    let (many, one) = ([[far; 3], [-far; 3], [far, -far, 0.3 * far], [0.0; 3]], [[far; 3]]);
    let radii = [far; 4];
    for (kind, _) in TESTS {
        let mesh = Geometry::from(Triangles { positions: &triangle, indices: &[[0, 1, 2]] });
        let one = Geometry::from(Spheres { centers: &one, radii: &radii });
        let many = Geometry::from(Spheres { centers: &many, radii: &radii });
        for geometries in [&[mesh.clone()][..], &[one], &[mesh, many]] {
            let tree = ObjectTree::build_from(geometries, &crate::common::options(kind), Threads::Single);
            assert_eq!(tree.bad_primitives().total(), 0, "{kind:?}: all of it can be traced");
            let loaded = ObjectTree::load(&mut &save(&tree)[..]);
            let loaded = loaded.unwrap_or_else(|error| panic!("{kind:?}, {geometries:?}: {error}"));
            assert!(loaded.same_tree(&tree), "{kind:?}: node for node");
            let cost = loaded.stats().sah_cost;
            assert!(cost.is_finite() && cost == tree.stats().sah_cost, "{kind:?}: {cost}");
            let ray = Ray::new([0.0, 0.0, -2.0 * far], [0.1, 0.2, 1.0]);
            assert_eq!(loaded.intersect(&ray), tree.intersect(&ray), "{kind:?}: hits");
        }
    }
}

/// Each geometry lies in one tree. Of a file in which two name the same one that one is not a tree that can be refitted.
#[test]
fn geometries_in_two_trees_are_refused() {
    let mesh = closed::torus(4);
    let triangles = Triangles { positions: &mesh.positions, indices: &mesh.indices };
    let geometries = [Geometry::from(triangles).with_mask(1), Geometry::from(triangles).with_mask(2)];
    for (kind, _) in TESTS {
        let options = crate::common::options(kind);
        let file = save(&ObjectTree::build_from(&geometries, &options, Threads::Single));
        // The last triangle of the first mesh becomes the first one of the second, in each place where its number may be.
        let count = mesh.indices.len() as u32;
        let placements: Vec<usize> =
            (0..file.len() / 4 - 2).filter(|&at| value(&file, at) == count - 1).collect();
        let mut refused = 0;
        for at in placements {
            let mut changed = file.clone();
            set_value(&mut changed, at, count);
            crate::signed::sign(&mut changed);
            match ObjectTree::load(&mut &changed[..]) {
                Err(error) => refused += usize::from(error.to_string().contains("several trees")),
                // It was another word. There is no panic.
                Ok(tree) => drop([
                    tree.posed_from(&geometries, Threads::Single),
                    tree.refit_from(&geometries, Threads::Single),
                ]),
            }
        }
        assert!(refused > 0 || kind.2 == TriangleTest::Projected, "{kind:?}: it is told");
    }
}

#[test]
fn no_part_of_a_file_is_a_tree() {
    for (kind, _) in TESTS {
        let file = save(&build(&[mixed(60)], kind));
        for length in 0..file.len() {
            match ObjectTree::load(&mut &file[..length]) {
                Err(LoadError::Truncated) => {}
                other => panic!("{kind:?}: {length} of {} bytes are {other:?}", file.len()),
            }
        }
    }
}

#[test]
fn any_change_is_found() {
    let mut random = Random::new(4);
    for (kind, _) in TESTS {
        let file = save(&build(&[mixed(200)], kind));
        for _ in 0..2000 {
            let mut changed = file.clone();
            let at = random.below(file.len());
            changed[at] ^= 1 + random.below(255) as u8;
            let error = ObjectTree::load(&mut &changed[..]).err();
            assert!(error.is_some(), "{kind:?}: byte {at} was changed");
        }
    }
}

fn value(file: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([file[4 * at], file[4 * at + 1], file[4 * at + 2], file[4 * at + 3]])
}

fn set_value(file: &mut [u8], at: usize, value: u32) {
    file[4 * at..4 * at + 4].copy_from_slice(&value.to_le_bytes());
}

#[test]
fn signed_changes_are_found_or_harmless() {
    let mut random = Random::new(11);
    let rays = batch(&(0..64).map(|_| (random.point(), random.point())).collect::<Vec<_>>());
    for (kind, _) in TESTS {
        let file = save(&build(&[mixed(300), closed::torus(8)], kind));
        let mut again = file.clone();
        crate::signed::sign(&mut again);
        assert!(again == file, "a file has the checksum that it should have");
        let (mut refused, mut taken) = (0, 0);
        for round in 0..2000 {
            let mut file = file.clone();
            if round % 2 == 0 {
                file[random.below(again.len() - 8)] ^= 1 << random.below(8);
            } else {
                // A tree accepts only copies of other words as its own.
                let [to, from] = [0; 2].map(|_: i32| random.below(again.len() / 4 - 2));
                let copied = value(&file, from);
                set_value(&mut file, to, copied);
            }
            crate::signed::sign(&mut file);
            match ObjectTree::load(&mut &file[..]) {
                Ok(tree) => {
                    for coherence in [Coherence::Incoherent, Coherence::Coherent] {
                        tree.run_queries(&Query { level: Level::best(), coherence, mask: u32::MAX }, &rays);
                    }
                    assert!(tree.bad_primitives().total() < 1 << 63, "counts stay counts");
                    taken += 1;
                }
                // A shorter list makes all behind it something else, the checksum as well.
                Err(LoadError::Io(error)) => panic!("{error} in round {round}"),
                Err(_) => refused += 1,
            }
        }
        assert!(refused > 100 && taken > 100, "{refused} refused and {taken} taken of {kind:?}");
    }
}

#[test]
fn nodes_that_share_a_child_are_refused() {
    // Words of head, starts, quads, counts, statistics, number of trees; mask, kind, statistics, bounds, number of nodes.
    const NODES: usize = 4 + (2 + 2) + (2 + 1) + 12 + 14 + 2 + (2 + 2 + 14 + 6 + 2);
    for (kind, _) in TESTS {
        let mut file = save(&build(&[closed::torus(20)], kind));
        match kind.0 {
            Structure::Bvh => {
                let inner = |&at: &usize| value(&file, at) >> 31 == 0;
                let children = NODES + if kind.3 == Memory::Fast { 48 } else { 18 };
                let inner: Vec<usize> = (children..children + 8).filter(inner).collect();
                let child = value(&file, inner[0]);
                set_value(&mut file, inner[1], child);
            }
            // The children of the root's left child become those of its right one.
            _ => {
                let children = value(&file, NODES + 2);
                assert!(children > 0 && value(&file, NODES + 4) > 0, "both are no leaves");
                set_value(&mut file, NODES + 4, children);
            }
        }
        crate::signed::sign(&mut file);
        let error = ObjectTree::load(&mut &file[..]).expect_err("no tree").to_string();
        let is_reported =
            error.contains("child of several") || error.contains("not where a walk comes to it");
        assert!(is_reported, "{kind:?}: {error}");
    }
}

#[test]
fn what_a_file_claims_costs_no_memory() {
    let mut file = save(&build(&[], TESTS[0].0));
    // The number of geometries, which would be 16 GiB.
    let at = 16;
    file[at..at + 8].copy_from_slice(&((1u64 << 32) - 1).to_le_bytes());
    let error = ObjectTree::load(&mut &file[..]).expect_err("they are not there");
    assert!(matches!(error, LoadError::Truncated | LoadError::Damaged(_)), "{error}");
    file[at..at + 8].fill(0xff);
    assert!(matches!(ObjectTree::load(&mut &file[..]), Err(LoadError::Damaged(_))), "nobody has so many");
}

#[test]
fn errors_say_what_is_wrong() {
    let file = save(&build(&[closed::torus(5)], TESTS[0].0));
    let load = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut file = file.clone();
        change(&mut file);
        ObjectTree::load(&mut &file[..]).expect_err("changed").to_string()
    };
    assert_eq!(load(&|file| file[0] = b'g'), "not a saved tree", "the first word");
    assert!(load(&|file| file[8] = 9).contains("version 9"), "of a later version");
    assert!(load(&|file| file[700] ^= 64).contains("checksum"), "a bit flips");
    let mut failing = std::io::Read::chain(&file[..100], Failing);
    assert!(matches!(ObjectTree::load(&mut failing), Err(LoadError::Io(_))), "the disk's fault");
    let tree = ObjectTree::load(&mut &file[..]).expect("as it was saved");
    assert!(tree.intersect(&Ray::new([0.0, 0.0, 9.0], [1.0, 0.0, 0.0])).is_none(), "it can be asked");
}

struct Failing;

impl std::io::Read for Failing {
    fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
        Err(std::io::Error::other("a scratch"))
    }
}
