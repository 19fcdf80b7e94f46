//! Whether a file is XML at all, before its parts are looked for.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

/// What is wrong with a file that is no XML.
#[derive(Debug, thiserror::Error)]
pub(super) enum XmlError {
    #[error(transparent)]
    Read(#[from] quick_xml::Error),
    #[error("the element <{0}> has no name of XML")]
    Name(String),
    #[error("{0} elements are not closed")]
    Open(usize),
}

/// Checks that all elements have names and are closed in order.
///
/// vtkio takes elements by serde, in which names that XML does not know, like `@type`, stand for attributes: these, and elements
/// that are closed by others, end in a failed assertion of quick-xml where that is built with debug assertions.
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
            // That one is open, and which, the reader has checked.
            Event::End(_) => open = open.saturating_sub(1),
            Event::Eof if open > 0 => return Err(XmlError::Open(open)),
            Event::Eof => return Ok(()),
            _ => {}
        }
    }
}

/// Checks the first character: of the others none matters to vtkio.
fn check_name(start: &BytesStart) -> Result<(), XmlError> {
    let name = start.name();
    match name.as_ref() {
        [b'A'..=b'Z' | b'a'..=b'z' | b'_' | b':' | 0x80.., ..] => Ok(()),
        other => Err(XmlError::Name(String::from_utf8_lossy(other).into())),
    }
}
