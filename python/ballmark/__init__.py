"""Learn a robot's own landmarks (BaLL, Thrun 1998), localise with them, and judge the result.

The package is the Rust crate of the same name: the same results to the last digit, the same sentences where something is
wrong. Arrays are numpy's; lengths are metres, angles radians, times seconds, unless a name says otherwise.

>>> import ballmark, numpy as np
>>> ballmark.uncertainty_coefficient(["hall", "hall", "door", "door"], [1, 1, 2, 2])
1.0
"""

from __future__ import annotations

import json as _json
import os as _os
import warnings as _warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as _np

from . import _ballmark

__all__ = [
    "Channel",
    "Dataset",
    "Imported",
    "Localised",
    "Model",
    "compare",
    "import_log",
    "localise",
    "read",
    "score",
    "train",
    "uncertainty_coefficient",
]

_Path = str | _os.PathLike[str]
_Config = _Path | Mapping[str, Any]


class Channel(NamedTuple):
    """One sensor, or one kind of sensor.

    ``values``: ``[K, D]`` readings, float32, NaN where nothing came back (None in what :attr:`Dataset.channels` answers; ask
    the dataset itself). ``unit``: ``"m"`` for ranges, anything else as recorded. ``bearing_rad``: ``[D]`` directions of the
    values, counter-clockwise from ahead; scans can be moved to other poses only where they are known. ``maximum``: reading
    from which on there was no return. ``offset_m``: ``[D]`` metres from the robot's middle, along the bearings.
    """

    values: _np.ndarray | None = None
    unit: str = "as recorded"
    bearing_rad: Sequence[float] | None = None
    maximum: float | None = None
    offset_m: Sequence[float] | None = None


class Dataset:
    """A recording: K snapshots of all sensors, the place of each, and odometry.

    ``dataset["sonar"]`` is a read-only view of a channel's values, ``[K, D]`` float32; nothing is copied.
    """

    def __init__(self, inner: _ballmark.Dataset) -> None:
        self._inner = inner

    @staticmethod
    def read(path: _Path) -> Dataset:
        """Reads a dataset (``.npz``), as ``ballmark import`` and :meth:`write` write it.

        Raises ``ValueError`` where it is none, ``OSError`` where it can't be read.
        """
        return Dataset(_ballmark.Dataset.read(_os.fspath(path)))

    @staticmethod
    def from_arrays(
        *,
        stamp: Any,
        pose: Any,
        channels: Mapping[str, Any],
        odometry: Any = None,
        run: Any = None,
        route: Any = None,
        compass: Any = None,
        source: str | None = None,
    ) -> Dataset:
        """A dataset of arrays.

        ``stamp``: ``[K]`` seconds. ``pose``: ``[K, 3]`` x, y in metres, heading in radians: the labels. ``channels``: arrays
        ``[K, D]`` by name, or :class:`Channel` where unit and bearings are known. ``odometry``: ``[K, 3]`` raw dead-reckoned poses;
        without it the poses are repeated. ``run``: ``[K]`` whole numbers, 0 where not said. ``route``: ``[K]`` metres along a
        route. ``compass``: ``[K]`` radians.

        Raises ``ValueError`` where lengths differ, a number of place or time is not finite, or a channel makes no sense.
        """

        def column(values: Any, dtype: type) -> Any:
            return None if values is None else _np.ascontiguousarray(values, dtype=dtype)

        def given(name: str, channel: Any) -> tuple[Any, ...]:
            if not isinstance(channel, Channel):
                channel = Channel(channel)
            values = _np.asarray(channel.values, dtype=_np.float32)
            if values.ndim == 1:
                values = values[:, None]
            if values.ndim != 2:
                raise ValueError(f"channel `{name}`: {values.ndim} dimensions; expected 2: snapshots, values")
            lists = [None if v is None else [float(x) for x in v] for v in (channel.bearing_rad, channel.offset_m)]
            return (name, values, channel.unit, lists[0], channel.maximum, lists[1])

        return Dataset(
            _ballmark.Dataset.of_columns(
                stamp=column(stamp, _np.float64),
                pose=column(pose, _np.float64),
                channels=[given(name, channel) for name, channel in channels.items()],
                odometry=column(odometry, _np.float64),
                run=column(run, _np.int64),
                route=column(route, _np.float64),
                compass=column(compass, _np.float64),
                source=source,
            )
        )

    def write(self, path: _Path) -> None:
        """Writes it as ``.npz``, whole or not at all; numpy opens it with ``allow_pickle=False``."""
        self._inner.write(_os.fspath(path))

    def __len__(self) -> int:
        return len(self._inner)

    def __getitem__(self, channel: str) -> _np.ndarray:
        return self._inner.channel(channel)

    @property
    def channels(self) -> dict[str, Channel]:
        """What is known of each channel, by name, in order; without the values."""
        return {name: Channel(None, *rest) for name, *rest in self._inner.described}

    @property
    def stamp(self) -> _np.ndarray:
        """Seconds, ``[K]``."""
        return self._inner.stamp

    @property
    def pose(self) -> _np.ndarray:
        """The labels, ``[K, 3]``: x, y in metres, heading in radians."""
        return self._inner.pose

    @property
    def odometry(self) -> _np.ndarray:
        """Raw dead-reckoned poses, ``[K, 3]``, cumulative."""
        return self._inner.odometry

    @property
    def run(self) -> _np.ndarray:
        """Run of each snapshot, ``[K]``."""
        return self._inner.run

    @property
    def route(self) -> _np.ndarray | None:
        """Metres along a route, ``[K]``, where there is one."""
        return self._inner.route

    @property
    def compass(self) -> _np.ndarray | None:
        """Compass heading in radians, ``[K]``, where there is one."""
        return self._inner.compass

    @property
    def source(self) -> str | None:
        """Where the data came from."""
        return self._inner.source

    def __repr__(self) -> str:
        channels = ", ".join(f"{name}[{self[name].shape[1]}]" for name in self.channels)
        return f"<ballmark.Dataset: {len(self)} snapshots over {self._inner.path_m:.1f} m, {channels}>"


