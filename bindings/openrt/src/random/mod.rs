// SPDX-License-Identifier: GPL-3.0-or-later
//! Random programs: bytes become calls of the state machine. For the tests beside this and for fuzz/fuzz_targets/openrt_calls.rs.
//! Each call takes seven bytes: which one, four of a number, two of a coordinate.

#[cfg(test)]
mod frames;
#[cfg(test)]
mod model;
#[cfg(test)]
mod state_machine;

use std::sync::{Arc, LazyLock};

use crate::context::Context;
use crate::state::error::{Error, Result};
use crate::state::framebuffer::FrameMemory;
use crate::state::matrix::Matrix;
use crate::state::parameter::GivenValue;
use crate::state::texture::ImageDescription;

/// Pixels that are dropped.
pub(crate) struct Nowhere;

impl FrameMemory for Nowhere {
    fn write(&self, _offset: usize, _bytes: &[u8]) {}
}

/// A call: which one, and two numbers for its arguments.
pub(crate) type Call = (u8, u32, f32);

/// Bytes of a call.
const SIZE: usize = 7;

/// Constants that calls take, and their neighbours that none takes.
const CONSTANTS: [u32; 30] = [
    0x100, 0x101, 0x102, 0x103, 0x104, 0x105, 0x106, 0x200, 0x201, 0x202, 0x203, 0x302, 0x310, 0x600, 0x601,
    0x602, 0x1700, 0x1701, 0x1702, 0x1703, 0x0DE1, 0x1401, 0x1406, 0x1907, 0x1908, 0x2800, 0x2801, 0x2802,
    0x2600, 0x2601,
];

/// The calls that these bytes encode; a rest that is too short encodes none.
pub(crate) fn decode(bytes: &[u8]) -> impl Iterator<Item = Call> + '_ {
    bytes.chunks_exact(SIZE).map(|b| {
        let number = u32::from_le_bytes([b[1], b[2], b[3], b[4]]);
        // Small ids and constants, so that calls succeed about as often as they fail; now and then anything.
        let n = match b[4] % 8 {
            0..4 => number % 6,
            4..7 => CONSTANTS[number as usize % CONSTANTS.len()],
            _ => number,
        };
        (b[0], n, f32::from(i16::from_le_bytes([b[5], b[6]])) / 1024.0)
    })
}

/// A context that renders a few pixels on one thread.
pub(crate) fn small_context() -> Context {
    let mut context = Context::with_arguments([&b"--rt-threads=1"[..]].into_iter());
    context.set_frame_buffer(Some(Arc::new(Nowhere)), [4, 3], 0x302).expect("a good buffer");
    context
}

