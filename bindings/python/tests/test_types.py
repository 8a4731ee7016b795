"""The types of the package, held by mypy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import clsdf

pytest.importorskip("mypy")

SAMPLE = """
import numpy as np
import clsdf

body = clsdf.Transform("bunny.off", sign="auto")
field = body.field(resolution=64, band=("10%", 0.5), outputs="distance gradient")
reveal_type(field.distance)
reveal_type(field.grid.shape)
reveal_type(field.band.inside)
reveal_type(body.query(np.zeros((3, 3)), within=0.1).gradient)
reveal_type(clsdf.devices())
for slab in body.slabs(resolution=64):
    clsdf.write_field(slab, "slab.nrrd")
body.field(clsdf.Grid((0, 0, 0), 0.1, [1, 2, 3]))
body.query([[0, 0, 0], (0.5, 0.5, 0.5)], frame=(np.eye(3), (0, 0, 0)), out={"distance": np.empty(2)})
points: clsdf.typing.ArrayLike = np.zeros((5, 3), np.float32)
clsdf.Body(clsdf.make_shape("torus"), device=None).contains(points)
body.query("abc")
clsdf.Transform(3)
try:
    body.field(resolution="many")
except clsdf.Error as error:
    reveal_type(error.code)
"""


def mypy(*arguments, folder):
    return subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
    ).stdout.splitlines()


def test_a_program_has_the_types_of_the_package(tmp_path):
    (tmp_path / "sample.py").write_text(SAMPLE)
    said = mypy("sample.py", folder=tmp_path)
    revealed = [line.split("Revealed type is ")[1].strip('"') for line in said if "Revealed" in line]
    assert "floating" in revealed[0] and "floating" in revealed[3], said
    assert revealed[1:3] == ["tuple[int, int, int]", "float"], said
    assert "DeviceInfo" in revealed[4] and revealed[5] == "str"
    errors = [line for line in said if "error:" in line]
    wrong = ("query", "Transform", "resolution")
    assert len(errors) == 3 and all(name in error for name, error in zip(wrong, errors)), errors


def test_the_package_itself_is_typed(tmp_path):
    folder = Path(clsdf.__file__).parent
    assert (folder / "py.typed").exists() and (folder / "_core.pyi").exists()
    assert mypy("-p", "clsdf", folder=tmp_path) == []


def test_everything_public_is_documented():
    for name in clsdf.__all__:
        thing = getattr(clsdf, name)
        if name.startswith("no_"):
            continue
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if callable(value) and not member.startswith("_"):
                assert value.__doc__, f"{name}.{member}"
