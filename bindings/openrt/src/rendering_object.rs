// SPDX-License-Identifier: GPL-3.0-or-later
//! Rendering objects: classes that say how a picture is made (rtUseRenderingObject).
//! Source: \[DWBS03\] for the kind; one class per integrator of the renderer, under its name there.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | samplesPerPixel | 0 | samples of each pixel; 0 = as rtSetSamplesPerPixel says |
//! | maxDepth | -1 | bounces of a path; negative = that of rtSetMaxRayRecursionDepth |
//! | vplCount | 0 | virtual lights of a pass; 0 = the renderer's own number |
//! | clamp | 0 | largest geometry term, one over area, that virtual lights bring light over; 0 = the renderer's own |
//! | seed | 0 | of the random numbers |
//! | interleave | 0 | width of the pattern of pixels that share virtual lights out; 0 = each has all |
//! | white | 1 | what a white diffuse surface of a shader that loops over lights shows where light 1 arrives |
//!
//! A class is there as soon as the renderer has its integrator. Proof: tests/c/rendering_objects.c.

use gnurt::render::{Integrator, RenderOptions};
use gnurt::shading::classes::ParameterRate;

use crate::class::{DataType, Parameter};
use crate::progressive::Sampling;
use crate::shader::ParameterValue;

/// A class of rendering objects.
#[derive(Debug, PartialEq, Eq)]
pub struct RenderingClass {
    /// Its name.
    pub name: &'static str,
    /// The renderer's name of its integrator.
    integrator: &'static str,
}

const fn class(name: &'static str, integrator: &'static str) -> RenderingClass {
    RenderingClass { name, integrator }
}

static ALL: [RenderingClass; 6] = [
    class("Whitted", "whitted"),
    class("Eyelight", "eyelight"),
    class("PathTracer", "path"),
    class("InstantRadiosity", "ir"),
    class("BidirectionalInstantRadiosity", "bir"),
    class("MetropolisInstantRadiosity", "mir"),
];

impl RenderingClass {
    fn available() -> impl Iterator<Item = (&'static Self, Integrator)> {
        ALL.iter().filter_map(|class| Some((class, class.integrator.parse().ok()?)))
    }

    /// The class of this name, if the renderer has its integrator.
    #[must_use]
    pub fn find(name: &str) -> Option<&'static Self> {
        Self::available().find(|(class, _)| class.name == name).map(|(class, _)| class)
    }

    /// Names of all classes that are there.
    pub fn names() -> impl Iterator<Item = &'static str> {
        Self::available().map(|(class, _)| class.name)
    }

    /// The parameters that all of them have.
    #[must_use]
    pub fn parameters() -> Vec<Parameter> {
        let parameter = |name: &str, kind, default: f32| {
            let (name, default) = (name.to_owned(), vec![default]);
            Parameter { name, rate: ParameterRate::Shader, kind, count: 1, default }
        };
        vec![
            parameter("samplesPerPixel", DataType::I32, 0.0),
            parameter("maxDepth", DataType::I32, -1.0),
            parameter("vplCount", DataType::I32, 0.0),
            parameter("clamp", DataType::F32, 0.0),
            parameter("seed", DataType::I32, 0.0),
            parameter("white", DataType::F32, 1.0),
            parameter("interleave", DataType::I32, 0.0),
        ]
    }

    /// What a rendering object with these values, in the order of [`parameters`](Self::parameters), asks for.
    pub fn apply(&self, values: &[ParameterValue], options: &mut RenderOptions) {
        options.integrator = self.integrator.parse().unwrap_or_default();
        if let Ok(depth) = u32::try_from(integer(values, 1)) {
            options.max_depth = depth;
        }
        if let Some(vpls) = u32::try_from(integer(values, 2)).ok().filter(|&vpls| vpls > 0) {
            options.vpls = vpls;
        }
        if let Some(ParameterValue::Floats(clamp)) = values.get(3) {
            options.clamp = clamp.first().copied().filter(|&clamp| clamp > 0.0 && clamp.is_finite());
        }
        if let Some(ParameterValue::Floats(white)) = values.get(5) {
            let white = white.first().copied().filter(|&white| white > 0.0 && white.is_finite());
            options.white = white.unwrap_or(options.white);
        }
        options.interleave = u32::try_from(integer(values, 6)).unwrap_or(0).max(1);
        options.seed = u64::from(integer(values, 4).cast_unsigned());
    }

    /// How many samples it takes, where the program has said `otherwise`.
    #[must_use]
    pub fn sampling(&self, values: &[ParameterValue], otherwise: Sampling) -> Sampling {
        let samples = u32::try_from(integer(values, 0)).ok().filter(|&samples| samples > 0);
        Sampling { samples: samples.unwrap_or(otherwise.samples), ..otherwise }
    }
}

/// Value number `i`; 0 if it is no integer.
fn integer(values: &[ParameterValue], i: usize) -> i32 {
    match values.get(i) {
        Some(ParameterValue::Integer(value)) => *value,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_options() {
        let class = RenderingClass::find("Eyelight").expect("a class of the first days");
        let mut options = RenderOptions { max_depth: 7, ..Default::default() };
        let values = |spp, depth| {
            let [a, b, c, d] = [spp, depth, 0, 3].map(ParameterValue::Integer);
            [
                a,
                b,
                c,
                ParameterValue::Floats(vec![0.0]),
                d,
                ParameterValue::Floats(vec![0.5]),
                ParameterValue::Integer(3),
            ]
        };
        class.apply(&values(4, -1), &mut options);
        assert_eq!(options.integrator.name(), "eyelight", "its integrator");
        assert_eq!((options.max_depth, options.seed), (7, 3), "its values");
        assert_eq!((options.vpls, options.clamp), (1024, None), "the renderer's own");
        assert_eq!((options.white, options.interleave), (0.5, 3), "its light model and pattern");
        let mut many = values(4, -1);
        (many[2], many[3]) = (ParameterValue::Integer(9), ParameterValue::Floats(vec![0.5]));
        class.apply(&many, &mut options);
        assert_eq!((options.vpls, options.clamp), (9, Some(0.5)), "its own");
        class.apply(&values(4, 2), &mut options);
        assert_eq!(options.max_depth, 2, "its own depth");
        let context = Sampling { samples: 5, progressive: true };
        assert_eq!(
            class.sampling(&values(4, 0), context),
            Sampling { samples: 4, ..context },
            "its own samples"
        );
        assert_eq!(class.sampling(&values(-3, 0), context), context, "those of the context");
        assert!(RenderingClass::find("Witted").is_none(), "an unknown name");
    }
}
