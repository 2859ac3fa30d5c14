use super::*;

/// The sixteen steps of a table.
fn table(steps: &Steps) -> [[Step; 4]; 4] {
    match &steps.0 {
        StepList::ByBases(all) => **all,
        StepList::InOrder(_) => panic!("steps in order"),
    }
}

/// Strains that a rod is at rest with lead exactly from base pair to base pair, whatever the step.
#[test]
fn the_rod_at_rest_passes_through_the_base_pairs() {
    let sequence = Sequence::parse("ACGTTGCAATCCGGA").unwrap();
    let steps = Steps::protein_dna_1998().unwrap();
    let helix = sequence.helix(&steps, false).unwrap();
    let (mut frame, mut position) = (Quat::identity(), Vec3::zeros());
    let (mut turned, mut moved) = (frame, position);
    let spacing = helix.length / 14.0;
    for (k, step) in sequence.steps(&steps, false).enumerate() {
        let (turn, shift) = step.pose();
        position += frame * shift;
        frame *= turn;
        let strains = helix.natural.at((k as f64 + 0.5) * spacing);
        let parts = 20_000;
        for part in 0..parts {
            let h = spacing / f64::from(parts);
            let middle = Quat::from_scaled_axis(strains.fixed_rows::<3>(3) * (h * (f64::from(part) + 0.5)));
            moved += turned * (middle * Vec3::from(strains.fixed_rows::<3>(0))) * h;
        }
        turned *= Quat::from_scaled_axis(strains.fixed_rows::<3>(3) * spacing);
        assert!(turned.angle_to(&frame) < 1e-12 && (moved - position).norm() < 1e-9, "{k}: {moved} {position}");
    }
    assert!((helix.length - 14.0 * 0.335).abs() < 0.2 && (helix.turns - 1.3).abs() < 0.1, "{helix:?}");
}

/// Half a turn about the dyad, x → x, y → −y, z → −z and back: both strands tell the same step.
#[test]
fn a_step_read_along_the_other_strand_is_the_same_step() {
    let steps = Steps::protein_dna_1998().unwrap();
    let dyad = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI);
    for (a, b) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
        let ((turn, shift), (back, shift_back)) = (table(&steps)[a][b].pose(), table(&steps)[3 - b][3 - a].pose());
        assert!((dyad * turn.inverse() * dyad.inverse()).angle_to(&back) < 1e-12, "{a} {b}");
        assert!((dyad * (turn.inverse() * -shift) - shift_back).norm() < 1e-12, "{a} {b}");
    }
}

#[test]
fn ideal_dna_has_its_stiffnesses() {
    let helix = Sequence::parse("AC").unwrap().helix(&Steps::ideal(), true).unwrap();
    let c = helix.stiffness.at(0.1) / THERMAL_ENERGY;
    let expected = [680.0 * 0.34 / 0.34 * 1.0, 680.0, 680.0, 47.6598, 47.6598, 66.6344];
    for i in 0..6 {
        assert!((c[(i, i)] / expected[i] - 1.0).abs() < 1e-6, "{i}: {}", c[(i, i)]);
    }
    assert_eq!(helix.natural.at(0.1).as_slice()[..3], [0.0, 0.0, 1.0]);
    assert!((helix.turns - 2.0 * 34.2857 / 360.0).abs() < 1e-12);
}

/// Means and some constants as the paper's table has them.
#[test]
fn the_table_of_1998() {
    let steps = Steps::protein_dna_1998().unwrap();
    let of = |word: &str| {
        let bases: Vec<usize> = word.chars().filter_map(base).collect();
        table(&steps)[bases[0]][bases[1]]
    };
    assert_eq!(of("CG").mean, [0.0, 5.4, 36.1, 0.0, 0.41, 3.39]);
    assert_eq!(of("TT").mean, [1.4, 0.7, 35.1, 0.03, -0.08, 3.27]);
    assert_eq!((of("TG").stiffness[0][2], of("CA").stiffness[2][0]), (0.016, -0.016));
    assert_eq!(of("TC").stiffness[3][4], -1.75);
}

