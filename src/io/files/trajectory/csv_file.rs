use super::{COLUMNS, Row};
use std::fs::File;
use std::io::{self, Write};
use std::iter::empty;

/// Writes the header line and the rows as CSV.
pub(super) fn write(file: &mut File, rows: &mut dyn Iterator<Item = Row>) -> io::Result<()> {
    write_records(file, true, rows).map_err(system_error)
}

/// Header line, with the names of the columns.
pub(super) fn header() -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    write_records(&mut line, true, empty()).map_err(system_error)?;
    Ok(line)
}

/// Lines of the rows.
pub(super) fn lines<'a>(rows: impl Iterator<Item = Row<'a>>) -> io::Result<Vec<u8>> {
    let mut lines = Vec::new();
    write_records(&mut lines, false, rows).map_err(system_error)?;
    Ok(lines)
}

fn write_records<'a>(
    target: impl Write,
    with_names: bool,
    rows: impl Iterator<Item = Row<'a>>,
) -> Result<(), csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(target);
    if with_names {
        writer.write_record(COLUMNS)?;
    }
    for row in rows {
        writer.serialize((row.time, row.body, row.numbers))?;
    }
    Ok(writer.flush()?)
}

/// Extracts the error of the operating system. The conversion of the crate csv would wrap it in an error of another kind.
fn system_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        kind => io::Error::other(format!("{kind:?}")),
    }
}
