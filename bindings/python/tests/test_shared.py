"""Arrays in memory of CUDA, on stand-ins: PoCL disguised as a GPU, and a libcuda.so.1 whose memory the host cannot
access (tests/disguise). scripts/python-tests runs this file with them, with semaphores and without."""

from __future__ import annotations

import ctypes
import functools
import gc
import os
import subprocess
import sys
import threading
import time
import types
from pathlib import Path

import numpy as np
import pytest

import clsdf

pytestmark = pytest.mark.skipif("CLSDF_DISGUISE_EXTERNAL" not in os.environ, reason="needs the stand-ins of tests/disguise")
HOST_FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_void_p)


class Cuda:
    """The driver as torch uses it: the primary context of a device is set for good, in this thread alone."""

    def __init__(self):
        self.library = ctypes.CDLL("libcuda.so.1")
        self("cuInit", 0)
        self.functions = []

    def __call__(self, name, *values):
        code = getattr(self.library, name)(*values)
        assert code == 0, (name, code)

    def calls(self, name):
        return self.library.cuda_stand_in_calls(name.encode())

    def context(self, device=1):
        context = ctypes.c_void_p()
        self("cuDevicePrimaryCtxRetain", ctypes.byref(context), device)
        return context

    def stream(self):
        with Pushed():
            stream = ctypes.c_void_p()
            self("cuStreamCreate", ctypes.byref(stream), 1)
        return stream.value

    def later(self, stream, function, seconds=0.05):
        """Runs the function on the stream, some time after this call."""

        def run(_):
            time.sleep(seconds)
            function()

        self.functions.append(HOST_FUNCTION(run))
        with Pushed():
            self("cuLaunchHostFunc", ctypes.c_void_p(stream), self.functions[-1], None)


@functools.cache
def cuda():
    return Cuda()


@functools.cache
def primary(device=1):
    return cuda().context(device)


class Pushed:
    def __init__(self, device=1):
        self.device = device

    def __enter__(self):
        cuda()("cuCtxPushCurrent_v2", primary(self.device))

    def __exit__(self, *_):
        cuda()("cuCtxPopCurrent_v2", None)


class Tensor:
    """As of torch or CuPy: memory of cudaMalloc, which cannot be exported, used on one stream. `where` is a slice."""

    def __init__(self, values, stream=1, device=1, where=(), read_only=False):
        self.values = np.ascontiguousarray(values)
        self.device, self.stream = device, stream
        self.memory = ctypes.c_uint64()
        with Pushed(device):
            cuda()("cuMemAlloc_v2", ctypes.byref(self.memory), ctypes.c_size_t(max(self.values.nbytes, 1)))
        self.copy_up(self.values)
        view = self.values[where]
        offset = view.ctypes.data - self.values.ctypes.data
        self.__cuda_array_interface__ = {
            "shape": view.shape, "typestr": view.dtype.str, "data": (self.memory.value + offset, read_only),
            "strides": None if view.flags.c_contiguous else view.strides, "version": 3, "stream": stream,
        }

    def copy_up(self, values):
        values = np.ascontiguousarray(values)
        with Pushed(self.device):
            cuda()("cuMemcpyHtoDAsync_v2", self.memory, ctypes.c_void_p(values.ctypes.data),
                   ctypes.c_size_t(values.nbytes), ctypes.c_void_p(self.stream))

    def get(self):
        """All of the memory, in the order of the stream."""
        values = np.empty_like(self.values)
        with Pushed(self.device):
            cuda()("cuMemcpyDtoHAsync_v2", ctypes.c_void_p(values.ctypes.data), self.memory,
                   ctypes.c_size_t(values.nbytes), ctypes.c_void_p(self.stream))
        return values

    def free(self):
        with Pushed(self.device):
            cuda()("cuMemFree_v2", self.memory)


class OnlyDLPack:
    """An array that has DLPack alone."""

    def __init__(self, array):
        self._array, self.shape = array, array.shape
        self.streams = []

    def __dlpack__(self, **options):
        self.streams.append(options.get("stream"))
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()


@pytest.fixture(scope="module")
def expected(body):
    return body.field(resolution=20, outputs="distance triangle gradient")