class Imported(NamedTuple):
    """A dataset, and what became of everything that the logs held."""

    dataset: Dataset
    account: dict[str, Any]


def read(path: _Path) -> Dataset:
    """Reads a dataset: :meth:`Dataset.read`."""
    return Dataset.read(path)


def import_log(
    *logs: _Path,
    format: str | None = None,
    max_range: float | None = None,
    columns: Sequence[str] = (),
    drop: Sequence[str] = (),
    unit: Mapping[str, str] | None = None,
    bearings: Mapping[str, Sequence[float]] | None = None,
    offset: Mapping[str, float] | None = None,
    gap: float | None = None,
    poses: _Path | None = None,
    pose_times: _Path | None = None,
    pose_tolerance: float | None = None,
    pose_topic: str | None = None,
    topics: Sequence[str] | None = None,
) -> Imported:
    """Turns logs into a dataset, as ``ballmark import`` does; each log becomes a run of its own.

    Options as the command's: ``max_range`` and ``gap`` in metres, ``bearings`` in degrees to the left of ahead by channel, ``offset`` in
    metres by channel, ``poses`` a file of poses to label the snapshots with (TUM, KITTI, CSV, g2o), ``pose_tolerance`` in seconds;
    of bags (rosbag1, rosbag2, MCAP) ``pose_topic`` and ``topics``.

    Answers the dataset and an account: ``notes``, ``warnings``, ``used``, ``passed_over``, ``dropped`` and the first ``dropped_records``.
    Records that were lost are also a Python warning, as they are exit status 3 of the command.
    """
    inner, account = _ballmark.import_log(
        [_os.fspath(log) for log in logs],
        format=format,
        max_range=max_range,
        columns=list(columns),
        drop=list(drop),
        units=dict(unit or {}),
        bearings={name: [float(x) for x in deg] for name, deg in (bearings or {}).items()},
        offsets=dict(offset or {}),
        gap=gap,
        poses=None if poses is None else _os.fspath(poses),
        pose_times=None if pose_times is None else _os.fspath(pose_times),
        pose_tolerance=pose_tolerance,
        pose_topic=pose_topic,
        topics=None if topics is None else list(topics),
    )
    account = _json.loads(account)
    if account["dropped"]:
        _warnings.warn(f"{account['dropped']} records dropped: {'; '.join(account['dropped_records'])}", stacklevel=2)
    return Imported(Dataset(inner), account)


class Model:
    """Trained filters with their map: what :func:`train` learns and the robot carries."""

    def __init__(self, inner: _ballmark.Model) -> None:
        self._inner = inner

    @staticmethod
    def read(path: _Path) -> Model:
        """Reads a model (``.safetensors`` or ``.npz``).

        Raises ``ValueError`` where it is none, ``OSError`` where it can't be read.
        """
        return Model(_ballmark.Model.read(_os.fspath(path)))

    def write(self, path: _Path) -> None:
        """Writes it, whole or not at all; the name ends in ``.safetensors`` or ``.npz``."""
        self._inner.write(_os.fspath(path))

    @property
    def features(self) -> int:
        """Number n of filters."""
        return self._inner.features

    @property
    def header(self) -> dict[str, Any]:
        """Everything of it that is no array: the resolved recipe, the channels, the scores."""
        return _json.loads(self._inner.header_json)

    @property
    def scores(self) -> dict[str, Any]:
        """Expected errors before and after sensing, on the part ``train`` and the part ``validation``; :func:`localise` tells of the rest."""
        return self.header["scores"]

    @property
    def notes(self) -> list[str]:
        """What one should know of its training besides the scores; empty for a model that was read."""
        return self._inner.notes

    def probabilities(self, snapshots: Dataset | Any) -> _np.ndarray:
        """P(f_i = 1 | s), ``[K, n]`` float32: of a dataset, or of raw readings ``[K, D]``, channels side by side in the model's
        order, NaN where nothing came back. One snapshot ``[D]`` answers ``[n]``.
        """
        if isinstance(snapshots, Dataset):
            return self._inner.of_dataset(snapshots._inner)
        values = _np.asarray(snapshots, dtype=_np.float32)
        answer = self._inner.of_values(_np.atleast_2d(values))
        return answer[0] if values.ndim == 1 else answer

    def __repr__(self) -> str:
        header = self.header
        return f"<ballmark.Model: {self.features} features for {header['prior']}>"


