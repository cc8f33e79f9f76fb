// SPDX-License-Identifier: GPL-3.0-or-later
//! Rendering objects: classes that define the rendering method (rtUseRenderingObject).
//! Source: \[DWBS03\] for the kind; one class per integrator of the renderer, under its name there.
//!
//! | parameter | default | meaning |
//! |---|---|---|
//! | samplesPerPixel | 0 | samples of each pixel; 0 = as set by rtSetSamplesPerPixel |
//! | maxDepth | -1 | bounces of a path; negative = that of rtSetMaxRayRecursionDepth |
//! | vplCount | 0 | virtual lights of a pass; 0 = the renderer's own number |
//! | clamp | 0 | bound on the geometry term of virtual lights, one over area; 0 = the renderer's own |
//! | seed | 0 | of the random numbers |
//! | interleave | 0 | width of the pattern of pixels that share virtual lights; 0 = each has all |
//! | white | 1 | radiance of a white diffuse surface under light 1, if its shader loops over lights |
//!
//! Each integrator of the renderer has a class. Tests: tests/c/rendering_objects.c.

use gnurt::render::{Integrator, RenderOptions};
use gnurt::shading::classes::ParameterRate;
use gnurt_plugins::host::{DataType, Parameter};

use super::sampling::Sampling;
use super::value::ParameterValue;

/// A class of rendering objects.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct RenderingClass {
    /// Its name.
    pub(crate) name: &'static str,
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
    pub(crate) fn find(name: &str) -> Option<&'static Self> {
        Self::available().find(|(class, _)| class.name == name).map(|(class, _)| class)
    }

    /// Names of all classes that are there.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        Self::available().map(|(class, _)| class.name)
    }

    /// The parameters that all of them have.
    pub(crate) fn parameters() -> Vec<Parameter> {
        let parameter = |&(name, kind, default): &(&str, DataType, f32)| {
            let (name, default) = (name.to_owned(), vec![default]);
            Parameter { name, rate: ParameterRate::Shader, kind, count: 1, default }
        };
        PARAMETERS.iter().map(parameter).collect()
    }

    /// Applies the values of a rendering object, in the order of [`parameters`](Self::parameters), to the
    /// options.
    pub(crate) fn apply(&self, values: &[ParameterValue], options: &mut RenderOptions) {
        let values = Values(values);
        options.integrator = self.integrator.parse().unwrap_or_default();
        options.max_depth = u32::try_from(values.integer(MAX_DEPTH)).unwrap_or(options.max_depth);
        options.vpls = values.count(VPL_COUNT).unwrap_or(options.vpls);
        options.clamp = values.above_zero(CLAMP);
        options.white = values.above_zero(WHITE).unwrap_or(options.white);
        options.interleave = values.count(INTERLEAVE).unwrap_or(1);
        options.seed = u64::from(values.integer(SEED).cast_unsigned());
    }

    /// How many samples it takes, `otherwise` where the program has set none.
    pub(crate) fn sampling(&self, values: &[ParameterValue], otherwise: Sampling) -> Sampling {
        let samples = Values(values).count(SAMPLES_PER_PIXEL);
        Sampling { samples: samples.unwrap_or(otherwise.samples), ..otherwise }
    }
}

const SAMPLES_PER_PIXEL: &str = "samplesPerPixel";
const MAX_DEPTH: &str = "maxDepth";
const VPL_COUNT: &str = "vplCount";
const CLAMP: &str = "clamp";
const SEED: &str = "seed";
const INTERLEAVE: &str = "interleave";
const WHITE: &str = "white";

/// Name, type, default.
const PARAMETERS: [(&str, DataType, f32); 7] = [
    (SAMPLES_PER_PIXEL, DataType::I32, 0.0),
    (MAX_DEPTH, DataType::I32, -1.0),
    (VPL_COUNT, DataType::I32, 0.0),
    (CLAMP, DataType::F32, 0.0),
    (SEED, DataType::I32, 0.0),
    (INTERLEAVE, DataType::I32, 0.0),
    (WHITE, DataType::F32, 1.0),
];

/// Values of the parameters, by their names.
struct Values<'a>(&'a [ParameterValue]);

impl Values<'_> {
    fn get(&self, name: &str) -> Option<&ParameterValue> {
        self.0.get(PARAMETERS.iter().position(|(known, ..)| *known == name)?)
    }

    /// 0 if it is no integer.
    fn integer(&self, name: &str) -> i32 {
        match self.get(name) {
            Some(ParameterValue::Integer(value)) => *value,
            _ => 0,
        }
    }

    /// A number that counts something; none if it is 0 or negative.
    fn count(&self, name: &str) -> Option<u32> {
        u32::try_from(self.integer(name)).ok().filter(|&count| count > 0)
    }

    /// A finite number above 0; none if it is another.
    fn above_zero(&self, name: &str) -> Option<f32> {
        match self.get(name) {
            Some(ParameterValue::Floats(value)) => {
                value.first().copied().filter(|&x| x > 0.0 && x.is_finite())
            }
            _ => None,
        }
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
            let mut all = vec![ParameterValue::Integer(0); PARAMETERS.len()];
            let mut set = |name, value| {
                let parameter_index = PARAMETERS.iter().position(|(known, ..)| *known == name);
                all[parameter_index.expect("a parameter")] = value;
            };
            set(SAMPLES_PER_PIXEL, ParameterValue::Integer(spp));
            set(MAX_DEPTH, ParameterValue::Integer(depth));
            set(CLAMP, ParameterValue::Floats(vec![0.0]));
            set(SEED, ParameterValue::Integer(3));
            set(INTERLEAVE, ParameterValue::Integer(3));
            set(WHITE, ParameterValue::Floats(vec![0.5]));
            all
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
