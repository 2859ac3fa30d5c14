//! The two error types: [`InputError`] for input refused where it is constructed, [`SolveError`] for numbers
//! that break down during a run. A run that merely does not converge is a status in its solution, not an error.

use std::path::PathBuf;

/// Input that was refused: names the field, the value found and the values allowed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// A number outside its legal range (NaN and infinities included).
    #[error("{field} = {value}: must be {allowed}")]
    Value {
        /// Path of the offending field, for example `rods[0].section.bending`.
        field: String,
        /// The value found.
        value: f64,
        /// The legal range in words.
        allowed: &'static str,
    },
    /// A count (elements, order, steps, nodes …) outside its legal range.
    #[error("{field} = {value}: must be {allowed}")]
    Count {
        /// Path of the offending field.
        field: String,
        /// The value found.
        value: usize,
        /// The legal range in words.
        allowed: &'static str,
    },
    /// A vector or point that is unusable (zero direction, NaN coordinate …).
    #[error("{field} = ({}, {}, {}): must be {allowed}", value[0], value[1], value[2])]
    Vector {
        /// Path of the offending field.
        field: String,
        /// The value found.
        value: [f64; 3],
        /// Allowed values, in words.
        allowed: &'static str,
    },
    /// A name (of a rod, a node, a key …) that is unknown or ambiguous.
    #[error("{} = \"{}\": must be {}", legible(field), legible(name), legible(allowed))]
    Name {
        /// Path of the offending field.
        field: String,
        /// The name found.
        name: String,
        /// Allowed values, in words.
        allowed: String,
    },
    /// Input whose parts contradict each other or make an ill-posed problem.
    #[error("{}: {}", legible(field), legible(reason))]
    Inconsistent {
        /// Path of the offending field.
        field: String,
        /// The reason, and a remedy.
        reason: String,
    },
    /// Text that could not be parsed (TOML, CSV, XYZ).
    #[error("{}: {}", legible(file), legible(reason))]
    Parse {
        /// File or section the text came from.
        file: String,
        /// The parser's words, with line and column where known.
        reason: String,
    },
    /// A file that could not be read.
    #[error("{}: {}", legible(&path.to_string_lossy()), legible(reason))]
    File {
        /// The file's path.
        path: PathBuf,
        /// The operating system's words.
        reason: String,
    },
    /// A file or folder that could not be written: a full disk, a folder that is read-only or in use.
    #[error("{}: {}", legible(&path.to_string_lossy()), legible(reason))]
    Write {
        /// The file's or folder's path.
        path: PathBuf,
        /// The operating system's words.
        reason: String,
    },
}

/// Longest line of a message. The longest of our own has some 700 characters; a line of a file may have millions.
const LONGEST_LINE: usize = 1000;

/// Text that is safe to show: control characters, which a terminal obeys, are escaped, and long lines are cut.
fn legible(text: &str) -> String {
    let line = |line: &str| -> String {
        let shown = line.chars().take(LONGEST_LINE).map(|c| match c {
            '\t' => c.to_string(),
            c if c.is_control() => c.escape_default().to_string(),
            c => c.to_string(),
        });
        let cut = if line.chars().nth(LONGEST_LINE).is_some() { "…" } else { "" };
        shown.chain([cut.to_owned()]).collect()
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

impl InputError {
    /// Values or keys that do not fit each other.
    pub(crate) fn inconsistent(field: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Inconsistent { field: field.into(), reason: reason.into() }
    }

    /// Refuses `value` unless it is finite and `ok`.
    pub(crate) fn check(field: &str, value: f64, ok: bool, allowed: &'static str) -> Result<(), Self> {
        if value.is_finite() && ok { Ok(()) } else { Err(Self::Value { field: field.to_owned(), value, allowed }) }
    }

    /// Refuses `value` unless it is finite and greater than zero.
    pub(crate) fn positive(field: &str, value: f64) -> Result<(), Self> {
        Self::check(field, value, value > 0.0, "a finite number greater than 0")
    }
}

/// Numbers that broke down during a run; the last accepted state stays available to the caller.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// A residual, tangent or increment became NaN or infinite.
    #[error("iteration {iteration}: {quantity} of unknown {index} is {value}")]
    NotFinite {
        /// Newton iteration.
        iteration: usize,
        /// Which quantity (residual, increment …).
        quantity: &'static str,
        /// Index of the first offending entry.
        index: usize,
        /// The offending value.
        value: f64,
    },
    /// The factorisation failed although the matrix was finite and shifted.
    #[error("iteration {iteration}: the tangent could not be factorised (largest shift tried {shift:.1e})")]
    Factorisation {
        /// Newton iteration.
        iteration: usize,
        /// Largest relative shift tried.
        shift: f64,
    },
    /// The softest modes of a state did not converge.
    #[error("the softest modes did not converge in {iterations} blocks of iterations")]
    Eigenvalues {
        /// Blocks of vectors that were tried.
        iterations: usize,
    },
    /// Contact geometry that cannot be resolved on this mesh.
    #[error("segment {segment} of curve {curve} turns by {turning:.3} rad, more than {limit:.3}: use more elements")]
    TooCoarse {
        /// Curve (rod) index.
        curve: usize,
        /// Segment index within the curve.
        segment: usize,
        /// Upper bound of the total curvature ∫κ ds along the segment, rad.
        turning: f64,
        /// Largest total curvature of a segment, rad.
        limit: f64,
    },
    /// A rod bent so much more tightly than it is thick that contact has no meaning there, on any mesh.
    #[error(
        "segment {segment} of curve {curve} is bent to curvature × contact radius {tightness:.2}: the rod is bent \
         more tightly than it is thick"
    )]
    TooTight {
        /// Curve (rod) index.
        curve: usize,
        /// Segment index within the curve.
        segment: usize,
        /// Upper bound of the mean curvature of the segment × contact radius.
        tightness: f64,
    },
    /// Frames of neighbouring nodes that differ by too much rotation: near half a turn an element would interpolate the
    /// other way round.
    #[error(
        "the frames of nodes {node} and {next} of rod {rod} turn by {turns:.3} turns against each other, more than \
         {limit}: use more elements"
    )]
    TooTwisted {
        /// Rod index.
        rod: usize,
        /// Node index within the rod.
        node: usize,
        /// The node after it.
        next: usize,
        /// Relative rotation of the two frames, turns, at least; the prescribed one if that is the cause.
        turns: f64,
        /// Largest relative rotation, turns.
        limit: f64,
    },
    /// A rod that dead forces drive for ever: nothing holds it, and nothing is left below that could carry it.
    #[error("rod \"{rod}\" falls for ever: nothing holds it against its dead forces, and all other rods are behind it")]
    Falls {
        /// Name of the rod.
        rod: String,
    },
    /// The matrices need more memory than there is.
    #[error(
        "{pairs} pairs of segments may touch: their matrices take at least {needed:.1} GiB, and {available:.1} GiB are \
         available; use fewer elements where rods lie side by side"
    )]
    Memory {
        /// Candidate pairs of segments.
        pairs: usize,
        /// Least memory of the tangent and its factor, GiB.
        needed: f64,
        /// Memory available, GiB.
        available: f64,
    },
    /// Not enough memory or index range for the factorisation.
    #[error("the sparse factorisation could not be set up: {reason}")]
    Symbolic {
        /// The library's words.
        reason: String,
    },
}
