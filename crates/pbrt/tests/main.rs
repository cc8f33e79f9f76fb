// SPDX-License-Identifier: GPL-3.0-or-later
//! The reader from files to scenes. One program for all files: each of its own takes a second to link.

mod broken;
mod common;
mod lights;
mod materials;
mod media;
mod motion;
mod shapes;
mod textures;
mod view;
mod volumes;
