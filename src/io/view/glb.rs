//! A film as binary glTF 2.0.
//!
//! Each frame is a node with one mesh, one primitive a rod; an animation shows one at a time by scaling the others to
//! nothing, as the standard provides (node transforms of scale zero). Without animation the last is visible. Morph
//! targets would move smoothly, but colours could not change with the steps, and viewers accept only a few of them.

use std::path::Path;

use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf_json::buffer::{Target as BufferTarget, View};
use gltf_json::material::{PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::scene::UnitQuaternion;
use gltf_json::validation::{Checked::Valid, USize64};
use gltf_json::{Accessor, Asset, Buffer, Index, Material, Mesh, Node, Root, Scene};

use crate::error::InputError;
use crate::io::picture::palette::{PALE, linear};
use crate::io::picture::span;
use crate::io::picture::{Stripe, colors_by_value};
use crate::math::Vec3;

use super::mesh::{self, MeshStyle, per_ring, tube};
use super::{Film, Frame, FrameRod, Quantity, STRANDS};

/// Sides of a tube, and of a tube in films with many vertices.
const SIDES: [usize; 2] = [14, 6];
/// Largest number of vertices of a file, some 60 bytes each, at one ring per node. Above it tubes get fewer sides, then
/// become lines.
const MAX_VERTICES: usize = 600_000;
/// Largest extent of the scene, in metres, the unit of glTF, because viewers and slides expect such a size.
const EXTENT: f64 = 2.0;

/// Options of glTF files.
#[derive(Debug, Clone, PartialEq)]
pub struct GlbOptions {
    /// By which rods are coloured.
    pub color: Quantity,
    /// Duration of each frame, s. Legal: greater than 0.
    pub seconds_per_frame: f64,
}

impl Default for GlbOptions {
    fn default() -> Self {
        Self { color: Quantity::Strand, seconds_per_frame: 0.25 }
    }
}

impl Film {
    /// The film as a binary glTF file (`.glb`): tubes with the material stripe, or lines where more than 600 000
    /// vertices would be needed, and one animation that steps through the frames.
    ///
    /// The vertices are in the film's own length unit, about the middle of the last frame; the root node rotates the
    /// widest direction to the right and scales that frame to about two metres.
    ///
    /// # Errors
    /// [`InputError`] naming the field if a count, radius or number cannot be used, or a file would exceed the 4 GiB of
    /// the format.
    pub fn glb(&self, options: &GlbOptions) -> Result<Vec<u8>, InputError> {
        self.check()?;
        InputError::positive("seconds_per_frame", options.seconds_per_frame)?;
        let mut writer = GlbWriter::new(self, options);
        let frames: Vec<Index<Node>> = self.frames.iter().map(|frame| writer.frame(frame)).collect();
        writer.root_node(&frames);
        if frames.len() > 1 {
            writer.animation(&frames);
        }
        writer.finish()
    }

    /// Writes [`Film::glb`] to a file, replacing what is there.
    ///
    /// # Errors
    /// As there; [`InputError::Write`] if the file cannot be written.
    pub fn save_glb(&self, path: &Path, options: &GlbOptions) -> Result<(), InputError> {
        let refuse = |e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
        std::fs::write(path, self.glb(options)?).map_err(refuse)
    }
}

struct GlbWriter<'a> {
    film: &'a Film,
    options: &'a GlbOptions,
    range: [f64; 2],
    center: Vec3,
    /// Lines of the obstacles at the start.
    lines: Vec<(usize, [Vec3; 2])>,
    /// Sides of tubes; none for lines.
    sides: Option<usize>,
    root: Root,
    data: Vec<u8>,
}

