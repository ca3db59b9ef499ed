"""Meshes of other packages, and meshes that are none."""

from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import pyvista
import trimesh

import meshseg
from meshseg._meshes import as_mesh

CORNERS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
FACES = [[0, 1, 2], [0, 2, 3]]
RED_TO_BLUE = np.array([[255, 0, 0], [200, 0, 55], [55, 0, 200], [0, 0, 255]], np.uint8)


def is_the_square(mesh):
    return mesh.vertices.tolist() == CORNERS and mesh.faces.tolist() == FACES


def test_of_arrays():
    mesh = meshseg.Mesh(np.array(CORNERS, np.float32), np.array(FACES, np.uint8), RED_TO_BLUE)
    assert is_the_square(mesh) and mesh.area == 1.0
    assert np.array_equal(mesh.colors, RED_TO_BLUE / 255) and mesh.face_colors is None
    assert repr(mesh) == "Mesh(4 vertices, 2 faces)"
    mesh.vertices[:] = 7  # a copy
    assert is_the_square(mesh)


def test_of_trimesh():
    square = trimesh.Trimesh(CORNERS, FACES, process=False, vertex_colors=RED_TO_BLUE)
    mesh = meshseg.from_trimesh(square)
    assert is_the_square(mesh) and np.array_equal(mesh.colors, RED_TO_BLUE / 255)
    by_face = trimesh.Trimesh(CORNERS, FACES, process=False, face_colors=RED_TO_BLUE[:2])
    assert np.array_equal(meshseg.from_trimesh(by_face).face_colors, RED_TO_BLUE[:2] / 255)
    assert meshseg.from_trimesh(trimesh.Trimesh(CORNERS, FACES)).colors is None


def test_a_texture_of_trimesh_becomes_colors():
    from PIL import Image

    image = Image.fromarray(RED_TO_BLUE.reshape(2, 2, 3))
    visual = trimesh.visual.TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], image=image)
    mesh = meshseg.from_trimesh(trimesh.Trimesh(CORNERS, FACES, process=False, visual=visual))
    expected = RED_TO_BLUE[[2, 3, 1, 0]] / 255
    assert np.allclose(mesh.colors, expected, atol=0.02)


def test_of_pyvista():
    square = pyvista.PolyData(np.array(CORNERS, float), [4, 0, 1, 2, 3])
    square.point_data["RGB"] = RED_TO_BLUE
    mesh = meshseg.from_pyvista(square)
    assert mesh.vertices.tolist() == CORNERS and mesh.area == 1.0 and len(mesh.faces) == 2
    assert np.array_equal(mesh.colors, RED_TO_BLUE / 255)


def test_by_what_they_have(tmp_path):
    corners, faces = np.array(CORNERS, float), np.array(FACES)
    file = tmp_path / "square.off"
    file.write_text("OFF 4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n")
    open3d = SimpleNamespace(vertices=corners, triangles=faces, vertex_colors=RED_TO_BLUE / 255.0)
    polygons = np.insert(faces, 0, 3, axis=1)
    for mesh in (
        (CORNERS, FACES),
        [corners, faces],
        file,
        str(file),
        meshio.Mesh(corners, [("triangle", faces)]),
        open3d,
        trimesh.Trimesh(corners, faces, process=False),
        pyvista.PolyData(corners, polygons),
    ):
        assert is_the_square(as_mesh(mesh)), mesh
    assert np.array_equal(as_mesh(open3d).colors, RED_TO_BLUE / 255)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (CORNERS, [[0, 1, 4]], r"faces: row 0 is \[0, 1, 4\]; the 4 vertices are numbered from 0"),
        (CORNERS, [[0, 1, -1]], "faces: row 0"),
        (CORNERS, [[0.5, 1, 2]], "integers"),
        (CORNERS, [[0, 1, 2, 3]], "triangles"),
        ([[0, 0, np.nan]], FACES, "vertices: row 0 has an entry that is not finite"),
        ([[0, 0]], FACES, "N x 3"),
        ([["a", "b", "c"]], FACES, "numbers"),
    ],
)
def test_what_is_no_mesh(vertices, faces, message):
    with pytest.raises(ValueError, match=message):
        meshseg.Mesh(vertices, faces)


def test_colors_that_do_not_fit():
    with pytest.raises(ValueError, match="colors: has 1 rows; the mesh needs 4"):
        meshseg.Mesh(CORNERS, FACES, [[0, 0, 0]])
    with pytest.raises(ValueError, match="colors: must be in"):
        meshseg.Mesh(CORNERS, FACES, [[0, 0, 2]] * 4)
    with pytest.raises(TypeError, match="mesh: int is no mesh"):
        meshseg.segment(3, regions=2)


def test_files_that_are_not_there():
    with pytest.raises(FileNotFoundError, match="no.ply"):
        meshseg.read_mesh("no.ply")
    with pytest.raises(ValueError, match="torus:0x0"):
        meshseg.read_mesh("torus:0x0")
