// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures of any number of channels as TIFF and OpenEXR files, without compression.
//! Source: TIFF 6.0, sections 2 and 19; OpenEXR file layout (openexr.com); original code.
//!
//! The renderer's pictures have three channels and go through its own crate; these are values of shader outputs.

/// Values by rows from the top, channels together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) channels: usize,
    pub(super) values: Vec<f32>,
}

/// How a value is stored.
#[derive(Clone, Copy, PartialEq)]
enum Sample {
    Byte,
    Half,
    Float,
}

impl Picture {
    /// Writes a file; the name's end selects the format.
    pub(super) fn save(&self, file: &str, format: &str) -> Result<(), String> {
        let sample = match format {
            "uint8" => Sample::Byte,
            "half" => Sample::Half,
            _ => Sample::Float,
        };
        let bytes = match file.rsplit('.').next() {
            Some("exr") => self.exr(if sample == Sample::Byte { Sample::Half } else { sample }),
            Some("tif" | "tiff") => self.tiff(sample),
            _ => return Err(format!("{file}: pictures are saved as .tif or .exr")),
        };
        std::fs::write(file, bytes).map_err(|e| format!("{file}: {e}"))
    }

    fn tiff(&self, sample: Sample) -> Vec<u8> {
        let (bits, kind) = match sample {
            Sample::Byte => (8_u16, 1_u16),
            Sample::Half => (16, 3),
            Sample::Float => (32, 3),
        };
        let mut data = Vec::with_capacity(self.values.len() * 4);
        for &value in &self.values {
            match sample {
                Sample::Byte => data.push((value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8),
                Sample::Half => data.extend(half(value).to_le_bytes()),
                Sample::Float => data.extend(value.to_le_bytes()),
            }
        }
        let channels = self.channels as u16;
        let mut out = b"II*\0".to_vec();
        let directory = 8 + data.len() + data.len() % 2;
        out.extend((directory as u32).to_le_bytes());
        out.extend(&data);
        out.resize(directory, 0);
        let extra = channels.saturating_sub(if channels >= 3 { 3 } else { 1 });
        let mut entries: Vec<(u16, u16, Vec<u16>, Option<u32>)> = vec![
            (256, 4, vec![], Some(self.width as u32)),
            (257, 4, vec![], Some(self.height as u32)),
            (258, 3, vec![bits; usize::from(channels)], None),
            (259, 3, vec![1], None),
            (262, 3, vec![if channels >= 3 { 2 } else { 1 }], None),
            (273, 4, vec![], Some(8)),
            (277, 3, vec![channels], None),
            (278, 4, vec![], Some(self.height as u32)),
            (279, 4, vec![], Some(data.len() as u32)),
            (284, 3, vec![1], None),
        ];
        if extra > 0 {
            entries.push((338, 3, vec![0; usize::from(extra)], None));
        }
        entries.push((339, 3, vec![kind; usize::from(channels)], None));
        let mut tail = Vec::new();
        let after = directory + 2 + entries.len() * 12 + 4;
        out.extend((entries.len() as u16).to_le_bytes());
        for (tag, ty, shorts, long) in entries {
            out.extend(tag.to_le_bytes());
            out.extend(ty.to_le_bytes());
            match long {
                Some(value) => {
                    out.extend(1_u32.to_le_bytes());
                    out.extend(value.to_le_bytes());
                }
                None => {
                    out.extend((shorts.len() as u32).to_le_bytes());
                    let bytes: Vec<u8> = shorts.iter().flat_map(|v| v.to_le_bytes()).collect();
                    if bytes.len() <= 4 {
                        let mut four = bytes;
                        four.resize(4, 0);
                        out.extend(four);
                    } else {
                        out.extend(((after + tail.len()) as u32).to_le_bytes());
                        tail.extend(bytes);
                    }
                }
            }
        }
        out.extend(0_u32.to_le_bytes());
        out.extend(tail);
        out
    }

    fn exr(&self, sample: Sample) -> Vec<u8> {
        let names = self.channel_names();
        // Channels are in the order of their names.
        let mut order: Vec<usize> = (0..self.channels).collect();
        order.sort_by(|&a, &b| names[a].cmp(&names[b]));
        let (kind, bytes) = if sample == Sample::Half { (1_u32, 2) } else { (2, 4) };
        let mut out = 20_000_630_u32.to_le_bytes().to_vec();
        out.extend(2_u32.to_le_bytes());
        let mut attribute = |name: &str, ty: &str, value: &[u8]| {
            out.extend(name.as_bytes());
            out.push(0);
            out.extend(ty.as_bytes());
            out.push(0);
            out.extend((value.len() as u32).to_le_bytes());
            out.extend(value);
        };
        let mut channels = Vec::new();
        for &c in &order {
            channels.extend(names[c].as_bytes());
            channels.push(0);
            channels.extend(kind.to_le_bytes());
            channels.extend([0; 4]);
            channels.extend(1_u32.to_le_bytes());
            channels.extend(1_u32.to_le_bytes());
        }
        channels.push(0);
        let window: Vec<u8> = [0, 0, self.width as i32 - 1, self.height as i32 - 1]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        attribute("channels", "chlist", &channels);
        attribute("compression", "compression", &[0]);
        attribute("dataWindow", "box2i", &window);
        attribute("displayWindow", "box2i", &window);
        attribute("lineOrder", "lineOrder", &[0]);
        attribute("pixelAspectRatio", "float", &1.0_f32.to_le_bytes());
        attribute("screenWindowCenter", "v2f", &[0; 8]);
        attribute("screenWindowWidth", "float", &1.0_f32.to_le_bytes());
        out.push(0);
        let row = self.width * self.channels * bytes;
        let first = out.len() + self.height * 8;
        for y in 0..self.height {
            out.extend(((first + y * (row + 8)) as u64).to_le_bytes());
        }
        for y in 0..self.height {
            out.extend((y as u32).to_le_bytes());
            out.extend((row as u32).to_le_bytes());
            for &c in &order {
                for x in 0..self.width {
                    let value = self.values[(y * self.width + x) * self.channels + c];
                    if sample == Sample::Half {
                        out.extend(half(value).to_le_bytes());
                    } else {
                        out.extend(value.to_le_bytes());
                    }
                }
            }
        }
        out
    }

    fn channel_names(&self) -> Vec<String> {
        match self.channels {
            1 => vec!["Y".into()],
            n => (0..n)
                .map(|i| ["R", "G", "B", "A"].get(i).map_or(format!("channel{i:02}"), |s| (*s).into()))
                .collect(),
        }
    }
}

/// The nearest 16-bit float, ties to even.
fn half(value: f32) -> u16 {
    let bits = value.to_bits();
    let sign = ((bits >> 16) & 0x8000) as u16;
    let magnitude = bits & 0x7fff_ffff;
    if magnitude > 0x7f80_0000 {
        return sign | 0x7e00;
    }
    if magnitude >= 0x4780_0000 {
        return sign | 0x7c00;
    }
    if magnitude < 0x3880_0000 {
        // Below the normal range: an integer count of the smallest step.
        let steps = f32::from_bits(magnitude) * 16_777_216.0;
        return sign | steps.round_ties_even() as u16;
    }
    let rounded = magnitude + 0xfff + ((magnitude >> 13) & 1);
    sign | ((rounded - 0x3800_0000) >> 13) as u16
}
