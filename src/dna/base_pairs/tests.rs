//! Base pairs: link, conventions, round trips.

use super::*;
use crate::dna::HELICAL_REPEAT;
use crate::dna::sequence::Sequence;
use crate::math::link::{link_numbers, linking_number};
use crate::rod::{Natural, Rod, RodMesh, Section, Shape};

fn ring(link: f64, count: usize) -> BasePairs {
    let circle = Shape::Circle { length: 0.34 * count as f64, center: Vec3::new(1.0, 2.0, 3.0), normal: Vec3::y() };
    let section = Section::isotropic(200.0, 300.0, 1e3, 1e3, 0.0);
    let rod = Rod::new("ring", &circle, RodMesh::closed(40, 3), section, Natural::Straight).unwrap();
    let rod = rod.with_excess_link(link).unwrap();
    let nodes = Nodes {
        positions: &rod.positions,
        frames: &rod.frames,
        order: 3,
        closed: Some(link),
        turns_left_out: 0.0,
        helical_repeat: HELICAL_REPEAT,
    };
    BasePairs::along(&nodes, count).unwrap()
}

/// 336 base pairs have 32 turns when relaxed; the linking number of the written strands is that plus the excess link.
#[test]
fn strands_are_linked_as_imposed() {
    for (link, turns) in [(0.0, 32), (-3.0, 29), (2.0, 34), (-0.4, 32)] {
        let pairs = ring(link, 336);
        let [a, b] = pairs.strands();
        assert_eq!(linking_number(&a, &b).round() as i32, turns, "{link}");
        let d1: Vec<Vec3> = pairs.frames.iter().map(|q| q * Vec3::x()).collect();
        let numbers = link_numbers(&pairs.positions, &d1, 0.0);
        assert!((numbers.link - f64::from(turns)).abs() < 1e-6, "{numbers:?}");
    }
}

#[test]
fn configurations_read_back() {
    let pairs = ring(-3.0, 336);
    let text = pairs.oxdna_configuration();
    assert_eq!(text.lines().count(), 3 + 2 * 336);
    let back = BasePairs::from_oxdna(&text, true).unwrap();
    for k in 0..336 {
        assert!((back.positions[k] - pairs.positions[k]).norm() < 1e-12, "{k}");
        assert!(back.frames[k].angle_to(&pairs.frames[k]) < 1e-7, "{k}");
    }
    let refused = BasePairs::from_oxdna("t = 0\nb = 1 1 1\nE = 0 0 0\n1 2 3\n", true).unwrap_err();
    assert!(refused.contains("line 4: position, a1 and a3 expected"), "{refused}");
    // axes of a nucleotide of the first strand that are none, and a number that is none
    for (axes, reason) in [("1 0 0  1 0 0", "no right-handed unit frame"), ("nan 0 0  0 0 1", "a1 and a3 expected")] {
        let text = format!("t = 0\nb = 1 1 1\nE = 0 0 0\n1 2 3  {axes}\n1 2 4  -1 0 0  0 0 -1\n");
        let refused = BasePairs::from_oxdna(&text, false).unwrap_err();
        assert!(refused.contains("line 4: ") && refused.contains(reason), "{refused}");
    }
}

