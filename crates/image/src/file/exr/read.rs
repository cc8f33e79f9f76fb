// SPDX-License-Identifier: GPL-3.0-or-later
//! Reading an EXR: the picture's colour is the unnamed R, G, B (or Y), else the first group of channels that has them.
//! A group is the part's name and the text before the last dot of a channel's name. All other channels become
//! layers. The layer `background`, R, G, B and A, is the background and is added to the colour: a picture's
//! colour is the visible sum. Colours of other chromaticities become those of Rec. 709. The picture is the display window; pixels missing from the data window are
//! black and transparent. The caller's workers decompress blocks. Invariants: headers are checked before pixels
//! are read; the picture does not depend on the workers.
//! Tests: `tests/{round_trip,broken}.rs`.

use std::sync::{Mutex, OnceLock, PoisonError};

use exr::block::UncompressedBlock;
use exr::block::reader::{ChunksReader, Reader};
use exr::image::read::image::LayersReader;
use exr::meta::BlockDescription;
use exr::meta::header::Header;
use exr::prelude::{
    FlatImage, FlatSamples, IntegerBounds, LayerAttributes, ReadChannels, ReadLayers, Text, Vec2,
    attribute::AttributeValue, read,
};

use super::super::guard::decode_guarded;
use super::super::limits::{PICTURE_BYTES, check_density, check_size};
use super::super::options::{ALONE, Workers};
use super::super::source::Source;
use crate::chromaticities::{Chromaticities, REC709};
use crate::{Budget, Channel, ChannelData, Error, Layer, Opacity, Picture, Stored, StoredValues};

/// Most bytes that a byte of compressed data can become in any of the format's compressions: deflate's 1032.
const MAX_INFLATION: u64 = 1032;
/// This many bytes of pixels are accepted however short the file is.
const BELIEVED_BYTES: u64 = 1 << 26;
/// Bytes of blocks that are decompressed together, if one has not more.
const BYTES_AT_ONCE: u64 = 1 << 24;
/// Most channels of all parts together.
const MAX_CHANNELS: usize = 1 << 12;

pub(in crate::file) fn decode(
    source: &mut dyn Source,
    length: u64,
    budget: &Budget,
    workers: Workers,
) -> Result<Picture, Error> {
    decode_guarded("EXR", || picture(flat(source, length, budget, workers)?))
}

/// The first part as it is stored: red, green, blue and opacity first, then the other channels in the file's order.
pub(in crate::file) fn stored(
    source: &mut dyn Source,
    length: u64,
    budget: &Budget,
) -> Result<Stored, Error> {
    decode_guarded("EXR", || {
        let image = flat(source, length, budget, ALONE)?;
        let display = image.attributes.display_window;
        let Some(part) = image.layer_data.into_iter().next() else {
            return Err(Error::corrupt("EXR", "it has no parts"));
        };
        let position = part.attributes.layer_position;
        let texts = texts(&part.attributes);
        let window = IntegerBounds::new(position, part.size);
        let mut list: Vec<(String, Vec<f32>)> = Vec::new();
        for channel in part.channel_data.list {
            let values = match cropped(channel.sample_data, window, window)? {
                ChannelData::F32(values) => values,
                ChannelData::U32(values) => values.into_iter().map(|value| value as f32).collect(),
            };
            list.push((channel.name.to_string(), values));
        }
        let rank = |name: &str| ["R", "G", "B", "A"].iter().position(|known| *known == name).unwrap_or(4);
        list.sort_by_key(|(name, _)| rank(name));
        let channels = list.len();
        let count = part.size.0 * part.size.1;
        let values = (0..count * channels).map(|i| list[i % channels].1[i / channels]).collect();
        let mut stored = Stored::plain([part.size.0, part.size.1], channels, StoredValues::F32(values));
        stored.alpha = list.iter().position(|(name, _)| name == "A");
        let bounds = |b: IntegerBounds| {
            let [x, y] = [b.position.0, b.position.1];
            [x, y, x + b.size.0 as i32 - 1, y + b.size.1 as i32 - 1]
        };
        (stored.window, stored.display) = (bounds(window), bounds(display));
        stored.texts = texts;
        Ok(stored)
    })
}

