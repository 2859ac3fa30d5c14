//! Polynomials in Bernstein form on \[0, 1\]: p(t) = Σ b_i C(n,i) tⁱ (1−t)ⁿ⁻ⁱ, up to degree 7.
//!
//! [`roots`] isolates every real root by Descartes' rule of signs on the Bernstein coefficients (Lane & Riesenfeld
//! 1981; Mourrain, Rouillier & Roy 2005) with de Casteljau subdivision. The number of sign changes of the coefficients
//! bounds the number of roots from above and has the same parity, so a piece without a sign change has no root and a
//! piece with one has exactly one. There is no absolute tolerance: multiplying all coefficients by any positive number
//! that keeps them normal changes nothing but roundings.

/// Highest degree handled.
pub const MAX_DEGREE: usize = 7;
const CAPACITY: usize = MAX_DEGREE + 1;
/// Halvings of \[0, 1\]. A piece still undecided at width 2⁻⁴⁸ is one root, because f64 parameters hardly separate two
/// there.
const MAX_DEPTH: u32 = 48;
/// Relative size of a Newton step that counts as rounding once the steps no longer shrink.
const NOISE: f64 = 1e-12;

/// How the sign of the polynomial changes at a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignChange {
    /// From negative to positive (at t = 0: positive after; at t = 1: negative before).
    Rising,
    /// From positive to negative (at t = 0: negative after; at t = 1: positive before).
    Falling,
    /// Touches zero without changing sign (double root, or a near-double pair within rounding).
    Touching,
}

/// A root in \[0, 1\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// Parameter.
    pub t: f64,
    /// Change of sign there.
    pub crossing: SignChange,
}

/// Roots found, ascending; fixed capacity, lives on the stack.
#[derive(Clone, Copy, Debug)]
pub struct Roots {
    t: [f64; CAPACITY],
    crossing: [SignChange; CAPACITY],
    len: usize,
    identically_zero: bool,
}

impl Default for Roots {
    fn default() -> Self {
        Self::new()
    }
}

impl Roots {
    /// No roots.
    #[must_use]
    pub const fn new() -> Self {
        Self { t: [0.0; CAPACITY], crossing: [SignChange::Touching; CAPACITY], len: 0, identically_zero: false }
    }

    /// Forgets all roots.
    pub fn clear(&mut self) {
        self.len = 0;
        self.identically_zero = false;
    }

    /// The parameters, ascending.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.t[..self.len]
    }

    /// The roots with their changes of sign, ascending.
    pub fn iter(&self) -> impl Iterator<Item = Root> + '_ {
        (0..self.len).map(|i| Root { t: self.t[i], crossing: self.crossing[i] })
    }

    /// True if every coefficient was zero: every t is a root and none is listed.
    #[must_use]
    pub const fn identically_zero(&self) -> bool {
        self.identically_zero
    }

    fn push(&mut self, t: f64, crossing: SignChange) {
        if self.len > 0 && self.t[self.len - 1] == t {
            // Two isolated roots that round to the same parameter are one root; opposite changes cancel.
            let last = &mut self.crossing[self.len - 1];
            *last = match (*last, crossing) {
                (SignChange::Touching, c) | (c, SignChange::Touching) => c,
                (a, b) if a == b => a,
                _ => SignChange::Touching,
            };
            return;
        }
        debug_assert!(self.len < CAPACITY, "more roots than sign variations");
        if self.len < CAPACITY {
            self.t[self.len] = t;
            self.crossing[self.len] = crossing;
            self.len += 1;
        }
    }
}

/// The four cubic Bernstein polynomials at u.
#[inline]
pub(crate) fn cubic_weights(u: f64) -> [f64; 4] {
    let t = 1.0 - u;
    [t * t * t, 3.0 * t * t * u, 3.0 * t * u * u, u * u * u]
}

/// Slopes of the four cubic Bernstein polynomials at u.
#[inline]
pub(crate) fn cubic_slopes(u: f64) -> [f64; 4] {
    let t = 1.0 - u;
    [-3.0 * t * t, 3.0 * t * (t - 2.0 * u), 3.0 * u * (2.0 * t - u), 3.0 * u * u]
}

