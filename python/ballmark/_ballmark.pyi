"""The compiled part; use ``ballmark`` itself."""

from collections.abc import Callable
from typing import Any

import numpy as np

class Dataset:
    @staticmethod
    def read(path: str) -> Dataset: ...
    @staticmethod
    def of_columns(
        stamp: np.ndarray,
        pose: np.ndarray,
        channels: list[tuple[Any, ...]],
        odometry: np.ndarray | None,
        run: np.ndarray | None,
        route: np.ndarray | None,
        compass: np.ndarray | None,
        source: str | None,
    ) -> Dataset: ...
    def write(self, path: str) -> None: ...
    def __len__(self) -> int: ...
    def channel(self, name: str) -> np.ndarray: ...
    @property
    def described(self) -> list[tuple[str, str, list[float] | None, float | None, list[float] | None]]: ...
    @property
    def stamp(self) -> np.ndarray: ...
    @property
    def pose(self) -> np.ndarray: ...
    @property
    def odometry(self) -> np.ndarray: ...
    @property
    def run(self) -> np.ndarray: ...
    @property
    def route(self) -> np.ndarray | None: ...
    @property
    def compass(self) -> np.ndarray | None: ...
    @property
    def source(self) -> str | None: ...
    @property
    def path_m(self) -> float: ...

class Model:
    @staticmethod
    def read(path: str) -> Model: ...
    def write(self, path: str) -> None: ...
    @property
    def features(self) -> int: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def header_json(self) -> str: ...
    def of_dataset(self, dataset: Dataset) -> np.ndarray: ...
    def of_values(self, values: np.ndarray) -> np.ndarray: ...

def command(arguments: list[str]) -> int: ...
def import_log(logs: list[str], **options: Any) -> tuple[Dataset, str]: ...
def train(
    dataset: Dataset,
    *,
    uncertainty: str | None,
    features: int | None,
    steps: int | None,
    seed: int | None,
    test_fold: int | None,
    recipe: str | None,
    config: str | None,
    on_progress: Callable[[int, int, float | None], Any] | None,
) -> Model: ...
def localise(
    models: list[Model],
    dataset: Dataset,
    *,
    trained_on: Dataset | None,
    trials: int | None,
    seed: int | None,
    config: str | None,
    on_progress: Callable[[int, int, str], Any] | None,
) -> tuple[str, str]: ...
def compare(
    config: str,
    *,
    seed: int | None,
    toy: bool,
    models: str | None,
    on_progress: Callable[[int, int, str], Any] | None,
) -> str: ...
def score(
    location: list[str],
    response: list[str],
    *,
    trial: list[str] | None,
    distance_m: list[float] | None,
    permutations: int,
    resamples: int,
    seed: int,
) -> str: ...
def uncertainty_coefficient(location: list[str], response: list[str]) -> float | None: ...