@pytest.fixture(scope="module")
def found(body, points):
    return body.query(points, "distance gradient")


def descriptors():
    gc.collect()
    return len(os.listdir("/proc/self/fd"))


def test_the_device_is_the_disguised_one(body):
    assert body.device.info().kind == "gpu"


def test_a_field_is_written_into_a_shared_array_without_a_copy(body, expected):
    shared = clsdf.SharedArray(expected.grid.shape, device=body.device)
    copies = cuda().calls("cuMemcpyDtoDAsync_v2")
    field = body.field(expected.grid, band=expected.band, out=shared)
    assert field.distance is shared and np.array_equal(shared.get(), expected.distance)
    triangles = clsdf.SharedArray(expected.grid.shape, "uint32", device=body.device)
    body.field(expected.grid, band=expected.band, out={"distance": shared, "triangle": triangles})
    assert np.array_equal(triangles.get(), expected.triangle)
    assert cuda().calls("cuMemcpyDtoDAsync_v2") == copies
    assert repr(shared).startswith("<clsdf.SharedArray: shape (") and len(shared) == shared.shape[0]


def test_a_part_of_a_shared_array_is_one(body, expected):
    nz, ny, nx = expected.grid.shape
    shared = clsdf.SharedArray((2, nz, ny, nx), device=body.device)
    shared.set(7)

    class Part:
        __cuda_array_interface__ = dict(shared.__cuda_array_interface__, shape=(nz, ny, nx))

    address = shared.__cuda_array_interface__["data"][0]
    Part.__cuda_array_interface__["data"] = (address + expected.distance.nbytes, False)
    body.field(expected.grid, band=expected.band, out=Part())
    assert (shared.get()[0] == 7).all() and np.array_equal(shared.get()[1], expected.distance)


def test_a_field_is_written_into_tensors_by_one_copy_within_the_device(body, expected):
    tensor = Tensor(np.zeros_like(expected.distance))
    for copied in (1, 2):
        before = cuda().calls("cuMemcpyDtoDAsync_v2")
        made = cuda().calls("cuMemCreate")
        body.field(expected.grid, band=expected.band, out=tensor)
        assert cuda().calls("cuMemcpyDtoDAsync_v2") == before + 1
        assert copied == 1 or cuda().calls("cuMemCreate") == made, "the memory of the copy is kept"
    assert np.array_equal(tensor.get(), expected.distance)
    in_double = Tensor(np.zeros(expected.distance.shape))
    body.field(expected.grid, band=expected.band, out=in_double)
    assert np.allclose(in_double.get(), expected.distance, atol=1e-6)


def test_tensors_with_strides_and_parts_of_one_tensor(body, expected):
    nz, ny, nx = expected.grid.shape
    large = Tensor(np.full((nz + 1, ny + 2, nx + 3, 2), 7, np.float32), where=(slice(1, None), slice(1, -1), slice(2, -1), 1))
    body.field(expected.grid, band=expected.band, out=large)
    values = large.get()
    assert np.array_equal(values[1:, 1:-1, 2:-1, 1], expected.distance)
    values[1:, 1:-1, 2:-1, 1] = 7
    assert (values == 7).all()  # nothing beside it was written

    # The components of one tensor, side by side: distance and gradient.
    whole = Tensor(np.full((nz, ny, nx, 4), 7, np.float32))

    def part(where):
        view = Tensor.__new__(Tensor)
        own = whole.values[where]
        view.__cuda_array_interface__ = dict(
            whole.__cuda_array_interface__, shape=own.shape, strides=own.strides,
            data=(whole.memory.value + own.ctypes.data - whole.values.ctypes.data, False))
        return view

    out = {"distance": part((..., 3)), "gradient": part((..., slice(0, 3)))}
    body.field(expected.grid, band=expected.band, out=out)
    assert np.array_equal(whole.get()[..., 3], expected.distance)
    assert np.array_equal(whole.get()[..., :3], expected.gradient, equal_nan=True)
    with pytest.raises(clsdf.Error, match="lie on the same bytes"):
        body.field(expected.grid, band=expected.band, out={"distance": part((..., 2)), "gradient": part((..., slice(0, 3)))})