/// Partners face each other across the axis, neighbours are listed from 3′ to 5′, and a3 points to the 5′ end.
#[test]
fn oxdna_conventions() {
    let sequence = Sequence::parse("AACGT").unwrap();
    let pairs = BasePairs {
        positions: (0..5).map(|k| Vec3::z() * (0.34 * f64::from(k))).collect(),
        frames: vec![Quat::identity(); 5],
        ..BasePairs::default()
    };
    let topology = pairs.oxdna_topology(&sequence).unwrap();
    let lines: Vec<&str> = topology.lines().collect();
    assert_eq!(lines[..4], ["10 2", "1 T -1 1", "1 G 0 2", "1 C 1 3"]);
    assert_eq!(lines[5..8], ["1 A 3 -1", "2 T -1 6", "2 T 5 7"]);
    let configuration = pairs.oxdna_configuration();
    let row = |k: usize| -> Vec<f64> {
        configuration.lines().nth(3 + k).unwrap().split(' ').map(|cell| cell.parse().unwrap()).collect()
    };
    // the first listed is the last of the strand that is read: at +d2, looking back to the axis and to its 5′ end
    assert_eq!(row(0)[..9], [0.0, 0.6, 4.0 * 0.34 / OXDNA_LENGTH, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0]);
    assert_eq!(row(5)[..9], [0.0, -0.6, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let closed = BasePairs { closed: true, ..pairs.clone() }.oxdna_topology(&sequence).unwrap();
    assert_eq!([1, 5, 6, 10].map(|k| closed.lines().nth(k).unwrap()), ["1 T 4 1", "1 A 3 0", "2 T 9 6", "2 A 8 5"]);
    let short = Sequence::parse("AAC").unwrap();
    assert!(pairs.oxdna_topology(&short).unwrap_err().to_string().contains("has 3 bases, but there are 5"));
}

#[test]
fn arrays_and_points() {
    let pairs = ring(0.0, 50);
    let bytes = pairs.npy();
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + header) % 64, 0);
    let text = std::str::from_utf8(&bytes[10..10 + header]).unwrap();
    assert_eq!(text.trim_end(), "{'descr': '<f8', 'fortran_order': False, 'shape': (50, 4, 3), }");
    assert_eq!(bytes.len(), 10 + header + 50 * 12 * 8);
    let number = |k: usize| f64::from_le_bytes(bytes[10 + header + 8 * k..][..8].try_into().unwrap());
    assert_eq!([12, 13, 14].map(number), <[f64; 3]>::from(pairs.positions[1]));
    assert_eq!([21, 22, 23].map(number), <[f64; 3]>::from(pairs.frames[1] * Vec3::z()));
    assert!(pairs.xyz().starts_with("50\nbase pairs, nm\nC ") && pairs.xyz().lines().count() == 52);
}

fn same(a: &BasePairs, b: &BasePairs, places: f64, turns: f64) {
    assert_eq!((a.positions.len(), a.closed), (b.positions.len(), b.closed));
    for k in 0..a.positions.len() {
        let off = (a.positions[k] - b.positions[k]).norm();
        assert!(off < places && a.frames[k].angle_to(&b.frames[k]) < turns, "{k}: {off:e}");
    }
}

#[test]
fn frames_read_back() {
    let pairs = ring(-1.0, 120);
    same(&BasePairs::from_npy(&pairs.npy(), true).unwrap(), &pairs, 1e-15, 1e-7);
    same(&BasePairs::from_ref_frames(&pairs.ref_frames(), true).unwrap(), &pairs, 1e-12, 1e-7);
    // step parameters forget where the first pair lies
    let start = (pairs.positions[0], pairs.frames[0]);
    let mut back = BasePairs::from_par(&pairs.par(), true).unwrap();
    back.positions.iter_mut().for_each(|r| *r = start.0 + start.1 * *r);
    back.frames.iter_mut().for_each(|q| *q = start.1 * *q);
    same(&back, &pairs, 1e-9, 1e-7);
    // listed from 5' to 3'
    let text = pairs.oxdna_configuration();
    let (head, rows): (Vec<&str>, Vec<&str>) = (text.lines().take(3).collect(), text.lines().skip(3).collect());
    let turned: Vec<&str> = rows[..120].iter().rev().chain(rows[120..].iter().rev()).copied().collect();
    let new = [head, turned].concat().join("\n");
    same(&BasePairs::from_oxdna(&new, true).unwrap(), &pairs, 1e-12, 1e-7);
}

