"""The program of docs/flow.md with lbmpy: a sphere's drag is that of experiments, by walls at their places on the links."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import clsdf

PROGRAM = Path(__file__).parents[3] / "integrations" / "lbmpy" / "drag_of_a_body.py"
REYNOLDS = 30
# Clift, Grace and Weber: Bubbles, Drops, and Particles, 1978, table 5.2, for Reynolds numbers of 20 to 260.
EXPERIMENTS = 24 / REYNOLDS * (1 + 0.1935 * REYNOLDS**0.6305)


def compiler(folder):
    """A folder with a g++ that takes this NumPy's headers: lbmpy's compiler finds those of Debian's python3-numpy first."""
    found = shutil.which("g++")
    if found is None:
        pytest.skip("there is no g++ for lbmpy")
    script = folder / "g++"
    script.write_text(f'#!/bin/sh\nexec {found} -I{np.get_include()} "$@"\n')
    script.chmod(0o755)
    return folder


def write_off(path, vertices, faces):
    with open(path, "w") as file:
        print(f"OFF\n{len(vertices)} {len(faces)} 0", file=file)
        np.savetxt(file, vertices, "%.17g")
        np.savetxt(file, np.insert(faces, 0, 3, axis=1), "%d")


@pytest.fixture(scope="module")
def drags(tmp_path_factory):
    """By the wall, of a sphere whose middle is a node, and of one whose middle is that of a voxel."""
    if importlib.util.find_spec("lbmpy") is None:
        pytest.skip("lbmpy is not installed")
    folder = tmp_path_factory.mktemp("drag")
    write_off(folder / "ball.off", *clsdf.make_shape("sphere5"))
    environment = {**os.environ, "PATH": f"{compiler(folder)}:{os.environ['PATH']}", "XDG_CACHE_HOME": str(folder)}
    drags = {"interpolated": [], "half-way": []}
    for shift in ("0", "0.5"):
        result = subprocess.run(
            [sys.executable, str(PROGRAM), "ball.off", "--reynolds", str(REYNOLDS), "--nodes", "6", "--width", "7",
             "--travel", "4", "--shift", shift],
            capture_output=True, text=True, cwd=folder, timeout=500, env=environment)
        assert result.returncode == 0, result.stderr
        for wall, drag in re.findall(r"^(interpolated|half-way) +([\d.]+)$", result.stdout, re.M):
            drags[wall].append(float(drag))
    return {wall: np.array(both) for wall, both in drags.items()}


def test_the_drag_of_a_sphere_is_that_of_experiments(drags):
    # The mean of both places: 6 nodes of diameter are few. The stream is 7 diameters wide, which adds about 3%.
    assert drags["interpolated"].shape == (2,)
    assert abs(drags["interpolated"].mean() / EXPERIMENTS - 1) < 0.05


def test_the_place_on_the_lattice_matters_less_than_half_way(drags):
    assert np.ptp(drags["interpolated"]) < 0.5 * np.ptp(drags["half-way"])
