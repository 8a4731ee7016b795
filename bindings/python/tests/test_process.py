"""Threads, signals, forks, warnings, progress, references: what a process and its interpreter may expect."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import textwrap
import threading
import time
import weakref
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import clsdf


def run(program, timeout=100, environment=None):
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=timeout, env=environment,
        cwd=os.sep,
    )


@pytest.mark.parametrize(
    "module, file", [("cmake", "lib/cmake/clsdf/clsdfConfig.cmake"), ("pkgconfig", "clsdf.pc")]
)
def test_folders_for_compilers(module, file):
    """A wheel has an installation for other languages; a package that is built from a clone says that it has none."""
    printed = subprocess.run([sys.executable, "-m", f"clsdf.{module}"], capture_output=True, text=True, cwd=os.sep)
    if (Path(clsdf.__file__).parent / "lib").exists():
        assert printed.returncode == 0 and (Path(printed.stdout.rstrip("\n")) / file).is_file()
    else:
        assert printed.returncode == 1 and printed.stdout == "" and "scripts/wheel has them" in printed.stderr


def test_the_module_is_the_command_if_the_package_has_it():
    printed = subprocess.run([sys.executable, "-m", "clsdf", "--version"], capture_output=True, text=True, cwd=os.sep)
    if (Path(clsdf.__file__).parent / "bin" / "clsdf").exists():
        assert printed.returncode == 0 and clsdf.__version__ in printed.stdout
    else:
        assert printed.returncode == 1 and "scripts/wheel makes has one" in printed.stderr


def test_threads_get_the_same_bytes(body, points):
    field = body.field(resolution=24)
    expected = body.query(points).distance

    def work(n):
        if n % 2:
            return np.array_equal(body.query(points).distance, expected)
        return np.array_equal(body.field(field.grid, band=field.band).distance, field.distance)

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(work, range(100)))


def test_positions_wait_for_calls():
    vertices, faces = clsdf.make_shape("sphere5")
    body = clsdf.Transform((vertices, faces))
    grid = body.grid(60)
    points = np.random.default_rng(2).uniform(-1.2, 1.2, (50, 3))  # so few that the calling thread answers

    def results():
        field = body.field(grid, band="3v", outputs="triangle").triangle.tobytes()
        return field, body.query(points).distance.tobytes()

    fields, queries = [], []
    for scale in (1.0, 1.25):
        body.set_positions(vertices * scale)
        field, query = results()
        fields.append(field)
        queries.append(query)
    assert fields[0] != fields[1] and queries[0] != queries[1]
    end = time.monotonic() + 0.8

    def move():
        scale = 1.0
        while time.monotonic() < end:
            scale = 2.25 - scale
            body.set_positions(vertices * scale)

    def read():
        while time.monotonic() < end:
            if any(body.query(points).distance.tobytes() not in queries for _ in range(100)):
                return False
            field, query = results()
            if field not in fields or query not in queries:
                return False
        return True

    with ThreadPoolExecutor(4) as pool:
        readers = [pool.submit(read) for _ in range(3)]
        pool.submit(move).result()
        assert all(reader.result() for reader in readers)


def test_other_threads_run_during_a_call(body):
    grid = body.grid(200)
    body.field(grid, band="full")
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    ticker = threading.Thread(target=tick)
    ticker.start()
    began = time.perf_counter()
    while time.perf_counter() - began < 1:
        body.field(grid, band="full", outputs="distance gradient closest")
    ended = time.perf_counter()
    stop.set()
    ticker.join()
    # A call lasts a good part of a second; with the GIL held there would be one tick a call.
    assert sum(began < t < ended for t in ticks) > 100


def test_progress_is_told(body):
    told = []
    body.field(resolution=150, band="full", progress=lambda stage, part: told.append((stage, part)))
    assert told and {stage for stage, _ in told} <= {"compiling", "testing", "computing"}
    parts = [part for stage, part in told if stage == "computing"]
    assert parts == sorted(parts) and parts[-1] == pytest.approx(1)


@pytest.mark.parametrize("with_tqdm", [False, True])
def test_progress_true_shows_itself(body, capfd, monkeypatch, with_tqdm):
    if with_tqdm:
        pytest.importorskip("tqdm")
    else:
        monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    body.field(resolution=150, band="full", progress=True)
    shown = capfd.readouterr().err
    assert "computing" in shown and ("|" in shown) == with_tqdm


def test_an_exception_of_progress_ends_the_call(body):
    with pytest.raises(ZeroDivisionError):
        body.field(resolution=150, progress=lambda stage, part: 1 / 0)
    assert body.field(resolution=16).distance.any()


def test_a_callback_may_not_use_its_transform(body, solid, points):
    other = clsdf.Transform(solid)
    other.query(points[:5])
    with pytest.raises(clsdf.Error, match="progress="):
        body.field(resolution=150, progress=lambda stage, part: body.query(points))
    with pytest.raises(clsdf.Error, match="progress="):
        body.field(resolution=150, progress=lambda stage, part: body.set_motion(np.eye(3), (0, 0, 0)))


def test_a_callback_that_uses_another_transform_of_the_device_does_not_wait_for_its_own_call():
    program = """
