//! Which arrays a model is made of: written in this layout, and held to it when read.

use super::{arrays::Arrays, header::Header, trained_model::Model};
use crate::{
    detector::net::{Convolution, Layer, Weights},
    error::{Error, Result},
    geometry::Pose,
    mapping::{Occupancy, OccupancyMap},
};
use ndarray::{Array1, Array2, Array3, Axis, Ix1, Ix2, Ix3};
use serde_json::{Value, json};
use std::{collections::BTreeSet, path::Path};

/// The arrays of a model, to be written to `path`.
pub(super) fn arrays(model: &Model, path: &Path) -> Arrays {
    let mut arrays = Arrays::new(path);
    put_weights(&mut arrays, &model.weights, "");
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
    if let Some(map) = &model.occupancy {
        let [columns, rows] = map.size();
        let cells = Array2::from_shape_fn((rows, columns), |(row, column)| {
            occupancy_number(map.cells()[row * columns + column])
        });
        arrays.put_u8(OCCUPANCY, cells.into_dyn());
    }
    arrays
}

/// The arrays of some networks, to names that begin with `prefix`.
pub(super) fn put_weights(arrays: &mut Arrays, weights: &Weights, prefix: &str) {
    let names = Names {
        convolutions: weights.convolutions.len(),
        shared: weights.trunk,
    };
    for (l, layer) in weights.layers.iter().enumerate() {
        for i in 0..layer.bias.nrows() {
            let name = format!("{prefix}{}", names.layer(l, i));
            // [in, out] here, [out, in] in the file, as every framework stores it
            let weight = layer.weight.index_axis(Axis(0), i).t().to_owned();
            let weight = match weights.convolutions.get(l) {
                None => weight.into_dyn(),
                // [out, tap, in] here, [out, in, tap] there
                Some(c) => {
                    let shape = (c.outputs, c.inputs, c.width);
                    let entry = |(out, number, tap)| weight[[out, tap * c.inputs + number]];
                    Array3::from_shape_fn(shape, entry).into_dyn()
                }
            };
            arrays.put_f32(&weight_of(&name), weight);
            arrays.put_f32(&bias_of(&name), layer.bias.row(i).to_owned().into_dyn());
        }
    }
}

/// The model that some arrays and a header make, every number of which is checked: after this, nothing in a file can
/// surprise the rest of the program.
pub(super) fn model(path: &Path, meta: &str, arrays: &Arrays) -> Result<Model> {
    let in_header = |fault: String| Error::input(path, "header", fault);
    let no_model = |e: serde_json::Error| in_header(format!("{e}; expected the JSON of a model"));
    let mut meta: Value = serde_json::from_str(meta).map_err(no_model)?;
    if let Some(sets) = meta.get("bank").and_then(Value::as_array) {
        return Err(in_header(format!(
            "a bank of {} sets of filters (train --uncertainty bank); expected a single model",
            sets.len()
        )));
    }
    without_later_keys(&mut meta);
    let mut header: Header = serde_json::from_value(meta).map_err(no_model)?;
    let checked = header.recipe.check();
    checked.map_err(|e| in_header(format!("recipe: {e}")))?;
    if let Some(scale) = header
        .evidence_scale
        .filter(|s| !(s.is_finite() && *s > 0.0))
    {
        return Err(in_header(format!(
            "evidence_scale is {scale}; expected a number above 0"
        )));
    }
    if let Some(lost) = &header.lost {
        lost.check().map_err(|e| in_header(e.to_string()))?;
    }
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
    let occupancy = occupancy(&header, arrays)?;
    let pose = pose.rows().into_iter();
    let model = Model {
        header,
        weights,
        pose: pose.map(|p| Pose::new(p[0], p[1], p[2])).collect(),
        route_m,
        activation,
        occupancy,
    };
    let map = model.map(); // says what of recipe.map does not fit the places
    map.map_err(|e| in_header(format!("recipe: {e}")))?;
    if let Some(rendered) = model.rendered_inputs() {
        rendered.map_err(|e| in_header(format!("occupancy: {e}")))?;
    }
    Ok(model)
}

/// A header that does not speak of something is of a time before there was any: it has none, not the default's.
fn without_later_keys(meta: &mut Value) {
    for (place, key, none) in [
        ("/recipe", "begin_with", json!("random")),
        ("/recipe/network", "convolutions", json!([])),
        ("/recipe/network", "dense", json!([])),
        ("/recipe/descent", "cross_entropy", json!(0.0)),
        ("/recipe/map", "filled_from", json!("visits")),
    ] {
        if let Some(table) = meta.pointer_mut(place).and_then(Value::as_object_mut) {
            table.entry(key).or_insert(none);
        }
    }
    let channels = meta.pointer_mut("/input/channels");
    for channel in channels.and_then(Value::as_array_mut).into_iter().flatten() {
        if channel.get("kind") == Some(&json!("values")) {
            channel["kind"] = json!({ "values": {} });
        }
    }
}

/// The occupancy map's array.
pub(super) const OCCUPANCY: &str = "map.occupancy";

/// As ROS numbers occupancy.
pub(super) fn occupancy_number(cell: Occupancy) -> u8 {
    match cell {
        Occupancy::Free => 0,
        Occupancy::Occupied => 100,
        Occupancy::Unknown => 255,
    }
}

