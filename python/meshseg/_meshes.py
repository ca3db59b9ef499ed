"""Meshes: our own, those of files, and those of other packages, by what they have."""

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _meshseg
from ._arrays import numbers
from ._words import said

#: A :class:`Mesh`; a path or a name such as ``"torus:400x250"``; a pair of vertices and faces; a mesh of trimesh, pyvista,
#: Open3D or meshio.
MeshLike = Any


class Mesh:
    """A triangle mesh.

    Parameters
    ----------
    vertices : (V, 3) floats
        Positions, in any unit of length.
    faces : (F, 3) integers
        Indices of vertices, from 0.
    colors, face_colors : (V, 3) or (F, 3) numbers, optional
        RGB in [0, 1], or uint8. A fourth column is ignored.

    Arrays are copied, once for all calls; those of the properties are copies as well.

    >>> mesh = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh
    Mesh(3 vertices, 1 face)
    >>> mesh.area
    0.5
    """

    __slots__ = ("_held",)

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        colors: ArrayLike | None = None,
        face_colors: ArrayLike | None = None,
    ) -> None:
        arrays = (
            numbers("vertices", vertices),
            _indices(faces),
            None if colors is None else _rgb("colors", colors),
            None if face_colors is None else _rgb("face_colors", face_colors),
        )
        with said():
            self._held = _meshseg.Mesh(*arrays)

    @property
    def vertices(self) -> NDArray[np.float64]:
        """(V, 3) positions."""
        return self._held.vertices

    @property
    def faces(self) -> NDArray[np.uint32]:
        """(F, 3) indices of vertices; polygons of a file are divided into triangles."""
        return self._held.faces

    @property
    def colors(self) -> NDArray[np.float64] | None:
        """(V, 3) RGB in [0, 1], if the mesh has them."""
        return self._held.colors

    @property
    def face_colors(self) -> NDArray[np.float64] | None:
        """(F, 3) RGB in [0, 1], if the mesh has them."""
        return self._held.face_colors

    @property
    def area(self) -> float:
        """The total area, in squared units of the mesh."""
        return self._held.area

    def __reduce__(self) -> tuple[Any, ...]:
        """For other processes: positions, faces and colors; textures stay behind."""
        return Mesh, (self.vertices, self.faces, self.colors, self.face_colors)

    def __copy__(self) -> "Mesh":
        """Itself: a mesh does not change."""
        return self

    def __deepcopy__(self, memo: object) -> "Mesh":
        """Itself: a mesh does not change."""
        return self

    def __repr__(self) -> str:
        return repr(self._held)


def _indices(faces: ArrayLike) -> NDArray[np.int64]:
    given = np.asarray(faces)
    if given.dtype.kind not in "iu" and given.size > 0:
        raise ValueError(f"faces: have the type {given.dtype}; they must be integers")
    if np.ma.is_masked(faces):
        raise ValueError("faces: are a masked array; leave out what is masked")
    if given.dtype == np.uint64:
        given = given.astype(np.int64)
    if given.ndim != 2 or given.shape[1] != 3:
        raise ValueError(f"faces: have the shape {given.shape}; they must be triangles, F x 3")
    return np.ascontiguousarray(given, dtype=np.int64)


def _rgb(name: str, colors: ArrayLike) -> NDArray[np.float64]:
    given = np.asarray(colors)
    scale = 255.0 if given.dtype == np.uint8 else 1.0
    rows = numbers(name, given)
    if rows.shape[1] not in (3, 4):
        raise ValueError(f"{name}: have the shape {given.shape}; they must be N x 3")
    rows = np.ascontiguousarray(rows[:, :3]) / scale
    if not (np.nanmin(rows, initial=0.0) >= 0.0 and np.nanmax(rows, initial=0.0) <= 1.0):
        raise ValueError(f"{name}: must be in [0, 1], or uint8")
    return rows


def _holding(held: _meshseg.Mesh) -> Mesh:
    mesh = object.__new__(Mesh)
    mesh._held = held
    return mesh


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """The mesh of a file (OBJ, PLY, OFF or STL), ``"builtin:spot"``, or a shape.

    >>> read_mesh("torus:40x25")
    Mesh(1000 vertices, 2000 faces)
    """
    with said():
        return _holding(_meshseg.read_mesh(path))


def from_trimesh(mesh: Any) -> Mesh:
    """The mesh of a ``trimesh.Trimesh``, with the colors of its vertices or faces; a texture becomes colors of vertices."""
    visual = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "texture":
        visual, kind = visual.to_color(), "vertex"
    return Mesh(
        mesh.vertices,
        mesh.faces,
        visual.vertex_colors if kind == "vertex" else None,
        visual.face_colors if kind == "face" else None,
    )


def from_pyvista(mesh: Any) -> Mesh:
    """The mesh of a ``pyvista.PolyData``; polygons are divided into triangles. Colors are those of ``RGB`` or ``RGBA``."""
    if not mesh.is_all_triangles:
        mesh = mesh.triangulate()
    faces = np.asarray(mesh.faces).reshape(-1, 4)[:, 1:]

    def colors(data: Any) -> Any:
        return next((np.asarray(data[name]) for name in ("RGB", "RGBA") if name in data), None)

    return Mesh(mesh.points, faces, colors(mesh.point_data), colors(mesh.cell_data))


def as_mesh(mesh: MeshLike) -> Mesh:
    """Our mesh of any :data:`MeshLike`."""
    match mesh:
        case Mesh():
            return mesh
        case str() | os.PathLike():
            return read_mesh(mesh)
        case (vertices, faces):
            return Mesh(vertices, faces)
    if hasattr(mesh, "points") and hasattr(mesh, "is_all_triangles"):
        return from_pyvista(mesh)
    if hasattr(mesh, "points") and hasattr(mesh, "extract_surface"):
        return from_pyvista(mesh.extract_surface(algorithm="dataset_surface"))
    if hasattr(mesh, "points") and hasattr(mesh, "cells_dict"):
        if not {"triangle"} <= {*mesh.cells_dict} <= {"triangle", "line", "vertex"}:
            raise ValueError(f"mesh: has cells of {', '.join(mesh.cells_dict) or 'no kind'}; it must have triangles")
        return Mesh(mesh.points, mesh.cells_dict["triangle"])
    if hasattr(mesh, "to_geometry"):
        return from_trimesh(mesh.to_geometry())
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return from_trimesh(mesh)
    if hasattr(mesh, "vertices") and hasattr(mesh, "triangles"):
        colors = np.asarray(getattr(mesh, "vertex_colors", []))
        return Mesh(mesh.vertices, mesh.triangles, colors if len(colors) > 0 else None)
    kind = type(mesh).__name__
    raise TypeError(f"mesh: {kind} is no mesh; give vertices and faces, a path, or a mesh of trimesh or pyvista")
