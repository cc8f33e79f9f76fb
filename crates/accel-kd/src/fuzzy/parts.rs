// SPDX-License-Identifier: GPL-3.0-or-later
//! Parts of a mesh whose triangles move alike.
//! Source: [GFW*06]: each triangle joins the part whose motion leaves the least of its own, each part moves as its triangles do best, in
//! turns; a new part begins with the triangle that moves most against its own. Differs: motions are rigid, and parts are
//! found for a sample of the triangles. Space: rest, which is the first pose. Tests: `tests`.

use super::rigid::Rigid;

/// Triangles from which parts are found.
const SAMPLE: usize = 1024;

/// Rounds for each number of parts.
const ROUNDS: usize = 4;

/// No new part begins where all triangles move by less than this against their part, in diagonals of the box at rest.
const LITTLE: f64 = 0.005;

/// Motions of a part in all poses.
type Motions = Vec<Rigid>;

/// A mesh in several poses.
#[derive(Clone, Copy)]
pub(super) struct Poses<'a> {
    pub(super) positions: &'a [&'a [[f32; 3]]],
    pub(super) triangles: &'a [[u32; 3]],
}

impl Poses<'_> {
    /// Corners of triangles, at rest and in a pose.
    fn corners<'a>(
        &'a self,
        triangles: &'a [u32],
        pose: usize,
    ) -> impl Iterator<Item = [[f32; 3]; 2]> + Clone + 'a {
        let (rest, posed) = (self.positions[0], self.positions[pose]);
        let corners = triangles.iter().flat_map(|&number| self.triangles[number as usize]);
        corners.map(|corner| [rest[corner as usize], posed[corner as usize]])
    }

    fn motions(&self, triangles: &[u32]) -> Motions {
        (0..self.positions.len()).map(|pose| Rigid::fit(self.corners(triangles, pose))).collect()
    }

    /// The square of how far a triangle's corners move against motions.
    fn residue(&self, number: u32, motions: &Motions) -> f64 {
        let own = [number];
        let mut most = 0.0f64;
        for (pose, motion) in motions.iter().enumerate() {
            for [rest, posed] in self.corners(&own, pose) {
                let back = motion.at_rest(posed);
                most = most.max((0..3).map(|k| (back[k] - f64::from(rest[k])).powi(2)).sum());
            }
        }
        most
    }

    /// The part whose motion leaves least, and that.
    fn nearest(&self, number: u32, parts: &[Motions]) -> (usize, f64) {
        let residues = parts.iter().map(|motions| self.residue(number, motions)).enumerate();
        residues.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// Triangles of at most `most` parts, none of them empty. There is at least one pose.
    pub(super) fn parts(&self, most: usize) -> Vec<Vec<u32>> {
        let count = self.triangles.len();
        let step = count.div_ceil(SAMPLE).max(1);
        let sample: Vec<u32> = (0..count as u32).step_by(step).collect();
        let mut parts = vec![self.motions(&sample)];
        let little = LITTLE * self.diagonal();
        loop {
            let worst = self.settle(&sample, &mut parts);
            match worst {
                Some((number, residue)) if residue.sqrt() > little && parts.len() < most => {
                    parts.push(self.motions(&[number]));
                }
                _ => break,
            }
        }
        let mut lists = vec![Vec::new(); parts.len()];
        for number in 0..count as u32 {
            lists[self.nearest(number, &parts).0].push(number);
        }
        lists.retain(|list| !list.is_empty());
        lists
    }

    /// Triangles and motions in turns; the triangle that moves most against its part then.
    fn settle(&self, sample: &[u32], parts: &mut [Motions]) -> Option<(u32, f64)> {
        let mut before = Vec::new();
        for _ in 0..ROUNDS {
            let found: Vec<(usize, f64)> = sample.iter().map(|&number| self.nearest(number, parts)).collect();
            let joined: Vec<usize> = found.iter().map(|(part, _)| *part).collect();
            for (part, motions) in parts.iter_mut().enumerate() {
                let own: Vec<u32> = sample
                    .iter()
                    .zip(&joined)
                    .filter(|(_, of)| **of == part)
                    .map(|(&number, _)| number)
                    .collect();
                // Without triangles it keeps what it had.
                if !own.is_empty() {
                    *motions = self.motions(&own);
                }
            }
            if joined == before {
                break;
            }
            before = joined;
        }
        let all = sample.iter().map(|&number| (number, self.nearest(number, parts).1));
        all.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn diagonal(&self) -> f64 {
        let extent = gnurt_accel_core::Aabb::around(self.positions[0]).extent();
        extent.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_has_two_parts() {
        // Quads along an axis, of which the second half turns about the middle.
        let at = |i: u32, angle: f32| {
            let (along, side) = ((i / 2) as f32 / 20.0 - 1.0, (i % 2) as f32);
            let (sin, cos) = angle.sin_cos();
            if along <= 0.0 { [along, side, 0.0] } else { [cos * along, side, sin * along] }
        };
        let pose = |angle: f32| -> Vec<[f32; 3]> { (0..82).map(|i| at(i, angle)).collect() };
        let poses = [pose(0.0), pose(0.7), pose(1.5)];
        let positions: Vec<&[[f32; 3]]> = poses.iter().map(Vec::as_slice).collect();
        let triangles: Vec<[u32; 3]> = (0..40)
            .flat_map(|i| [[2 * i, 2 * i + 1, 2 * i + 2], [2 * i + 1, 2 * i + 3, 2 * i + 2]])
            .collect();
        let poses = Poses { positions: &positions, triangles: &triangles };
        let parts = poses.parts(8);
        assert_eq!(parts.len(), 2, "upper and lower arm: {parts:?}");
        for part in parts {
            let is_first = part[0] < 40;
            assert!(part.iter().all(|&number| (number < 40) == is_first), "each of its own: {part:?}");
        }
        assert_eq!(
            Poses { positions: &positions[..1], ..poses }.parts(8).len(),
            1,
            "nothing moves in one pose"
        );
    }
}
