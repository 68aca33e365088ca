use super::*;
use crate::belief::GridConfig;

fn ahead(forward_m: f64) -> Displacement {
    Displacement {
        forward_m,
        left_m: 0.0,
        turn_rad: 0.0,
    }
}

fn corridor() -> Arc<Grid> {
    Arc::new(Grid::along_route(0.0, 12.0, &GridConfig::default()).unwrap())
}

/// P(ξ_t+1 | ξ_t) of a step as a matrix, `[from][to]`, one row a cell that all mass is put on.
fn transitions(grid: &Arc<Grid>, motion: &OdometryMotion, step: &Displacement) -> Vec<Vec<f64>> {
    let row = |cell: usize| {
        let mut mass = vec![0.0; grid.len()];
        mass[cell] = 1.0;
        let start = Belief::from_mass(grid.places(), mass).unwrap();
        let mut filter = BayesFilter::new(grid, motion.clone(), start).unwrap();
        filter.predict(step).unwrap();
        filter.belief().mass().to_vec()
    };
    (0..grid.len()).map(row).collect()
}

/// Sums over all ways through the cells, by matrices: α of the forward pass, β of the backward one.
fn enumerated(
    grid: &Arc<Grid>,
    motion: &OdometryMotion,
    steps: &[Displacement],
    likelihood: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let n = grid.len();
    let moves: Vec<_> = steps.iter().map(|s| transitions(grid, motion, s)).collect();
    let mut alpha = vec![vec![1.0; n]];
    for (t, matrix) in moves.iter().enumerate() {
        let seen = |cell: usize| alpha[t][cell] * likelihood[t][cell].exp();
        let next = (0..n).map(|to| (0..n).map(|from| seen(from) * matrix[from][to]).sum());
        let next = next.collect();
        alpha.push(next);
    }
    let mut beta = vec![1.0; n];
    let mut smoothed = Vec::new();
    for t in (0..=steps.len()).rev() {
        let mass = (0..n).map(|cell| alpha[t][cell] * likelihood[t][cell].exp() * beta[cell]);
        let mass: Vec<f64> = mass.collect();
        let total: f64 = mass.iter().sum();
        smoothed.push(mass.iter().map(|m| m / total).collect());
        if t > 0 {
            let seen = |to: usize| beta[to] * likelihood[t][to].exp();
            let matrix = &moves[t - 1];
            beta = (0..n)
                .map(|from| (0..n).map(|to| matrix[from][to] * seen(to)).sum())
                .collect();
        }
    }
    smoothed.reverse();
    smoothed
}

fn run(
    grid: &Arc<Grid>,
    steps: &[Displacement],
    likelihood: &[Vec<f64>],
    knowing: Knowing,
) -> Vec<Moment> {
    let mut moments = vec![None; likelihood.len()];
    smooth(
        grid,
        &OdometryMotion::default(),
        Belief::uniform(grid.places()).unwrap(),
        steps,
        knowing,
        &mut |t, _| Ok(likelihood[t].clone()),
        &mut |t, moment| {
            assert!(moments[t].replace(moment).is_none(), "{t} twice");
            Ok(())
        },
    )
    .unwrap();
    moments.into_iter().map(Option::unwrap).collect()
}

/// Doors in three places, one of which is seen at the second moment and another at the last.
fn doors(grid: &Grid) -> (Vec<Displacement>, Vec<Vec<f64>>) {
    let Places::Route(cells) = &**grid.places() else {
        unreachable!()
    };
    let sees = |door: bool| {
        let near = |x: &f64| [3.0, 5.0, 9.0].iter().any(|d: &f64| (x - d).abs() < 0.3);
        let each = cells
            .iter()
            .map(|x| if near(x) == door { 0.9_f64 } else { 0.002 }.ln());
        each.collect()
    };
    let likelihood = [false, true, false, true].map(sees).to_vec();
    (vec![ahead(0.8), ahead(1.0), ahead(1.0)], likelihood)
}

#[test]
fn it_is_the_sum_over_all_ways() {
    let grid = corridor();
    let (steps, likelihood) = doors(&grid);
    let expected = enumerated(&grid, &OdometryMotion::default(), &steps, &likelihood);
    let found = run(&grid, &steps, &likelihood, Knowing::TheRun);
    for (t, (moment, expected)) in found.iter().zip(&expected).enumerate() {
        let off: f64 = moment
            .belief
            .mass()
            .iter()
            .zip(expected)
            .map(|(a, b)| (a - b).abs())
            .sum();
        assert!(off < 0.02, "moment {t}: {off}"); // the border alone
    }
    // What the filter knows of the first moment is less.
    let filtered = run(&grid, &steps, &likelihood, Knowing::ThePast);
    assert!(found[0].belief.entropy() < filtered[0].belief.entropy() - 0.5);
    let last = [&found[3], &filtered[3]].map(|m| m.belief.mass().to_vec());
    let off: f64 = last[0]
        .iter()
        .zip(&last[1])
        .map(|(a, b)| (a - b).abs())
        .sum();
    assert!(off < 1e-5, "{off}"); // at the end both know all
}

#[test]
fn the_others_judge_an_observation() {
    let grid = corridor();
    let (steps, mut likelihood) = doors(&grid);
    let ratio = |likelihood: &[Vec<f64>], t: usize| {
        let moment = &run(&grid, &steps, likelihood, Knowing::TheRun)[t];
        moment.by_others - moment.anywhere
    };
    assert!(ratio(&likelihood, 1) > 0.1);
    // Between two doors that are two metres apart there is half a third one all of a sudden.
    likelihood[2] = likelihood[1].iter().map(|l| 0.5 * l).collect();
    assert!(ratio(&likelihood, 2) < -0.1);
}

#[test]
fn a_robot_that_was_carried_is_contradicted_from_both_sides() {
    let grid = corridor();
    let at = |x_m: f64| {
        let Places::Route(cells) = &**grid.places() else {
            unreachable!()
        };
        let each = cells.iter().map(|x| -0.5 * ((x - x_m) / 0.1).powi(2));
        each.collect::<Vec<f64>>()
    };
    let likelihood = [at(2.0), at(2.5), at(10.0), at(10.5)];
    let moments = run(&grid, &[ahead(0.5); 3], &likelihood, Knowing::TheRun);
    assert!(moments.iter().all(|m| m.by_others < m.anywhere - 8.0));
    // Where both exclude each other its belief is the filter's.
    assert_eq!(moments[1].by_others, f64::NEG_INFINITY);
    assert!((moments[1].belief.mean().x_m - 2.5).abs() < 0.1);
}

#[test]
fn a_movement_back_leads_back() {
    let turned = Displacement {
        forward_m: 1.0,
        left_m: 0.2,
        turn_rad: 1.4,
    };
    let plane = Places::Plane(vec![Pose::default()]);
    let back = Pose::default()
        .after(turned)
        .after(reversed(&turned, &plane));
    assert!(back.distance_m(&Pose::default()) < 1e-12 && back.heading_rad.abs() < 1e-12);
    let route = Places::Route(vec![0.0]);
    let back = reversed(&turned, &route);
    assert!((back.forward_m + turned.distance_m()).abs() < 1e-12 && back.left_m == 0.0);
}
