//! Hostile pairs with rigid bodies and half-spaces keep all the claims of `support/hostile/claims.rs` but that of an exchange of
//! names.

use crate::hostile::{Tallies, merge, report};
use crate::support::hostile::partners::StandIns;
use crate::support::hostile::{Family, Hostile};
use crate::support::scenes::Random;
use crate::support::sweep::{in_batches, range_from_environment};
use std::ops::Range;

/// Pairs that share a set of shapes.
const BATCH: usize = 4096;

/// Pairs of the short form.
const SHORT: usize = BATCH;

/// Pairs of the long form, if HOSTILE_PAIRS does not say.
const LONG: usize = 1_000_000;

fn add(tallies: &mut Tallies, batch: usize, numbers: Range<usize>) {
    let hostile = Hostile::new(batch as u64);
    let partners = StandIns::of(hostile.shapes(), &mut Random::numbered(batch as u64));
    for number in numbers {
        let family = number % Family::ALL.len();
        let pair = hostile.pair_with(&partners, Family::ALL[family], number as u64);
        tallies[family].add(number, &pair);
    }
}

fn soaked(first: usize, count: usize) -> Tallies {
    in_batches((first, count), BATCH, add, merge)
}

#[test]
fn hostile_pairs_with_partners_keep_every_claim() {
    let tallies = soaked(0, SHORT);
    report(&tallies);
    for (family, tally) in Family::ALL.iter().zip(&tallies) {
        assert!(tally.touches_often(), "{family:?} hardly touches");
    }
}

/// Takes from HOSTILE_PAIRS how many, and from HOSTILE_FIRST the number of the first.
#[test]
#[ignore = "an hour: a million pairs"]
fn many_hostile_pairs_with_partners_keep_every_claim() {
    let (first, count) = range_from_environment("HOSTILE", (SHORT, LONG));
    report(&soaked(first, count));
}
