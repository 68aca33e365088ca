"""What many cells cost besides their commands: plan, status, run (nothing), run-cell (done) and collect, results being copies of a real one.

    python tests/sweep/scale.py target/release/ballmark [--cells 100000] [--result CELL.json]

Without a result one training is run for it. Bytes and seconds go to standard output; nothing stays.
"""

import argparse
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def timed(binary, *arguments):
    begun = time.perf_counter()
    done = subprocess.run([binary, "sweep", *map(str, arguments)], capture_output=True, text=True)
    print(f"{arguments[0]:9} {time.perf_counter() - begun:8.2f} s", flush=True)
    if done.returncode:
        sys.exit(done.stderr)


def main(binary, count, result, place):
    shutil.copy(ROOT / "datasets" / "corridor-small.npz", place / "d.npz")
    seeds = list(range(max(count // 100, 1)))
    (place / "s.toml").write_text(
        f'command = "train"\ndata = "d.npz"\nseeds = {seeds}\n[base]\nrecipe = "thrun1998"\n[base.train]\nuncertainty = "2m"\n'
        f"[keys]\ntrain.features = {list(range(1, 11))}\ntrain.descent.steps = {list(range(1, 11))}\n"
    )
    sweep = place / "sweep"
    timed(binary, "plan", place / "s.toml", "-o", sweep)
    cells = [json.loads(line)["cell"] for line in (sweep / "cells.jsonl").read_text().splitlines()]
    if result is None:
        timed(binary, "run-cell", sweep, cells[0])
        result = next(sweep.glob("results/*/*.json"))
    result = json.loads(pathlib.Path(result).read_text())
    rng = random.Random(1)
    for cell in cells:
        result["cell"] = cell
        for part in ("train", "validation"):
            result["record"][part] = {"error_reduction": rng.random()}
        path = sweep / "results" / cell[:2] / f"{cell}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(result))
    print(f"{len(cells)} cells: cells.jsonl {(sweep / 'cells.jsonl').stat().st_size} bytes, a result {path.stat().st_size} bytes", flush=True)
    timed(binary, "status", sweep)
    timed(binary, "run", sweep)
    timed(binary, "run-cell", sweep, cells[len(cells) // 2])
    timed(binary, "collect", sweep, "-o", place / "table")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary")
    parser.add_argument("--cells", type=int, default=100_000)
    parser.add_argument("--result")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        main(str(pathlib.Path(options.binary).resolve()), options.cells, options.result, pathlib.Path(place))
