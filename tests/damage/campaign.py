#!/usr/bin/env python3
"""Damages files of every kind that the command reads, and holds it to what it promises of such files.

    python3 tests/damage/campaign.py target/release/ballmark                    # 1,000 inputs: half a minute on two cores
    python3 tests/damage/campaign.py target/release/ballmark --inputs 36000     # all readers at length
    python3 tests/damage/campaign.py target/release/ballmark --only carmen --first 17 --inputs 1 --keep DIR   # one of them again

Input N of a reader is the same in every run. Each is given to the command, which must end by itself within five seconds, without a
panic, with a status that it knows; with at most twice the memory that the clean file takes (and some MB that vary from run to run); with one
printable line of bounded length where it refuses; with nothing left behind where it fails; and, where checksums seal a file, with status 0 only
if what came in is what the clean file holds. Standard library alone.
"""

import argparse
import bz2
import concurrent.futures
import gzip
import lzma
import math
import os
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LONGEST_S = 5.0
LONGEST_LINE = 2100
# Allocators and threads differ by so much from run to run.
SPARE_KB = 24 * 1024


def write_clean(folder, binary):
    """Small clean files, and how each is read: {reader: (file to damage, call, whether a checksum seals it)}."""
    write = lambda name, text: (folder / name).write_text(text)
    run = lambda *call: subprocess.run([binary, *map(str, call)], cwd=folder, check=True, capture_output=True)
    beams = 12
    bearings = [-90 + 180 * b / (beams - 1) for b in range(beams)]
    turn = lambda k: 2 * math.pi * k / 40  # three laps of a circle
    pose = lambda k: (4 + 2 * math.cos(turn(k)), 3 + 2 * math.sin(turn(k)), math.remainder(turn(k) + math.pi / 2, 2 * math.pi))
    ranges = lambda k: [round(2 + 1.5 * math.sin(0.3 * k + b), 3) for b in range(beams)]
    rows = ["time_s,x_m,y_m,heading_rad," + ",".join(f"laser.{b}[m @ {v:.3f}]" for b, v in enumerate(bearings)) + ",light"]
    carmen, tum, other = [], [], []
    for k in range(120):
        x, y, h = pose(k)
        rows.append(f"{k * 0.5},{x:.4f},{y:.4f},{h:.4f}," + ",".join(map(str, ranges(k))) + f",{k % 7}")
        at = f"{x:.4f} {y:.4f} {h:.4f}"
        carmen.append(f"FLASER {beams} {' '.join(map(str, ranges(k)))} {at} {at} {100 + k * 0.5} host {k * 0.5}")
        carmen.append(f"ODOM {at} 0.3 0.0 0.0 {100 + k * 0.5} host {k * 0.5}")
        quaternion = f"0 0 {math.sin(h / 2):.6f} {math.cos(h / 2):.6f}"
        tum.append(f"{k * 0.5} {x:.4f} {y:.4f} 0 {quaternion}")
        other.append(f"{k * 0.5} {x + 0.01:.4f} {y:.4f} 0 {quaternion}")
    write("walk.csv", "\n".join(rows) + "\n")
    write("walk.log", "\n".join(carmen) + "\n")
    write("ref.tum", "\n".join(tum) + "\n")
    write("est.tum", "\n".join(other) + "\n")
    write("est.kitti", "\n".join(f"1 0 0 {k} 0 1 0 0 0 0 1 0" for k in range(30)) + "\n")
    write("ref.kitti", "\n".join(f"1 0 0 {k}.1 0 1 0 0 0 0 1 0" for k in range(30)) + "\n")
    graph = [f"VERTEX_SE2 {k} {' '.join(f'{v:.4f}' for v in pose(k))}" for k in range(30)]
    write("est.g2o", "\n".join(graph) + "\n")
    write("ref.g2o", "\n".join(graph) + "\n")
    answers = [f"{'hall' if k % 3 else 'door'},{k % 4},{k // 5},{k % 5}" for k in range(60)]
    write("answers.csv", "location,response,trial,distance_m\n" + "\n".join(answers) + "\n")
    text = (folder / "walk.log").read_bytes()
    (folder / "walk.log.gz").write_bytes(gzip.compress(text, mtime=0))
    (folder / "walk.log.xz").write_bytes(lzma.compress(text))
    (folder / "walk.log.bz2").write_bytes(bz2.compress(text))
    for name in ["none.bag", "lz4.bag", "bz2.bag", "none.mcap", "zstd.mcap", "lz4.mcap", "plain/plain.db3"]:
        shutil.copy(ROOT / "tests/bags" / name, folder / Path(name).name)
    shutil.copy(ROOT / "configs/worlds/ruizmayor2006-r1.toml", folder / "world.toml")
    width, height = 80, 60
    edge = lambda x, y: x in (0, width - 1) or y in (0, height - 1)
    pixels = bytes(0 if edge(x, y) else 254 for y in range(height) for x in range(width))
    (folder / "map.pgm").write_bytes(b"P5\n%d %d\n255\n" % (width, height) + pixels)
    write("map.yaml", "image: map.pgm\nresolution: 0.1\norigin: [-2.0, -2.5, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n")
    world = (folder / "world.toml").read_text()
    wall = world[world.index("[[wall]]"):world.index("[robot]")]
    write("in-map.toml", world.replace(wall, '[building]\nmap = "map.yaml"\n'))
    run("import", "walk.csv", "-o", "walk.npz")
    run("train", "walk.npz", "-o", "model.safetensors", "--uncertainty", "2m", "--steps", "2", "--from", "none")
    run("export", "model.safetensors", "-o", "model.npz")
    run("export", "model.safetensors", "-o", "model.onnx")
    compare = "[[dataset]]\nfile = 'walk.npz'\n[[system]]\nkind = 'dead_reckoning'\n[[system]]\nkind = 'nearest'\n[protocol]\nmapping = 'split'\n" \
        "[recognition]\npermutations = 9\nresamples = 9\nbin_m = 2.0\n"
    write("compare.toml", compare)
    run("compare", "compare.toml", "--out", "compared")
    shutil.copy(folder / "compared/comparison.json", folder / "comparison.json")
    trials = "seed = 1\n[protocol]\nmapping = 'split'\n[protocol.split]\nunit = '4m'\n[localisation]\ntrials = 3\nspacing_m = 0.3\nshortest_m = 1.0\nlongest_m = 3.0\n"
    write("trials.toml", trials)
    imported = lambda file, sealed: (file, ["import", "{file}", "-o", "{out}.npz"], sealed)
    held = lambda est, ref: (est, ["trajectory", "{file}", ref, "--allow-incomplete", "--out", "{out}.csv"], False)
    features = lambda model: (model, ["features", "{file}", "walk.npz", "-o", "{out}.csv"], True)
    return {
        "carmen": imported("walk.log", False), "csv": imported("walk.csv", False), "npz": ("walk.npz", ["features", "model.safetensors", "{file}", "-o", "{out}.csv"], True),
        "gzip": imported("walk.log.gz", True), "xz": imported("walk.log.xz", True), "bzip2": imported("walk.log.bz2", True),
        "rosbag1": imported("none.bag", False), "rosbag1-lz4": imported("lz4.bag", False), "rosbag1-bz2": imported("bz2.bag", False),
        "mcap": imported("none.mcap", False), "mcap-zstd": imported("zstd.mcap", False), "mcap-lz4": imported("lz4.mcap", False),
        "rosbag2": imported("plain.db3", False),
        "poses": ("est.tum", ["import", "walk.csv", "--poses", "{file}", "-o", "{out}.npz"], False),
        "tum": held("est.tum", "ref.tum"), "kitti": held("est.kitti", "ref.kitti"), "g2o": held("est.g2o", "ref.g2o"),
        "responses": ("answers.csv", ["score", "{file}", "--permutations", "9", "--bootstrap", "9", "--out", "{out}"], False),
        "model": features("model.safetensors"), "model-npz": features("model.npz"), "onnx": features("model.onnx"),
        "world": ("world.toml", ["simulate", "{file}", "-o", "{out}.npz"], False),
        "map-yaml": ("map.yaml", ["simulate", "in-map.toml", "-o", "{out}.npz"], False),
        "map-pgm": ("map.pgm", ["simulate", "in-map.toml", "-o", "{out}.npz"], False),
        "config": ("trials.toml", ["trials", "walk.npz", "--config", "{file}", "-o", "{out}"], False),
        "record": ("comparison.json", ["compare", "--redraw", "{file}", "--out", "{out}"], False),
    }


