//! Tables as Parquet: the only file that names the library for it. Columns are optional doubles, 64-bit integers or
//! UTF-8.

use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::column::reader::ColumnReader;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::columns::{Column, ColumnValues, SweepTable};

/// A table as the bytes of a Parquet file. Equal tables give equal bytes.
///
/// # Errors
/// The library's message.
pub fn to_bytes(table: &SweepTable) -> Result<Vec<u8>, String> {
    write(table).map_err(|e| e.to_string())
}

/// The columns of a Parquet file that are `wanted`; only kinds that [`to_bytes`] writes are read.
///
/// # Errors
/// The library's message for bytes that are not such a file.
pub fn from_bytes(bytes: Vec<u8>, wanted: &dyn Fn(&str) -> bool) -> Result<SweepTable, String> {
    read(bytes, wanted).map_err(|e| e.to_string())
}

fn write(table: &SweepTable) -> Result<Vec<u8>, ParquetError> {
    let fields = table.columns().iter().map(field).collect::<Result<_, _>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let program = concat!("supercoil ", env!("CARGO_PKG_VERSION")).to_owned();
    let properties = Arc::new(WriterProperties::builder().set_created_by(program).build());
    let mut bytes = Vec::new();
    let mut file = SerializedFileWriter::new(&mut bytes, schema, properties)?;
    let mut group = file.next_row_group()?;
    for column in table.columns() {
        match &column.values {
            ColumnValues::Number(values) => write_column::<DoubleType, _>(&mut group, values, |&x| x)?,
            ColumnValues::Whole(values) => write_column::<Int64Type, _>(&mut group, values, |&x| x)?,
            ColumnValues::Text(values) => {
                write_column::<ByteArrayType, _>(&mut group, values, |x| ByteArray::from(x.as_str()))?;
            }
        }
    }
    group.close()?;
    file.close()?;
    Ok(bytes)
}

fn field(column: &Column) -> Result<TypePtr, ParquetError> {
    let (physical, converted) = match column.values {
        ColumnValues::Number(_) => (Physical::DOUBLE, ConvertedType::NONE),
        ColumnValues::Whole(_) => (Physical::INT64, ConvertedType::NONE),
        ColumnValues::Text(_) => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
    };
    let builder = Type::primitive_type_builder(&column.name, physical);
    builder.with_repetition(Repetition::OPTIONAL).with_converted_type(converted).build().map(Arc::new)
}

fn write_column<T: DataType, V>(
    group: &mut SerializedRowGroupWriter<&mut Vec<u8>>,
    values: &[Option<V>],
    value: impl Fn(&V) -> T::T,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = values.iter().flatten().map(value).collect();
    let missing = || ParquetError::General("a column more than the schema has".to_owned());
    let mut writer = group.next_column()?.ok_or_else(missing)?;
    writer.typed::<T>().write_batch(&present, Some(&levels), None)?;
    writer.close()
}

fn read(bytes: Vec<u8>, wanted: &dyn Fn(&str) -> bool) -> Result<SweepTable, ParquetError> {
    let file = SerializedFileReader::new(Bytes::from(bytes))?;
    let schema = file.metadata().file_metadata().schema_descr_ptr();
    let mut columns = Vec::new();
    for (index, head) in schema.columns().iter().enumerate().filter(|(_, head)| wanted(head.name())) {
        let unread = || ParquetError::General(format!("column \"{}\" is of a kind that is not read", head.name()));
        let mut values = match head.physical_type() {
            Physical::DOUBLE => ColumnValues::Number(Vec::new()),
            Physical::INT64 => ColumnValues::Whole(Vec::new()),
            Physical::BYTE_ARRAY => ColumnValues::Text(Vec::new()),
            _ => return Err(unread()),
        };
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group)?;
            let rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
            read_column(&*group, index, rows, &mut values)?;
        }
        columns.push(Column { name: head.name().to_owned(), values });
    }
    Ok(SweepTable::new(columns))
}

fn read_column(
    group: &dyn RowGroupReader,
    index: usize,
    rows: usize,
    into: &mut ColumnValues,
) -> Result<(), ParquetError> {
    /// Inserts `None` where the definition levels have no value.
    fn spread<V, X>(
        (levels, present): (Vec<i16>, Vec<X>),
        value: impl Fn(X) -> Result<V, ParquetError>,
        into: &mut Vec<Option<V>>,
    ) -> Result<(), ParquetError> {
        let mut present = present.into_iter();
        for level in levels {
            into.push(if level == 0 { None } else { present.next().map(&value).transpose()? });
        }
        Ok(())
    }
    let (mut levels, mut numbers, mut wholes, mut words) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    match (group.get_column_reader(index)?, into) {
        (ColumnReader::DoubleColumnReader(mut reader), ColumnValues::Number(into)) => {
            reader.read_records(rows, Some(&mut levels), None, &mut numbers)?;
            spread((levels, numbers), Ok, into)
        }
        (ColumnReader::Int64ColumnReader(mut reader), ColumnValues::Whole(into)) => {
            reader.read_records(rows, Some(&mut levels), None, &mut wholes)?;
            spread((levels, wholes), Ok, into)
        }
        (ColumnReader::ByteArrayColumnReader(mut reader), ColumnValues::Text(into)) => {
            reader.read_records(rows, Some(&mut levels), None, &mut words)?;
            spread((levels, words), |word: ByteArray| word.as_utf8().map(str::to_owned), into)
        }
        _ => Err(ParquetError::General("a column is of another kind than its head says".to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::csv::Cell;
    use super::*;

    fn table(rows: usize) -> SweepTable {
        let mut table = SweepTable::default();
        table.push([("case", Cell::from("é")), ("rods.a.b", Cell::Number(-0.0)), ("n", Cell::Count(7))]);
        for row in 0..rows {
            table.push([("case", Cell::from(format!("case {row}"))), ("rods.a.b", Cell::Number(f64::NAN))]);
            table.push([("n", Cell::Count(row)), ("rods.a.b", Cell::Number(5e-324 * row as f64))]);
        }
        table
    }

    #[test]
    fn tables_come_back_to_the_bit() {
        for rows in [0, 1, 3000] {
            let table = table(rows);
            let bytes = to_bytes(&table).unwrap();
            assert_eq!(bytes, to_bytes(&table).unwrap());
            let read = from_bytes(bytes.clone(), &|_| true).unwrap();
            assert_eq!(read.num_rows(), table.num_rows());
            let all = 0..table.num_rows();
            assert_eq!(table.difference(all.clone(), &read, all, &[]), None);
            let some = from_bytes(bytes, &|name| name == "n").unwrap();
            assert_eq!(some.columns().len(), 1);
        }
        assert_eq!(from_bytes(to_bytes(&SweepTable::default()).unwrap(), &|_| true).unwrap(), SweepTable::default());
    }

    #[test]
    fn files_cut_short_anywhere_are_refused() {
        let bytes = to_bytes(&table(3)).unwrap();
        for length in 0..bytes.len() {
            assert!(from_bytes(bytes[..length].to_vec(), &|_| true).is_err(), "{length} of {}", bytes.len());
        }
    }
}
