#!/usr/bin/env python3
"""Kills the command at random instants (SIGKILL), starts it again, and holds what comes of it to an unbroken run, byte for byte.

    python3 tests/damage/kills.py target/release/ballmark                 # six kills of each command: a minute on two cores
    python3 tests/damage/kills.py target/release/ballmark --kills 100     # a hundred

`train` is started again with --resume, as a user would; `compare` and `sweep run` as they were. A killed run may leave its checkpoint and a temporary file of the output
that it was writing, and no half of an output; nothing of them may be left after the run that ends. Then: system calls that signals interrupt (where there is strace), a full disk (where a small one can
be mounted, else a limit on the size of a file), a read-only folder, and two runs with one output at once. Standard library alone.
"""

import argparse
import json
import os
import random
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DATASET = ROOT / "datasets/corridor-small.npz"
TRAIN = ["train", DATASET, "-o", "m.safetensors", "--uncertainty", "2m", "--features", "2", "--steps", "120", "--from", "none", "--seed", "3"]
COMPARE = ["compare", "compare.toml", "--out", "out"]
CONFIG = f"""seed = 2
[[dataset]]
name = "corridor"
file = "{DATASET}"
[[system]]
name = "learned"
kind = "bayes"
train.uncertainty = "global"
train.features = 2
train.descent.steps = 40
[[system]]
kind = "nearest"
[[system]]
name = "odometry"
kind = "bayes"
landmarks = []
[protocol]
mapping = "split"
[recognition]
permutations = 49
resamples = 49
[localisation]
trials = 6
longest_m = 8.0
resamples = 20
"""
SWEEP = """command = "train"
data = "d.npz"
seeds = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
[base]
recipe = "thrun1998"
[base.train]
uncertainty = "2m"
[base.train.descent]
steps = 5
"""
RUN_SWEEP = ["sweep", "run", "s", "--jobs", "2"]
faults = []


def run(binary, call, folder, kill_after_s=None, **how):
    """Its exit status, and what it said; killed after so many seconds."""
    child = subprocess.Popen([binary, *map(str, call)], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, **how)
    try:
        _, said = child.communicate(timeout=kill_after_s)
    except subprocess.TimeoutExpired:
        child.send_signal(signal.SIGKILL)
        _, said = child.communicate()
    return child.returncode, said.decode(errors="replace")


def contents(folder):
    """Files by their names, without what differs from run to run: wall clock, and pictures of it."""
    def plain(path):
        data = path.read_bytes()
        if path.name == "comparison.json":
            try:
                data = json.dumps({key: value for key, value in json.loads(data).items() if key != "timing"}).encode()
            except ValueError:
                pass  # not whole: no other file is like it
        return data

    # A sweep's plan names the folder that it is in.
    left_out = ("cost.", "quality-against-cost", "index.html", "times.jsonl", "plan.json", "run.slurm")
    files = (p for p in sorted(Path(folder).rglob("*")) if p.is_file() and not p.name.startswith(left_out))
    return {str(p.relative_to(folder)): plain(p) for p in files}


def check(what, holds, said=""):
    if not holds:
        faults.append(f"{what}: {said.strip().splitlines()[-1][:200] if said.strip() else ''}")


def kills(binary, name, call, again, prepare, count, checkpoint=(), plants=True):
    """`plants`: is every output written again, and with it what a kill left beside it taken away?"""
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder))
        given = os.listdir(folder)
        began = time.monotonic()
        status, said = run(binary, call, folder)
        lasted = time.monotonic() - began
        check(f"{name}, unbroken", status == 0, said)
        whole = contents(folder)
    random_ = random.Random(name)
    killed = 0
    for number in range(count):
        with tempfile.TemporaryDirectory() as folder:
            prepare(Path(folder))
            after_s = random_.uniform(0.0, lasted)
            status, said = run(binary, call, folder, after_s)
            killed += status == -signal.SIGKILL
            if status == -signal.SIGKILL and random_.random() < 0.5:  # and once more, on the way
                run(binary, again, folder, random_.uniform(0.0, lasted))
            for file, data in contents(folder).items():
                if file in whole and data != whole[file] and "checkpoint" not in file:
                    faults.append(f"{name} {number}: after a kill at {after_s:.3f} s, {file} is there and not whole")
            if number == 0 and plants:  # as if killed amid a write, which few instants hit
                for file in [*(file for file in whole if file not in given), *checkpoint]:
                    left = Path(folder) / file
                    left.parent.mkdir(parents=True, exist_ok=True)
                    left.with_name(f".{left.name}.tmpa1B2c3").write_text("half")
            status, said = run(binary, again, folder)
            check(f"{name} {number}, started again", status == 0, said)
            made = contents(folder)
            check(f"{name} {number}: other files: {sorted(set(made) ^ set(whole))}", set(made) == set(whole))
            differ = [file for file in whole if made.get(file) != whole[file]]
            check(f"{name} {number}, killed at {after_s:.3f} s: {differ} differ", not differ)
    print(f"{name}: {killed} of {count} runs of {lasted:.1f} s were killed; the same bytes")


def planned(binary, folder):
    """A sweep of a few cells, none of them run."""
    shutil.copy(DATASET, folder / "d.npz")
    (folder / "s.toml").write_text(SWEEP)
    status, said = run(binary, ["sweep", "plan", "s.toml", "-o", "s"], folder)
    check("sweep: planned", status == 0, said)


