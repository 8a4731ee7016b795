#!/usr/bin/env python3
"""clsdf's Python package on a machine with an NVIDIA GPU: arrays that CUDA and OpenCL share, torch, CuPy and JAX.

usage: on_a_gpu.py [--steps NAME,NAME] [--resolution 256] [--repetitions 30]

One line for each thing that is tried, `ok` or `FAILED` with the reason, and times. A step is a process of its own: one
that crashes or hangs is FAILED, and the next one is tried. A step whose package is missing is left out, and the last
line says so. The status is 1 if a step FAILED, and 2 if the machine has no GPU that can be tried. Needs clsdf; torch,
CuPy and JAX for their steps.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

TORCH_STEPS = ("outputs", "points", "vertices", "streams", "times", "program")
STEPS = ("devices", "shared", "semaphores", *TORCH_STEPS, "cupy", "jax")
LEFT_OUT = 3

arguments = argparse.ArgumentParser()
arguments.add_argument("--steps", default=",".join(STEPS))
arguments.add_argument("--resolution", type=int, default=256)
arguments.add_argument("--repetitions", type=int, default=30)
arguments.add_argument("--child", default="")
options = arguments.parse_args()
failures: list[str] = []


def say(text):
    print(text, flush=True)


def check(what, good, detail=""):
    say(f"  {'ok' if good else 'FAILED'} {what}{': ' if detail else ''}{detail}")
    if not good:
        failures.append(what)


@contextlib.contextmanager
def trying(what):
    """A part of a step: a failure is told, and the step goes on."""
    try:
        yield
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        check(what, False, f"{type(error).__name__}: {error} [{os.path.basename(where.filename)}:{where.lineno}]")


def package(name):
    try:
        return __import__(name)
    except ImportError as error:
        say(f"  left out: {error}")
        sys.exit(LEFT_OUT)


def torch_on_gpu():
    torch = package("torch")
    if not torch.cuda.is_available():
        say("  left out: torch has no GPU of CUDA")
        sys.exit(LEFT_OUT)
    return torch


def timed(function):
    """The median of the times of a function, in ms."""
    for _ in range(3):
        function()
    times = []
    for _ in range(options.repetitions):
        begin = time.perf_counter()
        function()
        times.append((time.perf_counter() - begin) * 1e3)
    return sorted(times)[len(times) // 2]


def same(tensor, expected):
    """Whether a tensor has the bytes of a NumPy array."""
    import numpy as np

    values = tensor if isinstance(tensor, np.ndarray) else tensor.cpu().numpy()
    return values.shape == expected.shape and np.array_equal(values, expected, equal_nan=True)


def new_body():
    """A transform on a GPU, that of the process's first one."""
    import clsdf

    gpus = [info for info in clsdf.devices() if info.usable and info.kind == "gpu"]
    return clsdf.Transform(clsdf.make_shape("knot"), device=clsdf.Device.select(str(gpus[0].index)))


# ---- the steps ------------------------------------------------------------------------------------------------------


def devices():
    """What OpenCL and clsdf find."""
    import clsdf

    check("import clsdf opens no libcuda", "libcuda" not in Path("/proc/self/maps").read_text(), clsdf.__version__)
    gpus = [info for info in clsdf.devices() if info.kind == "gpu"]
    for info in gpus:
        check(f"{info.name}, {info.platform}, {info.version}, driver {info.driver}", info.usable, info.why_not)
    check("a GPU that clsdf can use", any(info.usable for info in gpus))