/// p(t) by de Casteljau's algorithm. `coeffs` holds the degree + 1 Bernstein coefficients, at most 8; an empty slice is
/// the polynomial 0.
#[must_use]
pub fn eval(coeffs: &[f64], t: f64) -> f64 {
    let Some(mut b) = load(coeffs) else { return 0.0 };
    for level in (1..coeffs.len()).rev() {
        for i in 0..level {
            b[i] = (1.0 - t) * b[i] + t * b[i + 1];
        }
    }
    b[0]
}

/// Coefficients, degree five, of the product of a cubic and a quadratic; `products(i, j)` is that of the cubic's
/// coefficient i and the quadratic's j.
#[must_use]
pub fn product_with_quadratic(products: impl Fn(usize, usize) -> f64) -> [f64; 6] {
    let d = products;
    [
        d(0, 0),
        (2.0 * d(0, 1) + 3.0 * d(1, 0)) / 5.0,
        (d(0, 2) + 6.0 * d(1, 1) + 3.0 * d(2, 0)) / 10.0,
        (3.0 * d(1, 2) + 6.0 * d(2, 1) + d(3, 0)) / 10.0,
        (3.0 * d(2, 2) + 2.0 * d(3, 1)) / 5.0,
        d(3, 2),
    ]
}

/// Bernstein coefficients of p′ (degree n − 1), written to the first n entries of the result: n (b_{i+1} − b_i).
/// The derivative of a constant (and of an empty slice) is all zeros.
#[must_use]
pub fn derivative(coeffs: &[f64]) -> [f64; MAX_DEGREE] {
    let mut d = [0.0; MAX_DEGREE];
    let n = coeffs.len().saturating_sub(1);
    for i in 0..n.min(MAX_DEGREE) {
        d[i] = n as f64 * (coeffs[i + 1] - coeffs[i]);
    }
    d
}

fn load(coeffs: &[f64]) -> Option<[f64; CAPACITY]> {
    assert!(coeffs.len() <= CAPACITY, "Bernstein polynomials here have degree at most {MAX_DEGREE}");
    let mut b = [0.0; CAPACITY];
    b[..coeffs.len()].copy_from_slice(coeffs);
    (!coeffs.is_empty()).then_some(b)
}

/// p(t) and p′(t) at once, of degree `N` − 1 ≥ 1. The degree is known to the compiler, because contact evaluates cubics
/// and quintics by the million.
#[inline]
fn eval_with_slope<const N: usize>(b: &[f64; N], t: f64) -> (f64, f64) {
    let mut w = *b;
    let s = 1.0 - t;
    for level in (1..N - 1).rev() {
        for i in 0..=level {
            w[i] = s * w[i] + t * w[i + 1];
        }
    }
    (s * w[0] + t * w[1], (N - 1) as f64 * (w[1] - w[0]))
}

/// Number of sign changes of the coefficients, zeros skipped.
fn variations(b: &[f64]) -> usize {
    let mut count = 0;
    let mut last = 0.0_f64;
    for &c in b {
        if c != 0.0 {
            if last != 0.0 && (c < 0.0) != (last < 0.0) {
                count += 1;
            }
            last = c;
        }
    }
    count
}

/// A piece of the polynomial on [t0, t0 + width].
#[derive(Clone, Copy)]
struct SubInterval {
    b: [f64; CAPACITY],
    n: usize,
    t0: f64,
    width: f64,
    depth: u32,
    /// Report a root at the left end of this piece before its interior (set on a right half whose start is a root).
    root_at_start: Option<SignChange>,
}

