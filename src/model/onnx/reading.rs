//! An exported graph as the model that it was made from.
//!
//! Its arrays are the graph's constants by their names; the nodes are not run, since the header says which networks they are. So that
//! header, constants and nodes are surely those that were written together, the digest at the end must be that of all bytes before it.

use super::{
    super::{
        arrays::{Arrays, Values},
        bank_names::{BANK, RUN, prefix},
        header::Header,
        layout::{self, OCCUPANCY},
    },
    proto::{DOUBLE, FLOAT, ModelProto, TensorProto},
    seal::seal,
};
use crate::{
    detector::net::{Layer, Weights},
    error::{Error, Result},
};
use ndarray::{Array1, Array2, Array3, ArrayD, IxDyn};
use prost::Message;
use serde_json::{Value, json};
use std::{collections::BTreeMap, path::Path};

/// What messages say was expected.
const EXPECTED: &str =
    "expected a graph as `ballmark export` wrote it, or the model's .safetensors or .npz";

/// Does a file begin as an ONNX file does: its version, and who made it?
pub(in crate::model) fn is_graph(bytes: &[u8]) -> bool {
    match bytes {
        // The numbers of two fields, a small number and a name's length. A .safetensors file, which begins with a length of eight bytes, has zeros
        // at the end of it.
        [0x08, _, 0x12, _, name @ ..] => name.iter().take(4).any(|&byte| byte != 0),
        _ => false,
    }
}

/// JSON and arrays of a graph, named as in every other container.
pub(in crate::model) fn read(path: &Path, bytes: &[u8]) -> Result<(String, Arrays)> {
    let fault = |fault: String| Error::file(path, format!("{fault}; {EXPECTED}"));
    let before = bytes.len().checked_sub(seal(&[]).len());
    let (before, end) = bytes.split_at(before.unwrap_or(0));
    if end != seal(before) {
        return Err(fault(
            "an ONNX graph of another program, of a version without digests, or one that was changed since".into(),
        ));
    }
    let file = ModelProto::decode(bytes).map_err(|e| fault(format!("no ONNX graph ({e})")))?;
    let header = file.metadata_props.iter().find(|m| m.key == "ballmark");
    let header = header.ok_or_else(|| fault("metadata key `ballmark` is missing".into()))?;
    let header: Value = serde_json::from_str(&header.value)
        .map_err(|e| fault(format!("metadata key `ballmark`: {e}")))?;
    let graph = file.graph.unwrap_or_default();
    let constants = Constants {
        path,
        by_name: (graph.initializer.iter())
            .map(|tensor| (tensor.name.as_str(), tensor))
            .collect(),
    };
    let mut arrays = Arrays::new(path);
    let pose = constants.f64("map.pose.values")?;
    let k = pose.len() / 3;
    let pose = Array2::from_shape_vec((k, 3), pose)
        .map_err(|e| constants.wrong("map.pose.values", e.to_string()))?;
    arrays.put_f64("map.pose", pose.into_dyn());
    if constants.has("map.route.values") {
        let route_m = Array1::from(constants.f64("map.route.values")?);
        arrays.put_f64("map.route", route_m.into_dyn());
    }
    let Value::Array(headers) = header else {
        add_set(&mut arrays, &constants, parsed(path, &header)?, "")?;
        return Ok((header.to_string(), arrays));
    };
    let run = Array1::from(constants.f64("map.run.values")?);
    arrays.put(RUN, Values::F64(run.into_dyn()));
    for header in &headers {
        let own = parsed(path, header)?;
        let prefix = prefix(own.prior);
        add_set(&mut arrays, &constants, own, &prefix)?;
    }
    Ok((json!({ BANK: headers }).to_string(), arrays))
}

fn parsed(path: &Path, header: &Value) -> Result<Header> {
    serde_json::from_value(header.clone())
        .map_err(|e| Error::input(path, "header", format!("{e}; {EXPECTED}")))
}