import clsdf
mesh = clsdf.make_shape("sphere1")
for wanted in ("compiling", "testing"):
    device = clsdf.Device.automatic()
    body, other = clsdf.Transform(mesh, device=device), clsdf.Transform(mesh, device=device)
    try:
        body.field(resolution=16, progress=lambda stage, part: stage == wanted and other.field(resolution=16))
    except clsdf.Error as error:
        print(error.code, "a transform of the call's device" in str(error))
    stages = set()
    body.field(resolution=16, progress=lambda stage, part: stages.add(stage))
    print(*sorted(stages))
"""
    result = run(program, environment={**os.environ, "CLSDF_CACHE_DIR": ""})
    lines = ["invalid_argument True", "compiling computing testing"] * 2
    assert result.stdout.splitlines() == lines, result.stdout + result.stderr


DEVICES = {
    "automatic": "None",
    "index": "clsdf.Device.automatic().info().index",
    "name": "clsdf.Device.automatic().name",
    "share": "clsdf.Device.of_rank(0, 1)",
}


@pytest.mark.parametrize("choice", DEVICES)
def test_records_are_kept_for_every_device(choice, tmp_path):
    program = f"""
import clsdf
clsdf.Transform(clsdf.make_shape("sphere1"), device={DEVICES[choice]}).field(resolution=16)
"""
    result = run(program, environment={**os.environ, "CLSDF_CACHE_DIR": str(tmp_path)})
    assert result.returncode == 0, result.stderr
    assert list(tmp_path.rglob("*.tested"))


def test_an_open_mesh_warns_on_the_callers_line(solid):
    vertices, faces = solid
    with pytest.warns(clsdf.MeshWarning, match="not closed") as warned:
        body = clsdf.Transform((vertices, faces[:1]))
    assert warned[0].filename == __file__
    assert body.sign == "none" and (body.field(resolution=12).distance >= 0).all()
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(clsdf.MeshWarning):
            clsdf.Transform((vertices, faces[1:]))
        clsdf.Transform((vertices, faces[1:]), sign="none")
    with pytest.raises(clsdf.Error, match="edge") as error:
        clsdf.Transform((vertices, faces[1:]), sign="nonzero")
    assert error.value.code == "invalid_mesh"


def test_errors_have_codes_and_survive_pickling():
    import pickle

    error = pickle.loads(pickle.dumps(clsdf.Error("text", "out_of_memory", -4)))
    assert (str(error), error.code, error.opencl_code) == ("text", "out_of_memory", -4)
    assert issubclass(clsdf.Error, RuntimeError)


def references(array):
    gc.collect()
    return sys.getrefcount(array)


def test_nothing_keeps_arrays_after_a_call(solid, points):
    vertices, faces = solid[0].copy(), solid[1].copy()
    out = {"distance": np.empty(len(points), np.float32), "gradient": np.empty((len(points), 3), np.float32)}
    arrays = [vertices, faces, points, *out.values()]
    before = [references(array) for array in arrays]
    body = clsdf.Transform((vertices, faces))
    for _ in range(10):
        body.query(points, out=out)
        body.set_positions(vertices)
        with pytest.raises(clsdf.Error):
            body.query(points, out=out["gradient"])
    assert [references(array) for array in arrays] == before


def test_transforms_and_fields_are_released(solid):
    body = clsdf.Transform(solid)
    field = body.field(resolution=16)
    ends = [weakref.ref(body), weakref.ref(field), weakref.ref(field.distance)]
    told = []

    def progress(stage, part):
        told.append(part)

    body.field(resolution=16, progress=progress)
    ends.append(weakref.ref(progress))
    del body, field, progress
    gc.collect()
    assert [end() for end in ends] == [None] * len(ends)


def test_memory_does_not_grow(body, points):
    import resource

    def work():
        for _ in range(100):
            body.query(points, "distance gradient closest")
        field = body.field(resolution=64, band="full", outputs="distance closest")
        with pytest.raises(clsdf.Error):
            body.field(field.grid, out=field.distance[1:])

    for _ in range(5):
        work()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(30):
        work()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 30_000  # KiB; a field has 8 MiB


# Calls that take several seconds.
INTERRUPTED = """
    import os, signal, threading, time
    import numpy as np
    import clsdf
    body = clsdf.Transform(clsdf.make_shape("sphere6"))
    grids = [clsdf.Grid((-1, -1, -1), 2 / 70 + n * 1e-4, (70, 70, 70)) for n in range(400)]
    random = np.random.default_rng(1)
    corners = random.uniform(-1, 1, (3_000_000, 1, 3)) + [[[0, 0, 0], [0.02, 0.02, 0.02]]]
    body.fields(grids[:2], band="full")
    def press():
        global pressed
        time.sleep(0.5)
        pressed = time.monotonic()
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=press).start()
    began = time.monotonic()
    try:
        CALL
        print("finished", time.monotonic() - began)
    except KeyboardInterrupt:
        print("interrupted", time.monotonic() - pressed)
    print(body.query([[0, 0, 0]]).distance[0] < 0)