def test_points_of_every_kind(body, points, found):
    shared = clsdf.SharedArray(points.shape, "float64", device=body.device)
    shared.set(points)
    distance, gradient = Tensor(np.zeros(len(points), np.float32)), clsdf.SharedArray(points.shape, device=body.device)
    only_dlpack = OnlyDLPack(shared)
    for asked in (shared, Tensor(points), only_dlpack, Tensor(points[::-1], where=slice(None, None, -1))):
        distance.copy_up(np.zeros(len(points), np.float32))
        result = body.query(asked, out={"distance": distance, "gradient": gradient})
        assert np.array_equal(distance.get(), found.distance) and np.array_equal(gradient.get(), found.gradient)
        assert len(result) == len(points) and "500 points" in repr(result)
        assert np.array_equal(body.query(asked).distance, found.distance)  # results on the host
    assert only_dlpack.streams and set(only_dlpack.streams) == {1}
    blocks = Tensor(points.reshape(50, 10, 3))
    assert np.array_equal(body.query(blocks).distance, found.distance.reshape(50, 10))
    out = Tensor(np.zeros((50, 10), np.float32))
    body.query(blocks, out=out)
    assert np.array_equal(out.get(), found.distance.reshape(50, 10))
    assert body.query(Tensor(points[0])).distance == found.distance[0]
    assert np.array_equal(body.contains(Tensor(points)), found.distance < 0)
    turns = Tensor(np.zeros(len(points), np.float32))
    body.winding(Tensor(points), out=turns)
    assert np.array_equal(turns.get(), body.winding(points))
    assert body.query(Tensor(np.empty((0, 3)))).distance.shape == (0,)


def test_meshes_and_positions(solid, body, points, found):
    vertices, faces = solid
    made = clsdf.Transform(Tensor(vertices), Tensor(faces), device=body.device)
    assert np.array_equal(made.query(points).distance, found.distance)
    assert np.array_equal(made.vertices, vertices) and np.array_equal(made.faces, faces)
    moved = clsdf.Transform(vertices * 1.5, faces, device=body.device).query(points).distance
    shared = clsdf.SharedArray(vertices.shape, "float64", device=body.device)
    shared.set(vertices * 1.5)
    for positions in (shared, Tensor(vertices * 1.5)):
        made.set_positions(vertices)
        made.set_positions(positions)
        assert np.array_equal(made.query(points).distance, moved)
        assert np.array_equal(made.vertices, vertices * 1.5)


def test_calls_follow_the_stream_and_the_stream_follows_plans(body, points, found, expected):
    stream = cuda().stream()
    asked = Tensor(np.zeros_like(points), stream)
    cuda().later(stream, lambda: None)
    asked.copy_up(points)  # 50 ms later
    distance = Tensor(np.zeros(len(points), np.float32), stream)
    body.query(asked, out=distance)
    assert np.array_equal(distance.get(), found.distance)

    plan = body.plan(expected.grid, band=expected.band)
    other = cuda().stream()
    out, shared = Tensor(np.zeros_like(expected.distance), other), clsdf.SharedArray(expected.grid.shape, device=body.device)
    for target in (out, shared):
        cuda().later(other, lambda: None, 0.4)
        out.copy_up(np.full_like(expected.distance, 3))  # before the plan, which overwrites it
        begin = time.perf_counter()
        assert plan.enqueue(out=target) is None
        if target is out and os.environ["CLSDF_DISGUISE_EXTERNAL"] == "memory+semaphores":
            assert time.perf_counter() - begin < 0.35, "a plan does not wait"
        assert np.array_equal(target.get(), expected.distance)
    for _ in range(20):  # in a row, on several streams
        assert plan.enqueue(out=out) is None
        assert plan.enqueue(out=shared) is None
    assert np.array_equal(out.get(), expected.distance) and np.array_equal(shared.get(), expected.distance)


