//! What Monte Carlo localisation does not work with.

use super::*;

#[test]
fn other_sensors_are_refused_by_name() {
    let recording = test_world();
    let any = room(&recording, MonteCarloConfig::default());
    let with = |change: &dyn Fn(&mut Channel)| {
        let mut channels = recording.channels().to_vec();
        change(&mut channels[0]);
        channels
    };
    let renamed = with(&|channel| channel.name = "laser".into());
    let turned = with(&|channel| {
        channel
            .bearing_rad
            .iter_mut()
            .flatten()
            .for_each(|b| *b += 0.1)
    });
    let blind = with(&|channel| channel.bearing_rad = None);
    assert!(any.check_channels(&renamed).is_ok() && any.check_channels(&turned).is_ok());
    let refused = |monte_carlo: &MonteCarlo, channels: &[Channel], words: &str| {
        let error = monte_carlo
            .check_channels(channels)
            .unwrap_err()
            .to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(
        &any,
        &blind,
        "no channel among sonar is in metres and has bearings",
    );
    assert!(any.clone().with_sensors_of(&blind).is_err());
    let own = any.with_sensors_of(recording.channels()).unwrap();
    own.check_channels(recording.channels()).unwrap();
    refused(&own, &renamed, "no channel `sonar`");
    refused(&own, &turned, "channel `sonar` has other beams");
    let blind = Recording::new(Columns {
        channels: blind,
        ..recording.clone().into_columns()
    });
    assert!(own.prepare(&blind.unwrap(), &[0]).is_err());
}

#[test]
fn a_grid_along_a_route_and_senseless_constants_are_refused() {
    let recording = test_world();
    let field = map_of(&recording, &(0..LAP).collect::<Vec<_>>()).unwrap();
    let refused = |grid: Arc<Grid>, motion: OdometryMotion, config: MonteCarloConfig| {
        MonteCarlo::new(Arc::clone(&field), motion, grid, config).unwrap_err()
    };
    let route = Grid::along_route(0.0, 10.0, &GridConfig::default()).unwrap();
    let error = refused(
        Arc::new(route),
        OdometryMotion::default(),
        MonteCarloConfig::default(),
    );
    assert!(
        error.to_string().contains("along a route; expected"),
        "{error}"
    );
    let plane = grid_over(&recording, &GridConfig::default());
    let motion = OdometryMotion {
        stall_probability: 2.0,
        ..OdometryMotion::default()
    };
    let error = refused(Arc::clone(&plane), motion, MonteCarloConfig::default());
    assert!(error.to_string().contains("stall_probability"), "{error}");
    let with = |key: &str, change: fn(&mut MonteCarloConfig)| {
        let mut config = MonteCarloConfig::default();
        change(&mut config);
        let error = refused(Arc::clone(&plane), OdometryMotion::default(), config);
        let names_key = error.to_string().contains(&format!("monte_carlo.{key} ="));
        assert!(error.is_usage() && names_key, "{error}");
    };
    with("particles", |c| c.particles = 0);
    with("least_particles", |c| c.least_particles = 0);
    with("least_particles", |c| c.least_particles = 5001);
    with("kld_error", |c| c.kld_error = 0.0);
    with("kld_quantile", |c| c.kld_quantile = f64::NAN);
    with("kld_bin_m", |c| c.kld_bin_m = -1.0);
    with("kld_bin_rad", |c| c.kld_bin_rad = f64::INFINITY);
    with("slow_decay", |c| c.slow_decay = 0.2);
    with("slow_decay", |c| c.slow_decay = 0.0);
    with("fast_decay", |c| c.fast_decay = 1.5);
    with("evidence_scale", |c| c.evidence_scale = Some(0.0));
    with("start_spread_m", |c| c.start_spread_m = 0.0);
    with("start_spread_rad", |c| c.start_spread_rad = -0.1);
    let unknown = serde_json::from_str::<MonteCarloConfig>(r#"{"particle": 10}"#);
    assert!(
        unknown
            .unwrap_err()
            .to_string()
            .contains("unknown field `particle`")
    );
}
