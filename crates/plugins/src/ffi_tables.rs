// SPDX-License-Identifier: GPL-3.0-or-later
//! A plugin's tables, made of arbitrary bytes: an accepted one has every guarantee of `PluginClass`. For the
//! tests and for fuzz/fuzz_targets/plugin_tables.rs.
//! Invariant: pointers are null or valid, as rts.h requires of plugins; every number and text is arbitrary.
//! Tests: `tests`.

use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;
use std::sync::Arc;

use gnurt::shading::classes::ParameterRate;

use crate::class::PluginClass;
use crate::data_type::DataType;
use crate::ffi_block::PluginBlock;
use crate::ffi_library::Library;
use crate::ffi_rts::{Class, Ctx, Hits, Host, Module, Param, RTS_ABI, Rays, Vec3In, Vec3Out};
use crate::frame::PluginFrame;
use crate::frame_state::FrameState;
use crate::load::class_of;

/// Bytes that become numbers; zeros when they run out.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn byte(&mut self) -> u8 {
        let (first, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        *first
    }

    /// Any number, valid ones more often than others.
    fn number(&mut self, meaning: &[u32]) -> u32 {
        let choice = self.byte() as usize;
        match meaning.get(choice % (meaning.len() + 1)) {
            Some(&number) => number,
            None => u32::from_le_bytes([(); 4].map(|()| self.byte())),
        }
    }

    /// A name, or none: few, so that some are the same.
    fn name(&mut self) -> Option<CString> {
        let letters = match self.byte() % 8 {
            0 => return None,
            1 => vec![],
            2 => vec![0xFF, 0xFE],
            3 => vec![b'x'; 300],
            n => vec![b'a' + n],
        };
        CString::new(letters).ok()
    }

    fn flag(&mut self) -> bool {
        // More often than not.
        !self.byte().is_multiple_of(4)
    }
}

fn pointer(name: Option<&CString>) -> *const c_char {
    name.map_or(ptr::null(), |name| name.as_ptr())
}

/// A callback that is called with the block that it may write.
unsafe extern "C-unwind" fn init(_block: *mut c_void) {}
unsafe extern "C-unwind" fn prepare(_host: *const Host, _block: *mut c_void) -> c_int {
    0
}
unsafe extern "C-unwind" fn shade(_host: *const Host, _ctx: *mut Ctx, _hits: *const Hits, _out: Vec3Out) {}
unsafe extern "C-unwind" fn miss(
    _host: *const Host,
    _ctx: *mut Ctx,
    _block: *const c_void,
    _rays: *const Rays,
    _out: Vec3Out,
) {
}
unsafe extern "C-unwind" fn illuminate(
    _host: *const Host,
    _ctx: *mut Ctx,
    _block: *const c_void,
    _n: u32,
    _p: Vec3In,
    _dir: Vec3Out,
    _dist: *mut f32,
    _radiance: Vec3Out,
    _lit: *mut u8,
) {
}
unsafe extern "C-unwind" fn camera(
    _host: *const Host,
    _ctx: *mut Ctx,
    _block: *const c_void,
    _n: u32,
    _x: *const f32,
    _y: *const f32,
    _org: Vec3Out,
    _dir: Vec3Out,
) {
}

unsafe extern "C-unwind" fn camera_lens(
    _host: *const Host,
    _ctx: *mut Ctx,
    _block: *const c_void,
    _n: u32,
    _x: *const f32,
    _y: *const f32,
    _lens_x: *const f32,
    _lens_y: *const f32,
    _time: *const f32,
    _org: Vec3Out,
    _dir: Vec3Out,
) {
}

