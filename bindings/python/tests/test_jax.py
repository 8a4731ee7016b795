"""clsdf.jax: distances of JAX arrays and their derivatives, in jit, grad and vmap."""

from __future__ import annotations

import numpy as np
import pytest

import clsdf

jax = pytest.importorskip("jax")
jnp = jax.numpy


@pytest.fixture(autouse=True)
def doubles():
    jax.config.update("jax_enable_x64", True)


def signed_distance(*arguments, **options):
    return clsdf.jax.signed_distance(*arguments, **options)


@pytest.fixture
def own_body(solid):
    return clsdf.Transform(solid)


@pytest.fixture(scope="module")
def some(points):
    return points[:24].reshape(4, 6, 3)


def differences(function, array, step=1e-6):
    """The derivative of a number by an array, by central differences."""
    result = np.zeros(array.shape)
    for index in np.ndindex(array.shape):
        high, low = array.copy(), array.copy()
        high[index] += step
        low[index] -= step
        result[index] = (function(high) - function(low)) / (2 * step)
    return result


def test_distances_are_those_of_query(body, points):
    for real in (np.float64, np.float32):
        rows = points.astype(real)
        for function in (signed_distance, jax.jit(signed_distance, static_argnums=0)):
            found = function(body, jnp.asarray(rows.reshape(5, 100, 3)))
            assert found.shape == (5, 100) and found.dtype == real
            assert np.array_equal(np.ravel(found), body.query(rows, dtype=real).distance)
    assert signed_distance(body, points[0]).shape == () and signed_distance(body, jnp.zeros((0, 3))).shape == (0,)
    assert signed_distance(body, points.astype(np.float32), body.vertices).dtype == np.float64


@pytest.mark.parametrize("within", [None, 0.3])
def test_derivatives_are_those_of_differences(own_body, solid, some, within):
    some = some[:2, :4]

    def loss(p, x):
        return (signed_distance(own_body, p, x, within=within) ** 2).sum()

    compiled = jax.jit(loss)
    value, (by_points, by_vertices) = jax.jit(jax.value_and_grad(loss, (0, 1)))(some, solid[0])
    assert value == pytest.approx((own_body.query(some, dtype="float64", within=within).distance ** 2).sum())
    assert np.allclose(by_points, differences(lambda p: compiled(p, solid[0]), some), atol=1e-7)
    assert np.allclose(by_vertices, differences(lambda x: compiled(some, x), solid[0]), atol=1e-7)
    assert np.abs(by_vertices).max() > 0.1
    own_body.set_positions(solid[0])
    alone = jax.grad(lambda p: (signed_distance(own_body, p, within=within) ** 2).sum())(some)
    assert np.array_equal(alone, by_points)
    floats = jax.grad(loss, (0, 1))(some.astype(np.float32), solid[0].astype(np.float32))
    for single, double in zip(floats, (by_points, by_vertices)):
        assert single.dtype == np.float32 and np.allclose(single, double, atol=1e-5)


def test_derivatives_are_zero_without_a_nearest_triangle(own_body, some):
    distance, pull = jax.vjp(lambda p: signed_distance(own_body, p, within=0.2), some)
    is_beyond = np.abs(distance) == 0.2
    assert 0 < is_beyond.sum() < is_beyond.size
    assert np.array_equal((pull(jnp.ones_like(distance))[0] == 0).all(-1), is_beyond)


def test_vmap_is_a_loop(own_body, solid, some):
    moved = np.stack([solid[0], solid[0] * 1.2, solid[0] * 1.4])
    expected = np.stack([signed_distance(own_body, some, x) for x in moved])
    over_points = jax.vmap(lambda p: signed_distance(own_body, p, moved[2]))
    assert np.array_equal(over_points(some), expected[2])
    over_vertices = jax.vmap(lambda x: signed_distance(own_body, some, x))
    assert np.array_equal(over_vertices(moved), expected)
    over_both = jax.jit(jax.vmap(lambda p, x: signed_distance(own_body, p, x)))
    assert np.array_equal(over_both(some[:3], moved), [expected[n, n] for n in range(3)])
    gradients = jax.vmap(jax.grad(lambda x: signed_distance(own_body, some, x).sum()))(moved)
    for x, gradient in zip(moved[1:], gradients[1:]):
        assert np.allclose(gradient, jax.grad(lambda x: signed_distance(own_body, some, x).sum())(x), atol=1e-12)


def test_the_backward_pass_needs_nothing_of_the_body(own_body, solid, some):
    pulls = [jax.vjp(lambda x: signed_distance(own_body, some, x), solid[0] * scale)[1] for scale in (1.0, 1.3)]
    assert np.array_equal(own_body.vertices, solid[0] * 1.3)
    own_body.set_positions(solid[0] * 3)
    for scale, pull in zip((1.0, 1.3), pulls):
        expected = jax.grad(lambda x: signed_distance(own_body, some, x).sum())(solid[0] * scale)
        assert np.array_equal(pull(jnp.ones((4, 6)))[0], expected)


def test_what_is_refused(own_body, solid, some):
    def loss(p):
        return (signed_distance(own_body, p) ** 2).sum()

    for second in (jax.grad(lambda p: jax.grad(loss)(p).sum()), jax.hessian(loss), jax.jit(jax.hessian(loss))):
        with pytest.raises(clsdf.Error, match="second derivative"):
            second(some)
    with pytest.raises(TypeError, match="forward-mode"):
        jax.jvp(loss, (some,), (some,))
    for arguments, match in (
        ((solid, some), "is no clsdf.Transform"),
        ((own_body, some[..., :2]), r"points has the shape \(4, 6, 2\); expected \(\.\.\., 3\)"),
        ((own_body, some.astype(int)), "points: numbers of int64 are not taken"),
        ((own_body, some, solid[0][1:]), r"vertices has the shape \(17, 3\); the body's have \(18, 3\)"),
    ):
        with pytest.raises(clsdf.InvalidArgument, match=match):
            jax.jit(lambda *rest: signed_distance(arguments[0], *rest))(*arguments[1:])
    with pytest.raises(jax.errors.JaxRuntimeError, match="not finite|NaN|nan"):
        jax.block_until_ready(signed_distance(own_body, some, np.full_like(solid[0], np.nan)))
