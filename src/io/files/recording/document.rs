//! glTF document, written as a `.glb` file.

use super::data::Data;
use gltf_json::animation::{Animation, Channel, Interpolation, Property, Sampler, Target};
use gltf_json::mesh::{Mesh, Primitive};
use gltf_json::scene::{Scene, UnitQuaternion};
use gltf_json::validation::Checked;
use gltf_json::{Camera, Extras, Index, Material, Node, Root};

/// Size of the header of a `.glb` file (bytes).
const HEADER_SIZE: usize = 12;
/// Size of the header of a chunk (bytes).
const CHUNK_HEADER_SIZE: usize = 8;
/// Version of glTF.
const VERSION: u32 = 2;
/// glTF extension for materials that do not depend on lighting.
const UNLIT: &str = "KHR_materials_unlit";

/// A glTF document under construction.
pub(super) struct Document {
    root: Root,
    pub data: Data,
    channels: Vec<Channel>,
    samplers: Vec<Sampler>,
    top_nodes: Vec<Index<Node>>,
}

/// Reason why a document cannot be written.
pub(super) enum Unwritable {
    /// A number of this subject is not finite in single precision.
    NotFinite(String),
    /// The length (bytes) does not fit into the header.
    TooLong(usize),
    /// The JSON serialization failed.
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
            top_nodes: Vec::new(),
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

    /// Adds a node in world coordinates.
    pub fn node(&mut self, node: Node) -> Index<Node> {
        let rotation = node.rotation.map(|rotation| rotation.0);
        let vectors = [node.translation, node.scale]
            .into_iter()
            .flatten()
            .flatten();
        self.data
            .check(vectors.chain(rotation.into_iter().flatten()));
        let index = self.root.push(node);
        self.top_nodes.push(index);
        index
    }

    /// Animates a node with keyframes at times (s): 4 numbers per keyframe for a rotation, otherwise 3. Does nothing for fewer than 2
    /// keyframes.
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

    /// Returns the bytes of the file. The quaternion (x y z w) rotates the world so that y is up.
    ///
    /// # Errors
    /// The variants of [`Unwritable`].
    pub fn into_glb(mut self, to_y_up: [f32; 4]) -> Result<Vec<u8>, Unwritable> {
        if let Some(part) = self.data.not_finite() {
            return Err(Unwritable::NotFinite(part.to_owned()));
        }
        let world = self.root.push(Node {
            name: Some("world".to_owned()),
            children: (!self.top_nodes.is_empty()).then_some(self.top_nodes),
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
        let binary = self.data.write_into(&mut self.root);
        let json = self.root.to_vec().map_err(Unwritable::Json)?;
        container(json, binary)
    }
}

/// Returns the `.glb` container of the JSON chunk and the binary chunk.
fn container(mut json: Vec<u8>, binary: Vec<u8>) -> Result<Vec<u8>, Unwritable> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut chunks = vec![(b"JSON", json), (b"BIN\0", binary)];
    chunks.retain(|(_, chunk)| !chunk.is_empty());
    let lengths = chunks
        .iter()
        .map(|(_, chunk)| CHUNK_HEADER_SIZE + chunk.len());
    let length = HEADER_SIZE + lengths.sum::<usize>();
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
