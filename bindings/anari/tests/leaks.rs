// SPDX-License-Identifier: GPL-3.0-or-later
//! Memory after very many commits: a program of its own, whose memory nothing else uses.

use anari_library_gnurt::ffi_client::Client;
use anari_library_gnurt::types as t;

/// Kilobytes that the process holds.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4
}

#[test]
fn a_hundred_thousand_commits_leak_nothing() {
    let client = Client::new();
    let (geometry, material) = (client.object(t::GEOMETRY, "sphere"), client.object(t::MATERIAL, "matte"));
    let round = |count: usize| {
        for k in 0..count {
            let list = client.floats(t::FLOAT32_VEC3, &[k as f32, 0.0, 0.0]);
            client.give(geometry, "vertex.position", t::ARRAY1D, list);
            client.set_float(geometry, "radius", k as f32);
            client.commit(geometry);
            client.set_vec3(material, "color", [0.5; 3]);
            client.commit(material);
            let surface = client.object(t::SURFACE, "");
            client.set_object(surface, "geometry", t::GEOMETRY, geometry);
            client.set_object(surface, "material", t::MATERIAL, material);
            client.commit(surface);
            client.release(surface);
        }
    };
    round(2000);
    let (alive, before) = (client.alive(), resident());
    round(40_000);
    assert_eq!(client.alive(), alive, "120,000 commits later as many objects live");
    let grown = resident().saturating_sub(before);
    assert!(grown < 8 << 10, "{grown} KiB more memory");
    assert!(client.messages().iter().all(|message| message.severity > 4), "no complaint");
}
