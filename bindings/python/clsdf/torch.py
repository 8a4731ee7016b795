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
from .typing import ArrayLike

__all__ = ["signed_distance"]

_no_forward = "the forward mode of a signed distance is not computed; use torch.func.grad, vjp or jacrev"


def signed_distance(
    body: Transform,
    points: torch.Tensor | ArrayLike,
    vertices: torch.Tensor | ArrayLike | None = None,
    *,
    within: float | None = None,
) -> torch.Tensor:
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
    side by side. Works in torch.compile, and in grad, vjp, vmap and jacrev of torch.func (PyTorch 2); a vmap over vertices
    sets one position after the other. The second derivative and the forward mode (jvp, jacfwd) are refused. Raises
    clsdf.Error as query() and set_positions().
    """
    points = torch.as_tensor(points)
    vertices = None if vertices is None else torch.as_tensor(vertices)
    _derivatives.check(body, points, vertices, (torch.float32, torch.float64))
    asked = (points.requires_grad, vertices is not None and vertices.requires_grad)
    if _is_transformed():
        asked = (True, vertices is not None)
    elif not torch.is_grad_enabled():
        asked = (False, False)
    distance: torch.Tensor = _Distance.apply(body, within, asked, points, vertices)[0]
    return distance


# torch.func and functorch's transforms need functions whose forward() has no ctx, which PyTorch 2 brought.
_has_transforms = hasattr(torch, "func")


def _with_ctx(function: Any) -> Any:
    """The function as PyTorch 1 takes it."""
    if _has_transforms:
        return function

    def forward(ctx: Any, *inputs: Any) -> Any:
        output = function.forward(*inputs)
        function.setup_context(ctx, inputs, output)
        return output

    return type(function.__name__, (function,), {"forward": staticmethod(forward)})


def _is_transformed() -> bool:
    """Whether torch.func is at work, for which tensors do not say what is differentiated."""
    return _has_transforms and bool(torch._C._are_functorch_transforms_active())


@_with_ctx
class _Distance(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
    """Distances, and what derivatives need. `asked`: whether by points and by vertices. What is not asked for is empty."""

    @staticmethod
    def forward(body: Transform, within: float | None, asked: tuple[bool, bool], points: Any, vertices: Any) -> Any:
        is_double = torch.float64 in (points.dtype, points.dtype if vertices is None else vertices.dtype)
        found = _derivatives.find(
            body,
            points.detach().cpu().numpy(),
            None if vertices is None else vertices.detach().cpu().numpy(),
            within,
            "float64" if is_double else "float32",
            *asked,
        )
        return tuple(
            points.new_empty(0) if array is None else torch.from_numpy(array).to(points.device) for array in found
        )

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        _, *kept = output
        ctx.mark_non_differentiable(*kept)
        ctx.save_for_backward(*inputs[3:], *kept)

    @staticmethod
    def vmap(
        info: Any, in_dims: Any, body: Transform, within: float | None, asked: tuple[bool, bool], points: Any, vertices: Any
    ) -> Any:
        by_points, by_vertices = in_dims[3:]
        if by_points is not None:
            points = points.movedim(by_points, 0)
        if by_vertices is None:
            found = _Distance.apply(body, within, asked, points, vertices)
        else:  # one position of the mesh after the other
            rows = points if by_points is not None else [points] * info.batch_size
            each = [_Distance.apply(body, within, asked, *both) for both in zip(rows, vertices.movedim(by_vertices, 0))]
            found = tuple(torch.stack(arrays) for arrays in zip(*each))
        return found, (0, *(0 if any(asked[n:]) else None for n in (0, 1, 1)))

    @staticmethod
    def backward(ctx: Any, upstream: Any, *_: Any) -> Any:
        return None, None, None, *_Derivatives.apply(upstream, ctx.needs_input_grad[3:], *ctx.saved_tensors)

    @staticmethod
    def jvp(ctx: Any, *tangents: Any) -> Any:
        raise Error(_no_forward, "unsupported")


@_with_ctx
class _Derivatives(torch.autograd.Function):  # type: ignore[misc,unused-ignore]
    """The derivatives, from what was kept; they depend on points and vertices, but have no derivative."""

    generate_vmap_rule = True

    @staticmethod
    def forward(
        upstream: Any, needed: tuple[bool, bool], points: Any, vertices: Any, gradient: Any, corners: Any, weights: Any
    ) -> Any:
        by_point = upstream[..., None] * gradient
        by_vertices = None
        if needed[1]:
            rows = (-weights[..., None] * by_point[..., None, :]).reshape(-1, 3)
            by_vertices = rows.new_zeros(vertices.shape).index_add(0, corners.reshape(-1), rows).to(vertices)
        return by_point.to(points) if needed[0] else None, by_vertices

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        pass

    @staticmethod
    def backward(ctx: Any, *upstream: Any) -> Any:
        raise Error(_derivatives.no_second, "unsupported")

    @staticmethod
    def jvp(ctx: Any, *tangents: Any) -> Any:
        raise Error(_derivatives.no_second, "unsupported")
