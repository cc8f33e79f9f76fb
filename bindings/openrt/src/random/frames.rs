// SPDX-License-Identifier: GPL-3.0-or-later
//! Work of frames: exactly the program's changes since the one before; and the scene shows the program's
//! state after any sequence of calls.

use std::ffi::CStr;

use super::{perform, small_context};
use crate::context::Context;
use crate::state::matrix::Matrix;
use crate::state::parameter::GivenValue;
use gnurt::render::CommitReport;
use proptest::prelude::*;

/// Renders a frame; returns the work of its commit.
fn frame(context: &mut Context) -> CommitReport {
    context.start_rendering().expect("a frame starts");
    context.end_rendering().expect("and ends");
    work_of(&context.stage.report)
}

/// A report without the fields that are no work.
fn work_of(report: &CommitReport) -> CommitReport {
    CommitReport { dropped_triangles: 0, dropped_instances: 0, build_seconds: 0.0, ..report.clone() }
}

fn shader(context: &mut Context, class: &CStr) -> u32 {
    context.gen_new_shader_class(Some(class), None).expect("a class");
    context.gen_new_shader().expect("a shader")
}

/// Two triangles, as an object.
fn object(context: &mut Context, height: f64) -> u32 {
    let id = context.create_object(0x200).expect("an object");
    geometry(context, height);
    context.end_object().expect("it is closed");
    id
}

fn geometry(context: &mut Context, height: f64) {
    context.begin(0x103).expect("quadrangles");
    for [x, y] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
        context.vertex([x, y, height, 1.0]).expect("a vertex");
    }
    context.end().expect("whole");
}

fn put(context: &mut Context, x: f64) {
    context.load_matrix(Some(Matrix::translation([x, 0.0, 0.0]))).expect("a matrix");
}

#[test]
fn frames_do_what_is_due() {
    let mut context = small_context();
    let light = shader(&mut context, c"SpotLightShader");
    context.use_light(light).expect("a light");
    let surface = shader(&mut context, c"ConstantShader");
    let color = context.parameter_handle(Some(c"value")).expect("its colour");
    let quad = object(&mut context, 0.0);
    put(&mut context, 0.0);
    let [first, second] = [(); 2].map(|()| context.instantiate_object(quad).expect("an instance"));
    let all = frame(&mut context);
    assert_eq!((all.built_objects, all.placed_instances), (1, 2), "all at first");

    let none = CommitReport::default();
    assert_eq!(frame(&mut context), none, "nothing was changed");
    context.look_at([0.0, 0.0, 9.0], [0.0; 3], [0.0, 1.0, 0.0]).expect("a view");
    assert_eq!(frame(&mut context), none, "a camera is not of the world");
    context.perspective(30.0, [0.1, 10.0]).expect("a projection");
    context.swap_buffers().expect("a frame");
    context.end_rendering().expect("its end");
    assert_eq!(work_of(&context.stage.report), none, "nor is a projection");

    put(&mut context, 1.0);
    context.update_instance(second).expect("it is there");
    let moved = frame(&mut context);
    assert_eq!((moved.placed_instances, moved.built_objects, moved.made_shaders), (1, 0, 0), "one moved");
    assert!(moved.built_top_tree, "in the tree, too");
    context.bind_shader(surface).expect("it is there");
    context.set_parameter(color, Some(GivenValue::Floats(&[0.3, 0.2, 0.1]))).expect("a colour");
    let painted = frame(&mut context);
    assert_eq!(painted, CommitReport { made_shaders: 1, ..none.clone() }, "one shader");
    context.set_parameter(color, Some(GivenValue::Floats(&[0.3, 0.2, 0.1]))).expect("a colour");
    assert_eq!(frame(&mut context), none, "the same colour again");

    // A matrix would carry them elsewhere.
    put(&mut context, 0.0);
    context.new_object(quad, 0x200).expect("it is there");
    geometry(&mut context, 0.0);
    context.end_object().expect("closed");
    let same = frame(&mut context);
    assert_eq!((same.built_objects, same.built_top_tree), (0, false), "the same triangles need no tree");
    context.new_object(quad, 0x200).expect("it is there");
    geometry(&mut context, 0.5);
    context.end_object().expect("closed");
    let deformed = frame(&mut context);
    assert_eq!((deformed.built_objects, deformed.refitted_objects), (0, 1), "moved ones are a deformation");
    context.new_object(quad, 0x202).expect("it is there");
    geometry(&mut context, 0.75);
    context.end_object().expect("closed");
    let updated = frame(&mut context);
    assert_eq!((updated.built_objects, updated.refitted_objects), (0, 1), "RT_UPDATE says so");

    context.delete_instance(first).expect("it is there");
    let gone = frame(&mut context);
    assert_eq!((gone.placed_instances, gone.built_objects), (1, 0), "the other one stays where it is");
    assert!(context.exit().is_ok(), "a program may leave");
}

/// The same picture again and again: each frame clears, defines and shows all.
#[test]
fn immediate_frames_find_what_they_showed() {
    let mut context = small_context();
    context.set_scene_mode(0x601).expect("immediate");
    let _ = shader(&mut context, c"ConstantShader");
    let quad = object(&mut context, 0.0);
    for round in 0..4 {
        for x in [0.0, 2.0, 4.0] {
            put(&mut context, x);
            context.instantiate_object(quad).expect("an instance");
        }
        put(&mut context, 0.0);
        geometry(&mut context, 3.0);
        let report = frame(&mut context);
        assert!(round == 0 || !report.built_top_tree, "round {round}: nothing moved: {report:?}");
        assert_eq!(context.stage.scene.instances().len(), 4, "three and what lies outside of objects");
    }
}

/// Checks that the scene shows the program's state.
fn check(context: &Context) {
    let stage = &context.stage;
    let mut shown = 0;
    for (position, id) in stage.places() {
        let instance = &stage.scene.instances()[position];
        assert!(instance.visible, "instance {id} is seen");
        shown += 1;
        if let Some(expected) = context.instances.get(id) {
            assert_eq!(instance.world_from_object, expected.world_from_object.to_affine(), "where {id} is");
            assert!(context.objects.get(expected.object).is_some(), "what {id} shows is there");
        } else {
            assert_eq!(id, u32::MAX, "only what lies outside of objects has no id");
        }
    }
    let is_defined = |object: u32| context.objects.get(object).is_some();
    let known = context.instances.iter().filter(|instance| is_defined(instance.object)).count();
    assert!((known..=known + 1).contains(&shown), "{shown} of {known} are shown");
    let visible = stage.scene.instances().iter().filter(|instance| instance.visible).count();
    assert_eq!(visible, shown, "and nothing else");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn scenes_show_what_programs_have(
        calls in prop::collection::vec((any::<u8>(), 0_u32..6, -2_f32..2.0), 1..150),
    ) {
        let mut context = small_context();
        let _ = shader(&mut context, c"ConstantShader");
        for height in 0..3 {
            let id = object(&mut context, f64::from(height));
            context.instantiate_object(id).expect("an instance");
        }
        for call in calls {
            let is_of_mode = call.0 % 44 == 29;
            if !is_of_mode {
                let _ = perform(&mut context, call);
            }
            if context.frame.is_none() && call.0 % 3 == 0 && context.start_rendering().is_ok() {
                context.end_rendering().expect("nothing is open");
                check(&context);
            }
        }
    }
}
