"""Makes the trajectories of tests/trajectories and what evo says of them, evo.json.

    pip install evo==1.38.1
    python benches/peers/trajectories.py tests/trajectories

With `--check` nothing is written: the trajectories there are judged anew and held against evo.json.
"""

import copy
import json
import sys
from pathlib import Path

import numpy as np
from evo import __version__
from evo.core import geometry, lie_algebra, metrics, sync
from evo.core.trajectory import Plane
from evo.tools import file_interface
from scipy.spatial.transform import Rotation

UNITS = {
    "frames": metrics.Unit.frames,
    "m": metrics.Unit.meters,
    "rad": metrics.Unit.radians,
    "deg": metrics.Unit.degrees,
}
RELATIONS = {
    "translation_m": metrics.PoseRelation.translation_part,
    "rotation_deg": metrics.PoseRelation.rotation_angle_deg,
}


def tum(path, stamps, places, rotations, digits):
    quaternions = rotations.as_quat()
    rows = np.column_stack((stamps, places, quaternions))
    lines = [" ".join(f"{value:.{digits}f}" for value in row) for row in rows]
    path.write_text("# stamp x y z qx qy qz qw\n" + "\n".join(lines) + "\n")


def kitti(path, places, rotations):
    rows = [np.column_stack((r, p)).ravel() for r, p in zip(rotations.as_matrix(), places)]
    path.write_text("\n".join(" ".join(f"{v:.6e}" for v in row) for row in rows) + "\n")


def make(folder):
    random = np.random.default_rng(15)
    # A flight in space: the estimate drifts, is too small, in another frame, a few poses are missing and stamps jitter.
    stamps = 1000 + np.arange(200) * 0.1
    t = np.arange(200) * 0.05
    places = np.column_stack((8 * np.sin(t), 5 * np.cos(0.7 * t), 0.5 * t + np.sin(2 * t)))
    rotations = Rotation.from_euler("zyx", np.column_stack((1.4 * t, 0.4 * np.sin(t), 0.3 * np.cos(t))))
    tum(folder / "flight-reference.tum", stamps, places, rotations, 6)
    frame = Rotation.from_euler("zyx", (0.8, -0.2, 0.1))
    drift = np.cumsum(random.normal(0, 0.01, (200, 3)), axis=0)
    turn = Rotation.from_rotvec(np.cumsum(random.normal(0, 0.004, (200, 3)), axis=0))
    kept = np.delete(np.arange(200), (0, 17, 18, 90, 150, 199))
    estimate = 0.8 * frame.apply(places + drift) + (3, -2, 1)
    jitter = random.uniform(-0.004, 0.004, 200)
    tum(folder / "flight-estimate.tum", (stamps + jitter)[kept], estimate[kept], (frame * turn * rotations)[kept], 6)
    # A robot in the plane, its estimate at twice the rate and another clock; it stands for a while.
    stamps = np.arange(150) * 0.2
    heading = np.cumsum(np.where(np.arange(150) % 40 < 25, 0.01, 0.12))
    step = np.where((np.arange(150) > 60) & (np.arange(150) < 70), 0.0, 0.15)
    places = np.column_stack((np.cumsum(step * np.cos(heading)), np.cumsum(step * np.sin(heading)), np.zeros(150)))
    tum(folder / "robot-reference.tum", stamps, places, Rotation.from_euler("z", heading[:, None]), 6)
    fine = np.arange(0, 29.8, 0.1)
    at = lambda values: np.interp(fine, stamps, values)
    noisy = np.column_stack((at(places[:, 0]), at(places[:, 1]), np.zeros(fine.size)))
    noisy[:, :2] += random.normal(0, 0.05, (fine.size, 2))
    headings = Rotation.from_euler("z", (at(heading) + random.normal(0, 0.03, fine.size))[:, None])
    tum(folder / "robot-estimate.tum", fine + 5.001, noisy, headings, 6)
    # A car without time stamps, matrices of seven digits.
    t = np.arange(120) * 0.1
    places = np.column_stack((10 * t, 0.1 * np.sin(t), 30 * np.sin(0.2 * t)))
    rotations = Rotation.from_euler("yxz", np.column_stack((0.3 * t, 0.02 * np.sin(t), 0.01 * np.cos(t))))
    kitti(folder / "car-reference.kitti", places, rotations)
    drift = np.cumsum(random.normal(0, 0.02, (120, 3)), axis=0)
    turn = Rotation.from_rotvec(np.cumsum(random.normal(0, 0.002, (120, 3)), axis=0))
    kitti(folder / "car-estimate.kitti", places + drift, turn * rotations)