/// The occupancy map that a header describes.
fn occupancy(header: &Header, arrays: &Arrays) -> Result<Option<OccupancyMap>> {
    let Some(of) = &header.occupancy else {
        return Ok(None);
    };
    let numbers = arrays.u8::<Ix2>(OCCUPANCY)?;
    let cell = |&number: &u8| {
        let all = [Occupancy::Free, Occupancy::Occupied, Occupancy::Unknown];
        let named = all
            .into_iter()
            .find(|&cell| occupancy_number(cell) == number);
        named.ok_or_else(|| {
            let fault =
                format!("holds {number}; expected 0 (free), 100 (occupied) or 255 (unknown)");
            arrays.wrong(OCCUPANCY, fault)
        })
    };
    let cells = numbers.iter().map(cell).collect::<Result<Vec<_>>>()?;
    let map = OccupancyMap::from_cells(of.cell_m, of.origin_m, numbers.ncols(), cells);
    map.map(Some)
        .map_err(|fault| arrays.wrong(OCCUPANCY, fault))
}

/// How layers are named: `filter.convolution.{layer}`, `filter.trunk.{layer}`, then `filter.{i}.{layer}`, each counted from 0.
#[derive(Clone, Copy)]
struct Names {
    convolutions: usize,
    /// Convolutions and trunk.
    shared: usize,
}

impl Names {
    fn of(header: &Header) -> Self {
        let (network, inputs) = (&header.recipe.network, header.input.shape());
        Self {
            convolutions: network.convolutions(inputs).len(),
            shared: network.shared_layers(inputs),
        }
    }

    /// Layer `layer`, counted from the input, of network `filter`.
    fn layer(&self, layer: usize, filter: usize) -> String {
        match layer {
            l if l < self.convolutions => format!("filter.convolution.{l}"),
            l if l < self.shared => format!("filter.trunk.{}", l - self.convolutions),
            l => format!("filter.{filter}.{}", l - self.shared),
        }
    }
}

fn weight_of(layer: &str) -> String {
    format!("{layer}.weight")
}

fn bias_of(layer: &str) -> String {
    format!("{layer}.bias")
}

/// Names of all layers of the networks that a header describes.
fn layer_names(header: &Header) -> BTreeSet<String> {
    let recipe = &header.recipe;
    let named = Names::of(header);
    let shapes = recipe.network.shapes(header.input.shape(), recipe.features);
    let names =
        |(l, [networks, _, _]): (usize, [usize; 3])| (0..networks).map(move |i| named.layer(l, i));
    shapes.into_iter().enumerate().flat_map(names).collect()
}

/// Refuses, by name, networks of a layout that is not ours (convolutions, more filters or layers than the header has,
/// banks): to pass over their arrays would be to compute something else than what was trained.
fn check_names(header: &Header, arrays: &Arrays) -> Result<()> {
    let names = layer_names(header);
    let ours: BTreeSet<String> = names
        .iter()
        .flat_map(|layer| [weight_of(layer), bias_of(layer)])
        .collect();
    let network = |name: &str| name.starts_with("filter.") || name.starts_with("set.");
    let mut found = arrays.all().map(|(name, _)| name);
    match found.find(|name| network(name) && !ours.contains(*name)) {
        Some(name) => {
            let recipe = &header.recipe;
            let trunk = match recipe.network.trunk.len() {
                0 => String::new(),
                shared => format!(" on a trunk of {shared}"),
            };
            Err(arrays.wrong(
                name,
                format!(
                    "a layout that this version does not know; expected {} filters of {} dense layers{trunk}",
                    recipe.features,
                    recipe.network.hidden.len() + 1
                ),
            ))
        }
        None => Ok(()),
    }
}

/// The weights of a layer of convolutions, `[out, tap · in]`, which the file has as `[out, in, tap]`.
fn by_tap(arrays: &Arrays, name: &str, layer: &Convolution) -> Result<Array2<f32>> {
    let found = arrays.f32::<Ix3>(name)?;
    let expected = (layer.outputs, layer.inputs, layer.width);
    if found.dim() != expected {
        return Err(arrays.wrong(
            name,
            format!("shape {:?}; expected {expected:?}", found.shape()),
        ));
    }
    let shape = (layer.outputs, layer.width * layer.inputs);
    Ok(Array2::from_shape_fn(shape, |(out, column)| {
        found[[out, column % layer.inputs, column / layer.inputs]]
    }))
}

/// The networks, whose shapes must be those that the header's recipe gives.
fn weights(header: &Header, arrays: &Arrays) -> Result<Weights> {
    let network = &header.recipe.network;
    let inputs = header.input.shape();
    let (names, convolutions) = (Names::of(header), network.convolutions(inputs));
    let mut layers = Vec::new();
    let shapes = network.shapes(inputs, header.recipe.features);
    for (l, [networks, inputs, outputs]) in shapes.into_iter().enumerate() {
        let (mut weight, mut bias) = (Vec::new(), Vec::new());
        for i in 0..networks {
            let layer = names.layer(l, i);
            let name = weight_of(&layer);
            let found = match convolutions.get(l) {
                None => arrays.f32::<Ix2>(&name)?,
                Some(c) => by_tap(arrays, &name, c)?,
            };
            if found.dim() != (outputs, inputs) {
                return Err(arrays.wrong(
                    &name,
                    format!("shape {:?}; expected [{outputs}, {inputs}]", found.shape()),
                ));
            }
            weight.push(found);
            let name = bias_of(&layer);
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
            weight: Array3::from_shape_fn((networks, inputs, outputs), |(i, a, b)| {
                weight[i][[b, a]]
            }),
            bias: Array2::from_shape_fn((networks, outputs), |(i, b)| bias[i][b]),
        });
    }
    Ok(Weights {
        layers,
        convolutions,
        trunk: names.shared,
        activation: header.activation,
    })
}
