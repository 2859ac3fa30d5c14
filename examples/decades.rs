use supercoil::math::Vec3;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::{Contact, ContactLaw, Model, Ramp};
use supercoil::solve::{Drive, Options, Solver};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let elements: usize = args[1].parse().unwrap();
    let d_over_l: f64 = args[2].parse().unwrap();
    let k0: f64 = args[3].parse().unwrap();
    let ea: f64 = args[4].parse().unwrap();
    let verbose = args[5] == "v";
    let eps = 0.5 * d_over_l;
    let section = Section::isotropic(1.0, 1.5, ea, ea, eps);
    let shape = Shape::Circle { length: 1.0, center: Vec3::zeros(), normal: Vec3::z() };
    let rod = Rod::new("ring", &shape, true, section, elements, 3, Natural::Straight).unwrap();
    let law = |k: f64| ContactLaw::Penalty { stiffness: k * eps.powi(4) };
    let model = Model { rods: vec![rod], contact: Contact { law: law(k0) }, ..Model::default() };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    for t in args[6..].iter().map(|x| x.parse::<f64>().unwrap()) {
        solver.engine_mut().set_contact_law(law(k0)).unwrap();
        let report = solver.step_to(&[Ramp::ExcessLink { rod: 0, to: t }]).unwrap();
        println!("lk {t} k {k0:e}: {:?} {:?}", report.status, report.history.iter().map(|h| h.len()).collect::<Vec<_>>());
        let mut k = k0;
        let mut line = String::new();
        for _ in 0..7 {
            k *= 10.0;
            solver.engine_mut().set_contact_law(law(k)).unwrap();
            let r = solver.settle(&Drive::default());
            line += &format!(" {:e}:{:?} {} pen {:.1e};", k, r.status, r.iterations, r.penetration);
            if verbose { for i in r.history.iter().flatten() { println!("    inc {:.2e} res {:.2e} t {:.3} shift {:.1e} r {}", i.increment, i.residual, i.fraction, i.shift, i.rounds); } }
        }
        println!("{line}\n   {}", supercoil::solve::path::quick(&solver).chars().take(160).collect::<String>());
    }
}