def shared():
    """SharedArray alone: fields, points and positions, without torch."""
    import numpy as np

    import clsdf

    body = new_body()
    expected = body.field(resolution=64, band="3v", outputs="distance triangle")
    arrays = {}
    with trying("SharedArray"):
        arrays = {name: clsdf.SharedArray(expected.grid.shape, expected[name].dtype, body.device) for name in expected.outputs}
        check("SharedArray", True, repr(arrays["distance"]))
    with trying("set and get"):
        arrays["distance"].set(expected.distance)
        check("set and get: the same bytes", same(arrays["distance"].get(), expected.distance))
    with trying("a field"):
        body.field(expected.grid, band=expected.band, out=arrays)
        for name in arrays:
            check(f"a field, {name}: the bytes of field()", same(arrays[name].get(), expected[name]))
    with trying("a plan"):
        plan = body.plan(expected.grid, band=expected.band)
        arrays["distance"].set(0)
        check("plan.enqueue returns None", plan.enqueue(out=arrays["distance"]) is None)
        check("a plan: the bytes of field()", same(arrays["distance"].get(), expected.distance))
    with trying("points"):
        points = np.random.default_rng(1).uniform(*body.box, (10_000, 3)).astype(np.float32)
        asked, distance = clsdf.SharedArray(points.shape, device=body.device), clsdf.SharedArray(len(points), device=body.device)
        asked.set(points)
        body.query(asked, out=distance)
        check("points: the bytes of query()", same(distance.get(), body.query(points).distance))
    with trying("positions"):
        positions = clsdf.SharedArray(body.vertices.shape, "float64", body.device)
        positions.set(body.vertices * 0.9)
        body.set_positions(positions)
        check("positions", same(body.vertices, positions.get()))
    with trying("many arrays"):
        before = len(os.listdir("/proc/self/fd"))
        for _ in range(200):
            clsdf.SharedArray(3, device=body.device)
        after = len(os.listdir("/proc/self/fd"))
        check("200 arrays leave no descriptor", after <= before, f"{before}, {after}")


def semaphores():
    """Whether the driver shares semaphores with CUDA. If not, plan.enqueue waits: slower, and as right."""
    import clsdf

    body = new_body()
    grid = body.grid(options.resolution, band="10%")
    plan, out = body.plan(grid, band="10%"), clsdf.SharedArray(grid.shape, device=body.device)
    expected = body.field(grid, band="10%").distance
    for _ in range(5):
        plan.enqueue(out=out)
    out.set(7)
    begin = time.perf_counter()
    plan.enqueue(out=out)
    returned = (time.perf_counter() - begin) * 1e3
    check("plan.enqueue: the bytes of field()", same(out.get(), expected), f"has_semaphores {body.device._has_semaphores()}, returned after {returned:.3f} ms")


def outputs():
    """torch's own tensors as out= of fields and plans."""
    torch, body = torch_on_gpu(), new_body()
    expected = body.field(resolution=64, band="3v", outputs="distance triangle gradient")
    shape = expected.grid.shape
    with trying("a field"):
        out = {"distance": torch.empty(shape, device="cuda"), "triangle": torch.empty(shape, dtype=torch.int32, device="cuda"),
               "gradient": torch.empty((*shape, 3), device="cuda")}
        body.field(expected.grid, band=expected.band, out=out)
        check("a field, distance", same(out["distance"], expected.distance))
        check("a field, gradient", same(out["gradient"], expected.gradient))
        check("a field, triangle", same(out["triangle"], expected.triangle.astype("int32")))
    with trying("a part of a tensor"):
        large = torch.full((*shape, 4), 7.0, device="cuda")
        body.field(expected.grid, band=expected.band, out={"distance": large[..., 3], "gradient": large[..., :3]})
        check("parts of one tensor", same(large[..., 3], expected.distance) and same(large[..., :3], expected.gradient))
    with trying("a plan"):
        plan = body.plan(expected.grid, band=expected.band)
        tensor = torch.empty(shape, device="cuda")
        for _ in range(20):
            tensor.fill_(7)
            plan.enqueue(out=tensor)
        check("20 runs of a plan, in torch's order", same(tensor, expected.distance))
    with trying("a view of a SharedArray"):
        import clsdf

        own = clsdf.SharedArray(shape, device=body.device)
        address = own.__cuda_array_interface__["data"][0]
        for name, view in (("__cuda_array_interface__", torch.as_tensor(own, device="cuda")), ("DLPack", torch.from_dlpack(own))):
            view.fill_(7)
            plan.enqueue(out=view)
            check(f"by {name}: the same memory", view.data_ptr() == address and same(view, expected.distance))
        del own
        view.fill_(1)
        check("the memory outlives the SharedArray", float(view.sum()) == view.numel())
    with trying("an output that requires a gradient"):
        try:
            body.field(expected.grid, out=torch.empty(shape, device="cuda", requires_grad=True))
            check("an output that requires a gradient is refused", False)
        except clsdf.Error as error:
            check("an output that requires a gradient is refused", "detach" in str(error), str(error))


