"""Exceptions, warnings, signals, callbacks and threads."""

import copy
import multiprocessing
import os
import pickle
import signal
import threading
import time
import warnings

import numpy as np
import pytest

import meshseg


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"gap": -1}, "gap=-1"),
        ({"lambda_": -0.5}, "lambda = -0.5"),
        ({"costs": np.zeros((3, 3))}, "costs: has 3 rows, but the mesh has 1000 vertices"),
        ({"costs": np.zeros((1000, 1))}, "costs: 1 regions"),
        ({"costs": np.full((1000, 3), -np.inf)}, "costs: "),
        ({"costs": np.zeros((1000, 3, 1))}, "costs: has 3 axes"),
        ({"costs": np.array([["a"]])}, "costs: has the type"),
        ({"relaxation": "tightest"}, "invalid value 'tightest' for 'relaxation"),
        ({"solver": "newton"}, "newton"),
        ({"solver_options": {"rho": 7}}, "rho"),
        ({"init": np.zeros((1000, 3))}, "init: "),
        ({"seeds": np.full(1000, 9)}, "seeds: entry 0: region 9 is out of range"),
        ({"seeds": np.full(1000, 0.5)}, "seeds: must be integers"),
        ({"threads": 0}, "threads"),
    ],
)
def test_bad_input_is_a_sentence(torus, costs, keywords, message):
    with pytest.raises(ValueError, match=message) as error:
        meshseg.solve(torus, **({"costs": costs, "lambda_": 0.01} | keywords))
    assert "\n" not in str(error.value) and "--" not in str(error.value)
    with pytest.raises(TypeError, match="unexpected keyword"):
        meshseg.solve(torus, costs, 0.01, gaps=1)


def test_files_of_arrays(tmp_path, torus, costs):
    with pytest.raises(FileNotFoundError, match="S.npy"):
        meshseg.solve(torus, tmp_path / "S.npy", 0.01)
    np.save(tmp_path / "S.npy", costs)
    of_file = meshseg.solve(torus, tmp_path / "S.npy", 0.01)
    assert np.array_equal(of_file.u, meshseg.solve(torus, costs, 0.01).u)


def test_arrays_of_any_layout(torus, costs):
    expected = meshseg.solve(torus, costs.astype(np.float32), 0.01)
    narrow = costs.astype(np.float32)
    for array in (np.asfortranarray(narrow), narrow.tolist(), np.repeat(narrow, 2, axis=1)[:, ::2]):
        assert np.array_equal(meshseg.solve(torus, array, 0.01).u, expected.u)


def test_bytes_are_data_up_to_one():
    mesh = meshseg.read_mesh("sphere:3")
    data = (255 * (mesh.vertices[:, 2] > 0)).astype(np.uint8)
    result = meshseg.segment(mesh, data, regions=2)
    assert sorted(region["mean"] for region in result.regions) == [[0.0], [1.0]]
    assert result.status == "converged" and result.label_gap <= 1e-4


def test_warnings_have_a_class_and_are_kept(torus):
    with pytest.warns(meshseg.MeshsegWarning, match="nothing to segment"):
        result = meshseg.segment(torus, np.ones(1000), regions=2)
    assert len(result.warnings) > 0


def test_notes_and_advice_are_in_our_words():
    mesh = meshseg.read_mesh("sphere:4")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = meshseg.segment(mesh, np.sign(mesh.vertices[:, 0]), regions=2)
    assert any("scaled by" in note and "normalize=none" in note for note in result.notes)
    assert "lambda_=" in repr(result) and "--" not in repr(result)


def test_history(torus, costs):
    result = meshseg.solve(torus, costs, 0.05, gap=1e-6)
    frame = result.history.frame()
    assert list(frame.columns) == list(result.history)
    assert frame.iteration.is_monotonic_increasing and frame.dual_bound.is_monotonic_increasing
    assert frame.energy.is_monotonic_decreasing
    assert np.allclose(frame.energy - frame.dual_bound, frame.gap, atol=1e-12)


def test_a_callback_sees_samples_and_ends_the_run(torus, costs):
    seen = []

    def callback(iteration, seconds, energy, bound, gap):
        seen.append((iteration, gap))
        return iteration >= 12

    result = meshseg.solve(torus, costs, 0.05, gap=0, callback=callback)
    assert result.status == "interrupted" and seen[-1][0] >= 12 and seen[-2][0] < 12
    assert result.dual_bound <= result.energy
    # The start is a sample of the history.
    assert [0, *(iteration for iteration, _ in seen)] == result.history["iteration"].tolist()

    def faulty(*sample):
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        meshseg.solve(torus, costs, 0.05, gap=0, callback=faulty)

    def faulty_file(*sample):
        raise FileNotFoundError(2, "--gap 5", "here")

    with pytest.raises(FileNotFoundError) as error:
        meshseg.solve(torus, costs, 0.05, gap=0, callback=faulty_file)
    assert (error.value.errno, error.value.strerror) == (2, "--gap 5")


def test_a_callback_is_called_by_the_thread_that_calls(torus, costs):
    lock, threads = threading.RLock(), set()

    def callback(*sample):
        with lock:
            threads.add(threading.current_thread())
        # A call within a call.
        meshseg.solve(torus, costs, 0.01, max_iterations=2)

    with lock:
        meshseg.solve(torus, costs, 0.05, max_iterations=20, callback=callback)
    assert threads == {threading.current_thread()}


def test_ctrl_c_interrupts_a_callback(torus, costs):
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    begin = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        meshseg.solve(torus, costs, 0.05, callback=lambda *sample: time.sleep(60))
    assert time.monotonic() - begin < 30


