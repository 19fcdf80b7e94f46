//! Check of the well-formedness of an XML file.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// Reason why a file is not well-formed XML.
#[derive(Debug, thiserror::Error)]
pub(super) enum XmlError {
    #[error(transparent)]
    Read(#[from] quick_xml::Error),
    #[error("the element <{0}> has no valid XML name")]
    Name(String),
    #[error("{0} elements are not closed")]
    Open(usize),
}

/// Checks that all elements have valid names and are closed in order.
///
/// vtkio deserializes elements with serde, which represents attributes by names that are invalid in
/// XML, such as `@type`. An element with an invalid name, or with a wrong closing tag, fails an
/// assertion of quick-xml in builds with debug assertions.
pub(super) fn check(bytes: &[u8]) -> Result<(), XmlError> {
    let mut reader = Reader::from_reader(bytes);
    let mut open = 0_usize;
    loop {
        match reader.read_event()? {
            Event::Start(start) => {
                check_name(&start)?;
                open += 1;
            }
            Event::Empty(start) => check_name(&start)?,
            // The reader has checked that the tag closes the innermost open element.
            Event::End(_) => open = open.saturating_sub(1),
            Event::Eof if open > 0 => return Err(XmlError::Open(open)),
            Event::Eof => return Ok(()),
            _ => {}
        }
    }
}

/// Checks the first character of a name. The other characters do not matter to vtkio.
fn check_name(start: &BytesStart) -> Result<(), XmlError> {
    let name = start.name();
    match name.as_ref() {
        [b'A'..=b'Z' | b'a'..=b'z' | b'_' | b':' | 0x80.., ..] => Ok(()),
        invalid => Err(XmlError::Name(String::from_utf8_lossy(invalid).into())),
    }
}
