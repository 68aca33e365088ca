//! Model files on the real binary: through both containers and back, and refused where they are none.

use crate::{
    support::{Answer, Workplace},
    train::toy,
};
use ballmark::model::Model;
use std::fs;

/// Long enough to be better than random features, which would be kept instead.
const SMALL: [&str; 6] = [
    "--features",
    "2",
    "--steps",
    "200",
    "--config",
    "small.toml",
];

/// A folder with `m.safetensors` and `m.npz`, the same small model.
fn trained() -> Workplace {
    let place = Workplace::new();
    toy(&place, true);
    place.write("small.toml", "[train.input]\nhistory_m = []\n");
    place
        .ballmark(&[&["train", "toy.npz", "-o", "m.safetensors"][..], &SMALL].concat())
        .done();
    export(&place, "m.safetensors", "m.npz").done();
    place
}

fn export(place: &Workplace, from: &str, to: &str) -> Answer {
    place.ballmark(&["export", from, "-o", to])
}

#[test]
fn export_goes_round_to_the_same_bytes() {
    let place = trained();
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    let answer = export(&place, "m.npz", "back.safetensors");
    answer.done();
    assert!(answer.stdout.contains("2 filters"), "{}", answer.stdout);
    export(&place, "back.safetensors", "back.npz").done();
    assert!(bytes("back.safetensors") == bytes("m.safetensors"));
    assert!(bytes("back.npz") == bytes("m.npz"));
    assert_eq!(
        Model::read(&place.path("m.npz")).unwrap(),
        Model::read(&place.path("m.safetensors")).unwrap()
    );
    // What a file is, its content tells.
    fs::rename(place.path("m.npz"), place.path("misnamed.safetensors")).unwrap();
    export(&place, "misnamed.safetensors", "again.npz").done();
    assert!(bytes("again.npz") == bytes("back.npz"));
    // Training writes either.
    place
        .ballmark(&[&["train", "toy.npz", "-o", "direct.npz"][..], &SMALL].concat())
        .done();
    assert!(bytes("direct.npz") == bytes("back.npz"));
}