"""


@pytest.mark.parametrize("call", ['body.fields(grids, band="full")', "body.classify(corners, 0.05)", "body.sample(20_000_000, 0.01)"])
def test_ctrl_c_ends_a_call(call):
    result = run(INTERRUPTED.replace("CALL", call))
    assert result.returncode == 0, result.stderr
    outcome, seconds, usable = result.stdout.split()
    assert outcome == "interrupted" and float(seconds) < 1 and usable == "True", result.stdout


FORKED = """
    import os, sys
    import clsdf
    body = clsdf.Transform(clsdf.make_shape("sphere1"))
    body.query([[0, 0, 0]])
    child = os.fork()
    if child == 0:
        calls = [lambda: body.query([[0, 0, 0]]), lambda: body.field(resolution=8), lambda: clsdf.devices(),
                 lambda: clsdf.Transform(clsdf.make_shape("sphere1")), lambda: body.device.name]
        codes = []
        for call in calls:
            try:
                call()
            except clsdf.Error as error:
                codes.append(error.code)
                assert "forked" in str(error)
        del body
        print(codes == ["device_failure"] * len(calls), flush=True)
        # OpenVDB's logger waits for its threads at the end of a process, also in a fork, which has none.
        with open("/proc/self/maps") as maps:
            has_logger = "log4cplus" in maps.read()
        os._exit(3) if has_logger else sys.exit(3)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), body.query([[0, 0, 0]]).distance[0] < 0)
