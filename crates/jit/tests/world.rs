// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs groups by the interpreter and by machine code at every level, and compares all that they give.

use gnurt_jit::{Compiled, Lanes};
use gnurt_simd::Level;
use gnurt_sl::exec::{
    ClosureDecl, ClosureParam, Component, DualRow, Event, Given, Host, LANES, Machine, Plan, PlanOptions,
    Point, Points, TextureOptions, lanes_of,
};
use gnurt_sl::group::Group;
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{Shader, SymbolKind};
use gnurt_sl::types::Type;
use gnurt_sl::{Options, compile};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::color::ColorSystem;
use std::sync::Arc;

/// A world that answers a little.
pub(crate) struct World {
    colors: ColorSystem,
    closures: Vec<ClosureDecl>,
}

impl Default for World {
    fn default() -> Self {
        let param = |ty: Type| ClosureParam::new("", ty);
        let named = |ty: Type, key: &str| ClosureParam::keyword(key, ty);
        let decl =
            |name: &str, params: Vec<ClosureParam>| ClosureDecl { name: name.into(), params: params.into() };
        let tint = Type::COLOR;
        let microfacet = [Type::STRING, Type::NORMAL, Type::FLOAT, Type::FLOAT, Type::INT].map(param);
        let conductor = [Type::NORMAL, Type::VECTOR, Type::FLOAT, Type::FLOAT, tint, tint, Type::STRING];
        let films = ["thinfilm_thickness", "thinfilm_ior"].map(|key| named(Type::FLOAT, key));
        let conductor = conductor.map(param).into_iter().chain(films).collect();
        Self {
            colors: ColorSystem::named("Rec709").expect("it is known"),
            closures: vec![
                decl("emission", Vec::new()),
                decl("diffuse", vec![param(Type::NORMAL)]),
                decl("microfacet", microfacet.to_vec()),
                decl("conductor_bsdf", conductor),
                decl("layer", vec![param(Type::CLOSURE); 2]),
            ],
        }
    }
}

impl Host for World {
    fn color_system(&self) -> &ColorSystem {
        &self.colors
    }

    fn userdata(&self, name: &str, _: Type, point: &Point) -> Option<Given> {
        // Some points have it.
        (name == "s" && point.index % 3 != 0).then(|| Data::Float(vec![point.index as f32]).into())
    }

    fn closures(&self) -> &[ClosureDecl] {
        &self.closures
    }

    fn common_from(&self, space: &str, point: &Point) -> Option<[[f32; 4]; 4]> {
        let x = match space {
            "object" => 0.5,
            "own" => point.index as f32,
            _ => return None,
        };
        Some([[2.0, 0.0, 1.0, 0.0], [0.0, 1.0, x, 0.0], [0.0, 0.0, 4.0, 0.0], [x, 2.0, 3.0, 1.0]])
    }

    fn is_same_space(&self, space: &str, lanes: u32, index: &[i32; 16]) -> bool {
        let first = index[lanes.trailing_zeros() as usize];
        space == "object" || lanes_of(lanes).all(|lane| index[lane] == first)
    }

    fn ray_kind(&self, name: &str) -> u32 {
        ["camera", "shadow", "glossy"].iter().position(|kind| *kind == name).map_or(0, |i| 1 << i)
    }

    fn texture(
        &self,
        file: &str,
        [s, t]: [Dual<f32>; 2],
        o: &TextureOptions,
        _: &Point,
    ) -> Result<[Dual<f32>; 4], String> {
        if file == "missing.png" {
            return Err("there is none".into());
        }
        let own = file.len() as f32 + o.width[0] + 2.0 * o.blur[1] + o.fill + o.first_channel as f32;
        let wrapped = if &*o.wrap[1] == "mirror" { -own } else { own };
        Ok([s * t, s + t, Dual::new(wrapped, s.dy, t.dx), (o.channels as f32).into()])
    }

    fn textures(
        &self,
        file: &str,
        lanes: u32,
        [s, t]: &[DualRow; 2],
        options: &TextureOptions,
        out: &mut [DualRow; 4],
    ) -> bool {
        if file.starts_with("alone") || file.starts_with("missing") {
            return false;
        }
        for i in lanes_of(lanes) {
            let texel = self.texture(file, [s.get(i), t.get(i)], options, &Point::default());
            for (row, x) in out.iter_mut().zip(texel.expect("it is there")) {
                row.set(i, x);
            }
        }
        true
    }
}

