//! Masking of the fields of a whole data set in legacy VTK files (`FIELD FieldData`). VTK, ParaView and pyvista write these fields
//! before the points. `vtkio` cannot parse them, and they are not part of a mesh.

use std::borrow::Cow;
use std::ops::Range;

/// Replaces the fields of the data set by spaces and keeps the line numbers. Returns the file
/// unchanged if it has no fields of the data set, or has a field of unsupported type (strings).
pub(super) fn mask_fields(bytes: &[u8]) -> Cow<'_, [u8]> {
    let Some(fields) = fields(bytes) else {
        return Cow::Borrowed(bytes);
    };
    let mut masked = bytes.to_vec();
    for byte in &mut masked[fields] {
        if *byte != b'\n' {
            *byte = b' ';
        }
    }
    Cow::Owned(masked)
}

/// Byte range of the fields. They follow four lines, the last of which contains the type of the data set.
fn fields(bytes: &[u8]) -> Option<Range<usize>> {
    let mut rest = bytes;
    let [_, _, format, _] = [(); 4].map(|()| line(&mut rest));
    let is_binary = has_word(format?, "BINARY");
    rest = rest.trim_ascii_start();
    let start = bytes.len() - rest.len();
    if !has_word(rest, "FIELD") {
        return None;
    }
    let [_, _, count] = words(line(&mut rest)?)?;
    for _ in 0..count.parse::<usize>().ok()? {
        rest = after_metadata(after_array(rest, is_binary)?)?;
    }
    Some(start..bytes.len() - rest.len())
}

/// Text after an array. An array is a line with name, component count, tuple count and type, and the numbers.
fn after_array(rest: &[u8], is_binary: bool) -> Option<&[u8]> {
    let mut rest = rest.trim_ascii_start();
    let [_, components, tuples, kind] = words(line(&mut rest)?)?;
    let (components, tuples): (usize, usize) = (components.parse().ok()?, tuples.parse().ok()?);
    let (count, bits) = (components.checked_mul(tuples)?, bits(kind)?);
    if is_binary {
        return rest.get(count.checked_mul(bits)?.div_ceil(8)..);
    }
    for _ in 0..count {
        rest = rest.trim_ascii_start();
        let end = rest.iter().position(u8::is_ascii_whitespace);
        rest = &rest[end.filter(|&end| end > 0)?..];
    }
    Some(rest)
}

/// Text after the optional metadata of an array, which ends with an empty line.
fn after_metadata(rest: &[u8]) -> Option<&[u8]> {
    let mut rest = rest.trim_ascii_start();
    if has_word(rest, "METADATA") {
        while !line(&mut rest)?.trim_ascii().is_empty() {}
    }
    Some(rest.trim_ascii_start())
}

/// Removes the next line from `rest` and returns it without its line feed.
fn line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().position(|&byte| byte == b'\n')?;
    let line = &rest[..end];
    *rest = &rest[end + 1..];
    Some(line)
}

/// Words of a line, or `None` unless there are exactly `COUNT`.
fn words<const COUNT: usize>(line: &[u8]) -> Option<[&str; COUNT]> {
    let words: Vec<&str> = std::str::from_utf8(line).ok()?.split_whitespace().collect();
    words.try_into().ok()
}

/// Whether the first word of the text is `word`, ignoring case.
fn has_word(text: &[u8], word: &str) -> bool {
    let text = text.trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace);
    text[..end.unwrap_or(text.len())].eq_ignore_ascii_case(word.as_bytes())
}

/// Size of a number in a binary file (bits), or `None` for an unsupported type.
fn bits(kind: &str) -> Option<usize> {
    match kind.to_ascii_lowercase().as_str() {
        "bit" => Some(1),
        "char" | "unsigned_char" => Some(8),
        "short" | "unsigned_short" => Some(16),
        "int" | "unsigned_int" | "float" | "vtkidtype" => Some(32),
        "long" | "unsigned_long" | "double" | "vtktypeint64" | "vtktypeuint64" => Some(64),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::mask_fields;

    const HEAD: &str = "# vtk DataFile Version 5.1\na title\n";
    const MESH: &str = "POINTS 4 double\n0 0 0 ";

    #[test]
    fn fields_in_text_are_passed_over() {
        let fields = "FIELD FieldData 2\nTimeValue 1 1 double\n0.5 \nflags 2 2 bit\n1 0\n1 1\nMETADATA\nINFORMATION 0\n\n";
        let file = format!("{HEAD}ASCII\nDATASET UNSTRUCTURED_GRID\n{fields}{MESH}");
        let blank: String = fields.replace(|letter| letter != '\n', " ");
        let expected = file.replace(fields, &blank);
        assert_eq!(&*mask_fields(file.as_bytes()), expected.as_bytes());
    }

    #[test]
    fn binary_fields_are_passed_over_whatever_their_bytes() {
        let head = format!("{HEAD}BINARY\nDATASET UNSTRUCTURED_GRID\n");
        let [first, second] = [&[b'\n'; 16][..], b"\x80"];
        let file = [
            head.as_bytes(),
            b"FIELD FieldData 2\nTimeValue 2 1 double\n",
            first,
            b"\nflags 1 3 bit\n",
            second,
            b"\n",
            MESH.as_bytes(),
        ];
        let file = file.concat();
        let masked = mask_fields(&file);
        let (before, after) = (head.len(), file.len() - MESH.len());
        assert_eq!(
            (&masked[..before], &masked[after..]),
            (head.as_bytes(), MESH.as_bytes())
        );
        assert!(masked[before..after].trim_ascii().is_empty());
    }

    #[test]
    fn files_without_them_or_cut_short_stay_as_they_are() {
        let files = [
            format!("{HEAD}ASCII\nDATASET UNSTRUCTURED_GRID\n{MESH}"),
            format!(
                "{HEAD}ASCII\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nTimeValue 1 3 double\n0.5"
            ),
            format!(
                "{HEAD}ASCII\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nname 1 1 string\nab\n{MESH}"
            ),
            format!(
                "{HEAD}BINARY\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nTimeValue 99 18446744073709551615 double\n"
            ),
            HEAD.to_owned(),
            String::new(),
        ];
        for file in files {
            assert_eq!(&*mask_fields(file.as_bytes()), file.as_bytes(), "{file}");
        }
    }
}
