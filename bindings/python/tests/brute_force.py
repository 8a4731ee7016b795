"""Distances to small meshes by brute force in NumPy: the plain specification that the calls are compared with."""

from __future__ import annotations

import numpy as np


class BruteForce:
    """Distances, closest points and signs in float64, of every point to every triangle."""

    def __init__(self, vertices, faces):
        self.corners = np.asarray(vertices, float)[np.asarray(faces, int)]

    def closest(self, points):
        """(n, m, 3): the closest point of every triangle to every point."""
        a, b, c = (self.corners[None, :, i] for i in range(3))
        p = np.asarray(points, float)[:, None]
        normal = np.cross(b - a, c - a)
        onto = p - normal * (((p - a) * normal).sum(-1) / (normal**2).sum(-1))[..., None]
        # The projection if it is inside all edges, else the nearest point of the edges.
        within = np.ones(onto.shape[:2], bool)
        for start, end in ((a, b), (b, c), (c, a)):
            within &= (np.cross(end - start, onto - start) * normal).sum(-1) >= 0
        best = np.where(within[..., None], onto, np.inf)
        far = np.where(within, ((p - onto) ** 2).sum(-1), np.inf)
        for start, end in ((a, b), (b, c), (c, a)):
            along = ((p - start) * (end - start)).sum(-1) / ((end - start) ** 2).sum(-1)
            on = start + np.clip(along, 0, 1)[..., None] * (end - start)
            distance = ((p - on) ** 2).sum(-1)
            best = np.where((distance < far)[..., None], on, best)
            far = np.minimum(far, distance)
        return best

    def winding(self, points):
        """The winding number by solid angles."""
        p = np.asarray(points, float)[:, None]
        a, b, c = (self.corners[None, :, i] - p for i in range(3))
        la, lb, lc = (np.linalg.norm(v, axis=-1) for v in (a, b, c))
        top = (a * np.cross(b, c)).sum(-1)
        bottom = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
        return np.arctan2(top, bottom).sum(1) / (2 * np.pi)

    def distance(self, points):
        """Signed, negative inside."""
        far = np.linalg.norm(self.closest(points) - np.asarray(points, float)[:, None], axis=-1).min(1)
        return np.where(np.round(self.winding(points)) != 0, -far, far)


def positions(grid):
    """(nz, ny, nx, 3): of the samples, from the definition of a grid."""
    nz, ny, nx = grid.shape
    k, j, i = np.meshgrid(range(nz), range(ny), range(nx), indexing="ij")
    return np.array(grid.origin) + np.array(grid.spacing) * (np.array(grid.first) + np.stack([i, j, k], -1))