"""


def test_a_forked_process_gets_an_error():
    result = run(FORKED)
    assert result.stdout.splitlines() == ["True", "3 True"], result.stderr


def test_a_child_of_a_process_that_only_imported_works():
    result = run(
        """
        import os
        import clsdf
        child = os.fork()
        if child == 0:
            body = clsdf.Transform(clsdf.make_shape("sphere1"))
            os._exit(0 if body.query([[0, 0, 0]]).distance[0] < 0 else 1)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
        """
    )
    assert result.stdout.split() == ["0"], result.stderr


def test_spawned_processes_work(tmp_path):
    program = tmp_path / "spawned.py"
    program.write_text(
        textwrap.dedent(
            """
            import multiprocessing
            import clsdf
            def work(n):
                return float(clsdf.Transform(clsdf.make_shape("sphere1")).query([[0, 0, n]]).distance[0])
            if __name__ == "__main__":
                work(0)
                with multiprocessing.get_context("spawn").Pool(2) as pool:
                    print(*[value < 0 for value in pool.map(work, [0, 9])])
            """
        )
    )
    result = subprocess.run([sys.executable, program], capture_output=True, text=True, timeout=200)
    assert result.stdout.split() == ["True", "False"], result.stderr


def test_the_end_of_a_process_is_silent():
    result = run(
        """
        import clsdf
        body = clsdf.Transform(clsdf.make_shape("sphere1"))
        field = body.field(resolution=8, band="full")
        cycle = [body, field]
        cycle.append(cycle)
        """
    )
    assert (result.returncode, result.stderr) == (0, "")


def test_import_needs_no_device_and_a_transform_one_or_the_wheels_own_driver():
    expected = "computes" if (Path(clsdf.__file__).parent / "driver").exists() else "no_device"
    environment = {**os.environ, "OCL_ICD_VENDORS": "/nonexistent", "CLSDF_DEVICE": ""}
    program = """
import clsdf
try:
    clsdf.Transform(clsdf.make_shape("sphere1")).field(resolution=16)
    print("computes")
except clsdf.Error as error:
    print(error.code)
"""
    result = run(program, environment=environment)
    assert result.stdout.split() == [expected], result.stderr


def test_a_gpu_that_is_not_used_is_told_once_unless_a_device_is_named(tmp_path):
    (tmp_path / "kfd").touch()
    (tmp_path / "nvidia0").touch()
    program = """
import os
import warnings
import clsdf
clsdf._core._read_environment()
infos = clsdf.devices()
if os.environ.get("OCL_ICD_VENDORS") or any(info.usable and info.kind == "gpu" for info in infos):
    print("skipped")
    raise SystemExit
print(*[info.driver_file for info in infos if info.source == "device_file"])
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    clsdf.Device.select(0)
    print(len(caught))
    clsdf.Device.automatic()
    print(len(caught), *sorted({one.category.__name__ for one in caught}))
    clsdf.Device.of_rank(0, 1)
    clsdf.Transform(clsdf.make_shape("sphere1")).query([[0, 0, 0]])
    print(len(caught), "NVIDIA_DRIVER_CAPABILITIES" in str(caught[0].message) if caught else "")
"""
    environment = {**os.environ, "CLSDF_DEVICE_FILES": str(tmp_path), "CLSDF_DEVICE": ""}
    result = run(program, environment=environment)
    if result.stdout.strip() == "skipped":
        pytest.skip("there is a GPU that can be used, or OCL_ICD_VENDORS is set")
    files = f"{tmp_path / 'nvidia0'} {tmp_path / 'kfd'}"
    assert result.stdout.splitlines() == [files, "0", "1 RuntimeWarning", "1 True"], result.stdout + result.stderr
    named = run(program, environment={**environment, "CLSDF_DEVICE": "0"})
    assert named.stdout.splitlines() == [files, "0", "0", "0 "], named.stdout + named.stderr


def test_import_is_light():
    """Neither the packages that are used if they are there, nor modules that take long, are imported with clsdf."""
    program = """
import sys
import numpy.typing
heavy = {"torch", "jax", "pyopencl", "tqdm", "pyvista", "trimesh", "inspect", "pathlib"} - set(sys.modules)
import clsdf
print(sorted(heavy & set(sys.modules)), hasattr(clsdf, "what"))
"""
    result = run(program)
    assert result.stdout.split() == ["[]", "False"], result.stdout + result.stderr
