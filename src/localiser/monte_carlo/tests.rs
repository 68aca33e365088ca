mod refused;

use super::*;
use crate::{
    belief::{BayesFilter, Belief, GridConfig},
    localiser::{LocaliserConfig, laws, likelihood_field::FieldOverGrid},
    mapping::{LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig, RangeSensors},
    recogniser::test_world::test_world,
    recording::Columns,
    registry::Constants,
    seed::Seed,
};
use serde::Serialize;

const LAP: usize = 104;

fn map_of(recording: &Recording, snapshots: &[usize]) -> Result<Arc<LikelihoodField>> {
    // The sonars of this world are rays.
    let config = OccupancyMapConfig {
        sensors: RangeSensors::default().as_rays(),
        ..OccupancyMapConfig::default()
    };
    let map = OccupancyMap::from_scans(recording, snapshots, &config)?;
    Ok(Arc::new(LikelihoodField::new(
        &map,
        &LikelihoodFieldConfig::default(),
    )?))
}

fn grid_over(recording: &Recording, config: &GridConfig) -> Arc<Grid> {
    let poses = recording.poses()[..LAP].to_vec();
    Arc::new(Grid::over(&Places::Plane(poses), config).unwrap())
}

/// The room, mapped on its first lap.
fn room(recording: &Recording, config: MonteCarloConfig) -> MonteCarlo {
    let mapped: Vec<usize> = (0..LAP).collect();
    let field = map_of(recording, &mapped).unwrap();
    let grid = grid_over(recording, &GridConfig::default());
    MonteCarlo::new(field, OdometryMotion::default(), grid, config).unwrap()
}

fn play(
    monte_carlo: &MonteCarlo,
    recording: &Recording,
    trial: &[usize],
    start: Option<Pose>,
    seed: u64,
) -> Vec<Step> {
    let player = monte_carlo.prepare(recording, trial).unwrap();
    let mut stream = Seed(seed).stream("a trial");
    player.play(trial, start, &mut stream).unwrap()
}

fn expected_error_m(step: &Step, truth: &Pose) -> f64 {
    let off_m = |place: &[f64; 2]| (place[0] - truth.x_m).hypot(place[1] - truth.y_m);
    step.posterior
        .iter()
        .map(|(place, p)| p * off_m(place))
        .sum()
}

fn point_error_m(step: &Step, truth: &Pose) -> f64 {
    let Some(Estimate::Place([x_m, y_m])) = step.estimate else {
        panic!("no place")
    };
    (x_m - truth.x_m).hypot(y_m - truth.y_m)
}

/// Expected errors of the grid's filter with the same motion and likelihood, on fine cells.
fn errors_on_cells_m(
    monte_carlo: &MonteCarlo,
    recording: &Recording,
    trial: &[usize],
    start: Option<Pose>,
) -> Vec<f64> {
    let fine = GridConfig {
        cell_m: 0.1,
        headings: 48,
        ..GridConfig::default()
    };
    let grid = grid_over(recording, &fine);
    let config = &monte_carlo.config;
    let prior = match start {
        Some(start) => Belief::around(
            grid.places(),
            &Places::Plane(vec![start]),
            0,
            config.start_spread_m,
            config.start_spread_rad,
        ),
        None => Belief::uniform(grid.places()),
    };
    let over_grid = FieldOverGrid::new(&monte_carlo.field, &grid).unwrap();
    let mut filter = BayesFilter::new(&grid, monte_carlo.motion.clone(), prior.unwrap()).unwrap();
    let truths = Places::Plane(recording.poses().to_vec());
    let mut last: Option<Pose> = None;
    let error_m = |&k: &usize| {
        let observation = recording.observation(k);
        if let Some(last) = last.replace(observation.odometry) {
            let step = last.displacement_to(&observation.odometry);
            filter.predict(&step).unwrap();
        }
        let beams = monte_carlo
            .field
            .beams(recording.channels(), &observation)
            .unwrap();
        let said = over_grid.log_likelihood(&beams);
        let scaled = |l: &f32| monte_carlo.scale * f64::from(*l);
        let said: Vec<f64> = said.iter().map(scaled).collect();
        filter.correct(&said).unwrap();
        filter.belief().expected_error_m(&truths, k)
    };
    trial.iter().map(error_m).collect()
}

fn plenty() -> MonteCarloConfig {
    MonteCarloConfig {
        particles: 20_000,
        least_particles: 20_000,
        slow_decay: 0.0,
        fast_decay: 0.0,
        ..MonteCarloConfig::default()
    }
}

/// On the room's second lap.
fn trials() -> [Vec<usize>; 2] {
    [104..134, 160..190].map(Iterator::collect)
}

