// SPDX-License-Identifier: GPL-3.0-or-later
//! Point clouds: `pointcloud_search`, `pointcloud_get`, `pointcloud_write`.
//! Source: the OSL specification, "Point clouds"; original. The library searches; the host has the files.
//! Results are always sorted; the lengths of arrays limit their number.
//! Tests: `tests/meaning/clouds.rs`.

use super::light::pairs;
use super::machine::{D, Machine, Step};
use super::slot::Slot;
use crate::types::{Base, Type};
use gnurt_sl_lib::Dual;
use gnurt_sl_lib::points::{Column, PointCloud, Values};
use std::sync::Arc;

/// The cloud of a name; none with a message, which is empty where the reason has been reported.
fn cloud(m: &mut Machine<'_>, s: &Step, file: &str) -> Option<Arc<PointCloud>> {
    if file.is_empty() {
        return None;
    }
    match m.host.point_cloud(file) {
        Ok(cloud) => Some(cloud),
        Err(why) => {
            if !why.is_empty() {
                m.error(format!("{}: {why}", s.code.name()));
            }
            None
        }
    }
}

/// Elements of an array; 1 for other types.
fn elements(slot: &Slot) -> usize {
    (slot.size / slot.one.max(1)) as usize
}

/// `pointcloud_search (file, point, radius, most [, sort], name, array, ...)`
pub(super) fn search(m: &mut Machine<'_>, s: &Step) {
    let [out, file, center, radius, most, rest @ ..] = &*s.args else { return };
    let rest = match rest {
        [sort, rest @ ..] if sort.ty == Type::INT => rest,
        rest => rest,
    };
    let capacity = rest.chunks_exact(2).map(|pair| elements(&pair[1])).min().unwrap_or(usize::MAX);
    let most = usize::try_from(m.int(most)).unwrap_or(0).min(capacity);
    let file = m.text(file);
    let Some(cloud) = cloud(m, s, &file) else {
        m.set_int(out, 0);
        return;
    };
    let center = m.triple(center);
    let found = cloud.nearest(center.map(|x| x.value), m.float(radius, 0), most);
    pairs(m, rest, |m, name, value| match (name, value.ty.base) {
        ("index", Base::Int) => {
            for (i, (number, _)) in found.iter().enumerate() {
                m.set_bits(value, i, *number);
            }
        }
        ("distance", Base::Float) => {
            for (i, &(number, distance)) in found.iter().enumerate() {
                m.set(value, i, away(center, cloud.positions()[number as usize], distance));
            }
        }
        _ => {
            let numbers = found.iter().map(|(number, _)| *number as usize);
            give(m, value, &file, &cloud, name, numbers);
        }
    });
    m.set_int(out, found.len() as i32);
}

/// The distance with its derivative by the searched position.
fn away(center: [D; 3], point: [f32; 3], distance: f32) -> D {
    if distance <= 0.0 {
        return distance.into();
    }
    let along = |part: fn(&D) -> f32| {
        let sum: f32 = (0..3).map(|k| (center[k].value - point[k]) * part(&center[k])).sum();
        sum / distance
    };
    Dual::new(distance, along(|x| x.dx), along(|x| x.dy))
}

/// Puts values of some points into an array; whether the cloud has them, of this kind.
fn give(
    m: &mut Machine<'_>,
    out: &Slot,
    file: &str,
    cloud: &PointCloud,
    name: &str,
    numbers: impl Iterator<Item = usize>,
) -> bool {
    let Some(column) = cloud.column(name) else {
        m.error(format!("Accessing unexisting attribute {name} in pointcloud \"{file}\""));
        return false;
    };
    let one = out.one as usize;
    let alike = match column.values {
        Values::Float(_) => out.ty.base.is_float_based(),
        Values::Int(_) => out.ty.base == Base::Int,
        Values::Text(_) => out.ty.base == Base::String,
    };
    if !alike || (one != column.width && one != 1) {
        let kind = match (&column.values, column.is_vector) {
            (_, true) => "vector".to_owned(),
            (Values::Float(_), _) => format!("float[{}]", column.width),
            (Values::Int(_), _) => format!("int[{}]", column.width),
            (Values::Text(_), _) => "string".to_owned(),
        };
        m.error(format!(
            "Type of attribute \"{name}\" : {kind} not compatible with OSL's {} in \"{file}\" pointcloud",
            out.ty
        ));
        return false;
    }
    let capacity = out.size as usize / column.width;
    for (i, number) in numbers.take(capacity).enumerate() {
        for k in 0..column.width {
            let (at, from) = (i * column.width + k, number * column.width + k);
            match &column.values {
                Values::Float(list) => m.set(out, at, list.get(from).copied().unwrap_or(0.0).into()),
                Values::Int(list) => m.set_bits(out, at, list.get(from).copied().unwrap_or(0) as u32),
                Values::Text(list) => m.set_text(out, at, list.get(from).map_or("", |text| text)),
            }
        }
    }
    true
}

/// `pointcloud_get (file, indices, count, name, array)`
pub(super) fn get(m: &mut Machine<'_>, s: &Step) {
    let [out, file, indices, count, name, data] = &*s.args else { return };
    let capacity = elements(indices).min(elements(data));
    let count = usize::try_from(m.int(count)).unwrap_or(0).min(capacity);
    let (file, name) = (m.text(file), m.text(name));
    let found = count == 0
        || cloud(m, s, &file).is_some_and(|cloud| {
            // A number of no point reads zeros.
            let numbers: Vec<usize> = (0..count)
                .map(|i| usize::try_from(m.cell_bits(indices, i) as i32).unwrap_or(usize::MAX >> 8))
                .collect();
            give(m, data, &file, &cloud, &name, numbers.into_iter())
        });
    m.set_int(out, i32::from(found));
}

/// `pointcloud_write (file, point, name, value, ...)`
pub(super) fn write(m: &mut Machine<'_>, s: &Step) {
    let [out, file, point, rest @ ..] = &*s.args else { return };
    let (file, point) = (m.text(file), m.triple_value(point));
    let (mut row, mut fits) = (Vec::new(), !file.is_empty());
    pairs(m, rest, |m, name, value| {
        let size = value.size as usize;
        let values = match value.ty.base {
            _ if value.ty.array != 0 => None,
            Base::Int => Some(Values::Int(vec![m.int(value)])),
            Base::String => Some(Values::Text(vec![m.text(value)])),
            base if base == Base::Float || base.is_triple() => {
                Some(Values::Float((0..size).map(|i| m.float(value, i)).collect()))
            }
            _ => None,
        };
        match values {
            Some(values) => row.push(Column { name: name.into(), width: size, is_vector: size == 3, values }),
            None => fits = false,
        }
    });
    if !file.is_empty() {
        match m.host.write_point(&file, point, &row) {
            Ok(written) => fits &= written,
            Err(why) => {
                fits = false;
                if !why.is_empty() {
                    m.error(format!("{}: {why}", s.code.name()));
                }
            }
        }
    }
    m.set_int(out, i32::from(fits));
}
