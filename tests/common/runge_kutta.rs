//! The classical Runge–Kutta method of order four, for references that tests integrate themselves.

/// One step of length `h` of y′ = rate(y).
pub fn step<const N: usize>(rate: &impl Fn(&[f64; N]) -> [f64; N], y: &[f64; N], h: f64) -> [f64; N] {
    let moved = |k: &[f64; N], t: f64| -> [f64; N] { std::array::from_fn(|i| y[i] + t * k[i]) };
    let k1 = rate(y);
    let k2 = rate(&moved(&k1, 0.5 * h));
    let k3 = rate(&moved(&k2, 0.5 * h));
    let k4 = rate(&moved(&k3, h));
    std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

/// Extrapolated from one step and two halves: of order five.
pub fn extrapolated_step<const N: usize>(rate: &impl Fn(&[f64; N]) -> [f64; N], y: &[f64; N], h: f64) -> [f64; N] {
    let (whole, halves) = (step(rate, y, h), step(rate, &step(rate, y, 0.5 * h), 0.5 * h));
    std::array::from_fn(|i| halves[i] + (halves[i] - whole[i]) / 15.0)
}

/// From `y` over `length` in so many equal steps.
pub fn along<const N: usize>(
    rate: impl Fn(&[f64; N]) -> [f64; N],
    mut y: [f64; N],
    length: f64,
    steps: usize,
) -> [f64; N] {
    for _ in 0..steps {
        y = step(&rate, &y, length / steps as f64);
    }
    y
}
