// SPDX-License-Identifier: GPL-3.0-or-later
//! Pictures shown by tev, another program, while they are rendered: its protocol over TCP.
//! Source: the packets of tev's `Ipc` (create, update version 3, close): a length of 32 bits that counts itself, a byte of
//! kind, then fields; numbers little-endian, texts ended by a zero. Colours are linear floats, as tev expects them.
//! Tests: `tests`, with a server that reads the packets, and `crates/cli/tests/program/viewing.rs`.

use std::fmt;
use std::io::Write;
use std::net::{TcpStream, ToSocketAddrs};
use std::str::FromStr;
use std::time::Duration;

use gnurt::image::Picture;

use crate::error::ViewError;

/// Where tev listens.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TevAddress {
    /// A name or a number of the internet.
    pub host: String,
    /// Its port.
    pub port: u16,
}

/// The port of tev by default.
const PORT: u16 = 14158;
/// The time to wait for a viewer that may be absent.
const PATIENCE: Duration = Duration::from_secs(5);
/// Rows per packet: tev takes a packet as a whole.
const ROWS: u32 = 64;

const CLOSE_IMAGE: u8 = 2;
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;
const CHANNELS: [&str; 3] = ["R", "G", "B"];

impl FromStr for TevAddress {
    type Err = String;

    /// Reads `tev`, `tev:HOST` or `tev:HOST:PORT`.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = || "give tev, tev:HOST or tev:HOST:PORT, like tev:127.0.0.1:14158".to_owned();
        let rest = match text.strip_prefix("tev").ok_or_else(form)? {
            "" => return Ok(Self { host: "127.0.0.1".into(), port: PORT }),
            rest => rest.strip_prefix(':').ok_or_else(form)?,
        };
        // An address of version 6 contains colons, and has brackets around it.
        let (host, port) =
            match rest.rsplit_once(':').filter(|(host, _)| !host.contains(':') || host.ends_with(']')) {
                Some((host, port)) => (host, port.parse().map_err(|_| form())?),
                None => (rest, PORT),
            };
        let host = host.trim_start_matches('[').trim_end_matches(']');
        if host.is_empty() || port == 0 { Err(form()) } else { Ok(Self { host: host.into(), port }) }
    }
}

impl fmt::Display for TevAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.host, self.port)
    }
}

/// A picture in tev's window.
#[derive(Debug)]
pub struct TevImage {
    address: TevAddress,
    stream: TcpStream,
    name: String,
}

impl TevImage {
    /// Opens a picture of this name and size in tev; it stays there until the user closes it.
    ///
    /// # Errors
    /// [`ViewError::Tev`] if no program listens at the address.
    pub fn create(address: &TevAddress, name: &str, [width, height]: [u32; 2]) -> Result<Self, ViewError> {
        let failed = |why: std::io::Error| error(address, &why);
        let mut last = std::io::Error::other("unknown host");
        let mut stream = None;
        let tile_pixels = (&address.host[..], address.port).to_socket_addrs().map_err(failed)?;
        for index in tile_pixels {
            match TcpStream::connect_timeout(&index, PATIENCE) {
                Ok(found) => {
                    stream = Some(found);
                    break;
                }
                Err(why) => last = why,
            }
        }
        let Some(stream) = stream else { return Err(failed(last)) };
        stream.set_write_timeout(Some(PATIENCE)).map_err(failed)?;
        stream.set_nodelay(true).map_err(failed)?;
        // A zero would end the name early.
        let mut image = Self { address: address.clone(), stream, name: name.replace('\0', "") };
        let mut packet = Packet::new(CREATE_IMAGE);
        packet.byte(1);
        packet.text(&image.name);
        packet.int(width);
        packet.int(height);
        packet.int(CHANNELS.len() as u32);
        CHANNELS.iter().for_each(|name| packet.text(name));
        image.send(packet)?;
        Ok(image)
    }

    /// Shows a picture of the requested size.
    ///
    /// # Errors
    /// [`ViewError::Tev`] if tev has hung up.
    pub fn update(&mut self, picture: &Picture) -> Result<(), ViewError> {
        let (width, height) = (picture.width, picture.height);
        for y in (0..height).step_by(ROWS as usize) {
            let rows = ROWS.min(height - y);
            let mut packet = Packet::new(UPDATE_IMAGE);
            packet.byte(0);
            packet.text(&self.name);
            packet.int(CHANNELS.len() as u32);
            CHANNELS.iter().for_each(|name| packet.text(name));
            [0, y, width, rows].into_iter().for_each(|number| packet.int(number));
            // The first value of each channel, and the distance between its values, in floats.
            (0..CHANNELS.len()).for_each(|channel| packet.long(channel as u64));
            (0..CHANNELS.len()).for_each(|_| packet.long(CHANNELS.len() as u64));
            let first = y as usize * width as usize;
            let pixels = &picture.color[first..first + rows as usize * width as usize];
            pixels.iter().flat_map(|pixel| &pixel[..CHANNELS.len()]).for_each(|&value| packet.float(value));
            self.send(packet)?;
        }
        Ok(())
    }

