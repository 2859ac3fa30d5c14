//! Geomview's VECT, PDB and NumPy.

use crate::math::Vec3;

use super::finite;
use crate::text::npy::NpyArray;

/// Points of an array of shape (points, 3), or of the first rows of (points, 4, 3).
pub(super) fn npy(bytes: &[u8]) -> Result<Vec<Vec3>, String> {
    let NpyArray { shape, values } = NpyArray::parse(bytes)?;
    let stride = match shape[..] {
        [_, 3] => 3,
        [_, 4, 3] => 12,
        _ => return Err(format!("has shape {shape:?}, not (points, 3) or (points, 4, 3)")),
    };
    Ok(values.chunks_exact(stride).map(|row| Vec3::new(row[0], row[1], row[2])).collect())
}

/// Curves of a VECT file: `VECT`, the numbers of curves, vertices and colours, the vertices of each curve (negative
/// where it is closed), its colours, then the coordinates.
pub(super) fn vect(text: &str) -> Result<Vec<Vec<Vec3>>, String> {
    let lines = (1..).zip(text.lines()).map(|(number, line)| (number, line.split('#').next().unwrap_or_default()));
    let mut words = lines.flat_map(|(number, line)| line.split_whitespace().map(move |word| (number, word)));
    match words.next() {
        Some((_, "VECT")) => {}
        other => return Err(format!("starts with \"{}\" where VECT is expected", other.map_or("", |(_, word)| word))),
    }
    let mut next = |what: &str| words.next().ok_or_else(|| format!("ends where {what} is expected"));
    let mut count = |what: &str| {
        let (number, word) = next(what)?;
        word.parse::<i64>().map_err(|_| format!("line {number}: {what} expected, found \"{word}\""))
    };
    let (curves, vertices) = (count("the number of curves")?, count("the number of vertices")?);
    count("the number of colours")?;
    let sizes = (0..curves).map(|_| count("the number of vertices of a curve")).collect::<Result<Vec<i64>, _>>()?;
    for _ in 0..curves {
        count("the number of colours of a curve")?;
    }
    let total: u64 = sizes.iter().map(|size| size.unsigned_abs()).sum();
    if total != vertices.unsigned_abs() {
        return Err(format!("announces {vertices} vertices, but its curves have {total}"));
    }
    let mut coordinate = || {
        let (number, word) = next("a coordinate")?;
        finite(word).map_err(|reason| format!("line {number}: {reason}"))
    };
    let mut point = || Ok(Vec3::new(coordinate()?, coordinate()?, coordinate()?));
    sizes.iter().map(|size| (0..size.unsigned_abs()).map(|_| point()).collect()).collect()
}

/// Phosphorus atoms of a chain of a PDB file, model by model; of the two strands of a double helix, without a chain,
/// the points midway between partners. Columns as the format fixes them: name 13–16, chain 22, x, y, z in 31–54.
pub(super) fn pdb(text: &str, chain: Option<&str>) -> Result<Vec<Vec<Vec3>>, String> {
    let mut models: Vec<Vec<Vec3>> = vec![Vec::new()];
    let mut chains: Vec<&str> = Vec::new();
    // points of each model by chain, in the order of `chains`
    let mut by_chain: Vec<Vec<Vec<Vec3>>> = vec![Vec::new()];
    for (number, line) in (1..).zip(text.lines()) {
        let column = |from: usize, to: usize| line.get(from - 1..to).unwrap_or_default().trim();
        if column(1, 6) == "ENDMDL" {
            models.push(Vec::new());
            by_chain.push(Vec::new());
        }
        if !matches!(column(1, 6), "ATOM" | "HETATM") || column(13, 16) != "P" {
            continue;
        }
        let here = column(22, 22);
        if !chains.contains(&here) {
            chains.push(here);
        }
        if chain.is_some_and(|chain| chain != here) {
            continue;
        }
        let coordinate =
            |from: usize| finite(column(from, from + 7)).map_err(|reason| format!("line {number}: {reason}"));
        let point = Vec3::new(coordinate(31)?, coordinate(39)?, coordinate(47)?);
        if let Some(model) = models.last_mut() {
            model.push(point);
        }
        if let (Some(model), Some(chain)) = (by_chain.last_mut(), chains.iter().position(|chain| *chain == here)) {
            model.resize_with(model.len().max(chain + 1), Vec::new);
            model[chain].push(point);
        }
    }
    models.retain(|model| !model.is_empty());
    by_chain.retain(|model| !model.is_empty());
    if chain.is_none()
        && let Some(axes) = by_chain.iter().map(|chains| axis(chains)).collect::<Option<Vec<_>>>()
        && !axes.is_empty()
    {
        return Ok(axes);
    }
    match chain {
        _ if chains.is_empty() => Err("holds no atoms P".to_owned()),
        None if chains.len() > 1 => Err(format!("has chains {}: say which by chain", chains.join(", "))),
        Some(chain) if models.is_empty() => Err(format!("has no chain {chain}, but {}", chains.join(", "))),
        _ => Ok(models),
    }
}

