use super::{COLUMNS, Row};
use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::{fs::File, io, sync::Arc};

/// Number of rows in a row group: 15 MB of numbers.
const ROWS_PER_GROUP: usize = 1 << 17;

/// Index of the column with the names of the bodies. All other columns are numbers.
const NAME_COLUMN: usize = 1;

/// Writes the rows as Apache Parquet.
pub(super) fn write(file: &mut File, rows: &mut dyn Iterator<Item = Row>) -> io::Result<()> {
    write_groups(file, rows).map_err(system_error)
}

fn write_groups(file: &mut File, rows: &mut dyn Iterator<Item = Row>) -> Result<(), ParquetError> {
    let properties = Arc::new(WriterProperties::new());
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema()?), properties)?;
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

fn schema() -> Result<Type, ParquetError> {
    let columns = COLUMNS.iter().enumerate().map(|(column, name)| {
        let is_name = column == NAME_COLUMN;
        let (physical, logical) = if is_name {
            (PhysicalType::BYTE_ARRAY, Some(LogicalType::String))
        } else {
            (PhysicalType::DOUBLE, None)
        };
        let column = Type::primitive_type_builder(name, physical)
            .with_logical_type(logical)
            .with_repetition(Repetition::REQUIRED)
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
        if column == NAME_COLUMN {
            let names: Vec<ByteArray> = rows.iter().map(|row| row.body.into()).collect();
            let typed = column_writer.typed::<ByteArrayType>();
            typed.write_batch(&names, None, None)?;
        } else {
            let numbers: Vec<f64> = rows.iter().map(|row| number(row, column)).collect();
            let typed = column_writer.typed::<DoubleType>();
            typed.write_batch(&numbers, None, None)?;
        }
        column_writer.close()?;
        column += 1;
    }
    Ok(())
}

/// Number of a row in a numeric column.
fn number(row: &Row, column: usize) -> f64 {
    if column < NAME_COLUMN {
        row.time
    } else {
        row.numbers[column - NAME_COLUMN - 1]
    }
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
