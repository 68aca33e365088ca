"""Sweeps on two Ray nodes of this machine: is all of it there, with the same bytes as here, whatever is killed or full?

    pip install -r tests/sweep/requirements.txt
    python tests/sweep/check.py target/release/ballmark [--cells 200]

A node is killed at a third; a driver is killed and started again; a cell is poisoned; a node has no room on its disk; cells ask for half of a
GPU each, which one node of three says that it has. At last what a cell costs besides its command.
"""

import argparse
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

from ray.cluster_utils import Cluster

ROOT = pathlib.Path(__file__).resolve().parents[2]
DRIVER = ROOT / "examples" / "sweep" / "ray_sweep.py"
OVERHEAD_S = 0.2
SWEEP = """\
command = "train"
data = {data}
seeds = {seeds}
[base]
recipe = "thrun1998"
[base.train]
uncertainty = "2m"
descent = {{ steps = {steps} }}
[keys]
train.features = [2, 3]
"""


def step(words):
    print(f"{time.monotonic() - BEGAN:5.1f} s  {words}", flush=True)


def ballmark(*arguments, status=0):
    done = subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != status:
        sys.exit(f"ballmark {' '.join(map(str, arguments))}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def planned(folder, name, seeds, data=("d.npz",), steps=4):
    """A sweep of two cells a seed and file."""
    file = folder / f"{name}.toml"
    file.write_text(SWEEP.format(data=json.dumps(list(data)), seeds=list(range(1, seeds + 1)), steps=steps))
    ballmark("sweep", "plan", file, "-o", folder / name)
    return folder / name


def results(sweep):
    return {path.stem: path.read_bytes() for path in sweep.glob("results/*/*.json")}


def driver(sweep, address, cache, *more):
    call = [sys.executable, DRIVER, sweep, "--address", address, "--binary", BINARY, "--cache", cache, "--backoff", "2", *more]
    return subprocess.Popen(list(map(str, call)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process, status=0):
    out, err = process.communicate(timeout=1800)
    if process.returncode != status:
        sys.exit(f"driver: exit status {process.returncode}, expected {status}\n{out}{err}")
    return out, err


def summary(out):
    return next(line for line in out.splitlines() if " done, " in line and " failed" in line)


def wait_for(sweep, count, process):
    while len(results(sweep)) < count:
        if process.poll() is not None:
            sys.exit(f"driver ended early: {process.communicate()}")
        time.sleep(0.01)


def expect(holds, words):
    if not holds:
        sys.exit(f"failed: {words}")


class FullDisk:
    """A folder for temporary files without room: a small file system where there may be one, else a place where no file can be made."""

    def __init__(self, folder):
        self.folder = folder / "disk"
        self.folder.mkdir()
        mount = ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", self.folder]
        self.mounted = os.getuid() == 0 and shutil.which("mount") and subprocess.run(mount, capture_output=True).returncode == 0
        if self.mounted:
            self.what = "a file system of 16 kB"
        elif os.getuid() == 0:
            self.folder, self.what = pathlib.Path("/proc/self"), "/proc/self"
        else:
            self.folder.chmod(0o500)
            self.what = "a folder that takes no file"

    def end(self):
        if self.mounted:
            subprocess.run(["umount", "-l", self.folder], check=False)


def overhead(folder, cells):
    """Seconds of `run-cell`, and of the same command by hand, a cell after the other in turns."""
    sweep = planned(folder, "overhead", (cells + 1) // 2)
    lines = [json.loads(line) for line in (sweep / "cells.jsonl").read_text().splitlines()]
    pairs = []
    for cell in lines:
        begun = time.perf_counter()
        ballmark("sweep", "run-cell", sweep, cell["cell"], "--quiet")
        middle = time.perf_counter()
        call = ["train", folder / "d.npz", "-o", folder / "m.safetensors", "--recipe", "thrun1998", "--uncertainty", "2m", "--json", "--quiet"]
        ballmark(*call, "--steps", 4, "--features", cell["keys"]["train.features"], "--seed", cell["seed"])
        pairs.append((middle - begun, time.perf_counter() - middle))
    ours, by_hand = (statistics.median(column) for column in zip(*pairs))
    more = statistics.median(a - b for a, b in pairs)
    step(f"overhead: {more:.3f} s a cell in the median of {len(pairs)} ({ours:.3f} s by run-cell, {by_hand:.3f} s by hand)")
    expect(more < OVERHEAD_S, f"expected less than {OVERHEAD_S} s a cell")


def main(folder, cells):
    shutil.copy(ROOT / "datasets" / "corridor-small.npz", folder / "d.npz")
    seeds, cache = max(cells // 2, 3), folder / "cache"
    cells = 2 * seeds
    here = planned(folder, "here", seeds)
    begun = time.perf_counter()
    ballmark("sweep", "run", here)
    expected = results(here)
    expect(len(expected) == cells, "all cells of the local run")
    step(f"here: {cells} cells in {time.perf_counter() - begun:.1f} s")

    disk = FullDisk(folder)
    # A dead node is noticed after two seconds, not ten.
    heartbeat = {"health_check_initial_delay_ms": 2000, "health_check_period_ms": 500, "health_check_failure_threshold": 4}
    head = {"num_cpus": 0, "num_gpus": 0, "include_dashboard": False, "_system_config": heartbeat}
    cluster = Cluster(initialize_head=True, head_node_args=head)
    try:
        node = lambda **more: cluster.add_node(num_cpus=1, num_gpus=0, include_dashboard=False, **more)
        first, second = node(), node()
        address = cluster.address
        step("a cluster of two nodes with a slot each")

        sweep = planned(folder, "killed-node", seeds)
        process = driver(sweep, address, cache)
        wait_for(sweep, cells // 3, process)
        cluster.remove_node(second, allow_graceful=False)
        at = len(results(sweep))
        out, _ = ended(process)
        expect(results(sweep) == expected, "the same cells with the same bytes after a node was killed")
        step(f"a node killed at {at}: {len(expected)} of {cells} cells, the same bytes as here; {summary(out)}")

        sweep = planned(folder, "killed-driver", seeds)
        process = driver(sweep, address, cache)
        wait_for(sweep, cells // 3, process)
        process.kill()
        process.communicate()
        before = results(sweep)
        expect(len(before) < cells, "the driver was killed before its end")
        out, _ = ended(driver(sweep, address, cache))
        expect(f"{len(before)} done, {cells - len(before)} to be run" in out, f"only what is missing is run: {out}")
        expect(f"{cells - len(before)} done, 0 failed" in out, out)
        expect(results(sweep) == expected, "the same bytes after the driver was killed")
        step(f"a driver killed at {len(before)}, started again: {cells - len(before)} more run, the same bytes as here")

        (folder / "bad.npz").write_text("no dataset")
        sweep = planned(folder, "poisoned", 1, data=["d.npz", "bad.npz"])
        _, err = ended(driver(sweep, address, cache), status=1)
        failed = {path.stem: path.read_text() for path in sweep.glob("failed/*/*.txt")}
        expect(len(results(sweep)) == 2 and len(failed) == 2, f"the other cells are done: {len(results(sweep))}, {len(failed)}")
        expect(all("last lines" in why and "bad.npz" in why and why.strip() in err for why in failed.values()), err)
        step("poisoned cells fail alone: " + err.splitlines()[0])

        # Its workers inherit the folder. It takes a cell before there is another node.
        cluster.remove_node(first, allow_graceful=False)
        node(env_vars={"TMPDIR": str(disk.folder)})
        sweep = planned(folder, "full-disk", seeds)
        process = driver(sweep, address, cache)
        line = process.stderr.readline()
        expect(line.startswith("again: no room: "), line or process.communicate())
        node()
        out, _ = ended(process)
        expect(results(sweep) == expected, "the same bytes where a node has no room")
        again = int(summary(out).split(" run again")[0].split()[-1])
        expect(again > 0, "the node without room took no cell")
        step(f"a node with {disk.what} for temporary files: {again} attempts lost, every cell done elsewhere, the same bytes as here")

        # Without a GPU in this machine: Ray counts what a node says that it has, and names the device to who is given a share.
        sweep, log, noted = planned(folder, "gpu", seeds), folder / "devices", folder / "noted.sh"
        log.touch()
        noted.write_text(f'#!/bin/sh\n[ "$2" = run-cell ] && echo "$CUDA_VISIBLE_DEVICES" >> "{log}"\nexec "{BINARY}" "$@"\n')
        noted.chmod(0o755)
        process = driver(sweep, address, cache, "--gpus", "0.5", "--binary", noted)
        line = process.stderr.readline()
        expect("no node has 0.5 of a GPU" in line, line or process.communicate())
        expect(not log.read_text(), "nothing runs where there is no GPU")
        cluster.add_node(num_cpus=2, num_gpus=1, include_dashboard=False)
        ended(process)
        expect(results(sweep) == expected, "the same bytes on the node with a GPU")
        expect(log.read_text().split() == ["0"] * cells, f"every cell has a share of device 0: {log.read_text().split()}")
        step(f"half of a GPU a cell: {cells} of {cells} cells on the one node of three that has one, the same bytes as here")
    finally:
        cluster.shutdown()
        disk.end()
    overhead(folder, min(cells, 20))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--cells", type=int, default=12)
    options = parser.parse_args()
    BINARY, BEGAN = str(pathlib.Path(options.binary).resolve()), time.monotonic()
    with tempfile.TemporaryDirectory() as place:
        main(pathlib.Path(place), options.cells)
    step("all is well")
