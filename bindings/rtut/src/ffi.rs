// SPDX-License-Identifier: GPL-3.0-or-later
//! The exported functions, and the functions of libOpenRT that they call.
//! Nothing here can panic: arguments out of range give nothing. Only exceptions of the program's
//! rtDebugCallback unwind through here. Tests: tests/c/shapes.c.

use crate::sink::{Mode, Sink, Vertex};

unsafe extern "C-unwind" {
    safe fn rtBegin(mode: u32);
    safe fn rtEnd();
    safe fn rtNormal3d(x: f64, y: f64, z: f64);
    safe fn rtTexCoord2d(s: f64, t: f64);
    safe fn rtVertex3d(x: f64, y: f64, z: f64);
}

/// The process's libOpenRT.
struct Library;

impl Sink for Library {
    fn begin(&mut self, mode: Mode) {
        rtBegin(mode as u32);
    }

    fn vertex(&mut self, Vertex { position: [x, y, z], normal: [nx, ny, nz], texcoord: [s, t] }: Vertex) {
        rtTexCoord2d(s, t);
        rtNormal3d(nx, ny, nz);
        rtVertex3d(x, y, z);
    }

    fn end(&mut self) {
        rtEnd();
    }
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutSphere(slices: i32, stacks: i32) {
    crate::sphere::sphere(&mut Library, slices, stacks);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutCube() {
    crate::cube::cube(&mut Library);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutTorus(tube: f64, middle: f64, sides: i32, rings: i32) {
    crate::torus::torus(&mut Library, [tube, middle], sides, rings);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutTeapot(size: f64) {
    crate::teapot::teapot(&mut Library, size);
}

#[unsafe(no_mangle)]
extern "C-unwind" fn rtutLogo() {
    crate::logo::logo(&mut Library);
}
