"""Alpha-expansion with CGAL, in floating point, from the labels of the smallest costs until no move lowers the energy.

`cgal_expansion.cpp` calls CGAL::alpha_expansion_graphcut and measures the construction of its graph and the call. An
implementation is CGAL's max-flow on Boost's graphs (`adjacency-list`, the default of CGAL) or its copy of the MAXFLOW
library (`maxflow`, the fastest). The latter is repaired in `cgal_expansion.cpp`: as CGAL has shipped it since 5.5, it
stops after the first move. CGAL cannot be stopped and does not count sweeps: iterate 1 is the result.

CGAL: doc.cgal.org, package CGAL and the Boost Graph Library. Method: see `gco_expansion`.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from meshseg_reference.potts import Labels, Potts, one_hot, potts
from meshseg_reference.problem import InputError, Problem
from meshseg_reference.trace import Sample, Trace

PROGRAM = "MESHSEG_CGAL_EXPANSION"


@dataclass(frozen=True)
class Options:
    implementation: Literal["adjacency-list", "maxflow"] = "adjacency-list"


def expand(energy: Potts, implementation: str) -> tuple[Labels, float]:
    """The final labels, and the seconds that the program reports."""
    if PROGRAM not in os.environ:
        raise InputError(f"{PROGRAM} does not name the compiled cgal_expansion.cpp; `run cgal` sets it")
    sizes = np.array([*energy.costs.shape, len(energy.weights)], np.int64)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with (folder / "problem").open("wb") as file:
            for array in (sizes, energy.costs, energy.pairs, energy.weights, energy.start):
                array.tofile(file)
        command = (os.environ[PROGRAM], implementation, folder / "problem", folder / "labels")
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise InputError(f"cgal_expansion failed ({done.returncode}): {done.stderr.strip()}")
        return np.fromfile(folder / "labels", np.int32), float(done.stdout)


def solve(problem: Problem, trace: Trace, options: Options) -> None:
    energy = potts(problem)
    trace.write(0, 0.0, Sample(problem.u0))
    labels, seconds = expand(energy, options.implementation)
    trace.write(1, seconds, Sample(one_hot(labels, problem.regions)))
