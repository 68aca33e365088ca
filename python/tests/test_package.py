"""The package on the repository's own dataset and model: everything once, and what is wrong."""

import pathlib
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import ballmark

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
DATASET = REPOSITORY / "datasets" / "corridor-small.npz"
MODEL = REPOSITORY / "models" / "corridor-2m.safetensors"


def test_a_dataset_is_what_numpy_reads(tmp_path):
    dataset = ballmark.read(DATASET)
    arrays = np.load(DATASET, allow_pickle=False)
    assert len(dataset) == len(arrays["stamp"])
    for name in ("stamp", "pose", "odometry", "run", "route"):
        np.testing.assert_array_equal(getattr(dataset, name), arrays[name])
    np.testing.assert_array_equal(dataset["sonar"], arrays["sonar"])
    channel = dataset.channels["sonar"]
    assert channel.unit == "m" and len(channel.bearing_rad) == 24
    dataset.write(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").exists()
    assert "24" in repr(dataset)


def test_values_are_a_view_that_keeps_its_dataset_and_cannot_be_written():
    values = ballmark.read(DATASET)["sonar"]  # the dataset itself has no other holder
    assert values.base is not None and not values.flags.writeable and not values.flags.owndata
    with pytest.raises(ValueError):
        values[0, 0] = 1.0
    assert np.isfinite(values).any()


def test_arrays_make_a_dataset_and_faults_are_sentences(tmp_path):
    k = 5
    pose = np.stack([np.arange(k), np.zeros(k), np.zeros(k)], axis=1)
    made = ballmark.Dataset.from_arrays(
        stamp=range(k),
        pose=pose,
        channels={
            "light": np.arange(k),
            "sonar": ballmark.Channel(np.full((k, 2), np.inf), unit="m", bearing_rad=[0.0, 1.0]),
        },
    )
    np.testing.assert_array_equal(made.odometry, pose)
    np.testing.assert_array_equal(made["light"][:, 0], np.arange(k))
    assert np.isnan(made["sonar"]).all()
    made.write(tmp_path / "made.npz")
    assert ballmark.read(tmp_path / "made.npz").channels == made.channels
    for change, sentence in [
        ({"pose": pose[:, :2]}, "expected 3: x and y"),
        ({"channels": {"light": np.zeros((k + 1, 1))}}, "6 rows; expected 5"),
        ({"channels": {}}, "expected at least one sensor channel"),
        ({"stamp": range(k - 1)}, "4 entries; expected 5"),
        ({"pose": pose * np.nan}, "not a finite number"),
    ]:
        columns = {"stamp": range(k), "pose": pose, "channels": {"light": np.zeros((k, 1))}} | change
        with pytest.raises((ValueError, RuntimeError), match=sentence):
            ballmark.Dataset.from_arrays(**columns)
    with pytest.raises(OSError, match="absent.npz: cannot read"):
        ballmark.read(tmp_path / "absent.npz")
    with pytest.raises(ValueError, match="not a whole .npz file"):
        ballmark.read(__file__)
    with pytest.raises(KeyError):
        made["sonnar"]


def test_logs_come_in_with_their_account(tmp_path):
    log = tmp_path / "walk.csv"
    rows = "".join(f"{k};{k},5;0;0;{100 + k}\n" for k in range(4))
    log.write_text("time_s;x_m;y_m;heading_rad;sonar.0\n" + rows + "x;0;0;0;1\n")
    with pytest.warns(UserWarning, match="1 records dropped: line 6"):
        dataset, account = ballmark.import_log(log, unit={"sonar": "cm"}, bearings={"sonar": [90]}, offset={"sonar": 0.1})
    assert dataset.pose[1, 0] == 1.5 and dataset["sonar"][0, 0] == pytest.approx(1.0)
    assert dataset.channels["sonar"].bearing_rad == [pytest.approx(np.pi / 2)]
    assert account["dropped"] == 1 and any("cm made metres" in note for note in account["notes"])
    with pytest.raises(ValueError, match="no channel is called `laser`"):
        ballmark.import_log(log, unit={"laser": "cm"})


def test_probabilities_are_the_command_s():
    dataset, model = ballmark.read(DATASET), ballmark.Model.read(MODEL)
    probability = model.probabilities(dataset)
    assert probability.shape == (len(dataset), model.features) and probability.dtype == np.float32
    assert ((probability > 0) & (probability < 1)).all()
    np.testing.assert_array_equal(model.probabilities(np.array(dataset["sonar"])), probability)
    np.testing.assert_array_equal(model.probabilities(dataset["sonar"][7]), probability[7])
    assert model.probabilities(np.zeros((0, 24))).shape == (0, model.features)
    with pytest.raises(ValueError, match="expected 24: 24 of `sonar`"):
        model.probabilities(np.zeros((2, 23)))


def test_training_tells_how_it_goes_and_ends_when_told(tmp_path):
    dataset = ballmark.read(DATASET)
    options = {"uncertainty": "2m", "features": 2, "seed": 3, "config": {"train": {"begin_with": "random"}}}
    seen = []
    model = ballmark.train(dataset, steps=12, on_progress=lambda *at: seen.append(at), **options)
    assert model.features == 2 and seen[-1][:2] == (12, 12)
    assert model.header["recipe"]["seed"] == 3 and set(model.scores) == {"train", "validation"}
    model.write(tmp_path / "model.safetensors")
    again = ballmark.Model.read(tmp_path / "model.safetensors")
    np.testing.assert_array_equal(again.probabilities(dataset), model.probabilities(dataset))
    # The best so far where the callback has seen enough; what it raises where it raises.
    short = ballmark.train(dataset, steps=500, on_progress=lambda step, *_: step < 5, **options)
    assert short.header["training"]["steps"] < 500

    def fails(step, most, best):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        ballmark.train(dataset, steps=500, on_progress=fails, **options)
    with pytest.raises(ValueError, match="learning_rate"):
        ballmark.train(dataset, config={"train": {"descent": {"learning_rate": -1}}})
    with pytest.raises(ValueError, match="unknown field"):
        ballmark.train(dataset, config={"train": {"feetures": 1}})
    with pytest.raises(ValueError, match="uncertainty"):
        ballmark.train(dataset, uncertainty="far")


def test_ctrl_c_ends_a_training_and_other_threads_run_meanwhile():
    code = (
        "import ballmark, threading, sys\n"
        f"d = ballmark.read({str(DATASET)!r})\n"
        "def count():\n"
        "    for _ in range(3): print('counting', flush=True)\n"
        "threading.Timer(0.5, count).start()\n"
        "try: ballmark.train(d, features=4, steps=1000000, config={'train': {'begin_with': 'random', 'descent': {'patience': 1000000}}})\n"
        "except KeyboardInterrupt: print('ended'); sys.exit(0)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "counting\n"
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert out.endswith("ended\n") and child.returncode == 0


def test_localising_answers_the_record(tmp_path):
    dataset, model = ballmark.read(DATASET), ballmark.Model.read(MODEL)
    told = []
    record = ballmark.localise(model, dataset, trials=4, seed=1, on_progress=lambda *at: told.append(at))
    names = [system["name"] for system in record["systems"]]
    assert "learned" in names and record["trials"] and told
    assert "found %" in record.table
    with pytest.raises(ValueError, match="expected at least one"):
        ballmark.localise([], dataset)


def test_comparing_reads_a_file(tmp_path):
    config = tmp_path / "compare.toml"
    dataset = f"[[dataset]]\nname = 'corridor'\nfile = {str(DATASET)!r}\n[[system]]\nkind = 'nearest'\n"
    with pytest.raises(ValueError, match="compare.toml: nothing is asked of the systems"):
        config.write_text(dataset)
        ballmark.compare(config)
    config.write_text(dataset + "[recognition]\n")
    told = []
    record = ballmark.compare(config, toy=True, on_progress=lambda *at: told.append(at))
    assert record["datasets"][0]["name"] == "corridor" and "recognition" in record and told


def test_scores_are_those_of_the_papers_formula():
    location = ["a", "a", "b", "b"]
    assert ballmark.uncertainty_coefficient(location, [1, 1, 2, 2]) == 1.0
    assert ballmark.uncertainty_coefficient(location, [1, 1, 2, 1]) == pytest.approx(0.311278, abs=1e-6)
    assert ballmark.uncertainty_coefficient(["a"], ["b"]) is None
    verdict = ballmark.score(np.array([0, 0, 1, 1] * 20), np.array([0, 0, 1, 0] * 20), trial=[0] * 40 + [1] * 40)
    assert verdict["n"] == 80 and verdict["ci95_over"] == "trials"
    with pytest.raises(ValueError, match="`response`: 3 entries; expected 4"):
        ballmark.score(location, [1, 2, 3])


def test_the_command_comes_with_the_package():
    def run(*arguments):
        return subprocess.run([sys.executable, "-m", "ballmark", *arguments], capture_output=True, text=True)

    version = run("--version")
    assert version.returncode == 0 and version.stdout.startswith("ballmark ")
    features = run("import", str(DATASET), "-o", "/nowhere/d.npz")
    assert features.returncode == 1 and features.stderr.startswith("error: ")
    assert run("import").returncode == 2


def test_two_trainings_side_by_side_give_the_same_bytes(tmp_path):
    dataset = ballmark.read(DATASET)
    files = [tmp_path / f"{k}.safetensors" for k in range(2)]

    def learn(file):
        ballmark.train(dataset, features=2, steps=5, config={"train": {"begin_with": "random"}}).write(file)

    threads = [threading.Thread(target=learn, args=(file,)) for file in files]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert files[0].read_bytes() == files[1].read_bytes()
