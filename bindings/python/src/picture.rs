// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt.Picture`. See docs/reference/python.md. Tests: `tests/test_pictures.py`.

use std::path::PathBuf;

use gnurt::denoise::{self, Method, Options};
use gnurt::display_rules::TONE;
use gnurt::image::{
    self, ChannelData, ExrPixels, Opacity, PictureFormat, ToneCurve, WorkingSpace, WriteOptions, exposure_for,
};
use gnurt::mattes;
use gnurt::ocio::{Request, View};
use gnurt::relight::{self, Gain};
use gnurt::render::MatteKind;
use pyo3::exceptions::{PyKeyError, PyOSError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arrays::New;
use crate::pixels::texels;
use crate::pool::{ThreadCount, with_all_threads};

/// Names of layers and of their channels, in order.
type Names = Vec<(String, Vec<String>)>;

/// The parts of a pickled picture: an EXR file, the colours and whether they are associated, exposure, rendered part,
/// names, space.
type Kept<'py> =
    (Bound<'py, PyBytes>, Bound<'py, PyBytes>, bool, Option<f32>, Option<[u32; 4]>, Names, &'static str);

/// Linear light with opacity, and its layers.
#[pyclass(module = "gnurt", frozen)]
pub(crate) struct Picture {
    pub(crate) picture: image::Picture,
    /// Stops, where they do not depend on the picture.
    pub(crate) exposure: Option<f32>,
    /// The rendered part of the frame; `None` = all.
    pub(crate) crop: Option<[u32; 4]>,
    /// The space in which its light was computed: that of the colours of its EXR.
    pub(crate) space: WorkingSpace,
}

/// The Python error for a picture file.
pub(crate) fn image_error(error: &image::Error) -> PyErr {
    match error {
        image::Error::File { .. } => PyOSError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The same for the surroundings of a scene: a picture, or a sky in the shading language.
pub(crate) fn surroundings_error(error: &gnurt::Error) -> PyErr {
    match error {
        gnurt::Error::Image(error) => image_error(error),
        _ => PyValueError::new_err(error.to_string()),
    }
}

impl Picture {
    /// As a file of this format shows it: on a screen the background is part of the picture.
    fn encoded(&self, format: &'static PictureFormat, options: &WriteOptions) -> PyResult<Vec<u8>> {
        if format == PictureFormat::EXR {
            let pool = gnurt::thread_pool(0).map_err(|error| surroundings_error(&error))?;
            let bytes = image::encode_with(&self.picture, format, options, &gnurt::workers(Some(&pool)));
            return bytes.map_err(|error| image_error(&error));
        }
        let mut seen = self.picture.clone();
        seen.make_opaque(self.crop);
        image::encode(&seen, format, options).map_err(|error| image_error(&error))
    }

    fn display_rules(&self, tone: Option<&str>, exposure: Option<f32>) -> PyResult<WriteOptions> {
        let tone: ToneCurve = match tone {
            None => TONE,
            Some(name) => name.parse().map_err(|error| PyValueError::new_err(format!("tone: {error}")))?,
        };
        if exposure.is_some_and(|stops| !stops.is_finite()) {
            return Err(PyValueError::new_err("exposure: expected a finite number of stops"));
        }
        let exposure = exposure.or(self.exposure).unwrap_or_else(|| exposure_for(&self.picture));
        Ok(WriteOptions { tone, exposure, exr_space: self.space, ..WriteOptions::default() })
    }
}

#[pymethods]
impl Picture {
    /// A picture of a file with its layers, or of an array as textures take it: bytes are sRGB, floats linear light.
    #[new]
    fn new(py: Python<'_>, source: &Bound<'_, PyAny>) -> PyResult<Self> {
        let picture = match source.extract::<PathBuf>() {
            Ok(path) => py
                .detach(|| with_all_threads(|workers| image::read_with(&path, workers)))
                .map_err(|error| image_error(&error))?,
            Err(_) => {
                let texels = texels(source, true)?;
                let mut picture = image::Picture::new(texels.width, texels.height);
                let width = texels.width as usize;
                for (i, pixel) in picture.color.iter_mut().enumerate() {
                    *pixel = texels.texel(i % width, i / width);
                }
                picture
            }
        };
        Ok(Self { picture, exposure: None, crop: None, space: WorkingSpace::default() })
    }

    /// For pickle. A file has the colour without its background, so the colour is kept beside it.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Kept<'py>)> {
        let (py, this) = (slf.py(), slf.get());
        let exact = WriteOptions { exr_pixels: ExrPixels::Float, ..WriteOptions::default() };
        let bytes = py
            .detach(|| image::encode(&this.picture, PictureFormat::EXR, &exact))
            .map_err(|error| image_error(&error))?;
        let color: Vec<u8> =
            this.picture.color.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        let is_associated = this.picture.opacity == Opacity::Associated;
        let restore = slf.get_type().getattr("_restored")?;
        let (bytes, color) = (PyBytes::new(py, &bytes), PyBytes::new(py, &color));
        let names = |layer: &image::Layer| {
            (layer.name.clone(), layer.channels.iter().map(|channel| channel.name.clone()).collect())
        };
        let names = this.picture.layers.iter().map(names).collect();
        Ok((restore, (bytes, color, is_associated, this.exposure, this.crop, names, this.space.name())))
    }

    /// The space is new: older pickles have none.
    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "the parts of a picture")]
    #[pyo3(signature = (exr, color, is_associated, exposure, crop, names, space="rec709"))]
    fn _restored(
        py: Python<'_>,
        exr: &[u8],
        color: &[u8],
        is_associated: bool,
        exposure: Option<f32>,
        crop: Option<[u32; 4]>,
        names: Names,
        space: &str,
    ) -> PyResult<Self> {
        let mut picture =
            py.detach(|| image::decode(exr, "pickled picture")).map_err(|error| image_error(&error))?;
        let (texels, rest) = color.as_chunks::<16>();
        if texels.len() != picture.color.len() || !rest.is_empty() {
            return Err(PyValueError::new_err("pickled picture: its colours do not fit its size"));
        }
        // A file sorts them by name.
        picture.layers.sort_by_key(|layer| names.iter().position(|(name, _)| *name == layer.name));
        for (layer, (_, channels)) in picture.layers.iter_mut().zip(&names) {
            layer.channels.sort_by_key(|channel| channels.iter().position(|name| *name == channel.name));
        }
        let texel = |bytes: &[u8; 16]| {
            let mut numbers = bytes.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
            std::array::from_fn(|_| numbers.next().unwrap_or(0.0))
        };
        let color = texels.iter().map(texel).collect();
        let opacity = if is_associated { Opacity::Associated } else { Opacity::Straight };
        let space = space.parse().map_err(|why| PyValueError::new_err(format!("pickled picture: {why}")))?;
        Ok(Self { picture: image::Picture { color, opacity, ..picture }, exposure, crop, space })
    }

    #[getter]
    fn width(&self) -> u32 {
        self.picture.width
    }

    #[getter]
    fn height(&self) -> u32 {
        self.picture.height
    }

    /// Names of the layers.
    #[getter]
    fn layers(&self) -> Vec<&str> {
        self.picture
            .layers
            .iter()
            .map(|layer| if layer.name.is_empty() { "Z" } else { &layer.name[..] })
            .collect()
    }

    /// The metadata of the picture.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        self.picture.metadata.iter().try_for_each(|(name, value)| all.set_item(name, value))?;
        Ok(all)
    }

    #[pyo3(signature = (dtype=None, copy=None))]
    fn __array__<'py>(
        &self,
        py: Python<'py>,
        dtype: Option<&Bound<'py, PyAny>>,
        copy: Option<bool>,
    ) -> PyResult<Bound<'py, PyAny>> {
        if copy == Some(false) {
            return Err(PyValueError::new_err("copy: a picture's array is always a copy"));
        }
        let (width, height) = (self.picture.width as usize, self.picture.height as usize);
        let mut array = New::<f32>::empty(py, width * height, 4)?;
        array.all().copy_from_slice(self.picture.color.as_flattened());
        let array = array.done().into_bound(py).call_method1("reshape", (height, width, 4))?;
        match dtype {
            Some(dtype) => array.call_method1("astype", (dtype,)),
            None => Ok(array),
        }
    }

    /// float32 or uint32 (height, width, channels), or (height, width) of a layer that has one channel.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let request = if name == "Z" { "" } else { name };
        let Some(layer) = self.picture.layer(request) else {
            let all = self.layers().join(", ");
            return Err(PyKeyError::new_err(format!(
                "unknown layer '{name}'; the picture has {}",
                if all.is_empty() { "none: render with layers=True" } else { &all }
            )));
        };
        let (width, height) = (self.picture.width as usize, self.picture.height as usize);
        let channels = layer.channels.len();
        let shape = |array: Bound<'py, PyAny>| match channels {
            1 => array.call_method1("reshape", (height, width)),
            _ => array.call_method1("reshape", (height, width, channels)),
        };
        let is_ids = layer.channels.iter().all(|channel| matches!(channel.data, ChannelData::U32(_)));
        if is_ids {
            let mut array = New::<u32>::empty(py, width * height, channels)?;
            let all = array.all();
            for (c, channel) in layer.channels.iter().enumerate() {
                if let ChannelData::U32(values) = &channel.data {
                    values.iter().enumerate().for_each(|(i, value)| all[i * channels + c] = *value);
                }
            }
            return shape(array.done().into_bound(py));
        }
        let mut array = New::<f32>::empty(py, width * height, channels)?;
        let all = array.all();
        for (c, channel) in layer.channels.iter().enumerate() {
            match &channel.data {
                ChannelData::F32(values) => {
                    values.iter().enumerate().for_each(|(i, value)| all[i * channels + c] = *value);
                }
                ChannelData::U32(values) => {
                    values.iter().enumerate().for_each(|(i, value)| all[i * channels + c] = *value as f32);
                }
            }
        }
        shape(array.done().into_bound(py))
    }

    /// Writes it: .png, .jpg, .webp, .exr, .hdr or .pfm. Curve and exposure are for the first three; without an exposure one is
    /// chosen. `ocio` is a configuration of OpenColorIO, whose view replaces the curve: a file, or `ocio://default`. `primaries`
    /// are those of an EXR's colours, rec709 or acescg; without them those of the working space.
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    #[pyo3(signature = (path, *, tone=None, exposure=None, exact=false, ocio=None, display=None, view=None, looks=None, primaries=None))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        tone: Option<&str>,
        exposure: Option<f32>,
        exact: bool,
        ocio: Option<PathBuf>,
        display: Option<&str>,
        view: Option<&str>,
        looks: Option<&str>,
        primaries: Option<&str>,
    ) -> PyResult<()> {
        let format = PictureFormat::from_path(&path).map_err(|error| image_error(&error))?;
        let mut options = self.display_rules(tone, exposure)?;
        if let Some(name) = primaries {
            options.exr_space =
                name.parse().map_err(|why| PyValueError::new_err(format!("primaries: {why}")))?;
        }
        if let Some(config) = ocio {
            if tone.is_some() {
                return Err(PyValueError::new_err("tone: a view of `ocio` replaces it; give one of the two"));
            }
            if !format.is_for_screens {
                return Err(PyValueError::new_err(
                    "ocio: this format keeps the light as it is; give a .png, .jpg or .webp",
                ));
            }
            let config = config.to_string_lossy();
            let request = Request { config: &config, display, view, looks, source: None };
            return py.detach(|| {
                let view =
                    View::new(&request).map_err(|error| PyValueError::new_err(format!("ocio: {error}")))?;
                let mut seen = self.picture.clone();
                seen.make_opaque(self.crop);
                let shown = with_all_threads(|workers| view.shown(&seen, options.exposure, workers));
                let options = WriteOptions { tone: ToneCurve::Clamp, exposure: 0.0, ..options };
                image::write(&shown, &path, &options).map_err(|error| image_error(&error))
            });
        }
        if [display, view, looks].iter().any(Option::is_some) {
            return Err(PyValueError::new_err(
                "ocio: missing; display, view and looks are names of its configuration",
            ));
        }
        if exact {
            options.exr_pixels = ExrPixels::Float;
        }
        py.detach(|| {
            let bytes = self.encoded(format, &options)?;
            image::replace_file(&path, &bytes).map_err(|error| image_error(&error))
        })
    }

    /// The bytes of a PNG.
    #[pyo3(signature = (*, tone=None, exposure=None))]
    fn png<'py>(
        &self,
        py: Python<'py>,
        tone: Option<&str>,
        exposure: Option<f32>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let options = self.display_rules(tone, exposure)?;
        Ok(PyBytes::new(py, &py.detach(|| self.encoded(PictureFormat::PNG, &options))?))
    }

    /// The representation in notebooks.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.png(py, None, None)
    }

    /// The picture without its noise. It needs the layers, which `render(layers=True)` gives.
    #[pyo3(signature = (method="auto", *, threads=0))]
    fn denoise(&self, py: Python<'_>, method: &str, threads: usize) -> PyResult<Self> {
        let method: Method =
            method.parse().map_err(|error| PyValueError::new_err(format!("method: {error}")))?;
        let threads = ThreadCount::new(threads)?;
        let mut picture = self.picture.clone();
        py.detach(|| take_noise_out(&mut picture, method, self.crop, threads))?;
        Ok(Self { picture, exposure: self.exposure, crop: self.crop, space: self.space })
    }

    /// The light groups of the picture.
    #[getter]
    fn light_groups(&self) -> Vec<String> {
        relight::light_groups(&self.picture)
    }

    /// The picture with other strengths of its light groups: a number each, or three for red, green and blue; `rest` is light without a group.
    #[pyo3(signature = (**gains))]
    fn relight(&self, py: Python<'_>, gains: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut all = Vec::new();
        for (group, value) in gains.into_iter().flatten() {
            let group: String = group.extract()?;
            let color = match value.extract::<f32>() {
                Ok(gain) => [gain; 3],
                Err(_) => value.extract::<[f32; 3]>().map_err(|_| {
                    PyTypeError::new_err(format!("{group}: expected a number or three numbers"))
                })?,
            };
            all.push(Gain { group, color });
        }
        let gains = all;
        let mut picture = self.picture.clone();
        py.detach(|| relight::relight(&mut picture, &gains)).map_err(PyValueError::new_err)?;
        Ok(Self { picture, exposure: self.exposure, crop: self.crop, space: self.space })
    }

    /// float32 (height, width): how much of each pixel the thing of this name covers, by Cryptomatte. Kinds are object, material, asset.
    #[pyo3(signature = (name, kind="object"))]
    fn matte<'py>(&self, py: Python<'py>, name: &str, kind: &str) -> PyResult<Bound<'py, PyAny>> {
        let kind = match kind {
            "object" => MatteKind::Object,
            "material" => MatteKind::Material,
            "asset" => MatteKind::Asset,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "kind: unknown kind of mattes '{kind}'; valid are: object, material, asset"
                )));
            }
        };
        let Some(covered) = mattes::matte(&self.picture, kind, name) else {
            return Err(PyKeyError::new_err(format!(
                "no {}: render with layers=\"cryptomatte\"",
                kind.layer()
            )));
        };
        let mut array = New::<f32>::empty(py, covered.len(), 1)?;
        array.all().copy_from_slice(&covered);
        let (width, height) = (self.picture.width as usize, self.picture.height as usize);
        array.done().into_bound(py).call_method1("reshape", (height, width))
    }

    fn __repr__(&self) -> String {
        let image::Picture { width, height, layers, .. } = &self.picture;
        format!("<gnurt.Picture: {width}x{height}, {} layers>", layers.len())
    }
}

/// Options of the filter for a part of a picture, or for all of it.
pub(crate) fn noise_options(method: Method, region: Option<[u32; 4]>) -> Options {
    let library = std::env::var_os("OIDN_LIB").filter(|file| !file.is_empty()).map(Into::into);
    Options { method, region, library }
}

/// Takes the noise out of a picture with layers.
pub(crate) fn take_noise_out(
    picture: &mut image::Picture,
    method: Method,
    region: Option<[u32; 4]>,
    threads: ThreadCount,
) -> PyResult<()> {
    let options = noise_options(method, region);
    let error = |error: denoise::Error| PyValueError::new_err(format!("denoise: {error}"));
    let used = denoise::denoise(picture, &options, &*threads.pool()?).map_err(error)?;
    picture.set_metadata("denoiser", used.name());
    Ok(())
}
