// SPDX-License-Identifier: GPL-3.0-or-later
//! Geometries of a ray scene as arrays, by their numbers, which stay when others are removed.
//! Invariant: all arrays fit each other: vertex numbers are in range, and vertices have radii, normals and tangents where
//! the kind needs them. Tests: `tests/test_scene.py`, `tests/test_primitives.py`.

use gnurt_accel::{CurveBasis, CurveForm};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Numbers, array, of_type, transform};
use crate::ffi_arrays::Rows;
use crate::retained::{radii, retained, rows, whole};

/// Kinds of primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Triangles,
    Quads,
    /// Regular rectangles of vertices.
    Grids,
    /// Points by their form.
    Points(PointForm),
    Curves(CurveBasis, CurveForm),
}

/// The surface of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PointForm {
    /// A sphere.
    Round,
    /// A disc that faces each ray.
    Flat,
    /// A disc with a normal.
    Oriented,
}

const BASES: [(&str, CurveBasis); 5] = [
    ("linear", CurveBasis::Linear),
    ("bezier", CurveBasis::Bezier),
    ("bspline", CurveBasis::BSpline),
    ("catmull-rom", CurveBasis::CatmullRom),
    ("hermite", CurveBasis::Hermite),
];
const CURVE_FORMS: [(&str, CurveForm); 3] =
    [("flat", CurveForm::Flat), ("round", CurveForm::Round), ("oriented", CurveForm::Oriented)];
const POINT_FORMS: [(&str, PointForm); 3] =
    [("round", PointForm::Round), ("flat", PointForm::Flat), ("oriented", PointForm::Oriented)];

/// The choice that a word stands for.
fn choice<T: Copy>(name: &str, word: &str, all: &[(&str, T)]) -> PyResult<T> {
    let found = all.iter().find(|(known, _)| *known == word);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        let known: Vec<String> = all.iter().map(|(known, _)| format!("\"{known}\"")).collect();
        PyValueError::new_err(format!("{name}: invalid: \"{word}\"; valid are: {}", known.join(", ")))
    })
}