def points():
    """torch's own tensors as points, and a gradient."""
    import numpy as np

    torch, body = torch_on_gpu(), new_body()
    on_host = np.random.default_rng(2).uniform(*body.box, (100_000, 3)).astype(np.float32)
    expected = body.query(on_host, "distance gradient")
    asked = torch.as_tensor(on_host, device="cuda").requires_grad_()
    out = {"distance": torch.empty(len(on_host), device="cuda"), "gradient": torch.empty(on_host.shape, device="cuda")}
    with trying("points"):
        body.query(asked, out=out)
        check("distance", same(out["distance"], expected.distance))
        check("gradient", same(out["gradient"], expected.gradient))
        check("results on the host", same(body.query(asked).distance, expected.distance))
        rows = torch.empty(100, 1000, device="cuda")
        body.query(asked.detach().reshape(100, 1000, 3), out=rows)
        check("points (100, 1000, 3)", same(rows, expected.distance.reshape(100, 1000)))


def vertices():
    """Vertices from torch: a mesh, and a body that torch moves for 20 steps."""
    torch, body = torch_on_gpu(), new_body()
    import clsdf

    rest = torch.as_tensor(body.vertices, device="cuda")
    with trying("a mesh"):
        made = clsdf.Transform(rest, torch.as_tensor(body.faces.astype("int64"), device="cuda"), device=body.device)
        check("a mesh of tensors", same(made.field(resolution=32).distance, body.field(resolution=32).distance))
    with trying("20 steps"):
        grid = body.grid(options.resolution, band="3v")
        plan, field = body.plan(grid, band="3v"), torch.empty(grid.shape, device="cuda")
        begin = time.perf_counter()
        for step in range(20):
            body.set_positions(rest * (1 - 0.005 * step))
            plan.update(body)
            plan.enqueue(out=field)
            volume = float((field < 0).sum()) * grid.voxel**3
        spent = (time.perf_counter() - begin) * 50
        check("20 steps", same(field, body.field(grid, band="3v").distance), f"{spent:.2f} ms a step, volume {volume:.5f}")


def streams():
    """Work on a stream of torch's that is not the default one."""
    torch, body = torch_on_gpu(), new_body()
    expected = body.field(resolution=64, band="3v")
    plan = body.plan(expected.grid, band=expected.band)
    stream = torch.cuda.Stream()
    with trying("a stream"), torch.cuda.stream(stream):
        out = torch.empty(expected.grid.shape, device="cuda")
        large = torch.rand(4096, 4096, device="cuda")
        for _ in range(10):
            for _ in range(5):
                large = large @ large / 4096  # the GPU is behind
            out.fill_(7)
            plan.enqueue(out=out)
            twice = out * 2
        check("a plan on a stream of its own", same(twice, expected.distance * 2))
        body.field(expected.grid, band=expected.band, out=out)
        check("a field on it", same(out, expected.distance))


def times():
    """A field into a torch tensor is to take at most 0.2 ms more than the plan alone."""
    torch, body = torch_on_gpu(), new_body()
    import clsdf

    for band in ("10%", "3v"):
        grid = body.grid(options.resolution, band=band)
        plan = body.plan(grid, band=band)
        tensor, own = torch.empty(grid.shape, device="cuda"), clsdf.SharedArray(grid.shape, device=body.device)
        view = torch.as_tensor(own, device="cuda")

        def run(out):
            plan.enqueue(out=out)
            torch.cuda.synchronize()

        with trying(f"times, {band}"):
            without_copy, with_copy = timed(lambda: run(view)), timed(lambda: run(tensor))
            check(f"{band}: into a tensor within 0.2 ms of the plan into shared memory", with_copy < without_copy + 0.2,
                  f"plan into shared memory {without_copy:.3f} ms, into a tensor {with_copy:.3f} ms")
            say(f"     {band}: field() into a tensor {timed(lambda: body.field(grid, band=band, out=tensor)):.3f} ms")
        with trying(f"times, {band}, pyopencl"):
            import pyopencl as cl
            import pyopencl.array

            queue = cl.CommandQueue.from_int_ptr(body.device.queue_int_ptr)
            plain = cl.array.empty(queue, grid.shape, "float32")
            alone = timed(lambda: plan.enqueue(out=plain, queue=queue).wait())
            check(f"{band}: into a tensor within 0.2 ms of the plan alone", with_copy < alone + 0.2,
                  f"plan alone {alone:.3f} ms")