def interrupted(binary):
    """System calls that a signal interrupts (EINTR) are made again: the same bytes. Every other one is made to fail so, by strace."""
    if not shutil.which("strace"):
        print("interrupted system calls: skipped, as there is no strace")
        return
    log = "".join(f"FLASER 3 1.5 2.5 {k % 7} {k} 0 0 {k} 0 0 {k} h {k}\n" for k in range(3000))
    train = [word if word != DATASET else "d.npz" for word in TRAIN]
    # Longer than what is read at once: the rest is read here and there. After the 13 letters it begins with stands a record that nobody needs.
    bag = (ROOT / "tests/bags/none.bag").read_bytes()
    filler = struct.pack("<II4sI", 8, 4, b"op=\x04", 17 << 20) + bytes(17 << 20)
    bag = bag[:13] + filler + bag[13:]

    def made(inject):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "walk.log").write_text(log)
            (Path(folder) / "walk.bag").write_bytes(bag)
            shutil.copy(DATASET, Path(folder) / "d.npz")
            for call in (["import", "walk.log", "-o", "walk.npz"], ["import", "walk.bag", "-o", "bag.npz"], train):
                first, *rest = [*inject, binary, *call]
                status, said = run(first, rest, folder)
                check(f"interrupted {inject}: {call[0]}", status == 0, said)
            return contents(folder)

    before, whole = len(faults), made([])
    strace = ["strace", "-f", "-qq", "-o", "/dev/null"]
    # Opening and reading by file alone, or the loader of the program would be interrupted, too, and it gives up.
    inputs = ["-P", "walk.log", "-P", "walk.bag", "-P", "d.npz"]
    for only, calls in ((inputs, "openat"), (inputs, "read"), (inputs, "pread64"), ([], "write,pwrite64"), ([], "fsync,fdatasync,ftruncate")):
        check(f"interrupted {calls}: other bytes", made([*strace, *only, "-e", f"inject={calls}:error=EINTR:when=1+2"]) == whole)
    print(f"interrupted system calls: {'other bytes' if len(faults) > before else 'the same bytes'}")


def full_disk(binary):
    """Nothing half-written where no more can be written, and a line that says so."""
    with tempfile.TemporaryDirectory() as folder:
        def small():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2048, 2048))

        status, said = run(binary, TRAIN, folder, preexec_fn=small)
        check("full disk: a training that can't be written ends with status 1 and says so", status == 1 and "m.safetensors" in said, said)
        check(f"full disk: left behind: {os.listdir(folder)}", not [name for name in os.listdir(folder) if "checkpoint" not in name])
        (Path(folder) / "compare.toml").write_text(CONFIG)
        status, said = run(binary, COMPARE, folder, preexec_fn=small)
        check("full disk: a comparison ends with status 1", status == 1, said)


def read_only(binary):
    """A folder that can't be written to is told before the work."""
    def nobody():  # root writes to it all the same
        if os.geteuid() == 0:
            os.setgid(65534)
            os.setuid(65534)

    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(binary, folder)
        shutil.copy(DATASET, folder)
        os.chmod(folder, 0o555)
        call = [word if word != DATASET else DATASET.name for word in TRAIN]
        status, said = run(f"{folder}/{Path(binary).name}", call, folder, preexec_fn=nobody)
        check("read-only folder: status 1 before anything is learned", status == 1 and "learning" not in said, said)
        check("read-only folder: the line names it", "m.safetensors" in said or "cannot" in said, said)
        os.chmod(folder, 0o755)


def two_at_once(binary):
    """Two runs with one output: it is whole, of the one or the other, and so is what either says."""
    with tempfile.TemporaryDirectory() as folder:
        other = [word if word != "3" else "4" for word in TRAIN]
        alone = []
        for call in (TRAIN, other):
            check("two runs: each alone", run(binary, call, folder)[0] == 0)
            alone.append((Path(folder) / "m.safetensors").read_bytes())
            (Path(folder) / "m.safetensors").unlink()
        both = [subprocess.Popen([binary, *map(str, call)], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) for call in (TRAIN, other)]
        said = [child.communicate()[1].decode() for child in both]
        statuses = [child.returncode for child in both]
        check(f"two runs at once: statuses {statuses}", all(status in (0, 1) for status in statuses) and 0 in statuses, " ".join(said))
        check("two runs at once: the output is whole", (Path(folder) / "m.safetensors").read_bytes() in alone)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary", help="the command")
    parser.add_argument("--kills", type=int, default=6, help="of each command")
    arguments = parser.parse_args()
    binary = str(Path(arguments.binary).resolve())
    kills(binary, "train", TRAIN, [*TRAIN, "--resume"], lambda folder: None, arguments.kills, ["m.safetensors.checkpoint"])
    kills(binary, "compare", COMPARE, COMPARE, lambda folder: (folder / "compare.toml").write_text(CONFIG), arguments.kills)
    kills(binary, "sweep", RUN_SWEEP, RUN_SWEEP, lambda folder: planned(binary, folder), arguments.kills, plants=False)
    interrupted(binary)
    full_disk(binary)
    read_only(binary)
    two_at_once(binary)
    for fault in faults[:40]:
        print(fault)
    print(f"{len(faults)} faults")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
