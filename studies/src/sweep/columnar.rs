//! Tables as Parquet files, which DuckDB, pandas, Polars, R and others read.

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;
use std::sync::Arc;

/// A column of a table. Cells may be empty.
pub(super) struct Column {
    pub(super) name: String,
    pub(super) cells: Cells,
}

/// The cells of a column, from the first row on.
pub(super) enum Cells {
    Whole(Vec<Option<i64>>),
    Number(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
}

impl Cells {
    /// Texts as numbers, where all of them are.
    pub(super) fn of_texts(texts: Vec<Option<String>>) -> Cells {
        fn all<T: std::str::FromStr>(texts: &[Option<String>]) -> Option<Vec<Option<T>>> {
            let parse = |text: &Option<String>| match text {
                Some(text) => text.parse().ok().map(Some),
                None => Some(None),
            };
            texts.iter().map(parse).collect()
        }
        if let Some(whole) = all(&texts) {
            return Cells::Whole(whole);
        }
        match all::<f64>(&texts) {
            Some(numbers) if numbers.iter().flatten().all(|n| n.is_finite()) => {
                Cells::Number(numbers)
            }
            _ => Cells::Text(texts),
        }
    }
}

/// The file of a table.
///
/// # Errors
///
/// Two columns have one name, or columns differ in their lengths.
pub(super) fn file(columns: &[Column]) -> Result<Vec<u8>, ParquetError> {
    let schema = Type::group_type_builder("rows").with_fields(
        columns
            .iter()
            .map(|column| field(column).map(Arc::new))
            .collect::<Result<_, _>>()?,
    );
    let properties = WriterProperties::builder().set_created_by("srp".to_owned());
    let mut writer = SerializedFileWriter::new(
        Vec::new(),
        Arc::new(schema.build()?),
        Arc::new(properties.build()),
    )?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        let into = group.next_column()?.expect("the schema has every column");
        match &column.cells {
            Cells::Whole(cells) => fill::<Int64Type>(into, cells.iter().copied())?,
            Cells::Number(cells) => fill::<DoubleType>(into, cells.iter().copied())?,
            Cells::Text(cells) => {
                let bytes = cells
                    .iter()
                    .map(|cell| cell.as_deref().map(ByteArray::from));
                fill::<ByteArrayType>(into, bytes)?;
            }
        }
    }
    group.close()?;
    writer.into_inner()
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical) = match column.cells {
        Cells::Whole(_) => (Physical::INT64, None),
        Cells::Number(_) => (Physical::DOUBLE, None),
        Cells::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
}

/// Writes the cells of a column: those that are there, and which these are.
fn fill<T: DataType>(
    mut column: SerializedColumnWriter<'_>,
    cells: impl Iterator<Item = Option<T::T>> + Clone,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = cells
        .clone()
        .map(|cell| i16::from(cell.is_some()))
        .collect();
    let values: Vec<T::T> = cells.flatten().collect();
    column
        .typed::<T>()
        .write_batch(&values, Some(&levels), None)?;
    column.close()
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::SerializedFileReader;
    use parquet::record::Field;
    use std::io::Write;

    #[test]
    fn cells_are_read_as_they_were_written() {
        let texts = |texts: [&str; 3]| {
            let cell = |text: &str| (!text.is_empty()).then(|| text.to_owned());
            Cells::of_texts(texts.map(cell).into())
        };
        let column = |name: &str, cells| Column {
            name: name.to_owned(),
            cells,
        };
        let bytes = super::file(&[
            column("array.rows", texts(["4", "", "-6"])),
            column("latency", texts(["0.5", "3", "16"])),
            column("bits", texts(["8", "exact", ""])),
            column("size", texts(["16K", "é", "inf"])),
            column("cycles", Cells::Number(vec![None, Some(1.5), Some(2e9)])),
        ]);
        let mut file = tempfile::tempfile().expect("a private file");
        file.write_all(&bytes.expect("a table"))
            .expect("it can be written");
        let reader = SerializedFileReader::new(file).expect("a Parquet file");
        let rows = reader.into_iter();
        let rows: Vec<Vec<(String, Field)>> =
            rows.map(|row| row.expect("a row").into_columns()).collect();
        let text = |text: &str| Field::Str(text.to_owned());
        let (none, double, long) = (Field::Null, Field::Double, Field::Long);
        let expected = [
            ["array.rows", "latency", "bits", "size", "cycles"].map(text),
            [long(4), double(0.5), text("8"), text("16K"), none.clone()],
            [
                none.clone(),
                double(3.0),
                text("exact"),
                text("é"),
                double(1.5),
            ],
            [long(-6), double(16.0), none, text("inf"), double(2e9)],
        ];
        assert_eq!(rows.len(), 3);
        for (row, expected_row) in rows.iter().zip(&expected[1..]) {
            let names: Vec<Field> = row.iter().map(|(name, _)| text(name)).collect();
            assert_eq!(names, expected[0]);
            let fields: Vec<Field> = row.iter().map(|(_, field)| field.clone()).collect();
            assert_eq!(fields, expected_row);
        }
    }
}
