// SPDX-License-Identifier: GPL-3.0-or-later
//! `gnurt join PIECE.. -o OUT`: pieces become the picture, with the bytes that one call of `render` would have written.
//! Invariant: nothing is written unless all pieces are there, and are of one picture. Noise is taken out here, under
//! the rule that `render` has. Tests: `tests/program/pieces.rs`.

use std::path::{Path, PathBuf};

use gnurt::denoise::{self, denoise};
use gnurt::display_rules::{FEW_SAMPLES, is_noisy};
use gnurt::image::{self, Opacity, Picture};
use gnurt::layers::{LayerList, drop_seen};
use gnurt::mattes;
use gnurt::memory::check_memory;
use gnurt::render::{Piece, empty_picture, pack_piece, rendered_rects, unpack_piece};

use super::pieces::Header;
use crate::arguments::JoinArguments;
use crate::environment::Environment;
use crate::failure::{Failure, Outcome};
use crate::messages::Messages;
use crate::output::{Output, is_same_file};
use crate::picture_header::command;
use crate::signals::{self, FirstSignal};
use crate::workers::{machine, read_picture};

/// A picture that is put together.
struct Whole {
    /// That of the first piece.
    header: Header,
    /// The file of each piece, once it is there.
    files: Vec<Option<PathBuf>>,
    picture: Picture,
    /// Metadata of the first file.
    metadata: Vec<(String, String)>,
    /// Most samples of a pixel.
    spp_max: u32,
    seconds: f64,
}

/// Joins.
pub(crate) fn run(arguments: &JoinArguments, environment: &Environment, messages: Messages) -> Outcome {
    let output = Output::named(&arguments.output)?.through(&arguments.ocio)?;
    if arguments.pieces.iter().any(|piece| is_same_file(piece, output.path())) {
        return Err(Failure::usage(format_args!(
            "{} is one of the pieces; give another name to write to",
            output.path().display()
        )));
    }
    if let Some(how) = arguments.denoiser.options(None) {
        denoise::check(&how).map_err(Failure::data)?;
    }
    output.check()?;
    signals::listen(FirstSignal::Leaves, messages)?;
    let mut whole = Whole::of(&arguments.pieces)?;
    whole.check_all_there()?;
    let used = whole.take_noise_out(arguments, &output, environment, messages)?;
    let picture = whole.finished(&output, used);
    let mut light = arguments.light.suited(whole.header.exposure);
    light.file.within(whole.header.space);
    if !whole.header.light_layers.is_empty() {
        light.file.exact();
    }
    output.write_with(&picture, light, messages)?;
    messages.detail(format_args!("wrote {} from {} pieces", output.path().display(), whole.files.len()));
    Ok(())
}

impl Whole {
    fn of(files: &[PathBuf]) -> Result<Self, Failure> {
        let mut whole: Option<Self> = None;
        for file in files {
            let packed = read_picture(file).map_err(Failure::data)?;
            let header = Header::of(&packed).ok_or_else(|| {
                Failure::data(format_args!(
                    "{}: not a piece of a picture; `gnurt render --piece I/N` writes them",
                    file.display()
                ))
            })?;
            let whole = match &mut whole {
                Some(whole) => whole,
                None => whole.insert(Self::begin(file, header.clone(), &packed)?),
            };
            whole.add(file, &header, packed)?;
        }
        whole.ok_or_else(|| Failure::usage("pieces missing"))
    }

    fn begin(file: &Path, header: Header, packed: &Picture) -> Result<Self, Failure> {
        let bad = |why: &dyn std::fmt::Display| Failure::data(format_args!("{}: {why}", file.display()));
        let options = header.options();
        check_memory(&options, false).map_err(|why| bad(&why))?;
        let picture = empty_picture(&options).map_err(|why| bad(&why))?;
        let files = vec![None; header.piece.count as usize];
        let metadata = packed.metadata.clone();
        Ok(Self { header, files, picture, metadata, spp_max: 0, seconds: 0.0 })
    }

