// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing an EXR: one flat part with the colour as R, G, B, A and every layer's channels as `layer.channel`.
//! Names as other renderers and viewers use them. R, G, B are the foreground, over nothing and associated
//! with A [PD84]; the background is the layer `background`, to be added. Chromaticities are those of the
//! requested space.
//! The caller's workers compress blocks. Invariants: pixels are exact in the chosen precision; finite values stay
//! finite in half precision; the bytes do not depend on the workers. Tests: `tests/round_trip.rs`.

use std::collections::HashSet;
use std::io::Cursor;
use std::sync::OnceLock;

use exr::block::writer::ChunksWriter;
use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::image::write::layers::{LayersWriter, WritableLayers};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes,
    LineOrder, Text, Vec2,
    attribute::{AttributeValue, Chromaticities},
};
use half::f16;

use super::super::options::{ExrCompression, ExrPixels, Workers, WriteOptions};
use crate::{BACKGROUND, Channel, ChannelData, Error, Picture};

/// Names that the file format itself uses; metadata of these names gets a prefix.
const RESERVED: [&str; 17] = [
    "channels",
    "chunkCount",
    "compression",
    "dataWindow",
    "displayWindow",
    "dwaCompressionLevel",
    "lineOrder",
    "maxSamplesPerPixel",
    "name",
    "pixelAspectRatio",
    "preview",
    "screenWindowCenter",
    "screenWindowWidth",
    "tiles",
    "type",
    "version",
    "view",
];
const RESERVED_PREFIX: &str = "gnurt.";

/// Compressed blocks that wait to be written at most: of 16 lines each in the default compression.
const BLOCKS_AT_ONCE: usize = 64;

/// Largest width and height of tiles.
const LARGEST_TILE: u32 = 1 << 14;

/// Longest name of an attribute or channel.
const MAX_NAME: usize = 255;

fn encoding(options: &WriteOptions) -> Encoding {
    let compression = match options.exr_compression {
        ExrCompression::None => Compression::Uncompressed,
        ExrCompression::Rle => Compression::RLE,
        ExrCompression::Zips => Compression::ZIP1,
        ExrCompression::Zip => Compression::ZIP16,
        ExrCompression::Piz => Compression::PIZ,
        ExrCompression::Pxr24 => Compression::PXR24,
    };
    let tile = |size: u32| Blocks::Tiles(Vec2(size as usize, size as usize));
    let blocks = options.exr_tile.map_or(Blocks::ScanLines, |size| tile(size.clamp(1, LARGEST_TILE)));
    Encoding { compression, blocks, line_order: LineOrder::Increasing }
}

pub(in crate::file) fn encode(
    picture: &Picture,
    options: &WriteOptions,
    workers: Workers,
) -> Result<Vec<u8>, Error> {
    let (chromaticities, rows) = (options.exr_space.chromaticities(), options.exr_space.from_rec709());
    let converted = rows.map(|rows| {
        let mut converted = picture.clone();
        converted.convert_colors(&rows);
        converted
    });
    let picture = converted.as_ref().unwrap_or(picture);
    let channels = channels(picture, options.exr_pixels)?;
    let size = (picture.width as usize, picture.height as usize);
    let encoding = encoding(options);
    let layer =
        Layer::new(size, attributes(picture), encoding, AnyChannels::sort(channels.into_iter().collect()));
    let mut image = Image::from_layer(layer);
    let point = |[x, y]: [f32; 2]| Vec2(x, y);
    let [red, green, blue] = chromaticities.primaries.map(point);
    let white = point(chromaticities.white);
    image.attributes.chromaticities = Some(Chromaticities { red, green, blue, white });
    write(&image, workers).map_err(|error| Error::Shape(format!("it does not fit an EXR: {error}")))
}

/// The bytes of a file.
fn write(image: &Image<Layer<AnyChannels<FlatSamples>>>, workers: Workers) -> exr::error::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let headers = image.layer_data.infer_headers(&image.attributes);
    exr::block::write(&mut bytes, headers, true, |meta, chunks| {
        let pixels = image.layer_data.create_writer(&meta.headers);
        let blocks: Vec<_> = enumerate_ordered_header_block_indices(&meta.headers).collect();
        for some in blocks.chunks(BLOCKS_AT_ONCE) {
            let compressed: Vec<OnceLock<_>> = some.iter().map(|_| OnceLock::new()).collect();
            workers(some.len(), &|k| {
                let (number, index) = some[k];
                let data = pixels.extract_uncompressed_block(&meta.headers, index);
                let block = UncompressedBlock { index, data };
                compressed[k].get_or_init(|| (number, block.compress_to_chunk(&meta.headers)));
            });
            for (number, chunk) in compressed.into_iter().filter_map(OnceLock::into_inner) {
                chunks.write_chunk(number, chunk?)?;
            }
        }
        Ok(())
    })?;
    Ok(bytes.into_inner())
}