/// The shader of a text.
pub(crate) fn shader(text: &str) -> Arc<Shader> {
    let compiled = compile("test.osl", text, &Options::default(), &|_| None);
    let messages: Vec<String> =
        compiled.diagnostics.list.iter().map(|d| format!("{}: {}", d.loc.line, d.message)).collect();
    Arc::new(compiled.shader.unwrap_or_else(|| panic!("it does not compile: {messages:?}\n{text}")))
}

/// The group of one text.
pub(crate) fn single_group(text: &str) -> Group {
    let mut group = Group::default();
    group.add(shader(text), Some("layer"), &[], &mut Vec::new());
    group
}

/// Points that differ in all that shaders see.
pub(crate) fn points(count: usize) -> Vec<Point> {
    let dual = |k: usize, i: usize| {
        let x = (k * 7 + i * 3) as f32 * 0.37 - 2.0;
        Dual::new(x, 0.01 * (k + 1) as f32, -0.02 * (i + 1) as f32)
    };
    (0..count)
        .map(|k| Point {
            p: Dual::from_components([dual(k, 0), dual(k, 1), dual(k, 2)]),
            i: Dual::from_components([dual(k, 3), dual(k, 4), dual(k, 5)]),
            n: [0.6, 0.0, 0.8],
            ng: [0.0, 0.0, 1.0],
            u: Dual::new(k as f32 / 13.0, 0.1, 0.0),
            v: Dual::new(1.0 - k as f32 / 7.0, 0.0, 0.1),
            dpdu: [1.0, 0.0, 0.0],
            dpdv: [0.0, 1.0, 0.0],
            time: 0.25,
            index: k as i32,
            backfacing: k % 2 == 1,
            ray_kinds: 1 << (k % 4),
            surface_area: 0.5 * k as f32,
            ..Point::default()
        })
        .collect()
}

/// As a batch.
pub(crate) fn rows(list: &[Point]) -> Points {
    let mut points = Points { count: list.len(), ..Points::default() };
    for (lane, point) in list.iter().enumerate() {
        points.set(lane, point);
    }
    points
}

fn same(a: &Data, b: &Data) -> bool {
    match (a, b) {
        (Data::Float(a), Data::Float(b)) => {
            a.len() == b.len()
                && a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits() || x.is_nan() && y.is_nan())
        }
        _ => a == b,
    }
}

/// The results of a point: outputs, `Ci`, and its messages.
type Given1 = (Vec<Data>, Vec<Event>);

/// Compares, as the group is and as it is optimised, of which the last layer's outputs are wanted. The oracle
/// runs every operation of the text. Returns how many operations of the latter were left to the interpreter.
pub(crate) fn compare(group: &Group, text: &str) -> usize {
    compare_with(group, Codes::All, text)
}

/// The codes of a plan that are compared.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Codes {
    /// At all levels, for one point and for many.
    All,
    /// At one level, for one point or for many, by a number.
    Some(u64),
}

/// The same with some codes.
pub(crate) fn compare_with(group: &Group, codes: Codes, text: &str) -> usize {
    let plan = |optimise, outputs| {
        let options = PlanOptions { optimise, outputs, drops_outputs: optimise, ..PlanOptions::default() };
        Arc::new(Plan::new(group, &options).expect("all operations are known"))
    };
    let last = group.layers.last().expect("a layer");
    let wanted = last.shader.params().map(|(_, s)| format!("{}.{}", last.name, s.name)).collect();
    let plain = plan(false, Vec::new());
    let outputs: Vec<(usize, String)> = group
        .layers
        .iter()
        .enumerate()
        .flat_map(|(number, layer)| {
            let names = layer.shader.symbols.iter().filter(|s| s.kind == SymbolKind::OutputParam);
            names
                .filter(|s| s.ty.struct_id().is_none())
                .map(move |s| (number, s.name.to_string()))
                .collect::<Vec<_>>()
        })
        .collect();
    let expected = Expected::of(&plain, outputs);
    expected.compare(&plain, codes, 0, text);
    expected.compare(&plan(true, wanted), codes, group.layers.len() - 1, text)
}

/// What the interpreter gives.
struct Expected {
    points: Vec<Point>,
    /// Layers and names.
    outputs: Vec<(usize, String)>,
    /// By point.
    given: Vec<Given1>,
}

impl Expected {
    fn of(plain: &Arc<Plan>, outputs: Vec<(usize, String)>) -> Self {
        let (world, points) = (World::default(), points(21));
        let mut machine = Machine::new(plain, &world);
        let mut run = |point| {
            machine.run(point);
            let mut list: Vec<Data> = Vec::new();
            for (layer, name) in &outputs {
                let (ty, data) = machine.output(Some(*layer), name).expect("an output");
                list.push(if ty == Type::CLOSURE { closure(&machine, &data) } else { data });
            }
            list.push(closure(&machine, &Data::Int(vec![machine.ci() as i32])));
            (list, std::mem::take(&mut machine.events))
        };
        let given = points.iter().map(&mut run).collect();
        Self { points, outputs, given }
    }

