//! Measures of arithmetic that several rooms share: rounding, nothing, balance, batches. A constant that decides
//! something stands next to its use.

/// Relative change of gaps, arc lengths or balances of energy that counts as rounding, because it is some 10⁴ units in
/// the last place: a sum over the elements of a mesh is known no better.
pub(in crate::solve) const ROUNDING: f64 = 1e-11;
/// Units in the last place that are the rounding of a strain, because it is the sum of that many products of shape
/// functions. Of the potential, too: potentials of states 10⁻¹³ apart scatter by 2 units of its parts, or by 0.3 of the
/// work of all forces over a node spacing (standard deviations, fifteen scenes at most).
pub(in crate::solve) const LAST_PLACES: f64 = 10.0;
/// Part of a usual quantity that counts as nothing, because it is far above the rounding of single numbers and far
/// below any load, motion or stiffness that is meant: works and angles of given numbers, the energy held by open gaps,
/// springs that keep a matrix regular.
pub(in crate::solve) const NOTHING: f64 = 1e-9;
/// Relative residual of a state in balance, and size of steps whose decrease is rounding. Below it tiny steps are those
/// at a saddle or rounding, because it is that of the default tolerance of increments.
pub(in crate::solve) const BALANCED: f64 = 1e-8;
/// Turn, rad, within which a chord stands for the arc, because it is only a hundredth shorter.
pub(in crate::solve) const ARC: f64 = 0.5;
/// Rounds of an iteration, because one that contracts by 0.4 gains four digits in them. With 8 rounds of
/// corrections instead the helical ring does not converge.
pub(in crate::solve) const MAX_ROUNDS: usize = 10;
/// Newton iterations, or inverse iterations, at most, because that is twice as many as a good search takes.
pub(in crate::solve) const MAX_ITERATIONS: usize = 16;
/// Halvings that shorten an interval to rounding, because each gives a bit.
pub(in crate::solve) const HALVINGS: usize = f64::MANTISSA_DIGITS as usize;
/// Results computed in parallel before they are added in order, because the buffer must not grow with the mesh, and
/// tasks that are shared out, because that is some dozens for each of many threads.
pub(in crate::solve) const AT_ONCE: usize = 1024;
