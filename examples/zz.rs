use supercoil::math::Vec3;
use supercoil::observe::observe;
use supercoil::rod::{Natural, Rod, Section, Shape};
use supercoil::scene::*;
use supercoil::solve::{Options, Progress, Solver};
fn main() {
    let r = 0.01;
    let gap = 1e-4;
    let beam = |name: &str, start: Vec3| {
        let section = Section::isotropic(1.0, 1.0, 1e7, 1e7, r);
        Rod::new(
            name,
            &Shape::Line { start, direction: Vec3::x(), length: 1.0 },
            false,
            section,
            24,
            3,
            Natural::Straight,
        )
        .unwrap()
    };
    let rods = vec![beam("l", Vec3::zeros()), beam("u", Vec3::new(0.0, 2.0 * r + gap, 0.0))];
    let supports = rods
        .iter()
        .enumerate()
        .flat_map(|(rod, r)| [0, r.num_nodes() - 1].map(|node| Support::clamp(NodeRef { rod, node })))
        .collect();
    let model = Model {
        rods,
        supports,
        planar: true,
        line_loads: vec![LineLoad { rod: 0, force: Vec3::y() }, LineLoad { rod: 1, force: -Vec3::y() }],
        ..Model::default()
    };
    let mut solver = Solver::new(model, Options::default()).unwrap();
    for f in [0.98, 1.5, 2.0, 2.9, 2.95, 6.0] {
        let report = solver.step_to(&[Ramp::Load { to: f * 192.0 * gap }]).unwrap();
        let p = Progress { engine: solver.engine(), stage: 0, step: 0, fraction: 1.0, report: &report, seconds: 0.0 };
        let o = observe(&p);
        println!(
            "{f} {:?} its {:?} aug {} pen {:e} F {} exact {}",
            report.status,
            report.history.iter().map(Vec::len).collect::<Vec<_>>(),
            report.augmentations,
            report.penetration,
            o.total_contact_force,
            0.5 * f * 192.0 * gap - 96.0 * gap
        );
        for s in &o.sites {
            println!("   {s:?}");
        }
        println!("  gap {:?}", o.min_gap);
        let ry: f64 = o.reactions.iter().filter(|r| r.rod == 0).map(|r| r.force[1]).sum();
        println!("  reaction lower {ry} expected {}", -f * 192.0 * gap + 0.5 * f * 192.0 * gap - 96.0 * gap);
    }
}
