// SPDX-License-Identifier: GPL-3.0-or-later
//! Intel's Open Image Denoise, where its library is found.
//! Invariant: pixels that come back broken keep the colour that they had. Tests: `tests`.

use std::path::Path;

use crate::error::Error;
use crate::ffi_oidn::{Device, Images, Library};
use crate::method::Used;
use crate::noisy::{Noisy, Triple};

/// Where it is searched unless it is named.
#[cfg(target_os = "macos")]
const USUAL: &str = "libOpenImageDenoise.2.dylib";
#[cfg(not(target_os = "macos"))]
const USUAL: &str = "libOpenImageDenoise.so.2";

/// Whether the library is there and opens a device.
pub(crate) fn check(library: Option<&Path>) -> Result<(), Error> {
    let library = Library::open(library.unwrap_or(USUAL.as_ref())).map_err(Error::Oidn)?;
    Device::open(&library, 1).map(drop).map_err(Error::Oidn)
}

/// The colours of the region without noise, row by row.
pub(crate) fn filter(
    noisy: &Noisy,
    library: Option<&Path>,
    threads: usize,
) -> Result<(Vec<Triple>, Used), Error> {
    let library = Library::open(library.unwrap_or(USUAL.as_ref())).map_err(Error::Oidn)?;
    let device = Device::open(&library, threads).map_err(Error::Oidn)?;
    let albedo: Vec<Triple> = noisy.albedo.iter().map(|a| a.map(|x| x.clamp(0.0, 1.0))).collect();
    let normal: Vec<Triple> = noisy.normal.iter().map(|n| n.map(|x| x.clamp(-1.0, 1.0))).collect();
    let color: Vec<Triple> = match &noisy.seen {
        Some(seen) => {
            noisy.color.iter().zip(seen.light.iter().zip(&seen.split)).map(without_chance).collect()
        }
        None => noisy.color.clone(),
    };
    let images =
        Images { width: noisy.width, height: noisy.height, color: &color, albedo: &albedo, normal: &normal };
    let mut clean = device.filter(&images).map_err(Error::Oidn)?;
    for (clean, noisy) in clean.iter_mut().zip(&noisy.color) {
        if clean.iter().any(|x| !x.is_finite()) {
            *clean = *noisy;
        }
    }
    let version = device.version();
    let version = format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100);
    Ok((clean, Used::Oidn { version, device: "CPU" }))
}