impl<'a> GlbWriter<'a> {
    fn new(film: &'a Film, options: &'a GlbOptions) -> Self {
        let rods = film.frames.iter().flat_map(|frame| &frame.rods);
        let nodes: usize = rods.map(|rod| rod.points.len()).sum();
        let sides = SIDES.into_iter().find(|&sides| nodes * per_ring(sides) <= MAX_VERTICES);
        let material = |name: &str| Material {
            name: Some(name.to_owned()),
            pbr_metallic_roughness: PbrMetallicRoughness {
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(0.5),
                ..PbrMetallicRoughness::default()
            },
            ..Material::default()
        };
        let asset = Asset { generator: Some(format!("supercoil {}", env!("CARGO_PKG_VERSION"))), ..Asset::default() };
        let lines = film.lines();
        let obstacles = (!lines.is_empty()).then_some("obstacles");
        let materials = film.rods.iter().map(|rod| rod.name.as_str()).chain(obstacles).map(material).collect();
        let root = Root { asset, materials, ..Root::default() };
        let (range, center) = (film.range(options.color), film.stage().0);
        Self { film, options, range, center, lines, sides, root, data: Vec::new() }
    }

    /// Adds a node with the mesh of a frame.
    fn frame(&mut self, frame: &Frame) -> Index<Node> {
        let name = Some(format!("step {}", frame.step));
        let drawn = frame.rods.iter().enumerate().filter(|(_, rod)| rod.points.len() > 1);
        let mut primitives: Vec<Primitive> = drawn.map(|(index, rod)| self.rod(index, rod)).collect();
        if !self.lines.is_empty() {
            primitives.push(self.obstacles(frame));
        }
        // a mesh needs at least one primitive
        let mesh = (!primitives.is_empty()).then(|| {
            let mesh =
                Mesh { name: name.clone(), primitives, extensions: None, extras: Default::default(), weights: None };
            self.root.push(mesh)
        });
        self.root.push(Node { name, mesh, ..Node::default() })
    }

    fn rod(&mut self, index: usize, rod: &FrameRod) -> Primitive {
        let nodes = self.nodes(index, rod);
        let head = &self.film.rods[index];
        let (mesh, mode) = match self.sides {
            Some(sides) => {
                let stripe = linear(Stripe::along(Vec::new()).color);
                let look = MeshStyle { closed: head.closed, seam_turns: rod.seam_turns, sides, stripe };
                (tube(&nodes, &look), Mode::Triangles)
            }
            None => (line(&nodes), if head.closed { Mode::LineLoop } else { Mode::LineStrip }),
        };
        self.primitive(&mesh, mode, index)
    }

    /// The lines of all obstacles, where they are in a frame.
    fn obstacles(&mut self, frame: &Frame) -> Primitive {
        let images: Vec<_> = self.film.images(frame).collect();
        let moved = |(obstacle, ends): &(usize, [Vec3; 2])| {
            let (matrix, shift) = images[*obstacle];
            ends.map(|end| matrix * end + shift - self.center)
        };
        let positions: Vec<Vec3> = self.lines.iter().flat_map(moved).collect();
        let colors = vec![linear(PALE); positions.len()];
        let mesh = mesh::Mesh { positions, colors, ..mesh::Mesh::default() };
        self.primitive(&mesh, Mode::Lines, self.film.rods.len())
    }

