//! The file is worked out node by node by an interpreter of its few operators, and must answer as the model does. ONNX's own checker and
//! runtime do the same in `tests/onnx/check.py`.

use super::{super::ModelBank, proto::*, *};
use crate::{
    belief::Uncertainty,
    detector::{Detector, net::Activation},
    geometry::Pose,
    learning::recipe::{BeginWith, Recipe},
    model::Training,
    recording::{Columns, Recording},
    seed::Seed,
};
use ndarray::{Array2, ArrayD, Axis, IxDyn};
use rand::RngExt;
use std::collections::BTreeMap;

type Values = BTreeMap<String, ArrayD<f64>>;

fn tensor(of: &TensorProto) -> ArrayD<f64> {
    let shape: Vec<usize> = of.dims.iter().map(|&length| length as usize).collect();
    let bytes = &of.raw_data;
    let four = |b: &[u8]| f64::from(f32::from_le_bytes(b.try_into().unwrap()));
    let values: Vec<f64> = match of.data_type {
        FLOAT => bytes.chunks(4).map(four).collect(),
        INT64 => (bytes.chunks(8))
            .map(|b| i64::from_le_bytes(b.try_into().unwrap()) as f64)
            .collect(),
        DOUBLE => (bytes.chunks(8))
            .map(|b| f64::from_le_bytes(b.try_into().unwrap()))
            .collect(),
        other => panic!("type {other}"),
    };
    ArrayD::from_shape_vec(IxDyn(&shape), values).unwrap()
}

/// The other's axes, with as many in front as it lacks.
fn broadcast(a: &ArrayD<f64>, b: &ArrayD<f64>, of: impl Fn(f64, f64) -> f64) -> ArrayD<f64> {
    let axes = a.ndim().max(b.ndim());
    let padded = |of: &ArrayD<f64>| [vec![1; axes - of.ndim()], of.shape().to_vec()].concat();
    let (left, right) = (padded(a), padded(b));
    let shape: Vec<usize> = left.iter().zip(&right).map(|(&l, &r)| l.max(r)).collect();
    let full = |of: &ArrayD<f64>, padded: &[usize]| {
        let of = of.to_shape(IxDyn(padded)).unwrap().to_owned();
        of.broadcast(IxDyn(&shape)).unwrap().to_owned()
    };
    let (a, b) = (full(a, &left), full(b, &right));
    let values = a.iter().zip(&b).map(|(&a, &b)| of(a, b)).collect();
    ArrayD::from_shape_vec(IxDyn(&shape), values).unwrap()
}

fn matrices(a: &ArrayD<f64>, b: &ArrayD<f64>) -> ArrayD<f64> {
    let two = |of: &ArrayD<f64>| of.clone().into_dimensionality::<ndarray::Ix2>().unwrap();
    if a.ndim() == 2 {
        return two(a).dot(&two(b)).into_dyn();
    }
    let slices: Vec<_> = (0..a.shape()[0])
        .map(|k| {
            let right = match b.ndim() {
                2 => b.clone(),
                _ => b.index_axis(Axis(0), k).to_owned(),
            };
            two(&a.index_axis(Axis(0), k).to_owned()).dot(&two(&right))
        })
        .collect();
    let views: Vec<_> = slices.iter().map(|slice| slice.view()).collect();
    ndarray::stack(Axis(0), &views).unwrap().into_dyn()
}