/// A colour with the light behind mirrors and glass from all branches in place of those that paths chose.
fn without_chance((color, (light, split)): (&Triple, (&Triple, &Triple))) -> Triple {
    [0, 1, 2].map(|k| (color[k] - light[k]).max(0.0) + split[k].max(0.0))
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use gnurt_image::{Layer, Picture};

    use super::*;
    use crate::{Method, Options, denoise};

    /// A library with the functions of the real one: it gives 2 * colour + albedo + normal, if all is set as it should be.
    const STAND_IN: &str = r#"
        #include <stddef.h>
        #include <stdlib.h>
        #include <string.h>
        #include <stdbool.h>
        static const float *images[3]; static float *output; static size_t width, height;
        static int hdr, committed, error;
        static int device;
        void *oidnNewDevice(int type) { error = type == 1 ? 0 : 1; return type == 1 ? &device : 0; }
        void oidnReleaseDevice(void *d) { if (d != &device) abort(); }
        void oidnSetDeviceInt(void *d, const char *name, int value) { (void)d; (void)name; (void)value; }
        int oidnGetDeviceInt(void *d, const char *name) { (void)d; return strcmp(name, "version") ? 0 : VERSION; }
        int oidnGetDeviceError(void *d, const char **text) { (void)d; int e = error; error = 0;
            if (e) *text = "a picture\nof nothing"; return e; }
        void oidnCommitDevice(void *d) { (void)d; }
        void *oidnNewFilter(void *d, const char *type) { (void)d; return strcmp(type, "RT") ? 0 : &hdr; }
        void oidnReleaseFilter(void *f) { if (f != &hdr) abort(); }
        void oidnSetSharedFilterImage(void *f, const char *name, void *data, int format, size_t w, size_t h,
                                      size_t offset, size_t pixel, size_t row) {
            (void)f; if (format != 3 || offset || pixel || row) error = 2;
            width = w; height = h;
            if (!strcmp(name, "color")) images[0] = data; else if (!strcmp(name, "albedo")) images[1] = data;
            else if (!strcmp(name, "normal")) images[2] = data; else if (!strcmp(name, "output")) output = data;
            else error = 3; }
        void oidnSetFilterBool(void *f, const char *name, bool value) { (void)f; hdr = value && !strcmp(name, "hdr"); }
        void oidnCommitFilter(void *f) { (void)f; committed = 1; }
        void oidnExecuteFilter(void *f) { (void)f; if (!hdr || !committed || width == 1) { error = 4; return; }
            for (size_t i = 0; i < 3 * width * height; ++i)
                output[i] = 2 * images[0][i] + images[1][i] + images[2][i]; }
    "#;

    /// Compiles the substitute library; `None`, loudly, if there is no C compiler.
    fn stand_in(folder: &Path, version: &str) -> Option<std::path::PathBuf> {
        let (source, library) = (folder.join("a.c"), folder.join(format!("lib{version}.so")));
        std::fs::write(&source, STAND_IN).expect("the folder is ours");
        let define = format!("-DVERSION={version}");
        let done =
            Command::new("cc").args(["-shared", "-fPIC", &define, "-o"]).arg(&library).arg(&source).status();
        let done = done.is_ok_and(|status| status.success());
        if !done {
            eprintln!("SKIPPED: no C compiler 'cc'");
        }
        done.then_some(library)
    }

    /// Every value of a layer differs from those of others.
    fn picture(width: u32, height: u32) -> Picture {
        let mut picture = Picture::new(width, height);
        let pixels = picture.pixel_count();
        for (i, pixel) in picture.color.iter_mut().enumerate() {
            *pixel = [i as f32, i as f32 + 0.25, 0.5, 0.75];
        }
        let ramp = |k: usize| (0..pixels).map(|i| ((i * 3 + k) % 16) as f32 / 16.0).collect::<Vec<_>>();
        for (name, [a, b, c]) in [
            ("albedo", ["R", "G", "B"]),
            ("variance", ["R", "G", "B"]),
            ("N", ["X", "Y", "Z"]),
            ("P", ["X", "Y", "Z"]),
        ] {
            let shift = name.len();
            picture
                .layers
                .push(Layer::floats(name, [(a, ramp(shift)), (b, ramp(shift + 1)), (c, ramp(shift + 2))]));
        }
        picture
    }

    fn pool() -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread")
    }

    #[test]
    fn the_library_gets_all_images_and_gives_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let Some(library) = stand_in(folder.path(), "20304") else { return };
        let before = picture(5, 4);
        let mut after = before.clone();
        let region = Some([1, 1, 4, 3]);
        let options = Options { method: Method::Oidn, region, library: Some(library) };
        let used = denoise(&mut after, &options, &pool()).expect("the stand-in works");
        assert_eq!(used, Used::Oidn { version: "2.3.4".into(), device: "CPU" }, "as it says");
        for (i, (before, after)) in before.color.iter().zip(&after.color).enumerate() {
            let (x, y) = (i % 5, i / 5);
            for k in 0..3 {
                let ramp = |shift: usize| ((i * 3 + k + shift) % 16) as f32 / 16.0;
                let expected = 2.0 * before[k] + ramp("albedo".len()) + ramp("N".len());
                let inside = (1..4).contains(&x) && (1..3).contains(&y);
                assert_eq!(after[k], if inside { expected } else { before[k] }, "pixel {x}, {y}");
            }
        }
    }

    #[test]
    fn what_the_library_complains_of_is_passed_on() {
        let folder = tempfile::tempdir().expect("a folder");
        let Some(library) = stand_in(folder.path(), "20000") else { return };
        let options = |method| Options { method, region: None, library: Some(library.clone()) };
        let error =
            denoise(&mut picture(1, 4), &options(Method::Oidn), &pool()).expect_err("one column is refused");
        assert_eq!(
            error.to_string(),
            "Open Image Denoise cannot be used: a picture of nothing",
            "in one line"
        );
        let used =
            denoise(&mut picture(1, 4), &options(Method::Auto), &pool()).expect("there is another way");
        assert!(
            used.to_string().contains("built-in filter: Open Image Denoise cannot be used: a picture"),
            "{used}"
        );
    }

    #[test]
    fn other_versions_and_other_files_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let message = |file: &Path| {
            let options = Options { method: Method::Oidn, region: None, library: Some(file.into()) };
            crate::check(&options).expect_err("it is not OIDN 2").to_string()
        };
        let missing = message(&folder.path().join("no.so"));
        assert!(missing.contains("no.so"), "{missing}");
        if let Some(library) = stand_in(folder.path(), "30001") {
            assert!(message(&library).contains("30001"), "the version is told");
        }
        if cfg!(target_os = "linux") {
            let other = message("libc.so.6".as_ref());
            assert!(other.contains("lacks oidnNewDevice"), "{other}");
        }
    }

    #[test]
    fn the_real_one_takes_noise_out() {
        let Some(file) = std::env::var_os("OIDN_LIB") else {
            eprintln!("SKIPPED: OIDN_LIB names no library of Open Image Denoise");
            return;
        };
        let mut noisy = picture(64, 64);
        let mut random = gnurt_testkit::Random::new(5);
        noisy.color.iter_mut().for_each(|pixel| *pixel = [random.between(0.5, 1.5); 4]);
        for layer in &mut noisy.layers {
            layer
                .channels
                .iter_mut()
                .for_each(|c| c.data = gnurt_image::ChannelData::F32(vec![0.5; 64 * 64]));
        }
        let options = Options { method: Method::Oidn, region: None, library: Some(file.into()) };
        let used = denoise(&mut noisy, &options, &pool()).expect("OIDN works");
        eprintln!("{used}");
        let spread = noisy.color.iter().map(|pixel| (pixel[0] - 1.0).powi(2)).sum::<f32>() / (64.0 * 64.0);
        assert!(spread < 0.02, "the variance was a twelfth, and is {spread}");
    }
}
