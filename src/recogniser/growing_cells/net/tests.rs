use super::*;
use crate::seed::Seed;
use rand::RngExt;

#[track_caller]
fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-6, "{found:?}");
}

const RATES: Rates = Rates {
    best: 0.5,
    neighbour: 0.1,
    decay: 0.1,
};

/// Two signals into a triangle, as the trace below has it.
fn traced() -> Net {
    let mut net = Net::triangle([vec![0.0, 0.0], vec![4.0, 0.0], vec![0.0, 2.0]]);
    net.adapt(&[4.0, 1.0], &RATES);
    net.adapt(&[0.0, 0.0], &RATES);
    net
}

#[test]
fn adaptation_as_traced_by_hand() {
    // (4, 1) is nearest to cell 1: cell 1 goes half the way, to (4, .5), cell 0 a tenth, to (.4, .1), and cell 2 to
    // (.4, 1.9); τ = (0, 1, 0), after decay (0, .9, 0). Then (0, 0) is nearest to cell 0.
    let net = traced();
    near(&net.weights[0], &[0.2, 0.05]);
    near(&net.weights[1], &[3.6, 0.45]);
    near(&net.weights[2], &[0.36, 1.71]);
    near(&net.signals, &[0.9, 0.81, 0.0]);
}

#[test]
fn insertion_as_traced_by_hand() {
    // q = 0 (τ = .9); its edges are √11.72 = 3.423449 to cell 1 and √2.7812 = 1.667693 to cell 2: f = 1.
    // w_3 = ((.2 + 3.6)/2, (.05 + .45)/2). Regions before and after, mean edge squared:
    //   cell 0: ((3.423449 + 1.667693)/2)² = 6.479931,  ((1.711724 + 1.667693)/2)² = 2.855115
    //   cell 1: ((3.423449 + 3.476377)/2)² = 11.901900, ((1.711724 + 3.476377)/2)² = 6.729100
    // so cell 0 keeps .9 · 2.855115/6.479931 of its signals, cell 1 .81 · 6.729100/11.901900, and cell 3 has the rest.
    let mut net = traced();
    net.insert();
    near(&net.weights[3], &[1.9, 0.25]);
    near(&net.signals, &[0.396548, 0.457958, 0.0, 0.855494]);
    assert_eq!(net.triangles, [[0, 2, 3], [1, 2, 3]]);
    assert_eq!(net.neighbours(0), [2, 3]);
    assert_eq!(net.neighbours(3), [0, 1, 2]);
    net.check(2).unwrap();
}

/// Two triangles with an edge in common, all edges about as long.
fn diamond(signals: [f64; 4]) -> Net {
    let at = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.9], [1.5, 0.9]];
    Net {
        weights: at.map(|w| w.to_vec()).to_vec(),
        signals: signals.to_vec(),
        triangles: vec![[0, 1, 2], [1, 2, 3]],
    }
}

#[test]
fn a_cell_that_nothing_signals_goes_with_its_triangles() {
    let mut net = diamond([0.0, 4.0, 4.0, 5.0]);
    net.remove_superfluous(0.0);
    assert_eq!(net, diamond([0.0, 4.0, 4.0, 5.0]), "η = 0 removes nothing");
    net.remove_superfluous(0.09);
    assert_eq!(net.len(), 3);
    assert_eq!(net.triangles, [[0, 1, 2]]);
    assert_eq!(net.weights[0], [1.0, 0.0]);
    assert_eq!(net.signals, [4.0, 4.0, 5.0]);
    net.check(2).unwrap();
}

#[test]
fn density_is_judged_relative_to_the_net() {
    // All edges are 1 or 1.0296 long: cell 0 has about 1.03² of 4.2 of the space. 9 % of the mean density is .1 of 4.5
    // signals or so.
    for (signals, kept) in [(0.05, 3), (0.2, 4)] {
        let mut net = diamond([signals, 1.5, 1.5, 1.5]);
        net.remove_superfluous(0.09);
        assert_eq!(net.len(), kept, "{signals}");
    }
    // The same net a thousand times as large, and signalled as often.
    let mut large = diamond([0.05, 1.5, 1.5, 1.5]);
    large
        .weights
        .iter_mut()
        .flatten()
        .for_each(|w| *w *= 1000.0);
    large.remove_superfluous(0.09);
    assert_eq!(large.len(), 3);
}

#[test]
fn cells_left_without_a_triangle_go_too_and_the_last_triangle_stays() {
    // A fan: triangles 012 and 234 share cell 2 alone. Without 3 there is no 4 either.
    let at = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.5], [2.0, 0.0], [2.0, 1.0]];
    let mut net = Net {
        weights: at.map(|w| w.to_vec()).to_vec(),
        signals: vec![1.0, 1.0, 1.0, 0.0, 9.0],
        triangles: vec![[0, 1, 2], [2, 3, 4]],
    };
    net.remove_superfluous(0.09);
    assert_eq!((net.len(), net.triangles.clone()), (3, vec![[0, 1, 2]]));
    net.signals = vec![0.0, 1.0, 1.0];
    net.remove_superfluous(0.09);
    assert_eq!(net.len(), 3);
    // Cell 1 is in both triangles: without it there would be none.
    let mut net = diamond([3.0, 0.0, 3.0, 3.0]);
    net.remove_superfluous(0.09);
    assert_eq!(net.len(), 4);
}

#[test]
fn growing_keeps_the_net_whole_and_the_signals_counted() {
    // Signals from two discs far apart: removal takes out what spans the gap.
    let mut random = Seed(2).stream("discs");
    let corner = |x: f64, y: f64| vec![x, y];
    let mut net = Net::triangle([corner(0.0, 0.0), corner(9.0, 0.0), corner(4.0, 3.0)]);
    let rates = Rates {
        best: 0.06,
        neighbour: 0.002,
        decay: 0.005,
    };
    let disc = |w: &Vec<f64>| w[0].hypot(w[1]).min((w[0] - 9.0).hypot(w[1]));
    let outside = |net: &Net| net.weights.iter().filter(|w| disc(w) > 1.2).count();
    let (mut removed, mut spanning) = (0, 0);
    for _ in 0..3 {
        while net.len() < 40 {
            for _ in 0..100 {
                let (turn, far): (f64, f64) = (random.random_range(0.0..7.0), random.random());
                let disc = if random.random() { 0.0 } else { 9.0 };
                net.adapt(&[disc + far * turn.cos(), far * turn.sin()], &rates);
            }
            let sum = |net: &Net| net.signals.iter().sum::<f64>();
            let (before, cells) = (sum(&net), net.len());
            net.insert();
            assert_eq!(net.len(), cells + 1);
            assert!((sum(&net) - before).abs() < 1e-9);
            net.check(2).unwrap();
        }
        spanning += outside(&net);
        removed += net.remove_superfluous(0.09);
        net.check(2).unwrap();
    }
    assert!(spanning > 0 && removed > 0, "{spanning}, {removed}");
    assert!(net.len() > 30 && outside(&net) == 0, "{}", net.len());
    let left = net.weights.iter().filter(|w| w[0] < 4.5).count();
    assert!(left > 8 && left + 8 < net.len(), "{left} of {}", net.len());
}
