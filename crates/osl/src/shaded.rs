// SPDX-License-Identifier: GPL-3.0-or-later
//! The results of a group: closures as flat lists, outputs, messages.

use std::sync::Arc;

use gnurt_sl::exec::{ClosureDecl, ClosureParam, Event, Part, Plan, Results, RetainedOutput};
use gnurt_sl::types::{Base, Type};

/// A closure of a point, with the weight that all products and sums around it make.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    /// The factor, by colour.
    pub weight: [f32; 3],
    /// Its name, such as `diffuse` or `dielectric_bsdf`.
    pub name: Arc<str>,
    /// The values of its parameters, all of them, in the order of [`parameters`](Self::parameters). Those that the shader
    /// does not give are 0, empty texts or no closures.
    pub arguments: Vec<Argument>,
    parameters: Arc<[ClosureParam]>,
}

/// The value of a closure's parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Argument {
    /// A whole number.
    Int(i32),
    /// A number.
    Float(f32),
    /// A colour, vector, normal or point.
    Triple([f32; 3]),
    /// A text.
    Text(Arc<str>),
    /// Closures within: both arguments of `layer`.
    Lobes(Vec<Lobe>),
    /// Arrays and matrices.
    Floats(Vec<f32>),
}

impl Lobe {
    /// Its parameters: names and types. The [table](crate::closures) has their meanings.
    #[must_use]
    pub fn parameters(&self) -> &[ClosureParam] {
        &self.parameters
    }

    /// The argument of a parameter by its name, such as `eta`; keywords such as `thinfilm_ior`, too. `None` if the closure's
    /// declaration has no such parameter. A keyword that the shader does not give is 0.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<&Argument> {
        let at = self.parameters.iter().position(|known| *known.name == *name)?;
        self.arguments.get(at)
    }

    /// Argument `i` as a number; 0 where it is none.
    #[must_use]
    pub fn float(&self, i: usize) -> f32 {
        match self.arguments.get(i) {
            Some(Argument::Float(x)) => *x,
            Some(Argument::Int(x)) => *x as f32,
            _ => 0.0,
        }
    }

    /// Argument `i` as a colour or direction; zeros where it is none.
    #[must_use]
    pub fn triple(&self, i: usize) -> [f32; 3] {
        match self.arguments.get(i) {
            Some(Argument::Triple(v)) => *v,
            _ => [0.0; 3],
        }
    }

    /// Argument `i` as a text; empty where it is none.
    #[must_use]
    pub fn text(&self, i: usize) -> &str {
        match self.arguments.get(i) {
            Some(Argument::Text(text)) => text,
            _ => "",
        }
    }

    /// Closures in argument `i`.
    #[must_use]
    pub fn lobes(&self, i: usize) -> &[Lobe] {
        match self.arguments.get(i) {
            Some(Argument::Lobes(lobes)) => lobes,
            _ => &[],
        }
    }
}

/// An output of all points.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Its name as it was requested.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// Its numbers, point by point; ints as floats.
    pub values: Vec<f32>,
}

/// Results of [`ShaderGroup::run`](crate::ShaderGroup::run).
#[derive(Clone, Debug, Default)]
pub struct Shaded {
    lobes: Vec<Vec<Lobe>>,
    outputs: Vec<Output>,
    /// Texts of `printf`, `warning` and `error`, and mistakes found at run time, each with the point's position in the slice that ran.
    pub events: Vec<(usize, Event)>,
}

/// Closures within closures that are flattened.
const DEEPEST: usize = 16;

impl Shaded {
    pub(crate) fn new(kept: &[RetainedOutput], points: usize) -> Self {
        let output = |kept: &RetainedOutput| Output {
            name: kept.name.clone(),
            ty: kept.ty,
            values: Vec::with_capacity(points * kept.ty.size()),
        };
        Self {
            lobes: Vec::with_capacity(points),
            outputs: kept.iter().map(output).collect(),
            events: Vec::new(),
        }
    }

    /// The closures of a point, by its position in the slice that ran, in the order of the text. Closures of weight 0 are left out.
    /// Equal ones are not merged. Weights may be negative, as the shader made them.
    ///
    /// # Panics
    /// If there is no such point.
    #[must_use]
    pub fn lobes(&self, point: usize) -> &[Lobe] {
        let points = self.lobes.len();
        self.lobes
            .get(point)
            .unwrap_or_else(|| panic!("there is no point {point}: the group ran for {points} points"))
    }

    /// The outputs that the group keeps, in the order in which they were requested.
    #[must_use]
    pub fn outputs(&self) -> &[Output] {
        &self.outputs
    }

    /// An output that the group keeps, by the very name that [`GroupBuilder::output`](crate::GroupBuilder::output) was given.
    #[must_use]
    pub fn output(&self, name: &str) -> Option<&Output> {
        self.outputs.iter().find(|output| output.name == name)
    }

    /// Adds the points of a batch.
    pub(crate) fn add(
        &mut self,
        first: usize,
        count: usize,
        from: &Results,
        known: &[ClosureDecl],
        plan: &Plan,
    ) {
        let flatten = Flatten { from, known, plan };
        for lane in 0..count {
            self.lobes.push(flatten.lobes(from.ci[lane], lane, 0));
        }
        for (output, kept) in self.outputs.iter_mut().zip(gnurt_sl::exec::Program::retained(plan)) {
            let rows = from.rows.get(kept.row..kept.row + kept.ty.size()).unwrap_or_default();
            output.values.extend((0..count).flat_map(|lane| rows.iter().map(move |row| row[lane])));
        }
        self.events.extend(from.events.iter().map(|(lane, event)| (first + lane, event.clone())));
    }
}

struct Flatten<'a> {
    from: &'a Results,
    known: &'a [ClosureDecl],
    plan: &'a Plan,
}

impl Flatten<'_> {
    fn lobes(&self, node: u32, lane: usize, depth: usize) -> Vec<Lobe> {
        if depth > DEEPEST {
            return Vec::new();
        }
        let parts = self.from.closures.parts(node, lane).into_iter();
        parts.filter_map(|(weight, part)| self.lobe(weight, &part, lane, depth)).collect()
    }

    fn lobe(&self, weight: [f32; 3], part: &Part<'_>, lane: usize, depth: usize) -> Option<Lobe> {
        let decl = self.known.get(part.kind as usize)?;
        let mut first = 0;
        let arguments = decl.params.iter().map(|param| {
            let bits: Vec<u32> = (first..first + param.ty.size()).map(|i| part.cells(i).at(lane)).collect();
            first += bits.len();
            self.argument(param.ty, &bits, lane, depth)
        });
        let arguments = arguments.collect();
        Some(Lobe { weight, name: decl.name.clone(), arguments, parameters: decl.params.clone() })
    }

    fn argument(&self, ty: Type, bits: &[u32], lane: usize, depth: usize) -> Argument {
        let floats = || bits.iter().map(|&x| f32::from_bits(x));
        match (ty.base, bits) {
            (Base::Closure, &[node]) => Argument::Lobes(self.lobes(node, lane, depth + 1)),
            (Base::Int, &[x]) => Argument::Int(x as i32),
            (Base::String, &[number]) if (number as usize) < self.plan.strings.count() => {
                Argument::Text(self.plan.strings.text(number).clone())
            }
            (Base::String, _) => Argument::Text("".into()),
            (_, &[x]) => Argument::Float(f32::from_bits(x)),
            (_, &[x, y, z]) if !ty.is_array() => Argument::Triple([x, y, z].map(f32::from_bits)),
            _ => Argument::Floats(floats().collect()),
        }
    }
}
