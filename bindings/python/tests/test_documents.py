"""The programs of Python in docs/ run as they stand, and their lists name what there is."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import clsdf

DOCS = Path(__file__).parents[3] / "docs"
PAGE = DOCS / "python.md"


def programs_of(page):
    """The title and the text of each program of a page."""
    title = "the first"
    for heading, program in re.findall(r"^## (.*?)$|^```python\n(.*?)^```$", page.read_text(), re.M | re.S):
        title = heading or title
        if program:
            yield title, program


def packages_of(program):
    names = re.findall(r"^import (\w+)", program, re.M)
    return [name for name in dict.fromkeys(names) if name not in ("clsdf", "numpy")]


def programs():
    names = ("learning", "segments", "rays", "scenes", "recipes", "fractions")
    for page in (PAGE, *(DOCS / f"{name}.md" for name in names)):
        for title, program in programs_of(page):
            name = "-".join([page.stem, *packages_of(program), *title.lower().replace(",", "").split()])
            yield pytest.param(program, id=name)


@pytest.fixture(scope="module")
def bunny(tmp_path_factory):
    """A folder with a mesh of the name that the page uses."""
    folder = tmp_path_factory.mktemp("page")
    vertices, faces = clsdf.make_shape("sphere4")
    vertices = vertices * (0.9, 0.8, 0.7)
    with open(folder / "bunny.off", "w") as file:
        print(f"OFF\n{len(vertices)} {len(faces)} 0", file=file)
        np.savetxt(file, vertices, "%.17g")
        np.savetxt(file, np.insert(faces, 0, 3, axis=1), "%d")
    return folder


def run(program, folder):
    (folder / "program.py").write_text(program)
    return subprocess.run([sys.executable, "program.py"], capture_output=True, text=True, cwd=folder, timeout=200)


@pytest.mark.parametrize("program", list(programs()))
def test_a_program_of_the_page_runs(program, bunny):
    for package in packages_of(program):
        module = pytest.importorskip(package)
        if package == "torch" and 'device="cuda"' in program and not module.cuda.is_available():
            pytest.skip("torch has no GPU of CUDA")
    result = run(program, bunny)
    assert result.returncode == 0, result.stderr


def test_the_cells_of_the_notebook_show_pictures(bunny, monkeypatch):
    monkeypatch.chdir(bunny)
    names, shown = {}, []
    program = next(text for title, text in programs_of(PAGE) if title == "In a notebook")
    for cell in program.split("# %%\n")[1:]:
        *statements, last = ast.parse(cell).body
        exec(compile(ast.Module(statements, []), "cell", "exec"), names)
        shown.append(eval(compile(ast.Expression(last.value), "cell", "eval"), names))
    body, *pictures = shown
    assert repr(body).startswith("<clsdf.Transform: bunny.off")
    assert len(pictures) == 2 and all(picture._repr_png_().startswith(b"\x89PNG") for picture in pictures)
    assert Path("slice.png").read_bytes() == pictures[1].png()


def test_a_forked_worker_of_torch_is_told_the_remedy(bunny):
    pytest.importorskip("torch")
    program = next(text for title, text in programs_of(DOCS / "learning.md") if title == "Samples for training")
    result = run(program.replace('="spawn"', '="fork"'), bunny)
    assert result.returncode != 0 and "this process was forked" in result.stderr and '"spawn"' in result.stderr


def test_any_number_of_ranks_computes_the_same(bunny):
    pytest.importorskip("mpi4py")
    if shutil.which("mpirun") is None:
        pytest.skip("there is no mpirun")
    program = next(text for _, text in programs_of(PAGE) if "mpi4py" in text)
    # As root, and with more ranks than cores, for Open MPI 4 and 5.
    settings = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                "OMPI_MCA_rmaps_base_oversubscribe": "1", "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe"}
    counts = set()
    for ranks in (1, 3):
        result = subprocess.run(["mpirun", "-n", str(ranks), sys.executable, "-c", program], capture_output=True,
                                text=True, cwd=bunny, timeout=200, env={**os.environ, **settings})
        assert result.returncode == 0, result.stderr
        # mpirun may put two ranks' text into one line.
        lines = re.findall(r"rank \d: .*? samples; (\d+) of all are inside", result.stdout)
        assert len(lines) == ranks and int(lines[0]) > 10_000, result.stdout
        counts.update(lines)
    assert len(counts) == 1


def test_the_page_names_everything_public():
    text = PAGE.read_text()
    for name in clsdf.__all__:
        assert re.search(rf"\b{name}\b", text), name
    reference = text[text.index("## Reference") :]
    for kind in (clsdf.Transform, clsdf.Field, clsdf.Grid, clsdf.Plan):
        for member in vars(kind):
            if not member.startswith("_") and member not in ("origin", "spacing", "size", "first"):
                assert re.search(rf"\b{member}\b", reference), f"{kind.__name__}.{member}"
