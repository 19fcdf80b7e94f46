//! Encodings of the arrays of VTK XML files: base64 or raw bytes, uncompressed or compressed with zlib.

use super::scalar::{ByteOrder, Scalar};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use std::borrow::Cow;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Encoded bytes, from the first byte of an array on.
#[derive(Clone, Copy)]
pub(super) struct Stream<'a> {
    pub bytes: &'a [u8],
    pub is_base64: bool,
}

/// Encoding of the arrays of a file.
pub(super) struct Encoding {
    pub order: ByteOrder,
    /// Type of the integers that precede the data of an array.
    pub header: Scalar,
    pub is_compressed: bool,
}

impl<'a> Stream<'a> {
    /// Decodes a number of bytes. Returns them and the rest of the stream.
    fn split(self, count: usize) -> Result<(Cow<'a, [u8]>, Self), String> {
        let length = if self.is_base64 {
            count.div_ceil(3).saturating_mul(4)
        } else {
            count
        };
        let (code, bytes) = self.bytes.split_at(length.min(self.bytes.len()));
        let mut decoded = Cow::from(code);
        if self.is_base64 {
            let bytes = BASE64.decode(code).map_err(|error| error.to_string())?;
            decoded = bytes.into();
        }
        if decoded.len() < count {
            return Err(format!(
                "{count} bytes were expected, but the data are shorter"
            ));
        }
        if decoded.len() > count {
            decoded.to_mut().truncate(count);
        }
        Ok((decoded, Self { bytes, ..self }))
    }
}

impl Encoding {
    /// Decodes the bytes of an array. The check is called with their number before they are decoded.
    pub fn decoded<'a>(
        &self,
        stream: Stream<'a>,
        check: impl FnOnce(usize) -> Result<(), String>,
    ) -> Result<Cow<'a, [u8]>, String> {
        if self.is_compressed {
            return self.inflated(stream, check).map(Cow::from);
        }
        let size = self.header.size;
        let (length, rest) = stream.split(size)?;
        let length = self.length(&length)?;
        check(length)?;
        let code = &stream.bytes[..stream.bytes.len() - rest.bytes.len()];
        // Most programs encode the length and the data together. Padding shows that they are encoded separately.
        if !stream.is_base64 || code.ends_with(b"=") {
            return Ok(rest.split(length)?.0);
        }
        let (mut both, _) = stream.split(size.saturating_add(length))?;
        both.to_mut().drain(..size);
        Ok(both)
    }

    /// Decompresses blocks. The number of blocks, the length of a block, the length of a shorter last block and the compressed lengths
    /// precede them.
    fn inflated(
        &self,
        stream: Stream,
        check: impl FnOnce(usize) -> Result<(), String>,
    ) -> Result<Vec<u8>, String> {
        let size = self.header.size;
        let count = self.length(&stream.split(size)?.0)?;
        if count == 0 {
            return Ok(Vec::new());
        }
        let (header, rest) = stream.split(count.saturating_add(3).saturating_mul(size))?;
        let lengths = header.chunks_exact(size).map(|bytes| self.length(bytes));
        let lengths = lengths.collect::<Result<Vec<_>, _>>()?;
        let (block, last, compressed) = (lengths[1], lengths[2], &lengths[3..]);
        let short = if last > 0 { last } else { block };
        check((count - 1).saturating_mul(block).saturating_add(short))?;
        let total = compressed
            .iter()
            .fold(0, |sum: usize, &length| sum.saturating_add(length));
        let (data, _) = rest.split(total)?;
        let (mut inflated, mut next) = (Vec::new(), 0);
        for (index, length) in compressed.iter().enumerate() {
            let expected = if index + 1 == count { short } else { block };
            let code = &data[next..next + length];
            let bytes = decompress_to_vec_zlib_with_limit(code, expected);
            let bytes = bytes.map_err(|error| error.to_string())?;
            if bytes.len() != expected {
                return Err(format!(
                    "a block has {} bytes, but needs {expected}",
                    bytes.len()
                ));
            }
            inflated.extend(bytes);
            next += length;
        }
        Ok(inflated)
    }

    /// Length that precedes data.
    fn length(&self, bytes: &[u8]) -> Result<usize, String> {
        let length = self.header.integer(bytes, self.order);
        let length = length.and_then(|length| length.try_into().ok());
        length.ok_or_else(|| "a length is not below 2⁶³".into())
    }
}
