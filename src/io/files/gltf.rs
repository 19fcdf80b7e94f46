//! Reader of glTF 2.0 files: the triangles of the default scene. Materials, lights, animations, morph targets and the deformation by skins
//! are ignored.

use super::FileError;
use super::scalar::{ByteOrder, Scalar};
use super::scene::{MAX_DEPTH, Scene, fan, strip};
use crate::mesh::TriangleSoup;
use base64::{Engine, prelude::BASE64_STANDARD};
use gltf_json::accessor::ComponentType::{self, F32, I8, I16, U8, U16, U32};
use gltf_json::deserialize::{from_slice, from_value};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Node, Root, Value, accessor::Type};
use nalgebra::{Matrix4, Quaternion, Translation3, UnitQuaternion, Vector3, Vector4};
use std::path::Path;

/// Size (bytes) of the header of a binary file: the word glTF, the version, and the length of the file.
const HEADER_SIZE: usize = 12;

/// Types of the chunks of a binary file.
const JSON: &[u8] = b"JSON";
const BINARY: &[u8] = b"BIN\0";

/// Lists of the document that are not read.
const IGNORED_LISTS: [&str; 5] = ["animations", "images", "materials", "samplers", "textures"];

/// Second words of the names of extensions that do not change triangles, such as "texture" in `KHR_texture_transform`.
const IGNORED_EXTENSION_WORDS: [&str; 3] = ["lights", "materials", "texture"];

type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Reads the triangles (m) of a file in its own axes: y points upwards.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let soup = document(bytes).and_then(|document| document.soup(bytes.len()));
    soup.map_err(|source| FileError::syntax(path, "glTF 2.0", source))
}

struct Document<'a> {
    root: Root,
    buffers: Vec<Buffer<'a>>,
}

enum Buffer<'a> {
    Chunk(&'a [u8]),
    Decoded(Vec<u8>),
}

fn document(bytes: &[u8]) -> Result<Document<'_>, Cause> {
    let (json, chunk) = match bytes {
        [b'g', b'l', b'T', b'F', 2, 0, 0, 0, ..] => {
            let rest = bytes.get(HEADER_SIZE..).unwrap_or_default();
            let (json, rest) = chunk_of(JSON, rest)?;
            (
                json,
                if rest.is_empty() {
                    rest
                } else {
                    chunk_of(BINARY, rest)?.0
                },
            )
        }
        [b'g', b'l', b'T', b'F', ..] => {
            return Err("only version 2 of binary glTF can be read".into());
        }
        _ => (bytes, &[][..]),
    };
    let root = root(json)?;
    let is_ignored = |extension: &String| {
        let word = extension.split('_').nth(1).unwrap_or_default();
        IGNORED_EXTENSION_WORDS.contains(&word)
    };
    let required = &root.extensions_required;
    if let Some(extension) = required.iter().find(|extension| !is_ignored(extension)) {
        return Err(format!("the required extension {extension:?} cannot be read").into());
    }
    let buffers = root.buffers.iter().map(|buffer| {
        let Some(uri) = &buffer.uri else {
            return Ok(Buffer::Chunk(chunk));
        };
        let data = uri
            .strip_prefix("data:")
            .and_then(|data| data.split_once(";base64,"));
        let Some((_, data)) = data else {
            return Err("the coordinates are in another file: save as .glb".into());
        };
        let decoded = BASE64_STANDARD.decode(data);
        Ok(Buffer::Decoded(decoded.map_err(|error| error.to_string())?))
    });
    let buffers = buffers.collect::<Result<_, Cause>>()?;
    Ok(Document { root, buffers })
}

/// Parses a document. First removes ignored lists and all `extras`, because they may use unknown extensions or have unexpected types.
fn root(json: &[u8]) -> Result<Root, Cause> {
    let mut document: Value = from_slice(json)?;
    if let Some(document) = document.as_object_mut() {
        document.retain(|name, _| !IGNORED_LISTS.contains(&name.as_str()));
    }
    remove_extras(&mut document);
    Ok(from_value(document)?)
}

fn remove_extras(value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.remove("extras");
            members.values_mut().for_each(remove_extras);
        }
        Value::Array(items) => items.iter_mut().for_each(remove_extras),
        _ => {}
    }
}