@pytest.mark.parametrize(
    "keywords",
    [{"gap": False}, {"threads": True}, {"out": object()}, {"contours": 1}, {"relaxation": object()}],
)
def test_values_of_other_types(torus, costs, keywords):
    with pytest.raises(TypeError, match=next(iter(keywords))):
        meshseg.solve(torus, costs, 0.01, **keywords)


def test_labels_and_masks_are_not_guessed(torus, costs):
    with pytest.raises(ValueError, match="seeds: has truth values"):
        meshseg.solve(torus, costs, 0.01, seeds=costs[:, 0] > 0.5)
    with pytest.raises(ValueError, match="costs: is a masked array"):
        meshseg.solve(torus, np.ma.masked_greater(costs, 0.5), 0.01)
    with pytest.raises(TypeError, match="classes: must be"):
        meshseg.segment(torus, probabilities=costs, classes=[1, 2, 3])
    with pytest.raises(ValueError, match="^classes: has 2 classes, but there are 3"):
        meshseg.segment(torus, probabilities=costs, classes=["a", "b"])
    named = meshseg.segment(torus, probabilities=costs, classes={"a": "#ff0000", "b": "", "c": ""})
    assert [region["name"] for region in named.regions] == ["a", "b", "c"]
    assert named.regions[0]["palette"] == [1.0, 0.0, 0.0]


def test_a_u_off_the_simplex_is_told_of(torus, costs):
    u = meshseg.solve(torus, costs, 0.01).u
    with pytest.warns(meshseg.MeshsegWarning, match="simplex"):
        found = meshseg.evaluate(torus, costs, (0.9999 * u).astype(np.float32), 0.01)
    assert found["relative_gap"] is None


def test_weld_is_a_truth_value_everywhere(torus, costs):
    expected = meshseg.solve(torus, costs, 0.01)
    assert np.array_equal(meshseg.solve(torus, costs, 0.01, weld=False).u, expected.u)
    assert meshseg.evaluate(torus, costs, expected.u, 0.01, weld=False)["feasible"]


def test_names_of_files_are_left_alone(tmp_path, costs, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FileNotFoundError, match="^a--lambda 5.ply: "):
        meshseg.read_mesh("a--lambda 5.ply")
    (tmp_path / "-mesh.off").write_text("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    for mesh in ("-mesh.off", meshseg.read_mesh("-mesh.off")):
        assert meshseg.solve(mesh, costs[:3], 0.01).status == "converged"


def test_copies_of_a_mesh(tmp_path):
    file = tmp_path / "mesh.off"
    file.write_text("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    mesh = meshseg.read_mesh(file)
    file.unlink()
    for other in (copy.copy(mesh), copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))):
        assert np.array_equal(other.vertices, mesh.vertices)
        assert np.array_equal(other.faces, mesh.faces)


def test_ctrl_c_is_a_keyboard_interrupt():
    mesh = meshseg.read_mesh("torus:400x250")
    costs = np.random.default_rng(0).random((100_000, 8))
    timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    begin = time.monotonic()
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        # Lambda is so small that all regions stay: labels that are constant have a gap of 0 in less than a second.
        meshseg.solve(mesh, costs, 3e-4, gap=0)
    assert time.monotonic() - begin < 20
    # The next call is not affected.
    assert meshseg.solve(mesh, costs, 1e-3, gap=1e-2).status == "converged"


def test_other_threads_run_meanwhile(torus, costs):
    """Two solves in threads: the lock is released, and results are the same bits."""
    expected = meshseg.solve(torus, costs, 0.05, gap=1e-6)
    found, ticks = {}, []

    def solve(name):
        found[name] = meshseg.solve(torus, costs, 0.05, gap=1e-6)

    threads = [threading.Thread(target=solve, args=(name,)) for name in range(4)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        ticks.append(time.monotonic())
        time.sleep(0.001)
    assert len(ticks) > 0
    assert all(np.array_equal(found[name].u, expected.u) for name in range(4))


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.filterwarnings("ignore:.*fork.*")
def test_other_processes(torus, costs, method):
    expected = meshseg.solve(torus, costs, 0.01)
    meshes = [torus, meshseg.Mesh(torus.vertices, torus.faces), "torus:40x25"]
    with multiprocessing.get_context(method).Pool(2) as pool:
        found = pool.starmap_async(meshseg.solve, [(mesh, costs, 0.01) for mesh in meshes]).get(60)
    assert all(np.array_equal(result.u, expected.u) for result in found)


def test_pairs_weigh_differently(torus, costs):
    """The weights as an array: evaluate confirms the energy of the labels that solve finds; what is no metric is refused."""
    pairs = np.array([[0, 0.5, 2], [0.5, 0, 1.75], [2, 1.75, 0]])
    faces = np.random.default_rng(5).random((len(torus.faces), 3))
    result = meshseg.solve(torus, faces, 0.05, on="faces", pairs=pairs, gap=1e-6)
    assert result.summary["relaxation"] == "metric"
    assert np.array_equal(result.summary["label_metric"], pairs)
    u = np.eye(3)[result.face_labels]
    scores = meshseg.evaluate(torus, faces, u, 0.05, on="faces", pairs=pairs)
    assert scores["energy"] == pytest.approx(result.summary["rounded_energy"], rel=1e-12)
    with pytest.raises(ValueError, match="pairs: labels 0 and 2 have the weight 9.0, more than"):
        meshseg.solve(torus, costs, 0.05, pairs=np.array([[0, 1, 9], [1, 0, 1], [9, 1, 0]]))
