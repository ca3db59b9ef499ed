"""The certified gap over time of two solvers, as a plot."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import meshseg

mesh = meshseg.read_mesh("torus:100x60")
costs = np.random.default_rng(0).random((len(mesh.vertices), 4))

frames = {}
for solver in ("chambolle-pock", "fista"):
    result = meshseg.solve(mesh, costs, 0.002, solver=solver, gap=1e-4, max_iterations=400)
    frames[solver] = result.history.frame()
history = pd.concat(frames, names=["solver"]).reset_index("solver")
print(history.groupby("solver")[["iteration", "seconds", "relative_gap"]].last())

figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
for solver, samples in history.groupby("solver"):
    axes.loglog(samples.iteration.clip(lower=1), samples.relative_gap, label=solver)
axes.set_xlabel("iterations")
axes.set_ylabel("certified relative gap")
axes.legend()
figure.savefig("history.png", dpi=150)