/// Makes one call.
pub(crate) fn perform(context: &mut Context, (call, n, x): Call) -> Result<()> {
    let classes = [
        c"ConstantShader",
        c"sample",
        c"DiffuseShader",
        c"SpotLightShader",
        c"MirrorShader",
        c"Phong",
        c"TextureShader",
        c"GlassShader",
        c"PinholeCameraShader",
        c"none",
    ];
    let parameters = [
        c"value",
        c"shader_color",
        c"triangle_color",
        c"vertex_color",
        c"color",
        c"texture",
        c"maxDepth",
        c"none",
    ];
    let position = [f64::from(x), f64::from(n % 7), f64::from(x * 0.5), 1.0];
    match call % 44 {
        0 => context.gen_new_shader_class(Some(classes[n as usize % classes.len()]), None).map(drop),
        1 => context.bind_shader_class(n),
        2 => context.gen_new_shader().map(drop),
        3 => context.bind_shader(n),
        4 => context.delete_shader(n),
        5 => context.parameter_handle(Some(parameters[n as usize % parameters.len()])).map(drop),
        6 => context.set_parameter(n, Some(GivenValue::Floats(&[x, 1.0, 0.0]))),
        7 => context.set_parameter(n, Some(GivenValue::Ints(&[1]))),
        8 => context.gen_objects(n as i32).map(drop),
        9 => context.new_object(n, 0x200 + u32::from(call > 128)).map(drop),
        10 => context.create_object(n).map(drop),
        11 => context.end_object(),
        12 => context.instantiate_object(n).map(drop),
        13 => context.remove_object(n),
        14 => context.begin(n),
        15..=17 => context.vertex(position),
        18 | 19 => context.end(),
        20 => context.load_matrix(Some(Matrix(std::array::from_fn(|i| f64::from(x) * i as f64)))),
        21 => context.multiply_matrix(Some(Matrix::rotation(f64::from(x), [1.0, 0.0, position[0]]))),
        22 => context.push_matrix().and_then(|()| context.matrix_mode(n)),
        23 => context.pop_matrix(),
        24 => context.update_instance(n).and_then(|()| context.delete_instance(n)),
        25 => context.use_light(n),
        26 => context.remove_light(n),
        27 => context.start_rendering(),
        28 => context.end_rendering(),
        29 => context.set_scene_mode(n),
        30 => context.look_at([f64::from(x); 3], [0.0; 3], [0.0, 1.0, 0.0]),
        31 => context.gen_textures(n as i32).map(drop),
        32 => context.bind_texture(0x0DE1, n),
        33 => context.tex_image(&image(n, x), Some(&|length| &TEXELS[..length])),
        34 => context.tex_parameter(0x0DE1, 0x2800 + n % 5, 0x2600 + (call as i32 % 3)),
        35 => context.delete_texture(n),
        36 => context.set_samples_per_pixel(n % 4),
        37 => context.set_progressive(x > 0.0),
        38 => context.cancel_rendering(),
        39 => context.perspective(f64::from(x) * 10.0, [0.1, 10.0]),
        40 => context.use_camera(n).and_then(|()| context.use_environment_shader(n)),
        41 => context.set_max_depth(n % 9),
        42 => context.new_object(n, 0x202).map(drop),
        _ => {
            context.normal([f64::from(x), 0.0, 1.0]);
            context.color([x; 4]);
            context.tex_coord(position);
            Ok(())
        }
    }
}

/// Texels of all pictures: enough for the largest.
static TEXELS: LazyLock<Vec<u8>> = LazyLock::new(|| vec![77; 8 * (1 << 15) * 16]);

/// A small picture, or one of an invalid size.
fn image(n: u32, x: f32) -> ImageDescription {
    ImageDescription {
        target: 0x0DE1,
        level: (n % 3) as i32,
        internal_format: [1, 3, 4, 0x1907, 7][n as usize % 5],
        size: [(n % 9) as i32, x as i32],
        border: i32::from(n == 5),
        format: 0x1907 + n % 3,
        texel_type: 0x1400 + n % 8,
    }
}

/// The state that queries between blocks return.
pub(crate) fn visible_state(context: &Context) -> Option<Vec<f32>> {
    let mut state = Vec::new();
    for name in [0x0700, 0x0701, 0x0702, 0x0B00, 0x0B02, 0x0B03, 0x0BA0, 0x0BA6, 0x0BA7, 0x0BA8] {
        context.get_floats(name, Some(&mut |values| state.extend_from_slice(values))).ok()?;
    }
    Some(state)
}

/// Runs a program: every error is one of the specification's, and the program may leave afterwards.
pub fn run(bytes: &[u8]) {
    let mut context = small_context();
    for call in decode(bytes) {
        if let Err(error) = perform(&mut context, call) {
            context.record(error);
        }
    }
    let _ = context.end();
    let code = context.take_error();
    let known = |code| code == Error::NONE_CODE || (0xFFFF_FE01..=0xFFFF_FE06).contains(&code);
    assert!(code.is_ok_and(known), "an error of types.h");
    assert_eq!(context.exit(), Ok(()), "a program may always leave");
}