fn work_out(node: &NodeProto, values: &Values) -> ArrayD<f64> {
    let input = |k: usize| &values[&node.input[k]];
    let number = |name: &str| {
        let mut all = node.attribute.iter();
        let own = all.find(|attribute| attribute.name == name).unwrap();
        (own.i.unwrap_or_default(), own.ints.clone())
    };
    let axis = |of: &ArrayD<f64>, axis: i64| Axis(axis.rem_euclid(of.ndim() as i64) as usize);
    let map = |of: fn(f64) -> f64| input(0).mapv(of);
    let both = |of: fn(f64, f64) -> f64| broadcast(input(0), input(1), of);
    match node.op_type.as_str() {
        "Identity" | "Cast" => input(0).clone(),
        "IsNaN" => map(|v| f64::from(u8::from(v.is_nan()))),
        "Not" => map(|v| 1.0 - v),
        "Log" => map(f64::ln),
        "Tanh" => map(f64::tanh),
        "Relu" => map(|v| v.max(0.0)),
        "Sigmoid" => map(|v| 1.0 / (1.0 + (-v).exp())),
        "Add" => both(|a, b| a + b),
        "Sub" => both(|a, b| a - b),
        "Mul" => both(|a, b| a * b),
        "Div" => both(|a, b| a / b),
        "Min" => both(f64::min),
        "MatMul" => matrices(input(0), input(1)),
        "Clip" => {
            let least = broadcast(input(0), input(1), f64::max);
            broadcast(&least, input(2), f64::min)
        }
        "Where" => {
            let full = broadcast(input(1), input(2), |a, _| a);
            let other = broadcast(input(1), input(2), |_, b| b);
            let chosen = input(0).iter().zip(full.iter().zip(&other));
            let chosen = chosen.map(|(condition, (a, b))| if *condition != 0.0 { *a } else { *b });
            ArrayD::from_shape_vec(full.raw_dim(), chosen.collect()).unwrap()
        }
        "Gather" => {
            let at: Vec<usize> = input(1).iter().map(|&at| at as usize).collect();
            input(0).select(axis(input(0), number("axis").0), &at)
        }
        "Concat" => {
            let all: Vec<_> = node.input.iter().map(|name| values[name].view()).collect();
            ndarray::concatenate(axis(input(0), number("axis").0), &all).unwrap()
        }
        "Reshape" => {
            let asked: Vec<i64> = input(1).iter().map(|&length| length as i64).collect();
            let known: i64 = asked.iter().filter(|&&length| length > 0).product();
            let left = input(0).len() as i64 / known;
            let shape: Vec<usize> = asked
                .iter()
                .map(|&length| if length < 0 { left } else { length } as usize)
                .collect();
            let in_rows: Vec<f64> = input(0).iter().copied().collect();
            ArrayD::from_shape_vec(IxDyn(&shape), in_rows).unwrap()
        }
        "Transpose" => {
            let order: Vec<usize> = number("perm").1.iter().map(|&at| at as usize).collect();
            input(0).clone().permuted_axes(IxDyn(&order))
        }
        "TopK" => {
            assert_eq!((number("largest").0, number("sorted").0), (0, 1));
            let mut sorted = input(0).as_standard_layout().into_owned();
            assert_eq!(input(1)[[0]] as usize, sorted.shape()[sorted.ndim() - 1]);
            let last = Axis(sorted.ndim() - 1);
            for mut lane in sorted.lanes_mut(last) {
                lane.as_slice_mut().unwrap().sort_by(f64::total_cmp);
            }
            sorted
        }
        other => panic!("operator {other}"),
    }
}

/// All outputs for some snapshots.
fn run(model: &ModelProto, snapshots: &Array2<f32>) -> Values {
    let graph = model.graph.as_ref().unwrap();
    let mut values: Values = graph
        .initializer
        .iter()
        .map(|array| (array.name.clone(), tensor(array)))
        .collect();
    let raw = snapshots.mapv(f64::from).into_dyn();
    values.insert(graph.input[0].name.clone(), raw);
    for node in &graph.node {
        let value = work_out(node, &values);
        assert!(values.insert(node.output[0].clone(), value).is_none());
    }
    let named = graph.output.iter().map(|output| {
        let value = values[&output.name].clone();
        let told = output
            .r#type
            .as_ref()
            .unwrap()
            .tensor_type
            .as_ref()
            .unwrap();
        let shape = &told.shape.as_ref().unwrap().dim;
        assert_eq!(shape.len(), value.ndim(), "{}", output.name);
        for (axis, length) in shape.iter().zip(value.shape()) {
            assert!(axis.dim_value.is_none_or(|told| told as usize == *length));
        }
        (output.name.clone(), value)
    });
    named.collect()
}

