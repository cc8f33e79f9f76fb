// SPDX-License-Identifier: GPL-3.0-or-later
//! From closures to scattering: weighted lobes, emission and transparency; all points of a batch at once, and
//! lobes of constant numbers once for all points. The closures are defined in `lobe`. Space: world.
//! Tests: `tests/scripts/{closures,lanes}.rs`.

use glam::Vec3;
use gnurt_shading::bsdf::{ClosureBatch, Ends, Lists};
use gnurt_shading::{ColorMap, Interior};
use gnurt_sl::exec::{Cells, Closure, Closures, LANES, Part, Points, Results, lanes_of};

use crate::closures::{Known, Shape, all};
use crate::lobe::{Params, interior, lobes};

/// Layers may lie on each other this deep.
const DEEPEST: u32 = 16;
/// Limit of visited nodes of a batch; the rest of a closure that has more is left out.
const MOST_NODES: u32 = 1 << 14;

/// A number of each point.
pub(crate) type Row = [f32; LANES];
/// A colour or a direction of each point.
pub(crate) type Rows = [Row; 3];

const ONES: Rows = [[1.0; LANES]; 3];

/// A colour of each point that is black for most.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Light {
    rows: Rows,
    /// Points whose colour may not be black.
    pub(crate) some: u32,
}

impl Light {
    pub(crate) fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.rows[0][i], self.rows[1][i], self.rows[2][i])
    }

    /// Adds colours of some points.
    fn add(&mut self, lanes: u32, more: impl Fn(usize) -> Vec3) {
        for i in lanes_of(lanes) {
            let sum = self.get(i) + more(i);
            for (row, x) in self.rows.iter_mut().zip(sum.to_array()) {
                row[i] = x;
            }
        }
        self.some |= lanes;
    }

    /// Adds other light times a colour.
    fn add_times(&mut self, lanes: u32, more: &Self, weight: &Rows) {
        self.add(lanes & more.some, |i| more.get(i) * column(weight, i));
    }
}

/// Emission and transparency of points, and the medium behind them, separate from scattering.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lights {
    /// Light that they give off.
    pub(crate) emission: Light,
    /// Share of light that goes straight through.
    pub(crate) through: Light,
    /// Radiance that the shader has computed itself.
    pub(crate) radiance: Light,
    /// Absorption and scattering coefficients behind the surface, 1 over world units.
    pub(crate) absorption: Light,
    pub(crate) scattering: Light,
    /// Mean cosine of the scattering of the last medium.
    pub(crate) anisotropy: f32,
    /// Share of the surface that is a hole in the picture.
    pub(crate) holdout: Light,
    /// Sum of the weights of `debug` closures with the requested tag.
    pub(crate) debug: Light,
}

impl Lights {
    /// Whether there are none.
    fn are_out(&self) -> bool {
        self.beside_lobes() | self.radiance.some | self.debug.some == 0
    }

    /// Points with emission, transparency, an absorbing medium or a hole.
    pub(crate) fn beside_lobes(&self) -> u32 {
        self.emission.some | self.through.some | self.absorption.some | self.holdout.some
    }
}

pub(crate) fn column(rows: &Rows, i: usize) -> Vec3 {
    Vec3::new(rows[0][i], rows[1][i], rows[2][i])
}

/// A node still to be visited, for some points, with its weight.
#[derive(Debug)]
pub(crate) struct Open {
    number: u32,
    lanes: u32,
    weight: Rows,
}

/// Visits the closures of a batch.
pub(crate) struct Flattened<'a> {
    nodes: &'a Closures,
    pub(crate) points: &'a Points,
    /// Lobes.
    pub(crate) lists: Lists<'a>,
    /// Everything else.
    pub(crate) lights: Lights,
    shapes: &'static [Shape],
    open: &'a mut Vec<Open>,
    left: u32,
    /// The number of the text whose `debug` closures are summed.
    tag: Option<u32>,
    /// From the shader's colours to the working space.
    map: ColorMap,
    /// The points' shading normals as normals of lobes, if not all are zero; computed at first use.
    own: Option<Option<Rows>>,
}

