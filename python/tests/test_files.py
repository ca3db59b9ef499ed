"""Files that other packages write are read, and those that we write are opened by them, with the same values."""

import json
import subprocess
import sys

import igl
import meshio
import nibabel
import numpy as np
import potpourri3d
import pytest
import pyvista
import trimesh
from PIL import Image

import meshseg

NAMES = ["wall & <roof>", "roof", "tree"]


@pytest.fixture(scope="module")
def sphere():
    mesh = meshseg.read_mesh("sphere:3")
    return mesh.vertices, mesh.faces.astype(int)


@pytest.fixture(scope="module")
def labeled(sphere, tmp_path_factory):
    """A result on faces and one on vertices, with all that they write."""
    vertices, faces = sphere
    rng = np.random.default_rng(0)
    out = tmp_path_factory.mktemp("labeled")
    formats = ["vtp", "vtu", "glb", "label-gii", "annot", "json"]
    votes = rng.multinomial(4, [0.5, 0.3, 0.2], len(faces))
    options = {"lambda_": 0.02, "also": formats, "classes": NAMES, "no_preview": True}
    return {
        on: (meshseg.segment(sphere, probabilities=votes, on=on, out=out / on, **options), out / on)
        for on in ("faces", "vertices")
    }


def test_pyvista_and_meshio_open_what_we_write(sphere, labeled):
    vertices, faces = sphere
    for on, (result, out) in labeled.items():
        for name in ("segmented.vtp", "segmented.vtu"):
            opened = pyvista.read(out / name)
            assert np.array_equal(opened.points, vertices)
            surface = opened if name.endswith("vtp") else opened.extract_surface(algorithm="dataset_surface")
            assert surface.n_cells == len(faces)
            assert np.array_equal(opened.point_data["label"], result.labels)
            assert np.array_equal(opened.cell_data["label"], result.face_labels)
            data = opened.cell_data if on == "faces" else opened.point_data
            assert np.array_equal(data["u"], result.u)
            two = np.sort(result.u, axis=1)[:, -2:]
            assert np.array_equal(data["margin"], two[:, 1] - two[:, 0])
            assert opened.field_data["lambda"][0] == 0.02
            assert opened.field_data["relative_gap"][0] == result.relative_gap
            version = ".".join(f"{part:.0f}" for part in opened.field_data["meshseg_version"])
            assert version == meshseg.__version__
        by_meshio = meshio.read(out / "segmented.vtu")
        assert np.array_equal(by_meshio.cells_dict["triangle"], faces)
        assert np.array_equal(by_meshio.point_data["label"], result.labels)


def test_nibabel_opens_what_we_write(labeled):
    result, out = labeled["vertices"]
    gifti = nibabel.load(out / "segmented.label.gii")
    keys = gifti.darrays[0].data
    names = gifti.labeltable.get_labels_as_dict()
    assert [names[key] for key in keys] == [NAMES[p] for p in result.labels]
    labels, colors, names = nibabel.freesurfer.read_annot(out / "segmented.annot")
    assert np.array_equal(labels, result.labels)
    assert [name.decode() for name in names] == NAMES
    palette = np.array([region["palette"] for region in result.regions])
    assert np.abs(colors[:, :3] / 255 - palette).max() < 0.006


def test_libigl_and_potpourri3d_open_what_we_write(sphere, labeled):
    for _, out in labeled.values():
        for opened in (igl.read_triangle_mesh, potpourri3d.read_mesh):
            vertices, faces = opened(str(out / "segmented.ply"))[:2]
            assert np.array_equal(vertices, sphere[0]) and np.array_equal(faces, sphere[1])


def test_trimesh_opens_what_we_write(sphere, labeled):
    vertices, faces = sphere
    for on, (result, out) in labeled.items():
        (opened,) = trimesh.load(out / "segmented.glb", process=False).dump()
        corners = vertices[faces].reshape(-1, 3) if on == "faces" else vertices
        assert np.allclose(opened.vertices, corners, atol=1e-6)
        assert len(opened.faces) == len(faces)
        # Our own reader finds the same surface.
        assert meshseg.read_mesh(out / "segmented.glb").faces.shape == faces.shape
        written = json.loads((out / "labels.json").read_text())
        assert written["labels"] == result.labels.tolist()
        assert written["face_labels"] == result.face_labels.tolist()
        assert [region["name"] for region in written["regions"]] == NAMES


def same(mesh, sphere, tolerance=0.0):
    vertices, faces = sphere
    assert np.array_equal(mesh.faces, faces)
    assert np.abs(mesh.vertices - vertices).max() <= tolerance


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("name", ["sphere.vtp", "sphere.vtk", "sphere.vtu", "grid.vtk"])
def test_files_of_pyvista(sphere, tmp_path, name, binary):
    vertices, faces = sphere
    surface = pyvista.PolyData(vertices, np.insert(faces, 0, 3, axis=1))
    surface.cell_data["p"] = np.random.default_rng(0).random((len(faces), 3))
    surface.point_data["RGB"] = (255 * np.abs(vertices) / np.abs(vertices).max()).astype(np.uint8)
    is_grid = name in ("sphere.vtu", "grid.vtk")
    written = surface.cast_to_unstructured_grid() if is_grid else surface
    written.save(tmp_path / name, binary=binary)
    mesh = meshseg.read_mesh(tmp_path / name)
    same(mesh, sphere, 0.0 if binary else 1e-5)
    assert np.array_equal(np.rint(255 * mesh.colors), surface.point_data["RGB"])
    result = meshseg.segment(tmp_path / name, property="p", lambda_=1e-9)
    assert np.array_equal(result.face_labels, surface.cell_data["p"].argmax(axis=1))


