// SPDX-License-Identifier: GPL-3.0-or-later
//! The language's library.
//!
//! One program for all files: each of its own takes a second to link.

mod colors;
mod derivatives;
mod dictionary;
mod gabor;
mod mathematics;
mod noise;
mod points;
mod regex;
mod splines;
mod strings;
mod vectors;