/// Content of a chunk of this type at the start of the bytes, and the bytes after it.
fn chunk_of<'a>(kind: &[u8], bytes: &'a [u8]) -> Result<(&'a [u8], &'a [u8]), Cause> {
    let chunk = || {
        let (length, rest) = bytes.split_first_chunk()?;
        let rest = rest.strip_prefix(kind)?;
        rest.split_at_checked(usize::try_from(u32::from_le_bytes(*length)).ok()?)
    };
    chunk().ok_or_else(|| {
        format!(
            "the chunk {:?} is missing or truncated",
            String::from_utf8_lossy(kind)
        )
        .into()
    })
}

impl Document<'_> {
    fn soup(&self, size: usize) -> Result<TriangleSoup, Cause> {
        let mut scene = Scene::of_file(size);
        let parts = self.root.meshes.iter().map(|mesh| {
            let primitives = mesh.primitives.iter();
            let parts = primitives.map(|primitive| self.part(primitive, &mut scene));
            parts.collect::<Result<Vec<TriangleSoup>, Cause>>()
        });
        let parts: Vec<Vec<TriangleSoup>> = parts.collect::<Result<_, Cause>>()?;
        let index = self.root.scene.map_or(0, |scene| scene.value());
        let Some(nodes) = self.root.scenes.get(index).map(|scene| &scene.nodes) else {
            // A file without a scene is a library of meshes.
            parts
                .iter()
                .flatten()
                .try_for_each(|part| scene.add(part, &Matrix4::identity()))?;
            return Ok(scene.soup);
        };
        let mut stack: Vec<(usize, usize, Matrix4<f64>)> = nodes
            .iter()
            .map(|node| (node.value(), 0, Matrix4::identity()))
            .collect();
        while let Some((index, depth, parent)) = stack.pop() {
            let node = self.root.nodes.get(index).ok_or("a node does not exist")?;
            if depth > MAX_DEPTH {
                return Err("the tree of nodes is too deep, or contains itself".into());
            }
            let transform = parent * transform(node);
            if let Some(mesh) = node.mesh {
                let parts = parts.get(mesh.value()).ok_or("a mesh does not exist")?;
                parts
                    .iter()
                    .try_for_each(|part| scene.add(part, &transform))?;
            }
            // Each visit of a node counts towards the limit of the scene, even if the node has no triangles.
            scene.add(&TriangleSoup::default(), &transform)?;
            let children = node.children.iter().flatten();
            stack.extend(children.map(|child| (child.value(), depth + 1, transform)));
        }
        Ok(scene.soup)
    }

    /// Reads the triangles of a primitive and the vertices that they use. Many primitives may refer to the same vertices.
    fn part(&self, primitive: &Primitive, scene: &mut Scene) -> Result<TriangleSoup, Cause> {
        let Some(&positions) = primitive
            .attributes
            .get(&Checked::Valid(Semantic::Positions))
        else {
            return Ok(TriangleSoup::default());
        };
        let positions = self.items(positions, &[F32], Type::Vec3)?;
        let indices = primitive.indices.map(|indices| {
            let types = [U8, U16, U32];
            self.items(indices, &types, Type::Scalar)
        });
        let indices = indices.transpose()?;
        let count = indices
            .as_ref()
            .map_or(positions.count, |items| items.count);
        scene.charge(count)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the numbers are unsigned and have at most 32 bits"
        )]
        let corner = |corner: usize| match &indices {
            Some(indices) => indices.number(corner, 0) as usize,
            None => corner,
        };
        let corners: Vec<usize> = (0..count).map(corner).collect();
        let mut used = corners.clone();
        used.sort_unstable();
        used.dedup();
        if used.last().is_some_and(|&last| last >= positions.count) {
            return Err("a triangle refers to a vertex that does not exist".into());
        }
        let position = |&vertex: &usize| Vector3::from_fn(|axis, _| positions.number(vertex, axis));
        let vertices = used.iter().map(position).collect();
        let new_index = |corner: &usize| used.binary_search(corner).unwrap_or_default();
        let corners: Vec<usize> = corners.iter().map(new_index).collect();
        let triangles = match primitive.mode {
            Checked::Valid(Mode::Triangles) => corners.as_chunks::<3>().0.to_vec(),
            Checked::Valid(Mode::TriangleStrip) => strip(&corners).collect(),
            Checked::Valid(Mode::TriangleFan) => fan(&corners).collect(),
            _ => Vec::new(),
        };
        Ok(TriangleSoup {
            vertices,
            triangles,
        })
    }

    /// Items of an accessor, which must have one of the types and this dimension.
    fn items(
        &self,
        accessor: Index<gltf_json::Accessor>,
        types: &[ComponentType],
        dimension: Type,
    ) -> Result<Items<'_>, Cause> {
        let accessor = self.root.accessors.get(accessor.value());
        let accessor = accessor.ok_or("an accessor does not exist")?;
        let Checked::Valid(component) = accessor.component_type else {
            return Err("an accessor has an unknown type".into());
        };
        let component = component.0;
        if !types.contains(&component) || accessor.type_ != Checked::Valid(dimension) {
            return Err(
                "coordinates must be vectors in single precision, and indices must be integers"
                    .into(),
            );
        }
        let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
            return Err("sparse accessors cannot be read: export without them".into());
        };
        let width = if dimension == Type::Vec3 { 3 } else { 1 };
        let scalar = scalar(component);
        let count = usize::try_from(accessor.count.0)?;
        let offset = usize::try_from(accessor.byte_offset.map_or(0, |offset| offset.0))?;
        let (bytes, stride) = self.view(view.value(), width * scalar.size)?;
        let bytes = bytes.get(offset..).unwrap_or_default();
        let last = count.saturating_sub(1).saturating_mul(stride);
        if count > 0 && last.saturating_add(width * scalar.size) > bytes.len() {
            return Err("an accessor is longer than its buffer".into());
        }
        Ok(Items {
            bytes,
            stride,
            count,
            scalar,
        })
    }

    /// Bytes of a view, and the stride of its items (bytes).
    fn view(&self, index: usize, item_size: usize) -> Result<(&[u8], usize), Cause> {
        let view = self.root.buffer_views.get(index);
        let view = view.ok_or("a view of a buffer does not exist")?;
        let buffer = match self.buffers.get(view.buffer.value()) {
            Some(Buffer::Chunk(bytes)) => bytes,
            Some(Buffer::Decoded(bytes)) => &bytes[..],
            None => return Err("a buffer does not exist".into()),
        };
        let offset = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0))?;
        let length = usize::try_from(view.byte_length.0)?;
        let bytes = buffer.get(offset..).and_then(|rest| rest.get(..length));
        let bytes = bytes.ok_or("a view is longer than its buffer")?;
        let stride = view.byte_stride.map_or(item_size, |stride| stride.0);
        Ok((bytes, stride.max(1)))
    }
}