    fn add(&mut self, file: &Path, header: &Header, packed: Picture) -> Outcome {
        let name = file.display();
        let first = self.files.iter().flatten().next().map_or(file, |first| first).display().to_string();
        let known = &self.header;
        if header.piece.count != known.piece.count {
            return Err(Failure::data(format_args!(
                "{name} is one of {} pieces, {first} one of {}",
                header.piece.count, known.piece.count
            )));
        }
        if header.spp != known.spp {
            return Err(Failure::data(format_args!(
                "{name} has {} samples per pixel, {first} has {}",
                header.spp, known.spp
            )));
        }
        if (Header { piece: known.piece, ..header.clone() }) != *known {
            return Err(Failure::data(format_args!(
                "{name} is of another picture than {first}: scene, camera, options or the version of the program differ"
            )));
        }
        let bad = || Failure::data(format_args!("{name}: is damaged: its pixels are not those of its piece"));
        let rects = rendered_rects(&header.options()).map_err(|_| bad())?;
        let slot = header.piece.index as usize;
        if let Some(other) = &self.files[slot] {
            // Made twice, and so the same twice.
            let there = pack_piece(&self.picture, &rects);
            if there.color != packed.color || there.layers.iter().any(|layer| !has_layer(&packed, layer)) {
                return Err(Failure::data(format_args!(
                    "{name} and {} are both piece {} and differ: one of them is damaged",
                    other.display(),
                    header.piece
                )));
            }
            return Ok(());
        }
        if !unpack_piece(&mut self.picture, &packed, &rects) {
            return Err(bad());
        }
        mattes::merge(&mut self.picture, &packed);
        let number = |name: &str| packed.metadata(name).and_then(|text| text.parse::<f64>().ok());
        self.spp_max = self.spp_max.max(number("samplesPerPixel").unwrap_or(0.0) as u32);
        self.seconds += number("renderTimeSeconds").unwrap_or(0.0);
        self.files[slot] = Some(file.to_owned());
        Ok(())
    }

    fn check_all_there(&self) -> Outcome {
        const TOLD: usize = 8;
        let count = self.header.piece.count;
        let missing = || (0..count).filter(|&index| self.files[index as usize].is_none());
        let all = missing().count();
        if all == 0 {
            return Ok(());
        }
        let reported: Vec<String> =
            missing().take(TOLD).map(|index| Piece { index, count }.to_string()).collect();
        let more = if all > TOLD { format!(" and {} others", all - TOLD) } else { String::new() };
        let verb = if all == 1 { "is" } else { "are" };
        Err(Failure::data(format_args!("piece {}{more} {verb} missing", reported.join(", "))))
    }

    /// As `render` does: where it is requested, or a picture for screens has few samples. The name of the
    /// filter.
    fn take_noise_out(
        &mut self,
        arguments: &JoinArguments,
        output: &Output,
        environment: &Environment,
        messages: Messages,
    ) -> Result<Option<String>, Failure> {
        let Header { crop, spp, integrator, .. } = self.header;
        let how = arguments.denoiser;
        let is_default = how.is_left_open()
            && output.is_for_screens()
            && is_noisy(integrator, 1)
            && spp.min(self.spp_max) < FEW_SAMPLES
            && check_memory(&self.header.options(), true).is_ok();
        let requested = how.options(crop).or_else(|| how.options_or_built_in(crop).filter(|_| is_default));
        let Some(options) = requested else { return Ok(None) };
        let (pool, _) = machine(&arguments.machine, environment)?;
        let used = denoise(&mut self.picture, &options, &pool).map_err(Failure::data)?;
        if is_default {
            messages.note(format_args!(
                "{used}, for there are fewer than {FEW_SAMPLES} samples; --denoise=none leaves it"
            ));
        } else {
            messages.note(&used);
        }
        Ok(Some(used.name().to_owned()))
    }

    /// The picture with the metadata of its file.
    fn finished(&mut self, output: &Output, denoiser: Option<String>) -> Picture {
        let mut picture = std::mem::take(&mut self.picture);
        picture.convert_from(self.header.space);
        let is_clean = denoiser.is_some();
        if let Some(name) = denoiser {
            picture.set_metadata("denoiser", name);
        }
        if let Some(layers) = self.header.layers.as_ref().filter(|_| output.has_layers()) {
            layers.apply(&mut picture, &self.header.light_layers);
        }
        if !self.header.layers.as_ref().is_some_and(LayerList::has_seen) {
            drop_seen(&mut picture);
        }
        if !output.has_layers() {
            picture.metadata.retain(|(name, _)| !mattes::is_metadata(name));
            if !is_clean {
                (picture.layers, picture.opacity) = (Vec::new(), Opacity::Straight);
            }
            picture.make_opaque(self.header.crop);
        }
        let mut keep = vec!["seed", "integrator", "filter"];
        if output.has_layers() {
            keep.extend(["depths", "cameraFromWorld", "ndcFromWorld"]);
            picture.set_metadata("commandLine", command());
            picture.set_metadata("samplesPerPixel", self.spp_max.to_string());
            picture.set_metadata("renderTimeSeconds", format!("{:.3}", self.seconds));
        }
        for name in keep {
            if let Some((_, value)) = self.metadata.iter().find(|(known, _)| known == name) {
                picture.set_metadata(name, value.clone());
            }
        }
        picture
    }
}

fn has_layer(picture: &Picture, layer: &image::Layer) -> bool {
    picture.layer(&layer.name).is_some_and(|other| {
        layer
            .channels
            .iter()
            .all(|channel| other.channel(&channel.name).is_some_and(|same| same.data == channel.data))
    })
}