#[test]
fn files_that_are_none_are_refused_with_line_and_value() {
    let pairs = BasePairs { closed: false, ..ring(0.0, 30) };
    let frames = pairs.ref_frames();
    for (text, reason) in [
        (frames.replace("0.000000000000000  # y-axis", "x  # y-axis"), "a finite number expected, found \"x\""),
        (frames.lines().take(9).collect::<Vec<_>>().join("\n"), "holds 6 lines of three numbers, not four a base pair"),
        (frames.replace(" # x-axis", " 7"), "three numbers expected, found 4"),
        (frames.replacen("# z-axis", "#", 1).replace("# x-axis", "\n1 0 0\n0 1 0 #"), "no right-handed unit frame"),
    ] {
        let refused = BasePairs::from_ref_frames(&text, false).unwrap_err();
        assert!(refused.contains(reason), "{refused}");
    }
    let par = pairs.par();
    let refused = BasePairs::from_par(&par.replace("Twist", "Turn"), false).unwrap_err();
    assert!(refused.starts_with("line 3: no column Twist; there are Shear"), "{refused}");
    let refused = BasePairs::from_par(&par.replacen("\nN-N  ", "\nN-N nan ", 2), false).unwrap_err();
    assert_eq!(refused, "line 4: a finite number expected, found \"nan\"");
}

#[test]
fn axes_as_points() {
    let pairs = ring(0.0, 40);
    let vect = pairs.vect();
    assert!(vect.starts_with("VECT\n1 40 0\n-40\n0\n") && vect.lines().count() == 44);
    let pdb = pairs.pdb().unwrap();
    assert_eq!(pdb.lines().filter(|line| line.starts_with("ATOM")).count(), 80);
    assert!(pdb.contains("\nCONECT   40    1\nCONECT   80   41\nEND"), "{pdb}");
    let far = BasePairs { positions: vec![Vec3::x() * 1000.0; 40], ..pairs };
    let refused = far.pdb().unwrap_err();
    assert!(refused.starts_with("base pair 1: 1000") && refused.ends_with("PDB ends at 999.9"), "{refused}");
}

/// Bases are named in every format that has a place for them. Strands are listed from their own 5' ends.
#[test]
fn bases_are_named() {
    let letters: String = "ACGTTGCAAG".repeat(4);
    let pairs = ring(0.0, 40).with_sequence(Sequence::parse(&letters).unwrap()).unwrap();
    let par = pairs.par();
    let names: Vec<&str> = par.lines().skip(3).map(|line| line.split_whitespace().next().unwrap()).collect();
    assert_eq!(names[..4], ["A-T", "C-G", "G-C", "T-A"]);
    assert!(pairs.ref_frames().contains("...     2 C-G\n"));
    let pdb = pairs.pdb().unwrap();
    let atoms: Vec<&str> = pdb.lines().filter(|line| line.starts_with("ATOM")).collect();
    assert_eq!([&atoms[0][17..26], &atoms[1][17..26]], [" DA A   1", " DC A   2"]);
    // the complement of the last, of the one before, of the first
    assert_eq!([&atoms[40][17..26], &atoms[41][17..26], &atoms[79][17..26]], [" DC B  41", " DT B  42", " DT B  80"]);
    let refused = ring(0.0, 40).with_sequence(Sequence::parse("ACGT").unwrap()).unwrap_err().to_string();
    assert_eq!(refused, "sequence: has 4 bases, but there are 40 base pairs");
}

/// The steps of a ring lead round it, back to the first pair: as many as pairs, in the file, too.
#[test]
fn the_steps_of_a_ring_close_it() {
    let pairs = ring(-1.0, 120);
    let steps = pairs.steps();
    assert_eq!(steps.len(), 120);
    let (mut turn, mut place) = (Quat::identity(), Vec3::zeros());
    for step in &steps {
        let (next, shift) = crate::dna::pose::pose(step);
        place += turn * shift;
        turn *= next;
    }
    assert!(place.norm() < 1e-9 && turn.angle() < 1e-7, "{place} {turn}");
    let par = pairs.par();
    assert!(par.starts_with("  121 # base-pairs") && par.lines().count() == 3 + 121);
    let last: Vec<f64> = par.lines().last().unwrap().split_whitespace().skip(7).map(|x| x.parse().unwrap()).collect();
    let [tilt, roll, twist, shift, slide, rise] = steps[119];
    assert!(last.iter().zip([shift, slide, rise, tilt, roll, twist]).all(|(a, b)| (a - b).abs() < 1e-9), "{last:?}");
}
