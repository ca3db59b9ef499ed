"""Results are those of the command line, bit by bit, and so are its words."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

import meshseg


def command(*arguments, **keywords):
    run = [sys.executable, "-m", "meshseg", *map(str, arguments)]
    return subprocess.run(run, capture_output=True, text=True, **keywords)


def written(folder):
    arrays = {file.stem: np.load(file) for file in folder.glob("*.npy")}
    return arrays, json.loads((folder / "summary.json").read_text())


def same_numbers(ours, theirs):
    """All but times, names of files that are in memory, and warnings, which have other words."""
    for key in {*ours, *theirs} - {"seconds", "rounding_seconds", "data", "coarse_to_fine", "warnings"}:
        assert ours.get(key) == theirs.get(key), key
    levels = [(found["coarse_to_fine"] or {}).get("levels", []) for found in (ours, theirs)]
    assert [level["iterations"] for level in levels[0]] == [level["iterations"] for level in levels[1]]


def test_solve(tmp_path, torus, costs):
    np.save(tmp_path / "S.npy", costs)
    out = tmp_path / "out"
    options = ["--lambda", "0.013", "--gap", "1e-7", "--save", "q", "--relaxation", "separate"]
    done = command("solve", "torus:40x25", "--costs", tmp_path / "S.npy", *options, "--out", out)
    assert done.returncode == 0, done.stderr
    arrays, summary = written(out)
    for mesh in (torus, "torus:40x25", (torus.vertices, torus.faces)):
        ours = meshseg.solve(
            mesh, costs, 0.013, gap=1e-7, save="q", relaxation="separate", threads=1
        )
        assert np.array_equal(ours.u, arrays["u"])
        assert np.array_equal(ours.q, arrays["q"])
        assert np.array_equal(ours.labels, arrays["labels"])
        same_numbers(ours.summary, summary)


@pytest.mark.parametrize(
    "options",
    [
        {"regions": 3},
        {"regions": 4, "model": "gaussian", "coarse_to_fine": True, "lambda_": 0.002},
        {"regions": "auto:2..4", "rounding": "moves"},
        {"model": "threshold", "thresholds": (0.3, 0.7)},
    ],
)
def test_segment(tmp_path, options):
    mesh = meshseg.read_mesh("sphere:4")
    values = np.random.default_rng(2).normal(np.round(2 * mesh.vertices[:, 2]) / 4 + 0.5, 0.1)
    np.save(tmp_path / "values.npy", values)
    words = []
    for keyword, value in options.items():
        name = "--" + keyword.rstrip("_").replace("_", "-")
        value = ",".join(map(str, value)) if isinstance(value, tuple) else value
        words += [name] if value is True else [name, value]
    out = tmp_path / "out"
    data = ["--data", tmp_path / "values.npy", "--no-preview"]
    done = command("segment", "sphere:4", *data, *words, "--out", out)
    assert done.returncode == 0, done.stderr
    arrays, summary = written(out)
    ours = meshseg.segment(mesh, values, **options)
    assert np.array_equal(ours.labels, arrays["labels"])
    assert np.array_equal(ours.u, arrays["u"])
    same_numbers(ours.summary, summary)
    # Our report has no folder and speaks of keywords.
    first = done.stdout.splitlines()[:5]
    assert repr(ours).splitlines()[:5] == first
    assert "written to" not in repr(ours) and "--" not in repr(ours)


@pytest.mark.parametrize("of", ["vertices", "faces"])
@pytest.mark.parametrize("on", ["vertices", "faces"])
def test_class_probabilities(tmp_path, of, on):
    mesh = meshseg.read_mesh("sphere:4")
    rng = np.random.default_rng(3)
    rows = len(getattr(mesh, of))
    votes = rng.multinomial(5, [0.5, 0.3, 0.2], rows)
    mask = rng.random(len(mesh.faces)) < 0.9
    seeds = np.full(len(mesh.faces), -1)
    seeds[np.flatnonzero(mask)[:3]] = 2
    for name, array in {"votes": votes, "mask": mask, "seeds": seeds}.items():
        np.save(tmp_path / f"{name}.npy", array)
    (tmp_path / "names.csv").write_text("name,color\nwall,#ff0000\nroof,#00ff00\ntree,#0000ff\n")
    files = ["--probabilities", tmp_path / "votes.npy", "--mask", tmp_path / "mask.npy"]
    files += ["--seeds", tmp_path / "seeds.npy", "--classes", tmp_path / "names.csv"]
    options = ["--on", on, "--edge-aware", "normals", "--min-area", "1%", "--no-preview"]
    out = tmp_path / "out"
    done = command("segment", "sphere:4", *files, *options, "--out", out)
    assert done.returncode == 0, done.stderr
    arrays, summary = written(out)
    ours = meshseg.segment(
        mesh,
        probabilities=votes,
        mask=mask,
        seeds=seeds,
        classes=[("wall", "#ff0000"), ("roof", "#00ff00"), ("tree", "#0000ff")],
        on=on,
        edge_aware="normals",
        min_area="1%",
    )
    assert np.array_equal(ours.labels, arrays["labels"])
    assert np.array_equal(ours.face_labels, arrays["face_labels"])
    assert np.array_equal(ours.u, arrays["u"], equal_nan=True)
    same_numbers(ours.summary, summary)
    assert (ours.face_labels == -1).sum() == (~mask).sum()
    assert [region["name"] for region in ours.regions] == ["wall", "roof", "tree"]


def test_a_folder_is_written_on_request(tmp_path, torus, costs):
    out = tmp_path / "out"
    ours = meshseg.solve(torus, costs, 0.01, out=out)
    arrays, summary = written(out)
    assert np.array_equal(ours.u, arrays["u"])
    assert (out / "preview.png").exists()
    assert f"written to     {out}" in repr(ours)
    same_numbers(ours.summary, summary)


def test_the_command_line_is_whole(tmp_path):
    assert command("--version").stdout == f"meshseg {meshseg.__version__}\n"
    assert "Usage: meshseg" in command("--help").stdout
    wrong = command("segment", "no.ply", "--regions", "3", "--out", tmp_path / "out")
    assert wrong.returncode == 1 and wrong.stderr.startswith("error: no.ply: ")
    assert command("segment").returncode == 2
    # A batch starts the program anew, which is Python with the package.
    (tmp_path / "list.csv").write_text("mesh,out\nbuiltin:spot,spot\n")
    batch = command("batch", "list.csv", "--", "--regions", "2", "--no-preview", cwd=tmp_path)
    assert batch.returncode == 0, batch.stderr
    assert (tmp_path / "spot" / "labels.npy").exists()


def test_ctrl_c_ends_the_command_line_with_results(tmp_path):
    import signal
    import time

    options = ["--data", "curvature", "--regions", "8", "--gap", "0", "--no-preview"]
    words = ["segment", "builtin:spot", *options, "--lambda", "0.02", "--out", tmp_path / "out"]
    run = [sys.executable, "-m", "meshseg", *map(str, words)]
    with subprocess.Popen(run, stderr=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        time.sleep(2.5)
        os.kill(process.pid, signal.SIGINT)
        process.communicate(timeout=30)
    assert process.returncode == 130
    assert (tmp_path / "out" / "labels.npy").exists()
