//! Which arrays a model is made of: written in this layout, and held to it when read.

use super::{Header, Model, arrays::Arrays};
use crate::{
    detector::net::{Layer, Weights},
    error::{Error, Result},
    geometry::Pose,
};
use ndarray::{Array1, Array2, Array3, Axis, Ix1, Ix2};
use std::{collections::BTreeSet, path::Path};

/// The arrays of a model, to be written to `path`.
pub(super) fn arrays(model: &Model, path: &Path) -> Arrays {
    let mut arrays = Arrays::new(path);
    for (l, layer) in model.weights.layers.iter().enumerate() {
        for i in 0..model.features() {
            // [in, out] here, [out, in] in the file, as every framework stores it
            let weight = layer.weight.index_axis(Axis(0), i).t().to_owned();
            arrays.put_f32(&weight_name(i, l), weight.into_dyn());
            arrays.put_f32(&bias_name(i, l), layer.bias.row(i).to_owned().into_dyn());
        }
    }
    let input = &model.header.input;
    for (name, constants) in [
        ("input.mean", &input.mean),
        ("input.deviation", &input.deviation),
    ] {
        arrays.put_f32(name, Array1::from(constants.clone()).into_dyn());
    }
    let pose = |(k, axis): (usize, usize)| match (axis, &model.pose[k]) {
        (0, p) => p.x_m,
        (1, p) => p.y_m,
        (_, p) => p.heading_rad,
    };
    let pose = Array2::from_shape_fn((model.pose.len(), 3), pose);
    arrays.put_f64("map.pose", pose.into_dyn());
    if let Some(route) = &model.route_m {
        arrays.put_f64("map.route", Array1::from(route.clone()).into_dyn());
    }
    arrays.put_f32("map.activation", model.activation.clone().into_dyn());
    arrays
}

/// The model that some arrays and a header make, every number of which is checked: after this, nothing in a file can
/// surprise the rest of the program.
pub(super) fn model(path: &Path, meta: &str, arrays: &Arrays) -> Result<Model> {
    let in_header = |fault: String| Error::input(path, "header", fault);
    let mut header: Header = serde_json::from_str(meta)
        .map_err(|e| in_header(format!("{e}; expected the JSON of a model")))?;
    let checked = header.recipe.check();
    checked.map_err(|e| in_header(format!("recipe: {e}")))?;
    check_names(&header, arrays)?;
    header.input.mean = arrays.f32::<Ix1>("input.mean")?.to_vec();
    header.input.deviation = arrays.f32::<Ix1>("input.deviation")?.to_vec();
    let checked = header.input.check();
    checked.map_err(|e| in_header(format!("input: {e}")))?;

    let weights = weights(&header, arrays)?;
    let pose = arrays.f64::<Ix2>("map.pose")?;
    let k = pose.nrows();
    if k == 0 || pose.ncols() != 3 {
        return Err(arrays.wrong(
            "map.pose",
            format!("shape {:?}; expected [K, 3] with K places", pose.shape()),
        ));
    }
    let activation = arrays.f32::<Ix2>("map.activation")?;
    if activation.dim() != (k, weights.features()) {
        return Err(arrays.wrong(
            "map.activation",
            format!(
                "shape {:?}; expected [{k}, {}], one row a place of map.pose",
                activation.shape(),
                weights.features()
            ),
        ));
    }
    if let Some(g) = activation.iter().find(|g| !(0.0..=1.0).contains(*g)) {
        return Err(arrays.wrong(
            "map.activation",
            format!("holds {g}; expected probabilities from 0 to 1"),
        ));
    }
    let route_m = match arrays.has("map.route") {
        true => Some(arrays.f64::<Ix1>("map.route")?.to_vec()),
        false => None,
    };
    if let Some(route) = route_m.as_ref().filter(|route| route.len() != k) {
        return Err(arrays.wrong(
            "map.route",
            format!("{} entries; expected {k}, one a place", route.len()),
        ));
    }
    let pose = pose.rows().into_iter();
    let model = Model {
        header,
        weights,
        pose: pose.map(|p| Pose::new(p[0], p[1], p[2])).collect(),
        route_m,
        activation,
    };
    let map = model.map(); // says what of recipe.map does not fit the places
    map.map_err(|e| in_header(format!("recipe: {e}")))?;
    Ok(model)
}

fn weight_name(filter: usize, layer: usize) -> String {
    format!("filter.{filter}.{layer}.weight")
}

fn bias_name(filter: usize, layer: usize) -> String {
    format!("filter.{filter}.{layer}.bias")
}

/// Refuses, by name, networks of a layout that is not ours (convolutions, more filters or layers than the header tells,
/// banks): to pass over their arrays would be to compute something else than what was trained.
fn check_names(header: &Header, arrays: &Arrays) -> Result<()> {
    let (filters, layers) = (
        header.recipe.features,
        header.recipe.network.hidden.len() + 1,
    );
    let names = |i| (0..layers).flat_map(move |l| [weight_name(i, l), bias_name(i, l)]);
    let ours: BTreeSet<String> = (0..filters).flat_map(names).collect();
    let network = |name: &str| name.starts_with("filter.") || name.starts_with("set.");
    let mut found = arrays.all().map(|(name, _)| name);
    match found.find(|name| network(name) && !ours.contains(*name)) {
        Some(name) => Err(arrays.wrong(
            name,
            format!("a layout that this version does not know; expected {filters} filters of {layers} dense layers"),
        )),
        None => Ok(()),
    }
}

/// The networks, whose shapes must be those that the header's recipe tells.
fn weights(header: &Header, arrays: &Arrays) -> Result<Weights> {
    let filters = header.recipe.features;
    let mut layers = Vec::new();
    let mut inputs = header.input.width();
    for (l, &outputs) in header.recipe.network.hidden.iter().chain(&[1]).enumerate() {
        let (mut weight, mut bias) = (Vec::new(), Vec::new());
        for i in 0..filters {
            let name = weight_name(i, l);
            let found = arrays.f32::<Ix2>(&name)?;
            if found.dim() != (outputs, inputs) {
                return Err(arrays.wrong(
                    &name,
                    format!("shape {:?}; expected [{outputs}, {inputs}]", found.shape()),
                ));
            }
            weight.push(found);
            let name = bias_name(i, l);
            let found = arrays.f32::<Ix1>(&name)?;
            if found.len() != outputs {
                return Err(arrays.wrong(
                    &name,
                    format!("shape {:?}; expected [{outputs}]", found.shape()),
                ));
            }
            bias.push(found);
        }
        // Made only now: of this size are the arrays that were in the file.
        layers.push(Layer {
            weight: Array3::from_shape_fn((filters, inputs, outputs), |(i, a, b)| {
                weight[i][[b, a]]
            }),
            bias: Array2::from_shape_fn((filters, outputs), |(i, b)| bias[i][b]),
        });
        inputs = outputs;
    }
    Ok(Weights {
        layers,
        activation: header.activation,
    })
}
