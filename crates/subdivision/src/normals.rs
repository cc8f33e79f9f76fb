// SPDX-License-Identifier: GPL-3.0-or-later
//! Normals of polygons that are smooth but for some edges.
//! A corner's normal is the sum of the normals, by area, of the faces that it reaches around its vertex without crossing a sharp edge.
//! Space: that of the positions. Tests: `tests/subdivision.rs`.

use super::topology::{Faces, Topology};

/// The numbers of each corner's normal, and the normals, of unit length; zero where the faces have no area.
#[must_use]
pub fn smooth_normals(
    faces: &Faces,
    positions: &[[f32; 3]],
    creases: &[([u32; 2], f32)],
) -> (Vec<u32>, Vec<[f32; 3]>) {
    let topology = Topology::new(faces);
    let mut is_sharp = vec![false; topology.edges.len()];
    for &([a, b], _) in creases {
        if let Some(edge) = topology.edge_between(a, b) {
            is_sharp[edge] = true;
        }
    }
    // Corners that share a normal have the same leader.
    let mut leaders: Vec<u32> = (0..faces.corners().len() as u32).collect();
    let mut seen: Vec<Option<[u32; 2]>> = vec![None; topology.edges.len()];
    for face in 0..faces.len() {
        let range = faces.range(face);
        for corner in range.clone() {
            let next = if corner + 1 == range.end { range.start } else { corner + 1 };
            let edge = topology.corner_edges[corner] as usize;
            if is_sharp[edge] || topology.face_counts[edge] != 2 {
                continue;
            }
            match seen[edge] {
                None => seen[edge] = Some([corner as u32, next as u32]),
                Some([first, second]) => {
                    for other in [first, second] {
                        for own in [corner as u32, next as u32] {
                            if faces.corners()[own as usize] == faces.corners()[other as usize] {
                                join(&mut leaders, own, other);
                            }
                        }
                    }
                }
            }
        }
    }
    let mut numbers = vec![u32::MAX; leaders.len()];
    let mut sums: Vec<[f64; 3]> = Vec::new();
    let mut corner_normals = vec![0; leaders.len()];
    for face in 0..faces.len() {
        let area = area_normal(&faces.corners()[faces.range(face)], positions);
        for corner in faces.range(face) {
            let leader = leader(&mut leaders, corner as u32) as usize;
            if numbers[leader] == u32::MAX {
                numbers[leader] = sums.len() as u32;
                sums.push([0.0; 3]);
            }
            corner_normals[corner] = numbers[leader];
            let sum = &mut sums[numbers[leader] as usize];
            (0..3).for_each(|k| sum[k] += area[k]);
        }
    }
    (corner_normals, sums.into_iter().map(unit).collect())
}

fn leader(leaders: &mut [u32], mut of: u32) -> u32 {
    while leaders[of as usize] != of {
        let above = leaders[leaders[of as usize] as usize];
        leaders[of as usize] = above;
        of = above;
    }
    of
}

fn join(leaders: &mut [u32], a: u32, b: u32) {
    let (a, b) = (leader(leaders, a), leader(leaders, b));
    leaders[a.max(b) as usize] = a.min(b);
}

/// Twice the area of a polygon along its normal, by Newell's method.
fn area_normal(corners: &[u32], positions: &[[f32; 3]]) -> [f64; 3] {
    let mut normal = [0.0; 3];
    for (i, &corner) in corners.iter().enumerate() {
        let p = positions[corner as usize].map(f64::from);
        let q = positions[corners[(i + 1) % corners.len()] as usize].map(f64::from);
        for (k, sum) in normal.iter_mut().enumerate() {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            *sum += (p[a] - q[a]) * (p[b] + q[b]);
        }
    }
    normal
}

fn unit(v: [f64; 3]) -> [f32; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { v.map(|x| (x / length) as f32) } else { [0.0; 3] }
}