#[test]
fn the_heading_is_found_with_the_place() {
    let recording = test_world();
    let monte_carlo = room(&recording, plenty());
    for trial in trials() {
        let steps = play(&monte_carlo, &recording, &trial, None, 1);
        let (step, truth) = (steps.last().unwrap(), recording.poses()[trial[29]]);
        assert!(point_error_m(step, &truth) < 0.3);
        let off = wrapped(step.heading_rad.unwrap() - truth.heading_rad).abs();
        assert!(off.to_degrees() < 5.0, "{}", off.to_degrees());
    }
}

#[test]
fn the_power_of_the_evidence_can_be_tuned_unless_it_is_stated() {
    let recording = test_world();
    let usual = room(&recording, MonteCarloConfig::default());
    assert_eq!(usual.evidence_scale(), Some(0.2));
    let tuned = usual.with_evidence_scale(0.5).unwrap();
    assert_eq!(tuned.evidence_scale(), Some(0.5));
    let stated = MonteCarloConfig {
        evidence_scale: Some(0.5),
        ..MonteCarloConfig::default()
    };
    let stated = room(&recording, stated);
    assert!(stated.with_evidence_scale(0.1).is_none());
    // Tuned to what another has stated, it answers the same.
    let trial = &trials()[0][..5];
    let of = |localiser: &dyn Localiser| {
        let player = localiser.prepare(&recording, trial).unwrap();
        player
            .play(trial, None, &mut Seed(1).stream("a trial"))
            .unwrap()
    };
    assert_eq!(of(tuned.as_ref()), of(&stated));
    assert_ne!(of(&usual), of(&stated));
}

#[test]
fn from_a_known_start_it_is_as_far_off_as_the_filter_on_fine_cells() {
    let recording = test_world();
    let monte_carlo = room(&recording, plenty());
    for trial in trials() {
        let start = Some(recording.poses()[trial[0]]);
        let on_cells = errors_on_cells_m(&monte_carlo, &recording, &trial, start);
        let steps = play(&monte_carlo, &recording, &trial, start, 1);
        for ((&k, step), on_cells_m) in trial.iter().zip(&steps).zip(&on_cells) {
            let error_m = expected_error_m(step, &recording.poses()[k]);
            // A fifth of a cell; both are 0.1 m and more.
            let agree = (error_m - on_cells_m).abs() < 0.02;
            assert!(agree, "{k}: {error_m}, {on_cells_m}");
        }
    }
}

#[test]
fn from_anywhere_it_is_mostly_as_far_off_as_the_filter_on_fine_cells() {
    let recording = test_world();
    let monte_carlo = room(&recording, plenty());
    let (mut played, mut agree) = (0, 0);
    for trial in trials() {
        let on_cells = errors_on_cells_m(&monte_carlo, &recording, &trial, None);
        assert!(on_cells[0] > 5.0 && on_cells[29] < 0.12, "{on_cells:?}");
        for seed in 0..5 {
            let steps = play(&monte_carlo, &recording, &trial, None, seed);
            let error_m = |i: usize| expected_error_m(&steps[i], &recording.poses()[trial[i]]);
            // Before particles have been drawn anew they sample the cells' belief: within 3 %.
            let at_first = (error_m(0) / on_cells[0] - 1.0).abs() < 0.03;
            let at_last = (20..30).all(|i| (error_m(i) - on_cells[i]).abs() < 0.03);
            played += 1;
            agree += usize::from(at_first && at_last);
        }
    }
    assert!(agree >= 8, "{agree} of {played}");
}

/// The room's second lap, on which somebody carries the robot from snapshot 134 to where 175 was taken: odometry does not
/// notice.
fn kidnapped() -> (Recording, Vec<usize>) {
    let mut columns = test_world().into_columns();
    let carried = {
        let [from, to] = [134, 175].map(|k| columns.odometry[k]);
        [to.x_m - from.x_m, to.y_m - from.y_m]
    };
    for odometry in &mut columns.odometry[175..] {
        odometry.x_m -= carried[0];
        odometry.y_m -= carried[1];
    }
    let trial = (104..134).chain(175..208).collect();
    (Recording::new(columns).unwrap(), trial)
}

#[test]
fn a_kidnapped_robot_recovers_by_random_particles() {
    let (recording, trial) = kidnapped();
    let start = Some(recording.poses()[trial[0]]);
    let found = |config: &MonteCarloConfig| {
        let monte_carlo = room(&recording, config.clone());
        let is_found = |seed: &u64| {
            let steps = play(&monte_carlo, &recording, &trial, start, *seed);
            // When it is carried away, and at the end.
            [29, trial.len() - 1]
                .into_iter()
                .all(|at| point_error_m(&steps[at], &recording.poses()[trial[at]]) < 0.3)
        };
        (0..10).filter(is_found).count()
    };
    let config = MonteCarloConfig::default();
    let never = MonteCarloConfig {
        slow_decay: 0.0,
        fast_decay: 0.0,
        ..config.clone()
    };
    let (with, without) = (found(&config), found(&never));
    assert!(with >= 9 && without <= 1, "{with}, {without} of 10");
}

