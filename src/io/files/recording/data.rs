//! Binary buffer of a glTF document, and its accessors.

use super::precision::single;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Buffer, Stride, Target, View};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Accessor, Extras, Index, Root, Value};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// Part of the buffer, by content.
#[derive(Clone, Copy)]
enum Part {
    Positions,
    Colors,
    Indices,
    Keys,
}

/// Bytes of the four parts of the buffer, and the accessors that refer to them.
pub(super) struct Data {
    parts: [Vec<u8>; 4],
    accessors: Vec<Accessor>,
    /// Accessors of keyframes, by the length of a value and the bits of all values.
    shared: FxHashMap<(usize, Vec<u64>), Index<Accessor>>,
    /// Current subject, to which the next numbers belong.
    subject: String,
    /// Subject of the first number that is not finite in single precision.
    not_finite: Option<String>,
}

impl Data {
    pub fn new() -> Self {
        Self {
            parts: [const { Vec::new() }; 4],
            accessors: Vec::new(),
            shared: FxHashMap::default(),
            subject: String::new(),
            not_finite: None,
        }
    }

    /// Sets the subject of the next numbers, for error messages.
    pub fn set_subject(&mut self, subject: impl Into<String>) {
        self.subject = subject.into();
    }

    /// Subject of the first number that is not finite in single precision, if there is one.
    pub fn not_finite(&self) -> Option<&str> {
        self.not_finite.as_deref()
    }

    /// Stores the current subject if a number is not finite.
    pub fn check(&mut self, numbers: impl IntoIterator<Item = f32>) {
        if !numbers.into_iter().all(f32::is_finite) {
            self.not_finite.get_or_insert_with(|| self.subject.clone());
        }
    }

    /// Adds the points of a mesh (m).
    pub fn positions(&mut self, points: &[Vector3<f64>]) -> Index<Accessor> {
        let points: Vec<[f64; 3]> = points.iter().map(|&point| point.into()).collect();
        self.bounded_floats(Part::Positions, Type::Vec3, &points)
    }

    /// Adds the colors of the points of a mesh: linear red, green, blue and alpha.
    pub fn colors(&mut self, colors: &[[u8; 4]]) -> Index<Accessor> {
        let (kind, count) = ((ComponentType::U8, Type::Vec4), colors.len());
        let offset = self.append(Part::Colors, colors.concat());
        let accessor = accessor(Part::Colors, offset, count, kind);
        self.push(Accessor {
            normalized: true,
            ..accessor
        })
    }

    /// Adds the point indices of lines or triangles.
    pub fn indices(&mut self, indices: &[u32]) -> Index<Accessor> {
        let short: Option<Vec<u16>> = indices.iter().map(|&index| short(index)).collect();
        let (bytes, component): (Vec<u8>, _) = if let Some(short) = short {
            let bytes = short.iter().flat_map(|index| index.to_le_bytes());
            (bytes.collect(), ComponentType::U16)
        } else {
            let bytes = indices.iter().flat_map(|index| index.to_le_bytes());
            (bytes.collect(), ComponentType::U32)
        };
        let offset = self.append(Part::Indices, bytes);
        let kind = (component, Type::Scalar);
        self.push(accessor(Part::Indices, offset, indices.len(), kind))
    }

    /// Adds the times (s) of keyframes, in increasing order.
    pub fn times(&mut self, times: &[f64]) -> Index<Accessor> {
        let times: Vec<[f64; 1]> = times.iter().map(|&time| [time]).collect();
        self.shared(&times, |data| {
            data.bounded_floats(Part::Keys, Type::Scalar, &times)
        })
    }

    /// Adds the values of keyframes: translations, scales, or quaternions x y z w.
    pub fn keys<const N: usize>(&mut self, values: &[[f64; N]]) -> Index<Accessor> {
        let kind = if N == 4 { Type::Vec4 } else { Type::Vec3 };
        self.shared(values, |data| {
            let accessor = data.floats(Part::Keys, kind, &singles(values));
            data.push(accessor)
        })
    }

    /// Returns the accessor of times or values, and adds it only once.
    fn shared<const N: usize>(
        &mut self,
        values: &[[f64; N]],
        add: impl Fn(&mut Self) -> Index<Accessor>,
    ) -> Index<Accessor> {
        let bits = values.iter().flatten().map(|number| number.to_bits());
        let key = (N, bits.collect());
        if let Some(known) = self.shared.get(&key) {
            return *known;
        }
        let accessor = add(self);
        self.shared.insert(key, accessor);
        accessor
    }

