"""clsdf.torch: distances of tensors and their derivatives."""

from __future__ import annotations

import numpy as np
import pytest

import clsdf

torch = pytest.importorskip("torch")


def signed_distance(*arguments, **options):
    return clsdf.torch.signed_distance(*arguments, **options)


@pytest.fixture
def own_body(solid):
    return clsdf.Transform(solid)


@pytest.fixture(scope="module")
def some(points):
    """Points as a tensor, in two axes."""
    return torch.tensor(points[:24].reshape(4, 6, 3))


def test_distances_are_those_of_query(body, points):
    for real in (np.float64, np.float32):
        rows = points.astype(real)
        found = signed_distance(body, torch.tensor(rows.reshape(5, 100, 3)))
        assert found.shape == (5, 100) and not found.requires_grad
        assert np.array_equal(found.numpy().ravel(), body.query(rows, dtype=real).distance)
    assert signed_distance(body, points[0]).shape == () and signed_distance(body, torch.zeros(0, 3)).shape == (0,)
    mixed = signed_distance(body, torch.tensor(points, dtype=torch.float32), torch.tensor(body.vertices))
    assert mixed.dtype == torch.float64
    strided = torch.tensor(points.T).T[::2]
    assert torch.equal(signed_distance(body, strided), signed_distance(body, torch.tensor(points[::2])))


def test_derivatives_are_those_of_differences(own_body, solid, some):
    vertices = torch.tensor(solid[0], requires_grad=True)
    assert torch.autograd.gradcheck(lambda p: signed_distance(own_body, p), some.clone().requires_grad_())
    both = (some[:2, :3].clone().requires_grad_(), vertices)
    assert torch.autograd.gradcheck(lambda p, x: signed_distance(own_body, p, x), both)
    assert torch.autograd.gradcheck(lambda x: signed_distance(own_body, some, x, within=0.3), vertices)


def test_floats_have_the_derivatives_of_doubles(own_body, solid, some):
    found = []
    for real in (torch.float32, torch.float64):
        p, x = some.clone().to(real).requires_grad_(), torch.tensor(solid[0], dtype=real, requires_grad=True)
        (signed_distance(own_body, p, x) ** 2).sum().backward()
        assert p.grad.dtype == x.grad.dtype == real
        found.append((p.grad, x.grad))
    for single, double in zip(*found):
        assert torch.allclose(single.double(), double, atol=1e-5) and double.abs().max() > 0.1


def test_derivatives_are_zero_without_a_nearest_triangle(own_body, solid, some):
    p, x = some.clone().requires_grad_(), torch.tensor(solid[0], requires_grad=True)
    distance = signed_distance(own_body, p, x, within=0.2)
    distance.sum().backward()
    is_beyond = distance.detach().abs() == 0.2
    assert 0 < is_beyond.sum() < is_beyond.numel()
    assert torch.equal((p.grad == 0).all(-1), is_beyond)
    alone = torch.tensor(solid[0], requires_grad=True)
    signed_distance(own_body, some[~is_beyond], alone, within=0.2).sum().backward()
    assert torch.allclose(x.grad, alone.grad, atol=1e-12)

    odd = torch.tensor([[np.nan, 0, 0], [2.0, 0, 0]], requires_grad=True)
    with pytest.warns(clsdf.MeshWarning):
        distance = signed_distance(own_body, odd)
    distance.nan_to_num().sum().backward()
    assert distance[0].isnan() and (odd.grad[0] == 0).all() and odd.grad[1].norm() > 0.9


def test_graphs_of_one_body_are_independent(own_body, solid, some):
    """backward() needs nothing of the body, which has other positions by then."""
    def gradients(scales, order):
        leaves = [torch.tensor(solid[0] * scale, requires_grad=True) for scale in scales]
        graphs = [signed_distance(own_body, some, leaf).square().sum() for leaf in leaves]
        assert np.array_equal(own_body.vertices, solid[0] * scales[-1])
        own_body.set_positions(solid[0] * 3)
        for n in order:
            graphs[n].backward()
        return [leaf.grad for leaf in leaves]

    alone = [gradients([scale], [0])[0] for scale in (1.0, 1.3)]
    for order in ([0, 1], [1, 0]):
        for found, expected in zip(gradients((1.0, 1.3), order), alone):
            assert torch.equal(found, expected)


def test_a_second_derivative_is_refused(own_body, some, solid):
    p, x = some.clone().requires_grad_(), torch.tensor(solid[0], requires_grad=True)
    for leaf in (p, x):
        (gradient,) = torch.autograd.grad(signed_distance(own_body, p, x).sum(), leaf, create_graph=True)
        with pytest.raises(clsdf.Error, match="second derivative") as error:
            gradient.square().sum().backward()
        assert error.value.code == "unsupported"


def test_wrong_tensors_are_told(own_body, solid, some):
    for arguments, match in (
        ((solid, some), "is no clsdf.Transform"),
        ((own_body, some[..., :2]), r"points has the shape \(4, 6, 2\); expected \(\.\.\., 3\)"),
        ((own_body, some.half()), "points: numbers of torch.float16 are not taken"),
        ((own_body, some, torch.tensor(solid[0][1:])), r"vertices has the shape \(17, 3\); the body's have \(18, 3\)"),
        ((own_body, some, torch.tensor(solid[0]).int()), "vertices: numbers of torch.int32 are not taken"),
    ):
        with pytest.raises(clsdf.InvalidArgument, match=match):
            signed_distance(*arguments)
