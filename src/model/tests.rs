//! Models come back as they went, and what is no model is refused by name: in both containers alike.

use super::{
    arrays::{Arrays, Values},
    *,
};
use crate::{
    belief::{Grid, GridConfig, Uncertainty},
    geometry::Pose,
    learning::Recipe,
    mapping::{Occupancy, OccupancyMap, RangeSensors},
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use ndarray::{Array2, ArrayD, IxDyn};
use rand::RngExt;
use serde_json::{Value, json};

mod rendered;

const CONTAINERS: [&str; 2] = ["safetensors", "npz"];

/// A model after two steps on forty snapshots; its numbers are of all lengths.
fn model(with_route: bool) -> Model {
    let mut random = Seed(3).stream("toy");
    let k = 40;
    let pose: Vec<Pose> = (0..k)
        .map(|k| Pose::new(k as f64 / 7.0, (k as f64).sin(), 0.1))
        .collect();
    let recording = Recording::new(Columns {
        channels: vec![Channel {
            name: "sonar".into(),
            width: 12,
            unit: "m".into(),
            bearing_rad: Some((0..12).map(|b| f64::from(b) * 0.5235987755982988).collect()),
            maximum: Some(4.7),
            offset_m: None,
        }],
        values: Array2::from_shape_simple_fn((k, 12), || random.random_range(0.2..5.0)),
        stamp_s: (0..k).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        run: vec![0; k],
        route_m: with_route.then(|| (0..k).map(|k| k as f64 / 7.0).collect()),
        pose,
        ..Columns::default()
    })
    .unwrap();
    let mut recipe = Recipe {
        features: 2,
        uncertainty: Uncertainty::Global,
        ..Recipe::default()
    };
    recipe.descent.steps = 2;
    recipe.network.trunk = vec![5];
    recipe.network.hidden = vec![3, 2];
    Training::new(&recipe, &recording).run().unwrap().model
}

#[test]
fn comes_back_to_the_same_bits_through_both_containers() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for with_route in [true, false] {
        let mut model = model(with_route);
        let mut random = Seed(4).stream("scores");
        for _ in 0..12 {
            // JSON readers that round twice lose the last bit of some of these.
            model.header.scores.train.posterior_error_m = random.random_range(0.0..20.0);
            model.write(&at("a.safetensors")).unwrap();
            let once = Model::read(&at("a.safetensors")).unwrap();
            once.write(&at("a.npz")).unwrap();
            let twice = Model::read(&at("a.npz")).unwrap();
            assert_eq!((&once, &twice), (&model, &model));
        }
        let detector = |m: &Model| m.detector().respond(Array2::ones((1, 12)).view()).unwrap();
        let again = Model::read(&at("a.npz")).unwrap();
        assert_eq!(detector(&again), detector(&model));
        for container in CONTAINERS {
            let bytes = |name: &str| {
                let path = at(name).with_extension(container);
                again.write(&path).unwrap();
                std::fs::read(path).unwrap()
            };
            assert!(bytes("b") == bytes("c"), "{container}");
        }
    }
}

/// Writes a model whose header and arrays a test has spoilt, and returns what reading it says, container by container.
fn spoilt(meta: &str, arrays: &Arrays) -> [String; 2] {
    let folder = tempfile::tempdir().unwrap();
    CONTAINERS.map(|container| {
        let path = folder.path().join("bad").with_extension(container);
        match container {
            "npz" => npz::write(&path, meta, arrays).unwrap(),
            _ => safetensors::write(&path, meta, arrays).unwrap(),
        }
        let error = Model::read(&path).expect_err("a spoilt model was read");
        assert!(!error.is_usage(), "{error}");
        let line = error.to_string();
        assert!(
            line.contains(&format!("bad.{container}: ")) && !line.contains('\n'),
            "{line}"
        );
        line
    })
}

#[track_caller]
fn refused(meta: &str, arrays: &Arrays, parts: &[&str]) {
    for line in spoilt(meta, arrays) {
        for part in parts {
            assert!(line.contains(part), "`{part}` is missing in: {line}");
        }
    }
}

fn without(arrays: &Arrays, gone: &str) -> Arrays {
    let mut rest = Arrays::new("bad".as_ref());
    for (name, values) in arrays.all().filter(|(name, _)| *name != gone) {
        match values {
            Values::U8(a) => rest.put_u8(name, a.clone()),
            Values::F32(a) => rest.put_f32(name, a.clone()),
            Values::F64(a) => rest.put_f64(name, a.clone()),
        }
    }
    rest
}

fn all_of(model: &Model) -> Arrays {
    layout::arrays(model, "bad".as_ref())
}

#[test]
fn every_array_is_needed_in_its_type_and_shape_with_finite_numbers() {
    let model = model(true);
    let (meta, whole) = (model.meta().unwrap(), all_of(&model));
    for (name, values) in whole.all() {
        let place = format!("array `{name}`");
        if name != "map.route" {
            refused(&meta, &without(&whole, name), &[&place, "missing"]);
        }
        let mut other_type = without(&whole, name);
        let mut not_finite = without(&whole, name);
        let mut misshapen = without(&whole, name);
        let mut flat = without(&whole, name);
        match values {
            Values::U8(_) => continue, // any number it can hold is one; its own test holds it
            Values::F32(a) => {
                other_type.put_f64(name, a.mapv(f64::from));
                not_finite.put_f32(name, a.mapv(|_| f32::NAN));
                misshapen.put_f32(name, ArrayD::zeros(&*vec![1; a.ndim()]));
                flat.put_f32(name, ArrayD::zeros(IxDyn(&[2, 2, 2, 2])));
            }
            Values::F64(a) => {
                other_type.put_f32(name, a.mapv(|v| v as f32));
                not_finite.put_f64(name, a.mapv(|_| f64::INFINITY));
                misshapen.put_f64(name, ArrayD::zeros(&*vec![1; a.ndim()]));
                flat.put_f64(name, ArrayD::zeros(IxDyn(&[2, 2, 2, 2])));
            }
        }
        refused(&meta, &other_type, &[&place, "expected f"]);
        refused(&meta, &not_finite, &[&place, "entry 0", "not finite"]);
        refused(&meta, &flat, &[&place, "[2, 2, 2, 2]; expected", "axes"]);
        // The last layer's bias has one entry as it should.
        if !name.ends_with(".2.bias") {
            refused(&meta, &misshapen, &["expected"]);
        }
    }
}

