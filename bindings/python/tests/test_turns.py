"""Processes that use a device for the first time compile one after the other."""

from __future__ import annotations

import contextlib
import fcntl
import importlib
import os
import signal
import subprocess
import sys
import time

import pytest

import clsdf

turns = importlib.import_module("clsdf._turns")

HOLDER = """
import os, sys, time
from clsdf import _turns
with _turns.taken(False, "device", str(os.getpid())) as watch:
    watch("compiling", 0)
    print("held", flush=True)
    time.sleep(float(sys.argv[1]))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("CLSDF_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(turns, "_known", set())
    monkeypatch.setattr(turns, "_said", set())
    monkeypatch.setattr(turns, "_silence", 0.05)
    monkeypatch.setattr(turns, "longest_wait", 20.0)
    return tmp_path


@contextlib.contextmanager
def held(seconds):
    """Another process that compiles."""
    with subprocess.Popen([sys.executable, "-c", HOLDER, str(seconds)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        yield process
        process.kill()


def compile_once(kind="points", progress=None):
    """The seconds that a call waited."""
    with turns.taken(progress, "device", kind) as watch:
        began = time.monotonic()
        if watch is not None:
            watch("compiling", 0)
        return time.monotonic() - began


def test_a_process_waits_for_one_that_compiles_and_says_so(folder, capfd):
    with held(0.5):
        waited = compile_once()
    assert 0.2 < waited < 15
    said = capfd.readouterr().err
    assert "clsdf: waiting for another process that compiles programs for device" in said
    assert (folder / "compiling.lock").exists() and len(list(folder.glob("*.called"))) == 2
    # The next one finds what was made, in this process and in others.
    with held(100):
        assert compile_once() < 0.2
        turns._known.clear()
        assert compile_once() < 0.2
        # Another kind waits, but not for ever.
        turns.longest_wait = 0.3
        assert 0.25 < compile_once("field") < 10
    assert len(list(folder.glob("*.called"))) == 2 + 1


def test_a_lock_ends_with_its_process(folder):
    with held(100) as process:
        process.send_signal(signal.SIGKILL)
        process.wait()
        assert compile_once() < 5


def test_threads_of_a_process_do_not_wait_for_each_other(folder):
    with turns.taken(False, "device", "one") as watch:
        watch("compiling", 0)
        assert compile_once("two") < 0.2
    assert compile_once("three") < 0.2


def test_a_call_that_fails_gives_its_turn_back(folder):
    with pytest.raises(ZeroDivisionError):
        with turns.taken(False, "device", "one") as watch:
            watch("compiling", 0)
            raise ZeroDivisionError
    assert not list(folder.glob("*.called"))
    with open(folder / "compiling.lock") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


@pytest.mark.parametrize("progress", [None, False])
def test_a_long_compilation_is_told_unless_it_is_not_wanted(folder, capfd, progress):
    with turns.taken(progress, "device", "one") as watch:
        watch("compiling", 0)
        time.sleep(0.3)
    said = capfd.readouterr().err
    assert said == "" if progress is False else "compiling programs for device, once on this machine" in said
    with turns.taken(progress, "device", "two") as watch:
        watch("computing", 0)
        time.sleep(0.1)
    assert capfd.readouterr().err == "" and len(list(folder.glob("*.called"))) == 1


def test_without_a_folder_nothing_is_locked(folder, monkeypatch):
    monkeypatch.setenv("CLSDF_CACHE_DIR", "")
    assert compile_once() < 0.2 and not list(folder.iterdir())
    # Not a folder, and one in which no file can be made.
    (folder / "file").touch()
    for name in (str(folder / "file"), "/proc/self"):
        monkeypatch.setenv("CLSDF_CACHE_DIR", name)
        assert compile_once(name) < 0.2


def test_calls_of_a_transform_take_turns(solid, points, tmp_path):
    """Two processes at once, with an empty folder."""
    program = (
        "import clsdf, numpy as np\n"
        "body = clsdf.Transform(clsdf.make_shape('sphere1'))\n"
        "print(body.query(np.zeros((200, 3)), progress=False).distance[0] < 0)\n"
        "print(body.field(resolution=16, progress=False).distance.min() < 0)\n"
    )
    environment = {**os.environ, "CLSDF_CACHE_DIR": str(tmp_path)}
    both = [subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                             env=environment) for _ in range(2)]
    for process in both:
        out, err = process.communicate(timeout=200)
        assert (out, err) == ("True\nTrue\n", ""), err
    assert len(list(tmp_path.glob("*.called"))) == 2 and (tmp_path / "compiling.lock").exists()
    assert clsdf.Transform(solid).query(points, progress=False).distance.shape == (500,)
