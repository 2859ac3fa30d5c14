//! The softest eigenvalues of K v = λ M v: block Lanczos on K⁻¹M with full reorthogonalisation.
//!
//! A block finds eigenvalues of any multiplicity up to its width; a single vector would find one vector of each pair of
//! a ring's modes. Each new block is orthogonalised against all before it, twice, so nothing has to be found out about
//! ghosts, and the projected matrix is kept in full.

use nalgebra::{DMatrix, SymmetricEigen};

use super::not_found;
use crate::error::SolveError;
use crate::solve::problem::linearised::dot;

/// Width of a block, because a straight or a round rod has its modes in pairs, and bending and twist modes of a ring
/// come as four.
const WIDTH: usize = 4;
/// Residual of a vector, over its eigenvalue of the inverse, at which it is found, because the error of the
/// eigenvalue is the square of that and 1e-7 in a shape is not seen.
const TOL: f64 = 1e-7;
/// Part of a vector that is left by those before it, below which it depends on them.
const DEPENDENT: f64 = 1e-10;
/// Blocks after which a search is given up: ten modes take about ten.
const MAX_BLOCKS: usize = 60;

/// K⁻¹ and M, both symmetric.
pub(super) trait Pencil {
    /// Number of numbers of a vector.
    fn len(&self) -> usize;
    /// K⁻¹ f, without zero-energy modes.
    fn solve(&mut self, forces: &[f64]) -> Vec<f64>;
    /// M v.
    fn multiply(&self, vector: &[f64]) -> Vec<f64>;
}

/// An eigenvalue with its vector, vᵀ M v = 1.
#[derive(Debug, Clone)]
pub(super) struct Eigenpair {
    pub(super) eigenvalue: f64,
    pub(super) vector: Vec<f64>,
}

/// The basis of a Krylov space, M-orthonormal, and the projection of K⁻¹M on it.
struct Krylov<'a, P> {
    pencil: &'a mut P,
    basis: Vec<Vec<f64>>,
    /// M times each of them.
    masses: Vec<Vec<f64>>,
    projected: Vec<Vec<f64>>,
}

/// The `num_negative` negative eigenvalues and the smallest positive ones, `count` in all (fewer if there are fewer),
/// ascending.
///
/// # Errors
/// `SolveError::Eigenvalues` if [`MAX_BLOCKS`] blocks do not suffice.
pub(super) fn softest(
    pencil: &mut impl Pencil,
    count: usize,
    num_negative: usize,
) -> Result<Vec<Eigenpair>, SolveError> {
    let count = count.max(num_negative);
    let mut krylov = Krylov { pencil, basis: Vec::new(), masses: Vec::new(), projected: Vec::new() };
    let mut block = krylov.start();
    for _ in 0..MAX_BLOCKS {
        let before = krylov.basis.len();
        let remainders = krylov.extend(block);
        let ritz = krylov.ritz();
        let wanted = wanted(&ritz, count, num_negative);
        let complete = krylov.basis.len() == before;
        let found = wanted.len() == count && krylov.residuals(&ritz, &wanted, before, &remainders) <= TOL;
        if complete || found {
            let mut pairs: Vec<Eigenpair> = wanted.iter().map(|&k| krylov.pair(&ritz, k)).collect();
            pairs.sort_by(|a, b| a.eigenvalue.total_cmp(&b.eigenvalue));
            return Ok(pairs);
        }
        block = remainders;
    }
    Err(not_found(MAX_BLOCKS))
}

/// Eigenvalues of the inverse that are wanted: the largest in size of those of either sign.
fn wanted(ritz: &SymmetricEigen<f64, nalgebra::Dyn>, count: usize, num_negative: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..ritz.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| ritz.eigenvalues[b].abs().total_cmp(&ritz.eigenvalues[a].abs()));
    let of_sign = |negative: bool| order.iter().copied().filter(move |&k| (ritz.eigenvalues[k] < 0.0) == negative);
    of_sign(true).take(num_negative).chain(of_sign(false).take(count - num_negative)).collect()
}

