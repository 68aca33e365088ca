"""The missing cells of a sweep on a Ray cluster: each a call of `ballmark sweep run-cell` on whatever node has a slot.

    pip install ray
    ballmark sweep plan S.toml -o sweep
    python ray_sweep.py sweep --address auto --cpus 1 [--gpus 0.25]
    ballmark sweep collect sweep

The program and the data go to a node once, by their SHA-256, and stay in its cache. Results come back whole and are written whole to the
sweep's folder, which only this machine needs to see. Killed and called again, it runs what is missing. Cells of a node that is lost are run
elsewhere (--retries); so are those that a node had no room on its disk for, if there is another. A cell that fails of itself fails alone: failed/ says why.
"""

import argparse
import collections
import fcntl
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy


def write_whole(path, content):
    """A temporary file beside it, fsync, rename: what is there is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o755)
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def fetched(cache, objects):
    """Puts what this node lacks into its cache; how many bytes that were."""
    count = 0
    for digest, (reference,) in objects.items():
        if (cache / digest).exists():
            continue
        with open(cache / f"{digest}.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # one of several cells that start at once
            if not (cache / digest).exists():
                content = ray.get(reference)
                write_whole(cache / digest, content)
                count += len(content)
    return count


def run_cell(plan, line, objects, program, cache, threads, backoff_s):
    """On a node: runs a cell in a folder of its own. What came of it, its file, times, bytes fetched, and the node."""
    node = ray.get_runtime_context().get_node_id()
    cell = json.loads(line)["cell"]
    folder = None
    try:
        cache = pathlib.Path(cache or f"{tempfile.gettempdir()}/ballmark-cache-{os.getuid()}")
        cache.mkdir(mode=0o700, parents=True, exist_ok=True)
        count = fetched(cache, objects)
        folder = pathlib.Path(tempfile.mkdtemp(prefix="ballmark-"))
        (folder / "plan.json").write_text(plan)
        (folder / "cells.jsonl").write_text(line + "\n")
        call = [cache / program, "sweep", "run-cell", folder, cell, "--data", cache, "--quiet"]
        call += ["--ends-with-parent", os.getpid()]  # as the node's worker may be killed
        environment = {**os.environ, "RAYON_NUM_THREADS": str(threads)}
        done = subprocess.run([str(word) for word in call], env=environment, capture_output=True, text=True)
        result = folder / "results" / cell[:2] / f"{cell}.json"
        times = folder / "times.jsonl"
        times = times.read_text() if times.exists() else ""
        if done.returncode == 0 and result.exists():
            return "done", result.read_bytes(), times, count, node
        (folder / "room").write_bytes(bytes(1 << 16))  # is there any?
        failure = folder / "failed" / cell[:2] / f"{cell}.txt"
        why = failure.read_bytes() if failure.exists() else f"cell {cell}\n{done.stderr}".encode()
        return "failed", why, times, count, node
    except OSError as fault:
        time.sleep(backoff_s)  # or a node without room would take one cell after the other
        return "no room", f"cell {cell}\n{os.uname().nodename}: {fault}\n".encode(), "", 0, node
    finally:
        if folder:
            shutil.rmtree(folder, ignore_errors=True)


def elsewhere(full, slots):
    """Where a cell is run again: on a node that has the slots and was not found full, if there is one."""
    asked = {"CPU": slots["num_cpus"], "GPU": slots["num_gpus"]}
    fits = lambda node: all(node["Resources"].get(kind, 0) >= count for kind, count in asked.items())
    nodes = [node["NodeID"] for node in ray.nodes() if node["Alive"] and node["NodeID"] not in full and fits(node)]
    return NodeAffinitySchedulingStrategy(random.choice(nodes), soft=True) if nodes else "DEFAULT"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="the sweep's folder")
    parser.add_argument("--address", help="the cluster; not said: one of this machine alone")
    parser.add_argument("--binary", default="ballmark", help="the program, as it is sent to the nodes")
    parser.add_argument("--cpus", type=int, default=1, help="slots, and threads, of a cell")
    parser.add_argument("--gpus", type=float, default=0, help="share of a GPU of a cell (the sweep's `device` uses it)")
    parser.add_argument("--memory", type=float, default=0, help="MB that a cell is given; 0: not counted")
    parser.add_argument("--retries", type=int, default=3, help="how often a cell is run again whose node was lost or had no room")
    parser.add_argument("--cache", help="folder of a node for program and data; not said: in its temporary folder")
    parser.add_argument("--backoff", type=float, default=30, help="seconds that a node without room takes no cell")
    return parser.parse_args()


def main():
    options = arguments()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    binary = shutil.which(options.binary)
    if not binary:
        sys.exit(f"{options.binary}: no such program; expected --binary with the path of ballmark")
    status = subprocess.run([binary, "sweep", "status", options.folder, "--json"], capture_output=True, text=True)
    if status.returncode:
        sys.exit(status.stderr.strip())
    status = json.loads(status.stdout)
    plan = (options.folder / "plan.json").read_text()
    missing = set(status["missing"]) | {failed["cell"] for failed in status["failed"]}
    lines = [json.loads(line) | {"line": line} for line in (options.folder / "cells.jsonl").read_text().splitlines()]
    left = collections.deque(sorted((line for line in lines if line["cell"] in missing), key=lambda line: line["number"]))
    print(f"{status['cells']} cells: {status['done']} done, {len(left)} to be run", flush=True)
    if not left:
        return
    ray.init(address=options.address, log_to_driver=False, logging_level="ERROR", include_dashboard=False)
    put = lambda path: [ray.put(pathlib.Path(path).read_bytes())]  # in a list: fetched only where it is wanted
    program = hashlib.sha256(pathlib.Path(binary).read_bytes()).hexdigest()
    sent = {program: put(binary)}
    data = json.loads(plan)["data"]
    slots = {"num_cpus": options.cpus, "num_gpus": options.gpus, "max_retries": options.retries}
    slots |= {"memory": options.memory * 1e6} if options.memory else {}
    remote = ray.remote(**slots)(run_cell)
    if options.gpus and not any(node["Alive"] and node["Resources"].get("GPU", 0) >= options.gpus for node in ray.nodes()):
        print(f"no node has {options.gpus:g} of a GPU; cells wait until one joins", file=sys.stderr, flush=True)
    running, tries, counts, bytes_sent, full = {}, collections.Counter(), collections.Counter(), 0, set()
    while left or running:
        # A few more than there are slots: the rest wait here and not in the cluster's memory.
        most = 2 * max(1, int(ray.cluster_resources().get("CPU", 1) / max(options.cpus, 1)))
        while left and len(running) < most:
            line = left.popleft()
            files = [file for number in line["data"] for file in data[number]["files"]]
            for file in files:
                if file["sha256"] not in sent:
                    sent[file["sha256"]] = put(file["source"])
            objects = {digest: sent[digest] for digest in [program, *(file["sha256"] for file in files)]}
            call = (plan, line["line"], objects, program, options.cache, options.cpus, options.backoff)
            where = elsewhere(full, slots) if tries[line["cell"]] else "DEFAULT"
            running[remote.options(scheduling_strategy=where).remote(*call)] = line
        ended, _ = ray.wait(list(running), timeout=1)
        for reference in ended:
            line = running.pop(reference)
            name = line["cell"]
            try:
                what, content, times, count, node = ray.get(reference)
            except ray.exceptions.RayError as fault:
                what, content, times, count, node = "lost", f"cell {name}\n{fault}\n".encode(), "", 0, None
            full = full | {node} if what == "no room" else full - {node}
            bytes_sent += count
            tries[name] += 1
            if what in ("no room", "lost") and tries[name] <= options.retries:
                counts["again"] += 1
                print(f"again: {what}: {content.decode(errors='replace').strip()}", file=sys.stderr, flush=True)
                left.append(line)
                continue
            failure = options.folder / "failed" / name[:2] / f"{name}.txt"
            if what == "done" and json.loads(content)["cell"] == name:
                write_whole(options.folder / "results" / name[:2] / f"{name}.json", content)
                failure.unlink(missing_ok=True)
            else:
                write_whole(failure, content)
                print(f"failed: {content.decode(errors='replace').strip()}", file=sys.stderr, flush=True)
            counts["done" if what == "done" else "failed"] += 1
            with open(options.folder / "times.jsonl", "a") as file:
                file.write(times)
    print(f"{counts['done']} done, {counts['failed']} failed, {counts['again']} run again; {bytes_sent / 1e6:.1f} MB sent to nodes", flush=True)
    sys.exit(1 if counts["failed"] else 0)


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit("cancelled; the same command goes on")
    except OSError as fault:
        sys.exit(f"error: {fault}; the same command goes on")