const BEAMS: usize = 37;

/// A laser of 37 beams, which no number of sectors divides, two lights, one of which is missing at times, and a beacon.
fn recording() -> Recording {
    let channel = |name: &str, width: usize, unit: &str| Channel {
        name: name.into(),
        width,
        unit: unit.into(),
        bearing_rad: (width == BEAMS).then(|| {
            let bearing = |b: usize| (b as f64 / BEAMS as f64 - 0.5) * 3.0;
            (0..BEAMS).map(bearing).collect()
        }),
        maximum: (unit == "m").then_some(30.0),
        offset_m: None,
    };
    let pose: Vec<Pose> = (0..90)
        .map(|k| Pose::new(0.5 * f64::from(k % 45), 0.0, 0.0))
        .collect();
    let value = |(k, d): (usize, usize)| match (k * 7 + d * 13) % 17 {
        0 if d != BEAMS => f32::NAN,
        other if d < BEAMS => other as f32 * 0.7 + ((k % 45) as f32 * 0.31).sin(),
        other => other as f32 - 5.0,
    };
    Recording::new(Columns {
        channels: vec![
            channel("light", 2, "lx"),
            channel("laser", BEAMS, "m"),
            channel("beacon", 1, "m"),
        ],
        values: Array2::from_shape_fn((90, BEAMS + 3), |(k, d)| {
            value((k, (d + BEAMS + 1) % (BEAMS + 3)))
        }),
        stamp_s: (0..90).map(f64::from).collect(),
        odometry: pose.clone(),
        pose,
        run: (0..90).map(|k| k / 45).collect(),
        ..Columns::default()
    })
    .unwrap()
}

pub(super) fn trained(change: impl Fn(&mut Recipe)) -> Model {
    let mut recipe = Recipe {
        features: 3,
        begin_with: BeginWith::Random,
        ..Recipe::default()
    };
    recipe.descent.steps = 2;
    change(&mut recipe);
    let recording = recording();
    Training::new(&recipe, &recording).run().unwrap().model
}

/// Snapshots of the recording, random ones, and extremes.
fn snapshots() -> Array2<f32> {
    let recording = recording();
    let mut random = Seed(4).stream("snapshots");
    let width = recording.values().ncols();
    let drawn = Array2::from_shape_simple_fn((40, width), || match random.random_range(0..8) {
        0 => f32::NAN,
        1 => 1e6,
        2 => -3.0,
        _ => random.random_range(0.0..40.0),
    });
    let nothing = Array2::from_elem((1, width), f32::NAN);
    let parts = [recording.values().view(), drawn.view(), nothing.view()];
    ndarray::concatenate(Axis(0), &parts).unwrap()
}

fn assert_answers(model: &Model, found: &ArrayD<f64>) {
    let snapshots = snapshots();
    let expected = model.detector();
    let expected = expected
        .detect_batch(&model.header.channels, snapshots.view())
        .unwrap();
    assert_eq!(found.shape(), [snapshots.nrows(), model.features()]);
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            (found - f64::from(*expected)).abs() < 1e-5,
            "{found} {expected}"
        );
    }
    // It says something: not all alike.
    let first = expected[(0, 0)];
    assert!(expected.column(0).iter().any(|p| (p - first).abs() > 1e-3));
}

pub(super) fn bank_of_one(model: &Model) -> ModelBank {
    ModelBank::new(vec![model.clone()], vec![0; model.pose.len()]).unwrap()
}

fn assert_read_back(bank: &ModelBank) {
    let bytes = to_bytes(bank).unwrap();
    let again = ModelBank::from_bytes("m.onnx".as_ref(), &bytes).unwrap();
    assert_eq!(&again, bank);
}

