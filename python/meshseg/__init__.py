"""Convex multi-region segmentation of data on triangle meshes, with certified optimality gaps.

>>> import meshseg
>>> result = meshseg.segment("builtin:spot", regions=3)
>>> result.labels.shape, result.labels.dtype
((46850,), dtype('int32'))
>>> result.relative_gap <= 1e-4  # certified: no U has a lower energy by more than this
True

Everything is computed as by the command line, ``python -m meshseg``, with the same bits on any number of threads.
"""

from ._meshes import Mesh, MeshLike, from_pyvista, from_trimesh, read_mesh
from ._meshseg import __version__
from ._numbers import Operators, kmeans, operators
from ._result import History, MeshsegWarning, Result
from ._verbs import evaluate, segment, solve

__all__ = [
    "History",
    "Mesh",
    "MeshLike",
    "MeshsegWarning",
    "Operators",
    "Result",
    "__version__",
    "evaluate",
    "from_pyvista",
    "from_trimesh",
    "kmeans",
    "operators",
    "read_mesh",
    "segment",
    "solve",
]
