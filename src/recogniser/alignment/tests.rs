use super::*;
use crate::{
    recogniser::{
        local_scan::{LocalScans, ScanConfig},
        occupancy::blotched,
    },
    recording::{Recording, npz},
};

fn cells(states: &States) -> Vec<State> {
    let at = |i: usize| states.at(i % CELLS, i / CELLS);
    (0..CELLS * CELLS).map(at).collect()
}

fn exhaustive(stored: &States, sought: &States, reach: i32) -> Alignment {
    let (stored, sought) = (cells(stored), cells(sought));
    let at = |right, up| Alignment {
        right,
        up,
        agreement: agreement(&stored, &sought, right, up),
    };
    let mut best = at(0, 0);
    for up in -reach..=reach {
        for right in -reach..=reach {
            let next = at(right, up);
            if next.beats(&best) {
                best = next;
            }
        }
    }
    best
}

/// The best of hill climbs from every so many cells.
fn hill_climbs(stored: &States, sought: &States, reach: i32, spacing: i32) -> Alignment {
    let (stored, sought) = (cells(stored), cells(sought));
    let starts = || (-reach / spacing..=reach / spacing).map(|i| i * spacing);
    let all = starts().flat_map(|up| starts().map(move |right| (right, up)));
    let climbed = all.map(|start| hill_climb(&stored, &sought, start, reach));
    climbed
        .reduce(|a, b| if b.beats(&a) { b } else { a })
        .unwrap()
}

/// Scans of the recording that comes with the crate, their walls along the axes.
fn scans(count: usize) -> Vec<States> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/corridor-small.npz");
    let recording: Recording = npz::read(path.as_ref()).unwrap();
    let config = ScanConfig::default();
    let scans = LocalScans::new(&config, recording.channels(), false).unwrap();
    let every = recording.len() / count;
    let of = |i: usize| {
        let observation = recording.observation(i * every);
        scans.grid(recording.channels(), &observation)
    };
    (0..count).filter_map(of).collect()
}

#[test]
fn cells_beyond_the_edge_are_unknown() {
    let stored = States::from_fn(|x, _| match x {
        0 => State::Occupied,
        _ => State::Unknown,
    });
    let sought = States::UNKNOWN;
    // 64 of 4096 cells differ; the same with the sought wall pushed out to the left.
    assert_eq!(agreement(&cells(&stored), &cells(&sought), 0, 0), 4032);
    assert_eq!(agreement(&cells(&stored), &cells(&stored), -1, 0), 4032);
    assert_eq!(
        agreement(&cells(&stored), &cells(&stored), 1, 0),
        4096 - 128
    );
    assert_eq!(agreement(&cells(&stored), &cells(&stored), 0, 3), 4096 - 3);
}

#[test]
fn the_bounded_search_finds_what_looking_at_all_translations_finds() {
    for index in 0..10 {
        let (stored, sought) = (blotched(index), blotched(index + 50));
        for reach in [0, 9, 63] {
            if reach == 63 && index > 2 {
                continue; // 16,129 translations by hand take their time
            }
            let best = exhaustive(&stored, &sought, reach);
            let ready = SoughtGrid::new(&sought, reach as usize);
            assert_eq!(
                ready.align(&stored, 0),
                Some(best),
                "{index}, reach {reach}"
            );
            // Asked for more than there is, or for just less.
            assert_eq!(ready.align(&stored, best.agreement), None);
            assert_eq!(ready.align(&stored, best.agreement - 1), Some(best));
            assert_eq!(ready.align(&stored, u32::MAX), None);
        }
    }
}

#[test]
fn no_translation_beats_its_groups_bound() {
    for index in 0..6 {
        let (stored, sought) = (blotched(index), blotched(index + 50));
        let ready = SoughtGrid::new(&sought, 63);
        let (stored_cells, sought_cells) = (cells(&stored), cells(&sought));
        let mut tight = 0;
        for (right, possible) in groups(63).zip(&ready.groups).step_by(4) {
            for up in groups(63).step_by(3) {
                let bound = possible.bound(&stored, up);
                let group =
                    (right..right + GROUP).flat_map(|r| (up..up + GROUP).map(move |u| (r, u)));
                let all = group.map(|(r, u)| agreement(&stored_cells, &sought_cells, r, u));
                let most = all.max().unwrap();
                assert!(most <= bound, "({right}, {up}): {most} > {bound}");
                tight += u32::from(bound - most < 600);
            }
        }
        assert!(tight > 40, "the bounds hardly bound: {tight}");
    }
}

/// A cell that fits equally well four cells to the left and three to the right; the groups of both promise no more than that.
#[test]
fn of_equally_good_translations_the_shortest_is_told() {
    let spots = |at: &'static [usize]| {
        States::from_fn(|x, y| match y == 30 && at.contains(&x) {
            true => State::Occupied,
            false => State::Unknown,
        })
    };
    let sought = SoughtGrid::new(&spots(&[30]), 16);
    let found = sought.align(&spots(&[26, 33]), 0).unwrap();
    assert_eq!((found.right, found.up, found.agreement), (3, 0, 4095));
    let found = sought.align(&spots(&[27, 34]), 0).unwrap();
    assert_eq!((found.right, found.up, found.agreement), (-3, 0, 4095));
}

#[test]
fn climbing_on_bit_planes_climbs_the_same_way() {
    for index in 0..6 {
        let (stored, sought) = (blotched(index), blotched(index + 50));
        let ready = SoughtGrid::new(&sought, 20);
        for start in [(0, 0), (-20, 20), (7, -3)] {
            let plain = hill_climb(&cells(&stored), &cells(&sought), start, 20);
            let on_planes = ready.hill_climb(&stored, start);
            assert_eq!(plain, on_planes, "{index} from {start:?}");
        }
    }
}

/// On scans, hill climbs from every fourth cell end where the bounded search ends; one climb alone often ends short of it.
#[test]
fn on_scans_the_bounded_search_agrees_with_hill_climbs_from_everywhere() {
    let scans = scans(12);
    let (mut pairs, mut agree, mut alone) = (0, 0, 0);
    for (i, stored) in scans.iter().enumerate() {
        let sought = &scans[(i + 1) % scans.len()];
        let aligned = SoughtGrid::new(sought, 16).align(stored, 0);
        let climbed = hill_climbs(stored, sought, 16, 4);
        let first = hill_climb(&cells(stored), &cells(sought), (0, 0), 16);
        let aligned = aligned.unwrap();
        assert!(aligned.agreement >= climbed.agreement);
        pairs += 1;
        agree += usize::from(aligned == climbed);
        alone += usize::from(aligned == first);
    }
    assert!(
        pairs >= 10 && agree == pairs,
        "{agree} of {pairs}, {alone} from the middle alone"
    );
}
