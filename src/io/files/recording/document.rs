//! A glTF document, written as one `.glb` file.

use super::data::Data;
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf_json::mesh::{Mesh, Primitive};
use gltf_json::scene::{Scene, UnitQuaternion};
use gltf_json::validation::Checked;
use gltf_json::{Camera, Extras, Index, Material, Node, Root};

/// Bytes of the header of a `.glb` file, and of that of a chunk.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;
/// Version of glTF.
const VERSION: u32 = 2;
/// The extension of glTF by which materials are the same in any light.
const UNLIT: &str = "KHR_materials_unlit";

/// Meshes, nodes and their animation.
pub(super) struct Document {
    root: Root,
    pub data: Data,
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
    top: Vec<Index<Node>>,
}

/// Why a document has no file.
pub(super) enum Unwritable {
    /// A number of this is not finite in single precision.
    NotFinite(String),
    /// It is longer (bytes) than its header can tell.
    TooLong(usize),
    /// It has no JSON.
    Json(gltf_json::Error),
}

impl Document {
    pub fn new() -> Self {
        let mut root = Root::default();
        root.asset.generator = Some("hydroelastic".to_owned());
        Self {
            root,
            data: Data::new(),
            channels: Vec::new(),
            samplers: Vec::new(),
            top: Vec::new(),
        }
    }

    pub fn material(&mut self, material: Material) -> Index<Material> {
        let used = &mut self.root.extensions_used;
        if material.extensions.is_some() && used.is_empty() {
            used.push(UNLIT.to_owned());
        }
        self.root.push(material)
    }

    pub fn camera(&mut self, camera: Camera) -> Index<Camera> {
        let perspective = camera.perspective.iter();
        self.data
            .check(perspective.map(|perspective| perspective.znear));
        self.root.push(camera)
    }

    pub fn mesh(&mut self, primitives: Vec<Primitive>) -> Index<Mesh> {
        self.root.push(Mesh {
            name: None,
            primitives,
            weights: None,
            extensions: None,
            extras: Extras::default(),
        })
    }

    /// A node in world coordinates.
    pub fn node(&mut self, node: Node) -> Index<Node> {
        let rotation = node.rotation.map(|rotation| rotation.0);
        let vectors = [node.translation, node.scale]
            .into_iter()
            .flatten()
            .flatten();
        self.data
            .check(vectors.chain(rotation.into_iter().flatten()));
        let index = self.root.push(node);
        self.top.push(index);
        index
    }

    /// Moves a node by keys at these times: 4 numbers each for a rotation, otherwise 3. With one key
    /// alone it stays as it is.
    pub fn animate<const N: usize>(
        &mut self,
        node: Index<Node>,
        (property, interpolation): (Property, Interpolation),
        times: &[f64],
        values: &[[f64; N]],
    ) {
        if times.len() < 2 {
            return;
        }
        let sampler = Sampler {
            input: self.data.times(times),
            interpolation: Checked::Valid(interpolation),
            output: self.data.keys(values),
            extensions: None,
            extras: Extras::default(),
        };
        let target = Target {
            node,
            path: Checked::Valid(property),
            extensions: None,
            extras: Extras::default(),
        };
        self.channels.push(Channel {
            sampler: Index::push(&mut self.samplers, sampler),
            target,
            extensions: None,
            extras: Extras::default(),
        });
    }

    /// The file, with the world turned by a quaternion (x y z w) so that y is up.
    pub fn into_glb(mut self, to_y_up: [f32; 4]) -> Result<Vec<u8>, Unwritable> {
        if let Some(part) = self.data.not_finite() {
            return Err(Unwritable::NotFinite(part.to_owned()));
        }
        let world = self.root.push(Node {
            name: Some("world".to_owned()),
            children: (!self.top.is_empty()).then_some(self.top),
            rotation: Some(UnitQuaternion(to_y_up)),
            ..Node::default()
        });
        let scene = self.root.push(Scene {
            nodes: vec![world],
            name: None,
            extensions: None,
            extras: Extras::default(),
        });
        self.root.scene = Some(scene);
        if !self.channels.is_empty() {
            self.root.animations.push(Animation {
                channels: self.channels,
                samplers: self.samplers,
                name: Some("rollout".to_owned()),
                extensions: None,
                extras: Extras::default(),
            });
        }
        let binary = self.data.moved_into(&mut self.root);
        let json = self.root.to_vec().map_err(Unwritable::Json)?;
        container(json, binary)
    }
}

/// The `.glb` container of the two chunks.
fn container(mut json: Vec<u8>, binary: Vec<u8>) -> Result<Vec<u8>, Unwritable> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut chunks = vec![(b"JSON", json), (b"BIN\0", binary)];
    chunks.retain(|(_, chunk)| !chunk.is_empty());
    let lengths = chunks.iter().map(|(_, chunk)| CHUNK_HEADER + chunk.len());
    let length = HEADER + lengths.sum::<usize>();
    let size = |bytes: usize| u32::try_from(bytes).map_err(|_| Unwritable::TooLong(length));
    let mut glb = b"glTF".to_vec();
    glb.extend([VERSION, size(length)?].map(u32::to_le_bytes).concat());
    for (kind, chunk) in chunks {
        glb.extend(size(chunk.len())?.to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    Ok(glb)
}