def test_a_plan_of_requests_keeps_its_arrays(body, solid, expected):
    tensor, shared = Tensor(np.zeros_like(expected.distance)), clsdf.SharedArray(expected.grid.shape, device=body.device)
    requests = [clsdf.Request(expected.grid, expected.band, {"distance": array}) for array in (tensor, shared)]
    moving = clsdf.Transform(solid, device=body.device)
    plan = moving.plan(requests)
    assert moving.plan_bytes(requests) == plan.device_bytes
    for factor in (1, 1.1):
        moving.set_positions(Tensor(solid[0] * factor))
        plan.update(moving)
        assert plan.enqueue() is None
        values = moving.field(expected.grid, band=expected.band).distance
        assert np.array_equal(tensor.get(), values) and np.array_equal(shared.get(), values)
    body.compute(requests)
    assert np.array_equal(tensor.get(), expected.distance) and np.array_equal(shared.get(), expected.distance)
    plan.update(moving, requests=requests[1:])
    plan.enqueue()
    assert np.array_equal(shared.get(), values) and np.array_equal(tensor.get(), expected.distance)


def test_the_memory_lives_as_long_as_its_last_user(body, points, found):
    asked = clsdf.SharedArray(points.shape, "float64", device=body.device)
    asked.set(points)
    capsule = OnlyDLPack(asked)
    capsule._array = asked.__dlpack__()

    class Rest:
        """The capsule alone, without its array."""

        shape = points.shape

        def __dlpack__(self, **_):
            return capsule._array

        def __dlpack_device__(self):
            return 2, 1

    del asked
    gc.collect()
    assert np.array_equal(body.query(Rest()).distance, found.distance)
    device = clsdf.Device.select(body.device.name)
    shared = clsdf.SharedArray(5, "int32", device=device)
    shared.set([1, 2, 3, 4, 5])
    del device
    gc.collect()
    assert shared.get().tolist() == [1, 2, 3, 4, 5]
    assert clsdf.SharedArray((0, 3), device=body.device).get().shape == (0, 3)


def test_an_array_of_another_context_is_copied(body, points, found):
    other = clsdf.Device.select(body.device.name)
    asked = clsdf.SharedArray(points.shape, "float64", device=other)
    asked.set(points)
    copies = cuda().calls("cuMemcpyDtoDAsync_v2")
    assert np.array_equal(body.query(asked).distance, found.distance)
    assert cuda().calls("cuMemcpyDtoDAsync_v2") == copies + 1


def test_ten_thousand_arrays_leave_no_descriptor(body):
    clsdf.SharedArray(3, device=body.device)
    before = descriptors()
    for _ in range(10_000):
        clsdf.SharedArray(3, device=body.device)
    assert descriptors() == before


def test_the_context_is_pushed_and_never_set(body, expected):
    def use():
        body.field(expected.grid, band=expected.band, out=clsdf.SharedArray(expected.grid.shape, device=body.device))
        current = ctypes.c_void_p(1)
        cuda()("cuCtxGetCurrent", ctypes.byref(current))
        assert current.value is None
        done.append(True)

    done = []
    use()
    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert len(done) == 2
    owners = cuda().library.cuda_stand_in_owners(1)
    device = clsdf.Device.select(body.device.name)
    shared = clsdf.SharedArray(3, device=device)
    assert cuda().library.cuda_stand_in_owners(1) == owners + 1
    del device, shared
    gc.collect()
    assert cuda().library.cuda_stand_in_owners(1) == owners


def test_threads_share_arrays(body, points, found, expected):
    asked = clsdf.SharedArray(points.shape, "float64", device=body.device)
    asked.set(points)
    plan = body.plan(expected.grid, band=expected.band)
    failures = []

    def work(number):
        try:
            stream = cuda().stream()
            distance, field = Tensor(np.zeros(len(points), np.float32), stream), Tensor(np.zeros_like(expected.distance), stream)
            for _ in range(10):
                body.query(asked if number % 2 else Tensor(points, stream), out=distance)
                plan.enqueue(out=field)
                assert np.array_equal(distance.get(), found.distance) and np.array_equal(field.get(), expected.distance)
        except BaseException as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures, failures


