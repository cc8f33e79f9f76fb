// SPDX-License-Identifier: GPL-3.0-or-later
//! Named spectra of pbrt-v4 in the few numbers that renderers of three colours need.
//! Source: white points of CIE 15; refractive indices and Abbe's numbers of Schott's catalogue; measured metals after Palik and
//! Johnson & Christy, reduced so that reflectances at normal incidence under D65 are exact (`spectrum::metal`).
//! D65 is the CIE's table, every 10 nm.

/// CIE standard illuminant D65 from 380 to 780 nm, every 10 nm.
pub(crate) const D65: [f32; 41] = [
    49.98, 54.65, 82.75, 91.49, 93.43, 86.68, 104.86, 117.01, 117.81, 114.86, 115.92, 108.81, 109.35, 107.80,
    104.79, 107.69, 104.41, 104.05, 100.00, 96.33, 95.79, 88.69, 90.01, 89.60, 87.70, 83.29, 83.70, 80.03,
    80.21, 82.28, 78.28, 69.72, 71.61, 74.35, 61.60, 69.89, 75.09, 63.59, 46.42, 66.81, 63.38,
];

/// A metal: indices and extinction coefficients per channel.
pub(crate) struct Metal {
    pub(crate) name: &'static str,
    pub(crate) eta: [f32; 3],
    pub(crate) k: [f32; 3],
}

/// The metals, and two oxides.
pub(crate) const METALS: [Metal; 7] = [
    Metal { name: "Ag", eta: [0.128, 0.124, 0.151], k: [4.086, 3.329, 2.408] },
    Metal { name: "Al", eta: [1.407, 0.927, 0.584], k: [7.679, 6.598, 5.329] },
    Metal { name: "Au", eta: [0.05, 0.405, 1.561], k: [4.9, 2.339, 1.718] },
    Metal { name: "Cu", eta: [0.104, 0.978, 1.205], k: [2.847, 2.624, 2.361] },
    Metal { name: "CuZn", eta: [0.418, 0.520, 1.123], k: [4.061, 2.659, 1.810] },
    Metal { name: "MgO", eta: [1.733, 1.741, 1.753], k: [0.0; 3] },
    Metal { name: "TiO2", eta: [2.860, 2.957, 3.185], k: [0.0; 3] },
];

/// Glasses: their names, index for yellow light (587.6 nm) and Abbe's number.
pub(crate) const GLASSES: [(&str, f32, f32); 7] = [
    ("glass-BK7", 1.5168, 64.17),
    ("glass-BAF10", 1.6700, 47.11),
    ("glass-FK51A", 1.4866, 84.47),
    ("glass-LASF9", 1.8503, 32.17),
    ("glass-F5", 1.6727, 32.25),
    ("glass-F10", 1.7283, 28.41),
    ("glass-F11", 1.7847, 25.76),
];

/// Illuminants by their chromaticities.
pub(crate) const ILLUMINANTS: [(&str, [f32; 2]); 16] = [
    ("stdillum-A", [0.447_57, 0.407_45]),
    ("stdillum-D50", [0.345_67, 0.358_50]),
    ("stdillum-D65", [0.312_71, 0.329_02]),
    ("stdillum-F1", [0.313_10, 0.337_27]),
    ("stdillum-F2", [0.372_08, 0.375_29]),
    ("stdillum-F3", [0.409_10, 0.394_30]),
    ("stdillum-F4", [0.440_18, 0.403_29]),
    ("stdillum-F5", [0.313_79, 0.345_31]),
    ("stdillum-F6", [0.377_90, 0.388_35]),
    ("stdillum-F7", [0.312_92, 0.329_33]),
    ("stdillum-F8", [0.345_88, 0.358_75]),
    ("stdillum-F9", [0.374_17, 0.372_81]),
    ("stdillum-F10", [0.346_09, 0.359_86]),
    ("stdillum-F11", [0.380_52, 0.377_13]),
    ("stdillum-F12", [0.436_95, 0.404_41]),
    ("illum-acesD60", [0.321_68, 0.337_67]),
];
