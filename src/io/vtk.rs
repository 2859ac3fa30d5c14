//! Rods for ParaView: XML PolyData (`.vtp`, one polyline a rod) and `.pvd` collections over steps.
//!
//! The writer covers what rods need and nothing else: points, polylines, point scalars and vectors, the rod's index as
//! cell data, single numbers and the units of all of them as field data. Arrays are appended raw, little endian, with
//! 64-bit byte counts (VTK XML format, version 1.0), so every f64 arrives bit for bit.

mod read;

pub use read::{VtkData, read_vtp};

use crate::error::InputError;
use crate::math::Vec3;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// One rod to be written: a polyline with arrays at its points.
#[derive(Debug, Clone, Default)]
pub struct VtkRod<'a> {
    /// Centreline points \[L\], in order.
    pub points: &'a [Vec3],
    /// Whether the polyline returns to its first point (which is not repeated in `points`).
    pub closed: bool,
    /// Named scalars, one value per point. A name that only some rods have is NaN on the others.
    pub scalars: Vec<(&'a str, Vec<f64>)>,
    /// Named vectors, one a point. A name that only some rods have is NaN on the others.
    pub vectors: Vec<(&'a str, Vec<Vec3>)>,
}

/// Field data of a `.vtp` file: numbers of the whole step.
#[derive(Debug, Clone, Default)]
pub struct VtkStep<'a> {
    /// Named numbers (load, link …). `TimeValue` is where ParaView looks for the time.
    pub numbers: Vec<(&'a str, f64)>,
    /// Units of arrays by name, written as lines `name: unit` of the text array `units`; none without any.
    pub units: Vec<(&'a str, &'a str)>,
}

/// Writes `rods` as one `.vtp` file, replacing what is there.
///
/// # Errors
/// [`InputError::Inconsistent`] if an array's length differs from its rod's points; [`InputError::Name`] if two arrays
/// of the file have one name; [`InputError::Write`] if the file cannot be written.
pub fn write_vtp(path: &Path, rods: &[VtkRod], step: &VtkStep) -> Result<(), InputError> {
    for (index, rod) in rods.iter().enumerate() {
        let mut lengths =
            rod.scalars.iter().map(|(n, v)| (n, v.len())).chain(rod.vectors.iter().map(|(n, v)| (n, v.len())));
        if let Some((name, found)) = lengths.find(|(_, found)| *found != rod.points.len()) {
            let reason = format!("{found} values for {} points", rod.points.len());
            return Err(InputError::Inconsistent { field: format!("rods[{index}].{name}"), reason });
        }
    }
    let of_points = distinct(rods.iter().flat_map(|r| r.scalars.iter().map(|(n, _)| *n)))
        .into_iter()
        .chain(distinct(rods.iter().flat_map(|r| r.vectors.iter().map(|(n, _)| *n))));
    let mut seen = vec![ROD, POINTS, UNITS];
    for name in of_points.chain(step.numbers.iter().map(|(name, _)| *name)) {
        if seen.contains(&name) {
            let allowed = "a name that no other array of the file has".to_owned();
            return Err(InputError::Name { field: path.display().to_string(), name: name.to_owned(), allowed });
        }
        seen.push(name);
    }
    write_file(path, &polydata(rods, step, (ROD, &|rod| rod as i64)))
}

/// Writes straight lines as one `.vtp` file, replacing what is there: each line with the index of the obstacle that it
/// shows as cell data.
///
/// # Errors
/// [`InputError::Write`] if the file cannot be written.
pub fn write_obstacle_lines(path: &Path, lines: &[(usize, [Vec3; 2])], step: &VtkStep) -> Result<(), InputError> {
    let rods: Vec<VtkRod> = lines.iter().map(|(_, ends)| VtkRod { points: ends, ..VtkRod::default() }).collect();
    write_file(path, &polydata(&rods, step, ("obstacle", &|line| lines[line].0 as i64)))
}

/// Names of the arrays that every file has.
const ROD: &str = "rod";
const POINTS: &str = "Points";
const UNITS: &str = "units";

/// The bytes of a `.vtp` file; cell data are named integers, by the index of the polyline.
fn polydata(rods: &[VtkRod], step: &VtkStep, (cells, of_cell): (&str, &dyn Fn(usize) -> i64)) -> Vec<u8> {
    let num_points: usize = rods.iter().map(|r| r.points.len()).sum();
    let lines = rods.iter().filter(|r| !r.points.is_empty()).count();
    let (mut xml, mut data) = (String::new(), Appended::default());
    xml.push_str(
        "<?xml version=\"1.0\"?>\n\
        <VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n\
        <FieldData>\n",
    );
    for (name, value) in &step.numbers {
        data.floats(&mut xml, name, " NumberOfTuples=\"1\"", [*value].into_iter());
    }
    if !step.units.is_empty() {
        let lines: Vec<String> = step.units.iter().map(|(name, unit)| format!("{name}: {unit}")).collect();
        data.texts(&mut xml, UNITS, &lines);
    }
    // Writing to a String cannot fail.
    let _ = write!(
        xml,
        "</FieldData>\n<Piece NumberOfPoints=\"{num_points}\" NumberOfVerts=\"0\" NumberOfLines=\"{lines}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n<PointData>\n"
    );
    point_data(rods, &mut xml, &mut data);
    xml.push_str("</PointData>\n<CellData>\n");
    let filled = || rods.iter().enumerate().filter(|(_, r)| !r.points.is_empty());
    data.integers(&mut xml, cells, filled().map(|(i, _)| of_cell(i)));
    xml.push_str("</CellData>\n<Points>\n");
    data.floats(&mut xml, POINTS, THREE, rods.iter().flat_map(|r| r.points).flat_map(|p| [p.x, p.y, p.z]));
    xml.push_str("</Points>\n<Lines>\n");
    let (mut connectivity, mut offsets, mut first) = (Vec::new(), Vec::new(), 0);
    for (_, rod) in filled() {
        let after = first + rod.points.len() as i64;
        connectivity.extend(first..after);
        connectivity.extend(rod.closed.then_some(first));
        offsets.push(connectivity.len() as i64);
        first = after;
    }
    data.integers(&mut xml, "connectivity", connectivity.into_iter());
    data.integers(&mut xml, "offsets", offsets.into_iter());
    xml.push_str("</Lines>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
    let mut bytes = xml.into_bytes();
    bytes.extend(data.0);
    bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
    bytes
}

/// Attribute of arrays of vectors.
const THREE: &str = " NumberOfComponents=\"3\"";

/// Scalars and vectors of all rods, the union of their names in order of appearance.
fn point_data(rods: &[VtkRod], xml: &mut String, data: &mut Appended) {
    for name in distinct(rods.iter().flat_map(|r| r.scalars.iter().map(|(n, _)| *n))) {
        let of_rod = |r: &VtkRod| {
            let own = r.scalars.iter().find(|(n, _)| *n == name);
            own.map_or_else(|| vec![f64::NAN; r.points.len()], |(_, v)| v.clone())
        };
        data.floats(xml, name, "", rods.iter().flat_map(of_rod));
    }
    for name in distinct(rods.iter().flat_map(|r| r.vectors.iter().map(|(n, _)| *n))) {
        let of_rod = |r: &VtkRod| {
            let own = r.vectors.iter().find(|(n, _)| *n == name);
            own.map_or_else(|| vec![Vec3::repeat(f64::NAN); r.points.len()], |(_, v)| v.clone())
        };
        data.floats(xml, name, THREE, rods.iter().flat_map(of_rod).flat_map(|v| [v.x, v.y, v.z]));
    }
}

/// Names without repetition, in order of first appearance.
fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut seen = Vec::new();
    for name in names {
        if !seen.contains(&name) {
            seen.push(name);
        }
    }
    seen
}

/// The appended block: for every array its byte count (u64) and its bytes.
#[derive(Default)]
struct Appended(Vec<u8>);

impl Appended {
    fn floats(&mut self, xml: &mut String, name: &str, attributes: &str, values: impl Iterator<Item = f64>) {
        let attributes = format!("type=\"Float64\" Name=\"{}\"{attributes}", escaped(name));
        self.array(xml, &attributes, values.map(f64::to_le_bytes));
    }

    fn integers(&mut self, xml: &mut String, name: &str, values: impl Iterator<Item = i64>) {
        let attributes = format!("type=\"Int64\" Name=\"{}\"", escaped(name));
        self.array(xml, &attributes, values.map(i64::to_le_bytes));
    }

    fn array(&mut self, xml: &mut String, attributes: &str, values: impl Iterator<Item = [u8; 8]>) {
        let start = self.0.len();
        // Writing to a String cannot fail.
        let _ = writeln!(xml, "<DataArray {attributes} format=\"appended\" offset=\"{start}\"/>");
        self.block(values);
    }

    /// Lines of text: VTK's element for them is `Array`, and each ends with a zero.
    fn texts(&mut self, xml: &mut String, name: &str, lines: &[String]) {
        let (count, start) = (lines.len(), self.0.len());
        // Writing to a String cannot fail.
        let _ = writeln!(
            xml,
            "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{count}\" format=\"appended\" offset=\"{start}\"/>"
        );
        self.block(lines.iter().flat_map(|line| line.bytes().chain([0])).map(|byte| [byte]));
    }

    /// Byte count and bytes.
    fn block<const N: usize>(&mut self, values: impl Iterator<Item = [u8; N]>) {
        let start = self.0.len();
        self.0.extend([0; 8]);
        values.for_each(|v| self.0.extend(v));
        let count = (self.0.len() - start - 8) as u64;
        self.0[start..start + 8].copy_from_slice(&count.to_le_bytes());
    }
}

/// Text with reserved characters of XML escaped.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A `.pvd` collection: one file of rods per time (or load) value, to be played back by ParaView.
#[derive(Debug, Clone)]
pub struct PvdWriter {
    path: PathBuf,
    entries: String,
}

impl PvdWriter {
    /// An empty collection to be written at `path`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into(), entries: String::new() }
    }

    /// Continues a collection from what [`PvdWriter::entries`] gave.
    pub fn resume(path: impl Into<PathBuf>, entries: String) -> Self {
        Self { path: path.into(), entries }
    }

    /// The entries so far, one line each.
    pub fn entries(&self) -> &str {
        &self.entries
    }

    /// Adds `files`, the parts of what is shown at time `time`, and rewrites the collection, which is thus valid after
    /// every step.
    ///
    /// Files in the collection's own folder (or below) are stored relative to it, so the folder can be moved.
    ///
    /// # Errors
    /// [`InputError::Value`] if `time` is not finite, [`InputError::Write`] if the collection cannot be written.
    pub fn push(&mut self, time: f64, files: &[&Path]) -> Result<(), InputError> {
        InputError::check("time", time, true, "a finite number")?;
        let folder = self.path.parent().unwrap_or(Path::new(""));
        for (part, file) in files.iter().enumerate() {
            let file = escaped(&file.strip_prefix(folder).unwrap_or(file).to_string_lossy());
            // Writing to a String cannot fail.
            let _ = writeln!(self.entries, "<DataSet timestep=\"{time:?}\" part=\"{part}\" file=\"{file}\"/>");
        }
        let head = "<?xml version=\"1.0\"?>\n\
            <VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n";
        write_file(&self.path, format!("{head}{}</Collection>\n</VTKFile>\n", self.entries).as_bytes())
    }
}

