//! Reads back what [`write_vtp`](super::write_vtp) has written.

use crate::error::InputError;
use crate::math::Vec3;
use std::collections::BTreeMap;
use std::path::Path;

/// One rod of a `.vtp` file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VtkData {
    /// Index among the rods that were written; those without points are left out of the file.
    pub rod: usize,
    /// Points \[L\].
    pub points: Vec<Vec3>,
    /// Scalars by name, one value a point.
    pub scalars: BTreeMap<String, Vec<f64>>,
    /// Vectors by name, one a point.
    pub vectors: BTreeMap<String, Vec<Vec3>>,
}

/// The rods of a `.vtp` file. Only the subset of the format that [`write_vtp`](super::write_vtp) writes is read.
///
/// # Errors
/// [`InputError::File`] if the file cannot be read, [`InputError::Parse`] if this crate has not written it, or it is
/// cut short.
pub fn read_vtp(path: &Path) -> Result<Vec<VtkData>, InputError> {
    let refuse = |e: std::io::Error| InputError::File { path: path.to_owned(), reason: e.to_string() };
    let bytes = std::fs::read(path).map_err(refuse)?;
    parse(&bytes).ok_or_else(|| {
        let reason = "not a whole .vtp file as supercoil writes them".to_owned();
        InputError::Parse { file: path.display().to_string(), reason }
    })
}

/// An array of the appended block: section, name, components, bytes.
struct AppendedArray<'a> {
    section: &'a str,
    name: String,
    components: usize,
    bytes: &'a [u8],
}

impl AppendedArray<'_> {
    fn numbers<T>(&self, number: impl Fn([u8; 8]) -> T) -> Vec<T> {
        self.bytes.chunks_exact(8).filter_map(|b| b.try_into().ok()).map(number).collect()
    }

    fn floats(&self) -> Vec<f64> {
        self.numbers(f64::from_le_bytes)
    }

    fn integers(&self) -> Vec<i64> {
        self.numbers(i64::from_le_bytes)
    }

    fn vectors(&self) -> Vec<Vec3> {
        self.floats().chunks_exact(3).map(|v| Vec3::new(v[0], v[1], v[2])).collect()
    }
}

fn parse(file: &[u8]) -> Option<Vec<VtkData>> {
    let arrays = arrays(file)?;
    let find = |section: &str, name: &str| arrays.iter().find(|a| a.section == section && a.name == name);
    let points = find("Points", "Points")?.vectors();
    let (indices, connectivity) = (find("CellData", "rod")?.integers(), find("Lines", "connectivity")?.integers());
    let offsets = find("Lines", "offsets")?.integers();
    let (mut rods, mut from) = (Vec::new(), 0);
    for (index, end) in indices.into_iter().zip(offsets) {
        let line = connectivity.get(from..usize::try_from(end).ok()?)?;
        from = end as usize;
        let (first, last) = (*line.iter().min()?, *line.iter().max()?);
        let range = usize::try_from(first).ok()?..usize::try_from(last).ok()? + 1;
        let mut rod = VtkData { rod: usize::try_from(index).ok()?, ..VtkData::default() };
        rod.points = points.get(range.clone())?.to_vec();
        for array in arrays.iter().filter(|array| array.section == "PointData") {
            let name = array.name.clone();
            if array.components == 3 {
                rod.vectors.insert(name, array.vectors().get(range.clone())?.to_vec());
            } else {
                rod.scalars.insert(name, array.floats().get(range.clone())?.to_vec());
            }
        }
        rods.push(rod);
    }
    Some(rods)
}

/// All arrays of a file.
fn arrays(file: &[u8]) -> Option<Vec<AppendedArray<'_>>> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(mark.len()).position(|w| w == mark)? + mark.len();
    let (head, block) = (std::str::from_utf8(&file[..start]).ok()?, &file[start..]);
    let (mut section, mut arrays) = ("", Vec::new());
    for line in head.lines() {
        let Some(tag) = line.strip_prefix("<DataArray ") else {
            section = line.trim_matches(['<', '>']);
            continue;
        };
        let offset: usize = attribute(tag, "offset")?.parse().ok()?;
        let count = u64::from_le_bytes(block.get(offset..offset.checked_add(8)?)?.try_into().ok()?);
        let bytes = block.get(offset + 8..)?.get(..usize::try_from(count).ok()?)?;
        let components = attribute(tag, "NumberOfComponents").map_or(Some(1), |n| n.parse().ok())?;
        arrays.push(AppendedArray { section, name: unescaped(attribute(tag, "Name")?), components, bytes });
    }
    Some(arrays)
}

/// Value of an attribute in a tag.
fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let (_, rest) = tag.split_once(&format!("{name}=\""))?;
    rest.split_once('"').map(|(value, _)| value)
}

/// Text with the escapes of XML replaced.
fn unescaped(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::super::{VtkRod, VtkStep, polydata};
    use super::*;

    #[test]
    fn rods_come_back_as_they_were_written() {
        let ring: Vec<Vec3> = (0..5).map(|i| Vec3::new((i as f64).cos(), (i as f64).sin(), 0.1)).collect();
        let line: Vec<Vec3> = (0..3).map(|i| Vec3::new(i as f64, 0.0, 1e-300)).collect();
        let values = vec![0.1, 0.2, 0.3];
        let rods = [
            VtkRod { points: &ring, closed: true, scalars: vec![], vectors: vec![("d<1", ring.clone())] },
            VtkRod::default(),
            VtkRod { points: &line, closed: false, scalars: vec![("twist", values.clone())], vectors: vec![] },
        ];
        let file = polydata(
            &rods,
            &VtkStep { numbers: vec![("link", 7.0)], units: vec![("link", "turns")] },
            ("rod", &|rod| rod as i64),
        );
        let read = parse(&file).unwrap();
        assert_eq!(read.iter().map(|r| r.rod).collect::<Vec<_>>(), [0, 2]);
        assert!(read[0].points == ring && read[1].points == line);
        assert!(read[0].vectors["d<1"] == ring && read[1].vectors["d<1"][2].x.is_nan());
        assert!(read[1].scalars["twist"] == values && read[0].scalars["twist"].len() == 5);
        // cut off anywhere in its arrays it is refused
        let block = file.len() - b"\n</AppendedData>\n</VTKFile>\n".len();
        for cut in [0, 100, block - 1] {
            assert!(parse(&file[..cut]).is_none(), "{cut}");
        }
    }
}