    /// With codes of a plan, and the outputs from a layer on.
    fn compare(&self, plan: &Arc<Plan>, codes: Codes, first: usize, text: &str) -> usize {
        let mut levels: Vec<_> =
            Level::available().into_iter().filter(|&level| Compiled::can(level)).collect();
        let mut widths = vec![Compiled::scalar, Compiled::new];
        if let Codes::Some(number) = codes {
            // Both halves of all numbers meet each level.
            let number = number as usize;
            widths = vec![widths[number % widths.len()]];
            levels = vec![levels[number / 2 % levels.len()]];
        }
        let mut left = 0;
        for make in widths {
            let mut known: Option<Compiled> = None;
            for &level in &levels {
                let made =
                    known.as_ref().map_or_else(|| make(plan.clone(), level), |code| code.for_level(level));
                match made {
                    Ok(code) => {
                        if code.lanes() > 1 {
                            self.compare_with(&code.paired().expect("as small as the other"), first, text);
                        }
                        self.compare_with(&code, first, text);
                        left = code.calls();
                        known = Some(code);
                    }
                    // A limit of machine code that a random program in twenty thousand meets: it is interpreted.
                    Err(why) if why.to_string().ends_with("values are needed at once") => {}
                    Err(why) => panic!("{why}\n{text}"),
                }
            }
        }
        left
    }

    /// With code.
    fn compare_with(&self, code: &Compiled, first: usize, text: &str) {
        let world = World::default();
        let mut lanes = Lanes::new(code, &world);
        for (batch, list) in self.points.chunks(code.lanes()).enumerate() {
            lanes.run_all(&list.chunks(LANES).map(rows).collect::<Vec<_>>());
            let mut heard = vec![Vec::new(); list.len()];
            lanes.take_events().into_iter().for_each(|(lane, event)| heard[lane].push(event));
            for (lane, heard) in heard.into_iter().enumerate() {
                let number = batch * code.lanes() + lane;
                let how = || format!("{}, {} lanes, point {number}", code.level(), code.lanes());
                let (values, told) = &self.given[number];
                for ((layer, name), value) in self.outputs.iter().zip(values).filter(|o| o.0.0 >= first) {
                    let (ty, data) = lanes.output(lane, Some(*layer), name).expect("an output");
                    let data = if ty == Type::CLOSURE { closure_of_lane(&lanes, lane, &data) } else { data };
                    assert!(same(value, &data), "{}: {name} is {data:?}, not {value:?}\n{text}", how());
                }
                let ci = closure_of_lane(&lanes, lane, &Data::Int(vec![lanes.ci(lane) as i32]));
                assert!(
                    values.last() == Some(&ci),
                    "{}: Ci is {ci:?}, not {:?}\n{text}",
                    how(),
                    values.last()
                );
                if first > 0 {
                    // Optimised layers may run in another order, and those that are not needed do not.
                    let mut rest = told.clone();
                    let is_told = heard.iter().all(|one| {
                        rest.iter().position(|other| other == one).map(|at| rest.remove(at)).is_some()
                    });
                    assert!(is_told, "{}: {heard:?} is said, not {told:?}\n{text}", how());
                } else {
                    assert_eq!(&heard, told, "{}: what is said\n{text}", how());
                }
            }
        }
    }
}

fn closure(machine: &Machine<'_>, data: &Data) -> Data {
    let Data::Int(list) = data else { return data.clone() };
    Data::Str(list.iter().map(|&n| reported(&|n| machine.components(n), n as u32).into()).collect())
}

fn closure_of_lane(lanes: &Lanes<'_>, lane: usize, data: &Data) -> Data {
    let Data::Int(list) = data else { return data.clone() };
    Data::Str(list.iter().map(|&n| reported(&|n| lanes.components(n, lane), n as u32).into()).collect())
}

/// A closure with all that lies in it: numbers of nodes are those of one engine only.
fn reported(components: &dyn Fn(u32) -> Vec<([f32; 3], Component)>, number: u32) -> String {
    let mut all = components(number);
    for (ty, data) in all.iter_mut().flat_map(|(_, part)| &mut part.params).map(|(_, ty, data)| (ty, data)) {
        if let (Type::CLOSURE, Data::Int(list)) = (*ty, &*data) {
            *data = Data::Str(list.iter().map(|&n| reported(components, n as u32).into()).collect());
        }
    }
    format!("{all:?}")
}
