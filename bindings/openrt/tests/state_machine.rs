// SPDX-License-Identifier: GPL-3.0-or-later
//! Random programs against the state machine: no call panics, and failing calls change nothing that can be asked.
//! Source: original.

use std::sync::Arc;

use OpenRT::context::Context;
use OpenRT::error::{Error, Result};
use OpenRT::framebuffer::FrameMemory;
use OpenRT::matrix::Matrix;
use OpenRT::parameter::Given;
use proptest::prelude::*;

/// Pixels that nobody looks at.
struct Nowhere;

impl FrameMemory for Nowhere {
    fn write(&self, _offset: usize, _bytes: &[u8]) {}
}

/// A call: which one, and two numbers for its arguments.
type Call = (u8, u32, f32);

/// Constants and small ids, so that calls succeed about as often as they fail.
fn argument() -> impl Strategy<Value = u32> {
    let constants: Vec<u32> =
        (0x100..0x107).chain(0x200..0x204).chain(0x600..0x603).chain(0x1700..0x1704).collect();
    prop_oneof![4 => 0_u32..6, 3 => prop::sample::select(constants), 1 => any::<u32>()]
}

fn perform(context: &mut Context, (call, n, x): Call) -> Result<()> {
    let classes =
        [c"ConstantShader", c"sample", c"DiffuseShader", c"SpotLightShader", c"MirrorShader", c"none"];
    let parameters = [c"value", c"shader_color", c"triangle_color", c"vertex_color", c"color", c"none"];
    let position = [f64::from(x), f64::from(n % 7), f64::from(x * 0.5), 1.0];
    match call % 32 {
        0 => context.gen_new_shader_class(Some(classes[n as usize % classes.len()]), None).map(drop),
        1 => context.bind_shader_class(n),
        2 => context.gen_new_shader().map(drop),
        3 => context.bind_shader(n),
        4 => context.delete_shader(n),
        5 => context.parameter_handle(Some(parameters[n as usize % parameters.len()])).map(drop),
        6 => context.set_parameter(n, Some(Given::Floats(&[x, 1.0, 0.0]))),
        7 => context.set_parameter(n, Some(Given::Ints(&[1]))),
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
        _ => {
            context.normal([f64::from(x), 0.0, 1.0]);
            context.color([x; 4]);
            context.tex_coord(position);
            Ok(())
        }
    }
}

/// What can be asked between blocks.
fn visible_state(context: &Context) -> Option<Vec<f32>> {
    let mut state = Vec::new();
    for name in [0x0700, 0x0701, 0x0702, 0x0B00, 0x0B02, 0x0B03, 0x0BA0, 0x0BA6, 0x0BA7, 0x0BA8] {
        context.get_floats(name, Some(&mut |values| state.extend_from_slice(values))).ok()?;
    }
    Some(state)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn random_programs(calls in prop::collection::vec((any::<u8>(), argument(), -9_f32..9.0), 1..200)) {
        let mut context = Context::with_arguments([&b"--rt-threads=1"[..]].into_iter());
        context.set_frame_buffer(Some(Arc::new(Nowhere)), [4, 3], 0x302).expect("a good buffer");
        for call in calls {
            let before = visible_state(&context);
            let outcome = perform(&mut context, call);
            // Calls 11 and 12 may close an object and fail; 22 and 24 are two calls.
            let is_single = ![11, 12, 22, 24].contains(&(call.0 % 32));
            if let (Err(error), Some(before), true) = (outcome, before, is_single) {
                let after = visible_state(&context);
                let same = after.is_some_and(|after| {
                    after.iter().map(|x| x.to_bits()).eq(before.iter().map(|x| x.to_bits()))
                });
                prop_assert!(same, "{call:?} failed with {error} and changed something");
            }
        }
        let _ = context.end();
        prop_assert_eq!(context.exit(), Ok(()), "a program may always leave");
    }
}

#[test]
fn the_first_error_stays() {
    let mut context = Context::default();
    context.record(Error::StackOverflow);
    context.record(Error::InvalidEnum);
    assert_eq!(context.take_error(), Ok(Error::StackOverflow.code()), "the first one");
    assert_eq!(context.take_error(), Ok(Error::NONE_CODE), "reading it clears it");
}
