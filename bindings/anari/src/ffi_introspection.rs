// SPDX-License-Identifier: GPL-3.0-or-later
//! Answers of introspection, in the form that C reads: strings, lists and values that live as long as the library.
//! Each answer is made at the first question and kept for ever. Properties of objects and parameters bound their number.
//! Tests: tests/introspection.rs.

use std::collections::HashMap;
use std::ffi::{CString, c_char, c_void};
use std::sync::{LazyLock, Mutex};

use crate::ffi_abi::ParameterName;
use crate::object::lock;
use crate::schema::{self, EXTENSIONS, Entry, Info, Parameter, Values};
use crate::types::{self, DataType};

/// A question: kind, subtype, parameter, its type, property, its type.
type Question = (DataType, String, String, DataType, String, DataType);

/// Answers so far, as addresses.
static KNOWN: LazyLock<Mutex<HashMap<Question, usize>>> = LazyLock::new(Mutex::default);

/// Values in memory that stays.
fn keep<T>(values: Vec<T>) -> usize {
    Box::leak(values.into_boxed_slice()).as_ptr() as usize
}

fn text(text: &str) -> usize {
    CString::new(text).unwrap_or_default().into_raw() as usize
}

/// A list of strings, ended by null.
fn texts<'a>(all: impl IntoIterator<Item = &'a str>) -> usize {
    keep(all.into_iter().map(text).chain([0]).collect())
}

fn value(info: &Info, kind: DataType) -> usize {
    match (info, kind) {
        (Info::Floats(floats), types::FLOAT64) => {
            keep(floats.iter().map(|&x| f64::from(x)).collect::<Vec<_>>())
        }
        (Info::Floats(floats), _) => keep(floats.clone()),
        (Info::Whole(number), types::UINT64) => keep(vec![*number]),
        (Info::Whole(number), _) => keep(vec![*number as u32]),
        (Info::Truth(truth), _) => keep(vec![i32::from(*truth)]),
        (Info::Text(word), _) => text(word),
    }
}

fn extension(name: &str, kind: DataType) -> usize {
    match kind {
        types::STRING if !name.is_empty() => text(name),
        types::INT32 => schema::extension_number(name).map_or(0, |number| keep(vec![number])),
        _ => 0,
    }
}

/// Something of a kind of object; 0 where there is none.
fn of_object(entry: &Entry, property: &str, kind: DataType) -> usize {
    let lists_extensions = [types::DEVICE, types::RENDERER].contains(&entry.kind);
    match (property, kind) {
        ("description", types::STRING) => text(entry.about),
        ("parameter", types::PARAMETER_LIST) => {
            let names = entry.parameters.iter().flat_map(|parameter| {
                let name = text(parameter.name) as *const c_char;
                parameter.types.iter().map(move |&kind| ParameterName { name, kind })
            });
            keep(names.chain([ParameterName { name: std::ptr::null(), kind: types::UNKNOWN }]).collect())
        }
        ("extension", types::STRING_LIST) if lists_extensions => extensions(),
        ("channel", types::STRING_LIST) if entry.kind == types::RENDERER => {
            let channels = ["color", "depth", "normal", "albedo", "primitiveId", "objectId", "instanceId"];
            texts(channels.map(|name| format!("channel.{name}")).iter().map(String::as_str))
        }
        ("sourceExtension", _) => extension(entry.extension, kind),
        _ => 0,
    }
}

/// Something of a parameter; 0 where there is none.
fn of_parameter(parameter: &Parameter, of: DataType, property: &str, kind: DataType) -> usize {
    let first = parameter.types.first() == Some(&of) && of == kind;
    let of_first = |info: &Option<Info>| info.as_ref().filter(|_| first).map_or(0, |info| value(info, kind));
    match property {
        "required" if kind == types::BOOL => keep(vec![i32::from(parameter.required)]),
        "default" => of_first(&parameter.default),
        "minimum" => of_first(&parameter.minimum),
        "maximum" => of_first(&parameter.maximum),
        "description" if kind == types::STRING => text(parameter.about),
        "use" if kind == types::STRING => parameter.meaning.map_or(0, text),
        "elementType" if kind == types::DATA_TYPE_LIST && !parameter.elements.is_empty() => {
            keep([&parameter.elements[..], &[types::UNKNOWN]].concat())
        }
        "value" => match (&parameter.values, of, kind) {
            (Values::Texts(words), types::STRING, types::STRING_LIST) => texts(words.iter().copied()),
            (Values::Types(kinds), types::DATA_TYPE, types::DATA_TYPE_LIST) => {
                keep([&kinds[..], &[types::UNKNOWN]].concat())
            }
            _ => 0,
        },
        "sourceExtension" => extension(parameter.extension, kind),
        _ => 0,
    }
}

/// The answer to a question, made by `make` if it is new; 0 is not kept.
fn answer(question: Question, make: impl FnOnce() -> usize) -> *const c_void {
    let mut known = lock(&KNOWN);
    let address = match known.get(&question) {
        Some(&address) => address,
        None => {
            let address = make();
            if address != 0 {
                known.insert(question, address);
            }
            address
        }
    };
    address as *const c_void
}

/// Subtypes of a kind, ended by null.
pub(crate) fn subtypes(kind: DataType) -> *const c_void {
    let question = (kind, String::new(), String::new(), 0, "subtypes".to_owned(), 0);
    answer(question, || texts(schema::subtypes(kind)))
}

/// The extensions, ended by null.
pub(crate) fn extensions() -> usize {
    static ALL: LazyLock<usize> = LazyLock::new(|| texts(EXTENSIONS.map(|name| name.trim_end_matches('\0'))));
    *ALL
}

/// Something of a kind of object, or null.
pub(crate) fn object_info(kind: DataType, subtype: &str, property: &str, of: DataType) -> *const c_void {
    let Some(entry) = schema::find(kind, subtype) else { return std::ptr::null() };
    let question = (kind, entry.subtype.to_owned(), String::new(), 0, property.to_owned(), of);
    answer(question, || of_object(entry, property, of))
}

/// Something of a parameter, or null.
pub(crate) fn parameter_info(
    (kind, subtype): (DataType, &str),
    (name, of): (&str, DataType),
    (property, info): (&str, DataType),
) -> *const c_void {
    let Some(entry) = schema::find(kind, subtype) else { return std::ptr::null() };
    let Some(parameter) = entry.parameters.iter().find(|parameter| parameter.name == name) else {
        return std::ptr::null();
    };
    let question = (kind, entry.subtype.to_owned(), name.to_owned(), of, property.to_owned(), info);
    answer(question, || of_parameter(parameter, of, property, info))
}