/// What a set has of its own.
fn add_set(
    arrays: &mut Arrays,
    constants: &Constants,
    mut header: Header,
    prefix: &str,
) -> Result<()> {
    let checked = header.recipe.check();
    checked.map_err(|e| Error::input(constants.path, "header", format!("recipe: {e}")))?;
    let own = |name: &str| format!("{prefix}{name}");
    header.input.mean = constants.f32(&own("input.mean"))?;
    header.input.deviation = constants.f32(&own("input.deviation"))?;
    let checked = header.input.check();
    checked.map_err(|e| Error::input(constants.path, "header", format!("input: {e}")))?;
    for (name, numbers) in [
        ("input.mean", &header.input.mean),
        ("input.deviation", &header.input.deviation),
    ] {
        arrays.put_f32(&own(name), Array1::from(numbers.clone()).into_dyn());
    }
    let weights = weights(constants, &header, prefix)?;
    let activation = own("map.activation.values");
    let numbers = constants.f32(&activation)?;
    let shape = (numbers.len() / weights.features(), weights.features());
    let numbers = Array2::from_shape_vec(shape, numbers)
        .map_err(|e| constants.wrong(&activation, e.to_string()))?;
    arrays.put_f32(&own("map.activation"), numbers.into_dyn());
    layout::put_weights(arrays, &weights, prefix);
    if header.occupancy.is_some() {
        let cells = constants.tensor("map.occupancy.values")?;
        let numbers = constants.f32("map.occupancy.values")?;
        let whole = |number: f32| match number as u8 {
            whole if f32::from(whole) == number => Ok(whole), // which of them are occupancies is asked where the map is made
            _ => Err(constants.wrong(
                "map.occupancy.values",
                format!("holds {number}; expected 0 (free), 100 (occupied) or 255 (unknown)"),
            )),
        };
        let numbers = numbers.into_iter().map(whole).collect::<Result<_>>()?;
        let shape: Vec<usize> = (cells.dims.iter())
            .map(|&length| usize::try_from(length).unwrap_or(0))
            .collect();
        let cells = ArrayD::from_shape_vec(IxDyn(&shape), numbers)
            .map_err(|e| constants.wrong("map.occupancy.values", e.to_string()))?;
        arrays.put_u8(&own(OCCUPANCY), cells);
    }
    Ok(())
}

/// The networks, whose shapes the header gives.
fn weights(constants: &Constants, header: &Header, prefix: &str) -> Result<Weights> {
    let (network, inputs) = (&header.recipe.network, header.input.shape());
    let convolutions = network.convolutions(inputs);
    let shared = network.shared_layers(inputs);
    let shapes = network.shapes(inputs, header.recipe.features);
    let layer = |(number, [n, inputs, outputs]): (usize, [usize; 3])| {
        let what = match number {
            l if l < convolutions.len() => "convolution",
            l if l < shared => "trunk",
            _ => "filter",
        };
        let numbers = |part: &str, shape: [usize; 3]| {
            let name = format!("{prefix}{what}.{number}.{part}");
            let numbers = constants.f32(&name)?;
            Array3::from_shape_vec(shape, numbers)
                .map_err(|e| constants.wrong(&name, format!("{e}; expected {shape:?}")))
        };
        let bias = numbers("bias", [n, 1, outputs])?;
        let weight = match number == shared {
            // The first layers of all networks stand side by side.
            true => {
                let side_by_side = numbers("weight", [inputs, n, outputs])?;
                let weight = side_by_side.permuted_axes([1, 0, 2]);
                weight.as_standard_layout().to_owned()
            }
            false => numbers("weight", [n, inputs, outputs])?,
        };
        let bias = bias.index_axis_move(ndarray::Axis(1), 0);
        Ok(Layer { weight, bias })
    };
    Ok(Weights {
        layers: (shapes.into_iter().enumerate())
            .map(layer)
            .collect::<Result<_>>()?,
        activation: header.activation,
        trunk: shared,
        convolutions,
    })
}

/// The constants of a graph.
struct Constants<'a> {
    path: &'a Path,
    by_name: BTreeMap<&'a str, &'a TensorProto>,
}