impl<'a> Flattened<'a> {
    /// Writes the lobes of a batch to the points from `first` on.
    pub(crate) fn flatten_lists(
        points: &'a Points,
        results: &'a Results,
        to: (&'a mut ClosureBatch, usize),
        open: &'a mut Vec<Open>,
        map: ColorMap,
    ) -> Self {
        Self::flatten_tagged(points, results, to, open, (None, map))
    }

    /// The same, with the sum of the `debug` closures whose tag has this number among the texts.
    pub(crate) fn flatten_tagged(
        points: &'a Points,
        results: &'a Results,
        (out, first): (&'a mut ClosureBatch, usize),
        open: &'a mut Vec<Open>,
        (tag, map): (Option<u32>, ColorMap),
    ) -> Self {
        let mut this = Self {
            nodes: &results.closures,
            points,
            lists: Lists::of(out, first),
            lights: Lights::default(),
            shapes: all().1,
            open,
            left: MOST_NODES,
            tag,
            map,
            own: None,
        };
        let lanes = (1_u32 << points.count.min(LANES)) - 1;
        this.open.clear();
        this.tree(Cells::Each(&results.ci), lanes, 0);
        this
    }

    /// Whether something was left out.
    pub(crate) fn is_cut(&self) -> bool {
        self.left == 0 || self.lists.full() != 0
    }

    /// Records closures to visit, each for the points that share it.
    fn spread(&mut self, numbers: Cells, lanes: u32, weight: &Rows) {
        let mut left = lanes;
        while left != 0 {
            let number = numbers.at(left.trailing_zeros() as usize);
            let same = match numbers {
                Cells::One(_) => left,
                Cells::Each(row) => {
                    left & (0..LANES).fold(0, |bits, i| bits | u32::from(row[i] == number) << i)
                }
            };
            left &= !same;
            if number != 0 {
                self.open.push(Open { number, lanes: same, weight: *weight });
            }
        }
    }

    fn tree(&mut self, numbers: Cells, lanes: u32, depth: u32) {
        if depth > DEEPEST {
            return;
        }
        let (below, nodes) = (self.open.len(), self.nodes);
        self.spread(numbers, lanes, &ONES);
        while self.open.len() > below
            && let Some(Open { number, lanes, weight }) = self.open.pop()
        {
            if self.left == 0 {
                self.open.truncate(below);
                return;
            }
            self.left -= 1;
            match nodes.node(number) {
                Some(Closure::Add(a, b)) => {
                    self.spread(b, lanes, &weight);
                    self.spread(a, lanes, &weight);
                }
                Some(Closure::Mul(by, inner)) => {
                    let mut weight = weight;
                    for (row, by) in weight.iter_mut().zip(by) {
                        match by {
                            Cells::One(by) => row.iter_mut().for_each(|x| *x *= f32::from_bits(by)),
                            Cells::Each(by) => {
                                row.iter_mut().zip(by).for_each(|(x, &by)| *x *= f32::from_bits(by));
                            }
                        }
                    }
                    self.spread(inner, lanes, &weight);
                }
                Some(Closure::Component(part)) => self.component(&part, lanes, &weight, depth),
                None => {}
            }
        }
    }

    fn component(&mut self, part: &Part<'a>, lanes: u32, weight: &Rows, depth: u32) {
        let Some(shape) = self.shapes.get(part.kind as usize) else { return };
        if shape.known == Known::Debug {
            let has_tag = |i: &usize| Some(part.cells(shape.firsts[0]).at(*i)) == self.tag;
            let tagged = lanes_of(lanes).filter(has_tag).fold(0, |bits, i| bits | 1 << i);
            let finite = |x: f32| if x.is_finite() { x } else { 0.0 };
            self.lights.debug.add(tagged, |i| column(weight, i).to_array().map(finite).into());
            return;
        }
        let mut retained = Rows::default();
        let mut heaviest = Row::default();
        for (retained, weight) in retained.iter_mut().zip(weight) {
            for ((retained, weight), heaviest) in retained.iter_mut().zip(weight).zip(&mut heaviest) {
                // NaN becomes zero.
                *retained = weight.max(0.0);
                *heaviest = heaviest.max(*retained);
            }
        }
        // Nor is light without end.
        let counts = |x: f32| x > 0.0 && x < f32::INFINITY;
        let some = heaviest.iter().enumerate().fold(0, |bits, (i, &x)| bits | u32::from(counts(x)) << i);
        let lanes = lanes & some;
        if lanes == 0 {
            return;
        }
        let mapped = self.mapped(&retained);
        let weight = mapped.as_ref().unwrap_or(&retained);
        match shape.known {
            Known::Emission => self.lights.emission.add(lanes, |i| column(weight, i)),
            Known::Radiance => self.lights.radiance.add(lanes, |i| column(weight, i)),
            Known::Transparent => self.lights.through.add(lanes, |i| column(weight, i)),
            Known::UniformEdf => {
                let map = self.map;
                let light = |i| Params::new(shape, part, i, map).vec3(0).max(Vec3::ZERO);
                self.lights.emission.add(lanes, |i| map.of(light(i) * column(&retained, i)));
            }
            Known::Layer => self.layer(part, lanes, weight, depth),
            Known::AnisotropicVdf | Known::MediumVdf => self.medium(shape, part, lanes, weight),
            Known::Holdout => self.lights.holdout.add(lanes, |i| column(&retained, i)),
            Known::Debug => {}
            _ => self.scatter(shape, part, lanes, weight),
        }
    }

    /// Weights in the working space, unless that is the shader's.
    fn mapped(&self, weight: &Rows) -> Option<Rows> {
        if self.map == ColorMap::default() {
            return None;
        }
        let mut mapped = Rows::default();
        for i in 0..LANES {
            let color = self.map.of(column(weight, i)).to_array();
            mapped.iter_mut().zip(color).for_each(|(row, x)| row[i] = x);
        }
        Some(mapped)
    }

    /// The medium behind the surface.
    fn medium(&mut self, shape: &'static Shape, part: &Part<'a>, lanes: u32, weight: &Rows) {
        for i in lanes_of(lanes) {
            let Interior { absorption, scattering, anisotropy } =
                interior(&Params::new(shape, part, i, self.map));
            self.lights.absorption.add(1 << i, |i| absorption * column(weight, i));
            self.lights.scattering.add(1 << i, |i| scattering * column(weight, i));
            self.lights.anisotropy = anisotropy;
        }
    }

    /// A layer, and the closures below it.
    fn layer(&mut self, part: &Part<'a>, lanes: u32, weight: &Rows, depth: u32) {
        // They are large: not moved about for nothing.
        let before = (!self.lights.are_out()).then(|| std::mem::take(&mut self.lights));
        let top = self.lists.ends();
        self.tree(part.cells(0), lanes, depth + 1);
        let base = self.lists.ends();
        // The transmittance of the layer applies to the closures below.
        if self.lights.through.some != 0 {
            self.lights.through = Light::default();
        }
        self.tree(part.cells(1), lanes, depth + 1);
        self.lists.layer(lanes, &top, &base);
        self.times(lanes, &top, weight);
        if before.is_none() && self.lights.are_out() {
            return;
        }
        let inner = std::mem::replace(&mut self.lights, before.unwrap_or_default());
        self.lights.emission.add_times(lanes, &inner.emission, weight);
        self.lights.through.add_times(lanes, &inner.through, weight);
        self.lights.radiance.add_times(lanes, &inner.radiance, weight);
        self.lights.absorption.add_times(lanes, &inner.absorption, weight);
        self.lights.scattering.add_times(lanes, &inner.scattering, weight);
        self.lights.holdout.add_times(lanes, &inner.holdout, weight);
        self.lights.debug.add_times(lanes, &inner.debug, weight);
        if inner.absorption.some != 0 {
            self.lights.anisotropy = inner.anisotropy;
        }
    }

    /// Multiplies lobes by weights, if some are not 1.
    fn times(&mut self, lanes: u32, from: &Ends, weight: &Rows) {
        if *weight != ONES {
            self.lists.times(lanes, from, weight);
        }
    }

    /// A closure that is a lobe, or several.
    fn scatter(&mut self, shape: &'static Shape, part: &Part<'a>, lanes: u32, weight: &Rows) {
        let from = self.lists.ends();
        let back = lanes & u32::from(self.points.backfacing);
        if Params::are_one(shape, part) {
            for (same, front) in [(lanes & !back, true), (back, false)] {
                if same != 0 {
                    let i = same.trailing_zeros() as usize;
                    let made = lobes(&Params::new(shape, part, i, self.map), front);
                    made.into_iter().flatten().for_each(|lobe| self.lists.push(same, &lobe));
                }
            }
        } else {
            for i in lanes_of(lanes) {
                let made = lobes(&Params::new(shape, part, i, self.map), back >> i & 1 == 0);
                made.iter().flatten().for_each(|lobe| self.lists.push_to(i, lobe));
            }
        }
        self.times(lanes, &from, weight);
        if let Some(position) = shape.normal()
            && let Some(normals) = self.normals(shape, part, position, lanes)
        {
            self.lists.tilt(lanes, &from, &normals);
        }
    }

    /// The normals that a lobe lies around; zero where they are those of the points, none if they all are.
    fn normals(&mut self, shape: &Shape, part: &Part<'a>, position: usize, lanes: u32) -> Option<Rows> {
        let first = shape.firsts[position];
        let cells = [part.cells(first), part.cells(first + 1), part.cells(first + 2)];
        let points = self.points;
        let is_own = cells.iter().zip(&points.n).all(|(cells, n)| match cells {
            Cells::Each(row) => {
                row.iter().zip(n).fold(0, |differs, (&number_bits, n)| differs | (number_bits ^ n.to_bits()))
                    == 0
            }
            Cells::One(number_bits) => lanes_of(lanes).all(|i| *number_bits == n[i].to_bits()),
        });
        if is_own {
            let all = (1_u32 << points.count.min(LANES)) - 1;
            return *self.own.get_or_insert_with(|| {
                let own =
                    |i: usize| normal(column(&points.n, i), column(&points.ng, i), column(&points.n, i));
                if are_plain(points) { None } else { turned(&own, all) }
            });
        }
        let [x, y, z] = cells;
        let messages = |i: usize| {
            let messages =
                Vec3::new(f32::from_bits(x.at(i)), f32::from_bits(y.at(i)), f32::from_bits(z.at(i)));
            normal(messages, column(&points.ng, i), column(&points.n, i))
        };
        turned(&messages, lanes)
    }
}

/// The normals of some points, none if they are all zero.
fn turned(of: &dyn Fn(usize) -> Vec3, lanes: u32) -> Option<Rows> {
    let mut rows = Rows::default();
    for i in lanes_of(lanes) {
        (rows[0][i], rows[1][i], rows[2][i]) = of(i).into();
    }
    rows.iter().any(|row| *row != [0.0; LANES]).then_some(rows)
}

/// Whether it is plain to see that [`normal`] makes zero of all points' own normals: they are unit, on the side of the meshes'.
fn are_plain(points: &Points) -> bool {
    let ([x, y, z], [a, b, c]) = (&points.n, &points.ng);
    (0..points.count.min(LANES)).fold(true, |plain, i| {
        let length = x[i] * x[i] + y[i] * y[i] + z[i] * z[i];
        plain & ((length - 1.0).abs() < 5e-7) & (x[i] * a[i] + y[i] * b[i] + z[i] * c[i] >= 0.0)
    })
}

/// The normal that a lobe lies around at a point of these unit normals, both towards where the ray came from; zero where it is that of
/// the point.
fn normal(n: Vec3, ng: Vec3, ns: Vec3) -> Vec3 {
    let n = if n.is_finite() { n } else { Vec3::ZERO };
    let Some(n) = n.try_normalize() else { return Vec3::ZERO };
    let n = if n.dot(ng) < 0.0 { -n } else { n };
    if n.dot(ns) > 1.0 - 1e-6 { Vec3::ZERO } else { n }
}