#[test]
fn fasta_letters_and_topologies() {
    let folder = std::env::temp_dir().join(format!("supercoil_fasta_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("a.fasta");
    let read = |text: &str| {
        std::fs::write(&file, text).unwrap();
        Sequence::read(&file).map_err(|error| error.to_string())
    };
    assert_eq!(read(">pX some plasmid\nACgt\n\nTT\r\n").unwrap().letters(), "ACGTTT");
    let refused = read(">pX\nACGT\nACNT\n").unwrap_err();
    assert!(refused.ends_with("a.fasta: line 3: \"N\" is no base: A, C, G or T expected"), "{refused}");
    assert!(read(">a\nACGT\n>b\nAC\n").unwrap_err().ends_with("line 3: a second sequence: one is read"));
    assert!(read(">a\nA\n").unwrap_err().ends_with("number of bases = 1: must be at least 2"));
    // two strands from 3′ to 5′, a ring; and the form since oxDNA 3.6
    let classic = "8 2\n1 T 3 1\n1 G 0 2\n1 C 1 3\n1 A 2 0\n2 T 7 5\n2 G 4 6\n2 C 5 7\n2 A 6 4\n";
    assert_eq!(read(classic).unwrap().letters(), "ACGT");
    assert_eq!(read("8 2 5->3\nGGAT type=DNA circular=true\nATCC type=DNA circular=true\n").unwrap().letters(), "GGAT");
    for (text, reason) in [
        (classic.replace("2 C 5", "2 A 5"), "line 8: base A faces G, of which it is no complement"),
        (classic.replace("2 C 5", "2 U 5"), "line 8: \"U\" is no base: A, C, G or T expected"),
        (
            classic.replace("2 A 6 4\n", ""),
            "strands of 4 and 3 bases, but line 1 says 8 in all: two of one length expected",
        ),
        (classic.replace("1 C 1 3", "1 C"), "line 4: strand, base and its two neighbours expected, found \"1 C\""),
        (classic.replace("8 2", "8 3"), "line 1: the number of nucleotides and two strands expected, found \"8 3\""),
    ] {
        let refused = read(&text).unwrap_err();
        assert!(refused.ends_with(reason), "{refused}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
    let refused = Sequence::parse("ACXT").unwrap_err().to_string();
    assert_eq!(refused, "sequence, base 3 = \"X\": must be A, C, G or T");
}

#[test]
fn bad_tables_are_refused() {
    let head =
        "step,tilt,roll,twist,shift,slide,rise,tilt_tilt,roll_roll,twist_twist,shift_shift,slide_slide,rise_rise";
    let row = "0,0,34,0,0,3.4,.04,.04,.06,20,20,20";
    let all = "AA AC AG AT CA CC CG GA GC TA".split(' ').map(|step| format!("{step},{row}\n")).collect::<String>();
    assert!(Steps::parse(&format!("{head}\n{all}")).is_ok());
    for (text, reason) in [
        (format!("{head}\nAA,{row}"), "there is no step AC".to_owned()),
        (format!("{head}\nAN,{row}"), "line 2: step AN: must be two of the letters A, C, G, T".to_owned()),
        (format!("{head}\nAA,{row}\nAA,{row}"), "line 3: step AA: is there twice".to_owned()),
        (
            format!("{head}\nAA,0,0,34,0,0,3.4,.04,-.04,.06,20,20,20"),
            "line 2: step AA: force constants[1][1] = -0.04".into(),
        ),
        (
            format!("{head},roll_twist\nAA,{row},.05"),
            "line 2: step AA: force constants: is not positive definite".into(),
        ),
        (format!("{head},roll_twits\nAA,{row},.05"), "line 1: unknown column \"roll_twits\"".into()),
        ("step,tilt,roll,twist,shift,slide\n".into(), "line 1: there is no column rise".into()),
        ("tilt,roll\n".into(), "line 1: the first column must be step, found tilt".into()),
    ] {
        let found = Steps::parse(&text).unwrap_err();
        assert!(found.starts_with(&reason), "{found}");
    }
}

/// Drawn and repeated sequences: as many bases as requested, the same for a seed, all four bases alike often.
#[test]
fn sequences_are_made_from_words() {
    let drawn = Sequence::parse("random:4000:7").unwrap();
    assert_eq!(drawn, Sequence::parse(" random : 4000 : 7 ").unwrap());
    assert_ne!(drawn, Sequence::parse("random:4000:8").unwrap());
    let letters = drawn.letters();
    for base in BASES {
        let count = letters.chars().filter(|letter| *letter == base).count();
        // five standard deviations
        assert!((count as f64 - 1000.0).abs() < 5.0 * 27.4, "{base}: {count}");
    }
    // written down once: machines and versions agree
    assert_eq!(Sequence::parse("random:12:1").unwrap().letters(), FIRST);
    assert_eq!(Sequence::parse("poly:AAT:8").unwrap().letters(), "AATAATAA");
    for word in ["random:1:7", "random:10", "random:10:x", "poly::8", "poly:AX:8", "many:8:1", "random:100000001:1"] {
        let refused = Sequence::parse(word).unwrap_err().to_string();
        assert!(
            refused.starts_with(&format!("sequence.letters = \"{word}\": must be A, C, G, T, random:")),
            "{refused}"
        );
    }
}

/// Twelve bases of seed 1.
const FIRST: &str = "GGTCCTTGCTCG";

#[test]
fn gaps_and_lower_case_are_read() {
    assert_eq!(Sequence::parse("ac-gt..a\nC").unwrap().letters(), "ACGTAC");
    let dir = std::env::temp_dir().join("supercoil_gaps");
    std::fs::create_dir_all(&dir).unwrap();
    std::fs::write(dir.join("a.fasta"), ">aligned\nac--GT\n..ta\n").unwrap();
    assert_eq!(Sequence::read(&dir.join("a.fasta")).unwrap().letters(), "ACGTTA");
    std::fs::write(dir.join("a.fasta"), ">aligned\nacN-GT\n").unwrap();
    let refused = Sequence::read(&dir.join("a.fasta")).unwrap_err().to_string();
    assert!(refused.contains("line 2: \"N\" is no base"), "{refused}");
}

/// A table of steps in their order gives each its own parameters.
#[test]
fn steps_in_order() {
    let row = |k: usize| format!("{k},0,{k},34,0,0,3.4,0.04,0.04,0.06,20,20,20");
    let head =
        "step,tilt,roll,twist,shift,slide,rise,tilt_tilt,roll_roll,twist_twist,shift_shift,slide_slide,rise_rise";
    let text = |rows: &[usize]| format!("{head}\n{}\n", rows.iter().map(|&k| row(k)).collect::<Vec<_>>().join("\n"));
    let steps = Steps::parse(&text(&[1, 2, 3])).unwrap();
    let sequence = Sequence::parse("AAAA").unwrap();
    let rolls: Vec<f64> = sequence.steps(&steps, false).map(|step| step.mean[1]).collect();
    assert_eq!(rolls, [1.0, 2.0, 3.0]);
    assert!(sequence.helix(&steps, false).is_ok());
    let refused = sequence.helix(&steps, true).unwrap_err().to_string();
    assert_eq!(refused, "sequence.steps: has 3 steps, but a closed molecule of 4 base pairs has 4");
    let refused = Steps::parse(&text(&[1, 3])).unwrap_err();
    assert_eq!(refused, "line 3: step 3: must be 2: numbers count the steps");
}