NUMBERS = [b"nan", b"inf", b"-1", b"0", b"1e999", b"99999999999999999999", b"1e-300", b"-0.0", b"1,5", b"", b"\xff\xfe", b"\x00", b"\"", b"[[", b"2147483648"]


def damaged(clean, random_):
    """Other bytes."""
    data = bytearray(clean)
    at = lambda: random_.randrange(len(data))
    kind = random_.choice(["flip", "flip", "set", "cut", "insert", "delete", "repeat", "swap", "length", "number", "number", "several"])
    if kind == "cut":
        return bytes(data[: at()])
    if kind == "flip":
        data[at()] ^= 1 << random_.randrange(8)
    elif kind == "set":
        data[at()] = random_.randrange(256)
    elif kind == "insert":
        place = at()
        data[place:place] = bytes(random_.randrange(256) for _ in range(random_.randint(1, 64)))
    elif kind == "delete":
        place = at()
        del data[place: place + random_.randint(1, 256)]
    elif kind == "repeat":
        place = at()
        data[place:place] = bytes(data[place: place + random_.randint(1, 512)]) * random_.randint(1, 8)
    elif kind == "swap":
        a, b, size = at(), at(), random_.randint(1, 64)
        first, second = bytes(data[a: a + size]), bytes(data[b: b + size])
        data[a: a + len(second)] = second
        data[b: b + len(first)] = first
    elif kind == "length":  # what counts bytes or rows in a container
        place, width = at(), random_.choice([1, 2, 4, 8])
        value = random_.choice([(1 << 8 * width) - 1, 1 << (8 * width - 1), 0, 65535 % (1 << 8 * width)])
        data[place: place + width] = value.to_bytes(width, "little")
    elif kind == "number":  # one number of a text
        digits = [k for k, byte in enumerate(data) if 48 <= byte <= 57]
        if digits:
            first = last = random_.choice(digits)
            while last < len(data) and chr(data[last]) in "0123456789.eE+-":
                last += 1
            data[first:last] = random_.choice(NUMBERS)
    else:
        for _ in range(random_.randint(2, 20)):
            data[at()] = random_.randrange(256)
    return bytes(data)