#[test]
fn what_is_no_whole_model_is_refused() {
    let place = trained();
    let before = place.files();
    let mut bad: Vec<(Vec<u8>, &str)> = vec![
        (b"".to_vec(), "the file is empty; expected a model"),
        (b"hello".to_vec(), "not a whole .safetensors"),
        (b"PK\x03\x04 and no more".to_vec(), "not a whole .npz"),
        (vec![0xff; 100], "not a whole .safetensors"),
        // A header as long as the address space.
        (
            [&[0xff; 7][..], b"\x7f{}"].concat(),
            "not a whole .safetensors",
        ),
        // A tensor of 2^60 numbers.
        (
            safetensors(
                r#"{"a":{"dtype":"F32","shape":[1152921504606846976],"data_offsets":[0,4]}}"#,
            ),
            "not a whole",
        ),
        (
            safetensors(r#"{"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}"#),
            "metadata key `ballmark`",
        ),
        (
            safetensors(
                r#"{"__metadata__":{"ballmark":"{}"},"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]}}"#,
            ),
            "header: missing field",
        ),
        (
            safetensors(
                r#"{"__metadata__":{"ballmark":"{}"},"a":{"dtype":"I32","shape":[1],"data_offsets":[0,4]}}"#,
            ),
            "array `a`: I32; expected U8, F32 or F64",
        ),
        (fs::read(place.path("toy.npz")).unwrap(), "array `run`"),
        (fs::read(place.path("toy.csv")).unwrap(), "not a whole"),
    ];
    for name in ["m.safetensors", "m.npz"] {
        let whole = fs::read(place.path(name)).unwrap();
        let cuts = (1..40)
            .map(|i| i * whole.len() / 40)
            .chain([1, whole.len() - 1]);
        bad.extend(cuts.map(|len| (whole[..len].to_vec(), "expected a model")));
    }
    for (content, fault) in bad {
        fs::write(place.path("bad"), content).unwrap();
        export(&place, "bad", "out.npz").refused(1, &["bad: ", fault]);
        assert!(!place.path("out.npz").exists());
    }
    fs::remove_file(place.path("bad")).unwrap();
    assert_eq!(place.files(), before, "something was left behind");
    export(&place, "none.npz", "out.npz").refused(1, &["none.npz", "cannot read"]);
}

/// A .safetensors file of this header and four bytes of numbers.
fn safetensors(header: &str) -> Vec<u8> {
    let len = (header.len() as u64).to_le_bytes();
    [&len[..], header.as_bytes(), &[0; 4]].concat()
}

#[test]
fn an_npz_that_claims_or_lacks_something_is_refused_by_the_array() {
    let place = trained();
    let model = Model::read(&place.path("m.npz")).unwrap();
    let header = serde_json::to_string(&model.header).unwrap();
    let weight = ndarray::Array2::<f32>::zeros((6, 8));
    let many = header.replace("\"features\":2", "\"features\":1000000000");
    let wide = header.replace("\"trunk\":[64]", "\"trunk\":[9000000000000]");
    assert!(many != header && wide != header);
    for (meta, name, fault) in [
        (
            Some(&header),
            "filter.0.0.weight",
            "array `filter.trunk.0.weight`: missing",
        ),
        (
            Some(&header),
            "filter.trunk.0.weight",
            "array `filter.trunk.0.weight`: shape [6, 8]; expected [128, ",
        ),
        (
            Some(&header),
            "filter.trunk.2.weight",
            "array `filter.trunk.2.weight`: a layout",
        ),
        (
            Some(&header),
            "filter.0.conv1.weight",
            "array `filter.0.conv1.weight`: a layout",
        ),
        (
            Some(&header),
            "filter.7.0.weight",
            "array `filter.7.0.weight`: a layout",
        ),
        (
            Some(&many),
            "filter.0.0.weight",
            "header: recipe: features = 1000000000",
        ),
        (
            Some(&wide),
            "filter.0.0.weight",
            "header: recipe: network.trunk",
        ),
        (None, "filter.0.0.weight", "array `meta`: missing"),
    ] {
        ballmark::archive::write(&place.path("bad.npz"), |archive| {
            if let Some(meta) = meta {
                archive.add("meta", ndarray::ArrayView1::from(meta.as_bytes()))?;
            }
            archive.add("input.mean", ndarray::Array1::<f32>::zeros(8).view())?;
            archive.add("input.deviation", ndarray::Array1::<f32>::ones(8).view())?;
            archive.add(name, weight.view())
        })
        .unwrap();
        export(&place, "bad.npz", "out.safetensors").refused(1, &["bad.npz: ", fault]);
    }
    assert!(!place.path("out.safetensors").exists());
}

#[test]
fn outputs_that_cannot_be_written_are_told() {
    let place = trained();
    let before = place.files();
    for output in ["m.pt", "m", "m.npz.gz"] {
        export(&place, "m.npz", output)
            .refused(2, &[output, "ending in .onnx, .safetensors or .npz"]);
    }
    export(&place, "m.npz", "toy.csv/m.npz").refused(1, &["toy.csv/m.npz", "is a file"]);
    export(&place, "m.npz", "nowhere/m.npz").refused(1, &["nowhere/m.npz", "does not exist"]);
    assert_eq!(place.files(), before);
}

/// `tests/onnx/check.py` asks ONNX's own runtime what the file answers; here is what needs no Python.
#[test]
fn a_graph_is_written_whole_and_alike_each_time() {
    let place = trained();
    export(&place, "m.npz", "m.onnx").done();
    export(&place, "m.npz", "again.onnx").done();
    let bytes = std::fs::read(place.path("m.onnx")).unwrap();
    assert_eq!(bytes, std::fs::read(place.path("again.onnx")).unwrap());
    let holds = |name: &str| {
        bytes
            .windows(name.len())
            .any(|part| part == name.as_bytes())
    };
    for name in [
        "snapshot",
        "probability",
        "map.activation",
        "Sigmoid",
        "\"recipe\"",
    ] {
        assert!(holds(name), "{name}");
    }
    export(&place, "m.npz", "nowhere/m.onnx").refused(1, &["nowhere/m.onnx", "does not exist"]);
    // And is a model as well: nothing is lost on the way.
    export(&place, "m.onnx", "back.npz").done();
    let back = std::fs::read(place.path("back.npz")).unwrap();
    assert_eq!(back, std::fs::read(place.path("m.npz")).unwrap());
    let mut changed = bytes;
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    std::fs::write(place.path("changed.onnx"), changed).unwrap();
    export(&place, "changed.onnx", "no.npz").refused(1, &["changed.onnx", "changed since"]);
}