    /// Adds the arrays of a mesh, and the primitive of that material that shows them.
    fn primitive(&mut self, mesh: &mesh::Mesh, mode: Mode, material: usize) -> Primitive {
        let floats =
            |vectors: &[Vec3]| -> Vec<[f32; 3]> { vectors.iter().map(|v| [v.x, v.y, v.z].map(|x| x as f32)).collect() };
        let positions = floats(&mesh.positions);
        let bound = |pick: fn(f32, f32) -> f32| {
            positions.iter().copied().reduce(|a, b| std::array::from_fn(|k| pick(a[k], b[k]))).map(|v| v.to_vec())
        };
        let (low, high) = (bound(f32::min), bound(f32::max));
        let bytes =
            |values: &[[f32; 3]]| -> Vec<u8> { values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect() };
        let vectors =
            Layout { kind: Type::Vec3, component: ComponentType::F32, target: Some(BufferTarget::ArrayBuffer) };
        let at = self.accessor(vectors, positions.len(), &bytes(&positions));
        let accessor = &mut self.root.accessors[at.value()];
        (accessor.min, accessor.max) = (low.map(Into::into), high.map(Into::into));
        let mut attributes = std::collections::BTreeMap::from([(Valid(Semantic::Positions), at)]);
        if !mesh.normals.is_empty() {
            let normals = self.accessor(vectors, mesh.normals.len(), &bytes(&floats(&mesh.normals)));
            attributes.insert(Valid(Semantic::Normals), normals);
        }
        // 16 bits: 8 of linear light would show steps in the dark
        let channel = |v: f64| ((v.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes();
        let color = |c: &Vec3| [c.x, c.y, c.z, 1.0].map(channel);
        let colors: Vec<u8> = mesh.colors.iter().flat_map(color).flatten().collect();
        let layout = Layout { kind: Type::Vec4, component: ComponentType::U16, ..vectors };
        attributes.insert(Valid(Semantic::Colors(0)), self.accessor(layout, mesh.colors.len(), &colors));
        let indices = (!mesh.indices.is_empty()).then(|| {
            let bytes: Vec<u8> = mesh.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
            let target = Some(BufferTarget::ElementArrayBuffer);
            let layout = Layout { kind: Type::Scalar, component: ComponentType::U32, target };
            self.accessor(layout, mesh.indices.len(), &bytes)
        });
        let material = Some(Index::new(material as u32));
        Primitive {
            attributes,
            indices,
            material,
            mode: Valid(mode),
            extensions: None,
            extras: Default::default(),
            targets: None,
        }
    }

    /// Nodes of a rod with the data for drawing.
    fn nodes(&self, index: usize, rod: &FrameRod) -> Vec<span::Node> {
        let color = self.options.color;
        let colors = match color {
            Quantity::Strand => vec![STRANDS[index % STRANDS.len()]; rod.points.len()],
            _ => colors_by_value(color.of(rod), color.palette(), Some((self.range[0], self.range[1]))),
        };
        let mut nodes = rod.nodes(self.film.rods[index].closed, |i| linear(colors[i]));
        nodes.iter_mut().for_each(|node| node.point -= self.center);
        nodes
    }

    /// Adds values to the data, and their accessor.
    fn accessor(&mut self, layout: Layout, count: usize, bytes: &[u8]) -> Index<Accessor> {
        let view = View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(self.data.len())),
            byte_stride: None,
            name: None,
            target: layout.target.map(Valid),
            extensions: None,
            extras: Default::default(),
        };
        // every type here fills whole words, so the next array is aligned
        self.data.extend(bytes);
        let view = self.root.push(view);
        self.root.push(Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Valid(GenericComponentType(layout.component)),
            extensions: None,
            extras: Default::default(),
            type_: Valid(layout.kind),
            min: None,
            max: None,
            name: None,
            normalized: layout.component == ComponentType::U16,
            sparse: None,
        })
    }

    /// The node above all frames, and the scene that shows it.
    fn root_node(&mut self, frames: &[Index<Node>]) {
        let (_, axes, extent) = self.film.stage();
        // the rows are the axes x, y, z of the viewer
        let turned = nalgebra::Rotation3::from_matrix_unchecked(axes);
        let q = nalgebra::UnitQuaternion::from_rotation_matrix(&turned).coords;
        let title = Some(self.film.title.clone()).filter(|title| !title.is_empty());
        let root = self.root.push(Node {
            name: Some(format!("{}1 unit = 1 {}", title.map(|t| t + ", ").unwrap_or_default(), self.film.units.length)),
            children: (!frames.is_empty()).then(|| frames.to_vec()),
            rotation: Some(UnitQuaternion([q.x, q.y, q.z, q.w].map(|x| x as f32))),
            scale: Some([(0.5 * EXTENT / extent) as f32; 3]),
            ..Node::default()
        });
        let scene = Scene { name: None, nodes: vec![root], extensions: None, extras: Default::default() };
        self.root.scene = Some(self.root.push(scene));
    }

    /// Shows one frame after the other.
    fn animation(&mut self, frames: &[Index<Node>]) {
        let scalars = Layout { kind: Type::Scalar, component: ComponentType::F32, target: None };
        let seconds = |k: usize| (k as f64 * self.options.seconds_per_frame) as f32;
        // one more than frames, so that the last one has a duration
        let times: Vec<f32> = (0..=frames.len()).map(seconds).collect();
        let bytes: Vec<u8> = times.iter().flat_map(|t| t.to_le_bytes()).collect();
        let input = self.accessor(scalars, times.len(), &bytes);
        let ends = |time: f32| Some(vec![time].into());
        (self.root.accessors[input.value()].min, self.root.accessors[input.value()].max) =
            (ends(times[0]), ends(times[frames.len()]));
        let (mut channels, mut samplers) = (Vec::new(), Vec::new());
        for (k, &node) in frames.iter().enumerate() {
            let shown = |j: usize| if j.min(frames.len() - 1) == k { 1.0_f32 } else { 0.0 };
            let scales: Vec<u8> = (0..times.len()).flat_map(|j| [shown(j); 3]).flat_map(f32::to_le_bytes).collect();
            let output = self.accessor(Layout { kind: Type::Vec3, ..scalars }, times.len(), &scales);
            let (extensions, extras) = (None, Default::default());
            samplers.push(Sampler { input, interpolation: Valid(Interpolation::Step), output, extensions, extras });
            let target = Target { node, path: Valid(Property::Scale), extensions: None, extras: Default::default() };
            let sampler = Index::new(k as u32);
            channels.push(Channel { sampler, target, extensions: None, extras: Default::default() });
            if k + 1 < frames.len() {
                self.root.nodes[node.value()].scale = Some([0.0; 3]);
            }
        }
        let name = Some("steps".to_owned());
        self.root.push(Animation { name, channels, samplers, extensions: None, extras: Default::default() });
    }

    /// Header, JSON and data, one after the other.
    fn finish(mut self) -> Result<Vec<u8>, InputError> {
        if !self.data.is_empty() {
            let byte_length = USize64::from(self.data.len());
            let buffer = Buffer { byte_length, name: None, uri: None, extensions: None, extras: Default::default() };
            self.root.push(buffer);
        }
        let refuse = |reason: String| InputError::Inconsistent { field: "glb".to_owned(), reason };
        let mut json = serde_json::to_vec(&self.root).map_err(|e| refuse(e.to_string()))?;
        json.resize(json.len().next_multiple_of(4), b' ');
        let chunks = [(json, b"JSON"), (self.data, b"BIN\0")];
        let chunks = || chunks.iter().filter(|(bytes, _)| !bytes.is_empty());
        let length = |bytes: usize| {
            let refused = |_| refuse(format!("{bytes} bytes: must be less than 4 GiB, the most a .glb file can have"));
            u32::try_from(bytes).map(u32::to_le_bytes).map_err(refused)
        };
        let total = 12 + chunks().map(|(bytes, _)| 8 + bytes.len()).sum::<usize>();
        let mut file = [*b"glTF", 2_u32.to_le_bytes(), length(total)?].concat();
        for (bytes, kind) in chunks() {
            file.extend(length(bytes.len())?.iter().chain(kind.iter()).chain(bytes));
        }
        Ok(file)
    }
}

/// Layout of the values of an accessor.
#[derive(Clone, Copy)]
struct Layout {
    kind: Type,
    component: ComponentType,
    target: Option<BufferTarget>,
}

/// A rod too long for a tube: its points and their colours.
fn line(nodes: &[span::Node]) -> mesh::Mesh {
    mesh::Mesh {
        positions: nodes.iter().map(|node| node.point).collect(),
        colors: nodes.iter().map(|node| node.color).collect(),
        ..mesh::Mesh::default()
    }
}
