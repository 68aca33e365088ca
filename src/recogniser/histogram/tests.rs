use super::*;
use crate::recogniser::occupancy::{State, blotched};

/// Duckett & Nehmzow's formula, cell states counted one by one and translations tried one by one.
fn brute_force(place: &States, scan: &States, columns: bool, reach: i32) -> u32 {
    let counts = |states: &States, j: i32| {
        let mut counts = [0u32; 3];
        for i in 0..CELLS {
            let state = match usize::try_from(j) {
                Ok(j) if j < CELLS && columns => states.at(j, i),
                Ok(j) if j < CELLS => states.at(i, j),
                _ => State::Unknown,
            };
            counts[state as usize] += 1;
        }
        counts
    };
    let translated = |by: i32| -> u32 {
        (0..CELLS as i32)
            .flat_map(|j| {
                let (stored, moved) = (counts(place, j), counts(scan, j - by));
                (0..3).map(move |kind| stored[kind].min(moved[kind]))
            })
            .sum()
    };
    (-reach..=reach).map(translated).max().unwrap()
}

#[test]
fn the_best_match_is_that_of_a_plain_loop_over_all_translations() {
    let mut moved = 0;
    for index in 0..12 {
        let (place, scan) = (blotched(index), blotched(index + 100));
        let (stored, sought) = (HistogramPair::of(&place), HistogramPair::of(&scan));
        for reach in [0, 1, 5, 7, 8, 15, 16, 31, 32, 62, 63] {
            let best = Sought::new(&sought, reach as usize).best_match(&stored);
            let by_hand = |columns| brute_force(&place, &scan, columns, reach);
            assert_eq!(
                [best.x, best.y],
                [true, false].map(by_hand),
                "{index} {reach}"
            );
        }
        let best = Sought::new(&sought, 63).best_match(&stored);
        moved += u32::from(best.x > sought.x.match_with(&stored.x));
        let by_moving = (-63..64).map(|by| stored.y.match_with(&sought.y.moved(by)));
        assert_eq!(Some(best.y), by_moving.max());
    }
    assert!(moved > 6, "translation hardly ever matters here: {moved}");
}

#[test]
fn a_histogram_matches_itself_in_all_4096_cells() {
    for index in 0..5 {
        let pair = HistogramPair::of(&blotched(index));
        let best = Sought::new(&pair, 5).best_match(&pair);
        assert_eq!((best.x, best.y, best.product()), (4096, 4096, 16_777_216));
        assert_eq!(pair.x.match_with(&pair.x), FULL_MATCH);
    }
}

#[test]
fn a_moved_scan_is_found_again_but_for_what_left_the_grid() {
    let pair = HistogramPair::of(&States::from_fn(|x, y| match (x, y) {
        (30, _) => State::Occupied,
        (20..30, _) => State::Empty,
        _ => State::Unknown,
    }));
    let at = |by: i32| HistogramPair {
        x: pair.x.moved(by),
        y: pair.y.clone(),
    };
    for by in [-20, -3, 0, 17, 33] {
        assert_eq!(
            Sought::new(&at(by), 63).best_match(&pair).x,
            FULL_MATCH,
            "{by}"
        );
    }
    // From one edge to the other, as far as anything still overlaps.
    let edge = |at: usize| {
        let states = States::from_fn(|x, y| match x == at && y == at {
            true => State::Occupied,
            false => State::Unknown,
        });
        HistogramPair::of(&states)
    };
    for (stored, sought) in [(edge(0), edge(63)), (edge(63), edge(0))] {
        assert_eq!(stored.x.match_with(&sought.x), FULL_MATCH - 2);
        assert_eq!(
            Sought::new(&sought, 63).best_match(&stored).product(),
            16_777_216
        );
    }
    // Pushed out by 40: the wall and six more columns are lost; they were known and are unknown now.
    let lost = Sought::new(&at(40), 63).best_match(&pair);
    assert_eq!(lost.x, FULL_MATCH - 7 * 64);
}

#[test]
fn a_quarter_turn_of_the_grid_is_one_of_its_histograms() {
    let states = blotched(3);
    let turned = HistogramPair::of(&states.quarter_turn());
    assert_eq!(HistogramPair::of(&states).quarter_turn(), turned);
    let round = (0..4).fold(states.clone(), |states, _| states.quarter_turn());
    assert_eq!(round, states);
    assert_ne!(states.quarter_turn(), states);
}

#[test]
fn many_places_at_once_are_matched_as_one_by_one() {
    let places: Vec<HistogramPair> = (0..9).map(|i| HistogramPair::of(&blotched(i))).collect();
    let sought = Sought::new(&HistogramPair::of(&blotched(50)), 5);
    let mut best = vec![PairMatch { x: 0, y: 0 }; places.len()];
    sought.best_matches(&places, &mut best);
    let alone: Vec<PairMatch> = places.iter().map(|p| sought.best_match(p)).collect();
    assert_eq!(best, alone);
}