class Judge:
    def __init__(self, binary, clean, readers, keep):
        self.binary, self.clean, self.readers, self.keep = binary, clean, readers, keep
        self.peak_kb, self.made = {}, {}
        self.lock = threading.Lock()
        self.faults = []
        self.statuses = {}

    def call(self, reader, data, folder):
        """Status, standard error, seconds and peak memory in kB; what lies in the folder then."""
        name, call, _ = self.readers[reader]
        for file in self.clean.iterdir():
            if file.is_file() and (file.name != name) and file.name in used_beside(call, reader):
                os.link(file, folder / file.name)
        (folder / name).write_bytes(data)
        before = set(os.listdir(folder))
        words = [self.binary, *(word.format(file=name, out="out") for word in call)]
        with open(folder / "stderr", "wb") as said:
            began = time.monotonic()
            child = subprocess.Popen(words, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=said)
            timer = threading.Timer(4 * LONGEST_S, child.kill)
            timer.start()
            _, status, used = os.wait4(child.pid, 0)
            child.returncode = 0  # it is waited for already
            timer.cancel()
            seconds = time.monotonic() - began
        text = (folder / "stderr").read_bytes()
        outputs = sorted(name for name in os.listdir(folder) if name.startswith("out"))
        made = b"".join((folder / name).read_bytes() for name in outputs if (folder / name).is_file())
        left = {name for name in set(os.listdir(folder)) - before - {"stderr"} if not is_empty(folder / name)}
        return status, text, seconds, used.ru_maxrss, left, made

    def one(self, task):
        reader, number = task
        name, _, is_sealed = self.readers[reader]
        clean = (self.clean / name).read_bytes()
        data = damaged(clean, random.Random(f"{reader} {number}"))
        with tempfile.TemporaryDirectory() as folder:
            status, text, seconds, peak_kb, left, made = self.call(reader, data, Path(folder))
        faults = []
        code = os.waitstatus_to_exitcode(status)
        if code not in (0, 1, 2, 3):
            faults.append(f"status {code}")
        if b"panicked" in text:
            faults.append("panic")
        if seconds > LONGEST_S:
            faults.append(f"{seconds:.1f} s")
        if peak_kb > 2 * self.peak_kb[reader] + SPARE_KB:
            faults.append(f"{peak_kb / 1024:.0f} MB, of the clean file {self.peak_kb[reader] / 1024:.0f}")
        lines = text.decode("utf-8", "replace").splitlines()
        if code in (1, 2):
            if not lines or not lines[-1].strip():
                faults.append("no line that says why")
            if left:
                faults.append(f"left behind: {sorted(left)}")
        long = [line for line in lines if len(line) > LONGEST_LINE or not line.isprintable() and line.strip("\t")]
        if long:
            faults.append(f"a line that can't be read: {long[0][:80]!r} ({len(long[0])} letters)")
        if code == 0 and is_sealed and made != self.made[reader]:
            faults.append("status 0 though what came in is not what was sealed")
        with self.lock:
            self.statuses.setdefault(reader, {}).setdefault(code, 0)
            self.statuses[reader][code] += 1
            for fault in faults:
                self.faults.append(f"{reader} {number}: {fault}: {lines[-1][:200] if lines else ''}")
        if faults and self.keep:
            Path(self.keep).mkdir(parents=True, exist_ok=True)
            (Path(self.keep) / f"{reader}-{number}-{name}").write_bytes(data)