/// Loads classes out of a module that the bytes describe, and uses the accepted ones.
///
/// # Panics
/// If an accepted class breaks a guarantee.
pub fn load_random(bytes: &[u8]) {
    let mut bytes = Bytes(bytes);
    let class_count = usize::from(bytes.byte() % 4);
    let mut names = Vec::new();
    let mut tables: Vec<Vec<Param>> = Vec::new();
    let mut classes = Vec::new();
    for _ in 0..class_count {
        let param_count = usize::from(bytes.byte() % 6);
        let table = (0..param_count).map(|_| {
            let name = bytes.name();
            let kind =
                bytes.number(&[0x1400, 0x1401, 0x1402, 0x1403, 0x1404, 0x1405, 0x1406, 0x140A, 0x140B]);
            let count = bytes.number(&[1, 3, 16, 17, 0]);
            let rate = bytes.number(&[0x500, 0x501, 0x502]);
            let offset = bytes.number(&[0, 4, 8, 16, 1, 60, u32::MAX]);
            let param = Param { name: pointer(name.as_ref()), kind, count, rate, offset };
            names.extend(name);
            param
        });
        tables.push(table.collect());
        let table = tables.last().expect("it was pushed");
        let name = bytes.name();
        // As many parameters as there are, or fewer; or a number that is rejected before the table is read.
        let stated = match bytes.byte() % 8 {
            0 => u32::MAX,
            1 => (1 << 16) + 1,
            2 => 0,
            _ => param_count as u32,
        };
        let sizes = [0, 4, 16, 64, 1 << 24, (1 << 24) + 1];
        classes.push(Class {
            // At most the real size: a plugin that states a greater one is beyond help.
            struct_size: bytes.number(&[size_of::<Class>() as u32, 56, 64, 0]).min(size_of::<Class>() as u32),
            kind: bytes.number(&[0x400, 0x401, 0x402, 0x403, 0x404]),
            flags: bytes.number(&[0, 0, 0, 1]),
            name: pointer(name.as_ref()),
            shader_size: bytes.number(&sizes),
            shader_align: bytes.number(&[0, 1, 16, 64, 4096, 8192, 24]),
            triangle_size: bytes.number(&sizes),
            vertex_size: bytes.number(&sizes),
            param_count: stated,
            params: if bytes.flag() { table.as_ptr() } else { ptr::null() },
            init: bytes.flag().then_some(init as _),
            fini: bytes.flag().then_some(init as _),
            prepare: bytes.flag().then_some(prepare as _),
            shade: bytes.flag().then_some(shade as _),
            transmit: bytes.flag().then_some(shade as _),
            miss: bytes.flag().then_some(miss as _),
            illuminate: bytes.flag().then_some(illuminate as _),
            camera: bytes.flag().then_some(camera as _),
            camera_lens: bytes.flag().then_some(camera_lens as _),
        });
        names.extend(name);
    }
    let pointers: Vec<*const Class> =
        classes.iter().map(|class| if bytes.flag() { ptr::from_ref(class) } else { ptr::null() }).collect();
    let module = Module {
        struct_size: bytes.number(&[size_of::<Module>() as u32, 0, 8]),
        abi: bytes.number(&[RTS_ABI, RTS_ABI + 1, 0x0002_0000]),
        class_count: pointers.len() as u32,
        classes: if bytes.flag() { pointers.as_ptr() } else { ptr::null() },
    };
    let library = Arc::new(Library::this_program());
    for name in ["", "e", "f", "g", "h", "x"] {
        match class_of(&module, name, "random", &library) {
            Ok(class) => use_class(Arc::new(class)),
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "an error is one line: {error}"),
        }
    }
}

/// An accepted class has its stated size, and each of its parameters can be written and read.
fn use_class(class: Arc<PluginClass>) {
    assert!(class.shader_align.is_power_of_two(), "an alignment: {}", class.shader_align);
    let block = PluginBlock::new(&class).expect("init throws nothing");
    for (i, p) in class.parameters.iter().enumerate() {
        let p = &p.description;
        if p.rate == ParameterRate::Shader {
            match p.kind {
                DataType::Text => block.write_text(i, c"text"),
                kind => block.write(i, &vec![7; p.count * kind.size()]),
            }
            assert_eq!(block.numbers(i).len(), p.count, "as many as there are");
        } else {
            assert_eq!(p.default.len(), p.count, "as many defaults as numbers");
        }
    }
    let snapshot = block.snapshot();
    // Children for trials take longer than all the rest.
    block.set_result(snapshot.version, Ok(()));
    let frame = PluginFrame::new([(1, &block)].into_iter(), FrameState::default);
    assert!(frame.made(1).is_some(), "it takes part: {:?}", frame.problems());
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

        #[test]
        fn random_tables(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            load_random(&bytes);
        }
    }

    #[test]
    fn some_are_accepted() {
        // One class of a surface: name e, no parameters, all callbacks.
        let mut bytes = vec![1, 0, 4, 3, 0, 0, 0, 2, 0, 0, 0];
        bytes.extend([1; 20]);
        load_random(&bytes);
    }
}
