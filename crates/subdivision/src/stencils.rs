// SPDX-License-Identifier: GPL-3.0-or-later
//! Weighted sums of values: one for each value that a step makes. Tests: `tests/subdivision.rs`.

/// One sum per new value.
#[derive(Default)]
pub(super) struct Stencils {
    starts: Vec<u32>,
    terms: Vec<(u32, f32)>,
}

impl Stencils {
    /// Adds to the sum that is being made.
    pub(super) fn add(&mut self, value: u32, weight: f32) {
        self.terms.push((value, weight));
    }

    /// Adds the mean of some values.
    pub(super) fn add_mean(&mut self, values: &[u32], weight: f32) {
        let each = weight / values.len() as f32;
        values.iter().for_each(|&value| self.add(value, each));
    }

    /// Ends a sum.
    pub(super) fn end(&mut self) {
        self.starts.push(self.terms.len() as u32);
    }

    /// The same in double precision.
    pub(super) fn apply_doubles(&self, values: &[f64], width: usize) -> Vec<f64> {
        let mut sums = vec![0.0; self.starts.len() * width];
        let mut from = 0;
        for (sum, &end) in sums.chunks_exact_mut(width.max(1)).zip(&self.starts) {
            for &(value, weight) in &self.terms[from..end as usize] {
                let at = value as usize * width;
                for (sum, &x) in sum.iter_mut().zip(&values[at..at + width]) {
                    *sum += f64::from(weight) * x;
                }
            }
            from = end as usize;
        }
        sums
    }

    /// All sums of values of `width` floats.
    pub(super) fn apply(&self, values: &[f32], width: usize) -> Vec<f32> {
        let mut sums = Vec::with_capacity(self.starts.len() * width);
        let mut sum = vec![0.0_f64; width];
        let mut from = 0;
        for &end in &self.starts {
            sum.fill(0.0);
            for &(value, weight) in &self.terms[from..end as usize] {
                let at = value as usize * width;
                for (sum, &x) in sum.iter_mut().zip(&values[at..at + width]) {
                    *sum += f64::from(weight) * f64::from(x);
                }
            }
            sums.extend(sum.iter().map(|&x| x as f32));
            from = end as usize;
        }
        sums
    }
}