impl Constants<'_> {
    fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    fn wrong(&self, name: &str, fault: String) -> Error {
        Error::input(self.path, format!("constant `{name}`"), fault)
    }

    fn tensor(&self, name: &str) -> Result<&TensorProto> {
        let found = self.by_name.get(name).copied();
        found.ok_or_else(|| self.wrong(name, format!("missing; {EXPECTED}")))
    }

    /// The bytes of a constant of this type of numbers.
    fn bytes(&self, name: &str, number: i32) -> Result<&[u8]> {
        let tensor = self.tensor(name)?;
        match tensor.data_type == number {
            true => Ok(&tensor.raw_data),
            false => Err(self.wrong(
                name,
                format!("numbers of type {}; expected {number}", tensor.data_type),
            )),
        }
    }

    fn f32(&self, name: &str) -> Result<Vec<f32>> {
        let bytes = self.bytes(name, FLOAT)?.as_chunks::<4>().0;
        Ok(bytes.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }

    fn f64(&self, name: &str) -> Result<Vec<f64>> {
        let bytes = self.bytes(name, DOUBLE)?.as_chunks::<8>().0;
        Ok(bytes.iter().map(|b| f64::from_le_bytes(*b)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::{
            super::Model,
            file,
            tests::{bank_of_one, trained},
            to_bytes,
        },
        *,
    };

    fn fault(bytes: &[u8]) -> String {
        let fault = Model::from_bytes("m.onnx".as_ref(), bytes).expect_err("it was read");
        fault.to_string()
    }

    #[test]
    fn a_graph_that_was_changed_cut_or_made_elsewhere_is_refused() {
        let bytes = to_bytes(&bank_of_one(&trained(|_| ()))).unwrap();
        // From behind the name of the program: before it a changed byte makes another kind of file.
        for at in (16..bytes.len()).step_by(bytes.len() / 97) {
            let mut changed = bytes.clone();
            changed[at] ^= 0x04;
            assert!(fault(&changed).contains("changed since"), "{at}");
        }
        for length in (16..bytes.len()).step_by(bytes.len() / 53) {
            assert!(
                fault(&bytes[..length]).contains("changed since"),
                "{length}"
            );
        }
        let theirs = b"\x08\x07\x12\x07pytorch\x1a\x052.1.0";
        assert!(fault(theirs).contains("of another program"));
    }

    /// Who seals a file of their own.
    #[test]
    fn every_constant_is_held_to_the_header() {
        let whole = file(&bank_of_one(&trained(|_| ()))).unwrap();
        let sealed = |change: &dyn Fn(&mut ModelProto)| {
            let mut file = whole.clone();
            change(&mut file);
            let mut bytes = file.encode_to_vec();
            bytes.extend(seal(&bytes));
            bytes
        };
        assert!(Model::from_bytes("m.onnx".as_ref(), &sealed(&|_| ())).is_ok());
        let of = |name: &str, change: fn(&mut TensorProto)| {
            fault(&sealed(&|file: &mut ModelProto| {
                let graph = file.graph.as_mut().unwrap();
                let mut all = graph.initializer.iter_mut();
                change(all.find(|tensor| tensor.name == name).unwrap());
            }))
        };
        let shorter = |tensor: &mut TensorProto| {
            let half = tensor.raw_data.len() / 2;
            tensor.raw_data.truncate(half);
        };
        let empty = |tensor: &mut TensorProto| tensor.raw_data.clear();
        let renamed = |tensor: &mut TensorProto| tensor.name = "other".into();
        let retyped = |tensor: &mut TensorProto| tensor.data_type = 7;
        let spoilt = |tensor: &mut TensorProto| tensor.raw_data.fill(0xff);
        let graph = whole.graph.as_ref().unwrap();
        let names = graph.initializer.iter().map(|tensor| &tensor.name);
        // Others are of the nodes alone, or the occupancy map's frame, which the header has.
        let is_read = |name: &&String| !name.starts_with("constant") && !name.contains("frame");
        let names: Vec<&String> = names.filter(is_read).collect();
        assert!(names.len() > 7, "{names:?}");
        for name in names {
            for change in [shorter, empty, renamed, retyped, spoilt] {
                let said = of(name, change);
                assert!(said.starts_with("m.onnx: "), "{name}: {said}");
            }
            assert!(of(name, renamed).contains("missing"), "{name}");
            assert!(of(name, retyped).contains("type 7"), "{name}");
        }
        let header = |text: &'static str| {
            let change = move |file: &mut ModelProto| file.metadata_props[0].value = text.into();
            fault(&sealed(&change))
        };
        for text in ["", "{}", "[]", "[{}]", "3", "{\"recipe\":{}}"] {
            let said = header(text);
            assert!(said.starts_with("m.onnx: "), "{text}: {said}");
        }
        let headless = fault(&sealed(&|file: &mut ModelProto| {
            file.metadata_props.clear()
        }));
        assert!(headless.contains("`ballmark` is missing"), "{headless}");
        let gutted = fault(&sealed(&|file: &mut ModelProto| file.graph = None));
        assert!(gutted.contains("map.pose.values"), "{gutted}");
    }
}
