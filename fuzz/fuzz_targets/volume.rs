// SPDX-License-Identifier: GPL-3.0-or-later
//! Any bytes as a file of OpenVDB or NanoVDB: grids that can be read everywhere, or one error of one line.
#![no_main]

/// The memory limit of a file's voxels.
const MOST_BYTES: usize = 256 << 20;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    match gnurt_image::Volume::decode(bytes, MOST_BYTES) {
        Ok(volume) => {
            for grid in volume.grids() {
                let corners = grid.window().unwrap_or([[i32::MIN; 3], [i32::MAX; 3]]);
                for at in [corners[0], corners[1], [0; 3], [-1, 4095, 4096]] {
                    std::hint::black_box(grid.voxel(at));
                }
            }
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
    }
});
