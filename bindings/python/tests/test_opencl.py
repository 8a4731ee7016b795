"""Memory, queues and events of pyopencl."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

import clsdf

cl = pytest.importorskip("pyopencl")
import pyopencl.array  # noqa: E402


@pytest.fixture(scope="module")
def queue():
    name = clsdf.Device.automatic().name
    for platform in cl.get_platforms():
        for device in platform.get_devices():
            if device.name == name:
                return cl.CommandQueue(cl.Context([device]))
    pytest.skip(f"pyopencl has no device {name}")


@pytest.fixture(scope="module")
def there(solid, queue):
    return clsdf.Transform(solid, device=queue)


def test_a_device_is_the_queues(there, queue):
    assert there.device.name == queue.device.name
    assert there.device.queue_int_ptr == queue.int_ptr and there.device.context_int_ptr == queue.context.int_ptr
    assert clsdf.Device.from_queue(queue).name == queue.device.name


def test_a_plan_writes_into_arrays_of_the_device(there, body, queue):
    expected = body.field(resolution=24, outputs="distance triangle")
    plan = there.plan(expected.grid, band=expected.band, outputs="distance triangle")
    shape = expected.grid.shape
    out = {"distance": cl.array.zeros(queue, shape, np.float32), "triangle": cl.array.zeros(queue, shape, np.uint32)}
    event = plan.enqueue(out=out, queue=queue)
    assert isinstance(event, cl.Event)
    event.wait()
    assert np.array_equal(out["distance"].get(), expected.distance)
    assert np.array_equal(out["triangle"].get(), expected.triangle)
    assert plan.sign == "nonzero" and plan.device_bytes > 0


def test_a_plan_writes_into_a_buffer(there, body, queue):
    expected = body.field(resolution=24)
    buffer = cl.Buffer(queue.context, cl.mem_flags.READ_WRITE, expected.distance.nbytes)
    event = there.plan(expected.grid, band=expected.band).enqueue(out=buffer)
    values = np.empty_like(expected.distance)
    cl.enqueue_copy(queue, values, buffer, wait_for=[event]).wait()
    assert np.array_equal(values, expected.distance)
    small = cl.Buffer(queue.context, cl.mem_flags.READ_WRITE, 100)
    with pytest.raises(clsdf.Error, match="100"):
        there.field(expected.grid, out=small)


def test_a_plan_waits_for_events(there, body, queue):
    expected = body.field(resolution=24)
    plan = there.plan(expected.grid, band=expected.band)
    out = cl.array.zeros(queue, expected.grid.shape, np.float32)
    gate = cl.UserEvent(queue.context)
    other = cl.CommandQueue(queue.context)
    event = plan.enqueue(out=out, queue=other, wait_for=[gate])
    assert event.command_execution_status != cl.command_execution_status.COMPLETE
    assert not out.get(queue).any()
    gate.set_status(cl.command_execution_status.COMPLETE)
    event.wait()
    assert np.array_equal(out.get(queue), expected.distance)


def test_events_of_a_generator_live_as_long_as_the_call(there, queue, points):
    living = weakref.WeakSet()

    class Event:
        def __init__(self):
            self.event = cl.enqueue_marker(queue)
            self.int_ptr = self.event.int_ptr
            living.add(self)

    told = []
    there.field(resolution=16, wait_for=(Event() for _ in range(3)), progress=lambda *_: told.append(len(living)))
    assert told and set(told) == {3}
    gc.collect()
    assert not living


def test_a_plan_of_requests_follows_the_body(solid, there, body, queue):
    grid = body.grid(16)
    large = cl.array.zeros(queue, (2, *grid.shape), np.float32)
    band = clsdf.Band(0.2, 0.2)
    moving = clsdf.Transform(solid, device=queue)
    requests = [clsdf.Request(grid, band, {"distance": large[n]}) for n in range(2)]
    plan = moving.plan(requests)
    assert moving.plan_bytes(requests) == plan.device_bytes
    plan.enqueue().wait()
    expected = body.field(grid, band=band).distance
    assert np.array_equal(large.get(), [expected, expected])
    moving.set_motion(np.eye(3), (0.1, 0, 0))
    plan.update(moving)
    plan.enqueue().wait()
    assert np.array_equal(large[1].get(), moving.field(grid, band=band).distance)
    assert not np.array_equal(large[1].get(), expected)
    shifted = clsdf.Grid(np.add(grid.origin, 0.05), grid.spacing, grid.size)
    plan.update(moving, grids=[shifted, grid])
    plan.enqueue().wait()
    assert np.array_equal(large[0].get(), moving.field(shifted, band=band).distance)
    plan.update(moving, requests=[clsdf.Request(grid, band, {"distance": large[0]})])
    plan.enqueue().wait()
    assert np.array_equal(large[0].get(), moving.field(grid, band=band).distance)


def test_a_plan_of_points_stays_on_the_device(solid, body, queue, points):
    moving = clsdf.Transform(solid, device=queue)
    points = np.vstack([points, [[np.nan, 0, 0]]])
    # Points and distances as a program has them: the fields of a particle.
    particles = np.zeros((len(points), 4))
    particles[:, :3] = points
    there = cl.array.to_device(queue, particles)
    out = {"distance": there[:, 3], "triangle": cl.array.zeros(queue, len(points), np.uint32)}
    status = cl.array.zeros(queue, len(points), np.uint8)
    plan = moving.plan_points(len(points), "distance triangle", within=0.5)
    assert plan.count == len(points) and plan.sign == "nonzero" and plan.device_bytes > 0
    assert str(len(points)) in repr(plan)

    def check(of):
        expected = of.query(points, "distance triangle", within=0.5, dtype="float64")
        assert np.array_equal(there.get()[:, 3], expected.distance, equal_nan=True)
        assert np.array_equal(out["triangle"].get(), expected.triangle)

    event = plan.enqueue(there[:, :3], out=out, status=status, queue=queue)
    assert isinstance(event, cl.Event)
    event.wait()
    with pytest.warns(clsdf.MeshWarning):
        check(body)
    assert (status.get()[:-1] == clsdf.PointStatus.FOUND).all() and status.get()[-1] == clsdf.PointStatus.NOT_FINITE
    moving.set_motion(np.eye(3), (0.1, 0, 0))
    plan.update(moving)
    plan.enqueue(there[:, :3], out=out, wait_for=[event]).wait()
    with pytest.warns(clsdf.MeshWarning):
        check(moving)
    with pytest.raises(clsdf.Error, match="the points lie on the same bytes"):
        plan.enqueue(there[:, :3], out={**out, "distance": there[:, 0]})
    with pytest.raises(clsdf.Error, match="triangle has no target"):
        plan.enqueue(there[:, :3], out=there[:, 3])
    with pytest.raises(clsdf.Error, match="0 points are too few; 1 are the fewest"):
        moving.plan_points(0)


def test_a_callback_may_not_use_its_plan(solid, queue):
    body = clsdf.Transform(solid, device=queue)  # which has compiled nothing yet
    grid = body.grid(16)
    plan = body.plan(grid, band=0.2)
    large = cl.array.zeros(queue, (*grid.shape, 2), np.float32)
    strided = [clsdf.Request(grid, 0.2, {"distance": large[..., 0]})]
    with pytest.raises(clsdf.Error, match="this plan.*progress="):
        plan.update(body, requests=strided, progress=lambda stage, part: plan.device_bytes)
    plan.update(body, requests=strided)
    assert plan.device_bytes > 0


def test_a_plan_keeps_its_arrays(there, body, queue):
    expected = body.field(resolution=16)
    out = {"distance": cl.array.zeros(queue, expected.grid.shape, np.float32)}
    plan = there.plan([clsdf.Request(expected.grid, expected.band, out)])
    first = weakref.ref(out["distance"])
    out["distance"] = None
    gc.collect()
    plan.enqueue().wait()
    assert np.array_equal(first().get(), expected.distance)
    del plan
    gc.collect()
    assert first() is None


def test_arrays_of_the_device_everywhere(solid, there, body, queue, points):
    there_points = cl.array.to_device(queue, points)
    out = {"distance": cl.array.zeros(queue, len(points), np.float32),
           "gradient": cl.array.zeros(queue, (len(points), 3), np.float32)}
    there.query(there_points, out=out)
    expected = body.query(points, "distance gradient")
    assert np.array_equal(out["distance"].get(), expected.distance)
    assert np.array_equal(out["gradient"].get(), expected.gradient)
    field = body.field(resolution=16)
    large = cl.array.zeros(queue, (2, *field.grid.shape), np.float32)
    there.field(field.grid, band=field.band, out=large[1])
    assert np.array_equal(large[1].get(), field.distance) and not large[0].get().any()
    vertices, faces = solid
    made = clsdf.Transform((cl.array.to_device(queue, vertices), cl.array.to_device(queue, faces)), device=queue)
    made.set_positions(cl.array.to_device(queue, vertices * 2))
    body_of_two = clsdf.Transform((vertices * 2, faces))
    assert np.array_equal(made.query(points).distance, body_of_two.query(points).distance)


def test_memory_of_the_device_that_cannot_be(there, body, queue):
    grid = body.grid(16)
    with pytest.raises(clsdf.Error, match="shape"):
        there.field(grid, out=cl.array.zeros(queue, (3, 3, 3), np.float32))
    other = cl.CommandQueue(cl.Context([queue.device]))
    with pytest.raises(clsdf.Error, match="context"):
        there.field(grid, out=cl.array.zeros(other, grid.shape, np.float32))
    with pytest.raises(clsdf.Error, match="targets"):
        there.plan(grid).enqueue()
    with pytest.raises(clsdf.Error, match="2 requests; the plan has 1"):
        there.plan(grid).enqueue(out=[{}, {}])


def test_links_stay_on_the_device(solid, queue):
    moving = clsdf.Transform(solid, device=queue)
    grid = moving.grid(20)
    plan = moving.plan_links(grid, ("D3Q19", "OpenLB"), room=10)
    count = cl.array.zeros(queue, 2, np.int64)
    types = {"samples": np.int32, "directions": np.uint8, "q": np.float32, "triangles": np.uint32,
             "counts": np.int32, "flags": np.uint8}  # fmt: skip

    def run():
        out = {name: cl.array.zeros(queue, (plan.room, 3) if name == "samples" else plan.room, dtype)
               for name, dtype in types.items()}  # fmt: skip
        out |= {"count": count, "inside": cl.array.zeros(queue, grid.shape, np.uint8)}
        plan.enqueue(out=out, queue=queue).wait()
        return out

    out = run()
    links = moving.links(grid, ("D3Q19", "OpenLB"), dtype=np.float32)
    assert count.get().tolist() == [len(links), 0] and not out["q"].get().any()
    plan.update(moving, room=len(links) + 3)
    assert plan.room == len(links) + 3 and plan.grid == grid and plan.device_bytes > 30 * len(links)
    moving.set_positions(moving.vertices[:, [1, 2, 0]])
    plan.update(moving, room=2 * len(links))
    links = moving.links(grid, ("D3Q19", "OpenLB"), dtype=np.float32)
    out = run()
    assert count.get().tolist() == [len(links), 1]
    for name in types:
        assert np.array_equal(out[name].get()[: len(links)], getattr(links, name)), name
    assert np.array_equal(out["inside"].get(), links.inside)
    with pytest.raises(clsdf.Error, match="another shape"):
        plan.enqueue(out={"q": cl.array.zeros(queue, 4, np.float32)})
    with pytest.raises(clsdf.Error, match="'fields'"):
        plan.enqueue(out={"fields": cl.array.zeros(queue, (19, *grid.shape), np.float32)})
    dense = cl.array.zeros(queue, (19, *grid.shape), np.float32)
    plan.enqueue(out={"dense": dense}, queue=queue).wait()
    assert np.array_equal(dense.get(), links.dense())


def test_a_sparse_field_stays_on_the_device(solid, queue):
    moving = clsdf.Transform(solid, device=queue)
    grid = moving.grid(60)
    plan = moving.sparse_plan(grid, (1, 1), outputs="triangle")
    counts = cl.array.zeros(queue, 3, np.int64)

    def run():
        bricks, runs = plan.room
        out = {"counts": counts, "bricks": cl.array.zeros(queue, (bricks, 3), np.int64),
               "inside": cl.array.zeros(queue, (runs, 4), np.int64),
               "distance": cl.array.zeros(queue, (bricks, 8, 8, 8), np.float32),
               "triangle": cl.array.zeros(queue, (bricks, 8, 8, 8), np.int32)}
        event = plan.enqueue(out=out, queue=queue)
        assert isinstance(event, cl.Event)
        event.wait()
        return out

    run()
    bricks, runs, is_complete = counts.get()
    assert is_complete == 0 and bricks > 1
    plan.update(moving, room=(int(bricks) + 50, int(runs) + 50))
    for _ in range(2):
        out = run()
        expected = moving.sparse(grid, band=plan.band, outputs="distance triangle")
        bricks, runs, is_complete = counts.get()
        assert is_complete == 1 and (bricks, runs) == (len(expected.bricks), len(expected.inside))
        assert np.array_equal(out["bricks"].get()[:bricks], expected.bricks)
        assert np.array_equal(out["inside"].get()[:runs], expected.inside)
        assert np.array_equal(out["distance"].get()[:bricks], expected.distance)
        assert np.array_equal(out["triangle"].get()[:bricks].view(np.uint32), expected.triangle)
        moving.set_motion(np.eye(3), (0.01, 0, 0))
        plan.update(moving)
    assert plan.sign == "nonzero" and plan.device_bytes > 0 and "room for" in repr(plan)
    exact = moving.sparse_plan(grid, plan.room, exact_signs=True)
    for band, is_exact in (("2v", True), (clsdf.Band(0.1), False)):
        exact.update(moving, band=band)
        assert exact.band.exact_signs == is_exact
    with pytest.raises(clsdf.Error, match="exclude each other"):
        moving.plan(grid).update(moving, grids=[grid], requests=[])
    with pytest.raises(clsdf.Error, match="'bricks' has another shape"):
        plan.enqueue(out={**out, "bricks": counts})
    with pytest.raises(clsdf.Error, match="'counts' has float; give it int64"):
        plan.enqueue(out={**out, "counts": cl.array.zeros(queue, 3, np.float32)})
    with pytest.raises(clsdf.Error, match="memory of the host"):
        plan.enqueue(out={**out, "counts": np.zeros(3, np.int64)})
    with pytest.raises(clsdf.Error, match="array of runs has no memory"):
        plan.enqueue(out={name: array for name, array in out.items() if name != "inside"})