/// Writes a file.
fn write_file(path: &Path, bytes: &[u8]) -> Result<(), InputError> {
    let refuse = |e: std::io::Error| InputError::Write { path: path.to_owned(), reason: e.to_string() };
    std::fs::File::create(path).and_then(|mut f| f.write_all(bytes)).map_err(refuse)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value of an attribute in a tag.
    fn attribute<'a>(tag: &'a str, name: &str) -> &'a str {
        let from = tag.find(&format!(" {name}=\"")).unwrap_or_else(|| panic!("{name} in {tag}")) + name.len() + 3;
        &tag[from..from + tag[from..].find('"').unwrap()]
    }

    /// Bytes of the appended array `name`, read the way VTK does, and the position just after it.
    fn array<'a>(file: &'a [u8], name: &str) -> &'a [u8] {
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let start = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
        let xml = std::str::from_utf8(&file[..start]).unwrap();
        let tag = xml.lines().find(|l| l.contains(&format!("Name=\"{name}\""))).unwrap();
        let at = start + attribute(tag, "offset").parse::<usize>().unwrap();
        let count = u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
        &file[at + 8..at + 8 + count]
    }

    fn floats(bytes: &[u8]) -> Vec<f64> {
        bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    fn integers(bytes: &[u8]) -> Vec<i64> {
        bytes.chunks_exact(8).map(|b| i64::from_le_bytes(b.try_into().unwrap())).collect()
    }

    #[test]
    fn lines_say_which_obstacle_they_show() {
        let lines = [(0, [Vec3::zeros(), Vec3::x()]), (0, [Vec3::x(), Vec3::y()]), (2, [Vec3::y(), Vec3::z()])];
        let path = std::env::temp_dir().join(format!("supercoil_obstacle_lines_{}.vtp", std::process::id()));
        write_obstacle_lines(&path, &lines, &VtkStep::default()).unwrap();
        let file = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(integers(array(&file, "obstacle")), [0, 0, 2]);
        assert_eq!(integers(array(&file, "offsets")), [2, 4, 6]);
        assert_eq!(floats(array(&file, "Points"))[15..], [0.0, 0.0, 1.0]);
    }

    #[test]
    fn what_is_written_comes_back() {
        let ring: Vec<Vec3> = (0..5).map(|i| Vec3::new((i as f64).cos(), (i as f64).sin(), 0.1)).collect();
        let line: Vec<Vec3> = (0..3).map(|i| Vec3::new(i as f64, 0.0, 1e-300)).collect();
        let rods = [
            VtkRod {
                points: &ring,
                closed: true,
                scalars: vec![("a<b", vec![1.0, 2.0, 3.0, 4.0, 5.0])],
                vectors: vec![],
            },
            VtkRod { points: &line, closed: false, scalars: vec![], vectors: vec![("d1", vec![Vec3::x(); 3])] },
        ];
        let file = polydata(
            &rods,
            &VtkStep { numbers: vec![("TimeValue", 0.25)], units: vec![("d1", "1")] },
            (ROD, &|rod| rod as i64),
        );
        let all: Vec<f64> = ring.iter().chain(&line).flat_map(|p| [p.x, p.y, p.z]).collect();
        assert_eq!(floats(array(&file, "Points")), all);
        assert_eq!(integers(array(&file, "connectivity")), [0, 1, 2, 3, 4, 0, 5, 6, 7]);
        assert_eq!(integers(array(&file, "offsets")), [6, 9]);
        assert_eq!(integers(array(&file, "rod")), [0, 1]);
        assert_eq!(floats(array(&file, "TimeValue")), [0.25]);
        let scalar = floats(array(&file, "a&lt;b"));
        assert_eq!(scalar[..5], [1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!(scalar.len() == 8 && scalar[5..].iter().all(|x| x.is_nan()));
        assert_eq!(floats(array(&file, "d1")).len(), 24);
        assert!(file.ends_with(b"\n</AppendedData>\n</VTKFile>\n"));
    }

    /// The arrays fill the appended block without gap or overlap.
    #[test]
    fn offsets_tile_the_block() {
        let points = [Vec3::x(), Vec3::y()];
        let rod = VtkRod { points: &points, scalars: vec![("s", vec![1.0, 2.0])], ..VtkRod::default() };
        let file =
            polydata(&[rod], &VtkStep { numbers: vec![("load", 1.0)], ..VtkStep::default() }, (ROD, &|rod| rod as i64));
        let text = String::from_utf8_lossy(&file);
        let mut expected = 0;
        for tag in text.lines().filter(|l| l.starts_with("<DataArray")) {
            assert_eq!(attribute(tag, "offset").parse::<usize>().unwrap(), expected);
            expected += 8 + array(&file, attribute(tag, "Name")).len();
        }
        assert_eq!(expected, 8 * (1 + 1 + 1 + 2 + 1 + 1 + 1 + 6 + 1 + 2 + 1 + 1));
    }

    #[test]
    fn wrong_lengths_and_places_are_refused() {
        let rod = VtkRod { points: &[Vec3::x()], scalars: vec![("s", vec![])], ..VtkRod::default() };
        let error = write_vtp(Path::new("/nowhere/a.vtp"), &[rod], &VtkStep::default()).unwrap_err();
        assert_eq!(error.to_string(), "rods[0].s: 0 values for 1 points");
        let error = write_vtp(Path::new("/nowhere/a.vtp"), &[], &VtkStep::default()).unwrap_err();
        assert!(matches!(error, InputError::Write { .. }));
        let rod = VtkRod { points: &[Vec3::x()], scalars: vec![("twist", vec![1.0])], ..VtkRod::default() };
        let twice = VtkStep { numbers: vec![("twist", 1.0)], ..VtkStep::default() };
        let error = write_vtp(Path::new("/nowhere/a.vtp"), &[rod], &twice).unwrap_err();
        assert!(error.to_string().contains("\"twist\": must be a name that no other array"), "{error}");
    }

    #[test]
    fn collection_is_relative_to_its_folder() {
        let folder = std::env::temp_dir().join(format!("supercoil_pvd_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut collection = PvdWriter::new(folder.join("run.pvd"));
        collection.push(0.5, &[&folder.join("step_0.vtp")]).unwrap();
        collection.push(1.0, &[&folder.join("step_1.vtp"), &folder.join("more_1.vtp")]).unwrap();
        assert!(collection.push(f64::NAN, &[Path::new("x")]).is_err());
        let text = std::fs::read_to_string(folder.join("run.pvd")).unwrap();
        assert!(text.contains("<DataSet timestep=\"0.5\" part=\"0\" file=\"step_0.vtp\"/>"));
        assert!(text.contains("<DataSet timestep=\"1.0\" part=\"1\" file=\"more_1.vtp\"/>"));
        assert_eq!(text.matches("<DataSet").count(), 3);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
