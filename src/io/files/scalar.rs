//! Numbers in binary files.

/// Order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Signed,
    Unsigned,
    Float,
}

/// Type of a number in a binary file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scalar {
    kind: Kind,
    /// Size (bytes), at most 8.
    pub size: usize,
}

impl Scalar {
    pub const I8: Self = Self::new(Kind::Signed, 1);
    pub const U8: Self = Self::new(Kind::Unsigned, 1);
    pub const I16: Self = Self::new(Kind::Signed, 2);
    pub const U16: Self = Self::new(Kind::Unsigned, 2);
    pub const I32: Self = Self::new(Kind::Signed, 4);
    pub const U32: Self = Self::new(Kind::Unsigned, 4);
    pub const U64: Self = Self::new(Kind::Unsigned, 8);
    pub const F32: Self = Self::new(Kind::Float, 4);
    pub const F64: Self = Self::new(Kind::Float, 8);

    const fn new(kind: Kind, size: usize) -> Self {
        Self { kind, size }
    }

    /// Returns the type with a name in a PLY file or a VTK file, legacy or XML. Legacy files store the type `vtkIdType` in 4 bytes.
    pub fn named(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let (kind, size) = match name.trim_start_matches("vtktype") {
            "char" | "signed_char" | "int8" => (Kind::Signed, 1),
            "uchar" | "unsigned_char" | "uint8" => (Kind::Unsigned, 1),
            "short" | "int16" => (Kind::Signed, 2),
            "ushort" | "unsigned_short" | "uint16" => (Kind::Unsigned, 2),
            "int" | "vtkidtype" | "int32" => (Kind::Signed, 4),
            "uint" | "unsigned_int" | "uint32" => (Kind::Unsigned, 4),
            "long" | "long_long" | "int64" => (Kind::Signed, 8),
            "unsigned_long" | "unsigned_long_long" | "uint64" => (Kind::Unsigned, 8),
            "float" | "float32" => (Kind::Float, 4),
            "double" | "float64" => (Kind::Float, 8),
            _ => return None,
        };
        Some(Self::new(kind, size))
    }

    /// Returns the bits of a number, and the number if it is a signed integer.
    fn bits(self, bytes: &[u8], order: ByteOrder) -> (u64, i64) {
        let mut little = [0; 8];
        for (i, byte) in bytes.iter().take(self.size).enumerate() {
            let place = match order {
                ByteOrder::Little => i,
                ByteOrder::Big => self.size - 1 - i,
            };
            little[place] = *byte;
        }
        let bits = u64::from_le_bytes(little);
        let shift = 64 - 8 * self.size;
        (bits, (bits << shift).cast_signed() >> shift)
    }

    /// Converts the bytes of a number. Missing bytes are zero.
    pub fn real(self, bytes: &[u8], order: ByteOrder) -> f64 {
        let (bits, signed) = self.bits(bytes, order);
        match self.kind {
            Kind::Signed => signed as f64,
            Kind::Unsigned => bits as f64,
            Kind::Float if self.size == 8 => f64::from_bits(bits),
            Kind::Float => f32::from_bits(u32::try_from(bits).unwrap_or_default()).into(),
        }
    }

    /// Converts the bytes of an integer. Missing bytes are zero. Returns `None` if the integer is too large, or if the type is a float.
    pub fn integer(self, bytes: &[u8], order: ByteOrder) -> Option<i64> {
        let (bits, signed) = self.bits(bytes, order);
        match self.kind {
            Kind::Signed => Some(signed),
            Kind::Unsigned => bits.try_into().ok(),
            Kind::Float => None,
        }
    }
}
