"""Signed distances of PyTorch tensors, differentiable by the points and by the mesh's vertices. Needs torch.

    import clsdf.torch
    distance = clsdf.torch.signed_distance(body, points)                # points, distance: tensors
    distance.square().mean().backward()
"""

from __future__ import annotations

from typing import Any

import torch  # type: ignore[import-not-found,import-untyped,unused-ignore]

from . import _derivatives
from ._error import Error
from ._transform import Transform

__all__ = ["signed_distance"]


def signed_distance(body: Transform, points: Any, vertices: Any = None, *, within: float | None = None) -> torch.Tensor:
    """The signed distances (...) at points (..., 3), negative inside, with derivatives by both tensors.

    points: a tensor of float32 or float64, or what torch.as_tensor() takes. The distances are float64 if one of the
        tensors is, else float32. Tensors of another device are copied to the host, and the distances to that of points.
    vertices: a tensor (n, 3), the positions of the body's vertices. The body gets them, as by set_positions(), and keeps
        them afterwards. None: the present positions, and no derivative by them.
    within: as of Transform.query(). A farther point has that limit as its distance, and the derivatives 0; so has a
        point that is not finite.

    The derivative by a point is the gradient, on the surface its outward normal; that by the vertices of the nearest
    triangle is minus the gradient times the barycentric coordinates of the closest point. The call keeps what they need,
    so backward() asks nothing of the body: it may have moved since, and graphs of one body with other vertices are right
    side by side. The second derivative is refused. Raises clsdf.Error as query() and set_positions().
    """
    points = torch.as_tensor(points)
    vertices = None if vertices is None else torch.as_tensor(vertices)
    _derivatives.check(body, points, vertices, (torch.float32, torch.float64))
    distance: torch.Tensor = _Distance.apply(body, within, torch.is_grad_enabled(), points, vertices)
    return distance


class _Distance(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
    @staticmethod
    def forward(ctx: Any, body: Transform, within: float | None, is_recorded: bool, points: Any, vertices: Any) -> Any:
        by_points, by_vertices = (is_recorded and needed for needed in ctx.needs_input_grad[3:])
        is_double = torch.float64 in (points.dtype, points.dtype if vertices is None else vertices.dtype)
        found = _derivatives.find(
            body,
            points.detach().cpu().numpy(),
            None if vertices is None else vertices.detach().cpu().numpy(),
            within,
            "float64" if is_double else "float32",
            by_points,
            by_vertices,
        )
        distance, *kept = (None if array is None else torch.from_numpy(array).to(points.device) for array in found)
        ctx.save_for_backward(points, vertices, *kept)
        return distance

    @staticmethod
    def backward(ctx: Any, upstream: Any) -> Any:
        return None, None, None, *_Derivatives.apply(upstream, ctx.needs_input_grad[3:], *ctx.saved_tensors)


class _Derivatives(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
    """The derivatives, from what was kept; they depend on points and vertices, but have no derivative."""

    @staticmethod
    def forward(
        ctx: Any, upstream: Any, needed: Any, points: Any, vertices: Any, gradient: Any, corners: Any, weights: Any
    ) -> Any:
        by_point = upstream[..., None] * gradient
        by_vertices = None
        if needed[1]:
            rows = (-weights[..., None] * by_point[..., None, :]).reshape(-1, 3)
            by_vertices = rows.new_zeros(vertices.shape).index_add_(0, corners.reshape(-1), rows)
            by_vertices = by_vertices.to(vertices)
        return by_point.to(points) if needed[0] else None, by_vertices

    @staticmethod
    def backward(ctx: Any, *upstream: Any) -> Any:
        raise Error(_derivatives.no_second, "unsupported")
