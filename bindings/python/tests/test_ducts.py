"""Every link of a duct's nodes to its walls has a q and a patch, also where nodes and diagonals lie on walls."""

from __future__ import annotations

import numpy as np
import pytest

import clsdf

RADIUS, LENGTH = 2.0, 50.0


def corners(turn):
    """The four corners of a square duct about z: on the axes, or, turned by 45 degrees, walls across x and y."""
    angles = turn + np.pi / 2 * np.arange(4)
    return np.round(RADIUS * np.column_stack([np.cos(angles), np.sin(angles)]), 12)


def solid(name, triangles):
    """A solid of an ASCII STL file."""
    lines = [f"solid {name}"]
    for triangle in triangles:
        lines.append("facet normal 0 0 0\nouter loop")
        lines += ["vertex " + " ".join(repr(float(x)) for x in corner) for corner in triangle]
        lines.append("endloop\nendfacet")
    return "\n".join([*lines, f"endsolid {name}\n"])


def write_duct(path, turn):
    low, high = (np.column_stack([corners(turn), np.full(4, z)]) for z in (0.0, LENGTH))
    wall = []
    for i in range(4):
        j = (i + 1) % 4
        wall += [(low[i], low[j], high[j]), (low[i], high[j], high[i])]
    path.write_text(solid("wall", wall) + solid("inlet", [(low[0], low[2], low[1]), (low[0], low[3], low[2])])
                    + solid("outlet", [(high[0], high[1], high[2]), (high[0], high[2], high[3])]))


def write_block(path):
    """A block around the duct: what is in both is an even number of shells deep, the fluid."""
    size = np.array((4.0, 4.0, 60.0))
    v = np.array([(x, y, z) for z in (-5.0, size[2]) for y in (-size[1], size[1]) for x in (-size[0], size[0])])
    faces = [(0, 3, 1), (0, 2, 3), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 7, 3), (2, 6, 7), (0, 6, 2),
             (0, 4, 6), (1, 3, 7), (1, 7, 5)]  # fmt: skip
    path.write_text(solid("block", v[np.array(faces)]))


@pytest.fixture(params=[0.0, np.pi / 4], ids=["corners on the axes", "walls across the axes"])
def duct(request, tmp_path):
    write_duct(tmp_path / "duct.stl", request.param)
    write_block(tmp_path / "block.stl")
    return clsdf.read_mesh(tmp_path / "duct.stl", tmp_path / "block.stl"), corners(request.param)


# With corners on the axes, nodes lie on the inlet, the outlet, the corners and, diagonally, all along the walls.
@pytest.mark.parametrize("spacing", [0.25, 0.2])
def test_every_link_of_the_fluid_to_a_wall_has_a_q_and_a_patch(duct, spacing):
    mesh, square = duct
    names = [mesh.groups.names[number] for number in range(len(mesh.groups.names))]
    assert sorted(names) == ["block", "duct/inlet", "duct/outlet", "duct/wall"]
    across, along = round(6 / spacing), round(52 / spacing)
    grid = clsdf.Grid((-3, -3, -1), spacing, (across + 1, across + 1, along + 1))
    links = clsdf.Transform(mesh, sign="parity").links(grid, ("D3Q27", "OpenLB"))
    # The fluid is outside the solid. A node is in it if it is within the duct, or on a wall.
    fluid = ~links.inside
    z, y, x = (np.arange(n) * spacing + first for n, first in zip(fluid.shape, (-1, -3, -3)))
    normals = [(b[1] - a[1], a[0] - b[0]) for a, b in zip(square, np.roll(square, -1, 0))]
    depths = [(a @ n - n[0] * x - n[1] * y[:, None]) / np.hypot(*n) for a, n in zip(square, np.array(normals))]
    depth = np.minimum(np.min(depths, 0), np.minimum(z, LENGTH - z)[:, None, None])
    clear = abs(depth) > 1e-9  # nodes on walls are on either side
    assert (fluid == (depth > 0))[clear].all() and (depth > 0).sum() > 10000

    # A row for each pair of a node in the fluid and one that is not, and no other: HemeLB aborts here, as it finds no
    # wall between some of them.
    expected = 0
    for cx, cy, cz in links.stencil:
        expected += (fluid[1:-1, 1:-1, 1:-1] & ~np.roll(fluid, (-cz, -cy, -cx), (0, 1, 2))[1:-1, 1:-1, 1:-1]).sum()
    assert len(links) == expected > 1000
    assert ((links.q >= 0) & (links.q <= 1)).all() and (links.counts % 2 == 1).all() and (links.flags == 0).all()

    # The patch is the one that the point of the wall lies on.
    patch = np.array(names)[mesh.groups.numbers[links.triangles]]
    assert set(patch) == {"duct/wall", "duct/inlet", "duct/outlet"}
    point = np.array((-3, -3, -1)) + spacing * (links.samples + links.q[:, None] * links.stencil[links.directions])
    on_wall = np.min([abs((a - point[:, :2]) @ n) / np.hypot(*n) for a, n in zip(square, np.array(normals))], 0)
    for name, distance in [("duct/wall", on_wall), ("duct/inlet", abs(point[:, 2])), ("duct/outlet", abs(point[:, 2] - LENGTH))]:
        assert distance[patch == name].max() < 1e-9, name
    # q by the depths of both ends.
    inlet = (patch == "duct/inlet") & (links.stencil[links.directions] == (0, 0, -1)).all(1)
    assert inlet.sum() > 100
    height = -1 + spacing * links.samples[inlet, 2]
    assert np.allclose(links.q[inlet], height / spacing, atol=1e-12)