#[test]
fn other_layouts_are_refused_by_name() {
    let model = model(false);
    for name in [
        "filter.0.conv1.weight",
        "filter.2.0.weight",
        "filter.0.3.bias",
        "filter.00.0.weight",
        "filter.0.0.scale",
        "set.2m.filter.0.0.weight",
    ] {
        let mut arrays = without(&all_of(&model), "filter.0.0.weight");
        arrays.put_f32(name, ArrayD::zeros(IxDyn(&[2])));
        let place = format!("array `{name}`");
        refused(&model.meta().unwrap(), &arrays, &[&place, "layout"]);
    }
    // Others may keep arrays of their own beside.
    let mut arrays = all_of(&model);
    arrays.put_f64("notes", ArrayD::zeros(IxDyn(&[2])));
    let read = layout::model("bad".as_ref(), &model.meta().unwrap(), &arrays).unwrap();
    assert_eq!(read, model);
}

#[test]
fn a_header_that_claims_too_much_is_refused() {
    let model = model(false);
    let arrays = all_of(&model);
    let mut header: Value = serde_json::from_str(&model.meta().unwrap()).unwrap();
    header["evidence_scale"] = json!(0.5);
    header["lost"] = json!(crate::belief::lost::LostConfig::default());
    let claims = |pointer: &str, value: Value| {
        let mut claims = header.clone();
        *claims.pointer_mut(pointer).expect(pointer) = value;
        claims.to_string()
    };
    let ranges = "/input/channels/0/kind/ranges";
    for (pointer, value, part) in [
        ("/recipe/features", json!(1_000_000_000), "features"),
        ("/recipe/features", json!(0), "features"),
        ("/evidence_scale", json!(0.0), "evidence_scale is 0"),
        ("/evidence_scale", json!(-2.5), "evidence_scale is -2.5"),
        ("/lost/slope", json!(-1.0), "`slope` is -1"),
        ("/recipe/features", json!(3), "`filter.2.0.weight`: missing"),
        ("/recipe/features", json!(-1), "expected usize"),
        ("/recipe/network/hidden", json!([1u64 << 60]), "units"),
        (
            "/recipe/network/hidden",
            json!(vec![1; 100_000]),
            "100000 layers",
        ),
        (
            "/recipe/network/hidden",
            json!([3, 7]),
            "shape [2, 3]; expected [7, 3]",
        ),
        (
            "/recipe/map/nearness/k",
            json!(1_000_000),
            "or at least map.nearness.k",
        ),
        ("/recipe/map/unmodelled_probability", json!(2), "unmodelled"),
        ("/input/channels", json!([]), "layout"), // no scan, so no convolutions
        ("/input/channels/0/width", json!(0), "channel `sonar`"),
        (
            &format!("{ranges}/sectors"),
            json!(u64::MAX),
            "channel `sonar`",
        ),
        (&format!("{ranges}/sectors"), json!(6), "expected 6 of each"),
        (&format!("{ranges}/clip"), json!(-1.0), "channel `sonar`"),
        (&format!("{ranges}/far_clip"), json!(0.1), "channel `sonar`"),
        (&format!("{ranges}/sector_values"), json!([]), "channel"),
        ("/prior", json!("0m"), "uncertainty `0m`"),
        ("/scores", json!(null), "null"),
    ] {
        refused(&claims(pointer, value), &arrays, &[part]);
    }
    refused("not JSON", &arrays, &["header", "expected"]);
    let mut zero = without(&arrays, "input.deviation");
    zero.put_f32("input.deviation", ArrayD::zeros(IxDyn(&[12])));
    refused(&header.to_string(), &zero, &["deviation of 0"]);
    let mut sure = without(&arrays, "map.activation");
    sure.put_f32(
        "map.activation",
        ArrayD::from_elem(IxDyn(&[model.pose.len(), 2]), 1.5),
    );
    refused(&header.to_string(), &sure, &["map.activation", "holds 1.5"]);
}

#[test]
fn no_truncation_is_read_and_no_damage_panics() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Seed(7).stream("damage");
    for container in CONTAINERS {
        let path = folder.path().join("m").with_extension(container);
        model(true).write(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for len in (0..whole.len()).step_by(7).chain([1, whole.len() - 1]) {
            let error = Model::from_bytes(&path, &whole[..len]).expect_err("a truncated model");
            assert!(error.is_input(), "{len}: {error}");
            assert!(error.to_string().contains("expected"), "{len}: {error}");
        }
        for _ in 0..1500 {
            let mut damaged = whole.clone();
            for _ in 0..random.random_range(1..4) {
                // Mostly near the ends, where the lengths and counts stand.
                let reach = damaged.len() >> random.random_range(0..6);
                let at = random.random_range(0..reach.max(1));
                let at = if random.random() {
                    at
                } else {
                    damaged.len() - 1 - at
                };
                damaged[at] = random.random();
            }
            if let Err(error) = Model::from_bytes(&path, &damaged) {
                assert!(!error.to_string().contains('\n'), "{error}");
            }
        }
    }
}
