// SPDX-License-Identifier: GPL-3.0-or-later
//! Runs the group for all points.
//! The order of output is that of OSL's `testshade`.

use super::options::{Options, Setup};
use super::report::{Recent, report};
use super::world::World;
use crate::console::Console;
use crate::picture::Picture;
use gnurt_sl::engine::Batch;
use gnurt_sl::exec::{Event, LANES, Machine, Plan, PlanOptions, Points};
use gnurt_sl::format::general;
use gnurt_sl::group::Group;
use gnurt_sl::hir::Data;
use gnurt_sl::ir::{SymId, SymbolKind, ops, uses};
use gnurt_sl::opcode::Opcode;
use gnurt_sl::types::Type;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A requested output that was found.
struct Output {
    name: String,
    file: String,
    layer: usize,
    ty: Type,
    pixels: Vec<f32>,
}

fn flag(list: &str, name: &str, default: bool) -> bool {
    let found = list.split(',').filter_map(|text| text.split_once('=')).find(|(n, _)| n.trim() == name);
    found.map_or(default, |(_, v)| v.trim() != "0")
}

fn find_outputs(options: &Options, group: &Group) -> Vec<Output> {
    let default = [("Cout".to_owned(), "null".to_owned())];
    let outputs_to_save: &[(String, String)] =
        if options.outputs.is_empty() { &default } else { &options.outputs };
    let mut out = Vec::new();
    for (name, file) in outputs_to_save {
        let (layer, var) = name.split_once('.').map_or((None, name.as_str()), |(l, v)| (Some(l), v));
        let found = group.layers.iter().enumerate().rev().find_map(|(number, l)| {
            if layer.is_some_and(|outputs_to_save| outputs_to_save != &*l.name) {
                return None;
            }
            let id = l.shader.find(var).filter(|&id| l.shader.symbol(id).kind == SymbolKind::OutputParam)?;
            Some((number, l.shader.symbol(id).ty))
        });
        if let Some((layer, ty)) = found {
            out.push(Output { name: var.to_owned(), file: file.clone(), layer, ty, pixels: Vec::new() });
        }
    }
    out
}

fn plan(group: &Group, options: &Options, entries: &[usize], console: &mut Console<'_>) -> Option<Plan> {
    let default = PlanOptions::default();
    let outputs_to_save = if options.outputs.is_empty() {
        vec!["Cout".to_owned()]
    } else {
        options.outputs.iter().map(|o| o.0.clone()).collect()
    };
    let plan_options = PlanOptions {
        outputs: outputs_to_save,
        lazy_globals: flag(&options.extra, "lazyglobals", default.lazy_globals),
        lazy_trace: flag(&options.extra, "lazytrace", default.lazy_trace),
        lazy_error: flag(&options.extra, "lazyerror", default.lazy_error),
        lazy_layers: flag(&options.extra, "lazylayers", default.lazy_layers),
        lazy_unconnected: flag(&options.extra, "lazyunconnected", default.lazy_unconnected),
        userdata_isconnected: options.userdata_isconnected,
        debug_layers: flag(&options.extra, "llvm_debug_layers", false),
        entries: entries.to_vec(),
        // Messages have the numbers of operations as they were compiled.
        optimise: !options.debug_uninit,
        ..PlanOptions::default()
    };
    match Plan::new(group, &plan_options) {
        Ok(plan) => Some(plan),
        Err(message) => {
            console.complain(&format!("ERROR: {message}\n"));
            None
        }
    }
}