impl<P: Pencil> Krylov<'_, P> {
    /// Vectors with components everywhere, the same in every run.
    fn start(&mut self) -> Vec<Vec<f64>> {
        let len = self.pencil.len();
        let number = |i: usize, k: usize| ((i * WIDTH + k + 1) as f64 * 0.618_033_988_749_895).fract() - 0.5;
        let start = |k: usize| (0..len).map(|i| number(i, k)).collect::<Vec<f64>>();
        // a first solve takes out what has no mass, and brings all components into their proportions
        (0..WIDTH).map(|k| self.pencil.solve(&self.pencil.multiply(&start(k)))).collect()
    }

    /// Takes a block into the basis; returns what K⁻¹M makes of it beyond the basis.
    fn extend(&mut self, block: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let first = self.basis.len();
        for vector in block {
            self.add(vector);
        }
        let mut remainders = Vec::new();
        for k in first..self.basis.len() {
            let mut image = self.pencil.solve(&self.masses[k]);
            let mut column = vec![0.0; self.basis.len()];
            // twice is enough
            for _ in 0..2 {
                for (i, mass) in self.masses.iter().enumerate() {
                    let part = dot(mass, &image);
                    subtract(&mut image, &self.basis[i], part);
                    column[i] += part;
                }
            }
            self.projected.push(column);
            remainders.push(image);
        }
        remainders
    }

    fn add(&mut self, mut vector: Vec<f64>) {
        let size = |vector: &[f64], mass: &[f64]| dot(vector, mass).max(0.0).sqrt();
        let before = size(&vector, &self.pencil.multiply(&vector));
        for _ in 0..2 {
            for (own, mass) in self.basis.iter().zip(&self.masses) {
                let part = dot(mass, &vector);
                subtract(&mut vector, own, part);
            }
        }
        let mass = self.pencil.multiply(&vector);
        let left = size(&vector, &mass);
        let largest = self.projected.iter().flatten().fold(before, |a, b| a.max(b.abs()));
        if left > DEPENDENT * largest {
            self.basis.push(vector.iter().map(|x| x / left).collect());
            self.masses.push(mass.iter().map(|x| x / left).collect());
        }
    }

    fn ritz(&self) -> SymmetricEigen<f64, nalgebra::Dyn> {
        let m = self.basis.len();
        // of the upper triangle: a column ends where the basis ended when it was computed
        let entry = |i: usize, j: usize| self.projected[i.max(j)][i.min(j)];
        DMatrix::from_fn(m, m, entry).symmetric_eigen()
    }

    /// Largest residual of the wanted pairs, each over its eigenvalue; `remainders` are those of the basis from
    /// `first` on.
    fn residuals(
        &self,
        ritz: &SymmetricEigen<f64, nalgebra::Dyn>,
        wanted: &[usize],
        first: usize,
        remainders: &[Vec<f64>],
    ) -> f64 {
        let masses: Vec<Vec<f64>> = remainders.iter().map(|r| self.pencil.multiply(r)).collect();
        let gram = DMatrix::from_fn(remainders.len(), remainders.len(), |i, j| dot(&remainders[i], &masses[j]));
        let residual = |&k: &usize| {
            let last = ritz.eigenvectors.column(k).rows(first, remainders.len()).into_owned();
            last.dot(&(&gram * &last)).max(0.0).sqrt() / ritz.eigenvalues[k].abs()
        };
        wanted.iter().map(residual).fold(0.0, f64::max)
    }

    fn pair(&self, ritz: &SymmetricEigen<f64, nalgebra::Dyn>, k: usize) -> Eigenpair {
        let mut vector = vec![0.0; self.pencil.len()];
        for (own, share) in self.basis.iter().zip(ritz.eigenvectors.column(k).iter()) {
            subtract(&mut vector, own, -share);
        }
        Eigenpair { eigenvalue: 1.0 / ritz.eigenvalues[k], vector }
    }
}

fn subtract(x: &mut [f64], direction: &[f64], amount: f64) {
    x.iter_mut().zip(direction).for_each(|(a, b)| *a -= amount * b);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonal pencil.
    struct Diagonal(Vec<f64>, Vec<f64>);

    impl Pencil for Diagonal {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn solve(&mut self, forces: &[f64]) -> Vec<f64> {
            forces.iter().zip(&self.0).map(|(f, k)| f / k).collect()
        }
        fn multiply(&self, vector: &[f64]) -> Vec<f64> {
            vector.iter().zip(&self.1).map(|(v, m)| v * m).collect()
        }
    }

    fn eigenvalues(pencil: &mut Diagonal, count: usize, num_negative: usize) -> Vec<f64> {
        softest(pencil, count, num_negative).unwrap().iter().map(|pair| pair.eigenvalue).collect()
    }

    /// Fourfold eigenvalues, negative ones, unknowns without mass, and fewer eigenvalues than requested.
    #[test]
    fn eigenvalues_of_diagonal_pencils() {
        let stiff = |i: usize| if i < 4 { 2.0 } else { (i * i) as f64 };
        let mut fourfold = Diagonal((0..400).map(stiff).collect(), vec![1.0; 400]);
        let found = eigenvalues(&mut fourfold, 6, 0);
        for (found, exact) in found.iter().zip([2.0, 2.0, 2.0, 2.0, 16.0, 25.0]) {
            assert!((found - exact).abs() < 1e-11 * exact, "{found} {exact}");
        }
        let mut saddle = Diagonal((0..300).map(|i| i as f64 - 1.5).collect(), vec![0.5; 300]);
        for (found, exact) in eigenvalues(&mut saddle, 4, 2).iter().zip([-3.0, -1.0, 1.0, 3.0]) {
            assert!((found - exact).abs() < 1e-10, "{found} {exact}");
        }
        let mut light = Diagonal(vec![3.0, 1.0, 5.0, 7.0, 2.0, 1.0, 4.0], vec![1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        let found = eigenvalues(&mut light, 5, 0);
        assert_eq!(found.len(), 2);
        assert!((found[0] - 3.0).abs() < 1e-12 && (found[1] - 7.0).abs() < 1e-12, "{found:?}");
    }
}
