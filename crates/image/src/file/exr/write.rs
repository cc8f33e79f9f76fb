// SPDX-License-Identifier: GPL-3.0-or-later
//! Writing an EXR: one flat part with the colour as R, G, B, A and every layer's channels as `layer.channel`.
//! Names as other renderers and viewers use them. R, G, B are the foreground, over nothing and associated
//! with A [PD84]; the background is the layer `background`, to be added. Chromaticities are those of the
//! requested space.
//! The caller's workers compress blocks. Invariants: pixels are exact in the chosen precision; finite values stay
//! finite in half precision; the bytes do not depend on the workers. Tests: `tests/round_trip.rs`.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufWriter, Cursor, Write};
use std::mem::discriminant;
use std::sync::OnceLock;

use exr::block::writer::ChunksWriter;
use exr::block::{UncompressedBlock, enumerate_ordered_header_block_indices};
use exr::image::write::layers::{LayersWriter, WritableLayers};
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, IntegerBounds, Layer,
    LayerAttributes, LineOrder, Text, Vec2,
    attribute::{AttributeValue, Chromaticities},
};
use half::f16;

use super::super::bands::Bands;
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
    let image = image(picture, options)?;
    write(&image, workers).map_err(|error| Error::Shape(format!("it does not fit an EXR: {error}")))
}

type FlatImage = Image<Layer<AnyChannels<FlatSamples>>>;

fn image(picture: &Picture, options: &WriteOptions) -> Result<FlatImage, Error> {
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
    Ok(image)
}

/// The bytes of a file.
fn write(image: &FlatImage, workers: Workers) -> exr::error::Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    let headers = image.layer_data.infer_headers(&image.attributes);
    exr::block::write(&mut bytes, headers, true, |meta, chunks| {
        write_blocks(image, [0, 0], &meta.headers, chunks, workers).map(drop)
    })?;
    Ok(bytes.into_inner())
}

/// Writes the blocks of a picture, or of a band whose first row and first block within the file are given; returns
/// the number of blocks.
fn write_blocks(
    image: &FlatImage,
    [top, first]: [usize; 2],
    file: &[Header],
    chunks: &mut impl ChunksWriter,
    workers: Workers,
) -> exr::error::Result<usize> {
    let headers = image.layer_data.infer_headers(&image.attributes);
    let pixels = image.layer_data.create_writer(&headers);
    let blocks: Vec<_> = enumerate_ordered_header_block_indices(&headers).collect();
    for some in blocks.chunks(BLOCKS_AT_ONCE) {
        let compressed: Vec<OnceLock<_>> = some.iter().map(|_| OnceLock::new()).collect();
        workers(some.len(), &|k| {
            let (number, mut index) = some[k];
            let data = pixels.extract_uncompressed_block(&headers, index);
            index.pixel_position.1 += top;
            let block = UncompressedBlock { index, data };
            compressed[k].get_or_init(|| (number, block.compress_to_chunk(file)));
        });
        for (number, chunk) in compressed.into_iter().filter_map(OnceLock::into_inner) {
            chunks.write_chunk(first + number, chunk?)?;
        }
    }
    Ok(blocks.len())
}

/// Rows of a block: bands begin at multiples of it.
///
/// # Errors
/// [`Error::Shape`] if the precision depends on values of all bands.
pub(in crate::file) fn rows_of_blocks(options: &WriteOptions) -> Result<u32, Error> {
    if options.exr_pixels == ExrPixels::Fitting {
        return Err(Error::Shape("an EXR in bands has half or float pixels, not those that fit".into()));
    }
    let Encoding { compression, blocks, .. } = encoding(options);
    Ok(match blocks {
        Blocks::ScanLines => compression.scan_lines_per_block() as u32,
        Blocks::Tiles(Vec2(_, rows)) => rows as u32,
    })
}

/// Writes a picture in bands.
pub(in crate::file) fn write_bands(
    file: &mut File,
    bands: &mut Bands,
    options: &WriteOptions,
    workers: Workers,
) -> Result<(), Error> {
    let Some((_, first)) = bands.next()? else { return Ok(()) };
    let [width, height] = bands.size.map(|size| size as usize);
    let mut image = image(&first, options)?;
    image.attributes.display_window = IntegerBounds::from_dimensions((width, height));
    let mut headers = image.layer_data.infer_headers(&image.attributes);
    for header in &mut headers {
        let Header { compression, blocks, line_order, .. } = *header;
        header.layer_size = Vec2(width, height);
        *header = header.clone().with_encoding(compression, blocks, line_order);
    }
    let kinds = |image: &FlatImage| -> Vec<_> {
        image
            .layer_data
            .channel_data
            .list
            .iter()
            .map(|c| (c.name.clone(), discriminant(&c.sample_data)))
            .collect()
    };
    let expected = kinds(&image);
    // What the file library's closure cannot return.
    let mut fault = None;
    let mut out = BufWriter::new(file);
    let written = exr::block::write(&mut out, headers, true, |meta, chunks| {
        let mut blocks = write_blocks(&image, [0, 0], &meta.headers, chunks, workers)?;
        loop {
            let band = bands.next().and_then(|band| match band {
                Some((top, band)) => Ok(Some((top, self::image(&band, options)?))),
                None => Ok(None),
            });
            let (top, image) = match band {
                Ok(Some(band)) => band,
                Ok(None) => return Ok(()),
                Err(error) => {
                    fault = Some(error);
                    return Err(exr::error::Error::Aborted);
                }
            };
            if kinds(&image) != expected {
                fault = Some(Error::Shape("a band has other layers than the first".into()));
                return Err(exr::error::Error::Aborted);
            }
            blocks += write_blocks(&image, [top as usize, blocks], &meta.headers, chunks, workers)?;
        }
    });
    match fault {
        Some(fault) => Err(fault),
        None => written
            .map_err(|error| bands.failed(&error))
            .and_then(|()| out.flush().map_err(|error| bands.failed(&error))),
    }
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
