// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters of shaders as controls: adjustable values, their steps, and their ranges. Labels, ranges, steps
//! and widgets are OSL's metadata. A colour or point has a control for each number.
//! Tests: `tests`.

use gnurt::osl::{Parameter, ParameterValue, Script};

/// Steps from one end of a range to the other, if their size is not given.
const STEPS: f32 = 50.0;
/// Lines that are shown of all knobs.
const LINES: usize = 9;

/// A number that keys change.
#[derive(Clone, Debug, PartialEq)]
pub struct ShaderControl {
    /// The script's index among the stage's.
    pub(crate) script: usize,
    parameter: String,
    /// For people, with the letter of the number where there are several.
    label: String,
    /// The first of a parameter's controls stores all its current numbers; this one changes the number at
    /// this offset.
    component: usize,
    count: usize,
    value: f32,
    /// As it was when the scene was read.
    first: f32,
    range: Option<[f32; 2]>,
    step: f32,
    is_int: bool,
    /// Names of values, where only those are meant.
    options: Vec<(String, f32)>,
}

impl ShaderControl {
    /// The controls of a script with this index; `first` are its parameters when the scene was read.
    pub(crate) fn of(index: usize, script: &Script, first: &[Parameter]) -> Vec<Self> {
        let mut shader_controls = Vec::new();
        for parameter in script.parameters() {
            if !parameter.is_tunable || parameter.is_of_mesh || parameter.widget == "null" {
                continue;
            }
            let Some(values) = parameter.default.numbers() else { continue };
            let before = first.iter().find(|p| p.name == parameter.name);
            let before = before.and_then(|p| p.default.numbers()).filter(|list| list.len() == values.len());
            let is_int = matches!(parameter.default, ParameterValue::Ints(_));
            let options = options(&parameter);
            let name = if parameter.label.is_empty() { &parameter.name } else { &parameter.label };
            for (component, &value) in values.iter().enumerate() {
                shader_controls.push(Self {
                    script: index,
                    parameter: parameter.name.clone(),
                    label: match (values.len(), &parameter.ty[..]) {
                        (1, _) => name.clone(),
                        (3, "color") => format!("{name} {}", ["red", "green", "blue"][component]),
                        (3, _) => format!("{name} {}", ["x", "y", "z"][component]),
                        _ => format!("{name} {component}"),
                    },
                    component,
                    count: values.len(),
                    value,
                    first: before.as_ref().map_or(value, |list| list[component]),
                    range: parameter.range,
                    step: step(&parameter, value, is_int),
                    is_int,
                    options: options.clone(),
                });
            }
        }
        shader_controls
    }

    /// Changes it by this many steps, within its range; returns whether it changed.
    fn adjust_control(&mut self, steps: f32) -> bool {
        let value = if self.options.is_empty() {
            let value = self.value + steps * self.step;
            // Decimal steps stay decimal.
            let value = (value / self.step).round() * self.step;
            self.range.map_or(value, |[min, max]| value.clamp(min, max.max(min)))
        } else {
            let at = self.options.iter().position(|(_, value)| *value == self.value).unwrap_or(0) as isize;
            let last = self.options.len() as isize - 1;
            self.options[(at + steps.signum() as isize).clamp(0, last) as usize].1
        };
        let moved = value != self.value && value.is_finite();
        if moved {
            self.value = value;
        }
        moved
    }

    fn line(&self, is_chosen: bool) -> String {
        let mark = if is_chosen { '>' } else { ' ' };
        let option = self.options.iter().find(|(_, value)| *value == self.value);
        let value = match option {
            Some((name, _)) => name.clone(),
            None if self.is_int => format!("{}", self.value),
            None => format!("{:.4}", self.value),
        };
        let range = match self.range {
            Some([min, max]) if option.is_none() => format!("  ({min} to {max})"),
            _ => String::new(),
        };
        format!("{mark} {}  {value}{range}", self.label)
    }
}

/// The width of a step.
fn step(parameter: &Parameter, value: f32, is_int: bool) -> f32 {
    let wide = |[min, max]: [f32; 2]| ((max - min) / STEPS).max(f32::MIN_POSITIVE);
    // A decimal number near a twentieth of the value.
    let near = |x: f32| 10.0_f32.powf((x.abs() / 20.0).max(1e-6).log10().round());
    match (parameter.step, parameter.range) {
        _ if is_int => parameter.step.map_or(1.0, |step| step.round().max(1.0)),
        (Some(step), _) => step,
        (None, Some(range)) => wide(range),
        (None, None) if value == 0.0 => 0.05,
        (None, None) => near(value),
    }
}

/// The choices of a widget.
fn options(parameter: &Parameter) -> Vec<(String, f32)> {
    match &parameter.widget[..] {
        "checkBox" | "boolean" => vec![("off".into(), 0.0), ("on".into(), 1.0)],
        "mapper" => parameter
            .options
            .split('|')
            .filter_map(|option| {
                let (name, value) = option.rsplit_once(':')?;
                Some((name.trim().to_owned(), value.trim().parse().ok()?))
            })
            .collect(),
        _ => Vec::new(),
    }
}

/// All knobs of a stage, one of them chosen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ShaderControls {
    all: Vec<ShaderControl>,
    at: usize,
    /// Whether they are shown.
    pub shown: bool,
}

impl ShaderControls {
    /// Replaces the controls; the chosen one stays chosen if it still exists.
    pub(crate) fn replace(&mut self, all: Vec<ShaderControl>) {
        let key = |control: &ShaderControl| (control.script, control.parameter.clone(), control.component);
        let chosen = self.all.get(self.at).map(key);
        self.at = all.iter().position(|control| Some(key(control)) == chosen).unwrap_or(0);
        self.all = all;
    }

