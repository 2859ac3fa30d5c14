//! The scenes cover every pair of features that there is, and those that are missing are refused.

use std::collections::BTreeSet;
use std::path::Path;

use crate::relations::axes::{AXES, REFUSALS, parts, words};
use crate::relations::covering::{Rules, all_pairs, covering, legal_pairs, pairs_of, scene_with};
use crate::relations::draft::{Draft, Mesh};
use crate::relations::{NUM_SCENES, scenes};

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_TARGET_TMPDIR"), "/relations"))
}

/// Every pair of values occurs in the scenes, or a refusal excludes it.
#[test]
fn all_legal_pairs_occur() {
    let scenes = scenes();
    assert_eq!(scenes.len(), NUM_SCENES);
    let found: BTreeSet<_> = scenes.iter().flat_map(|scene| pairs_of(&scene.features)).collect();
    let legal = legal_pairs();
    let missing: Vec<_> = legal.difference(&found).collect();
    assert!(missing.is_empty(), "{missing:?}");
    assert!(found.is_subset(&legal));
    println!("{} scenes, {} of {} pairs", scenes.len(), legal.len(), all_pairs().len());
}

#[test]
fn scenes_are_reproducible() {
    assert_eq!(covering(1), covering(1));
    assert_ne!(covering(1), covering(2));
}

/// Every scene can be read.
#[test]
fn scenes_are_sound() {
    let refused: Vec<String> = scenes()
        .iter()
        .filter_map(|scene| {
            let error = scene.scene(&folder().join("sound"), Mesh::Times(1)).err()?;
            Some(format!("{}: {error}", scene.title()))
        })
        .collect();
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

/// Each refusal, alone in a scene: it is what the scene is refused for.
#[test]
fn refusals_are_the_solvers_own() {
    let mut wrong = Vec::new();
    for (index, refusal) in REFUSALS.iter().enumerate() {
        let others = Rules::new(Some(index));
        for values in choices(&parts(refusal.together)) {
            // combinations that another refusal excludes, too, are seen there
            let Some(features) = scene_with(&values, &others) else { continue };
            let draft = Draft::new(900 + index, features);
            let message = match draft.scene(&folder().join("refused"), Mesh::Times(1)) {
                Ok(_) => "it is accepted".to_owned(),
                Err(error) => error.to_string(),
            };
            if !message.contains(refusal.message) {
                wrong.push(format!("{:?}, {:?}: {message}", refusal.together, words(&features)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// One value of each part, in all ways.
fn choices(parts: &[(usize, Vec<usize>)]) -> Vec<Vec<(usize, usize)>> {
    let Some(((axis, values), rest)) = parts.split_first() else { return vec![Vec::new()] };
    let tails = choices(rest);
    let with = |value: &usize| {
        let value = *value;
        tails.iter().map(move |tail| [vec![(*axis, value)], tail.clone()].concat()).collect::<Vec<_>>()
    };
    values.iter().flat_map(with).collect()
}

#[test]
fn words_are_of_one_axis() {
    let all: Vec<&str> = AXES.iter().flat_map(|axis| axis.values.iter().copied()).collect();
    let distinct: BTreeSet<&str> = all.iter().copied().collect();
    assert_eq!(all.len(), distinct.len());
}