/// All real roots of Σ `coeffs[i]` C(n,i) tⁱ (1−t)ⁿ⁻ⁱ in \[0, 1\], ascending, each once, replacing the contents of
/// `out`.
///
/// * Simple roots are polished to machine precision (Newton safeguarded by bisection). A sign change between two
///   computed values is never lost: both halves of a subdivided piece share the computed value at their common end.
/// * Exact zeros at t = 0 and t = 1 are reported as 0 and 1 exactly, with the one-sided sign as their [`SignChange`].
/// * A multiple root, and a group of roots that rounding cannot separate (all coefficients of the piece around it below
///   a few ulp of the largest coefficient, about 1e-8 apart for a pair), is one root: `Rising`/`Falling` if the sign
///   differs across the group, else `Touching`. A minimum of |p| above zero by less than that noise may be reported as
///   `Touching` too.
/// * The zero polynomial reports no root and sets [`Roots::identically_zero`]; so does nothing else.
/// * NaN or infinite coefficients: no roots.
/// * Invariant under p → c p, c > 0 (up to rounding); under p → −p the roots stay and the crossings swap.
///
/// # Panics
/// If there are more than 8 coefficients.
pub fn roots(coeffs: &[f64], out: &mut Roots) {
    out.clear();
    let n = coeffs.len().saturating_sub(1);
    // Early exit of the common case: all of one sign.
    if coeffs.iter().all(|&c| c > 0.0) || coeffs.iter().all(|&c| c < 0.0) {
        return;
    }
    let Some(mut b) = load(coeffs) else { return };
    let mut largest = 0.0_f64;
    for &c in coeffs {
        if !c.is_finite() {
            return;
        }
        largest = largest.max(c.abs());
    }
    if largest == 0.0 {
        out.identically_zero = true;
        return;
    }
    // A rescale keeps subnormal products out of the subdivision; signs and zeros are untouched.
    if !(1e-250..=1e250).contains(&largest) {
        for c in &mut b[..=n] {
            *c /= largest;
        }
        largest = 1.0;
    }
    let noise = 4.0 * (n + 1) as f64 * f64::EPSILON * largest;

    let mut m = n;
    let at_start = deflate_start(&mut b, &mut m);
    let at_end = deflate_end(&mut b, &mut m);
    if at_start {
        out.push(0.0, if b[0] > 0.0 { SignChange::Rising } else { SignChange::Falling });
    }
    match variations(&b[..=m]) {
        0 => {}
        1 => out.push(polish(&b[..=m]), crossing_of(b[0], b[m])),
        _ => isolate(SubInterval { b, n: m, t0: 0.0, width: 1.0, depth: 0, root_at_start: None }, noise, out),
    }
    if at_end {
        out.push(1.0, if b[m] < 0.0 { SignChange::Rising } else { SignChange::Falling });
    }
}

/// While b_0 = 0, divides by t: p = t q, q_i = b_{i+1} n/(i+1). True if that happened.
fn deflate_start(b: &mut [f64; CAPACITY], n: &mut usize) -> bool {
    let mut any = false;
    while *n > 0 && b[0] == 0.0 {
        for i in 0..*n {
            b[i] = b[i + 1] * *n as f64 / (i + 1) as f64;
        }
        *n -= 1;
        any = true;
    }
    any
}

/// While b_n = 0, divides by 1 − t: p = (1−t) q, q_i = b_i n/(n−i). True if that happened.
fn deflate_end(b: &mut [f64; CAPACITY], n: &mut usize) -> bool {
    let mut any = false;
    while *n > 0 && b[*n] == 0.0 {
        for i in 0..*n {
            b[i] = b[i] * *n as f64 / (*n - i) as f64;
        }
        *n -= 1;
        any = true;
    }
    any
}

/// Isolates the roots of a piece, neither end of which is a root. Depth-first, left to right: roots come out ascending.
fn isolate(first: SubInterval, noise: f64, out: &mut Roots) {
    const STACK: usize = MAX_DEPTH as usize + 2;
    let mut stack = [first; STACK];
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let piece = stack[top];
        if let Some(crossing) = piece.root_at_start {
            out.push(piece.t0, crossing);
        }
        let b = &piece.b[..=piece.n];
        match variations(b) {
            0 => continue,
            1 => {
                out.push(piece.t0 + piece.width * polish(b), crossing_of(b[0], b[piece.n]));
                continue;
            }
            _ => {}
        }
        if piece.depth >= MAX_DEPTH || b.iter().all(|c| c.abs() <= noise) {
            out.push(piece.t0 + piece.width * cluster_centre(b), crossing_of(b[0], b[piece.n]));
            continue;
        }
        let (left, right) = halve(&piece);
        stack[top] = right;
        stack[top + 1] = left;
        top += 2;
    }
}

fn crossing_of(before: f64, after: f64) -> SignChange {
    match (before < 0.0, after < 0.0) {
        (true, false) => SignChange::Rising,
        (false, true) => SignChange::Falling,
        _ => SignChange::Touching,
    }
}