def is_empty(path):
    """An output folder that nothing was written to: it is made first, so that a wrong name fails before the work."""
    return path.is_dir() and not any(path.iterdir())


def used_beside(call, reader):
    """Files that a call reads beside the damaged one."""
    named = {word for word in call if "{" not in word}
    if reader.startswith("map-"):
        named |= {"in-map.toml", "map.yaml", "map.pgm"}
    return named


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary", help="the command")
    parser.add_argument("--inputs", type=int, default=1000, help="damaged files, over all readers")
    parser.add_argument("--first", type=int, default=0, help="number of the first one of each reader")
    parser.add_argument("--only", help="one reader")
    parser.add_argument("--keep", help="folder for the files that it failed on")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    binary = str(Path(arguments.binary).resolve())
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.environ["NO_COLOR"] = "1"
    with tempfile.TemporaryDirectory() as folder:
        clean = Path(folder)
        readers = write_clean(clean, binary)
        if arguments.only:
            readers = {arguments.only: readers[arguments.only]}
        judge = Judge(binary, clean, readers, arguments.keep)
        for reader, (name, *_) in readers.items():
            with tempfile.TemporaryDirectory() as place:
                status, text, _, judge.peak_kb[reader], _, judge.made[reader] = judge.call(reader, (clean / name).read_bytes(), Path(place))
            if status:
                sys.exit(f"{reader}: the clean file is refused: {text.decode()}")
        each = math.ceil(arguments.inputs / len(readers))
        tasks = [(reader, arguments.first + n) for n in range(each) for reader in readers]
        began = time.monotonic()
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            # A few at a time: a child's greatest memory is at least this process's own, from before it became `ballmark`.
            for first in range(0, len(tasks), 1000):
                for _ in pool.map(judge.one, tasks[first : first + 1000]):
                    pass
    for reader, statuses in judge.statuses.items():
        print(f"{reader:12} " + ", ".join(f"{count} × status {code}" for code, count in sorted(statuses.items())))
    print(f"{len(tasks)} damaged files, {len(readers)} readers, {time.monotonic() - began:.0f} s: {len(judge.faults)} faults")
    for fault in judge.faults[:40]:
        print(fault)
    sys.exit(1 if judge.faults else 0)


if __name__ == "__main__":
    main()