def _source(config: _Config | None) -> str | None:
    if config is None:
        return None
    if isinstance(config, Mapping):
        return "json:" + _json.dumps(config)
    return _os.fspath(config)


def train(
    dataset: Dataset,
    *,
    uncertainty: str | None = None,
    features: int | None = None,
    steps: int | None = None,
    seed: int | None = None,
    test_fold: int | None = None,
    recipe: str | None = None,
    config: _Config | None = None,
    on_progress: Callable[[int, int, float | None], Any] | None = None,
) -> Model:
    """Learns filters for a prior uncertainty, by gradient descent on the expected localisation error after sensing.

    ``uncertainty``: ``"2m"`` (the robot knows its place to ±2 m), ``"global"`` (it knows nothing), … ``features``: how many filters.
    ``test_fold``: every fourth run or stretch with this number (0 to 3) is kept for testing. ``config``: a TOML file as the
    command's, or a dict of the same sections, such as ``{"train": {"descent": {"learning_rate": 0.01}}}``. What an argument says
    goes before the file.

    ``on_progress(step, most_steps, best_validation)`` is called after every step; answering ``False`` ends the training with the
    best so far, an exception (Ctrl-C, too) ends it with that. Python's lock is free meanwhile.
    """
    return Model(
        _ballmark.train(
            dataset._inner,
            uncertainty=uncertainty,
            features=features,
            steps=steps,
            seed=seed,
            test_fold=test_fold,
            recipe=recipe,
            config=_source(config),
            on_progress=on_progress,
        )
    )


class Localised(dict[str, Any]):
    """What came of localising: the record that ``ballmark localise --json`` prints; :attr:`table` is for people."""

    table: str = ""


def localise(
    models: Model | Iterable[Model],
    dataset: Dataset,
    *,
    trained_on: Dataset | None = None,
    trials: int | None = None,
    seed: int | None = None,
    config: _Config | None = None,
    on_progress: Callable[[int, int, str], Any] | None = None,
) -> Localised:
    """Localises globally and from a known start on runs that training never saw, beside baselines that learn nothing.

    Given the dataset that the models were trained on, the trials run on its test part (or on validation where there is none);
    given another one on all of it, and the baselines need ``trained_on``. The key ``systems`` has a dict each. ``on_progress(done, all,
    next)`` is called with each system that plays.
    """
    models = [models] if isinstance(models, Model) else list(models)
    record, table = _ballmark.localise(
        [model._inner for model in models],
        dataset._inner,
        trained_on=None if trained_on is None else trained_on._inner,
        trials=trials,
        seed=seed,
        config=_source(config),
        on_progress=on_progress,
    )
    localised = Localised(_json.loads(record))
    localised.table = table
    return localised


def compare(
    config: _Path,
    *,
    seed: int | None = None,
    toy: bool = False,
    models: _Path | None = None,
    on_progress: Callable[[int, int, str], Any] | None = None,
) -> dict[str, Any]:
    """Compares systems on datasets as a TOML file says (``ballmark compare``); answers the record, ``comparison.json``.

    ``models``: a folder for the models that are trained on the way; none are kept without it. ``toy``: small, to try a file.
    """
    models = None if models is None else _os.fspath(models)
    return _json.loads(
        _ballmark.compare(_os.fspath(config), seed=seed, toy=toy, models=models, on_progress=on_progress)
    )


def _labels(values: Iterable[Any]) -> list[str]:
    return [str(value) for value in (values.tolist() if isinstance(values, _np.ndarray) else values)]


def score(
    location: Iterable[Any],
    response: Iterable[Any],
    *,
    trial: Iterable[Any] | None = None,
    distance_m: Iterable[float] | None = None,
    permutations: int = 999,
    resamples: int = 999,
    seed: int = 0,
) -> dict[str, Any]:
    """How much do responses tell about the true location? (Duckett & Nehmzow 1998; ``ballmark score``)

    ``location`` and ``response``: labels of any kind, one a row; ``trial``: over which the interval is drawn; ``distance_m``: adds the
    coefficient at each distance, ``by_distance``. Answers the coefficient, the one corrected for chance, a p-value of so many
    ``permutations``, an interval of so many bootstrap ``resamples``, and ``notes``.
    """
    return _json.loads(
        _ballmark.score(
            _labels(location),
            _labels(response),
            trial=None if trial is None else _labels(trial),
            distance_m=None if distance_m is None else [float(d) for d in distance_m],
            permutations=permutations,
            resamples=resamples,
            seed=seed,
        )
    )


def uncertainty_coefficient(location: Iterable[Any], response: Iterable[Any]) -> float | None:
    """U(L|R): the share of the location's entropy that the response removes, 0 to 1; None where all locations are one."""
    return _ballmark.uncertainty_coefficient(_labels(location), _labels(response))
