// SPDX-License-Identifier: GPL-3.0-or-later
//! The command line.
//! The options are those of OSL's `testshade`, with one or two dashes.

use gnurt_sl::group::{Hint, Value, parse_value};
use gnurt_sl::types::{Base, Type};

pub(super) const USAGE: &str = "\
testshade -- runs shaders
testshade [options] shader...
    -v                           Verbose messages
    -t NTHREADS                  Set thread count
    --engine NAME                What runs shaders: interpreter (the default), machine (code for this CPU, sixteen
                                 points at once), avx2, avx512, or avx2-scalar, avx512-scalar (one point at once);
                                 without the option the variable TESTSHADE_ENGINE says so
    --debugnan                   Tell results that are not a number or infinite
    --debuguninit                Tell reads of variables that were never written
    --runstats                   Print what runs and how long it takes
    --res XRES YRES, -g          Set resolution
    --options LIST               Set extra OSL options
    --colorspace NAME            Set the shading system's colorspace
    -o VARIABLE FILENAME         Specify an output (filename='null' means don't save)
    -d NAME, -od                 Set the output data format to one of: uint8, half, float
    --print                      Print values of all -o outputs to console instead of saving images
    --groupname NAME             Set shader group name
    --layer NAME                 Set next layer name
    --param NAME VALUE           Add a parameter (options: type=%s, interpolated=%d, interactive=%d)
    --shader SHADER LAYERNAME    Declare a shader node
    --connect FROMLAYER FROMOUTPUT TOLAYER TOINPUT
                                 Connect two shader layers
    --reparam LAYERNAME PARAMNAME VALUE
                                 Change a parameter (options: type=%s)
    --group CMD                  Specify a full group command
    --raytype NAME               Set the raytype
    --iters ITERS                Number of iterations
    --entry LAYERNAME            Add layer to the list of entry points
    --entryoutput NAME           Add output symbol to the list of entry points
    --center                     Shade at output pixel 'centers' rather than corners
    --vary_pdxdy --vary_udxdy --vary_vdxdy
                                 Derivatives of P, u, v that vary
    --scaleuv U V, --offsetuv U V
                                 Scale and offset u and v
    --groupoutputs               Specify group outputs, not global outputs
    --oslquery                   Test OSLQuery at runtime
    --inbuffer                   Compile osl source from and to buffer
    --expr EXPR                  Specify an OSL expression to evaluate
    --userdata NAME VALUE        Add userdata (options: type=%s)
    --userdata_isconnected       Consider interpolated=1 to be isconnected()
";

/// The steps that make the group, in order.
#[derive(Clone, Debug)]
pub(super) enum Setup {
    Layer(String),
    Param(String, Value, Hint),
    Shader(String, Option<String>),
    Connect([String; 4]),
    Reparam(String, String, Value),
    Group(String),
    Expr(String),
}

/// All options.
#[derive(Clone, Debug)]
pub(super) struct Options {
    pub(super) setup: Vec<Setup>,
    pub(super) verbose: bool,
    pub(super) debug: bool,
    pub(super) size: [usize; 2],
    pub(super) extra: String,
    pub(super) colorspace: String,
    pub(super) outputs: Vec<(String, String)>,
    pub(super) format: String,
    pub(super) print: bool,
    pub(super) groupname: String,
    pub(super) raytype: String,
    pub(super) iterations: usize,
    pub(super) entries: Vec<String>,
    pub(super) entry_outputs: Vec<String>,
    pub(super) centers: bool,
    pub(super) vary: [bool; 3],
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
    pub(super) query: bool,
    pub(super) in_buffer: bool,
    pub(super) userdata: Vec<(String, Value)>,
    pub(super) userdata_isconnected: bool,
    pub(super) archive: Option<String>,
    pub(super) engine: String,
    pub(super) times: bool,
    pub(super) debug_nan: bool,
    pub(super) debug_uninit: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            setup: Vec::new(),
            verbose: false,
            debug: false,
            size: [1, 1],
            extra: String::new(),
            colorspace: String::new(),
            outputs: Vec::new(),
            format: String::new(),
            print: false,
            groupname: String::new(),
            raytype: "camera".to_owned(),
            iterations: 1,
            entries: Vec::new(),
            entry_outputs: Vec::new(),
            centers: false,
            vary: [false; 3],
            scale: [1.0; 2],
            offset: [0.0; 2],
            query: false,
            in_buffer: false,
            userdata: Vec::new(),
            userdata_isconnected: false,
            archive: None,
            engine: std::env::var("TESTSHADE_ENGINE").unwrap_or_default(),
            times: false,
            debug_nan: false,
            debug_uninit: false,
        }
    }
}

/// Options without effect here, and how many values each takes.
const IGNORED: [(&str, usize); 23] = [
    ("t", 1),
    ("optix", 0),
    ("llvm_debug", 0),
    ("stats", 0),
    ("batched", 0),
    ("profile", 0),
    ("saveptx", 0),
    ("warmup", 0),
    ("texoptions", 1),
    ("O0", 0),
    ("O1", 0),
    ("O2", 0),
    ("llvm_opt", 1),
    ("raytype_opt", 0),
    ("groupoutputs", 0),
    ("print-groupdata", 0),
    ("print-group-stats", 0),
    ("no-output-placement", 0),
    ("shadeimage", 0),
    ("noshadeimage", 0),
    ("locale", 1),
    ("use_rs_bitcode", 0),
    ("jbufferMB", 1),
];

/// Pixels along a side.
const MOST_PIXELS: usize = 1 << 14;

