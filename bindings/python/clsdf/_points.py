"""Points as users give them, and points on the surface."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _cuda, _meshes
from ._error import Error
from ._values import Outputs, given, real_of, shape_of, type_of, wanted


def rows_of(points: Any) -> tuple[Any, tuple[int, ...]]:
    """Points as (n, 3), and the shape of their distances."""
    points = in_floats(points)
    shape = _cuda.shape_of(points)
    if shape == (0,):
        return np.empty((0, 3)), (0,)
    if shape[-1:] != (3,):
        raise Error(f"points has the shape {shape}; expected (n, 3) or (..., 3), or (3,) of one point")
    if len(shape) == 2:
        return points, shape[:1]
    if _cuda.is_in_cuda(points):
        return _cuda.reshaped(points, (math.prod(shape[:-1]), 3)), shape[:-1]
    if not hasattr(points, "reshape"):
        points = on_host(points)
    return points.reshape(math.prod(shape[:-1]), 3), shape[:-1]


def in_floats(
    points: Any, name: str = "points", remedy: str = "clsdf.torch.signed_distance(body, points) gives it, or "
) -> Any:
    """Points of any package. Whole numbers become doubles; a tensor that requires a gradient is refused."""
    if not isinstance(points, np.ndarray):
        points = _meshes.as_array(points, np.float64)
    if not isinstance(points, np.ndarray):
        _meshes.refuse_graph(name, points, remedy)
        if "int" in str(getattr(points, "dtype", "int")) and not _cuda.is_in_cuda(points) and not hasattr(points, "base_data"):
            points = on_host(points)
    if isinstance(points, np.ndarray) and points.dtype.kind in "iu":
        return points.astype(np.float64)
    return points


def pairs_of(first: Any, second: Any, first_name: str, second_name: str) -> tuple[Any, Any, tuple[int, ...]]:
    """Two arrays (..., 3), which are broadcast, as (n, 3) each, and the shape of a result for each pair."""
    arrays = [in_floats(first, first_name, ""), in_floats(second, second_name, "")]
    shapes = [_cuda.shape_of(array) for array in arrays]
    for name, shape in zip((first_name, second_name), shapes):
        if shape[-1:] != (3,) and shape != (0,):
            raise Error(f"{name} has the shape {shape}; expected (n, 3) or (..., 3), or (3,)")
    for name, array in zip((first_name, second_name), arrays):
        if _cuda.is_in_cuda(array):
            raise Error(f"{name} is in memory of a device, and rays are looked up by the host; pass an array of the host",
                        "unsupported")
    if shapes[0] == shapes[1]:
        rows, of_results = zip(*(rows_of(array) for array in arrays))
        return rows[0], rows[1], of_results[0]
    try:
        broadcast = np.broadcast_arrays(*(on_host(array) for array in arrays))
    except ValueError:
        raise Error(f"{first_name} has the shape {shapes[0]} and {second_name} {shapes[1]}; expected equal shapes, or "
                    "such as NumPy broadcasts") from None
    shape = broadcast[0].shape[:-1]
    one, two = (np.ascontiguousarray(array).reshape(math.prod(shape), 3) for array in broadcast)
    return one, two, shape


def on_host(array: Any) -> npt.NDArray[Any]:
    """An array of any package as one of NumPy, in the same memory."""
    return np.asarray(array) if isinstance(array, memoryview) or hasattr(array, "__array__") else np.from_dlpack(array)


def flat(name: str, array: Any, shape: tuple[int, ...]) -> Any:
    """An array for points of the shape (...) as one of rows, in the same memory."""
    expected = shape_of(name, shape)
    if _cuda.shape_of(array) != expected:
        raise Error(f"out: the array of '{name}' has the shape {_cuda.shape_of(array)}; expected {expected}")
    rows = _cuda.reshaped(array, shape_of(name, (math.prod(shape),)))
    if _cuda.is_in_cuda(array) and _address(rows) != _address(array):
        raise Error(f"out: the array of '{name}' has strides that cannot be those of rows; pass one in C order")
    if isinstance(array, np.ndarray) and not np.may_share_memory(rows, array):
        raise Error(f"out: the array of '{name}' has strides that cannot be those of rows; pass one in C order")
    return rows


def arrays_for(
    outputs: Outputs | None, out: Any, dtype: npt.DTypeLike | None, shape: tuple[int, ...]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays of outputs for points of the shape (...), those of `out` or new ones: as rows, for the call, and as the caller
    gets them, in the same memory."""
    if out is not None:
        if dtype is not None:
            raise Error("dtype= and out= exclude each other: arrays that are given have a type")
        results = given(out, outputs)
        return (results if len(shape) < 2 else {name: flat(name, array, shape) for name, array in results.items()}), results
    arrays, real = {}, real_of(dtype)
    for name in wanted(outputs or ()):
        own = type_of(name)[0]
        arrays[name] = np.empty(shape_of(name, (math.prod(shape),)), real if own == np.float32 else own)
    return arrays, {name: array.reshape(shape_of(name, shape)) for name, array in arrays.items()}


