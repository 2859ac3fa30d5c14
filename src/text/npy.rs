//! Arrays of NumPy's format `.npy` (versions 1 to 3): numbers of 4 or 8 bytes in the order of C.

/// How a file begins.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// An array of numbers, the last index fastest.
#[derive(Debug, PartialEq)]
pub(crate) struct NpyArray {
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

impl NpyArray {
    /// Reads an array.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, String> {
        let short = || "ends within its header".to_owned();
        let rest = bytes.strip_prefix(MAGIC).ok_or_else(|| "is no NumPy array".to_owned())?;
        let (&[version, _, a, b], rest) = rest.split_first_chunk::<4>().ok_or_else(short)?;
        let (length, rest) = if version == 1 {
            (usize::from(u16::from_le_bytes([a, b])), rest)
        } else {
            let (&[c, d], rest) = rest.split_first_chunk::<2>().ok_or_else(short)?;
            (u32::from_le_bytes([a, b, c, d]) as usize, rest)
        };
        let (header, data) = rest.split_at_checked(length).ok_or_else(short)?;
        let header = String::from_utf8_lossy(header).replace(' ', "");
        let shape = shape(&header)?;
        if !header.contains("'fortran_order':False") {
            return Err("is in the order of Fortran: save numpy.ascontiguousarray of it".to_owned());
        }
        let values: Vec<f64> = match field(&header, "'descr':'") {
            Some("<f8") => data.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap_or_default())).collect(),
            Some("<f4") => {
                data.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap_or_default()))).collect()
            }
            other => return Err(format!("holds {}, not <f8 or <f4", other.unwrap_or("?"))),
        };
        let count = shape.iter().try_fold(1usize, |product, n| product.checked_mul(*n));
        if count != Some(values.len()) {
            return Err(format!("has shape {shape:?}, but {} numbers", values.len()));
        }
        if let Some(k) = values.iter().position(|x| !x.is_finite()) {
            return Err(format!("number {k} is {}: finite ones expected", values[k]));
        }
        Ok(Self { shape, values })
    }
}

/// Text between a key and the next quote.
fn field<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    header.split_once(key).and_then(|(_, rest)| rest.split('\'').next())
}

fn shape(header: &str) -> Result<Vec<usize>, String> {
    let inside = header.split_once("'shape':(").and_then(|(_, rest)| rest.split(')').next());
    let refuse = || "has no shape in its header".to_owned();
    let cells = inside.ok_or_else(refuse)?.split(',').filter(|cell| !cell.is_empty());
    cells.map(|cell| cell.parse().map_err(|_| refuse())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = [MAGIC, &[1, 0]].concat();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(data);
        bytes
    }

    #[test]
    fn arrays_are_read_and_others_refused() {
        let data: Vec<u8> = [1.5f64, -2.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let head = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1), }\n";
        assert_eq!(
            NpyArray::parse(&file(head, &data)).unwrap(),
            NpyArray { shape: vec![2, 1], values: vec![1.5, -2.0] }
        );
        let single: Vec<u8> = [1.5f32, -2.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(NpyArray::parse(&file(&head.replace("f8", "f4"), &single)).unwrap().values, [1.5, -2.0]);
        for (from, to, reason) in [
            ("f8", "i8", "holds <i8, not <f8 or <f4"),
            ("False", "True", "is in the order of Fortran"),
            ("(2, 1)", "(3, 1)", "has shape [3, 1], but 2 numbers"),
            ("shape", "form", "has no shape"),
        ] {
            let refused = NpyArray::parse(&file(&head.replace(from, to), &data)).unwrap_err();
            assert!(refused.starts_with(reason), "{refused}");
        }
        assert_eq!(NpyArray::parse(b"text").unwrap_err(), "is no NumPy array");
        assert_eq!(NpyArray::parse(&file(head, &data)[..30]).unwrap_err(), "ends within its header");
        let nan: Vec<u8> = [1.5f64, f64::NAN].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(NpyArray::parse(&file(head, &nan)).unwrap_err(), "number 1 is NaN: finite ones expected");
    }
}