/// Items of an accessor: vectors or numbers.
struct Items<'a> {
    bytes: &'a [u8],
    /// Distance (bytes) between the starts of two items.
    stride: usize,
    count: usize,
    scalar: Scalar,
}

impl Items<'_> {
    /// Returns a component of an item. Both must exist.
    fn number(&self, item: usize, component: usize) -> f64 {
        let start = item * self.stride + component * self.scalar.size;
        let bytes = self.bytes.get(start..).unwrap_or_default();
        self.scalar.real(bytes, ByteOrder::Little)
    }
}

fn scalar(component: ComponentType) -> Scalar {
    match component {
        I8 => Scalar::I8,
        U8 => Scalar::U8,
        I16 => Scalar::I16,
        U16 => Scalar::U16,
        U32 => Scalar::U32,
        F32 => Scalar::F32,
    }
}

/// Transform of a node into its parent.
fn transform(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = node.matrix {
        return Matrix4::from_column_slice(&matrix).cast();
    }
    let [x, y, z, w] = node
        .rotation
        .map_or([0.0, 0.0, 0.0, 1.0], |rotation| rotation.0);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z).cast::<f64>());
    let scale: Vector3<f64> = Vector3::from(node.scale.unwrap_or([1.0; 3])).cast();
    let translation: Vector3<f64> = Vector3::from(node.translation.unwrap_or_default()).cast();
    let scale = Matrix4::from_diagonal(&Vector4::new(scale.x, scale.y, scale.z, 1.0));
    Translation3::from(translation).to_homogeneous() * rotation.to_homogeneous() * scale
}