@pytest.mark.parametrize("name", ["a.vtu", "a.vtk", "a.gltf", "a.glb", "a.ply", "a.off", "a.obj", "a.stl"])
def test_files_of_meshio_and_trimesh(sphere, tmp_path, name):
    vertices, faces = sphere
    if name.endswith(("gltf", "glb")):
        scene = trimesh.Scene(trimesh.Trimesh(vertices, faces, process=False))
        if name.endswith("glb"):
            (tmp_path / name).write_bytes(trimesh.exchange.gltf.export_glb(scene))
        else:
            for part, content in trimesh.exchange.gltf.export_gltf(scene).items():
                (tmp_path / ("a.gltf" if part.endswith("gltf") else part)).write_bytes(content)
        same(meshseg.read_mesh(tmp_path / name), sphere, 1e-7)
        return
    meshio.write(tmp_path / name, meshio.Mesh(vertices, [("triangle", faces)]))
    if name.endswith("stl"):
        assert meshseg.read_mesh(tmp_path / name).faces.shape == faces.shape
        return
    same(meshseg.read_mesh(tmp_path / name), sphere, 1e-6)


@pytest.mark.parametrize("encoding", ["ASCII", "B64BIN", "B64GZ"])
def test_files_of_gifti(sphere, tmp_path, encoding):
    vertices, faces = sphere
    array = nibabel.gifti.GiftiDataArray
    surface = nibabel.gifti.GiftiImage(
        darrays=[
            array(vertices.astype(np.float32), "NIFTI_INTENT_POINTSET", "NIFTI_TYPE_FLOAT32", encoding),
            array(faces.astype(np.int32), "NIFTI_INTENT_TRIANGLE", "NIFTI_TYPE_INT32", encoding),
        ]
    )
    file = tmp_path / "sphere.surf.gii"
    nibabel.save(surface, file)
    same(meshseg.read_mesh(file), (vertices.astype(np.float32).astype(float), faces), 1e-5)
    values = np.abs(vertices[:, 2]).astype(np.float32)
    shape = nibabel.gifti.GiftiImage(
        darrays=[array(values, "NIFTI_INTENT_SHAPE", "NIFTI_TYPE_FLOAT32", encoding)]
    )
    nibabel.save(shape, tmp_path / "z.shape.gii")
    found = meshseg.segment(file, str(tmp_path / "z.shape.gii"), regions=2, lambda_=1e-6)
    expected = meshseg.segment(file, values, regions=2, lambda_=1e-6)
    assert np.mean(found.labels == expected.labels) > 0.99


def test_files_of_freesurfer(sphere, tmp_path):
    vertices, faces = sphere
    file = tmp_path / "lh.white"
    nibabel.freesurfer.write_geometry(file, vertices, faces)
    same(meshseg.read_mesh(file), (vertices.astype(np.float32).astype(float), faces))
    values = vertices[:, 2].astype(np.float32)
    nibabel.freesurfer.write_morph_data(tmp_path / "lh.curv", values)
    found = meshseg.segment(file, str(tmp_path / "lh.curv"), regions=2)
    assert np.array_equal(found.labels, meshseg.segment(file, values, regions=2).labels)
    labels = (vertices[:, 0] > 0).astype(int)
    colors = np.array([[255, 0, 0, 0], [0, 0, 255, 0]])
    annotation = tmp_path / "lh.some.annot"
    nibabel.freesurfer.write_annot(annotation, labels, colors, ["a", "b"], fill_ctab=True)
    found = meshseg.segment(file, labels_in=annotation, lambda_=1e-6)
    assert np.array_equal(found.labels, labels)


def test_textures_inside_glb(tmp_path):
    """A mesh of trimesh with its image in one .glb: its colors are those of the image, and OBJ has them too."""
    x, y = np.meshgrid(np.arange(9), np.arange(9), indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()]).astype(float)
    corner = (9 * np.arange(8)[:, None] + np.arange(8)).ravel()
    faces = np.concatenate(
        [np.column_stack(c) for c in ((corner, corner + 9, corner + 10), (corner, corner + 10, corner + 1))]
    )
    pixels = np.zeros((64, 64, 3), dtype=np.uint8)
    pixels[:, :32] = [200, 30, 10]
    pixels[:, 32:] = [20, 60, 220]
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(pixels))
    visual = trimesh.visual.TextureVisuals(uv=vertices[:, :2] / 8, material=material)
    mesh = trimesh.Trimesh(vertices, faces, visual=visual, process=False)
    file = tmp_path / "scan.glb"
    file.write_bytes(trimesh.exchange.gltf.export_glb(trimesh.Scene(mesh)))
    for name in ("scan.glb", "converted.obj"):
        if name == "converted.obj":
            command = ["mesh", "convert", str(file), "--out", str(tmp_path / name)]
            subprocess.run([sys.executable, "-m", "meshseg", *command], check=True)
        result = meshseg.segment(tmp_path / name, "texture", regions=2, lambda_=1e-4)
        left = result.labels[vertices[:, 0] < 3.5]
        right = result.labels[vertices[:, 0] > 4.5]
        assert len(set(left)) == len(set(right)) == 1 and left[0] != right[0]
        means = [region["mean"] for region in result.summary["region_parameters"]]
        assert np.allclose(sorted(np.rint(255 * np.array(means[left[0]]))), [10, 30, 200], atol=1)