/// The word for a choice.
fn word<T: PartialEq>(choice: T, all: &[(&'static str, T)]) -> &'static str {
    all.iter().find(|(_, known)| *known == choice).map_or("", |(word, _)| word)
}

/// Arrays of a geometry, without gaps. They are stored, so that they can be pickled and built again.
pub(crate) struct Arrays {
    /// float32, or float64 in a scene of that; (n, 3).
    pub(crate) vertices: Py<PyAny>,
    /// uint32: (m, 3) of triangles, (m, 4) of quads, (m,) of curves, whose first vertices they are; (m, 4) of grids: first vertex,
    /// stride, columns, rows.
    pub(crate) indices: Option<Py<PyAny>>,
    /// float32, (n,), of points and curves.
    pub(crate) radii: Option<Py<PyAny>>,
    /// float32, (n, 3), of oriented points and curves.
    pub(crate) normals: Option<Py<PyAny>>,
    /// float32, (n, 4), of Hermite curves.
    pub(crate) tangents: Option<Py<PyAny>>,
    /// float32, (n, 3), of oriented Hermite curves.
    pub(crate) normal_tangents: Option<Py<PyAny>>,
}

impl Arrays {
    fn others(&self) -> [Option<&Py<PyAny>>; 5] {
        [&self.indices, &self.radii, &self.normals, &self.tangents, &self.normal_tangents].map(Option::as_ref)
    }
}

/// A geometry.
pub(crate) struct StoredGeometry {
    pub(crate) kind: Kind,
    pub(crate) arrays: Arrays,
    /// Columns of an affine map.
    pub(crate) placement: Option<[[f64; 3]; 4]>,
    /// Which edit of the scene gave it these vertices; edits count from 1.
    pub(crate) shape: u64,
    /// Which edit gave it these vertices or this transform.
    pub(crate) state: u64,
}

type Object<'a, 'py> = &'a Bound<'py, PyAny>;

/// Arguments of points.
pub(crate) struct PointArguments<'a, 'py> {
    pub(crate) vertices: Object<'a, 'py>,
    pub(crate) radii: Object<'a, 'py>,
    pub(crate) form: &'a str,
    pub(crate) normals: Option<Object<'a, 'py>>,
}

/// Arguments of curves.
pub(crate) struct CurveArguments<'a, 'py> {
    pub(crate) vertices: Object<'a, 'py>,
    pub(crate) radii: Object<'a, 'py>,
    /// How many vertices each strand has, or the first vertex of each curve.
    pub(crate) counts: Option<Object<'a, 'py>>,
    pub(crate) segments: Option<Object<'a, 'py>>,
    pub(crate) basis: &'a str,
    pub(crate) form: &'a str,
    pub(crate) normals: Option<Object<'a, 'py>>,
    pub(crate) tangents: Option<Object<'a, 'py>>,
    pub(crate) normal_tangents: Option<Object<'a, 'py>>,
}

/// How many vertices a curve has, and from which vertex on the next one of its strand starts.
fn order_and_step(basis: CurveBasis) -> [usize; 2] {
    match basis {
        CurveBasis::Linear | CurveBasis::Hermite => [2, 1],
        CurveBasis::Bezier => [4, 3],
        CurveBasis::BSpline | CurveBasis::CatmullRom => [4, 1],
    }
}

/// An array that goes with one choice of an argument and only there.
fn fits(
    name: &str,
    given: Option<Object>,
    width: usize,
    count: usize,
    (condition, is_met): (&str, bool),
    copy: bool,
) -> PyResult<Option<Py<PyAny>>> {
    match given {
        Some(_) if !is_met => Err(PyValueError::new_err(format!("{name}: valid with {condition} only"))),
        None if is_met => Err(PyTypeError::new_err(format!("{name}: missing; {condition} needs them"))),
        None => Ok(None),
        Some(given) => rows(name, given, width, Some(count), "float32", copy).map(Some),
    }
}

/// How much a map scales all lengths; `None` where that depends on the direction.
pub(crate) fn uniform_scale([x, y, z, _]: &[[f64; 3]; 4]) -> Option<f64> {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let square = (dot(x, x) + dot(y, y) + dot(z, z)) / 3.0;
    let errors =
        [dot(x, x) - square, dot(y, y) - square, dot(z, z) - square, dot(x, y), dot(y, z), dot(z, x)];
    // Not so of NaN. A millionth is more than matrices of single precision are off.
    errors.iter().all(|error| error.abs() <= 1e-6 * square).then(|| square.sqrt())
}

impl StoredGeometry {
    fn new(kind: Kind, arrays: Arrays) -> Self {
        Self { kind, arrays, placement: None, shape: 0, state: 0 }
    }

    /// Triangles, or quads.
    pub(crate) fn mesh(
        vertices: Object,
        faces: Object,
        kind: Kind,
        copy: bool,
        dtype: &str,
    ) -> PyResult<Self> {
        let width = if kind == Kind::Quads { 4 } else { 3 };
        let count = Numbers::new("vertices", vertices, Some(3))?.count();
        let found = whole("faces", &array("faces", faces)?, Some(width))?;
        let wide = of_type(&found, "int64")?;
        let all = Rows::<i64>::new(&wide)?.ok_or_else(|| PyValueError::new_err("faces: has gaps"))?;
        if let Some(bad) = all.all().iter().position(|&corner| corner < 0 || corner as u64 >= count as u64) {
            let (row, corner) = (bad / width, all.all()[bad]);
            return Err(PyValueError::new_err(format!(
                "faces: row {row} names vertex {corner}, and there are {count} vertices, from 0 on"
            )));
        }
        let arrays = Arrays {
            vertices: rows("vertices", vertices, 3, None, dtype, copy)?,
            indices: Some(retained(&of_type(&found, "uint32")?, faces, copy)?),
            radii: None,
            normals: None,
            tangents: None,
            normal_tangents: None,
        };
        Ok(Self::new(kind, arrays))
    }

    /// Regular rectangles of vertices.
    pub(crate) fn grids(vertices: Object, grids: Object, copy: bool) -> PyResult<Self> {
        let count = Numbers::new("vertices", vertices, Some(3))?.count();
        let found = whole("grids", &array("grids", grids)?, Some(4))?;
        let wide = of_type(&found, "int64")?;
        let all = Rows::<i64>::new(&wide)?.ok_or_else(|| PyValueError::new_err("grids: has gaps"))?;
        for (row, &[first, stride, columns, rows]) in all.all().as_chunks::<4>().0.iter().enumerate() {
            let sizes = 2..=i64::from(u16::MAX);
            if let Some((bad, what)) =
                [(columns, "columns"), (rows, "rows")].into_iter().find(|(size, _)| !sizes.contains(size))
            {
                return Err(PyValueError::new_err(format!(
                    "grids: row {row} has {bad} {what} of vertices; valid are {} to {}",
                    sizes.start(),
                    sizes.end()
                )));
            }
            if first < 0 || stride < 0 {
                return Err(PyValueError::new_err(format!(
                    "grids: row {row} has first vertex {first} and stride {stride}; valid are numbers from 0 on"
                )));
            }
            let last =
                i128::from(first) + i128::from(rows - 1) * i128::from(stride) + i128::from(columns - 1);
            if last >= count as i128 {
                return Err(PyValueError::new_err(format!(
                    "grids: row {row} takes vertex {last}, and there are {count} vertices, from 0 on"
                )));
            }
        }
        let arrays = Arrays {
            vertices: rows("vertices", vertices, 3, None, "float32", copy)?,
            indices: Some(retained(&of_type(&found, "uint32")?, grids, copy)?),
            radii: None,
            normals: None,
            tangents: None,
            normal_tangents: None,
        };
        Ok(Self::new(Kind::Grids, arrays))
    }

    /// Spheres or discs.
    pub(crate) fn points(given: &PointArguments, copy: bool) -> PyResult<Self> {
        let form = choice("form", given.form, &POINT_FORMS)?;
        let count = Numbers::new("vertices", given.vertices, Some(3))?.count();
        let condition = ("form=\"oriented\"", form == PointForm::Oriented);
        let arrays = Arrays {
            vertices: rows("vertices", given.vertices, 3, None, "float32", copy)?,
            indices: None,
            radii: Some(radii(given.radii, count, copy)?),
            normals: fits("normals", given.normals, 3, count, condition, copy)?,
            tangents: None,
            normal_tangents: None,
        };
        Ok(Self::new(Kind::Points(form), arrays))
    }

    /// Curves.
    pub(crate) fn curves(given: &CurveArguments, copy: bool) -> PyResult<Self> {
        let basis = choice("basis", given.basis, &BASES)?;
        let form = choice("form", given.form, &CURVE_FORMS)?;
        let (is_hermite, is_oriented) = (basis == CurveBasis::Hermite, form == CurveForm::Oriented);
        let count = Numbers::new("vertices", given.vertices, Some(3))?.count();
        let arrays = Arrays {
            vertices: rows("vertices", given.vertices, 3, None, "float32", copy)?,
            indices: Some(segments(given, basis, count)?),
            radii: Some(radii(given.radii, count, copy)?),
            normals: fits("normals", given.normals, 3, count, ("form=\"oriented\"", is_oriented), copy)?,
            tangents: fits("tangents", given.tangents, 4, count, ("basis=\"hermite\"", is_hermite), copy)?,
            normal_tangents: fits(
                "normal_tangents",
                given.normal_tangents,
                3,
                count,
                ("basis=\"hermite\" and form=\"oriented\"", is_hermite && is_oriented),
                copy,
            )?,
        };
        Ok(Self::new(Kind::Curves(basis, form), arrays))
    }

    /// The same with a transform as a matrix.
    pub(crate) fn placed(self, given: Option<Object>) -> PyResult<Self> {
        let placement = given.map(|given| transform("transform", given)).transpose()?;
        self.check_placement(placement.as_ref())?;
        Ok(Self { placement, ..self })
    }

    /// Spheres stay spheres, and curves keep their circles, under maps that scale all directions alike.
    pub(crate) fn check_placement(&self, placement: Option<&[[f64; 3]; 4]>) -> PyResult<()> {
        let is_mesh = matches!(self.kind, Kind::Triangles | Kind::Quads | Kind::Grids);
        match placement {
            Some(placement) if !is_mesh && uniform_scale(placement).is_none() => Err(PyValueError::new_err(
                "transform: points and curves need the same scale in all directions; \
                     for others put them into a RayScene of their own and show it by add_instance",
            )),
            _ => Ok(()),
        }
    }

    /// The same arrays.
    pub(crate) fn shared(&self, py: Python<'_>) -> Self {
        let clone = |array: &Option<Py<PyAny>>| array.as_ref().map(|array| array.clone_ref(py));
        let arrays = Arrays {
            vertices: self.arrays.vertices.clone_ref(py),
            indices: clone(&self.arrays.indices),
            radii: clone(&self.arrays.radii),
            normals: clone(&self.arrays.normals),
            tangents: clone(&self.arrays.tangents),
            normal_tangents: clone(&self.arrays.normal_tangents),
        };
        Self { arrays, ..*self }
    }

    /// Other vertices for it, checked: as many.
    pub(crate) fn moved(
        &self,
        py: Python<'_>,
        vertices: Object,
        copy: bool,
        dtype: &str,
    ) -> PyResult<Py<PyAny>> {
        let (expected, found) =
            (self.arrays.vertices.bind(py).len()?, Numbers::new("vertices", vertices, Some(3))?.count());
        if found != expected {
            return Err(PyValueError::new_err(format!(
                "vertices: expected shape ({expected}, 3) as before, not ({found}, 3)"
            )));
        }
        rows("vertices", vertices, 3, None, dtype, copy)
    }

    /// For the garbage collector.
    pub(crate) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.arrays.vertices)?;
        self.arrays.others().into_iter().try_for_each(|array| visit.call(array))
    }

    /// For pickle: vertices, faces and a transform of triangles, arguments by their names of others.
    pub(crate) fn pickled<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let Arrays { vertices, indices, radii, normals, tangents, normal_tangents } = &self.arrays;
        let placement = self.placement.as_ref().map(matrix);
        let named = |kind: &str| {
            let all = PyDict::new(py);
            all.set_item("kind", kind)?;
            all.set_item("vertices", vertices)?;
            let others = [
                ("radii", radii),
                ("normals", normals),
                ("tangents", tangents),
                ("normal_tangents", normal_tangents),
            ];
            for (name, array) in others {
                if let Some(array) = array {
                    all.set_item(name, array)?;
                }
            }
            if let Some(placement) = &placement {
                all.set_item("transform", placement)?;
            }
            Ok::<_, PyErr>(all)
        };
        Ok(match self.kind {
            Kind::Triangles => (vertices, indices, placement).into_pyobject(py)?.into_any(),
            Kind::Quads => {
                let all = named("quads")?;
                all.set_item("faces", indices)?;
                all.into_any()
            }
            Kind::Grids => {
                let all = named("grids")?;
                all.set_item("grids", indices)?;
                all.into_any()
            }
            Kind::Points(form) => {
                let all = named("points")?;
                all.set_item("form", word(form, &POINT_FORMS))?;
                all.into_any()
            }
            Kind::Curves(basis, form) => {
                let all = named("curves")?;
                all.set_item("segments", indices)?;
                all.set_item("basis", word(basis, &BASES))?;
                all.set_item("form", word(form, &CURVE_FORMS))?;
                all.into_any()
            }
        })
    }

    /// A geometry from the value of `pickled`, checked.
    pub(crate) fn restored(kept: Object, dtype: &str) -> PyResult<Self> {
        let Ok(all) = kept.cast::<PyDict>() else {
            let (vertices, faces, placement): (Bound<PyAny>, Bound<PyAny>, Option<Bound<PyAny>>) =
                kept.extract()?;
            return Self::mesh(&vertices, &faces, Kind::Triangles, false, dtype)?.placed(placement.as_ref());
        };
        if dtype != "float32" {
            return Err(PyValueError::new_err(format!("dtype: a scene of {dtype} has triangles only")));
        }
        let get = |name: &str| all.get_item(name);
        let need = |name: &str| {
            get(name)?.ok_or_else(|| PyValueError::new_err(format!("{name}: missing in a geometry")))
        };
        let text = |name: &str| need(name)?.extract::<String>();
        let vertices = need("vertices")?;
        let [normals, tangents, normal_tangents] =
            [get("normals")?, get("tangents")?, get("normal_tangents")?];
        let made = match text("kind")?.as_str() {
            "quads" => Self::mesh(&vertices, &need("faces")?, Kind::Quads, false, dtype)?,
            "grids" => Self::grids(&vertices, &need("grids")?, false)?,
            "points" => {
                let (radii, form) = (&need("radii")?, &text("form")?);
                let normals = normals.as_ref();
                Self::points(&PointArguments { vertices: &vertices, radii, form, normals }, false)?
            }
            "curves" => {
                let given = CurveArguments {
                    vertices: &vertices,
                    radii: &need("radii")?,
                    counts: None,
                    segments: Some(&need("segments")?),
                    basis: &text("basis")?,
                    form: &text("form")?,
                    normals: normals.as_ref(),
                    tangents: tangents.as_ref(),
                    normal_tangents: normal_tangents.as_ref(),
                };
                Self::curves(&given, false)?
            }
            other => return Err(PyValueError::new_err(format!("kind: unknown: \"{other}\""))),
        };
        made.placed(get("transform")?.as_ref())
    }
}