def in_numbers(results: dict[str, Any]) -> dict[str, Any]:
    """Arrays of no axes, as numbers."""
    return {name: array[()] for name, array in results.items()}


def _address(array: Any) -> Any:
    """The first address of an array in memory of CUDA, or its object if only DLPack tells."""
    interface = _cuda.described(array)[0]
    return None if interface is None else interface["data"][0]


def limit_of(value: float | None, name: str = "within", unit: str = "the mesh's units") -> float:
    return math.inf if value is None else _meshes.number_of(name, value, f"in {unit}; None is no limit")


def limits_of(within: Any, shape: tuple[int, ...]) -> npt.NDArray[np.float64] | float:
    """One limit for all points, or an array (n,) of one for each of the points of the shape (...)."""
    if within is None or isinstance(within, (float, int, str)):
        return limit_of(within)  # type: ignore[arg-type]
    try:
        limits = np.asarray(within, np.float64)
    except (TypeError, ValueError):
        raise Error(f"within: {repr(within)[:100]} is neither a number nor an array of numbers") from None
    if not limits.ndim:
        return limit_of(within)
    if limits.shape != shape:
        raise Error(f"within has the shape {limits.shape}; expected a number, or {shape}, one for each point")
    if not (limits >= 0).all():
        raise Error("within: a limit is below 0 or NaN")
    return np.ascontiguousarray(limits).reshape(-1)


#: One call costs as much as the search of so many points.
_worth_a_call = 1000


def by_limit(points: Any, limits: npt.NDArray[np.float64], side: float) -> Iterator[npt.NDArray[np.intp] | slice]:
    """The rows of points in groups of about equal limits, whose greatest one is that of a call. `side`: of the mesh's box."""
    # Points that are not usable are counted, or refused by their row, by one call.
    if len(limits) < _worth_a_call or not (np.abs(points) <= 1e10 * side + np.finfo(np.float32).tiny).all():
        yield slice(None)
        return
    exponents = np.where(limits > 0, np.frexp(np.where(np.isinf(limits), 1, limits))[1], -5000)
    exponents[np.isinf(limits)] = 5000
    for exponent in np.unique(exponents):
        yield np.flatnonzero(exponents == exponent)


def limit_each(points: npt.NDArray[Any], arrays: dict[str, npt.NDArray[Any]], limits: npt.NDArray[np.float64]) -> None:
    """Results, of which the distance is in double, as of points that are searched up to limits of their own."""
    distance = arrays["distance"]
    is_beyond = np.abs(distance) > limits
    distance[is_beyond] = np.copysign(limits, distance)[is_beyond]
    # Too far, in a group without a limit.
    is_lost = np.isnan(distance) & np.isfinite(limits) & np.isfinite(points).all(axis=-1)
    distance[is_lost] = limits[is_lost]
    is_beyond |= is_lost
    for name, array in arrays.items():
        if name != "distance":
            array[is_beyond] = np.array({"triangle": -1, "body": -1, "site": 255}.get(name, np.nan)).astype(array.dtype)


def on_surface(
    vertices: npt.NDArray[Any], faces: npt.NDArray[Any], count: int, radius: float, seed: int | None
) -> npt.NDArray[np.float64]:
    """The points of Transform.sample()."""
    random = np.random.default_rng(seed)

    def drawn(draw: Callable[[tuple[int, int]], npt.NDArray[Any]], columns: int) -> npt.NDArray[Any]:
        """Rows of random numbers; so few at a time that Ctrl-C comes between two."""
        numbers = np.empty((count, columns))
        for part in parts:
            numbers[part] = draw((len(range(*part.indices(count))), columns))
        return numbers

    parts = [slice(begin, begin + (1 << 20)) for begin in range(0, count, 1 << 20)]
    corners = vertices[faces].astype(np.float64)
    first, one, two = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    ends = np.cumsum(np.linalg.norm(np.cross(one, two), axis=1))
    if not ends[-1] > 0:
        raise Error("sample: no face of the mesh has an area", "invalid_mesh")
    areas, us, vs = (drawn(random.random, 1) for _ in range(3))
    points = np.empty((count, 3))
    for part in parts:
        chosen = np.searchsorted(ends, areas[part, 0] * ends[-1], side="right").clip(max=len(ends) - 1)
        u, v = us[part], vs[part]
        u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
        points[part] = first[chosen] + u * one[chosen] + v * two[chosen]
    if radius > 0:
        ways, lengths = drawn(random.standard_normal, 3), drawn(random.random, 1)
        for part in parts:
            way = ways[part] / np.linalg.norm(ways[part], axis=1, keepdims=True)
            points[part] += way * (radius * lengths[part])
    return points
