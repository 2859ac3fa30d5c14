//! Two rods wound round each other: the inside of a plectoneme, against its closed forms. Set-up and closed forms:
//! `common/two_ply.rs`.

#![allow(clippy::unwrap_used)] // helpers of tests

use crate::common;

use common::two_ply::without_torque;
use common::verify;

#[test]
fn inside_of_a_plectoneme_has_its_closed_forms() {
    for (alpha, turns) in [(0.35, 3.0), (0.5, 4.0)] {
        let plies = without_torque(alpha, turns);
        let ply = &plies[plies.len() - 1];
        let [moment, tail, pressure] = ply.exact();
        let name = format!("two-ply, α = {:.4}", ply.alpha);
        verify(&name, "torque of the pair, over M", ply.torque / moment, 0.0, 1e-6);
        verify(&name, "twisting moment M", -ply.moment, moment, 1e-3 * moment);
        verify(&name, "tension F of the tails", ply.tail, tail, 1e-3 * tail);
        verify(&name, "contact force per length p", ply.pressure, pressure, 1e-3 * pressure);
    }
}
