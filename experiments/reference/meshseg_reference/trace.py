"""The output of a solver: iterates at geometrically spaced iterations, and trace.csv.

The clock measures only the iterations of the method. It is paused while a sample is written.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from meshseg_reference.problem import Floats

RATIO = 1.1


class Sample(NamedTuple):
    u: Floats
    q: Floats | None = None
    epsilon: float | None = None
    epsilon_mode: str = ""


class Method(Protocol):
    def advance(self, iterations: int) -> None:
        """Makes iterations, on the clock."""

    def sample(self) -> Sample:
        """The current iterate; called once after each advance, off the clock."""


@dataclass(frozen=True)
class Limits:
    max_iterations: int = 10_000
    time_limit: float = math.inf


class Clock:
    def __init__(self) -> None:
        self._counted = 0.0
        self._since = time.perf_counter()

    def seconds(self) -> float:
        return self._counted + time.perf_counter() - self._since

    @contextmanager
    def paused(self) -> Iterator[float]:
        """Pauses the clock; yields its reading."""
        self._counted = self.seconds()
        try:
            yield self._counted
        finally:
            self._since = time.perf_counter()


class Trace:
    def __init__(self, folder: Path, limits: Limits) -> None:
        self.folder = folder
        self.limits = limits
        self.last = -1
        self._next = 0
        self._lines = (folder / "trace.csv").open("w", encoding="utf-8")
        self._lines.write("iteration,seconds,epsilon,epsilon_mode\n")
        self._lines.flush()
        self.clock = Clock()

    def is_due(self, iteration: int) -> bool:
        return iteration >= self._next

    def steps_to_next(self) -> int:
        return min(self._next, self.limits.max_iterations) - self.last

    def is_over(self) -> bool:
        return self.last >= self.limits.max_iterations or self.clock.seconds() >= self.limits.time_limit

    def write(self, iteration: int, seconds: float, sample: Sample) -> None:
        """Writes the arrays before the line: a line guarantees that its arrays are complete."""
        self._save(f"u_{iteration:08}.npy", sample.u)
        if sample.q is not None:
            self._save(f"q_{iteration:08}.npy", sample.q)
        epsilon = "" if sample.epsilon is None else repr(sample.epsilon)
        self._lines.write(f"{iteration},{seconds:.9f},{epsilon},{sample.epsilon_mode}\n")
        self._lines.flush()
        self.last = iteration
        self._next = max(iteration + 1, math.ceil(RATIO * iteration))

    def _save(self, name: str, array: Floats) -> None:
        temporary = self.folder / f".{name}"
        with temporary.open("wb") as file:
            np.save(file, np.ascontiguousarray(array, dtype=np.float64))
        os.replace(temporary, self.folder / name)


def drive(method: Method, trace: Trace, u0: Floats) -> None:
    """Runs a method from sample to sample until a limit is reached. Iterate 0 is u0."""
    trace.write(0, 0.0, Sample(u0))
    trace.clock = Clock()
    while not trace.is_over():
        steps = trace.steps_to_next()
        method.advance(steps)
        with trace.clock.paused() as seconds:
            trace.write(trace.last + steps, seconds, method.sample())