    /// Takes the picture out of tev's window.
    ///
    /// # Errors
    /// [`ViewError::Tev`] if tev has hung up.
    pub fn close(mut self) -> Result<(), ViewError> {
        let mut packet = Packet::new(CLOSE_IMAGE);
        packet.text(&self.name);
        self.send(packet)
    }

    fn send(&mut self, packet: Packet) -> Result<(), ViewError> {
        self.stream.write_all(&packet.finish()).map_err(|why| error(&self.address, &why))
    }
}

fn error(address: &TevAddress, why: &std::io::Error) -> ViewError {
    ViewError::Tev { address: address.to_string(), why: gnurt::image::system_reason(why) }
}

/// Bytes of a packet.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: u8) -> Self {
        Self(vec![0, 0, 0, 0, kind])
    }

    fn byte(&mut self, value: u8) {
        self.0.push(value);
    }

    fn int(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    fn long(&mut self, value: u64) {
        self.0.extend(value.to_le_bytes());
    }

    fn float(&mut self, value: f32) {
        self.0.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// The bytes, their number in front.
    fn finish(mut self) -> Vec<u8> {
        let length = u32::try_from(self.0.len()).unwrap_or(u32::MAX);
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::TcpListener;

    #[test]
    fn addresses() {
        let read = |text: &str| text.parse::<TevAddress>().map(|address| address.to_string());
        assert_eq!(read("tev"), Ok("127.0.0.1:14158".into()), "here");
        assert_eq!(read("tev:studio"), Ok("studio:14158".into()), "there");
        assert_eq!(read("tev:studio:99"), Ok("studio:99".into()), "at a port");
        assert_eq!(read("tev:[::1]:99"), Ok("::1:99".into()), "version 6");
        for bad in ["", "te", "tevx", "tev:", "tev:a:b", "tev:a:0", "tev:a:70000", "x11"] {
            assert!(read(bad).is_err_and(|why| why.contains("tev:HOST:PORT")), "'{bad}'");
        }
    }

    /// The packets that tev receives on a connection: kind and contents.
    fn packets(listener: &TcpListener) -> Vec<(u8, Vec<u8>)> {
        let (mut stream, _) = listener.accept().expect("somebody calls");
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).expect("it can be read");
        let mut found = Vec::new();
        let mut rest = &bytes[..];
        while let [a, b, c, d, kind, ..] = *rest {
            let length = u32::from_le_bytes([a, b, c, d]) as usize;
            found.push((kind, rest[5..length].to_vec()));
            rest = &rest[length..];
        }
        assert!(rest.is_empty(), "nothing is left over");
        found
    }

    #[test]
    fn a_server_can_read_the_packets() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("it has one").port();
        let server = std::thread::spawn(move || packets(&listener));
        let mut picture = Picture::new(3, 70);
        for (i, pixel) in picture.color.iter_mut().enumerate() {
            *pixel = [i as f32, 0.5, -1.0, 9.0];
        }
        let address = TevAddress { host: "127.0.0.1".into(), port };
        let mut image = TevImage::create(&address, "a\0b", [3, 70]).expect("somebody listens");
        image.update(&picture).expect("it is sent");
        image.close().expect("it is sent");
        let packets = server.join().expect("the server ends");
        let kinds: Vec<u8> = packets.iter().map(|packet| packet.0).collect();
        assert_eq!(kinds, [4, 6, 6, 2], "create, two bands, close");
        let head = b"\x01ab\0\x03\0\0\0\x46\0\0\0\x03\0\0\0R\0G\0B\0";
        assert_eq!(packets[0].1, head, "name, size, channels");
        let second = &packets[2].1;
        let fields = b"\0ab\0\x03\0\0\0R\0G\0B\0\0\0\0\0\x40\0\0\0\x03\0\0\0\x06\0\0\0";
        assert_eq!(&second[..fields.len()], fields, "rows 64 to 69");
        let longs: Vec<u64> = second[fields.len()..][..48]
            .chunks(8)
            .map(|bytes| u64::from_le_bytes(bytes.try_into().expect("8 bytes")))
            .collect();
        assert_eq!(longs, [0, 1, 2, 3, 3, 3], "offsets and strides");
        let floats: Vec<f32> = second[fields.len() + 48..]
            .chunks(4)
            .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("4 bytes")))
            .collect();
        assert_eq!(floats.len(), 3 * 3 * 6, "no opacity");
        assert_eq!(floats[..6], [192.0, 0.5, -1.0, 193.0, 0.5, -1.0], "pixel by pixel");
        assert_eq!(packets[3].1, b"ab\0", "the same name");
    }

    #[test]
    fn nobody_listens() {
        // A port that was free just before.
        let port = TcpListener::bind("127.0.0.1:0").and_then(|l| l.local_addr()).expect("a port").port();
        let address = TevAddress { host: "127.0.0.1".into(), port };
        let error = TevImage::create(&address, "a", [1, 1]).expect_err("nobody is there").to_string();
        assert!(error.starts_with(&format!("tev at 127.0.0.1:{port}: ")), "{error}");
    }
}
