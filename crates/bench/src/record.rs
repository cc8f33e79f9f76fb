// SPDX-License-Identifier: GPL-3.0-or-later
//! A record of a run of `bench rays`: measurements, machine, its load, every round's rate and the compared
//! engines. Source: proc(5). Units as in [`Row`]. Tests: `tests::a_record_says_it_all`.

use serde_json::{Map, Value, json};

use crate::options::Options;
use crate::pin::Pinned;
use crate::pools::POOLS;
use crate::row::to_json as rows_to_json;
use crate::{Class, Row};

/// How busy the machine is: programs that ran or waited over the last minute. `None` where the system does
/// not report it.
#[must_use]
pub fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// The name of the processor, where the system reports it.
fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

/// An object: `rows` are those of [`to_json`](crate::to_json), and `rates` are next to them. `embree` is the
/// version of Embree, and `load_before` the result of [`load`] before the run.
#[must_use]
pub fn to_json(options: &Options, embree: Option<i64>, load_before: Option<f64>, rows: &[Row]) -> Value {
    let mut reported = rows_to_json(rows);
    for (value, row) in reported.as_array_mut().into_iter().flatten().zip(rows) {
        value["rates"] = json!(row.rates);
    }
    json!({
        "program": concat!("gnurt ", env!("CARGO_PKG_VERSION")),
        "processor": processor(),
        "cores": gnurt::cores(),
        "load_before": load_before,
        "load_after": load(),
        "embree": embree,
        "isa": options.level.name(),
        "threads": options.threads,
        "pinned": Pinned::thread(0, options.threads).is_pinned(),
        "size": options.size,
        "rounds": options.rounds,
        "batch": options.batch,
        "order": "rotated each round, every other one backwards",
        "rows": reported,
        "ratios": ratios(rows),
    })
}

/// By pool, class and scene: the winner on either side, their numbers, and our rate over Embree's.
fn ratios(rows: &[Row]) -> Value {
    let mut all = Vec::new();
    for class in Class::ALL {
        let mut scenes: Vec<&str> = Vec::new();
        for row in rows.iter().filter(|row| row.class == class) {
            if !scenes.contains(&&row.scene[..]) {
                scenes.push(&row.scene);
            }
        }
        for scene in scenes {
            let these: Vec<Row> =
                rows.iter().filter(|row| row.class == class && row.scene == scene).cloned().collect();
            let mut value = Map::new();
            for pool in POOLS {
                let sides = pool.of(&these);
                if let Some([own, embree]) = sides.winners() {
                    let reported = json!({
                        "gnurt": own.mode, "embree4": embree.mode, "modes": sides.own.len(),
                        "ratio": own.mrays_cpu / embree.mrays_cpu,
                    });
                    value.insert(pool.name.into(), reported);
                }
            }
            all.push(json!({ "class": class.name(), "scene": scene, "pools": value }));
        }
    }
    Value::Array(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::sample;

    #[test]
    fn a_record_says_it_all() {
        let rows = [
            sample("a", Class::Ao, "gnurt", "bvh-medium-one", 6.0),
            sample("a", Class::Ao, "embree4", "robust-1", 3.0),
            sample("b", Class::Ao, "embree4", "robust-1", 3.0),
        ];
        let value = to_json(&Options::default(), Some(40_400), Some(0.5), &rows);
        assert_eq!(value["embree"], 40_400, "{value}");
        assert_eq!(value["rows"][0]["rates"].as_array().map(Vec::len), Some(5), "every round: {value}");
        assert_eq!(value["rows"][0]["mrays_cpu"], 6.0, "beside what rows always hold");
        let ratios = &value["ratios"];
        assert_eq!(ratios.as_array().map(Vec::len), Some(2), "each scene once: {ratios}");
        assert_eq!(ratios[0]["pools"]["med/rob"]["ratio"], 2.0, "{ratios}");
        assert_eq!(ratios[1]["pools"], json!({}), "nobody to compare with");
        assert!(value["cores"].as_u64().is_some_and(|cores| cores > 0), "{value}");
    }
}