fn flat(source: &mut dyn Source, length: u64, budget: &Budget, workers: Workers) -> Result<FlatImage, Error> {
    let reader = exr::block::read(source, false).map_err(library_error)?;
    check_headers(&reader, length, budget)?;
    from_blocks(reader, workers).map_err(library_error)
}

/// The parts of a file whose headers are checked.
fn from_blocks(
    reader: Reader<impl std::io::Read + std::io::Seek>,
    workers: Workers,
) -> exr::error::Result<FlatImage> {
    let attributes = reader.headers().first().map(|header| header.shared_attributes.clone());
    let most = reader.headers().iter().map(blocks_at_once).min().unwrap_or(1);
    let all = read().no_deep_data().largest_resolution_level().all_channels().all_layers();
    let mut layers = all.create_layers_reader(reader.headers())?;
    let mut chunks =
        reader.filter_chunks(false, |meta, tile, block| layers.filter_block(meta, tile, block))?;
    loop {
        let some = chunks.by_ref().take(most).collect::<exr::error::Result<Vec<_>>>()?;
        if some.is_empty() {
            break;
        }
        let compressed: Vec<_> = some.into_iter().map(|chunk| Mutex::new(Some(chunk))).collect();
        let blocks: Vec<OnceLock<_>> = compressed.iter().map(|_| OnceLock::new()).collect();
        let meta = chunks.meta_data();
        workers(compressed.len(), &|k| {
            // Nothing panics while it is locked.
            let chunk = compressed[k].lock().unwrap_or_else(PoisonError::into_inner).take();
            if let Some(chunk) = chunk {
                blocks[k].get_or_init(|| UncompressedBlock::decompress_chunk(chunk, meta, false));
            }
        });
        for block in blocks.into_iter().filter_map(OnceLock::into_inner) {
            layers.read_block(&chunks.meta_data().headers, block?)?;
        }
    }
    let attributes = attributes.ok_or_else(|| exr::error::Error::Invalid("it has no parts".into()))?;
    Ok(FlatImage { attributes, layer_data: layers.into_layers() })
}

fn check_headers<R: std::io::Read + std::io::Seek>(
    reader: &Reader<R>,
    length: u64,
    budget: &Budget,
) -> Result<(), Error> {
    let mut bytes = 0_u64;
    let mut channels = 0;
    // Channels, then also the picture's colour.
    let mut memory = 0_u64;
    let mut window = [1; 2];
    for header in reader.headers() {
        if header.deep {
            return Err(Error::corrupt("EXR", "deep pixels are not read, only flat ones"));
        }
        let display = header.shared_attributes.display_window.size;
        for size in [header.layer_size, display] {
            check_size("EXR", size.0 as u64, size.1 as u64)?;
        }
        check_density("EXR", [display.0 as u64, display.1 as u64], length, MAX_INFLATION)?;
        let pixels = header.layer_size.0 as u64 * header.layer_size.1 as u64;
        let block = block_bytes(header);
        bytes =
            bytes.saturating_add(pixels.saturating_mul(header.channels.bytes_per_pixel as u64)).max(block);
        channels += header.channels.list.len();
        window = [display.0 as u64, display.1 as u64];
        // One channel after the other becomes floats in the memory of the read values.
        let cropped =
            (window[0] * window[1]).max(pixels).saturating_mul(4 * header.channels.list.len() as u64);
        let read = pixels.saturating_mul(header.channels.bytes_per_pixel as u64);
        // Blocks as they are stored, and as they become.
        let together = block.saturating_mul(blocks_at_once(header) as u64).min(read.max(block));
        memory = memory.saturating_add(cropped.max(read)).saturating_add(together.saturating_mul(2));
        // Each block has an offset of eight bytes and a head of at least eight.
        if (header.chunk_count as u64).saturating_mul(16) > length {
            return Err(Error::corrupt(
                "EXR",
                format!("{} blocks in {length} bytes; is it truncated?", header.chunk_count),
            ));
        }
    }
    if channels > MAX_CHANNELS {
        return Err(Error::corrupt("EXR", format!("{channels} channels are too many")));
    }
    if bytes > BELIEVED_BYTES.max(length.saturating_mul(MAX_INFLATION)) {
        return Err(Error::corrupt(
            "EXR",
            format!("{length} bytes cannot hold {bytes} bytes of pixels; is it truncated?"),
        ));
    }
    let [width, height] = window;
    budget.check_bytes(window, memory.saturating_add(width * height * PICTURE_BYTES))
}