/// The first vertex of each curve, uint32: as given, or of strands with these numbers of vertices.
fn segments(given: &CurveArguments, basis: CurveBasis, vertices: usize) -> PyResult<Py<PyAny>> {
    let [order, step] = order_and_step(basis);
    let py = given.vertices.py();
    let (name, value) = match (given.counts, given.segments) {
        (Some(_), Some(_)) => {
            return Err(PyTypeError::new_err("segments: valid without counts only"));
        }
        (None, Some(segments)) => ("segments", array("segments", segments)?),
        (Some(counts), None) => ("counts", array("counts", counts)?),
        (None, None) => ("counts", array("counts", &vec![vertices].into_pyobject(py)?)?),
    };
    let wide = of_type(&whole(name, &value, None)?, "int64")?;
    let all = Rows::<i64>::new(&wide)?.ok_or_else(|| PyValueError::new_err(format!("{name}: has gaps")))?;
    let all = all.all();
    let mut firsts: Vec<u32> = Vec::new();
    if name == "segments" {
        for (row, &first) in all.iter().enumerate() {
            let end = usize::try_from(first).ok().and_then(|first| first.checked_add(order));
            if end.is_none_or(|end| end > vertices) {
                return Err(PyValueError::new_err(format!(
                    "segments: row {row} starts at vertex {first} and takes {order}, and there are {vertices} vertices, from 0 on"
                )));
            }
            firsts.push(first as u32);
        }
    } else {
        let sum = all.iter().try_fold(0_i64, |sum, &count| sum.checked_add(count).filter(|_| count >= 0));
        if sum != i64::try_from(vertices).ok() {
            return Err(PyValueError::new_err(format!(
                "counts: expected numbers from 0 on whose sum is {vertices}, the number of vertices"
            )));
        }
        let mut first = 0;
        for (row, &count) in all.iter().enumerate() {
            let count = count as usize;
            // A strand of no vertices has no curve; others end where their last curve does.
            if count > 0 && (count < order || !(count - order).is_multiple_of(step)) {
                let steps = if step == 1 { String::new() } else { format!(" plus a multiple of {step}") };
                return Err(PyValueError::new_err(format!(
                    "counts: row {row} is {count}; a strand of this basis has {order} vertices{}{steps}",
                    if step == 1 { " or more" } else { "" }
                )));
            }
            firsts.extend(
                (0..count / step)
                    .map(|i| first + i * step)
                    .filter(|at| at + order <= first + count)
                    .map(|at| at as u32),
            );
            first += count;
        }
    }
    Ok(crate::arrays::New::of(py, &firsts)?.done())
}

/// Rows of a matrix for columns of an affine map.
pub(crate) fn matrix(columns: &[[f64; 3]; 4]) -> Vec<Vec<f64>> {
    let mut rows: Vec<Vec<f64>> = (0..3).map(|k| columns.iter().map(|column| column[k]).collect()).collect();
    rows.push(vec![0.0, 0.0, 0.0, 1.0]);
    rows
}