/// The names of `--engine`.
const ENGINES: [&str; 6] = ["interpreter", "machine", "avx2", "avx512", "avx2-scalar", "avx512-scalar"];

/// One of these words.
fn known(option: &str, argument: String, list: &[&str]) -> Result<String, Option<String>> {
    if list.contains(&argument.as_str()) {
        return Ok(argument);
    }
    Err(Some(format!("{option}: '{argument}' is none of {}", list.join(", "))))
}

/// The types that `type=` names.
fn type_named(text: &str) -> Option<Type> {
    let (name, array) = match text.split_once('[') {
        Some((name, rest)) => (name, rest.strip_suffix(']')?.parse::<i32>().ok().filter(|&n| n > 0)?),
        None => (text, 0),
    };
    Base::from_keyword(name).map(|base| Type::of(base).array_of(array))
}

/// The modifiers after a colon in `-param:type=int:interactive=1`.
fn modifiers(text: &str) -> (Option<Type>, Hint) {
    let (mut ty, mut hint) = (None, Hint::default());
    for part in text.split(':').skip(1) {
        match part.split_once('=') {
            Some(("type", value)) => ty = type_named(value),
            Some(("lockgeom", value)) => hint.interpolated = value == "0",
            Some(("interpolated", value)) => hint.interpolated = value != "0",
            Some(("interactive", value)) => hint.interactive = value != "0",
            _ => {}
        }
    }
    (ty, hint)
}

/// Reads it; an error without a message requests help.
pub(super) fn read(args: &[String]) -> Result<Options, Option<String>> {
    let mut o = Options::default();
    let mut rest = args.iter();
    while let Some(arg) = rest.next() {
        let Some(name) = arg.strip_prefix('-').map(|n| n.strip_prefix('-').unwrap_or(n)) else {
            o.setup.push(Setup::Shader(arg.clone(), None));
            continue;
        };
        let mut value = || rest.next().cloned().ok_or_else(|| Some(format!("{arg} needs more values")));
        let argument = name.split(':').next().unwrap_or("");
        if let Some((_, count)) = IGNORED.iter().find(|(n, _)| *n == argument) {
            for _ in 0..*count {
                value()?;
            }
            continue;
        }
        let number =
            |text: String| text.parse::<f32>().map_err(|_| Some(format!("{arg}: '{text}' is not a number")));
        let count = |text: String| {
            text.parse::<usize>().map_err(|_| Some(format!("{arg}: '{text}' is not a number")))
        };
        match argument {
            "help" | "h" => return Err(None),
            "v" => o.verbose = true,
            "debug" | "debug2" => o.debug = true,
            "res" | "g" => {
                let mut side = || match count(value()?)? {
                    n @ 1..=MOST_PIXELS => Ok(n),
                    n => Err(Some(format!("{arg}: {n} is not from 1 to {MOST_PIXELS}"))),
                };
                o.size = [side()?, side()?];
            }
            "options" => o.extra = value()?,
            "colorspace" => o.colorspace = value()?,
            "o" => o.outputs.push((value()?, value()?)),
            "d" | "od" => o.format = known(arg, value()?, &["uint8", "half", "float"])?,
            "engine" => o.engine = known(arg, value()?, &ENGINES)?,
            "runstats" => o.times = true,
            "debugnan" => o.debug_nan = true,
            "debuguninit" => o.debug_uninit = true,
            "print" => o.print = true,
            "groupname" => o.groupname = value()?,
            "raytype" => o.raytype = value()?,
            "iters" => o.iterations = count(value()?)?.clamp(1, 10_000),
            "entry" => o.entries.push(value()?),
            "entryoutput" => o.entry_outputs.push(value()?),
            "center" => o.centers = true,
            "vary_pdxdy" => o.vary[0] = true,
            "vary_udxdy" => o.vary[1] = true,
            "vary_vdxdy" => o.vary[2] = true,
            "scaleuv" | "scalest" => o.scale = [number(value()?)?, number(value()?)?],
            "offsetuv" | "offsetst" => o.offset = [number(value()?)?, number(value()?)?],
            "oslquery" => o.query = true,
            "inbuffer" => o.in_buffer = true,
            "archivegroup" => o.archive = Some(value()?),
            "userdata_isconnected" => o.userdata_isconnected = true,
            "layer" => o.setup.push(Setup::Layer(value()?)),
            "shader" => o.setup.push(Setup::Shader(value()?, Some(value()?))),
            "connect" => o.setup.push(Setup::Connect([value()?, value()?, value()?, value()?])),
            "group" => o.setup.push(Setup::Group(value()?)),
            "expr" => o.setup.push(Setup::Expr(value()?)),
            "param" => {
                let (ty, hint) = modifiers(name);
                o.setup.push(Setup::Param(value()?, parse_value(ty, &value()?), hint));
            }
            "reparam" => {
                let (ty, _) = modifiers(name);
                o.setup.push(Setup::Reparam(value()?, value()?, parse_value(ty, &value()?)));
            }
            "userdata" => {
                let (ty, _) = modifiers(name);
                o.userdata.push((value()?, parse_value(ty, &value()?)));
            }
            _ => return Err(Some(format!("Invalid option \"{arg}\""))),
        }
    }
    let any = o.setup.iter().any(|s| matches!(s, Setup::Shader(..) | Setup::Group(_) | Setup::Expr(_)));
    if !any {
        return Err(Some(
            "No shader or group was specified.\n\nTry `testshade --help` for an explanation of all arguments"
                .into(),
        ));
    }
    Ok(o)
}