#[test]
fn the_graph_answers_as_the_model_and_is_read_back() {
    let shapes: [fn(&mut Recipe); 4] = [
        |_| (),
        |recipe| recipe.network.activation = Activation::Relu,
        |recipe| {
            recipe.network.hidden = vec![];
            recipe.input.channels = vec!["light".into(), "beacon".into()];
        },
        |recipe| {
            recipe.network.trunk = vec![5];
            recipe.input.channels = vec!["laser".into()];
            recipe.input.sectors = 9;
            recipe.network.convolutions = vec![crate::detector::net::ConvolutionConfig {
                channels: 2,
                width: 3,
                stride: 2,
            }];
        },
    ];
    for change in shapes {
        let model = trained(change);
        let file = file(&bank_of_one(&model)).unwrap();
        assert_answers(&model, &run(&file, &snapshots())["probability"]);
        assert_read_back(&bank_of_one(&model));
    }
}

#[test]
fn a_bank_has_an_output_a_set_and_one_map() {
    let wide: Uncertainty = "10m".parse().unwrap();
    let sets = vec![
        trained(|_| ()),
        trained(|recipe| {
            recipe.uncertainty = wide;
            recipe.seed = 9;
            recipe.features = 2;
        }),
    ];
    let runs = (0..sets[0].pose.len()).map(|k| k / 45).collect();
    let bank = ModelBank::new(sets.clone(), runs).unwrap();
    assert_read_back(&bank);
    let fault = Model::from_bytes("m.onnx".as_ref(), &to_bytes(&bank).unwrap()).unwrap_err();
    assert!(fault.to_string().contains("a bank of 2 sets"), "{fault}");
    let file = file(&bank).unwrap();
    let found = run(&file, &snapshots());
    assert_answers(&sets[0], &found["probability.2m"]);
    assert_answers(&sets[1], &found["probability.10m"]);
    let poses = &found["map.pose"];
    assert_eq!(poses[[3, 0]], sets[0].pose[3].x_m);
    assert_eq!(found["map.run"][[50]], 1.0);
    let activation = &found["set.10m.map.activation"];
    assert_eq!(activation[[2, 1]], f64::from(sets[1].activation[(2, 1)]));
    // Every name is there once, and none is used that isn't.
    let graph = file.graph.as_ref().unwrap();
    let mut names: Vec<&String> = graph.initializer.iter().map(|array| &array.name).collect();
    names.extend(graph.node.iter().flat_map(|node| &node.output));
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all);
}

#[test]
fn an_occupancy_map_travels_with_its_frame() {
    use crate::mapping::{
        Occupancy::{Free, Occupied, Unknown},
        OccupancyMap,
    };
    let mut model = trained(|_| ());
    let cells = vec![Free, Occupied, Unknown, Free, Free, Free];
    model.occupancy = Some(OccupancyMap::from_cells(0.25, [-1.0, 2.0], 3, cells).unwrap());
    let found = run(&file(&bank_of_one(&model)).unwrap(), &snapshots());
    let numbers: Vec<f64> = found["map.occupancy"].iter().copied().collect();
    assert_eq!(numbers, [0.0, 100.0, 255.0, 0.0, 0.0, 0.0]);
    assert_eq!(found["map.occupancy"].shape(), [2, 3]);
    let frame: Vec<f64> = found["map.occupancy.frame"].iter().copied().collect();
    assert_eq!(frame, [-1.0, 2.0, 0.25]);
}

#[test]
fn the_file_says_what_it_is() {
    let model = trained(|_| ());
    let file = file(&bank_of_one(&model)).unwrap();
    let read = ModelProto::decode(file.encode_to_vec().as_slice()).unwrap();
    assert_eq!(read, file);
    let value = |key: &str| {
        let mut all = read.metadata_props.iter();
        let entry = all.find(|entry| entry.key == key).unwrap();
        serde_json::from_str::<serde_json::Value>(&entry.value).unwrap()
    };
    assert_eq!(value("ballmark")["prior"], "2m");
    assert_eq!(
        value("channels")[1]["bearing_rad"]
            .as_array()
            .unwrap()
            .len(),
        BEAMS
    );
    let doc = &read.graph.as_ref().unwrap().input[0].doc_string;
    assert!(
        doc.contains("light (2, lx), laser (37, m), beacon (1, m)"),
        "{doc}"
    );
}