/// Shades, prints and saves; returns the exit status.
pub(super) fn shade(options: &Options, mut group: Group, console: &mut Console<'_>) -> i32 {
    if !options.outputs.is_empty() {
        console.print("\n");
    }
    let mut entries = Vec::new();
    if !options.entries.is_empty() {
        console.print("Entry layers:");
        for name in &options.entries {
            let found = group.find(name);
            console.print(&format!(" {name}({})", found.map_or(-1, |n| n as i64)));
            entries.extend(found);
        }
        console.print("\n");
    }
    let mut outputs = find_outputs(options, &group);
    // OSL's tool prints no message for either, and succeeds.
    let mut missing = Vec::new();
    if !console.link {
        let is_there = |(name, file): &&(String, String)| {
            let var = name.split_once('.').map_or(name.as_str(), |(_, var)| var);
            outputs.iter().any(|o| (o.name.as_str(), &o.file) == (var, file))
        };
        missing.extend(options.outputs.iter().filter(|o| !is_there(o)).map(|(name, _)| name.clone()));
        missing.iter().for_each(|name| console.complain(&format!("ERROR: no shader has an output {name}\n")));
    }
    let is_whole = console.link || (missing.is_empty() && !group.layers.is_empty());
    for (output, requested) in outputs.iter().map(|o| (o, &o.file)) {
        if requested != "null" {
            let name = options.outputs.iter().find(|o| o.1 == *requested).map_or(&output.name, |o| &o.0);
            console.print(&format!("Output {name} to {requested}\n"));
        }
    }
    let mut starts = entries.clone();
    if !options.entry_outputs.is_empty() {
        starts.clear();
        console.print("Entry outputs:");
        for name in &options.entry_outputs {
            let (layer, var) = name.split_once('.').map_or((None, name.as_str()), |(l, v)| (Some(l), v));
            let found = group
                .layers
                .iter()
                .rposition(|l| layer.is_none_or(|n| n == &*l.name) && l.shader.find(var).is_some());
            let Some(found) = found else {
                console.print(&format!("\nEntry output {name} not found. Abording.\n"));
                return 1;
            };
            starts.push(found);
            console.print(&format!(" {name}"));
        }
        console.print("\n");
    }
    if options.debug {
        globals(&group, console);
    }
    let world = World::new(options, console.textures);
    let repeats = flag(&options.extra, "error_repeats", false);
    let mut recent = Recent::default();
    let mut messages: Vec<Event> = Vec::new();
    for iteration in 0..options.iterations {
        if group.layers.is_empty() {
            break;
        }
        let Some(plan) = plan(&group, options, &entries, console) else { return 1 };
        let plan = Arc::new(plan);
        if iteration == 0 && flag(&options.extra, "opt_warnings", false) {
            warn(&plan, options, console);
        }
        let last = iteration + 1 == options.iterations;
        let mut run = Run { options, world: &world, entries: &starts, outputs: &mut outputs, last };
        match run.all(&plan, console) {
            Ok(mut events) => messages.append(&mut events),
            Err(message) => {
                console.complain(&format!("ERROR: {message}\n"));
                return 1;
            }
        }
        if !last {
            for step in &options.setup {
                if let Setup::Reparam(layer, param, value) = step
                    && let Err(message) = group.reparameter(layer, param, value)
                {
                    console.complain(&format!("ERROR: {message}\n"));
                }
            }
        }
    }
    report(&messages, repeats, &mut recent, console);
    let unwritten = world.save();
    unwritten.iter().for_each(|why| console.complain(&format!("ERROR: {why}\n")));
    let only = if options.outputs.is_empty() { "null" } else { &options.outputs[0].1 };
    if options.outputs.len() <= 1 && only == "null" {
        console.print("\n");
    }
    match save(options, &outputs, console) {
        0 if !unwritten.is_empty() || !is_whole => 1,
        status => status,
    }
}

/// One pass over all points.
struct Run<'a> {
    options: &'a Options,
    world: &'a World<'a>,
    entries: &'a [usize],
    outputs: &'a mut [Output],
    /// Whether the outputs of this pass are stored.
    last: bool,
}