/// De Casteljau at ½. A midpoint that is exactly a root is moved to `root_at_start` of the right half and divided out
/// of both.
fn halve(piece: &SubInterval) -> (SubInterval, SubInterval) {
    let n = piece.n;
    let mut left = *piece;
    let mut right = *piece;
    for level in 0..=n {
        left.b[level] = right.b[0];
        for i in 0..n - level {
            right.b[i] = 0.5 * right.b[i] + 0.5 * right.b[i + 1];
        }
    }
    left.width = 0.5 * piece.width;
    left.depth += 1;
    left.root_at_start = None;
    right.width = left.width;
    right.t0 = piece.t0 + left.width;
    right.depth = left.depth;
    right.root_at_start = None;
    let at_mid = deflate_end(&mut left.b, &mut left.n) | deflate_start(&mut right.b, &mut right.n);
    if at_mid {
        right.root_at_start = Some(crossing_of(left.b[left.n], right.b[0]));
    }
    (left, right)
}

/// The root of a piece with b_0 b_n < 0, in (0, 1).
fn polish(b: &[f64]) -> f64 {
    match *b {
        [b0, b1] => polish_of(&[b0, b1]),
        [b0, b1, b2] => polish_of(&[b0, b1, b2]),
        [b0, b1, b2, b3] => polish_of(&[b0, b1, b2, b3]),
        [b0, b1, b2, b3, b4] => polish_of(&[b0, b1, b2, b3, b4]),
        [b0, b1, b2, b3, b4, b5] => polish_of(&[b0, b1, b2, b3, b4, b5]),
        [b0, b1, b2, b3, b4, b5, b6] => polish_of(&[b0, b1, b2, b3, b4, b5, b6]),
        [b0, b1, b2, b3, b4, b5, b6, b7] => polish_of(&[b0, b1, b2, b3, b4, b5, b6, b7]),
        // a constant has no change of sign
        _ => 0.0,
    }
}

/// [`polish`]: Newton kept inside a shrinking bracket.
fn polish_of<const N: usize>(b: &[f64; N]) -> f64 {
    let rising = b[0] < 0.0;
    let (mut lo, mut hi) = (0.0_f64, 1.0_f64);
    // The secant of the end values starts the search: it is the root for a straight control polygon.
    let (first, last) = (b[0], b[N - 1]);
    let mut t = (first / (first - last)).clamp(0.0, 1.0);
    let mut last_step = 1.0_f64;
    for _ in 0..200 {
        let (value, slope) = eval_with_slope(b, t);
        if value == 0.0 {
            return t;
        }
        if (value < 0.0) == rising {
            lo = t;
        } else {
            hi = t;
        }
        let newton = t - value / slope;
        let step = (newton - t).abs();
        // Rounding keeps the last steps above an ulp and may take them out of the bracket: they only stop shrinking. (A
        // root with the other slope is another one, just outside.)
        let noise = step <= NOISE * t && step >= 0.25 * last_step;
        if (slope > 0.0) == rising && (step <= f64::EPSILON * t || noise) {
            return newton.clamp(lo, hi);
        }
        // Outside the bracket (also for slope 0 or NaN) or not at least halving: bisect.
        let inside = newton > lo && newton < hi && step <= 0.5 * last_step;
        let next = if inside { newton } else { 0.5 * (lo + hi) };
        last_step = (next - t).abs();
        if last_step <= f64::EPSILON * next || next <= lo || next >= hi {
            return next.clamp(lo, hi);
        }
        t = next;
    }
    t
}

/// Representative of a cluster: the candidate with the smallest |p|, among both ends, the middle and two Newton-like
/// guesses.
fn cluster_centre(b: &[f64]) -> f64 {
    if (b[0] < 0.0) != (b[b.len() - 1] < 0.0) {
        return polish(b);
    }
    // An even cluster: the vertex of the parabola through the ends and the middle.
    let (first, middle, last) = (b[0], eval(b, 0.5), b[b.len() - 1]);
    let curvature = first - 2.0 * middle + last;
    let vertex = 0.5 + 0.25 * (first - last) / curvature;
    if vertex > 0.0 && vertex < 1.0 { vertex } else { 0.5 }
}

#[cfg(test)]
mod tests;
