"""``segment``, ``solve`` and ``evaluate``."""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias

from numpy.typing import ArrayLike

from ._call import heard
from ._meshes import MeshLike
from ._result import Result
from ._words import pythonic

_Path: TypeAlias = str | os.PathLike[str]
_Relaxation: TypeAlias = Literal["frobenius", "separate", "envelope"]
_Mass: TypeAlias = Literal["barycentric", "voronoi", "consistent"]
_Format: TypeAlias = Literal["vtp", "vtu", "glb", "label-gii", "annot", "json"]
_Callback: TypeAlias = Callable[[int, float, float, float, float], object]


def segment(
    mesh: MeshLike,
    data: ArrayLike | str | None = None,
    *,
    regions: int | str | None = None,
    probabilities: ArrayLike | _Path | None = None,
    scores: ArrayLike | _Path | None = None,
    labels_in: ArrayLike | _Path | None = None,
    property: str | None = None,
    lambda_: float | None = None,
    on: Literal["vertices", "faces"] | None = None,
    seeds: ArrayLike | _Path | None = None,
    model: Literal["constant", "l1", "gaussian", "histogram", "albedo", "kmeans", "threshold"] | None = None,
    means: ArrayLike | _Path | None = None,
    thresholds: Sequence[float] | None = None,
    init: Literal["kmeans", "random"] | None = None,
    seed: int | None = None,
    every: int | None = None,
    light: Sequence[float] | None = None,
    ambient: float | None = None,
    project: str | None = None,
    fit: Literal["cover", "stretch"] | None = None,
    texel: Literal["mean", "vertex"] | None = None,
    images: _Path | None = None,
    weights: Literal["pixel", "angle", "unit"] | None = None,
    pure: int | None = None,
    grazing: float | None = None,
    border: int | None = None,
    samples: int | None = None,
    classes: Sequence[str | tuple[str, str]] | _Path | None = None,
    floor: float | None = None,
    confidence: float | None = None,
    unknown: int | Sequence[int] | None = None,
    mask: ArrayLike | _Path | None = None,
    edge_aware: Literal["normals", "colors"] | ArrayLike | _Path | None = None,
    min_area: float | str | None = None,
    fill_holes: float | str | None = None,
    components: bool = False,
    normalize: Literal["area", "none"] | None = None,
    weld: bool | float | None = None,
    relaxation: _Relaxation | None = None,
    pairs: ArrayLike | _Path | None = None,
    mass: _Mass | None = None,
    solver: str | None = None,
    solver_options: Mapping[str, Any] | None = None,
    precision: Literal["f64", "f32"] | None = None,
    gap: float | None = None,
    max_iterations: int | None = None,
    time_limit: float | None = None,
    stop_change: float | None = None,
    check_every: int | None = None,
    coarse_to_fine: bool = False,
    rounding: Literal["expansion", "moves", "argmax"] | None = None,
    label_gap: float | None = None,
    save: Literal["q"] | None = None,
    threads: int | None = None,
    out: _Path | None = None,
    also: _Format | Sequence[_Format] | None = None,
    contours: bool = False,
    cut_mesh: _Path | None = None,
    view: str | None = None,
    no_preview: bool = False,
    callback: _Callback | None = None,
) -> Result:
    """Segments data on a mesh, or class probabilities, into regions.

    Keywords are the options of ``meshseg segment``, whose help says more of each; arrays take the place of files.

    Parameters
    ----------
    mesh
        A :class:`Mesh`, a path, a name such as ``"torus:400x250"``, a pair of vertices and faces, or a mesh of trimesh,
        pyvista, Open3D or meshio.
    data : (V,) or (V, d) numbers, or str, optional
        Numbers at the vertices (uint8 is divided by 255, NaN is unknown), or the name of data: ``"colors"``,
        ``"texture"``, ``"curvature"``, ``"image:photo.jpg"``, ... By default the textures or colors of the mesh.
    regions : int or str
        The number of regions, 2 to 64, or ``"auto"``.
    probabilities, scores : (V, m) or (F, m) numbers
        In place of data: class probabilities or votes, or scores whose softmax is taken. Rows of zeros are unknown.
    labels_in : (V,) or (F,) integers
        Labels to be smoothed; -1 is unknown.
    lambda_ : float
        The weight of the length of the cuts, for a mesh of area 1. By default it is chosen for the data.
    on : "vertices" or "faces"
        Where labels of class probabilities are; by default where the probabilities are.
    seeds : (V,) or (F,) integers
        Labels that are given; -1 where there is none.
    pairs : (m, m) numbers or path
        How much cuts between each two classes weigh; must be a metric.
    gap : float
        The run ends at this certified gap, by default 1e-4.
    out : path
        A folder for the files and the picture of the command line; ``also`` names further formats.
    callback
        Called with samples of the run: iteration, seconds, energy, dual bound, relative gap. A true result ends the run, and
        the result is that reached.

    Returns
    -------
    Result
        Labels, U, energies and bounds. What a user should know is a :class:`MeshsegWarning`.

    Raises
    ------
    ValueError, OSError
        What is wrong, in a sentence.

    Examples
    --------
    Two noisy halves of a sphere:

    >>> import meshseg, numpy as np
    >>> mesh = meshseg.read_mesh("sphere:4")
    >>> truth = (mesh.vertices[:, 2] > 0).astype(int)
    >>> data = truth + np.random.default_rng(0).normal(0, 0.5, len(truth))
    >>> result = meshseg.segment(mesh, data, regions=2)
    >>> float(np.mean(result.labels == truth)) > 0.98
    True

    Votes of eight views for three classes, one row per face:

    >>> centers = mesh.vertices[mesh.faces].mean(axis=1)
    >>> truth = np.digitize(centers[:, 2], [-0.3, 0.3])
    >>> p = np.where(np.eye(3)[truth] > 0, 0.6, 0.2)
    >>> votes = np.random.default_rng(0).multinomial(8, p)
    >>> result = meshseg.segment(mesh, probabilities=votes)
    >>> float(np.mean(result.face_labels == truth)) > 0.97
    True
    """
    options = dict(locals())
    del options["mesh"], options["callback"]
    return Result(heard("segment", mesh, options, callback))


