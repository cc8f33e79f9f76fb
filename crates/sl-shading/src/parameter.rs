// SPDX-License-Identifier: GPL-3.0-or-later
//! Parameters of compiled scripts: their declarations, and values of their types. Labels and ranges are OSL's metadata.
//! Tests: `tests/scripts/wrong.rs`.

use gnurt_shading::script::{Parameter, ParameterValue};
use gnurt_sl::group::Value;
use gnurt_sl::hir::Data;
use gnurt_sl::ir::Symbol;
use gnurt_sl::types::{Base, Type};

/// Numbers of a parameter that is changed without compiling.
const MOST_NUMBERS: usize = 16;

fn number(data: &Data) -> Option<f32> {
    match data {
        Data::Float(list) => list.first().copied(),
        Data::Int(list) => list.first().map(|&x| x as f32),
        Data::Str(_) => None,
    }
}

/// The parameter of a symbol, with the value that it was given.
pub(crate) fn declared(symbol: &Symbol, value: Option<&Data>) -> Parameter {
    let meta = |name: &str| symbol.meta.iter().find(|m| &*m.name == name).map(|m| &m.value);
    let text = |name: &str| match meta(name) {
        Some(Data::Str(list)) => list.first().map(ToString::to_string).unwrap_or_default(),
        _ => String::new(),
    };
    let range = meta("min").and_then(number).zip(meta("max").and_then(number));
    let flag = |name: &str| symbol.flag(name);
    let size = symbol.ty.size();
    let default = match value.or(symbol.value.as_ref()) {
        Some(Data::Float(list)) => ParameterValue::Floats(list.clone()),
        Some(Data::Int(list)) => ParameterValue::Ints(list.clone()),
        Some(Data::Str(list)) => ParameterValue::Texts(list.iter().map(ToString::to_string).collect()),
        None => match symbol.ty.base {
            Base::Int => ParameterValue::Ints(vec![0; size]),
            Base::String => ParameterValue::Texts(vec![String::new(); size]),
            _ => ParameterValue::Floats(vec![0.0; size]),
        },
    };
    Parameter {
        name: symbol.name.to_string(),
        ty: symbol.ty.to_string(),
        default,
        label: text("label"),
        help: text("help"),
        rate: text("rate"),
        range: range.map(|(min, max)| [min, max]),
        step: meta("step").or(meta("sensitivity")).and_then(number).filter(|&x| x > 0.0),
        widget: text("widget"),
        options: text("options"),
        is_tunable: (symbol.ty.base == Base::Int || symbol.ty.base.is_float_based())
            && (value.is_some() || symbol.init.is_empty() && symbol.value.is_some())
            && (1..=MOST_NUMBERS).contains(&size)
            && !symbol.ty.is_array(),
        is_of_mesh: flag("lockgeom") == Some(0) || flag("interpolated") == Some(1),
    }
}

/// A value for a parameter of type `ty`: all its components, or one number for all of a single element.
pub(crate) fn value(ty: Type, given: &ParameterValue) -> Result<Value, String> {
    let size = if ty.array < 0 { usize::MAX } else { ty.size() };
    let (data, count): (Data, usize) = match (given, ty.base) {
        (ParameterValue::Ints(list), Base::Int) => (Data::Int(list.clone()), list.len()),
        (ParameterValue::Ints(list), base) if base.is_float_based() => {
            (Data::Float(list.iter().map(|&x| x as f32).collect()), list.len())
        }
        (ParameterValue::Floats(list), base) if base.is_float_based() => {
            (Data::Float(list.clone()), list.len())
        }
        (ParameterValue::Texts(list), Base::String) => {
            (Data::Str(list.iter().map(|text| text.as_str().into()).collect()), list.len())
        }
        _ => return Err(format!("it is of type {ty}")),
    };
    if let (Data::Float(list), 1, false) = (&data, count, ty.is_array()) {
        // One number for all components; for a matrix its diagonal.
        let all =
            (0..ty.size()).map(|i| if ty == Type::MATRIX && i % 5 != 0 { 0.0 } else { list[0] }).collect();
        return Ok(Value { ty, data: Data::Float(all) });
    }
    if ty.array < 0 {
        let components = ty.base.components().max(1);
        if count == 0 || count % components != 0 {
            return Err(format!("{count} values are not a list of {}", ty.element()));
        }
        return Ok(Value { ty: ty.array_of((count / components) as i32), data });
    }
    if count == size {
        return Ok(Value { ty, data });
    }
    let plural = if size == 1 { "" } else { "s" };
    Err(format!("{count} values are given, it is {size} number{plural} ({ty})"))
}

/// Parses a written value: numbers between commas, or a text.
pub(crate) fn read(ty: Type, text: &str) -> Result<ParameterValue, String> {
    let wrong = |what: &str| {
        let size = ty.size();
        let shape = match size {
            _ if ty.array < 0 => "between commas".to_owned(),
            1 => "one".to_owned(),
            _ if ty.is_array() => format!("{size} between commas"),
            _ => format!("{size} between commas, or one"),
        };
        format!("'{text}' is not {what} ({ty}: {shape})")
    };
    match ty.base {
        Base::String if ty.is_array() => {
            Ok(ParameterValue::Texts(text.split(',').map(str::to_owned).collect()))
        }
        Base::String => Ok(ParameterValue::Texts(vec![text.to_owned()])),
        Base::Int => {
            let list: Result<Vec<i32>, _> = text.split(',').map(|item| item.trim().parse()).collect();
            list.map(ParameterValue::Ints).map_err(|_| wrong("whole numbers"))
        }
        base if base.is_float_based() => {
            let list: Result<Vec<f32>, _> = text.split(',').map(|item| item.trim().parse()).collect();
            let list = list.map_err(|_| wrong("numbers"))?;
            let fits = ty.array < 0 || list.len() == 1 && !ty.is_array() || list.len() == ty.size();
            if fits { Ok(ParameterValue::Floats(list)) } else { Err(wrong("numbers")) }
        }
        _ => Err(format!("a {ty} cannot be given as text")),
    }
}