    /// Whether there are any.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Chooses the next one, or the one before.
    pub(crate) fn choose(&mut self, direction: isize) {
        let count = self.all.len() as isize;
        if count > 0 {
            self.at = (self.at as isize + direction).rem_euclid(count) as usize;
        }
        self.shown = true;
    }

    /// Changes the chosen one by this many steps; returns whether it changed.
    pub(crate) fn adjust_control(&mut self, steps: f32) -> bool {
        self.shown = true;
        self.all.get_mut(self.at).is_some_and(|control| control.adjust_control(steps))
    }

    /// Resets the chosen one to its first value; returns whether it changed.
    pub(crate) fn reset(&mut self) -> bool {
        let Some(control) = self.all.get_mut(self.at) else { return false };
        let moved = control.value != control.first;
        control.value = control.first;
        moved
    }

    /// The parameter of the chosen one: its script, its name and its value now.
    pub(crate) fn chosen(&self) -> Option<(usize, String, ParameterValue)> {
        let control = self.all.get(self.at)?;
        let begin = self.at - control.component;
        let numbers = self.all.get(begin..begin + control.count)?.iter().map(|control| control.value);
        let value = match control.is_int {
            true => ParameterValue::Ints(numbers.map(|x| x as i32).collect()),
            false => ParameterValue::Floats(numbers.collect()),
        };
        Some((control.script, control.parameter.clone(), value))
    }

    /// Those near the chosen one, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        if !self.shown {
            return Vec::new();
        }
        if self.all.is_empty() {
            return vec!["no shader has adjustable parameters".into()];
        }
        let begin = self.at.saturating_sub(LINES / 2).min(self.all.len().saturating_sub(LINES));
        let near = self.all.iter().enumerate().skip(begin).take(LINES);
        near.map(|(i, control)| control.line(i == self.at)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gnurt::osl::Access;

    fn shader_controls(parameters: &str) -> ShaderControls {
        let text = format!("surface s ({parameters}) {{ Ci = diffuse (N); }}");
        let script = Script::from_text("s.osl".as_ref(), &text, &Access::default()).expect("it compiles");
        let mut shader_controls = ShaderControls::default();
        shader_controls.replace(ShaderControl::of(3, &script, &script.parameters()));
        shader_controls
    }

    #[test]
    fn numbers_turn_in_their_steps_within_their_range() {
        let mut k = shader_controls(
            "float a = 0.5 [[ string label = \"Width\", float min = 0, float max = 1, float step = 0.1 ]], color c = 0.25,
             int n = 2 [[ int min = 1, int max = 3 ]], int on = 1 [[ string widget = \"checkBox\" ]],
             int kind = 7 [[ string widget = \"mapper\", string options = \"oak:5|ash:7|elm:9\" ]],
             float hidden = 1 [[ string widget = \"null\" ]], string name = \"x\", float mesh = 1 [[ int interpolated = 1 ]]",
        );
        assert!(k.lines().is_empty(), "not shown before somebody asks");
        let chosen =
            |k: &ShaderControls| k.chosen().map(|(_, name, value)| (name, value.numbers().expect("numbers")));
        assert!(k.adjust_control(3.0) && k.adjust_control(-1.0), "it moves");
        assert_eq!(chosen(&k), Some(("a".into(), vec![0.7])), "in decimal steps");
        assert!(k.adjust_control(99.0) && !k.adjust_control(1.0), "to its end");
        assert!(k.reset() && !k.reset());
        assert_eq!(chosen(&k), Some(("a".into(), vec![0.5])), "as it was");
        k.choose(2);
        assert!(k.adjust_control(1.0));
        assert_eq!(chosen(&k), Some(("c".into(), vec![0.25, 0.26, 0.25])), "one number of a colour");
        k.choose(2);
        assert!(k.adjust_control(1.0) && !k.adjust_control(1.0));
        assert_eq!(k.chosen(), Some((3, "n".into(), ParameterValue::Ints(vec![3]))), "an int stays one");
        k.choose(1);
        assert!(k.adjust_control(-10.0));
        assert_eq!(chosen(&k), Some(("on".into(), vec![0.0])), "off");
        k.choose(1);
        assert!(k.adjust_control(1.0) && !k.adjust_control(1.0));
        assert_eq!(chosen(&k), Some(("kind".into(), vec![9.0])), "the next option");
        let lines = k.lines();
        assert_eq!(lines.len(), 7, "all but what is hidden, no number, or the mesh's: {lines:?}");
        assert!(lines[0].contains("Width  0.5000  (0 to 1)") && lines[6] == "> kind  elm", "{lines:?}");
        k.choose(1);
        assert_eq!(chosen(&k), Some(("a".into(), vec![0.5])), "round");
    }

    #[test]
    fn steps_without_metadata_suit_the_number() {
        for (value, expected) in [("0", 0.05), ("1", 0.1), ("-300", 10.0), ("0.02", 0.001)] {
            let mut k = shader_controls(&format!("float a = {value}"));
            assert!(k.adjust_control(1.0));
            let (Some((.., now)), before) = (k.chosen(), value.parse::<f32>().expect("a number")) else {
                panic!("there is one")
            };
            let step = now.numbers().expect("numbers")[0] - before;
            assert!((step / expected - 1.0).abs() < 1e-3, "{value}: {step}, not {expected}");
        }
        assert_eq!(shader_controls("string only = \"x\"").lines(), Vec::<String>::new());
        let mut none = ShaderControls::default();
        none.choose(1);
        assert!(!none.adjust_control(1.0) && none.chosen().is_none() && none.lines().len() == 1, "says so");
    }
}
