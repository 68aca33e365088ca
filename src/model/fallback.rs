//! Features that were not learned, for data from which nothing is learned that holds up: random ones of the same number.

use crate::{
    detector::{device, net::NetDetector, random_projection::RandomProjection},
    error::Result,
    learning::{
        recipe::{ObjectiveKind, Recipe},
        trainer::Trained,
        training_set::TrainingSet,
    },
    seed::Seed,
};

/// Sides of random planes in the place of what was learned, if they take away more of the validation error, and what was learned took
/// away. Only where the map is filled from visits, and of the mean-field objective: what Thrun (1998) did is left as it is.
pub(super) fn better_random(
    recipe: &Recipe,
    training_set: &TrainingSet,
    trained: &Trained,
) -> Result<Option<(Trained, f64)>> {
    let (Some(learned), Some(validation_set)) = (trained.validation, &training_set.validation_set)
    else {
        return Ok(None);
    };
    if training_set.every_pose.is_some() || recipe.descent.objective != ObjectiveKind::MeanField {
        return Ok(None);
    }
    let input = training_set.input.clone();
    let projection = RandomProjection::new(input.clone(), recipe.features, Seed(recipe.seed));
    let weights = projection.weights();
    let detector = NetDetector::new(input, &weights, &device::cpu());
    let activation = detector.respond(training_set.inputs.view())?;
    let truths = detector.respond(validation_set.inputs.view())?;
    let validation = training_set.validate(validation_set, truths.view(), activation.view())?;
    if validation.error_reduction <= learned.error_reduction {
        return Ok(None);
    }
    let train = training_set.judge(activation.view(), activation.view())?;
    let random = Trained {
        weights,
        activation,
        train,
        validation: Some(validation),
        ..trained.clone()
    };
    Ok(Some((random, learned.error_reduction)))
}
