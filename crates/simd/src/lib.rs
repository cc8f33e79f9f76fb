// SPDX-License-Identifier: GPL-3.0-or-later
//! SIMD lanes, masks and CPU levels: the only crate that names `core::arch` or a SIMD library.
