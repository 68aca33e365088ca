//! The state of a training as a file.

use super::{
    identity::TrainingIdentity,
    phase::{Phase, of_features},
    pseudo_patterns::PseudoPatterns,
    state::State,
};
use crate::{
    detector::net::{Nets, values},
    error::{Error, Result},
    learning::{
        optimiser::{Descent, Memory},
        recipe::{Optimiser, Recipe, Schedule},
    },
    storage,
};
use burn::tensor::{Tensor, TensorData};
use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use std::{collections::HashMap, io, path::Path};

/// Keys of the file's metadata: the identity of the training, that without its number of steps, …
const IDENTITY: &str = "ballmark_training";
const BUT_FOR_STEPS: &str = "ballmark_training_but_for_steps";
/// … and the step at which it went on under another schedule.
const EXTENDED_AT: &str = "ballmark_extended_at";

/// Numbers that are no tensor's.
const NUMBERS: usize = 6;

/// Length of the hexadecimal SHA-256 that ends the file.
const DIGEST: usize = 64;

/// Writes a checkpoint, whole or not at all.
///
/// # Errors
/// Where the file can't be written.
pub fn write(path: &Path, identity: &TrainingIdentity, now: &State) -> Result<()> {
    let mut tensors: Vec<(String, Vec<usize>, Vec<u8>, Dtype)> = Vec::new();
    let mut put = |name: String, tensor: &Tensor<3>| -> Result<()> {
        let bytes = values(tensor.clone())?
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        tensors.push((name, tensor.dims().to_vec(), bytes, Dtype::F32));
        Ok(())
    };
    for (l, (weight, bias)) in now.nets.weight.iter().zip(&now.nets.bias).enumerate() {
        put(format!("now.{l}.weight"), weight)?;
        put(format!("now.{l}.bias"), bias)?;
    }
    for (l, (weight, bias)) in now
        .best_nets
        .weight
        .iter()
        .zip(&now.best_nets.bias)
        .enumerate()
    {
        put(format!("best.{l}.weight"), weight)?;
        put(format!("best.{l}.bias"), bias)?;
    }
    for (p, memory) in now.descent.memory.iter().enumerate() {
        match memory {
            Memory::Adam { first, second } => {
                put(format!("memory.{p}.first"), first)?;
                put(format!("memory.{p}.second"), second)?;
            }
            Memory::Momentum { velocity } => put(format!("memory.{p}.velocity"), velocity)?,
            Memory::ConjugateGradient {
                gradient,
                direction,
            } => {
                put(format!("memory.{p}.gradient"), gradient)?;
                put(format!("memory.{p}.direction"), direction)?;
            }
        }
    }
    if let Some(patterns) = &now.pseudo_patterns {
        put(
            "patterns.output".into(),
            &patterns.output.clone().unsqueeze(),
        )?;
        put(
            "patterns.gradient".into(),
            &patterns.gradient.clone().unsqueeze(),
        )?;
    }
    let best = now.best_validation.unwrap_or(f64::NAN);
    let numbers = [
        now.descent.steps as f64,
        now.best_step as f64,
        best,
        now.batch_error_reduction,
        now.evaluations as f64,
        now.descent.promised,
    ];
    let bytes = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
    tensors.push(("numbers".into(), vec![NUMBERS], bytes, Dtype::F64));

    let views = tensors
        .iter()
        .map(|(name, shape, bytes, dtype)| {
            Ok((name.clone(), TensorView::new(*dtype, shape.clone(), bytes)?))
        })
        .collect::<std::result::Result<Vec<_>, safetensors::SafeTensorError>>()
        .map_err(|e| Error::work(format!("checkpoint: {e}")))?;
    let mut metadata = HashMap::from([
        (IDENTITY.to_string(), identity.whole.clone()),
        (BUT_FOR_STEPS.to_string(), identity.but_for_steps.clone()),
    ]);
    if let Some(step) = now.extended_at {
        metadata.insert(EXTENDED_AT.to_string(), step.to_string());
    }
    let mut bytes = safetensors::serialize(views, Some(metadata))
        .map_err(|e| Error::work(format!("checkpoint: {e}")))?;
    let digest = storage::sha256(&bytes);
    bytes.extend(digest.as_bytes());
    storage::write_file(path, |out| io::Write::write_all(out, &bytes))
}

/// The content of a checkpoint file, if its digest says that not a bit of it has changed: a flipped bit in a weight would
/// go unseen otherwise, and training would end in another model.
fn undamaged(bytes: &[u8]) -> Option<&[u8]> {
    let (content, digest) = bytes.split_at_checked(bytes.len().checked_sub(DIGEST)?)?;
    (storage::sha256(content).as_bytes() == digest).then_some(content)
}