def test_a_callback_may_use_the_array_of_its_call(solid, body, points, found):
    many = np.tile(points, (400, 1))
    asked = clsdf.SharedArray(many.shape, "float64", device=body.device)
    asked.set(many)
    inner = []
    outer, other = (clsdf.Transform(solid, device=body.device) for _ in range(2))
    copies = cuda().calls("cuMemcpyDtoDAsync_v2")
    result = outer.query(asked, progress=lambda *_: inner or inner.append(other.query(asked).distance))
    assert inner, "the callback was called"
    for distance in (result.distance, inner[0]):
        assert np.array_equal(distance, np.tile(found.distance, 400))
    assert cuda().calls("cuMemcpyDtoDAsync_v2") == copies


def test_an_array_belongs_to_a_run_until_its_stream_waits_for_the_run(body, expected):
    shared = clsdf.SharedArray(expected.grid.shape, device=body.device)
    plan = body.plan(expected.grid, band=expected.band)
    plan.enqueue(out=shared)
    records = cuda().calls("cuEventRecord")
    cuda().library.cuda_stand_in_delay(b"cuEventRecord", records + 1)  # after the run, when its arrays are handed back
    first = threading.Thread(target=lambda: plan.enqueue(out=shared))
    first.start()
    while cuda().calls("cuEventRecord") == records:
        time.sleep(0.001)
    body.field(expected.grid, band=expected.band, out=shared)
    first.join(0.3)
    assert not first.is_alive(), "the second call waits for the first one"
    assert np.array_equal(shared.get(), expected.distance)


def test_a_plan_gets_other_requests_while_a_thread_waits_for_it(solid, body, expected):
    own = clsdf.Transform(solid, device=clsdf.Device.select(body.device.name))  # whose programs are not built
    old = clsdf.SharedArray(expected.grid.shape, device=own.device)
    new = {"distance": clsdf.SharedArray(expected.grid.shape, device=own.device),
           "gradient": clsdf.SharedArray((*expected.grid.shape, 3), device=own.device)}
    old.set(7)
    before, after = (clsdf.Request(expected.grid, expected.band, out) for out in ({"distance": old}, new))
    plan, failures = own.plan([before]), []

    def run():
        try:
            plan.enqueue()
        except BaseException as error:
            failures.append(error)

    waiting = threading.Thread(target=run)

    def start(*_):
        if waiting.ident is None:
            waiting.start()
            time.sleep(0.3)

    plan.update(own, requests=[after], progress=start)
    assert waiting.ident is not None, "the callback was called"
    waiting.join()
    assert not failures, failures
    assert (old.get() == 7).all()
    for name, array in new.items():
        assert np.array_equal(array.get(), expected[name], equal_nan=True)


def test_a_plan_of_requests_follows_the_present_streams(body, expected):
    tensor = Tensor(np.zeros_like(expected.distance))
    plan = body.plan([clsdf.Request(expected.grid, expected.band, {"distance": tensor})])
    plan.enqueue()
    assert np.array_equal(tensor.get(), expected.distance)
    tensor.stream = tensor.__cuda_array_interface__["stream"] = cuda().stream()
    cuda().later(tensor.stream, lambda: None)
    tensor.copy_up(np.full_like(expected.distance, 3))  # before the run, which overwrites it
    plan.enqueue()
    assert np.array_equal(tensor.get(), expected.distance)


def test_tensors_of_subclasses_are_those_of_torch(body, points, found, monkeypatch):
    stream = cuda().stream()

    class TorchTensor(Tensor):
        """A tensor of torch: it does not name its stream."""

        def __init__(self, values):
            super().__init__(values, stream)
            del self.__cuda_array_interface__["stream"]

        def detach(self):
            return self

    class OwnTensor(TorchTensor):
        """A class of another package, as MONAI's MetaTensor."""

    current = types.SimpleNamespace(current_stream=lambda device: types.SimpleNamespace(cuda_stream=stream))
    monkeypatch.setitem(sys.modules, "torch", types.SimpleNamespace(Tensor=TorchTensor, cuda=current))
    asked = OwnTensor(np.zeros_like(points))
    cuda().later(stream, lambda: None)
    asked.copy_up(points)  # 50 ms later
    assert np.array_equal(body.query(asked).distance, found.distance)