#[test]
fn it_draws_fewer_particles_once_it_knows_where_it_is() {
    let recording = test_world();
    let monte_carlo = room(&recording, MonteCarloConfig::default());
    let mut stream = Seed(1).stream("a trial");
    let mut robot = Robot::new(&monte_carlo, None, &mut stream);
    assert_eq!(robot.particles.poses().len(), 5000);
    let mut counts = Vec::new();
    for k in 104..150 {
        let observation = recording.observation(k);
        let beams = monte_carlo
            .field
            .beams(recording.channels(), &observation)
            .unwrap();
        robot
            .observe(observation.odometry, &beams, &mut stream)
            .unwrap();
        counts.push(robot.particles.poses().len());
    }
    assert!(*counts.last().unwrap() < 1000, "{counts:?}");
}

#[test]
fn answers_do_not_depend_on_the_number_of_threads() {
    let recording = test_world();
    let monte_carlo = room(&recording, MonteCarloConfig::default());
    let trial: Vec<usize> = (120..140).collect();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| play(&monte_carlo, &recording, &trial, None, 1))
    };
    let once = on(1);
    assert!(once == on(3), "on three threads");
    assert!(once == play(&monte_carlo, &recording, &trial, None, 1));
    assert!(once != play(&monte_carlo, &recording, &trial, None, 2));
}

/// Moved by normal deviates as wide as stated, but not off the grid, and not at all where nothing is stated.
#[test]
fn particles_drawn_anew_are_moved_a_little() {
    let recording = test_world();
    let pose = recording.poses()[120];
    let roughened = |roughening_m: f64, roughening_deg: f64| {
        let config = MonteCarloConfig {
            roughening_m,
            roughening_rad: roughening_deg.to_radians(),
            ..MonteCarloConfig::default()
        };
        let monte_carlo = room(&recording, config);
        let mut stream = Seed(1).stream("roughening");
        let moved = (0..4000).map(|_| monte_carlo.roughened(pose, &mut stream));
        let moved: Vec<Pose> = moved.collect();
        let on_grid = |pose: &Pose| monte_carlo.grid.cell_of(pose).is_some();
        assert!(moved.iter().all(on_grid));
        moved
    };
    assert!(roughened(0.0, 0.0).iter().all(|moved| *moved == pose));
    let moved = roughened(0.05, 2.0);
    let sd = |off: &dyn Fn(&Pose) -> f64| {
        let squares: f64 = moved.iter().map(|moved| off(moved).powi(2)).sum();
        (squares / moved.len() as f64).sqrt()
    };
    assert!((sd(&|moved| moved.x_m - pose.x_m) - 0.05).abs() < 0.005);
    assert!((sd(&|moved| moved.y_m - pose.y_m) - 0.05).abs() < 0.005);
    let turn = sd(&|moved| wrapped(moved.heading_rad - pose.heading_rad));
    assert!(
        (turn.to_degrees() - 2.0).abs() < 0.1,
        "{}",
        turn.to_degrees()
    );
    // Far outside there is no place to be.
    let wide = roughened(50.0, 0.0);
    assert!(wide.iter().filter(|moved| **moved == pose).count() > 1000);
}

/// Maps what it learns from.
#[derive(Debug, Clone, Serialize)]
struct Mapped(MonteCarloConfig);

impl Constants for Mapped {
    fn kind(&self) -> &'static str {
        "monte_carlo"
    }
}

impl LocaliserConfig for Mapped {
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Box<dyn Localiser>> {
        let grid = grid_over(recording, &GridConfig::default());
        let field = map_of(recording, snapshots)?;
        let motion = OdometryMotion::default();
        let monte_carlo = MonteCarlo::new(field, motion, grid, self.0.clone())?;
        Ok(Box::new(monte_carlo.with_sensors_of(recording.channels())?))
    }
}

#[test]
fn it_keeps_the_laws() {
    let [mapping, trial] = [0..LAP, 130..170].map(Iterator::collect::<Vec<usize>>);
    let config = Mapped(MonteCarloConfig {
        particles: 1000,
        ..MonteCarloConfig::default()
    });
    laws::check(&config, &test_world(), &mapping, &trial).unwrap();
}

#[test]
fn a_start_off_the_grid_is_taken_to_the_nearest_cell() {
    let recording = test_world();
    let monte_carlo = room(&recording, MonteCarloConfig::default());
    let start = Some(Pose::new(-20.0, 0.5, 0.0));
    let steps = play(&monte_carlo, &recording, &[104], start, 1);
    let nearest = Pose::new(-0.5, 0.5, 0.0);
    assert!(
        point_error_m(&steps[0], &nearest) < 0.3,
        "{:?}",
        steps[0].estimate
    );
}
