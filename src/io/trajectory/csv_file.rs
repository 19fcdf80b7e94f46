use super::{COLUMNS, Row};
use std::{io, path::Path};

/// Writes the rows as CSV.
pub(super) fn write(path: &Path, rows: &mut dyn Iterator<Item = Row>) -> io::Result<()> {
    write_records(path, rows).map_err(system_error)
}

fn write_records(path: &Path, rows: &mut dyn Iterator<Item = Row>) -> Result<(), csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_path(path)?;
    writer.write_record(COLUMNS)?;
    for row in rows {
        writer.serialize((row.time, row.body, row.numbers))?;
    }
    Ok(writer.flush()?)
}

/// What the system says; csv's own conversion would hide it in an error of another kind.
fn system_error(error: csv::Error) -> io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}