/// Bytes of a whole block.
fn block_bytes(header: &Header) -> u64 {
    let [width, height] = match header.blocks {
        BlockDescription::ScanLines => {
            [header.layer_size.0, header.compression.scan_lines_per_block().min(header.layer_size.1)]
        }
        BlockDescription::Tiles(tiles) => [tiles.tile_size.0, tiles.tile_size.1],
    };
    (header.channels.bytes_per_pixel as u64).saturating_mul(width as u64).saturating_mul(height as u64)
}

/// Blocks that are decompressed together.
fn blocks_at_once(header: &Header) -> usize {
    (BYTES_AT_ONCE / block_bytes(header).max(1)).clamp(1, 64) as usize
}

/// A channel between a part of the file and the picture.
struct Found {
    group: String,
    name: String,
    data: ChannelData,
    half: bool,
}

fn picture(image: FlatImage) -> Result<Picture, Error> {
    let window = image.attributes.display_window;
    let chromaticities = image.attributes.chromaticities.map(|c| {
        let point = |v: Vec2<f32>| [v.0, v.1];
        Chromaticities { primaries: [c.red, c.green, c.blue].map(point), white: point(c.white) }
    });
    let mut found = Vec::new();
    let mut metadata = Vec::new();
    for part in image.layer_data {
        let position = part.attributes.layer_position;
        let data_window = IntegerBounds::new(position, part.size);
        metadata.extend(texts(&part.attributes));
        let part_name = part.attributes.layer_name.as_ref().map(Text::to_string).unwrap_or_default();
        for channel in part.channel_data.list {
            let full = channel.name.to_string();
            let (prefix, name) = full.rsplit_once('.').unwrap_or(("", &full));
            let group = [&part_name, prefix].into_iter().filter(|name_part| !name_part.is_empty());
            let group = group.map(str::to_string).collect::<Vec<_>>().join(".");
            let half = matches!(channel.sample_data, FlatSamples::F16(_));
            let data = cropped(channel.sample_data, data_window, window)?;
            found.push(Found { group, name: name.to_string(), data, half });
        }
    }
    let mut picture = Picture { metadata, opacity: Opacity::Associated, ..Picture::default() };
    (picture.width, picture.height) = (window.size.0 as u32, window.size.1 as u32);
    picture.color = take_color(&mut found)?;
    for Found { group, name, data, half } in found {
        let channel = Channel { name, data, half };
        match picture.layers.iter_mut().find(|layer| layer.name == group) {
            Some(layer) => layer.channels.push(channel),
            None => picture.layers.push(Layer { name: group, channels: vec![channel] }),
        }
    }
    let rows = chromaticities.filter(|space| !space.is_near(&REC709)).and_then(|space| space.to(&REC709));
    if let Some(rows) = rows {
        picture.convert_colors(&rows);
    }
    add_background(&mut picture);
    Ok(picture)
}

/// The visible colour is the foreground plus the background.
fn add_background(picture: &mut Picture) {
    let mut color = std::mem::take(&mut picture.color);
    if let Some([r, g, b, _]) = picture.background() {
        for (((pixel, r), g), b) in color.iter_mut().zip(r).zip(g).zip(b) {
            (pixel[0], pixel[1], pixel[2]) = (pixel[0] + r, pixel[1] + g, pixel[2] + b);
        }
    }
    picture.color = color;
}