def read(path):
    is_kitti = path.suffix == ".kitti"
    return (file_interface.read_kitti_poses_file if is_kitti else file_interface.read_tum_trajectory_file)(path)


def aligned(reference, estimate, kind):
    estimate = copy.deepcopy(estimate)
    scale = kind.startswith("sim")
    if kind in ("se3", "sim3"):
        estimate.align(reference, correct_scale=scale)
    elif kind in ("se2", "sim2"):
        # evo aligns in space alone; its Umeyama alignment takes any dimension.
        r, t, c = geometry.umeyama_alignment(
            estimate.positions_xyz[:, :2].T.copy(), reference.positions_xyz[:, :2].T.copy(), scale
        )
        poses = []
        for pose in estimate.poses_se3:
            pose = pose.copy()
            pose[:2, 3] *= c
            poses.append(pose)
        rotation, shift = np.eye(3), np.zeros(3)
        rotation[:2, :2], shift[:2] = r, t
        estimate._cache.replace_poses_se3(poses)
        estimate.transform(lie_algebra.se3(rotation, shift))
    return estimate


def statistics(metric, pair):
    metric.process_data(pair)
    return {name: float(value) for name, value in metric.get_all_statistics().items()}


def judged(folder, case):
    reference, estimate = read(folder / case["reference"]), read(folder / case["estimate"])
    if hasattr(reference, "timestamps"):
        reference, estimate = sync.associate_trajectories(
            reference, estimate, max_diff=case["max_difference_s"], offset_2=case["offset_s"]
        )
    estimate = aligned(reference, estimate, case["align"])
    if case["planar"]:
        reference = copy.deepcopy(reference)
        reference.project(Plane.XY)
        estimate.project(Plane.XY)
    pair = (reference, estimate)
    result = {"matched": reference.num_poses, "ape": {}, "rpe": {}}
    for key, relation in RELATIONS.items():
        result["ape"][key] = statistics(metrics.APE(relation), pair)
        relative = metrics.RPE(
            relation,
            case["delta"],
            UNITS[case["delta_unit"]],
            case["delta_tolerance"],
            case["all_pairs"],
            case["pairs_from_reference"],
        )
        result["rpe"][key] = statistics(relative, pair)
        result["pairs"] = len(relative.error)
    return result


def cases():
    flight = {"reference": "flight-reference.tum", "estimate": "flight-estimate.tum"}
    robot = {"reference": "robot-reference.tum", "estimate": "robot-estimate.tum", "offset_s": -5.0}
    car = {"reference": "car-reference.kitti", "estimate": "car-estimate.kitti"}
    default = {
        "max_difference_s": 0.01,
        "offset_s": 0.0,
        "align": "none",
        "planar": False,
        "delta": 1.0,
        "delta_unit": "frames",
        "delta_tolerance": 0.1,
        "all_pairs": False,
        "pairs_from_reference": False,
    }
    for align in ("none", "se2", "se3", "sim2", "sim3"):
        for files in (flight, robot, car):
            yield default | files | {"align": align}
    yield default | flight | {"max_difference_s": 0.002, "align": "sim3", "planar": True}
    yield default | flight | {"offset_s": 0.1, "align": "se3"}
    for delta, unit in ((7.0, "frames"), (2.0, "m"), (0.5, "rad"), (40.0, "deg")):
        for all_pairs in (False, True):
            yield default | flight | {"delta": delta, "delta_unit": unit, "all_pairs": all_pairs}
            yield default | robot | {
                "delta": delta, "delta_unit": unit, "all_pairs": all_pairs,
                "pairs_from_reference": True, "delta_tolerance": 0.03,
            }
    yield default | car | {"delta": 10.0, "delta_unit": "m", "all_pairs": True, "planar": True}


def main():
    folder = Path(sys.argv[1])
    check = "--check" in sys.argv
    if not check:
        folder.mkdir(exist_ok=True)
        make(folder)
    found = {"evo": __version__, "cases": [case | judged(folder, case) for case in cases()]}
    text = json.dumps(found, indent=1) + "\n"
    if check:
        assert text == (folder / "evo.json").read_text(), "evo says something else now"
    else:
        (folder / "evo.json").write_text(text)


main()
