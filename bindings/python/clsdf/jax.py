"""Signed distances of JAX arrays, differentiable by the points and by the mesh's vertices, also in jit, vmap and grad.
Needs jax.

    import clsdf.jax
    loss = lambda points: (clsdf.jax.signed_distance(body, points) ** 2).mean()
    jax.jit(jax.value_and_grad(loss))(points)
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
import numpy.typing as npt

import jax  # type: ignore[import-not-found,import-untyped,unused-ignore]
import jax.numpy as jnp  # type: ignore[import-not-found,import-untyped,unused-ignore]

from . import _derivatives
from ._error import Error
from ._transform import Transform

__all__ = ["signed_distance"]


def signed_distance(
    body: Transform,
    points: jax.Array | npt.ArrayLike,
    vertices: jax.Array | npt.ArrayLike | None = None,
    *,
    within: float | None = None,
) -> jax.Array:
    """The signed distances (...) at points (..., 3), negative inside, with derivatives by both arrays.

    points: an array of float32, or of float64 with jax_enable_x64. The distances are float64 if one of the arrays is.
    vertices: an array (n, 3), the positions of the body's vertices. The body gets them, as by set_positions(), at the
        time of the computation, and keeps them afterwards. None: the positions that it has then, and no derivative by
        them. JAX may change the order of calls: in one program give `vertices` to all calls of a body or to none.
    within: a number, as of Transform.query(). A farther point has that limit as its distance, and the derivatives 0; so
        has a point that is not finite.

    The derivative by a point is the gradient, on the surface its outward normal; that by the vertices of the nearest
    triangle is minus the gradient times the barycentric coordinates of the closest point. The call keeps what they need,
    so the backward pass asks nothing of the body, which may have moved since. Works in jit, grad and vmap; a vmap over
    vertices sets one position after the other. The second derivative and the forward mode (jvp, jacfwd) are refused.
    Raises clsdf.Error for wrong types and shapes; what query() and set_positions() refuse during the computation arrives
    as jax.errors.JaxRuntimeError, with their message.
    """
    points = jnp.asarray(points)
    vertices = None if vertices is None else jnp.asarray(vertices)
    _derivatives.check(body, points, vertices, (jnp.float32, jnp.float64))
    distance: jax.Array = _distance(body, within, points, vertices)
    return distance


# What find() finds, in the callback. A dimension that vmap added stands first, and is 1 of an array without it.
def _find(body: Transform, within: float | None, names: tuple[str, ...], points: Any, vertices: Any) -> Any:
    def found(points: Any, vertices: Any) -> Any:
        by_vertices = "weights" in names
        all_found = _derivatives.find(body, points, vertices, within, real, "gradient" in names, by_vertices)
        return [np.asarray(getattr(all_found, name), np.int32 if name == "corners" else real) for name in names]

    points = np.asarray(points)
    if vertices is None:
        real = points.dtype
        return tuple(found(points, None))
    vertices = np.asarray(vertices)
    real = np.result_type(points, vertices)
    axes = vertices.ndim - 2
    if math.prod(vertices.shape[:axes]) == 1:
        return tuple(found(points, vertices.reshape(vertices.shape[axes:])))
    batch = np.broadcast_shapes(points.shape[:axes], vertices.shape[:axes])
    points = np.broadcast_to(points, batch + points.shape[axes:])
    vertices = np.broadcast_to(vertices, batch + vertices.shape[axes:])
    rows = [found(points[index], vertices[index]) for index in np.ndindex(batch)]
    return tuple(np.stack(arrays).reshape(batch + arrays[0].shape) for arrays in zip(*rows))


# By custom_jvp, so that a second derivative is refused with our message.
@functools.partial(jax.custom_jvp, nondiff_argnums=(0, 1, 2))
def _found(body: Transform, within: float | None, names: tuple[str, ...], points: Any, vertices: Any) -> Any:
    real = points.dtype if vertices is None else jnp.result_type(points, vertices)
    shapes = tuple(
        jax.ShapeDtypeStruct(  # type: ignore[no-untyped-call,unused-ignore]
            points.shape[:-1] if name == "distance" else points.shape, jnp.int32 if name == "corners" else real
        )
        for name in names
    )
    call = functools.partial(_find, body, within, names)
    return jax.pure_callback(call, shapes, points, vertices, vmap_method="expand_dims")


@_found.defjvp  # type: ignore[misc,untyped-decorator,unused-ignore]
def _refuse(body: Any, within: Any, names: Any, primals: Any, tangents: Any) -> Any:
    raise Error(_derivatives.no_second, "unsupported")


@functools.partial(jax.custom_vjp, nondiff_argnums=(0, 1))
def _distance(body: Transform, within: float | None, points: Any, vertices: Any) -> Any:
    return _found(body, within, ("distance",), points, vertices)[0]


def _forward(body: Transform, within: float | None, points: Any, vertices: Any) -> Any:
    names = ("distance", "gradient") if vertices is None else ("distance", "gradient", "corners", "weights")
    distance, *kept = _found(body, within, names, points, vertices)
    return distance, (kept, points, vertices)


def _backward(body: Transform, within: float | None, saved: Any, upstream: Any) -> Any:
    (gradient, *of_triangle), points, vertices = saved
    by_point = upstream[..., None] * gradient
    by_vertices = None
    if of_triangle:
        corners, weights = of_triangle
        rows = -weights[..., None] * by_point[..., None, :]
        by_vertices = jnp.zeros(vertices.shape, rows.dtype).at[corners].add(rows).astype(vertices.dtype)
    return by_point.astype(points.dtype), by_vertices


_distance.defvjp(_forward, _backward)
