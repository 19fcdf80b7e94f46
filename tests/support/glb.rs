//! A reader of `.glb` files: the container, the numbers of accessors, and nodes at a time of the animation.

use gltf_json::accessor::ComponentType;
use gltf_json::animation::{Interpolation, Property, Sampler};
use gltf_json::mesh::{Primitive, Semantic};
use gltf_json::validation::{Checked, USize64, Validate};
use gltf_json::{Accessor, Index, Node, Root, Value};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A file: its JSON and its binary buffer, which may be empty.
pub struct Glb {
    pub root: Root,
    pub binary: Vec<u8>,
}

/// Placement of a node at a time, in its parent's frame.
#[derive(Debug, Clone, Copy)]
pub struct Placement {
    pub translation: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub scale: Vector3<f64>,
}

/// Keyframes of a property of a node.
pub struct Keys<const N: usize> {
    pub times: Vec<f32>,
    pub values: Vec<[f32; N]>,
    pub interpolation: Interpolation,
}

/// A mesh with one primitive of triangles.
pub struct Mesh {
    pub points: Vec<Vector3<f64>>,
    pub triangles: Vec<[usize; 3]>,
    /// One color per point, or no colors.
    pub colors: Vec<[u8; 4]>,
}

impl Glb {
    /// Parses a file, and checks all sizes in the container.
    pub fn read(bytes: &[u8]) -> Self {
        assert_eq!(&bytes[..4], b"glTF");
        assert_eq!(number(bytes, 4), 2, "version");
        assert_eq!(number(bytes, 8), bytes.len(), "length");
        let (json, rest) = chunk(&bytes[12..], *b"JSON");
        let binary = if rest.is_empty() {
            Vec::new()
        } else {
            let (binary, rest) = chunk(rest, *b"BIN\0");
            assert!(rest.is_empty(), "unexpected third chunk");
            binary.to_vec()
        };
        let root = Root::from_slice(json).unwrap();
        Self { root, binary }
    }

