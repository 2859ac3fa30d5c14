//! Measures that several rooms share: what counts as rounding, as the same, as rough; how long a step may be; how often
//! something is tried.

/// Relative change of gaps, arc lengths or balances of energy that counts as rounding, because it is some 10⁴ units in the
/// last place: a sum over the elements of a mesh is known no better.
pub(in crate::solve) const ROUNDING: f64 = 1e-11;
/// Units in the last place that are the rounding of a strain, because it is the sum of that many products of shape
/// functions. Of the potential, too: potentials of states 10⁻¹³ apart scatter by 2 units of its parts, or by .3 of the
/// work of all forces over a node spacing (standard deviations, fifteen scenes at most).
pub(in crate::solve) const LAST_PLACES: f64 = 10.0;
/// Part of a usual quantity that counts as nothing, because it is far above the rounding of single numbers and far below
/// any load, motion or stiffness that is meant: works and angles of given numbers, the energy held by open gaps, springs
/// that keep a matrix regular.
pub(in crate::solve) const NOTHING: f64 = 1e-9;
/// Relative residual of a state in balance, and size of steps whose decrease is rounding. Below it tiny steps are those at
/// a saddle or rounding, because it is that of the default tolerance of increments.
pub(in crate::solve) const BALANCED: f64 = 1e-8;
/// Relative accuracy of contact forces and of gaps, and that of numbers given with six digits.
pub(in crate::solve) const FINE: f64 = 1e-6;
/// Relative deviation up to which two shapes, motions or forces count as the same, because meshes do not tell them apart.
pub(in crate::solve) const SAME: f64 = 1e-3;
/// Relative accuracy of rough results, because they are only the start of something else.
pub(in crate::solve) const ROUGH: f64 = 1e-2;
/// Relative change up to which a linearisation holds, because its error is the square: a hundredth.
pub(in crate::solve) const SLIGHT: f64 = 0.1;
/// Largest ratio of two changes in a row of an iteration that converges, because with less gain another step does better.
/// With .5 instead, corrections that hardly shrink go on: the beam beside a clamp takes 2844 iterations for 709.
pub(in crate::solve) const CONTRACTION: f64 = 0.4;
/// Turn, rad, within which a chord stands for the arc, because it is only a hundredth shorter.
pub(in crate::solve) const ARC: f64 = 0.5;
/// Largest growth of an extrapolated step, because an extrapolation to twice the distance of what is known has twice to
/// four times its error.
pub(in crate::solve) const FARTHEST: f64 = 2.0;
/// Tries in a row without gain after which there will be none, because the first may be chance.
pub(in crate::solve) const IN_VAIN: usize = 2;
/// Rounds of rules that find their value by the second round, because the first measures, the second corrects, the
/// third confirms.
pub(in crate::solve) const FEW: usize = 3;
/// Rounds of an iteration, because one that contracts by [`CONTRACTION`] gains four digits in them. With 8 rounds of
/// corrections instead the helical ring does not come to rest.
pub(in crate::solve) const MAX_ROUNDS: usize = 10;
/// Newton iterations, or inverse iterations, at most, because that is twice as many as a good search takes.
pub(in crate::solve) const MAX_ITERATIONS: usize = 16;
/// Halvings that shorten an interval to rounding, because each gives a bit.
pub(in crate::solve) const HALVINGS: usize = f64::MANTISSA_DIGITS as usize;
/// Results computed in parallel before they are added in order, because the buffer must not grow with the mesh, and tasks
/// that are shared out, because that is some dozens for each of many threads.
pub(in crate::solve) const AT_ONCE: usize = 1024;
