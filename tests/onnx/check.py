"""Exported graphs by ONNX's own checker and runtime: do they answer as `ballmark features` does?

    pip install -r tests/onnx/requirements.txt
    python tests/onnx/check.py target/release/ballmark [MODEL.safetensors ...]

Without models: those in models/, and a bank that is trained here. Each is exported, checked in full, read back, and asked about 10,000 random snapshots (a
tenth of the values missing, some at the ends of their range) and, for the shipped corridor models, the shipped recording. At last the Bayes
filter of models/README.md runs on that.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import onnx
import onnxruntime

ROOT = pathlib.Path(__file__).resolve().parents[2]
SNAPSHOTS = 10_000
WITHIN = 1e-5


def ballmark(binary, *arguments):
    done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"ballmark {' '.join(map(str, arguments))}: {done.stderr}")


def random_values(channels, rng):
    """One array a channel, float32, NaN where nothing came back."""
    values = {}
    for channel in channels:
        most = channel.get("maximum") or 50.0
        drawn = rng.uniform(0.0, 1.2 * most, (SNAPSHOTS, channel["width"]))
        drawn[rng.random(drawn.shape) < 0.05] = 0.0
        drawn[rng.random(drawn.shape) < 0.05] = 1e6
        drawn[rng.random(drawn.shape) < 0.1] = np.nan
        drawn[0] = np.nan
        values[channel["name"]] = drawn.astype(np.float32)
    return values


def write_dataset(path, channels, values):
    k = len(next(iter(values.values())))
    pose = np.zeros((k, 3))
    pose[:, 0] = np.arange(k)
    meta = {"channels": {c["name"]: {key: c.get(key) for key in ("unit", "bearing_rad", "maximum")} for c in channels}}
    text = np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8)
    run = np.zeros(k, dtype=np.int64)
    np.savez(path, stamp=np.arange(k, dtype=float), pose=pose, odometry=pose, run=run, meta=text, **values)


def answers(binary, model, dataset, folder):
    """`ballmark features`, a column an output: those of a bank's sets behind one another."""
    out = folder / "features.csv"
    ballmark(binary, "features", model, dataset, "-o", out)
    with open(out, newline="") as file:
        rows = list(csv.reader(file))
    own = [k for k, name in enumerate(rows[0]) if name.split(".")[-1][0] == "f" and name.split(".")[-1][1:].isdigit()]
    return np.array([[float(row[k]) for k in own] for row in rows[1:]])


def check(binary, model, folder, dataset=None):
    graph = folder / "graph.onnx"
    ballmark(binary, "export", model, "-o", graph)
    loaded = onnx.load(graph)
    onnx.checker.check_model(loaded, full_check=True)
    meta = {entry.key: entry.value for entry in loaded.metadata_props}
    session = onnxruntime.InferenceSession(graph, providers=["CPUExecutionProvider"])
    channels = json.loads(meta["channels"])
    sources = {}
    random = folder / "random.npz"
    write_dataset(random, channels, random_values(channels, np.random.default_rng(1)))
    sources["random"] = random
    if dataset:
        sources["recorded"] = dataset
    wanted = [o.name for o in session.get_outputs() if o.name.split(".")[0] == "probability"]
    for what, file in sources.items():
        arrays = np.load(file)
        raw = np.concatenate([arrays[c["name"]] for c in channels], axis=1).astype(np.float32)
        found = np.concatenate(session.run(wanted, {"snapshot": raw}), axis=1)
        single = np.concatenate(session.run(wanted, {"snapshot": raw[:1]}), axis=1)  # the batch is dynamic
        expected = answers(binary, model, file, folder)
        off = np.abs(found - expected).max()
        print(f"{pathlib.Path(model).name}, {what}: {len(raw)} snapshots, {found.shape[1]} features, off by {off:.1e}")
        if found.shape != expected.shape or not off <= WITHIN or not np.abs(single - found[:1]).max() <= WITHIN:
            sys.exit(f"{model}: expected within {WITHIN}")
        if not np.array_equal(answers(binary, graph, file, folder), expected):
            sys.exit(f"{model}: its graph, read back as a model, answers otherwise")


def localise(binary, folder, dataset):
    """The Bayes filter of models/README.md, word for word, along every run of a recording that the model never saw."""
    text = (ROOT / "models" / "README.md").read_text()
    code = text.split("## As an ONNX graph")[1].split("```python\n")[1].split("```")[0]
    ballmark(binary, "export", ROOT / "models" / "corridor-2m.safetensors", "-o", folder / "corridor-2m.onnx")
    channels = json.loads({p.key: p.value for p in onnx.load(folder / "corridor-2m.onnx").metadata_props}["channels"])
    arrays = np.load(dataset)
    raw = np.concatenate([arrays[c["name"]] for c in channels], axis=1)
    odometry, route, runs = arrays["odometry"], arrays["route"], arrays["run"]
    for run in np.unique(runs):
        own = np.flatnonzero(runs == run)
        names = {}
        exec(code.replace('"corridor-2m.onnx"', repr(str(folder / "corridor-2m.onnx"))), names)
        belief, off_m = names["belief"], []
        for before, k in zip([own[0], *own], own):
            moved_m = np.hypot(*(odometry[k, :2] - odometry[before, :2]))
            belief = names["correct"](names["predict"](belief, moved_m), raw[k])
            off_m.append(abs(names["cells_m"][belief.argmax()] - route[k]))
        half = off_m[len(off_m) // 2 :]
        print(f"run {run}: {len(own)} snapshots, second half off by {np.median(half):.2f} m in the median")
        if not np.median(half) < 0.5:
            sys.exit("the Bayes filter of models/README.md: expected to be within 0.5 m in the second half of every run")


def main():
    binary, *models = sys.argv[1:]
    binary = str(pathlib.Path(binary).resolve())
    corridor = ROOT / "datasets" / "corridor-small.npz"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if models:
            for model in models:
                check(binary, model, folder)
            return
        for model in sorted((ROOT / "models").glob("corridor-*.safetensors")):
            check(binary, model, folder, corridor)
        bank = folder / "bank.safetensors"
        ballmark(binary, "train", corridor, "-o", bank, "--uncertainty", "bank", "--steps", 20, "--features", 2)
        check(binary, bank, folder, corridor)
        check(binary, ROOT / "models" / "lidar-180.safetensors", folder)
        localise(binary, folder, corridor)


main()