def solve(
    mesh: MeshLike,
    costs: ArrayLike | _Path,
    lambda_: float,
    *,
    on: Literal["vertices", "faces"] | None = None,
    init: Literal["argmin", "uniform", "random"] | ArrayLike | _Path | None = None,
    seed: int | None = None,
    seeds: ArrayLike | _Path | None = None,
    weld: bool | float | None = None,
    relaxation: _Relaxation | None = None,
    pairs: ArrayLike | _Path | None = None,
    mass: _Mass | None = None,
    solver: str | None = None,
    solver_options: Mapping[str, Any] | None = None,
    precision: Literal["f64", "f32"] | None = None,
    gap: float | None = None,
    max_iterations: int | None = None,
    time_limit: float | None = None,
    stop_change: float | None = None,
    check_every: int | None = None,
    coarse_to_fine: bool = False,
    rounding: Literal["expansion", "moves", "argmax"] | None = None,
    label_gap: float | None = None,
    save: Literal["q"] | None = None,
    threads: int | None = None,
    out: _Path | None = None,
    also: _Format | Sequence[_Format] | None = None,
    contours: bool = False,
    cut_mesh: _Path | None = None,
    view: str | None = None,
    no_preview: bool = False,
    callback: _Callback | None = None,
) -> Result:
    """Minimizes sum_k a_k <u_k, s_k> + lambda TV(U) over rows in the simplex, on the mesh as it is, without scaling.

    Keywords are the options of ``meshseg solve``, whose help says more of each; arrays take the place of files.

    Parameters
    ----------
    mesh
        As in :func:`segment`.
    costs : (V, m) or (F, m) floats
        The pointwise costs s; inf forbids a region, a row of NaN is unknown.
    lambda_ : float
        The weight of the total variation, in units of cost times length.
    on : "vertices" or "faces"
        What has a row of costs and gets a label; vertices if left out.
    init : (V, m) or (F, m) floats or str
        The initial U, or ``"uniform"``, ``"random"``, ``"argmin"`` (the default).
    solver, solver_options
        ``"chambolle-pock"``, ``"fista"``, ... and settings such as ``{"epsilon": 0.1}``; see ``meshseg solvers``.
    save : "q"
        Keeps the dual field of the bound, from which :func:`evaluate` computes the same bound.
    callback
        As in :func:`segment`.

    Returns
    -------
    Result
        Labels, U, energies and bounds.

    Examples
    --------
    >>> import meshseg, numpy as np
    >>> mesh = meshseg.read_mesh("torus:40x25")
    >>> costs = np.random.default_rng(0).random((1000, 3))
    >>> result = meshseg.solve(mesh, costs, 0.01, gap=1e-6, save="q")
    >>> result.status, result.relative_gap <= 1e-6
    ('converged', True)
    >>> again = meshseg.evaluate(mesh, costs, result.u, 0.01, q=result.q)
    >>> again["relative_gap"] <= 1e-6
    True
    """
    options = dict(locals())
    del options["mesh"], options["callback"]
    return Result(heard("solve", mesh, options, callback))


def evaluate(
    mesh: MeshLike,
    costs: ArrayLike | _Path,
    u: ArrayLike | _Path,
    lambda_: float,
    *,
    on: Literal["vertices", "faces"] | None = None,
    q: ArrayLike | _Path | None = None,
    dual_steps: int | None = None,
    relaxation: _Relaxation | None = None,
    pairs: ArrayLike | _Path | None = None,
    mass: _Mass | None = None,
    epsilon: float | None = None,
    epsilon_mode: Literal["paper", "intrinsic"] | None = None,
    weld: bool | float | None = None,
) -> dict[str, Any]:
    """Energies, a lower bound and the rounding of any U, whoever computed it; what ``meshseg evaluate`` prints.

    Parameters
    ----------
    mesh, costs, lambda_, on
        The problem, as in :func:`solve`.
    u : (V, m) or (F, m) floats
        Relaxed labels, such as those of another solver.
    q : (2F, m) floats, optional
        A dual field, whose bound is taken. Otherwise the bound is that of ``dual_steps`` steps of the default solver
        from U.
    epsilon : float, optional
        Adds the smoothed energy.

    Returns
    -------
    dict
        ``energy``, ``dual_bound``, ``relative_gap``, ``rounded_energy``, ...; gaps are None, with a warning, if a row of U
        is not in the simplex.

    Examples
    --------
    >>> import meshseg, numpy as np
    >>> costs = np.random.default_rng(0).random((1000, 3))
    >>> found = meshseg.evaluate("torus:40x25", costs, np.full((1000, 3), 1 / 3), 0.01)
    >>> found["dual_bound"] <= found["energy"]
    True
    """
    options = dict(locals())
    del options["mesh"]
    found = json.loads(heard("evaluate", mesh, options)["printed"])
    found["warnings"] = [pythonic(sentence) for sentence in found["warnings"]]
    return found