/// Points midway between the two strands of a double helix, each listed from its 5' end; `None` of other chains.
fn axis(chains: &[Vec<Vec3>]) -> Option<Vec<Vec3>> {
    let [read, other] = chains else { return None };
    let partners = || read.iter().zip(other.iter().rev());
    let face = |(a, b): (&Vec3, &Vec3)| (a - b).norm() <= WIDEST_PAIR;
    (read.len() == other.len() && partners().all(face)).then(|| partners().map(|(a, b)| (a + b) * 0.5).collect())
}

/// Largest distance of the atoms P of a base pair, Å: 19 in B-DNA.
const WIDEST_PAIR: f64 = 25.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_of_vect_files() {
        let text = "VECT # two curves\n2 5 1\n-3 2\n1 0\n0 0 0  1 0 0\n1 1 0\n\n5 5 5 6 6 6.5\n1 0 0 1\n";
        let curves = vect(text).unwrap();
        assert_eq!(
            curves,
            [
                vec![Vec3::zeros(), Vec3::x(), Vec3::new(1.0, 1.0, 0.0)],
                vec![Vec3::new(5.0, 5.0, 5.0), Vec3::new(6.0, 6.0, 6.5)]
            ]
        );
        for (from, to, reason) in [
            ("VECT", "LIST", "starts with \"LIST\" where VECT is expected"),
            ("2 5 1", "2 6 1", "announces 6 vertices, but its curves have 5"),
            ("6.5\n1 0 0 1", "", "ends where a coordinate is expected"),
            ("1 1 0", "1 one 0", "line 6: a finite number expected, found \"one\""),
            ("2 5 1", "two 5 1", "line 2: the number of curves expected, found \"two\""),
        ] {
            assert_eq!(vect(&text.replacen(from, to, 1)).unwrap_err(), reason);
        }
    }

    #[test]
    fn phosphorus_atoms_of_pdb_files() {
        let atom = |name: &str, chain: &str, x: f64| {
            format!("ATOM  {:>5} {name:<4}  DA {chain}{:>4}    {x:>8.3}{:>8.3}{:>8.3}  1.00  0.00\n", 1, 1, 2.5, -3.0)
        };
        let model =
            |x: f64| atom(" P", "A", x) + &atom(" C1'", "A", 9.0) + &atom(" P", "A", x + 1.0) + &atom(" P", "B", 7.0);
        let text = format!("MODEL 1\n{}ENDMDL\nMODEL 2\n{}ENDMDL\nEND\n", model(0.0), model(10.0));
        let at = |x: f64| Vec3::new(x, 2.5, -3.0);
        assert_eq!(pdb(&text, Some("A")).unwrap(), [[at(0.0), at(1.0)], [at(10.0), at(11.0)]]);
        assert_eq!(pdb(&text, Some("B")).unwrap(), [[at(7.0)], [at(7.0)]]);
        assert_eq!(pdb(&text, None).unwrap_err(), "has chains A, B: say which by chain");
        assert_eq!(pdb(&text, Some("C")).unwrap_err(), "has no chain C, but A, B");
        assert_eq!(pdb("END\n", None).unwrap_err(), "holds no atoms P");
    }
}
