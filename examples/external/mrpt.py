#!/usr/bin/env python3
"""Lets MRPT's `pf-localization` answer a trial that `ballmark trials` or `ballmark compare` gives away.

    apt-get install mrpt-apps                     (Debian 12: MRPT 2.5.8)
    mrpt.py MAP.yaml TRIAL.log ANSWER.csv START [PARTICLES]

MAP.yaml is the map_server map of the mapping part, TRIAL.log a CARMEN log, START `x,y,heading` or `unknown`. The particles of every step
become rows of ANSWER.csv, those within 5 cm of each other as one. Options are those of MRPT's own demonstration of localisation in a laser's map,
with 40,000 particles; as a command of a comparison:

    command = ["python3", "mrpt.py", "trials/mapping/map.yaml", "{trial_carmen}", "{answer_csv}", "{start}"]
"""

import math
import re
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

PARTICLES = 40_000
# How well a start is known that is given: standard deviations of 0.3 m and 0.1 rad, as uniform ranges.
SPREAD_M, SPREAD_DEG = 0.3 * math.sqrt(3), math.degrees(0.1 * math.sqrt(3))
MERGED_M = 0.05

INI = """
[KLD_options]
KLD_binSize_PHI_deg=10
KLD_binSize_XY=0.10
KLD_delta=0.01
KLD_epsilon=0.01
KLD_maxSampleSize={particles}
KLD_minSampleSize=150
KLD_minSamplesPerBin=0
[PF_options]
PF_algorithm=0
resamplingMethod=0
adaptiveSampleSize=1
BETA=0.5
sampleSize=1
[DummyOdometryParams]
minStdXY=0.10
minStdPHI=2.0
[LocalizationExperiment]
use_3D_poses=false
map_file={gridmap}
rawlog_file={rawlog}
logOutput_dir={out}
3DSceneFrequency=1
experimentRepetitions=1
particles_count={particles}
init_PDF_mode={mode}
init_PDF_min_x={low[0]}
init_PDF_max_x={high[0]}
init_PDF_min_y={low[1]}
init_PDF_max_y={high[1]}
init_PDF_min_yaw_deg={low[2]}
init_PDF_max_yaw_deg={high[2]}
SHOW_PROGRESS_3D_REAL_TIME=false
[MetricMap]
occupancyGrid_count=1
gasGrid_count=0
landmarksMap_count=0
pointsMap_count=0
beaconMap_count=0
likelihoodMapSelection=-1
[MetricMap_occupancyGrid_00_creationOpts]
resolution={resolution}
[MetricMap_occupancyGrid_00_insertOpts]
maxDistanceInsertion=15
[MetricMap_occupancyGrid_00_likelihoodOpts]
likelihoodMethod=4
LF_decimation=10
LF_stdHit=0.40
LF_maxCorrsDistance=0.30
LF_zHit=0.95
LF_zRandom=0.05
LF_maxRange=80
LF_alternateAverageMethod=0
"""


def read_map(yaml):
    """Resolution, lower left corner, width, height and the pixels of a map, the southernmost row first."""
    keys = dict(line.split(":", 1) for line in yaml.read_text().splitlines() if ":" in line)
    picture = (yaml.parent / keys["image"].strip()).read_bytes()
    header = re.match(rb"P5\s+(\d+)\s+(\d+)\s+255\s", picture)
    width, height = int(header[1]), int(header[2])
    rows = [picture[header.end() + row * width :][:width] for row in range(height)]
    x, y, _ = (float(part) for part in keys["origin"].strip(" []").split(","))
    return float(keys["resolution"]), (x, y), width, height, b"".join(reversed(rows))


def write_gridmap(file, resolution, corner, width, height, pixels):
    """The map as MRPT keeps it: cells from 0 (occupied) to 255 (free), in the first version of its serialisation."""
    cell = bytes(254 if value > 250 else 127 if value > 100 else 1 for value in range(256))
    name = b"mrpt::maps::COccupancyGridMap2D"
    (x, y), edge = corner, resolution
    limits = struct.pack("<II5f", width, height, x, x + width * edge, y, y + height * edge, edge)
    file.write_bytes(bytes([len(name) | 0x80]) + name + b"\0" + limits + pixels.translate(cell) + b"\x88")


def run(words, folder):
    done = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        sys.exit(f"{words[0]} failed: {done.stdout.decode(errors='replace')[-400:]}")


def times(log):
    """Seconds of the scans of a log."""
    lines = log.read_text().splitlines()
    return [line.split()[-3] for line in lines if line.startswith("ROBOTLASER1 ")]


def merged(file):
    """x, y, heading and weight of particles, those of one small square together."""
    squares = {}
    for line in file.read_text().splitlines():
        if line.startswith("%"):
            continue
        numbers = [float(number) for number in line.split()]
        x, y, heading = numbers[:3]
        weight = math.exp(numbers[3]) if len(numbers) > 3 else 1.0
        sums = squares.setdefault((round(x / MERGED_M), round(y / MERGED_M)), [0.0] * 5)
        for at, value in enumerate([1.0, x, y, math.cos(heading), math.sin(heading)]):
            sums[at] += weight * value
    for weight, x, y, cosine, sine in squares.values():
        if weight > 0.0:
            yield x / weight, y / weight, math.atan2(sine, cosine), weight


def main(map_file, log, answer, start, particles=PARTICLES):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        resolution, corner, width, height, pixels = read_map(Path(map_file))
        write_gridmap(folder / "map.gridmap", resolution, corner, width, height, pixels)
        run(["carmen2rawlog", "-q", "-w", "-i", str(Path(log).resolve()), "-o", "trial.rawlog"], folder)
        low = [*corner, -180.0]
        high = [corner[0] + width * resolution, corner[1] + height * resolution, 180.0]
        if start != "unknown":
            x, y, heading = (float(part) for part in start.split(","))
            middle, spread = (x, y, math.degrees(heading)), (SPREAD_M, SPREAD_M, SPREAD_DEG)
            low, high = ([m + sign * s for m, s in zip(middle, spread)] for sign in (-1, 1))
        options = INI.format(
            particles=int(particles), gridmap="map.gridmap", rawlog="trial.rawlog", out="out", low=low, high=high,
            mode=0 if start == "unknown" else 1, resolution=resolution,
        )
        (folder / "trial.ini").write_text(options)
        run(["pf-localization", "trial.ini"], folder)
        steps = sorted(folder.glob("out_000_*/particles/particles_[0-9]*[0-9].txt"))
        scans = times(Path(log))
        if len(steps) != len(scans):
            sys.exit(f"{len(steps)} steps of pf-localization for {len(scans)} scans")
        rows = ["time_s,x_m,y_m,heading_rad,weight"]
        for time_s, step in zip(scans, steps):
            rows += [f"{time_s},{x:.4f},{y:.4f},{heading:.5f},{weight:.6g}" for x, y, heading, weight in merged(step)]
        Path(answer).write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
