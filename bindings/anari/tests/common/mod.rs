// SPDX-License-Identifier: GPL-3.0-or-later
//! Small scenes as programs make them.

use anari_library_gnurt::ffi_client::{Channel, Client};
use anari_library_gnurt::types as t;

/// A world to be rendered.
pub(crate) struct Set {
    pub(crate) client: Client,
    pub(crate) world: usize,
    pub(crate) camera: usize,
    pub(crate) renderer: usize,
    surfaces: Vec<usize>,
    volumes: Vec<usize>,
    lights: Vec<usize>,
    instances: Vec<usize>,
}

impl Set {
    /// An empty world before a camera at (0, 0, 5) that looks along -z and shows 2 x 2 in the plane z = 0, in parallel.
    pub(crate) fn new(renderer: &str) -> Self {
        let client = Client::new();
        let (world, camera) = (client.object(t::WORLD, ""), client.object(t::CAMERA, "orthographic"));
        let renderer = client.object(t::RENDERER, renderer);
        client.set_vec3(camera, "position", [0.0, 0.0, 5.0]);
        client.set_float(camera, "height", 2.0);
        client.commit(camera);
        client.commit(renderer);
        let [surfaces, volumes, lights, instances] = Default::default();
        Self { client, world, camera, renderer, surfaces, volumes, lights, instances }
    }

    /// The same seen by another camera.
    pub(crate) fn seen_by(self, camera: usize) -> Self {
        Self { camera, ..self }
    }

    /// Light from everywhere.
    pub(crate) fn ambient(&self, radiance: f32) {
        self.client.set_float(self.renderer, "ambientRadiance", radiance);
        self.client.commit(self.renderer);
    }

    /// Samples of a pixel.
    pub(crate) fn samples(&self, count: u32) {
        self.client.set_u32(self.renderer, "pixelSamples", t::INT32, count);
        self.client.commit(self.renderer);
    }

    /// A matte material.
    pub(crate) fn matte(&self, color: [f32; 3]) -> usize {
        let material = self.client.object(t::MATERIAL, "matte");
        self.client.set_vec3(material, "color", color);
        self.client.commit(material);
        material
    }

    /// A surface, which it lets go.
    pub(crate) fn surface(&self, geometry: usize, material: usize) -> usize {
        let surface = self.client.object(t::SURFACE, "");
        self.client.give(surface, "geometry", t::GEOMETRY, geometry);
        self.client.give(surface, "material", t::MATERIAL, material);
        self.client.commit(surface);
        surface
    }

    /// Adds a geometry of a material to the world.
    pub(crate) fn add(&mut self, geometry: usize, material: usize) -> usize {
        let surface = self.surface(geometry, material);
        self.surfaces.push(surface);
        surface
    }

    /// Adds a light of these floats; three of them are a vector.
    pub(crate) fn light(&mut self, subtype: &str, parameters: &[(&str, &[f32])]) -> usize {
        let light = self.client.object(t::LIGHT, subtype);
        for (name, floats) in parameters {
            let kind = if floats.len() == 3 { t::FLOAT32_VEC3 } else { t::FLOAT32 };
            self.client.set_floats(light, name, kind, floats);
        }
        self.client.commit(light);
        self.lights.push(light);
        light
    }

    /// Adds a volume.
    pub(crate) fn volume(&mut self, volume: usize) {
        self.volumes.push(volume);
    }

    /// Adds an instance.
    pub(crate) fn instance(&mut self, instance: usize) {
        self.instances.push(instance);
    }

    /// A geometry of triangles or quadrilaterals that follow each other.
    pub(crate) fn faces(&self, subtype: &str, corners: &[[f32; 3]]) -> usize {
        let geometry = self.client.object(t::GEOMETRY, subtype);
        let positions = self.client.floats(t::FLOAT32_VEC3, corners.as_flattened());
        self.client.give(geometry, "vertex.position", t::ARRAY1D, positions);
        self.client.commit(geometry);
        geometry
    }

    /// A square of this half side around the origin, across the view.
    pub(crate) fn square(&self, half: f32) -> usize {
        let h = half;
        self.faces("quad", &[[-h, -h, 0.0], [h, -h, 0.0], [h, h, 0.0], [-h, h, 0.0]])
    }

    /// Makes the world hold the added objects.
    pub(crate) fn commit(&self) {
        let lists = [
            ("surface", t::SURFACE, &self.surfaces),
            ("volume", t::VOLUME, &self.volumes),
            ("light", t::LIGHT, &self.lights),
            ("instance", t::INSTANCE, &self.instances),
        ];
        for (name, kind, all) in lists.into_iter().filter(|(_, _, all)| !all.is_empty()) {
            let list = self.client.objects(kind, all);
            self.client.give(self.world, name, t::ARRAY1D, list);
        }
        self.client.commit(self.world);
    }

    /// A frame with these channels, not rendered.
    pub(crate) fn frame(&self, size: [u32; 2], channels: &[(&str, t::DataType)]) -> usize {
        let (client, frame) = (&self.client, self.client.object(t::FRAME, ""));
        client.set(frame, "size", t::UINT32_VEC2, &[size[0].to_ne_bytes(), size[1].to_ne_bytes()].concat());
        client.set_object(frame, "world", t::WORLD, self.world);
        client.set_object(frame, "camera", t::CAMERA, self.camera);
        client.set_object(frame, "renderer", t::RENDERER, self.renderer);
        for (name, kind) in channels {
            client.set(frame, name, t::DATA_TYPE, &kind.to_ne_bytes());
        }
        client.commit(frame);
        frame
    }

    /// A channel of a rendering.
    pub(crate) fn channel(&self, size: [u32; 2], name: &str, kind: t::DataType) -> Channel {
        self.commit();
        let frame = self.frame(size, &[(name, kind)]);
        self.client.render(frame);
        assert!(self.client.is_ready(frame, true), "it was waited for");
        let channel = self.client.channel(frame, name).expect("the channel was asked for");
        self.client.release(frame);
        channel
    }

    /// The colours of a rendering, as floats.
    pub(crate) fn picture(&self, size: [u32; 2]) -> Channel {
        self.channel(size, "channel.color", t::FLOAT32_VEC4)
    }

    /// The mean colour of a rendering.
    pub(crate) fn mean(&self, size: [u32; 2]) -> [f32; 4] {
        mean(&self.picture(size))
    }

    /// Complains about warnings and errors so far.
    pub(crate) fn assert_quiet(&self) {
        let loud: Vec<_> =
            self.client.messages().into_iter().filter(|message| message.severity < 5).collect();
        assert!(loud.is_empty(), "{loud:?}");
    }
}

/// The mean colour of a picture.
pub(crate) fn mean(picture: &Channel) -> [f32; 4] {
    let (floats, count) = (picture.floats(), (picture.size[0] * picture.size[1]) as f32);
    std::array::from_fn(|k| floats.iter().skip(k).step_by(4).sum::<f32>() / count)
}

/// Complains where numbers differ by more than a share of the expected one.
#[track_caller]
pub(crate) fn assert_close(found: f32, expected: f32, share: f32, text: &str) {
    let within = (found - expected).abs() <= share * expected.abs().max(1e-3);
    assert!(within, "{text}: {found}, expected {expected}");
}