/// Takes the channels of the picture's colour out of the others.
fn take_color(found: &mut Vec<Found>) -> Result<Vec<[f32; 4]>, Error> {
    let groups: Vec<String> = found.iter().map(|channel| channel.group.clone()).collect();
    let has = |found: &[Found], group: &str, names: &[&str]| {
        names.iter().all(|name| found.iter().any(|channel| channel.group == group && channel.name == *name))
    };
    // The unnamed group comes first, then the others in the file's order; colours before grey in each.
    let candidates = std::iter::once("").chain(groups.iter().map(String::as_str));
    let choice = candidates.clone().find_map(|group| {
        [&["R", "G", "B"][..], &["Y"]]
            .into_iter()
            .find(|names| has(found, group, names))
            .map(|names| (group, names))
    });
    let Some((group, names)) = choice else {
        return Err(Error::corrupt("EXR", "it has no channels R, G, B or Y"));
    };
    let mut take = |name: &str| {
        let at = found.iter().position(|channel| channel.group == group && channel.name == name)?;
        Some(match found.remove(at).data {
            ChannelData::F32(values) => values,
            ChannelData::U32(values) => values.into_iter().map(|value| value as f32).collect(),
        })
    };
    let opacity = take("A");
    let colors: Vec<Vec<f32>> = names.iter().filter_map(|name| take(name)).collect();
    let color_at = |i: usize| {
        let [r, g, b] = std::array::from_fn(|c| colors[c.min(colors.len() - 1)][i]);
        [r, g, b, opacity.as_ref().map_or(1.0, |values| values[i])]
    };
    Ok((0..colors[0].len()).map(color_at).collect())
}

/// The values of a data window, placed into the display window; 0 where there are none.
fn cropped(samples: FlatSamples, data: IntegerBounds, display: IntegerBounds) -> Result<ChannelData, Error> {
    let count = data.size.0 * data.size.1;
    if samples.len() != count {
        return Err(Error::corrupt("EXR", "channels of lower resolution than the picture are not read"));
    }
    Ok(match samples {
        FlatSamples::F16(values) => {
            ChannelData::F32(crop(values.iter().map(|value| value.to_f32()).collect(), data, display))
        }
        FlatSamples::F32(values) => ChannelData::F32(crop(values, data, display)),
        FlatSamples::U32(values) => ChannelData::U32(crop(values, data, display)),
    })
}

fn crop<T: Copy + Default>(values: Vec<T>, data: IntegerBounds, display: IntegerBounds) -> Vec<T> {
    if data == display {
        return values;
    }
    let [left, top] =
        [data.position.0 - display.position.0, data.position.1 - display.position.1].map(i64::from);
    let mut out = vec![T::default(); display.size.0 * display.size.1];
    for (y, row) in values.chunks_exact(data.size.0).enumerate() {
        let target_y = y as i64 + top;
        if !(0..display.size.1 as i64).contains(&target_y) {
            continue;
        }
        let from = (-left).clamp(0, data.size.0 as i64) as usize;
        let to = (display.size.0 as i64 - left).clamp(from as i64, data.size.0 as i64) as usize;
        let start = target_y as usize * display.size.0 + (from as i64 + left).max(0) as usize;
        if from < to {
            out[start..start + to - from].copy_from_slice(&row[from..to]);
        }
    }
    out
}

/// The textual attributes, those of unknown name in alphabetical order.
fn texts(attributes: &LayerAttributes) -> Vec<(String, String)> {
    let known = [
        ("software", &attributes.software_name),
        ("comments", &attributes.comments),
        ("owner", &attributes.owner),
        ("capDate", &attributes.capture_date),
    ];
    let known = known.into_iter().filter_map(|(name, text)| Some((name.to_string(), utf8(text.as_ref()?))));
    let mut other: Vec<_> = attributes
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((utf8(name), utf8(text))),
            _ => None,
        })
        .collect();
    other.sort();
    known.chain(other).collect()
}

fn utf8(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

fn library_error(error: exr::error::Error) -> Error {
    use exr::error::Error as Library;
    let what = match error {
        Library::Invalid(what) if what.contains("missing bytes") => {
            "the file ends too early; it is truncated".into()
        }
        Library::Invalid(what) => what.into_owned(),
        Library::NotSupported(what) => format!("not supported: {what}"),
        Library::Aborted => "reading was stopped".into(),
        Library::Io(error) => return Error::reading(error),
    };
    Error::corrupt("EXR", what)
}