impl Run<'_> {
    /// By the requested engine; by the interpreter where that cannot run the group.
    fn all(&mut self, plan: &Arc<Plan>, console: &mut Console<'_>) -> Result<Vec<Event>, String> {
        let name = self.options.engine.as_str();
        let mut messages = Vec::new();
        let start = Instant::now();
        // Only the interpreter checks each operand and result.
        let checks = self.options.debug_nan || self.options.debug_uninit;
        if !matches!(name, "" | "interpreter") && !checks {
            let Some(engine) = console.engine else {
                return Err(format!("this program has no engine '{name}'; it has: interpreter"));
            };
            let world = self.world;
            let mut ready = None;
            let made = engine(name, plan, world, &mut |batch| {
                ready = Some(Instant::now());
                self.batches(batch, &mut messages, console);
            });
            match (made, ready) {
                (Ok(()), Some(ready)) => {
                    let (compiled, ran) = (ready - start, ready.elapsed());
                    self.times(
                        name,
                        &format!("compiled in {:.3} ms, ", 1e3 * compiled.as_secs_f64()),
                        ran,
                        console,
                    );
                    return Ok(messages);
                }
                (Err(why), _) if self.options.times => {
                    console.complain(&format!("{name}: {why}; interpreted\n"))
                }
                _ => {}
            }
        }
        let start = Instant::now();
        let mut machine = Machine::new(plan, self.world);
        if self.options.debug_nan {
            machine.check_numbers();
        }
        if self.options.debug_uninit {
            machine.check_reads_of_unwritten();
        }
        self.points(&mut machine, console);
        self.times("interpreter", "", start.elapsed(), console);
        Ok(std::mem::take(&mut machine.events))
    }

    fn times(&self, name: &str, compiled: &str, ran: Duration, console: &mut Console<'_>) {
        if self.options.times {
            let [width, height] = self.options.size;
            let each = ran.as_secs_f64() * 1e9 / (width * height) as f64;
            let run = 1e3 * ran.as_secs_f64();
            console.complain(&format!("{name}: {compiled}run in {run:.3} ms, {each:.1} ns a point\n"));
        }
    }

    fn points(&mut self, machine: &mut Machine<'_>, console: &mut Console<'_>) {
        let [width, height] = self.options.size;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let point = self.world.point(self.options, x, y);
            if self.entries.is_empty() {
                machine.run(&point);
            } else {
                machine.begin(&point);
                for &layer in self.entries {
                    machine.run_layer(layer);
                }
            }
            self.keep([x, y], &|output| machine.output(Some(output.layer), &output.name), console);
        }
    }

    fn batches(&mut self, batch: &mut dyn Batch, messages: &mut Vec<Event>, console: &mut Console<'_>) {
        let [width, height] = self.options.size;
        let all: Vec<[usize; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
        let mut points = vec![Points::default(); batch.lanes().div_ceil(LANES)];
        for point_indices in all.chunks(batch.lanes()) {
            for (points, point_indices) in points.iter_mut().zip(point_indices.chunks(LANES)) {
                points.count = point_indices.len();
                for (lane, &[x, y]) in point_indices.iter().enumerate() {
                    points.set(lane, &self.world.point(self.options, x, y));
                }
            }
            let points = &points[..point_indices.len().div_ceil(LANES)];
            if self.entries.is_empty() {
                batch.run(points);
            } else {
                batch.begin(points);
                for &layer in self.entries {
                    batch.layer(layer);
                }
            }
            messages.extend(batch.take_events().into_iter().map(|(_, event)| event));
            for (lane, &position) in point_indices.iter().enumerate() {
                self.keep(position, &|output| batch.output(lane, output.layer, &output.name), console);
            }
        }
    }

    fn keep(
        &mut self,
        [x, y]: [usize; 2],
        value: &dyn Fn(&Output) -> Option<(Type, Data)>,
        console: &mut Console<'_>,
    ) {
        if !self.last {
            return;
        }
        if self.options.print {
            console.print(&format!("Pixel ({x}, {y}):\n"));
        }
        for output in &mut *self.outputs {
            let value = value(output);
            keep(self.options, value, output, console);
        }
    }
}

