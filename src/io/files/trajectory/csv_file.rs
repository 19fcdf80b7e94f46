use super::{COLUMNS, Row};
use std::fs::File;
use std::io::{self, Write};

/// Writes the header line and the rows as CSV.
pub(super) fn write(
    file: &mut File,
    columns: &[&str],
    rows: &mut dyn Iterator<Item = Row>,
) -> io::Result<()> {
    file.write_all(&header(columns)?)?;
    write_rows(file, columns, rows).map_err(system_error)
}

/// Header line, with the names of the columns.
pub(super) fn header(columns: &[&str]) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(columns).map_err(system_error)?;
    writer.into_inner().map_err(csv::IntoInnerError::into_error)
}

/// Lines of the rows.
pub(super) fn lines<'a>(
    columns: &[&str],
    rows: impl Iterator<Item = Row<'a>>,
) -> io::Result<Vec<u8>> {
    let mut lines = Vec::new();
    write_rows(&mut lines, columns, rows).map_err(system_error)?;
    Ok(lines)
}

fn write_rows<'a>(
    target: impl Write,
    columns: &[&str],
    rows: impl Iterator<Item = Row<'a>>,
) -> Result<(), csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(target);
    let with_joints = columns.len() > COLUMNS.len();
    for row in rows {
        let numbers = (row.time, row.body, row.numbers);
        let joint = row.joint.as_ref();
        let joint = joint.map(|joint| (joint.name, joint.position, joint.velocity));
        match joint {
            Some(joint) => writer.serialize((numbers, joint))?,
            None if with_joints => writer.serialize((numbers, ["", "", ""]))?,
            None => writer.serialize(numbers)?,
        }
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