def program():
    """The program of docs/python.md, if this file lies in a clone."""
    torch_on_gpu()
    page = Path(__file__).resolve().parents[2] / "docs" / "python.md"
    if not page.exists():
        say(f"  left out: there is no {page}")
        sys.exit(LEFT_OUT)
    text = page.read_text()
    section = text[text.index("## Memory that CUDA sees") :]
    source = re.search(r"^```python\n(.*?)^```$", section, re.M | re.S)[1]
    source = source.replace('clsdf.Transform("bunny.off")', 'clsdf.Transform(clsdf.make_shape("torus"))')
    with tempfile.TemporaryDirectory() as folder:
        result = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, cwd=folder)
    losses = [float(loss) for loss in re.findall(r"loss ([0-9.]+)", result.stdout)]
    good = result.returncode == 0 and len(losses) == 10 and losses[-1] < losses[0]
    check("the program of docs/python.md", good, (result.stderr or result.stdout).strip().splitlines()[-1])


def cupy():
    """Arrays of CuPy."""
    cupy, body = package("cupy"), new_body()
    import clsdf

    expected = body.field(resolution=64, band="3v")
    own = clsdf.SharedArray(expected.grid.shape, device=body.device)
    for name, array in (("a view of a SharedArray", cupy.asarray(own)), ("its own", cupy.zeros(expected.grid.shape, "float32"))):
        with trying(name):
            body.field(expected.grid, band=expected.band, out=array)
            check(name, same(array.get(), expected.distance))
    stream = cupy.cuda.Stream(non_blocking=True)
    with trying("a stream"), stream:
        array[...] = 7
        body.plan(expected.grid, band=expected.band).enqueue(out=array)
        check("a stream", same((array * 1).get(), expected.distance))


def jax():
    """Arrays of JAX: inputs alone."""
    os.environ["XLA_PYTHON_CLIENT_PREALLOCATE"] = "false"
    jax, body = package("jax"), new_body()
    import numpy as np

    import clsdf

    if jax.default_backend() != "gpu":
        say("  left out: JAX has no GPU")
        sys.exit(LEFT_OUT)
    on_host = np.random.default_rng(3).uniform(*body.box, (10_000, 3)).astype(np.float32)
    array = jax.numpy.asarray(on_host) * 1
    with trying("points"):
        check("points", same(body.query(array).distance, body.query(on_host).distance))
    with trying("an output"):
        try:
            body.query(on_host, out=jax.numpy.zeros(len(on_host)))
            check("an output is refused", False)
        except clsdf.Error as error:
            check("an output is refused", "never change" in str(error), str(error))
    with trying("from_dlpack"):
        own = clsdf.SharedArray(on_host.shape, device=body.device)
        own.set(on_host)
        check("from_dlpack of a SharedArray", same(np.asarray(jax.numpy.from_dlpack(own)), on_host))


# ---- running them ---------------------------------------------------------------------------------------------------


def child(name):
    import faulthandler

    faulthandler.enable()
    step = globals()[name]
    say(f"{name}: {step.__doc__}")
    with trying(name):
        step()
    sys.stdout.flush()
    os._exit(1 if failures else 0)  # no end of drivers' libraries can spoil the answer


def parent():
    """Runs each step in a process of its own. Returns the status."""
    try:
        import clsdf
    except ImportError as error:
        say(f"clsdf cannot be imported: {error}")
        return 2
    if not any(info.usable and info.kind == "gpu" for info in clsdf.devices()):
        found = "; ".join(f"{info.name} ({info.kind}) {info.why_not}".rstrip() for info in clsdf.devices()) or "none"
        say(f"This machine has no GPU that clsdf can use, so nothing is tried. Its OpenCL devices: {found}.")
        return 2
    failed, left_out = [], []
    for name in options.steps.split(","):
        command = [sys.executable, os.path.abspath(__file__), "--child", name, "--resolution", str(options.resolution),
                   "--repetitions", str(options.repetitions)]
        try:
            code = subprocess.run(command, timeout=240).returncode
        except subprocess.TimeoutExpired:
            code = "a hang of 240 s"
        if code == LEFT_OUT:
            left_out.append(name)
        elif code != 0:
            failed.append(name)
            if code != 1:
                say(f"  FAILED {name}: it ended with {code}")
    say(f"{'FAILED ' + ', '.join(failed) if failed else 'ok'}{'; left out: ' + ', '.join(left_out) if left_out else ''}")
    return 1 if failed else 0


if __name__ == "__main__":
    if options.child:
        child(options.child)
    sys.exit(parent())