fn channels(picture: &Picture, pixels: ExrPixels) -> Result<Vec<AnyChannel<FlatSamples>>, Error> {
    let front: Vec<[f32; 4]> = picture.in_front().collect();
    let is_float = match pixels {
        ExrPixels::Float => true,
        ExrPixels::Half => false,
        ExrPixels::Fitting => !fits_half(front.as_flattened()) || !background_fits(picture),
    };
    let color = ["R", "G", "B", "A"].into_iter().enumerate().map(|(c, name)| {
        let values = front.iter().map(|pixel| pixel[c]);
        let samples = match is_float {
            false => FlatSamples::F16(values.map(nearest_half).collect()),
            true => FlatSamples::F32(values.collect()),
        };
        (name.to_string(), samples)
    });
    let layers = picture.layers.iter().flat_map(|layer| {
        // Foreground and background are added: they have one precision.
        let is_color = layer.name == BACKGROUND;
        let samples = move |channel: &Channel| match &channel.data {
            ChannelData::F32(values) if is_color && is_float => FlatSamples::F32(values.clone()),
            ChannelData::F32(values) if is_color => {
                FlatSamples::F16(values.iter().copied().map(nearest_half).collect())
            }
            _ => samples(channel),
        };
        layer.channels.iter().map(move |channel| (layer.full_name(channel), samples(channel)))
    });

    let mut names = HashSet::new();
    let mut list = Vec::new();
    for (name, samples) in color.chain(layers) {
        let valid = !name.is_empty() && name.len() <= MAX_NAME && !name.contains('\0');
        match Text::new_or_none(&name) {
            Some(text) if valid && names.insert(name.clone()) => list.push(AnyChannel::new(text, samples)),
            Some(_) if valid => return Err(Error::Shape(format!("two channels are named '{name}'"))),
            _ => return Err(Error::Shape(format!("'{name}' cannot name a channel"))),
        }
    }
    Ok(list)
}

fn samples(channel: &Channel) -> FlatSamples {
    match &channel.data {
        ChannelData::U32(values) => FlatSamples::U32(values.clone()),
        ChannelData::F32(values) if channel.half => {
            FlatSamples::F16(values.iter().copied().map(nearest_half).collect())
        }
        ChannelData::F32(values) => FlatSamples::F32(values.clone()),
    }
}

/// Whether halves hold the finite ones among these values.
fn fits_half(values: &[f32]) -> bool {
    // Values that round to the largest half or less.
    const MOST: f32 = 65520.0;
    values.iter().all(|value| value.abs() < MOST || !value.is_finite())
}

fn background_fits(picture: &Picture) -> bool {
    let layers = picture.layers.iter().filter(|layer| layer.name == BACKGROUND);
    layers.flat_map(|layer| &layer.channels).all(|channel| match &channel.data {
        ChannelData::F32(values) => fits_half(values),
        ChannelData::U32(_) => true,
    })
}

/// Finite values stay finite: excessive values become the largest half.
fn nearest_half(value: f32) -> f16 {
    let half = f16::from_f32(value);
    if half.is_infinite() && value.is_finite() { f16::MAX.copysign(half) } else { half }
}

fn attributes(picture: &Picture) -> LayerAttributes {
    let mut attributes =
        LayerAttributes { software_name: Text::new_or_none(crate::SOFTWARE), ..LayerAttributes::default() };
    for (name, value) in &picture.metadata {
        // Attribute values are bytes; other programs write UTF-8 as well.
        let text = Text::from_bytes_unchecked(value.bytes().collect());
        match &name[..] {
            "software" => attributes.software_name = Some(text),
            "comments" => attributes.comments = Some(text),
            "owner" => attributes.owner = Some(text),
            "capDate" => attributes.capture_date = Some(text),
            _ => {
                let prefix = if RESERVED.contains(&&name[..]) { RESERVED_PREFIX } else { "" };
                let name: Vec<u8> = prefix.bytes().chain(name.bytes()).filter(|&byte| byte != 0).collect();
                if (1..=MAX_NAME).contains(&name.len()) {
                    let name = Text::from_bytes_unchecked(name.into_iter().collect());
                    attributes.other.insert(name, AttributeValue::Text(text));
                }
            }
        }
    }
    attributes
}
