"""A complete solver: python example.py PROBLEM.npz OUT. Chambolle-Pock, tau = sigma <= 1 / |lambda K|."""

import sys, time
import numpy as np
from scipy.sparse import csr_array

problem = np.load(sys.argv[1])
K = csr_array((problem["K_data"], problem["K_indices"], problem["K_indptr"]), shape=problem["K_shape"]) * problem["lambda"]
f, u, q = problem["f"], problem["u0"], np.zeros((K.shape[0], problem["f"].shape[1]))
step = 1 / np.sqrt(abs(K).sum(axis=0).max() * abs(K).sum(axis=1).max())
trace, seconds = open(f"{sys.argv[2]}/trace.csv", "w"), 0.0
print("iteration,seconds,epsilon,epsilon_mode", file=trace)
for iteration in range(501):
    if iteration % 20 == 0:
        np.save(f"{sys.argv[2]}/u_{iteration:08}.npy", u)
        print(f"{iteration},{seconds},,", file=trace, flush=True)
    start = time.perf_counter()
    v = u - step * (f + K.T @ q)
    thresholds = (np.cumsum(-np.sort(-v), axis=1) - 1) / np.arange(1, v.shape[1] + 1)
    u, before = np.maximum(v - thresholds.max(axis=1, keepdims=True), 0), u
    q += step * (K @ (2 * u - before))
    q /= np.maximum(np.linalg.norm(q.reshape(len(q) // 2, -1), axis=1), 1).repeat(2)[:, None]
    seconds += time.perf_counter() - start
