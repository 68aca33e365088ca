//! Trainings that are stopped, and go on from a checkpoint.

use super::*;

#[test]
fn a_resumed_training_ends_in_the_same_bits() {
    resumes(&recipe());
    resumes(&recipe_in_draws());
}

fn resumes(recipe: &Recipe) {
    let recording = recording();
    let training_set = training_set(recipe, &recording);
    let whole = run(recipe, &training_set).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.checkpoint");
    for cancelled_at in [0, 3, 8, 29, recipe.descent.steps] {
        let file = (&*path, "it", false);
        let cancel = &mut at(cancelled_at, Directive::Cancel);
        let error = run_with(recipe, &training_set, file, cancel).unwrap_err();
        assert!(error.is_cancelled(), "{error}");
        let message = error.to_string();
        assert!(
            message.contains(&format!("step {cancelled_at} of")),
            "{message}"
        );
        let file = (&*path, "it", true);
        let resumed = run_with(recipe, &training_set, file, &mut |_| ()).unwrap();
        assert_eq!(
            resumed.weights, whole.weights,
            "cancelled at step {cancelled_at}"
        );
        assert_eq!(resumed.steps, whole.steps);
        assert_eq!(resumed.resumed_at, Some(cancelled_at));
        assert_eq!(resumed.extended_at, None);
    }
    let other = run_with(recipe, &training_set, (&path, "another", true), &mut |_| ());
    assert!(other.unwrap_err().to_string().contains("another training"));
}

#[test]
fn a_stopped_training_keeps_the_best_so_far() {
    let recipe = recipe();
    let recording = recording();
    let training_set = training_set(&recipe, &recording);
    let mut best = None;
    let stop = &mut |p: Progress| {
        best = p.best_validation;
        match p.step == 33 {
            true => Directive::Stop, // not a step that the validation part is judged at
            false => Directive::Continue,
        }
    };
    let stopped = train(&recipe, &training_set, &cpu(), None, stop).unwrap();
    assert_eq!(stopped.stopped_by, StoppedBy::Callback);
    assert_eq!(stopped.steps, 33);
    let kept = stopped.validation.unwrap().error_reduction;
    assert!(kept >= best.unwrap() && kept > 0.2, "{kept} {best:?}");

    let mut several = recipe.clone();
    several.descent.restarts = 3;
    let mut last = 0;
    let stop = &mut |p: Progress| {
        last = p.step;
        assert_eq!(p.most_steps, 180);
        match p.step == 70 {
            true => Directive::Stop,
            false => Directive::Continue,
        }
    };
    let stopped = train(&several, &training_set, &cpu(), None, stop).unwrap();
    assert_eq!((last, stopped.stopped_by), (70, StoppedBy::Callback));
}

/// Where the rate is constant, the first steps of a longer training are those of a shorter one; where it falls along a
/// cosine they are not, and the result says so.
#[test]
fn a_checkpoint_goes_on_to_more_steps() {
    let recording = recording();
    for schedule in [Schedule::Constant, Schedule::Cosine] {
        let mut recipe = recipe_in_draws();
        recipe.descent.schedule = schedule;
        let training_set = training_set(&recipe, &recording);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.checkpoint");
        let cancel = &mut at(50, Directive::Cancel);
        run_with(&recipe, &training_set, (&path, "it", false), cancel).unwrap_err();

        let mut longer = recipe.clone();
        longer.descent.steps = 80;
        longer.descent.patience = 80;
        let resume = (&*path, "it", true);
        // Cancelled once more on the way: what it is must not be forgotten.
        let cancel = &mut at(60, Directive::Cancel);
        run_with(&longer, &training_set, resume, cancel).unwrap_err();
        let extended = run_with(&longer, &training_set, resume, &mut |_| ()).unwrap();
        assert_eq!(extended.steps, 80);
        let whole = run(&longer, &training_set).unwrap();
        let is_the_same = extended.weights == whole.weights;
        match schedule {
            Schedule::Constant => assert!(is_the_same && extended.extended_at.is_none()),
            Schedule::Cosine => assert!(!is_the_same && extended.extended_at == Some(50)),
        }

        let mut shorter = recipe.clone();
        shorter.descent.steps = 59;
        let refused = run_with(&shorter, &training_set, resume, &mut |_| ()).unwrap_err();
        assert!(refused.to_string().contains("at step 72"), "{refused}");
    }
}

#[test]
fn a_checkpoint_of_a_sequence_does_not_go_on_to_other_steps() {
    let mut recipe = recipe();
    recipe.descent.sequential = true;
    let recording = recording();
    let training_set = training_set(&recipe, &recording);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.checkpoint");
    let cancel = &mut at(10, Directive::Cancel);
    run_with(&recipe, &training_set, (&path, "it", false), cancel).unwrap_err();
    recipe.descent.steps = 80;
    let refused = run_with(&recipe, &training_set, (&path, "it", true), &mut |_| ());
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("descent.sequential"), "{refused}");
}

/// Stopped before its own first checkpoint, a training must not find another one's when it is taken up.
#[test]
fn an_old_checkpoint_does_not_outlive_a_fresh_start() {
    let recipe = recipe();
    let recording = recording();
    let training_set = training_set(&recipe, &recording);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.checkpoint");
    let old = (&*path, "old", false);
    run_with(&recipe, &training_set, old, &mut |_| ()).unwrap();
    assert!(path.exists());
    // Stopped at once, this one leaves no checkpoint of its own.
    let new = (&*path, "new", false);
    run_with(&recipe, &training_set, new, &mut at(3, Directive::Stop)).unwrap();
    assert!(!path.exists());
    let new = (&*path, "new", true);
    let resumed = run_with(&recipe, &training_set, new, &mut |_| ()).unwrap();
    let whole = run(&recipe, &training_set).unwrap();
    assert_eq!(resumed.weights, whole.weights);
}
