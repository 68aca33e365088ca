use super::*;

/// Short ways through few buildings.
fn config() -> PretrainingConfig {
    PretrainingConfig {
        buildings: GeneratedConfig {
            path_m: [25.0, 35.0],
            visits: 1,
            ..GeneratedConfig::default()
        },
        sensors: VariedSensorConfig::default(),
        at_hand: 2,
        steps_per_building: 4,
        held_out: 2,
    }
}

fn recipe(steps: usize) -> Recipe {
    let mut recipe = Recipe {
        features: 8,
        uncertainty: Uncertainty::Global,
        ..Recipe::default()
    };
    recipe.descent.steps = steps;
    recipe.descent.truths_per_step = 48;
    recipe.descent.rendered_per_step = 120;
    recipe.network.convolutions.truncate(2);
    recipe
}

fn run(steps: usize) -> (Pretrained, Vec<PretrainingProgress>) {
    let mut seen = Vec::new();
    let pretrained = pretrain(&config(), &recipe(steps), &mut |p| {
        seen.push(p);
        Directive::Continue
    });
    (pretrained.unwrap(), seen)
}

#[test]
fn what_is_learned_holds_in_buildings_kept_apart_and_is_the_same_again() {
    let (one, seen) = run(24);
    let at_start = seen[0].held_out.unwrap();
    assert!(one.held_out > at_start + 0.1, "{at_start} {}", one.held_out);
    // Two apart, then one every four steps.
    assert!(one.buildings >= 8 && seen.len() == 25, "{}", one.buildings);
    let on_one_thread = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    let (again, _) = on_one_thread.install(|| run(24));
    assert!(one.weights == again.weights && one.input == again.input);
}

#[test]
fn it_can_be_cancelled() {
    let cancelled = pretrain(&config(), &recipe(9), &mut |p| match p.step {
        2 => Directive::Cancel,
        _ => Directive::Continue,
    });
    let fault = cancelled
        .err()
        .map(|fault| fault.to_string())
        .unwrap_or_default();
    assert!(fault.contains("step 2 of 9"), "{fault}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let refused = |config: &PretrainingConfig, recipe: &Recipe| {
        let fault = pretrain(config, recipe, &mut |_| Directive::Continue).unwrap_err();
        assert!(fault.is_usage(), "{fault}");
        fault.to_string()
    };
    let none = PretrainingConfig {
        at_hand: 0,
        ..config()
    };
    assert!(refused(&none, &recipe(1)).contains("pretrain.at_hand = 0"));
    assert!(refused(&config(), &Recipe::thrun1998()).contains("network.trunk"));
}