/// Reads a checkpoint of the training named by `identity`, or of the same with another number of steps; its networks have
/// the shape of `like`.
///
/// # Errors
/// Where the file is damaged, belongs to a training with another recipe or other data, or is of another number of steps
/// and does not fit these.
pub fn read(
    path: &Path,
    identity: &TrainingIdentity,
    recipe: &Recipe,
    like: &Nets,
) -> Result<State> {
    let device = like.weight[0].device(); // networks have a first layer
    let file = storage::read_file(path)?;
    let damaged = |what: &str| {
        Error::input(
            path,
            what,
            "is not as a checkpoint has it; train without --resume to start afresh",
        )
    };
    let bytes = undamaged(&file).ok_or_else(|| damaged("the content"))?;
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|_| damaged("the header"))?;
    let metadata = header.metadata().as_ref();
    let entry = |key: &str| metadata.and_then(|m| m.get(key));
    let whose = entry(IDENTITY).ok_or_else(|| damaged("the header"))?;
    let has_other_steps = *whose != identity.whole;
    if has_other_steps && entry(BUT_FOR_STEPS) != Some(&identity.but_for_steps) {
        return Err(Error::file(
            path,
            "is a checkpoint of another training (other data, recipe or version); train without --resume to start afresh",
        ));
    }
    if has_other_steps && recipe.descent.sequential {
        return Err(Error::file(
            path,
            "is a checkpoint of the same training with another number of steps, which descent.sequential deals out \
             among the features: it can't go on with other ones; expected the same --steps, or train without --resume",
        ));
    }
    let file = SafeTensors::deserialize(bytes).map_err(|_| damaged("the content"))?;
    let get = |name: String| -> Result<Option<Tensor<3>>> {
        let Ok(view) = file.tensor(&name) else {
            return Ok(None);
        };
        let shape: [usize; 3] = view.shape().try_into().map_err(|_| damaged(&name))?;
        if view.dtype() != Dtype::F32 {
            return Err(damaged(&name));
        }
        let numbers = view
            .data()
            .chunks_exact(4)
            .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        Ok(Some(Tensor::from_data(
            TensorData::new::<f32, _>(numbers, shape),
            &device,
        )))
    };
    let numbers: Vec<f64> = match file.tensor("numbers") {
        Ok(view) if view.dtype() == Dtype::F64 && view.shape() == [NUMBERS] => {
            let double = |b: &[u8]| {
                b.iter()
                    .rev()
                    .fold(0u64, |bits, &byte| bits << 8 | u64::from(byte))
            };
            view.data()
                .chunks_exact(8)
                .map(|b| f64::from_bits(double(b)))
                .collect()
        }
        _ => return Err(damaged("numbers")),
    };
    let same_shape = |found: Option<Tensor<3>>, like: &Tensor<3>, name: &str| {
        found
            .filter(|t| t.dims() == like.dims())
            .ok_or_else(|| damaged(name))
    };
    let layers = |which: &str| -> Result<Nets> {
        let each = |part: &str, like: &[Tensor<3>]| -> Result<Vec<Tensor<3>>> {
            let named = |l: usize| format!("{which}.{l}.{part}");
            let numbered = like.iter().enumerate();
            numbered
                .map(|(l, like)| same_shape(get(named(l))?, like, &named(l)))
                .collect()
        };
        Ok(Nets {
            weight: each("weight", &like.weight)?,
            bias: each("bias", &like.bias)?,
            convolutions: like.convolutions.clone(),
            trunk: like.trunk,
            activation: like.activation,
            gain: like.gain,
        })
    };
    let mut descent = Descent::new(&recipe.descent);
    descent.steps = numbers[0] as usize;
    if descent.steps > recipe.descent.steps {
        return Err(Error::file(
            path,
            format!(
                "is a checkpoint at step {} of the same training; expected --steps of no less than that, or train \
                 without --resume",
                descent.steps
            ),
        ));
    }
    // At a constant rate no step depends on how many there will be; else the bits are not those of an unbroken training.
    let changed = has_other_steps && recipe.descent.schedule != Schedule::Constant;
    let extended_at = match changed {
        true => Some(descent.steps),
        false => entry(EXTENDED_AT).and_then(|step| step.parse().ok()),
    };
    descent.promised = numbers[5];
    let phase = Phase::at(recipe, descent.steps);
    let learners = of_features(like, phase.learners.clone());
    let remembered = match descent.steps > phase.first_step {
        true => learners.weight.len(),
        false => 0, // nothing of another phase
    };
    let parameters = learners.weight.iter().take(remembered);
    let parameters = parameters.chain(learners.bias.iter().take(remembered));
    for (p, like) in parameters.enumerate() {
        let stored = |what: &str| {
            let name = format!("memory.{p}.{what}");
            same_shape(get(name.clone())?, like, &name)
        };
        descent.memory.push(match recipe.descent.optimiser {
            Optimiser::Adam => Memory::Adam {
                first: stored("first")?,
                second: stored("second")?,
            },
            Optimiser::Momentum => Memory::Momentum {
                velocity: stored("velocity")?,
            },
            Optimiser::ConjugateGradient => Memory::ConjugateGradient {
                gradient: stored("gradient")?,
                direction: stored("direction")?,
            },
        });
    }
    let pattern = |what: &str| -> Result<Option<Tensor<2>>> {
        let name = format!("patterns.{what}");
        let found = get(name.clone())?;
        let Some([1, _, learners]) = found.as_ref().map(|t| t.dims()) else {
            return Ok(None);
        };
        match learners == phase.learners.len() {
            true => Ok(found.map(|t| t.squeeze_dim(0))),
            false => Err(damaged(&name)),
        }
    };
    let pseudo_patterns = match (pattern("output")?, pattern("gradient")?) {
        (Some(output), Some(gradient)) if output.dims() == gradient.dims() => {
            Some(PseudoPatterns { output, gradient })
        }
        (None, None) => None,
        _ => return Err(damaged("patterns")),
    };
    Ok(State {
        nets: layers("now")?,
        descent,
        pseudo_patterns,
        evaluations: numbers[4] as usize,
        best_nets: layers("best")?,
        best_validation: Some(numbers[2]).filter(|best| !best.is_nan()),
        best_step: numbers[1] as usize,
        batch_error_reduction: numbers[3],
        extended_at,
    })
}