    /// Returns the faults found by `gltf_json`.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        self.root
            .validate(&self.root, gltf_json::Path::new, &mut |path, error| {
                faults.push(format!("{}: {error}", path()));
            });
        faults
    }

    pub fn name(&self, node: Index<Node>) -> &str {
        self.root.get(node).unwrap().name.as_deref().unwrap()
    }

    /// Returns all nodes whose names have this prefix.
    pub fn nodes(&self, beginning: &str) -> Vec<Index<Node>> {
        let all = 0..u32::try_from(self.root.nodes.len()).unwrap();
        all.map(Index::new)
            .filter(|&node| self.name(node).starts_with(beginning))
            .collect()
    }

    /// Returns the only node whose name has this prefix.
    pub fn node(&self, beginning: &str) -> Index<Node> {
        let [node] = self.nodes(beginning)[..] else {
            panic!("the number of nodes that begin with {beginning:?} is not one")
        };
        node
    }

    /// Returns the keyframes of a node's property, if it is animated.
    pub fn keys<const N: usize>(&self, node: Index<Node>, property: Property) -> Option<Keys<N>> {
        let animation = self.root.animations.first()?;
        let channel = animation.channels.iter().find(|channel| {
            channel.target.node == node && channel.target.path == Checked::Valid(property)
        })?;
        let sampler: &Sampler = &animation.samplers[channel.sampler.value()];
        let times = self.floats::<1>(sampler.input);
        Some(Keys {
            times: times.into_iter().flatten().collect(),
            values: self.floats(sampler.output),
            interpolation: sampler.interpolation.unwrap(),
        })
    }

    pub fn is_animated(&self, node: Index<Node>) -> bool {
        let mut channels = self.root.animations.iter().flat_map(|all| &all.channels);
        channels.any(|channel| channel.target.node == node)
    }

    /// Returns the placement of a node at a time (s): its own, or that of its animation.
    pub fn placement(&self, node: Index<Node>, time: f32) -> Placement {
        let node_data = self.root.get(node).unwrap();
        let translation = self.keys(node, Property::Translation).map_or_else(
            || node_data.translation.unwrap_or_default(),
            |keys| keys.at(time, mixed),
        );
        let rotation = self.keys(node, Property::Rotation).map_or_else(
            || node_data.rotation.unwrap_or_default().0,
            |keys| keys.at(time, turned),
        );
        let scale = self.keys(node, Property::Scale).map_or_else(
            || node_data.scale.unwrap_or([1.0; 3]),
            |keys| keys.at(time, mixed),
        );
        Placement {
            translation: vector(translation),
            rotation: UnitQuaternion::new_normalize(quaternion(rotation)),
            scale: vector(scale),
        }
    }

    /// Returns whether a node has a nonzero scale at a time.
    pub fn is_visible(&self, node: Index<Node>, time: f32) -> bool {
        self.placement(node, time).scale.amin() > 0.0
    }

    pub fn primitives(&self, node: Index<Node>) -> &[Primitive] {
        let mesh = self.root.get(node).unwrap().mesh.unwrap();
        &self.root.get(mesh).unwrap().primitives
    }

    /// Returns the triangles of a node's mesh, which are its first primitive.
    pub fn mesh(&self, node: Index<Node>) -> Mesh {
        let primitive = &self.primitives(node)[0];
        let colors = attribute(primitive, Semantic::Colors(0));
        let indices = self.indices(primitive.indices.unwrap());
        let (triangles, rest) = indices.as_chunks();
        assert!(rest.is_empty());
        Mesh {
            points: self.points(attribute(primitive, Semantic::Positions).unwrap()),
            triangles: triangles.to_vec(),
            colors: colors.map_or_else(Vec::new, |colors| self.colors(colors)),
        }
    }

    fn points(&self, accessor: Index<Accessor>) -> Vec<Vector3<f64>> {
        self.floats(accessor).into_iter().map(vector).collect()
    }

    /// Returns the numbers of an accessor, and checks the accessor's bounds against them.
    pub fn floats<const N: usize>(&self, accessor: Index<Accessor>) -> Vec<[f32; N]> {
        let bytes = self.bytes(accessor, ComponentType::F32, N);
        let floats: Vec<f32> = bytes
            .as_chunks()
            .0
            .iter()
            .copied()
            .map(f32::from_le_bytes)
            .collect();
        let values = floats.as_chunks().0.to_vec();
        let accessor = self.root.get(accessor).unwrap();
        assert_bound(accessor.min.as_ref(), &values, f32::min);
        assert_bound(accessor.max.as_ref(), &values, f32::max);
        values
    }

    fn colors(&self, accessor: Index<Accessor>) -> Vec<[u8; 4]> {
        assert!(self.root.get(accessor).unwrap().normalized);
        let bytes = self.bytes(accessor, ComponentType::U8, 4);
        bytes.as_chunks().0.to_vec()
    }

    fn indices(&self, accessor: Index<Accessor>) -> Vec<usize> {
        let kind = self.root.get(accessor).unwrap().component_type.unwrap().0;
        let bytes = self.bytes(accessor, kind, 1);
        let number = |bytes: &[u8]| {
            let digits = bytes.iter().rev();
            digits.fold(0, |number, &digit| number << 8 | usize::from(digit))
        };
        bytes.chunks(kind.size()).map(number).collect()
    }

    /// Returns the bytes of an accessor, which must have numbers of this kind in groups of `together`.
    fn bytes(&self, accessor: Index<Accessor>, kind: ComponentType, together: usize) -> &[u8] {
        let accessor = self.root.get(accessor).unwrap();
        assert_eq!(accessor.component_type.unwrap().0, kind);
        assert_eq!(accessor.type_.unwrap().multiplicity(), together);
        let view = self.root.get(accessor.buffer_view.unwrap()).unwrap();
        let size = kind.size() * together;
        assert!(view.byte_stride.is_none_or(|stride| stride.0 == size));
        let part = &self.binary[to_usize(view.byte_offset)..][..to_usize(Some(view.byte_length))];
        &part[to_usize(accessor.byte_offset)..][..size * to_usize(Some(accessor.count))]
    }
}

