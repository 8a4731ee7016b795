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


# What torch.func and torch.compile do, which PyTorch 2 has.
needs_transforms = pytest.mark.skipif(not hasattr(torch, "func"), reason="PyTorch 1 has no torch.func")


@needs_transforms
def test_transforms_of_functions_have_the_derivatives_of_backward(own_body, solid, some):
    func = torch.func
    vertices = torch.tensor(solid[0])
    p, x = some.clone().requires_grad_(), vertices.clone().requires_grad_()
    signed_distance(own_body, p, x).sum().backward()
    by_points, by_vertices = func.grad(lambda p, x: signed_distance(own_body, p, x).sum(), argnums=(0, 1))(some, vertices)
    assert torch.equal(by_points, p.grad) and torch.allclose(by_vertices, x.grad)
    one = lambda p: signed_distance(own_body, p)
    rows = some.reshape(-1, 3)
    expected = p.grad.reshape(-1, 3)
    assert torch.equal(func.vmap(one)(rows), one(rows)) and torch.equal(func.vmap(one, in_dims=1)(rows.T), one(rows))
    assert torch.equal(func.vmap(func.grad(one))(rows), expected)
    assert torch.equal(func.grad(lambda p: func.vmap(one)(p).sum())(rows), expected)
    jacobian = func.jacrev(one)(rows)
    assert torch.equal(jacobian[range(24), range(24)], expected) and torch.equal(jacobian.sum(1), expected)
    assert torch.equal(torch.autograd.functional.jacobian(one, rows), jacobian)
    several = torch.stack([vertices, 1.2 * vertices])
    found = func.vmap(lambda x: signed_distance(own_body, rows, x))(several)
    assert torch.equal(found, torch.stack([signed_distance(own_body, rows, x) for x in several]))
    found = func.vmap(func.grad(lambda x: signed_distance(own_body, some, x).sum()))(several)
    assert torch.allclose(found[0], x.grad)


@needs_transforms
@pytest.mark.filterwarnings("ignore::FutureWarning")  # torch's own
def test_second_derivatives_and_the_forward_mode_of_transforms_are_refused(own_body, some):
    func, one = torch.func, lambda p: signed_distance(own_body, p).sum()
    rows = some[0]
    for call in (
        lambda: func.grad(lambda p: (func.grad(one)(p) ** 2).sum())(rows),
        lambda: func.jacrev(func.jacrev(one))(rows),
        lambda: torch.autograd.functional.hessian(one, rows),
    ):
        with pytest.raises(clsdf.Unsupported, match="second derivative"):
            call()
    for call in (lambda: func.jacfwd(one)(rows), lambda: func.hessian(one)(rows)):
        with pytest.raises(clsdf.Unsupported, match="forward mode.*use torch.func.grad, vjp or jacrev"):
            call()


@needs_transforms
@pytest.mark.filterwarnings("ignore")  # torch's own
def test_compiled_functions_have_the_same_results(own_body, some):
    def loss(p):
        return (2 * signed_distance(own_body, p)).sin().sum()

    found = []
    for function in (loss, torch.compile(loss, backend="eager")):
        p = some.clone().requires_grad_()
        value = function(p)
        value.backward()
        found.append((value.detach(), p.grad))
    assert torch.allclose(found[0][0], found[1][0]) and torch.allclose(found[0][1], found[1][1])


def test_a_graph_is_not_lost_without_a_word(own_body, solid, some):
    p = some.clone().requires_grad_()
    pose = torch.eye(4, requires_grad=True)
    for call, remedy in (
        (lambda: own_body.query(p), "points requires a gradient.*clsdf.torch.signed_distance.*detach"),
        (lambda: own_body.winding(p[0]), r"requires a gradient, which this call does not give: pass tensor.detach\(\)"),
        (lambda: own_body.rays(p[0], some[0]), "origins requires a gradient"),
        (lambda: own_body.set_positions(torch.tensor(solid[0], requires_grad=True)), "positions requires a gradient"),
        (lambda: own_body.query(some, frame=pose), "frame requires a gradient.*@ R"),
    ):
        with pytest.raises(clsdf.InvalidArgument, match=remedy):
            call()
    expected = own_body.query(some).distance
    assert np.array_equal(own_body.query(p.detach()).distance, expected)
    with torch.no_grad():
        assert np.array_equal(own_body.query(p).distance, expected)
