//! Hostile pairs with rigid bodies and half-spaces satisfy all claims of `support/hostile/claims.rs`, except that about an exchange of
//! names.

use crate::hostile::{self, Tallies, assert_touching};
use crate::support::hostile::partners::StandIns;
use crate::support::hostile::{Family, Hostile};
use crate::support::scenes::Random;
use crate::support::sweep::{in_batches, merge, range_from_environment, report};
use std::ops::Range;

/// Number of pairs that share a set of shapes.
const BATCH: usize = 4096;

/// Number of pairs in the short form.
const SHORT: usize = BATCH;

/// Number of pairs in the long form, unless HOSTILE_PAIRS is set.
const LONG: usize = 1_000_000;

fn add(tallies: &mut Tallies, batch: usize, numbers: Range<usize>) {
    let all = Hostile::new(batch as u64);
    let partners = StandIns::of(all.shapes(), &mut Random::numbered(batch as u64));
    for number in numbers {
        let family = number % Family::ALL.len();
        let pair = all.pair_with(&partners, Family::ALL[family], number as u64);
        hostile::add(&mut tallies[family], number, &pair);
    }
}

fn soaked(first: usize, count: usize) -> Tallies {
    in_batches((first, count), BATCH, add, merge)
}

#[test]
fn hostile_pairs_with_partners_keep_every_claim() {
    assert_touching(&soaked(0, SHORT));
}

/// 208,829, 357,328: a side lies in a layer with an equal field, and no polygon remains if corners near the plane count as on the plane.
#[test]
fn pairs_with_partners_that_once_failed_keep_every_claim() {
    for number in [208_829, 357_328] {
        let mut tallies = Tallies::default();
        add(&mut tallies, number / BATCH, number..number + 1);
        report(&Family::ALL, &tallies);
    }
}

/// HOSTILE_PAIRS is the number of pairs, and HOSTILE_FIRST is the number of the first pair.
#[test]
#[ignore = "an hour: a million pairs"]
fn many_hostile_pairs_with_partners_keep_every_claim() {
    let (first, count) = range_from_environment("HOSTILE", (SHORT, LONG));
    report(&Family::ALL, &soaked(first, count));
}