impl<const N: usize> Keys<N> {
    /// Returns the value at a time. It is constant before the first key and after the last key. Between two keys, `between` interpolates
    /// with a fraction from 0 to 1.
    fn at(&self, time: f32, between: impl Fn([f32; N], [f32; N], f32) -> [f32; N]) -> [f32; N] {
        let after = self.times.partition_point(|&key| key <= time);
        let Some(before) = after.checked_sub(1) else {
            return self.values[0];
        };
        let (from, Some(&to)) = (self.values[before], self.values.get(after)) else {
            return self.values[before];
        };
        match self.interpolation {
            Interpolation::Step => from,
            Interpolation::Linear => {
                let [start, end] = [before, after].map(|key| self.times[key]);
                between(from, to, (time - start) / (end - start))
            }
            Interpolation::CubicSpline => panic!("unexpected cubic spline"),
        }
    }
}

impl Mesh {
    pub fn corners(&self) -> impl Iterator<Item = [Vector3<f64>; 3]> {
        let points = |triangle: &[usize; 3]| triangle.map(|corner| self.points[corner]);
        self.triangles.iter().map(points)
    }

    /// Returns the area (m²).
    pub fn area(&self) -> f64 {
        self.corners().map(|corners| area(&corners)).sum()
    }

    /// Returns ∫ (x − point) dA (m³).
    pub fn first_moment_about(&self, point: &Vector3<f64>) -> Vector3<f64> {
        let arm = |[a, b, c]: &[Vector3<f64>; 3]| (a + b + c) / 3.0 - point;
        self.corners()
            .map(|corners| arm(&corners) * area(&corners))
            .sum()
    }

    /// Returns the enclosed volume (m³), if the surface is closed. It is positive if the triangles are counter-clockwise seen from outside.
    pub fn volume(&self) -> f64 {
        let cone = |[a, b, c]: [Vector3<f64>; 3]| a.dot(&b.cross(&c)) / 6.0;
        self.corners().map(cone).sum()
    }
}

fn area([a, b, c]: &[Vector3<f64>; 3]) -> f64 {
    (b - a).cross(&(c - a)).norm() / 2.0
}

/// Returns the content of a chunk of this kind, and the bytes after it.
fn chunk(bytes: &[u8], kind: [u8; 4]) -> (&[u8], &[u8]) {
    let length = number(bytes, 0);
    assert_eq!(bytes[4..8], kind);
    assert_eq!(length % 4, 0, "padding");
    bytes[8..].split_at(length)
}

fn number(bytes: &[u8], offset: usize) -> usize {
    u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap()) as usize
}

fn to_usize(number: Option<USize64>) -> usize {
    usize::try_from(number.unwrap_or_default().0).unwrap()
}

fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<Index<Accessor>> {
    primitive.attributes.get(&Checked::Valid(semantic)).copied()
}

/// Asserts that a bound, if present, is that of the values along each axis.
fn assert_bound<const N: usize>(
    bound: Option<&Value>,
    values: &[[f32; N]],
    extreme: fn(f32, f32) -> f32,
) {
    let Some(bound) = bound else { return };
    for axis in 0..N {
        let along = values.iter().map(|value| value[axis]);
        assert_eq!(bound[axis].as_f64(), along.reduce(extreme).map(f64::from));
    }
}

fn mixed(from: [f32; 3], to: [f32; 3], part: f32) -> [f32; 3] {
    std::array::from_fn(|axis| from[axis] + (to[axis] - from[axis]) * part)
}

fn turned(from: [f32; 4], to: [f32; 4], part: f32) -> [f32; 4] {
    let [from, to] = [from, to].map(|turn| UnitQuaternion::new_normalize(quaternion(turn)));
    let between = from.slerp(&to, f64::from(part));
    #[expect(clippy::cast_possible_truncation, reason = "glTF has single precision")]
    between.coords.map(|number| number as f32).into()
}

pub fn vector(numbers: [f32; 3]) -> Vector3<f64> {
    numbers.map(f64::from).into()
}

/// Converts from the order x y z w.
pub fn quaternion([x, y, z, w]: [f32; 4]) -> Quaternion<f64> {
    let [x, y, z, w] = [x, y, z, w].map(f64::from);
    Quaternion::new(w, x, y, z)
}
