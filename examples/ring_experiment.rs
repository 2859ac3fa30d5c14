use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Options, Solver};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let elements: usize = args[1].parse().unwrap();
    let d_over_l: f64 = args[2].parse().unwrap();
    let kappa: f64 = args[3].parse().unwrap();
    let ea: f64 = args[4].parse().unwrap();
    let al = args[5] == "al";
    let verbose = args[6] == "v";
    let targets: Vec<f64> = args[7..].iter().map(|x| x.parse().unwrap()).collect();
    let eps = 0.5 * d_over_l;
    let section = Section::isotropic(1.0, 1.5, ea, ea, eps);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, true, section, elements, 3, Natural::Straight).unwrap();
    let stiffness = kappa * eps.powi(4);
    let law = if al {
        ContactLaw::AugmentedLagrangian { stiffness, tol_penetration: 1e-8 }
    } else {
        ContactLaw::Penalty { stiffness }
    };
    let model = Model { rods: vec![rod], contact: Contact { law }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    for t in targets {
        let clock = std::time::Instant::now();
        let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: t }]).unwrap();
        if verbose {
            for h in &report.history {
                println!("  search");
                for i in h {
                    println!(
                        "    inc {:.2e} res {:.2e} t {:.3} shift {:.1e} pot {:.9} r {}",
                        i.increment, i.residual, i.fraction, i.shift, i.potential, i.rounds
                    );
                }
            }
        }
        let r = supercoil::solve::path::quick(&solver);
        if let Some(e) = &report.error {
            println!("{e}");
        }
        println!(
            "lk {t}: {:?} it {} {:?} aug {} dep {} unstable {} pen {:.2e} {} [{:.0} ms]",
            report.status,
            report.iterations,
            report.history.iter().map(|h| h.len()).collect::<Vec<_>>(),
            report.augmentations,
            report.departures,
            report.num_unstable,
            report.penetration,
            r,
            clock.elapsed().as_secs_f64() * 1e3
        );
    }
}