fn keep(options: &Options, value: Option<(Type, Data)>, output: &mut Output, console: &mut Console<'_>) {
    let (tokens, numbers): (Vec<String>, Vec<f32>) = match value {
        Some((_, Data::Float(list))) => (list.iter().map(|&f| general(f64::from(f), 6)).collect(), list),
        Some((_, Data::Int(list))) => {
            // Pictures hold ints as parts of the largest one.
            let parts = list.iter().map(|&v| v as f32 / i32::MAX as f32).collect();
            (list.iter().map(ToString::to_string).collect(), parts)
        }
        _ => return,
    };
    if options.print {
        console.print(&format!("  {} : {}\n", output.name, tokens.join(" ")));
    }
    output.pixels.extend(numbers);
}

fn save(options: &Options, outputs: &[Output], console: &mut Console<'_>) -> i32 {
    for output in outputs.iter().filter(|o| !options.print && o.file != "null" && !o.pixels.is_empty()) {
        let [width, height] = options.size;
        let channels = output.ty.size();
        let picture = Picture { width, height, channels, values: output.pixels.clone() };
        if let Err(message) = picture.save(&output.file, &options.format) {
            console.complain(&format!("ERROR: {message}\n"));
            return 1;
        }
    }
    0
}

/// Which globals the group requests.
fn globals(group: &Group, console: &mut Console<'_>) {
    let mut names: Vec<String> = Vec::new();
    let mut add = |name: &str| {
        if !names.iter().any(|n| n == name) {
            names.push(name.to_owned());
        }
    };
    for layer in &group.layers {
        uses(&layer.shader.code, &mut |id, _| {
            let symbol = layer.shader.symbol(id);
            if symbol.kind == SymbolKind::Global {
                add(&symbol.name);
            }
        });
        ops(&layer.shader.code, &mut |op| match op.code {
            Opcode::Backfacing => add("backfacing"),
            Opcode::SurfaceArea => add("surfacearea"),
            Opcode::CalculateNormal => add("flipHandedness"),
            _ => {}
        });
    }
    console.print(&format!("Need {} globals:  {}\n", names.len(), names.join(" ")));
}

/// Warns about values that were unknown before the group runs, and cost time therefore.
fn warn(plan: &Plan, options: &Options, console: &mut Console<'_>) {
    let waits = flag(&options.extra, "lazyerror", true);
    for layer in &plan.layers {
        let shader = &layer.shader;
        let constant = |id: Option<&SymId>| {
            id.is_some_and(|&id| {
                shader.symbol(id).kind == SymbolKind::Const || layer.constant.get(id as usize) == Some(&true)
            })
        };
        ops(&shader.code, &mut |op| {
            let issue = match op.code {
                Opcode::Error if !waits => "call present in optimized shader.",
                Opcode::Texture | Opcode::Texture3d | Opcode::Environment | Opcode::GetTextureInfo
                    if !constant(op.args.get(1)) =>
                {
                    "texture name cannot be converted to a handle."
                }
                Opcode::Format | Opcode::Concat | Opcode::Substr if !constant(op.args.first()) => {
                    "new string creation couldn't be optimized to a constant."
                }
                Opcode::Strlen
                | Opcode::Getchar
                | Opcode::Startswith
                | Opcode::Endswith
                | Opcode::Stoi
                | Opcode::Stof
                | Opcode::RegexSearch
                | Opcode::RegexMatch
                    if !constant(op.args.first()) =>
                {
                    "need for string characters couldn't be optimized away."
                }
                _ => return,
            };
            let file = shader.files.get(usize::from(op.at.file)).map_or("", |f| f);
            let colon = if op.code == Opcode::Error { "" } else { ":" };
            console.complain(&format!(
                "WARNING: Optimization warning:\n  group:  {}\n  layer:  {}\n  source: {file}:{}\n  issue:  {}(){colon} {issue}\n",
                plan.name, layer.name, op.at.line, op.code.name()
            ));
        });
    }
}
