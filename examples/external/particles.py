#!/usr/bin/env python3
"""A page of numpy that localises: particles in the likelihood field of a map, for trials of `ballmark trials` or `ballmark compare`.

    pip install numpy scipy
    particles.py MAP.yaml TRIAL.csv ANSWER.csv START [SEED [PARTICLES]]

START is `x,y,heading` or `unknown`. Likelihood field after Thrun, Burgard & Fox, *Probabilistic Robotics* (2005), table 6.3; resampling
after table 4.4. As a command of a comparison:

    command = ["python3", "particles.py", "trials/mapping/map.yaml", "{trial_csv}", "{answer_csv}", "{start}", "{seed}"]
"""

import csv
import re
import sys
from pathlib import Path

import numpy as np
from scipy.ndimage import distance_transform_edt

from mrpt import read_map

BEAMS = 36  # so many of a scan, evenly
HIT_M, RANDOM, POWER = 0.15, 0.05, 0.3  # beams of a scan are no independent evidence
NOISE_M, NOISE_RAD = 0.05, 0.04  # of a step, besides a tenth of it


def read_trial(file):
    """Times, odometry, bearings and ranges of the scans in a table of `ballmark`."""
    rows = list(csv.reader(open(file)))
    header = rows[0]
    beams = [at for at, name in enumerate(header) if re.search(r"\[m @ ", name)]
    beams = beams[:: max(1, len(beams) // BEAMS)]
    bearings = np.radians([float(re.search(r"@ ([-\d.e]+)", header[at])[1]) for at in beams])
    at = [header.index(f"odometry_{name}") for name in ("x_m", "y_m", "heading_rad")]
    cells = [[row[0], [float(row[a]) for a in at], [float(row[b] or "nan") for b in beams]] for row in rows[1:]]
    times, odometry, ranges = zip(*cells)
    return times, np.array(odometry), bearings, np.array(ranges)


def main(map_file, trial, answer, start, seed="1", count="20000"):
    random, count = np.random.default_rng(int(seed)), int(count)
    edge, corner, width, height, pixels = read_map(Path(map_file))
    cells = np.frombuffer(pixels, np.uint8).reshape(height, width)
    far_m = distance_transform_edt(cells != 0) * edge
    times, odometry, bearings, ranges = read_trial(trial)
    if start == "unknown":
        rows, columns = np.nonzero(cells > 250)
        drawn = random.integers(len(rows), size=count)
        x = corner[0] + (columns[drawn] + random.random(count)) * edge
        y = corner[1] + (rows[drawn] + random.random(count)) * edge
        heading = random.uniform(-np.pi, np.pi, count)
    else:
        pose = [float(part) for part in start.split(",")]
        x, y, heading = (random.normal(middle, spread, count) for middle, spread in zip(pose, (0.3, 0.3, 0.1)))
    table = ["time_s,x_m,y_m,heading_rad,weight"]
    for k, time_s in enumerate(times):
        if k:
            (bx, by, bh), (ax, ay, ah) = odometry[k - 1], odometry[k]
            forward = (ax - bx) * np.cos(bh) + (ay - by) * np.sin(bh)
            left = (ay - by) * np.cos(bh) - (ax - bx) * np.sin(bh)
            turn = (ah - bh + np.pi) % (2 * np.pi) - np.pi
            step = np.hypot(forward, left)
            forward = forward + random.normal(0, NOISE_M + 0.1 * step, count)
            left = left + random.normal(0, NOISE_M + 0.1 * step, count)
            x, y = x + forward * np.cos(heading) - left * np.sin(heading), y + forward * np.sin(heading) + left * np.cos(heading)
            heading = heading + turn + random.normal(0, NOISE_RAD + 0.1 * abs(turn), count)
        log = np.zeros(count)
        for bearing, r in zip(bearings, ranges[k]):
            if np.isfinite(r):
                column = np.floor((x + r * np.cos(heading + bearing) - corner[0]) / edge).astype(int)
                row = np.floor((y + r * np.sin(heading + bearing) - corner[1]) / edge).astype(int)
                inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
                off = np.where(inside, far_m[row.clip(0, height - 1), column.clip(0, width - 1)], 10.0)
                log += np.log(np.exp(-0.5 * (off / HIT_M) ** 2) + RANDOM)
        weight = np.exp(POWER * (log - log.max()))
        kept = random.permutation(count)[: count // 10]  # a tenth says it as well, in a tenth of the space
        table += [f"{time_s},{a:.3f},{b:.3f},{h:.4f},{w:.4g}" for a, b, h, w in zip(x[kept], y[kept], heading[kept], weight[kept])]
        ladder = (random.random() + np.arange(count)) / count
        chosen = np.searchsorted(np.cumsum(weight) / weight.sum(), ladder).clip(0, count - 1)
        x, y, heading = x[chosen], y[chosen], heading[chosen]
    Path(answer).write_text("\n".join(table) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
