use super::{COLUMNS, JointCells, Row};
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::{fs::File, io, sync::Arc};

/// Number of rows in a row group: 15 MB of numbers.
const ROWS_PER_GROUP: usize = 1 << 17;

/// Indices of the columns with the names of the bodies and of the joints. All other columns are numbers.
const BODY_COLUMN: usize = 1;
const JOINT_COLUMN: usize = COLUMNS.len();

/// Writes the rows as Apache Parquet.
pub(super) fn write(
    file: &mut File,
    columns: &[&str],
    rows: &mut dyn Iterator<Item = Row>,
) -> io::Result<()> {
    write_groups(file, columns, rows).map_err(system_error)
}

fn write_groups(
    file: &mut File,
    columns: &[&str],
    rows: &mut dyn Iterator<Item = Row>,
) -> Result<(), ParquetError> {
    let properties = Arc::new(WriterProperties::new());
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema(columns)?), properties)?;
    loop {
        let group: Vec<Row> = rows.take(ROWS_PER_GROUP).collect();
        if group.is_empty() {
            break;
        }
        let mut group_writer = writer.next_row_group()?;
        write_columns(&mut group_writer, &group)?;
        group_writer.close()?;
    }
    writer.close()?;
    Ok(())
}

fn schema(columns: &[&str]) -> Result<Type, ParquetError> {
    let columns = columns.iter().enumerate().map(|(column, name)| {
        let (physical, logical) = match column {
            BODY_COLUMN | JOINT_COLUMN => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
            _ => (PhysicalType::DOUBLE, None),
        };
        let repetition = if column < JOINT_COLUMN {
            Repetition::REQUIRED
        } else {
            Repetition::OPTIONAL
        };
        let column = Type::primitive_type_builder(name, physical)
            .with_logical_type(logical)
            .with_repetition(repetition)
            .build()?;
        Ok(Arc::new(column))
    });
    let columns = columns.collect::<Result<Vec<_>, ParquetError>>()?;
    Type::group_type_builder("trajectory")
        .with_fields(columns)
        .build()
}

/// Writes the times, the names and the numbers of the rows as columns.
fn write_columns(
    writer: &mut SerializedRowGroupWriter<&mut File>,
    rows: &[Row],
) -> Result<(), ParquetError> {
    let mut column = 0;
    while let Some(mut column_writer) = writer.next_column()? {
        // The definition level of a value is 1, and of a null 0. Values of required columns have none.
        let is_joint = rows.iter().map(|row| i16::from(row.joint.is_some()));
        let levels: Option<Vec<i16>> = (column >= JOINT_COLUMN).then(|| is_joint.collect());
        let levels = levels.as_deref();
        if let BODY_COLUMN | JOINT_COLUMN = column {
            let names = rows.iter().filter_map(|row| name(row, column));
            let names: Vec<ByteArray> = names.map(ByteArray::from).collect();
            let typed = column_writer.typed::<ByteArrayType>();
            typed.write_batch(&names, levels, None)?;
        } else {
            let numbers = rows.iter().filter_map(|row| number(row, column));
            let typed = column_writer.typed::<DoubleType>();
            typed.write_batch(&numbers.collect::<Vec<_>>(), levels, None)?;
        }
        column_writer.close()?;
        column += 1;
    }
    Ok(())
}

/// Name of a row in a column of names, or `None` for null.
fn name<'a>(row: &Row<'a>, column: usize) -> Option<&'a str> {
    if column == BODY_COLUMN {
        return Some(row.body);
    }
    row.joint.as_ref().map(|joint| joint.name)
}

/// Number of a row in a numeric column, or `None` for null.
fn number(row: &Row, column: usize) -> Option<f64> {
    if column < BODY_COLUMN {
        return Some(row.time);
    }
    if column < JOINT_COLUMN {
        return Some(row.numbers[column - BODY_COLUMN - 1]);
    }
    let JointCells {
        position, velocity, ..
    } = row.joint.as_ref()?;
    Some(if column == JOINT_COLUMN + 1 {
        *position
    } else {
        *velocity
    })
}

/// Extracts the error of the operating system, if it is the cause.
fn system_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(source) => match source.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(cause) => io::Error::other(cause),
        },
        error => io::Error::other(error),
    }
}