@pytest.mark.parametrize("call", ["cuMemcpyDtoDAsync_v2", "cuSignalExternalSemaphoresAsync", "cuWaitExternalSemaphoresAsync",
                                  "cuEventRecord", "cuStreamSynchronize"])
def test_a_run_after_a_call_of_cuda_that_failed(solid, body, monkeypatch, call):
    before = body.field(resolution=100)
    larger = clsdf.Transform((solid[0] * 1.1, solid[1]), device=body.device)
    expected = larger.field(before.grid, band=before.band)
    plan, failing = (transform.plan(before.grid, band=before.band) for transform in (larger, body))
    tensor = Tensor(np.zeros_like(expected.distance))
    calls = cuda().calls(call)
    plan.enqueue(out=tensor)
    if cuda().calls(call) == calls:
        pytest.skip("a run does not call it here")
    for _ in range(2):
        monkeypatch.setenv("CLSDF_CUDA_FAULT", f"{call}:{cuda().calls(call) + 1}")
        with pytest.raises(clsdf.Error, match=call.removesuffix("_v2")):
            failing.enqueue(out=tensor)
        plan.enqueue(out=tensor)
        assert np.array_equal(tensor.get(), expected.distance)


def test_memory_is_given_back(body, expected):
    body.field(expected.grid, band=expected.band, out=Tensor(np.zeros_like(expected.distance)))
    assert body.device.release_memory() >= 2 << 20
    body.field(expected.grid, band=expected.band, out=Tensor(np.zeros_like(expected.distance)))


class Constant(Tensor):
    """As of JAX, whose arrays never change."""

    __module__ = "jaxlib._jax"
    waits = 0

    def block_until_ready(self):
        Constant.waits += 1


def test_arrays_of_jax_are_inputs_alone(body, points, found):
    assert np.array_equal(body.query(Constant(points)).distance, found.distance) and Constant.waits
    with pytest.raises(clsdf.Error, match="array of jax, and these never change"):
        body.query(points, out=Constant(np.zeros(len(points), np.float32)))


def test_arrays_that_cannot_be(body, points, expected):
    with pytest.raises(clsdf.Error, match="points lies on device 0 of CUDA, and clsdf computes on device 1"):
        body.query(Tensor(points, device=0))
    freed = Tensor(points)
    freed.free()
    with pytest.raises(clsdf.Error, match="an address that CUDA's driver does not know"):
        body.query(freed)
    with pytest.raises(clsdf.Error, match="read-only"):
        body.query(points, out=Tensor(np.zeros(len(points), np.float32), read_only=True))
    with pytest.raises(clsdf.Error, match="elements of type"):
        body.query(Tensor(points.astype(np.float16)))
    with pytest.raises(clsdf.Error, match=r"shape \(500, 2\); expected"):
        body.query(Tensor(points[:, :2]))
    with pytest.raises(clsdf.Error, match="shape"):
        body.field(expected.grid, out=clsdf.SharedArray((3, 3, 3), device=body.device))
    with pytest.raises(clsdf.Error, match="take them into the frame there"):
        body.query(Tensor(points), frame=np.eye(4))
    with pytest.raises(clsdf.Error, match="negate them there"):
        body.query(points, out=Tensor(np.zeros(len(points), np.float32)), positive_inside=True)
    with pytest.raises(clsdf.Error, match="memory of CUDA, and this function reads the host's"):
        clsdf.mesh_hash((Tensor(points), Tensor(np.zeros((1, 3), np.int32))))

    class Gradient(Tensor):
        requires_grad = True

    with pytest.raises(clsdf.Error, match=r"requires a gradient.*tensor.detach\(\)"):
        body.query(points, out=Gradient(np.zeros(len(points), np.float32)))
    for wrong in ({"shape": (2, -1)}, {"shape": "two"}, {"shape": 3, "dtype": "float16"}, {"shape": 3, "dtype": "nothing"}):
        with pytest.raises(clsdf.Error, match="SharedArray"):
            clsdf.SharedArray(**wrong, device=body.device)
    shared = clsdf.SharedArray(3, device=body.device)
    with pytest.raises(BufferError):
        shared.__dlpack__(dl_device=(1, 0))
    with pytest.raises(BufferError):
        shared.__dlpack__(copy=True)


