"""Arrays by the names of outputs, and the results that have them."""

from __future__ import annotations

import math
import operator
import sys
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _core, _cuda
from ._core import Band, Grid
from ._error import Error

Outputs = Union[str, Iterable[str]]

#: The names of all outputs. docs/library.md, 'A field', says what each is.
names = tuple(name for name, _, _, _ in _core.outputs())
_types = {name: (np.dtype(dtype), components) for name, dtype, components, _ in _core.outputs()}


#: Bytes of arrays that are made without a look at the memory there is.
_unquestioned = 1 << 30


def type_of(output: str) -> tuple[np.dtype[Any], int]:
    """The type of a number of the output, and how many numbers a sample has."""
    return _types[output]


@lru_cache(maxsize=64)
def _split(text: str) -> tuple[str, ...]:
    return wanted(text.replace(",", " ").split())


def wanted(outputs: Outputs) -> tuple[str, ...]:
    """The names in "distance gradient", "distance,gradient" or ["distance", "gradient"], with the distance, in the order
    of `names`."""
    if isinstance(outputs, str):
        return _split(outputs)
    try:
        asked = {"distance", *outputs}
        unknown = sorted(asked.difference(names))
    except TypeError:
        raise Error(f"outputs: {outputs!r} is neither a text nor a list of names; the outputs are {', '.join(names)}") from None
    if unknown:
        raise Error(f"there is no output {unknown[0]!r}; the outputs are {', '.join(names)}")
    return tuple(name for name in names if name in asked)


def shape_of(output: str, shape: tuple[int, ...]) -> tuple[int, ...]:
    """The shape of the output's array; a vector has one axis more than the samples."""
    components = _types[output][1]
    return shape if components == 1 else (*shape, components)


def whole(what: str, value: Any, of: str = "samples", least: int | None = None) -> int:
    try:
        if isinstance(value, bool):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise Error(f"{what}: {value!r} is not a whole number of {of}") from None
    if least is not None and number < least:
        raise Error(f"{what}: {value!r} {of} are too few; {least} are the fewest")
    if not -(2**63) <= number < 2**63:
        raise Error(f"{what}: {value!r} {of} are too many")
    return number


def real_of(dtype: npt.DTypeLike | None) -> np.dtype[Any]:
    """The type of the outputs that may be in floats or in doubles."""
    try:
        real = np.dtype(np.float32 if dtype is None else dtype)
    except TypeError:
        real = np.dtype(np.int8)
    if real not in (np.dtype(np.float32), np.dtype(np.float64)):
        raise Error(f"dtype: {dtype!r} is neither 'float32' nor 'float64'")
    return real


def new_samples(
    outputs: Iterable[str], shape: tuple[int, ...], real: npt.DTypeLike | None = None
) -> dict[str, npt.NDArray[Any]]:
    """Arrays for the samples of a grid, in memory for fast stores."""
    arrays = {}
    outputs = tuple(outputs)
    types = {name: real_of(real) if _types[name][0] == np.float32 else _types[name][0] for name in outputs}
    bytes_of_sample = sum(types[name].itemsize * _types[name][1] for name in outputs)
    if bytes_of_sample * math.prod(shape) > _unquestioned:
        from . import _memory  # imports pathlib

        _memory.check(bytes_of_sample * math.prod(shape), "a field")
    for name in outputs:
        dtype, components = types[name], _types[name][1]
        size = components * math.prod(shape) * dtype.itemsize
        if size > sys.maxsize:
            raise Error(f"a field of {' x '.join(map(str, reversed(shape)))} samples does not fit the memory; choose a "
                        "lower resolution, or slabs()", "out_of_memory")
        memory = _core.allocate(size)
        arrays[name] = memory.view(dtype).reshape(shape_of(name, shape))
    return arrays