    /// Moves accessors, views and buffer into a document. Returns the bytes of the buffer.
    pub fn write_into(mut self, root: &mut Root) -> Vec<u8> {
        let mut offset = 0;
        let views = PARTS.map(|part| {
            let (start, length) = (offset, self.parts[part as usize].len());
            offset += length;
            (length > 0).then(|| root.push(view(part, start, length)))
        });
        for accessor in &mut self.accessors {
            let part = accessor.buffer_view;
            accessor.buffer_view = part.and_then(|part| views[part.value()]);
        }
        if offset > 0 {
            root.push(buffer(offset));
        }
        root.accessors = self.accessors;
        self.parts.concat()
    }

    /// Adds numbers, with the minimum and maximum of each component, which glTF requires for points and times.
    fn bounded_floats<const N: usize>(
        &mut self,
        part: Part,
        kind: Type,
        values: &[[f64; N]],
    ) -> Index<Accessor> {
        let values = singles(values);
        let bound = |extreme: fn(f32, f32) -> f32| {
            let bound = values.iter().copied().reduce(|bound, value| {
                std::array::from_fn(|component| extreme(bound[component], value[component]))
            });
            bound.map(|bound| Value::from(bound.to_vec()))
        };
        let [min, max] = [bound(f32::min), bound(f32::max)];
        let accessor = self.floats(part, kind, &values);
        self.push(Accessor {
            min,
            max,
            ..accessor
        })
    }

    fn floats<const N: usize>(&mut self, part: Part, kind: Type, values: &[[f32; N]]) -> Accessor {
        let numbers = values.as_flattened();
        self.check(numbers.iter().copied());
        let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
        let offset = self.append(part, bytes.collect());
        accessor(part, offset, values.len(), (ComponentType::F32, kind))
    }

    /// Appends bytes to a part, padded to a multiple of 4 bytes. Returns their offset in the part.
    fn append(&mut self, part: Part, bytes: Vec<u8>) -> usize {
        let target = &mut self.parts[part as usize];
        let offset = target.len();
        target.extend(bytes);
        target.resize(target.len().next_multiple_of(4), 0);
        offset
    }

    fn push(&mut self, accessor: Accessor) -> Index<Accessor> {
        Index::push(&mut self.accessors, accessor)
    }
}

const PARTS: [Part; 4] = [Part::Positions, Part::Colors, Part::Indices, Part::Keys];

fn singles<const N: usize>(values: &[[f64; N]]) -> Vec<[f32; N]> {
    values.iter().map(|&value| single(value)).collect()
}

/// Converts an index to 16 bits, if possible. glTF reserves the largest value.
fn short(index: u32) -> Option<u16> {
    u16::try_from(index).ok().filter(|&short| short != u16::MAX)
}

/// Placeholder of the view of a part, until [`Data::write_into`] knows which parts are empty.
fn placeholder(part: Part) -> Index<View> {
    Index::new(part as u32)
}

fn accessor(
    part: Part,
    offset: usize,
    count: usize,
    (component, kind): (ComponentType, Type),
) -> Accessor {
    Accessor {
        buffer_view: Some(placeholder(part)),
        byte_offset: Some(USize64::from(offset)),
        count: USize64::from(count),
        component_type: Checked::Valid(GenericComponentType(component)),
        type_: Checked::Valid(kind),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
        extensions: None,
        extras: Extras::default(),
    }
}

/// View of a part of the buffer.
fn view(part: Part, offset: usize, length: usize) -> View {
    let (target, stride) = match part {
        Part::Positions => (Some(Target::ArrayBuffer), Some(12)),
        Part::Colors => (Some(Target::ArrayBuffer), Some(4)),
        Part::Indices => (Some(Target::ElementArrayBuffer), None),
        Part::Keys => (None, None),
    };
    View {
        buffer: Index::new(0),
        byte_length: USize64::from(length),
        byte_offset: Some(USize64::from(offset)),
        byte_stride: stride.map(Stride),
        target: target.map(Checked::Valid),
        name: None,
        extensions: None,
        extras: Extras::default(),
    }
}

fn buffer(length: usize) -> Buffer {
    Buffer {
        byte_length: USize64::from(length),
        uri: None,
        name: None,
        extensions: None,
        extras: Extras::default(),
    }
}