def test_a_call_that_fails_gives_the_memory_back(body, expected):
    shared = clsdf.SharedArray(expected.grid.shape, device=body.device)

    def refuse(*_):
        raise RuntimeError("no")

    fresh = clsdf.Transform((body.vertices, body.faces), device=clsdf.Device.select(body.device.name))
    own = clsdf.SharedArray(expected.grid.shape, device=fresh.device)
    with pytest.raises(RuntimeError, match="no"):
        fresh.field(expected.grid, band=expected.band, out=own, progress=refuse)
    fresh.field(expected.grid, band=expected.band, out=own)
    assert np.array_equal(own.get(), expected.distance)
    body.field(expected.grid, band=expected.band, out=shared)
    plan = body.plan([clsdf.Request(expected.grid, expected.band, {"distance": shared})])
    for _ in range(2):
        with pytest.raises(clsdf.Error, match="the queue belongs to another context"):
            plan.enqueue(queue=types.SimpleNamespace(int_ptr=fresh.device.queue_int_ptr))  # of another context
        plan.enqueue()
        assert np.array_equal(shared.get(), expected.distance)


# The state that each of the driver's calls leaves when it fails, and the message in a process without a driver.

PROGRAM = """
import gc, os, sys
import numpy as np
import clsdf
def count():
    gc.collect()
    return len(os.listdir("/proc/self/fd"))
device = clsdf.Device.automatic()
try:
    clsdf.SharedArray(3, device=device)
    print("made")
except clsdf.Error as error:
    print(error.code, "-", error)
before = count()
for _ in range(3):
    try:
        clsdf.SharedArray(3, device=device)
    except clsdf.Error:
        pass
print(count() - before)
"""


def run(program, **settings):
    environment = {name: value for name, value in {**os.environ, **settings}.items() if value is not None}
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment, timeout=200)
    assert result.returncode == 0, result.stderr
    return result.stdout.splitlines()


def test_errors_name_the_driver_the_device_and_the_remedy():
    assert run(PROGRAM)[0] == "made"
    without = ":".join(part for part in os.environ["LD_LIBRARY_PATH"].split(":") if not part.endswith("/cuda"))
    said = run(PROGRAM, LD_LIBRARY_PATH=without)[0]
    if os.path.exists("/usr/lib/x86_64-linux-gnu/libcuda.so.1"):
        pytest.skip("this machine has a driver of CUDA")
    assert said.startswith("no_device - an array in memory of CUDA is used, and libcuda.so.1") and "install the driver" in said
    said = run(PROGRAM, CLSDF_CUDA_DEVICES="0")[0]
    assert "no_device" in said and "cuInit: CUDA_ERROR_NO_DEVICE (100)" in said
    said = run(PROGRAM, CLSDF_CUDA_DEVICES="1")[0]
    assert "no_device" in said and "636c7364-662d-6469-7367-756973652d31" in said and "CUDA_VISIBLE_DEVICES" in said
    said = run(PROGRAM, CLSDF_DISGUISE_EXTERNAL=None)[0]
    assert "unsupported" in said and "has no cl_khr_" in said and "copy of the array" in said


@pytest.mark.parametrize("call", ["cuMemGetAllocationGranularity", "cuMemCreate", "cuMemAddressReserve", "cuMemMap",
                                  "cuMemSetAccess", "cuMemExportToShareableHandle", "cuDevicePrimaryCtxRetain",
                                  "cuDeviceGetUuid_v2"])
def test_a_call_of_cuda_that_fails(call):
    said, leaked = run(PROGRAM, CLSDF_CUDA_FAULT=f"{call}:1")
    assert said.startswith("device_failure") and call.removesuffix("_v2") in said and "CUDA_ERROR_UNKNOWN (999)" in said
    assert leaked == "0"


def test_a_buffer_that_opencl_refuses_leaves_no_descriptor():
    said, leaked = run(PROGRAM, CLSDF_DISGUISE_FAULT="clCreateBufferWithProperties:1+", CLSDF_DISGUISE_CODE="-30")
    assert said.startswith("invalid_argument") and "does not take the descriptor" in said and leaked == "0"