def given(out: Any, outputs: Outputs | None) -> dict[str, Any]:
    """The arrays of `out`: a result, a dictionary, or the array of the distance."""
    if isinstance(out, Values):
        arrays: dict[str, Any] = out.arrays
    elif isinstance(out, Mapping):
        arrays = dict(out)
    else:
        arrays = {"distance": out}
    if "distance" not in arrays:
        raise Error("out has no array of the distance, which is always computed")
    if outputs is not None and (asked := wanted(outputs)) != wanted(arrays):
        raise Error(f"outputs= names {', '.join(asked)}; out= has arrays of {', '.join(wanted(arrays))}")
    return arrays


class Values:
    """Arrays of outputs. One that was not asked for raises AttributeError.

    The inside is negative. Beyond the band the distance is its half width with the sign, the triangle
    clsdf.no_triangle, the site clsdf.no_site, and vectors are NaN.
    """

    def __init__(self, arrays: dict[str, Any]) -> None:
        self.arrays = arrays

    @property
    def outputs(self) -> tuple[str, ...]:
        """The names of the outputs that it has."""
        return tuple(self.arrays)

    def _array(self, name: str) -> npt.NDArray[Any]:
        try:
            return self.arrays[name]  # type: ignore[no-any-return]
        except KeyError:
            raise AttributeError(f"there is no {name} here: ask for it with outputs='distance {name}'") from None

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """The array of an output, as of the attribute of its name: r["distance"]."""
        if name not in self.arrays:
            raise KeyError(f"there is no {name!r} here, but {', '.join(self.arrays)}; outputs= names what is computed")
        return self.arrays[name]  # type: ignore[no-any-return]

    __iter__ = None  # the names are in `outputs`

    @property
    def distance(self) -> npt.NDArray[np.float32]:
        """Signed distances in the mesh's units, negative inside."""
        return self._array("distance")

    @property
    def triangle(self) -> npt.NDArray[np.uint32]:
        """Index of the nearest triangle; if an edge or a vertex is nearest, the lowest that shares it."""
        return self._array("triangle")

    @property
    def site(self) -> npt.NDArray[np.uint8]:
        """The triangle's nearest part: 0 to 2 its vertices, 3 to 5 its edges (3 + k: from vertex k to the next), 6 its
        face; of an outer surface also 7, where faces cut each other."""
        return self._array("site")

    @property
    def closest(self) -> npt.NDArray[np.float64]:
        """(..., 3): position of the closest point, in the mesh's units."""
        return self._array("closest")

    @property
    def gradient(self) -> npt.NDArray[np.float32]:
        """(..., 3): gradient of the signed distance, a unit vector."""
        return self._array("gradient")

    @property
    def barycentric(self) -> npt.NDArray[np.float32]:
        """(..., 2): weights of the triangle's vertices 1 and 2 in the closest point."""
        return self._array("barycentric")

    @property
    def offset(self) -> npt.NDArray[np.float32]:
        """(..., 3): from the sample or point to the closest point, in the mesh's units."""
        return self._array("offset")

    @property
    def body(self) -> npt.NDArray[np.uint32]:
        """Of a Scene: the body of the nearest triangle, clsdf.no_body beyond the band. Of a Transform 0."""
        return self._array("body")


class Samples(Values):
    """Arrays of samples of a grid, with what a file says of them."""

    def __init__(
        self,
        grid: Grid,
        band: Band,
        sign: str,
        mesh_name: str,
        arrays: dict[str, Any],
        positive_inside: bool,
        floor: float | None,
    ) -> None:
        super().__init__(arrays)
        self.grid = grid
        self.band = band
        self.sign = sign
        self.mesh_name = mesh_name
        self.positive_inside = positive_inside
        self.floor = floor


class Points(Values):
    """What query() found: arrays (n,), and (n, 3) of vectors, in the order of the points."""

    def __len__(self) -> int:
        """The number of points."""
        return math.prod(_cuda.shape_of(self.arrays["distance"]))

    def __repr__(self) -> str:
        return f"<clsdf.Points: {', '.join(self.outputs)} of {len(self)} points>"


class Blocks(Values):
    """What blocks() computed: arrays (blocks, nz, ny, nx), and (blocks, nz, ny, nx, 3) of vectors."""

    def __repr__(self) -> str:
        return f"<clsdf.Blocks: {', '.join(self.outputs)}, shape {self.arrays['distance'].shape}>"
