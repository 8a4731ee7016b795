"""The program of docs/flow.md: a stream past a body, from a file .stl."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import clsdf

PROGRAM = Path(__file__).parents[3] / "integrations" / "peclet" / "flow_past_a_body.py"
# Runs the program, and keeps its arrays.
RUN = f"""
import runpy, sys
import numpy as np
program = runpy.run_path({str(PROGRAM)!r}, run_name="__main__")
solver = program["solver"]
np.savez("flow.npz", sdf=program["sdf"], u=solver.get_u(), v=solver.get_v(), w=solver.get_w(),
         centres=np.stack(np.meshgrid(*solver.cell_centers(), indexing="ij"), -1))
"""
RADIUS, CENTRE = 3.0, np.array((10.0, -20.0, 5.0))


def write_stl(path, vertices, faces):
    triangles = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles["corners"] = vertices[faces]
    path.write_bytes(bytes(80) + np.uint32(len(faces)).tobytes() + triangles.tobytes())


@pytest.fixture(scope="module")
def flow(tmp_path_factory):
    for package in ("peclet", "matplotlib"):
        if importlib.util.find_spec(package) is None:
            pytest.skip(f"{package} is not installed")
    folder = tmp_path_factory.mktemp("flow")
    vertices, faces = clsdf.make_shape("sphere4")
    write_stl(folder / "ball.stl", RADIUS * vertices + CENTRE, faces)
    result = subprocess.run(
        [sys.executable, "-c", RUN, "ball.stl", "--cells", "16", "--lengths", "4", "--picture", "ball.png"],
        capture_output=True, text=True, cwd=folder, timeout=200,
        env={**os.environ, "OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg"})
    assert result.returncode == 0, result.stderr
    assert (folder / "ball.png").read_bytes().startswith(b"\x89PNG")
    with np.load(folder / "flow.npz") as arrays:
        return dict(arrays)


def test_the_solver_has_the_distance_at_the_centres_of_its_cells(flow):
    expected = np.linalg.norm(flow["centres"] - CENTRE, axis=-1) - RADIUS
    assert flow["sdf"].shape == (32, 16, 16)
    assert np.allclose(flow["sdf"], expected, atol=0.01 * RADIUS)


def test_the_body_is_at_rest_and_nothing_is_lost(flow):
    for axis, name in enumerate("uvw"):
        behind = np.moveaxis(flow["sdf"], axis, 0)
        on_faces = (behind[1:] + behind[:-1]) / 2  # between the cells before and behind
        velocity = np.moveaxis(flow[name], axis, 0)[1:]
        assert (on_faces < 0).any() and (velocity[on_faces < 0] == 0).all(), name
    through = flow["u"].mean((1, 2))
    assert np.allclose((through[0], through[-1]), 1, atol=1e-6)


def test_the_stream_parts_before_the_body_and_leaves_a_wake(flow):
    x = flow["centres"][:, 0, 0, 0] - CENTRE[0]
    faces = x - (x[1] - x[0]) / 2  # where u lies
    along = flow["u"][:, 7:9, 7:9].mean((1, 2))
    before, behind, far = (np.interp(at * RADIUS, faces, along) for at in (-1.5, 1.5, 5))
    assert abs(before - (1 - 1.5**-3)) < 0.05  # as without viscosity
    assert behind < -0.1 and 0.1 < far < 0.7  # the stream turns back behind the body, up to about 1.4 diameters
    turns = (faces > RADIUS) & (along < 0)
    assert 1.2 < faces[turns].max() / (2 * RADIUS) < 1.6
    beside = flow["u"][abs(x).argmin()]
    assert 1.1 < beside[:, 0].mean() < 1.5
    assert np.allclose(flow["u"], flow["u"][:, ::-1], atol=0.01)  # a ball's wake at this Reynolds number is steady