RUNS = """
import numpy as np, clsdf
body = clsdf.Transform(clsdf.make_shape("sphere1"))
points = np.random.default_rng(1).uniform(-1, 1, (20_000, 3))
distance = body.query(points).distance
asked = clsdf.SharedArray(points.shape, "float64", device=clsdf.Device.select(body.device.name))  # copied
asked.set(points)
body.query(asked)
expected = body.field(resolution=64)
shared = clsdf.SharedArray(expected.grid.shape, device=clsdf.Device.select(body.device.name))  # copied
plan = body.plan(expected.grid, band=expected.band)
failed = 0
for _ in range(6):
    try:
        plan.enqueue(out=shared)
    except clsdf.Error as error:
        failed += 1
        print(error)
    assert np.array_equal(body.query(asked).distance, distance)
shared.set(3)
plan.enqueue(out=shared)
assert np.array_equal(shared.get(), expected.distance)
print(failed, body.device._has_semaphores())
"""


@pytest.mark.parametrize("call", ["clEnqueueAcquireExternalMemObjectsKHR", "clEnqueueReleaseExternalMemObjectsKHR",
                                  "clEnqueueWaitSemaphoresKHR", "clEnqueueSignalSemaphoresKHR"])
def test_a_run_after_a_call_of_opencl_that_failed(call):
    is_of_semaphores = "Semaphores" in call
    if is_of_semaphores and os.environ["CLSDF_DISGUISE_EXTERNAL"] == "memory":
        pytest.skip("no semaphores here")
    # The first call is that of the query before the runs, or that of the test of semaphores.
    said = run(RUNS, CLSDF_DISGUISE_FAULT=f"{call}:2")
    assert call in said[0] and said[1].startswith("1 "), said


UNSHARED = """
import gc, numpy as np, clsdf
body = clsdf.Transform(clsdf.make_shape("sphere1"))
expected = body.field(resolution=20)
shared = clsdf.SharedArray(expected.grid.shape, device=body.device)
body.plan(expected.grid, band=expected.band).enqueue(out=shared)
assert np.array_equal(shared.get(), expected.distance) and not body.device._has_semaphores()
del shared
gc.collect()
body.device.release_memory()
print("freed")
"""


def test_semaphores_whose_signals_do_not_arrive_hold_nothing_up():
    assert run(UNSHARED, CLSDF_DISGUISE_EXTERNAL="memory+unshared-semaphores") == ["freed"]


ON_A_GPU = Path(__file__).parents[3] / "tests" / "python" / "on_a_gpu.py"


def test_the_program_for_machines_with_a_gpu():
    command = [sys.executable, str(ON_A_GPU), "--resolution", "32", "--steps", "devices,shared,semaphores"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=200)
    assert result.returncode == 0 and "FAILED" not in result.stdout, result.stdout + result.stderr
    assert result.stdout.count("  ok ") > 10 and result.stdout.splitlines()[-1] == "ok"
    is_shared = os.environ["CLSDF_DISGUISE_EXTERNAL"] == "memory+semaphores"
    assert f"has_semaphores {is_shared}" in result.stdout
    result = subprocess.run(command, capture_output=True, text=True, timeout=200, env={**os.environ, "CLSDF_CUDA_DEVICES": "1"})
    assert result.returncode == 1 and "FAILED SharedArray" in result.stdout
    result = subprocess.run(command, capture_output=True, text=True, timeout=200, env={**os.environ, "CLSDF_DISGUISE": ""})
    if "no GPU that clsdf can use" not in result.stdout:
        pytest.skip("this machine has a GPU")
    assert result.returncode == 2 and "nothing is tried" in result.stdout


IMPORTS = """
import clsdf, numpy
def is_open():
    return "libcuda" in open("/proc/self/maps").read()
assert not is_open()
body = clsdf.Transform(clsdf.make_shape("cube"))
body.field(resolution=8)
body.query(numpy.zeros((3, 3)))
assert not is_open()
clsdf.SharedArray(3, device=body.device)
assert is_open()
print("as promised")
"""


def test_the_driver_of_cuda_is_opened_by_the_first_array_of_it():
    assert run(IMPORTS) == ["as promised"]
