"""The meshes and points of the conformance set. Each case says in a line what fails there, in which kind of method, and
in most cases names a public thread in which somebody met it. Answers are computed by make.py, never written here.

`asks` names what a case asks of a method beyond a closed surface that does not meet itself and looks outwards:

    cavities     shells that look inwards
    overlaps     bodies that meet or overlap; inside is where the winding number is not 0
    open         holes: inside is where the winding number is 1/2 or more, or -1/2 or less
    no sign      an open sheet: the distance alone
    repair       faces that are doubled or look the wrong way: inside is what a person would say (`solid`)
    degenerate   faces without an area
    doubles      positions or points that floats cannot hold apart
"""

from dataclasses import dataclass

from shapes import (
    around, beside, box, cube, extrude, grid_box, joined, lattice, moved, octahedron, on_sites, rounded, scaled, single,
    singles, subdivided, tetrahedron, turned, with_faces, without,
)  # fmt: skip


@dataclass
class Case:
    name: str
    kind: str
    mesh: tuple
    points: list
    fails: str  # one line: what fails here, in which kind of method
    thread: str = ""  # https://github.com/ + this
    asks: tuple = ()
    solid: tuple = None  # the mesh that decides the sign, if it is another one


CASES = []


def case(name, kind, mesh, points, fails, thread="", asks=(), solid=None):
    asks = (asks,) if isinstance(asks, str) else asks
    if "doubles" not in asks:
        points = [singles(point) for point in points]
    CASES.append(Case(name, kind, mesh, list(dict.fromkeys(points)), fails, thread, asks, solid))


# Pseudonormals: the sign by a normal of the nearest face, edge or vertex.
NORMALS = "normals"
corner = tetrahedron((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
warp_points = [
    (2.8584, 1.8733, 1.9557), (2.7895, 1.9055, 1.8430), (1.6957, 1.7298, 2.6789), (0.125, 0.125, 0.125),
]  # fmt: skip
case("tetrahedron", NORMALS, corner, warp_points + lattice((-2, -2, -2), (3, 3, 3), 3) + around(corner, (0.25, 2.0)),
     "normals of faces are added whose closest point lies elsewhere, if their distance is nearly the least: outside "
     "becomes inside", "NVIDIA/warp/issues/1836")  # fmt: skip
case("tetrahedron-reordered", NORMALS, (corner[0], [(1, 2, 3), (3, 0, 1), (2, 0, 3), (1, 0, 2)]),
     [(2.9, 1.8, 1.9), (1.7, 2.7, 1.75), (1.9, 1.9, 2.9)] + lattice((-1, -1, -1), (2.5, 2.5, 2.5), 3) + warp_points,
     "the same with the faces in another order: the sign must not depend on it", "NVIDIA/warp/issues/1836")  # fmt: skip
obtuse = tetrahedron((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (3.0, 3.0, 0.25))
case("obtuse-tetrahedron", NORMALS, obtuse, around(obtuse, (0.0625, 1.0, 16.0)) + [(0.75, 0.75, 0.0625)],
     "dihedral angles near 0 and 180 degrees: the normal of the nearest face alone has the wrong side beside its edges",
     "llnl/axom/issues/783")  # fmt: skip
shallow = tetrahedron((0.0, 0.0, 0.0), (4.0, 0.0, 0.0), (-2.0, 0.5, 0.0), (-5.0, -0.5, 0.125))
case("skewed-tetrahedron", NORMALS, shallow, around(shallow, (0.125, 4.0)) + [(-0.5, 0.015625, 0.03125)],
     "edges whose two faces differ much in area: a sum of normals that are not of unit length has the sign of the "
     "larger face", "llnl/axom/pull/784")  # fmt: skip
needle = tetrahedron((0.0, 0.0, 0.0), (0.015625, 0.0, 0.0), (0.0, 0.015625, 0.0), (0.0, 0.0, 64.0))
case("needle", NORMALS, needle, around(needle, (0.0078125, 1.0, 100.0)) + [(2**-10, 2**-10, 32.0)],
     "a needle of 4096 to 1: three normals at its tip nearly cancel each other", "llnl/axom/pull/706")  # fmt: skip
slanted = tetrahedron((0.0, 0.0, 0.0), (0.0625, 0.0, 0.0), (0.0, 0.0625, 0.0), (40.0, 28.0, 0.5))
case("slanted-needle", NORMALS, slanted, around(slanted, (0.03125, 8.0, 1000.0)),
     "a needle along no axis, from far away: points beyond its tip are outside", "llnl/axom/issues/783")  # fmt: skip
knife = extrude([(0.0, 0.0), (8.0, -0.00390625), (8.0, 0.00390625)], 0.0, 4.0)
case("knife", NORMALS, knife, around(knife, (0.001953125, 0.5, 20.0)) + [(4.0, 0.0, 2.0)],
     "two faces meet at an angle of 0.06 degrees: the sum of their normals is 1e-3 long and lost by rounding",
     "RobotLocomotion/drake/pull/21566")  # fmt: skip
blade = tetrahedron((0.0, 0.0, 0.0), (16.0, 0.0, 0.0), (15.0, 0.125, 0.0), (8.0, 0.0625, 2.0))
case("blade", NORMALS, blade, around(blade, (0.0625, 3.0)), "acute edges between large and tiny faces",
     "llnl/axom/pull/784")  # fmt: skip
# A corner of a cube at which one side is cut into a fan of thin triangles.
fan_rim = [(1.0, n / 16, 0.0) for n in range(16)] + [(1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
fan = (
    cube()[0] + fan_rim[1:16],
    [face for face in cube()[1] if face not in ((0, 2, 3), (0, 3, 1))]
    + [(0, 2, 3)]
    + [(0, b, a) for a, b in zip([1] + list(range(8, 23)), list(range(8, 23)) + [3])],
)
# The side at x = 1 must have the fan's vertices, too.
fan = (fan[0], [face for face in fan[1] if face not in ((1, 3, 7), (1, 7, 5))]
       + [(a, b, 5) for a, b in zip([1] + list(range(8, 23)), list(range(8, 23)) + [3])] + [(5, 3, 7)])  # fmt: skip
spread = [(-0.25, -0.0625, -0.015625), (-0.0625, -0.25, -0.03125), (-0.03125, -0.03125, -1.0), (-0.5, -0.5, 0.0),
          (-1.0, -0.0078125, -0.0078125), (-0.0078125, -1.0, -0.0078125), (0.5, 0.5, 0.25), (1.5, -0.25, -0.125)]
case("fan-at-a-corner", NORMALS, fan, spread + around(fan, (0.125,), range(12, 16)),
     "a corner with a fan of 17 thin faces on one side: normals that are not weighted by angles lean towards the fan",
     "Algebraic-UG/squishy_volumes/pull/315")  # fmt: skip
# A saddle vertex: four deep notches around a spike.
star = extrude([(1.0, 1.0), (2.0, 1.25), (1.375, 1.5), (1.5, 2.0), (1.0, 1.375), (0.5, 2.0), (0.625, 1.5), (0.0, 1.25)],
               0.0, 0.25)  # fmt: skip
case("star", NORMALS, star, around(star, (0.0625, 0.5)) + [(1.0, 1.1875, 0.125), (1.0, 1.75, 0.125)],
     "concave edges: the nearest face is seen from behind its neighbour", "MeshInspector/MeshLib/pull/4549")  # fmt: skip

# Rays: the sign by the parity of crossings, or by their directions.
RAYS = "rays"
unit = cube()
axis_points = [p for a in (-1.0, 0.5, 2.0) for b in (0.0, 0.5, 1.0) for c in (0.0, 1.0, 0.25)
               for p in ((a, b, c), (b, a, c), (b, c, a))]  # fmt: skip
case("cube-axes", RAYS, unit, [(-1.0, -1.0, 0.0), (-1.0, -1.0, -1.0), (0.5, 0.5, 0.5)] + axis_points,
     "rays along the axes through corners, edges and diagonals of a cube: they are counted twice or not at all",
     "isl-org/Open3D/issues/5105")  # fmt: skip
steps = (-3.0, -1.0, -0.5, -0.0625, 0.25, 0.5, 1.0625, 1.5, 4.0)
diagonal = [tuple(p[i] + t for i in range(3)) for t in steps for p in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 1, 1))]
case("cube-diagonals", RAYS, unit, diagonal + [singles(0.25 * n - t * d for n, d in zip((0, 4, 0), (0.5773, 0.5774, 0.5775)))
                                               for t in (0.5, 1.0, 2.0)],
     "rays along (1, 1, 1) and other fixed directions that leave through a corner",
     "Oblikovati/Oblikovati/issues/1317")  # fmt: skip
case("octahedron-axes", RAYS, octahedron(), axis_points + [(0.25, 0.25, 0.25), (-2.0, 0.0, 0.0), (0.0, -0.5, 0.5)],
     "rays along the axes meet an edge or a vertex of four faces: an edge is hit three times",
     "mikedh/trimesh/issues/85")  # fmt: skip
ball = rounded(subdivided(octahedron(), 3))
case("sphere-lattice", RAYS, ball, lattice((-1.125, -1.125, -1.125), (1.125, 1.125, 1.125), 5),
     "a lattice on which whole rows pass through vertices of a sphere: stray rows of a slice",
     "isl-org/Open3D/issues/5669")  # fmt: skip
case("sphere-turned", RAYS, ([(-y, x, z) for x, y, z in ball[0]], ball[1]), lattice((-1.5, -1.0, -0.5), (1.5, 1.0, 0.5), 5),
     "the same turned by 90 degrees in a box of 3 : 2 : 1: random rays hit edges", "pyvista/pyvista/pull/8181")  # fmt: skip
outline = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)]
pocket_vertices = ([(x, y, 0.0) for x, y in outline] + [(x, y, 10.0) for x, y in outline]
                   + [(x, y, z) for z in (10.0, 6.0) for x, y in ((20.0, 20.0), (80.0, 20.0), (80.0, 80.0), (20.0, 80.0))])
pocket_faces = [(0, 2, 1), (0, 3, 2), (12, 13, 14), (12, 14, 15)]
for k in range(4):
    after = (k + 1) % 4
    pocket_faces += [(k, after, 4 + after), (k, 4 + after, 4 + k), (4 + k, 4 + after, 8 + after), (4 + k, 8 + after, 8 + k),
                     (8 + k, 8 + after, 12 + after), (8 + k, 12 + after, 12 + k)]  # fmt: skip
pocket = pocket_vertices, pocket_faces
case("pocket", RAYS, pocket, [(50, 50, 8), (50, 50, 5), (50, 50, 10), (10, 50, 8), (30, 30, 9), (90, 90, 9.5), (50, 50, 20),
                              (50, 50, -4), (20.5, 50, 8), (50, 79.5, 9.75), (100, 50, 5), (50, 50, 6), (20, 20, 12)],
     "a face with a hole counts as crossed within the hole: the pocket of a plate is inside",
     "andymai/brepkit/issues/1525")  # fmt: skip
far_box = box((-0.5, -0.25, -2.5), (2.0, 2.0, 1.5))
case("ray-of-limited-length", RAYS, far_box,
     [singles((-2.339783, -1.976354, -3.724050)), (-2.5, -2.0, -4.0), (-6.0, -5.0, -7.0), (4.0, 4.0, 3.0), (0.5, 0.5, 0.5),
      (-30.0, -25.0, -28.0), (-1.0, -1.0, -3.0)],
     "a ray as long as the body ends within it, if it begins far outside: one crossing",
     "LTplus-AG/ifc-lite/pull/3356")  # fmt: skip
stack = joined(*[box((n / 8, 0.0, 0.0), (n / 8 + 0.0625, 1.0, 1.0)) for n in range(12)])
case("many-plates-on-a-ray", RAYS, stack, [(x / 32, 0.5, z) for x in (-4, 1, 3, 17, 19, 30, 45, 47, 60) for z in (0.5, 0.25)]
     + [(0.65625, -0.5, 0.5), (0.65625, 0.5, 2.0)],
     "hits of a ray in the order of a tree, not of the distance: near ones are dropped as equal, and the parity is lost",
     "facebookresearch/momentum/pull/1035")  # fmt: skip
case("coplanar-outside", RAYS, cube(2.0), [(3.0, 2.0, 2.0), (3.0, 1.0, 2.0), (-1.0, 0.0, 0.0), (1.0, -0.5, 2.0), (2.5, 0.0, 1.0),
                                          (1.0, 1.0, 2.5), (1.0, 1.0, 1.0), (2.0, 3.0, 2.0), (4.0, 4.0, 2.0)],
     "points in the plane of a face and beside it: the sign of a product that is 0", "mikedh/trimesh/issues/73")  # fmt: skip
million = 1048576.0
slab_box = box((million, -million, 0.0), (million + 4.0, 4.0 - million, 4.0))
case("rays-at-large-coordinates", RAYS, slab_box,
     [(million + x, y - million, z) for x in (-1.0, 0.0, 2.0, 4.0, 5.0) for y in (0.0, 2.0, 4.0, 5.0) for z in (0.0, 2.0)],
     "rays that start on the side of a box of the tree, at large coordinates: the box is missed",
     "NVIDIA/warp/issues/1530")  # fmt: skip
chain = joined(*[octahedron(1.0, (2.0 * n, 0.0, 0.0)) for n in range(4)])
case("chain-of-vertices", RAYS, chain, [(-3, 0, 0), (0.5, 0, 0), (2.5, 0, 0), (1, 0.25, 0), (3, 0, 0.5), (8, 0, 0), (6.25, 0.125, 0),
                                       (4, 0, 0), (5, 1, 0), (1, 0, 2)],
     "bodies that touch in vertices on one row: a ray through all of them meets vertices only",
     "dimforge/parry/issues/171", "overlaps")  # fmt: skip
stairs = extrude([(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (3.0, 1.0), (3.0, 2.0), (2.0, 2.0), (2.0, 3.0), (1.0, 3.0), (1.0, 4.0),
                  (0.0, 4.0)], 0.0, 2.0)  # fmt: skip
case("stairs", RAYS, stairs, lattice((-1, -1, 0), (5, 5, 2), 4) + [(3.5, 1.5, 1), (2.5, 2.5, 1), (2.5, 1.5, 1), (1.5, 3.5, 2)],
     "steps whose edges lie on rows of a lattice", "mikedh/trimesh/issues/242")  # fmt: skip

# Shells within shells.
CAVITIES = "cavities"
hollow = joined(box((-0.5,) * 3, (0.5,) * 3), turned(box((-0.0625,) * 3, (0.0625,) * 3)))
case("cavity", CAVITIES, hollow, [(0, 0, 0), (0.25, 0, 0), (0.03125, 0, 0), (0.0625, 0, 0), (0.09375, 0, 0), (0.5, 0, 0), (0.75, 0, 0),
                                 (0.03125, 0.03125, -0.03125), (0, 0, -0.25), (0.46875, 0.46875, 0.46875), (2, 2, 2)],
     "a box less a small box at its middle: the cavity is inside", "mikedh/trimesh/issues/2534", "cavities")  # fmt: skip
nested = joined(*[turned(box((-s,) * 3, (s,) * 3)) if n % 2 else box((-s,) * 3, (s,) * 3) for n, s in enumerate((8.0, 6.0, 4.0, 2.0))])
case("nested-shells", CAVITIES, nested, [(x, y, 0) for x in (0, 1, 3, 5, 7, 9) for y in (0, 0.5)] + [(2, 2, 2), (5, 5, -5), (7, 7, 7), (3, -3, 3)],
     "four shells in turn: only the outermost one is seen by a flood from outside",
     "AcademySoftwareFoundation/openvdb/issues/111", "cavities")  # fmt: skip
case("body-within-a-cavity", CAVITIES, joined(cube(8.0), turned(cube(6.0, (1.0, 1.0, 1.0))), octahedron(1.0, (4.0, 4.0, 4.0))),
     [(4, 4, 4), (4, 4, 4.5), (4, 4, 5.5), (2, 2, 2), (0.5, 4, 4), (-1, 4, 4), (4.5, 4.5, 4.5), (7.5, 7.5, 7.5), (6, 4, 4)],
     "a body that floats in a cavity", "AcademySoftwareFoundation/openvdb/issues/111", "cavities")  # fmt: skip
case("thin-hollow-wall", CAVITIES, joined(cube(1.0), turned(box((0.0009765625,) * 3, (0.9990234375,) * 3))),
     [(0.5, 0.5, 0.5), (0.00048828125, 0.5, 0.5), (0.5, 0.99951171875, 0.5), (0.001953125, 0.5, 0.5), (-0.001, 0.5, 0.5),
      (0.25, 0.25, 0.25), (0.0009765625, 0.5, 0.25), (1.5, 1.5, 1.5)],
     "a wall of a thousandth: the two signs lie within a voxel", "AcademySoftwareFoundation/openvdb/issues/903", "cavities")  # fmt: skip
case("slanted-cavity", CAVITIES, joined(cube(2.0, (-0.5, -0.5, -0.5)), turned(scaled(corner, 0.75))),
     warp_points[3:] + lattice((-0.25, -0.25, -0.25), (1.25, 1.25, 1.25), 3) + [(0.75, 0.75, 0.0), (0.0, 0.0, 0.75), (0.1875, 0.1875, 0.0)],
     "a cavity with acute edges: its pseudonormals look into it", "", "cavities")  # fmt: skip

# Several bodies.
BODIES = "bodies"
first, second = cube(1.0), octahedron(1.5, (4.0, 0.5, 0.5))
both_points = lattice((-1, -1, -1), (6, 2, 2), 3) + [(0.5, 0.5, 0.5), (4.0, 0.5, 0.5), (1.75, 0.5, 0.5), (2.5, 0.5, 0.5), (4.5, 0.75, 0.25)]
case("in-turn-1", BODIES, first, both_points,
     "two bodies in turn, at the same points as in-turn-2: the second is looked up in the tree of the first",
     "google-deepmind/mujoco_warp/pull/1178")  # fmt: skip
case("in-turn-2", BODIES, second, both_points, "the second of the two, whose answers differ at every point",
     "google-deepmind/mujoco_warp/issues/1176")  # fmt: skip
case("two-bodies", BODIES, joined(first, second), both_points, "two bodies in one mesh, and points between them",
     "LTplus-AG/ifc-lite/pull/3356")  # fmt: skip
case("overlap", BODIES, joined(cube(2.0), cube(2.0, (1.0, 0.5, 0.25))),
     [(0.5, 0.5, 0.125), (1.5, 1.0, 1.0), (2.5, 2.0, 1.5), (1.125, 1.0, 1.0), (0.75, 1.0, 1.0), (3.5, 1, 1), (1.5, 1.5, 2.125),
      (-0.5, 1, 1), (2.0, 0.25, 0.125), (1.25, 0.625, 0.375)],
     "bodies that overlap are one; the distance is that to all faces as given, also to those within",
     "NVlabs/curobo/issues/475", "overlaps")  # fmt: skip
case("overlap-turned", BODIES, joined(cube(2.0), octahedron(1.25, (2.0, 1.0, 1.0))),
     [(1.5, 1, 1), (2.5, 1, 1), (0.25, 1, 1), (3.5, 1, 1), (2.0, 1.0, 1.0), (1.0, 1.0, 1.0), (2.0, 2.0, 1.0), (2.0, 2.125, 1.0),
      (1.9375, 1.5, 1.25)],
     "the parity of crossings is even where two bodies overlap", "libigl/libigl/issues/2562", "overlaps")  # fmt: skip
case("filled-shell", BODIES, joined(cube(4.0), cube(2.0, (1.0, 1.0, 1.0))), [(2, 2, 2), (0.5, 2, 2), (1.5, 2, 2), (5, 2, 2), (1, 0.5, 2)],
     "a body within a body that looks the same way: wound twice, and inside", "LTplus-AG/ifc-lite/pull/1802", "overlaps")  # fmt: skip
case("shared-face", BODIES, joined(cube(1.0), cube(1.0, (1.0, 0.0, 0.0))),
     [(0.5, 0.5, 0.5), (0.875, 0.5, 0.5), (1.125, 0.25, 0.75), (1.5, 0.5, 0.5), (2.25, 0.5, 0.5), (1.0, 1.25, 0.5), (1.0, 0.5, -0.5),
      (-0.25, 0.25, 0.25), (1.0, 1.5, 1.5)],
     "two boxes that touch: the faces between them coincide and look at each other", "libigl/libigl/issues/644", "overlaps")  # fmt: skip
case("shared-edge", BODIES, joined(cube(1.0), cube(1.0, (1.0, 1.0, 0.0))),
     [(0.5, 0.5, 0.5), (1.5, 1.5, 0.5), (1.25, 0.75, 0.5), (0.75, 1.25, 0.5), (1.0, 1.0, 1.5), (0.9375, 0.9375, 0.5), (1.0625, 1.0625, 0.5),
      (1.0, 1.0, 0.5), (1.125, 0.9375, 1.25), (2.5, 0.0, 0.5)],
     "four faces at an edge: their normals cancel", "", "overlaps")  # fmt: skip
case("shared-vertex", BODIES, joined(cube(1.0), cube(1.0, (1.0, 1.0, 1.0))),
     [(0.5, 0.5, 0.5), (1.5, 1.5, 1.5), (1.25, 0.875, 0.875), (0.75, 1.125, 1.125), (0.9375, 0.9375, 0.9375), (1.0625, 1.0625, 1.0625),
      (1.0, 1.0, 1.0), (1.25, 0.75, 1.25), (0.75, 0.75, 1.25)],
     "two bodies touch in a vertex: it has no normal of its own", "", "overlaps")  # fmt: skip

# Points on the surface and just beside it.
SURFACE = "surface"
tiny = single(1e-6)
case("cube-surface", SURFACE, unit, [(0.0, 0.5, 0.5), (tiny, 0.5, 0.5), (-tiny, 0.5, 0.5)] + on_sites(unit)[:24] + beside(on_sites(unit)[:24], tiny),
     "on faces, edges and vertices the distance is 0, not a number close to it and not NaN; 1e-6 beside them it has a sign",
     "libigl/libigl/issues/1204")  # fmt: skip
case("tetrahedron-surface", SURFACE, corner, on_sites(corner) + beside(on_sites(corner), tiny),
     "the same on a slanted face", "su2code/SU2/pull/2484")  # fmt: skip
case("obtuse-surface", SURFACE, obtuse, on_sites(obtuse) + beside(on_sites(obtuse), single(1e-4)) + beside(on_sites(obtuse)[:6], tiny),
     "the same beside dihedral angles near 0 and 180 degrees", "llnl/axom/issues/783")  # fmt: skip
last_place = [(0.5, 0.5, 2.0**-60), (0.5, 0.5, -(2.0**-60)), (0.25, 0.75, 1 + 2.0**-52), (0.25, 0.75, 1 - 2.0**-53), (2.0**-300, 0.5, 0.5),
              (-(2.0**-300), 0.5, 0.5), (0.5, 1 + 2.0**-52, 0.5), (0.5, 1 - 2.0**-53, 0.5), (1 + 2.0**-52, 1 + 2.0**-52, 0.5),
              (1 - 2.0**-53, 1 - 2.0**-53, 0.5), (2.0**-60, 2.0**-60, 2.0**-60), (-(2.0**-60), 2.0**-60, 2.0**-60)]
case("last-place", SURFACE, unit, last_place, "a last place beside faces, edges and a vertex: the sign is decided by exact predicates only",
     "", "doubles")  # fmt: skip
tilted = scaled(tetrahedron((0.0, 0.0, 0.0), (3.0, 1.0, 0.0), (1.0, 3.0, 0.0), (1.0, 1.0, 2.0)), 1.0)
plane_points = [(1.25 + dx, 1.25, 0.0 + dz) for dx in (0.0, 0.125) for dz in (2.0**-50, -(2.0**-50), 0.0)]
plane_points += [(1.5 * (1 + s * 2.0**-52), 0.5, 0.0) for s in (0, 1, -1)] + [(2.0, 2.0 + s * 2.0**-50, 2.0**-52) for s in (0, 1, -1)]
case("last-place-of-an-edge", SURFACE, tilted, plane_points, "the same at edges along no axis", "", "doubles")  # fmt: skip

# Far points.
FAR = "far"
directions = [(1, 0, 0), (-1, -1, 0), (1, 1, 1), (0, -2, 1), (-3, 1, 2)]
case("cube-far", FAR, unit, [tuple(0.5 + far * x for x in d) for far in (1e3, 1.5e5, 1e6) for d in directions],
     "distances above 1e5 are taken for none found", "zarquon42b/Rvcg/issues/10")  # fmt: skip
case("cube-very-far", FAR, unit, [tuple(far * x for x in d) for far in (1e9, 1e11) for d in directions],
     "a body far away is a point, but it has an outside", "zarquon42b/Rvcg/issues/10", "doubles")  # fmt: skip
case("tetrahedron-far", FAR, corner, [tuple(far * x for x in d) for far in (64.0, 4096.0) for d in
                                      [(1, 1, -1), (1, -1, 1), (-1, 1, 1), (1, 1, 1), (-1, -1, -1), (2, 2, -1), (1, -0.5, 0), (0, 0, 1)]],
     "far from an edge, in the plane between its faces", "NVIDIA/warp/issues/1836")  # fmt: skip
tiny_triangle = [singles((10.67399979, 8.61225986, 0.77146602)), singles((10.67269993, 8.61141968, 0.77197701)),
                 singles((10.67399979, 8.61225986, 0.77197701))]
case("small-triangle", FAR, (tiny_triangle, [(0, 1, 2)]), [(5, 5, 5), (10.5, 8.5, 0.75), (10.6730, 8.6119, 0.7719), (100, -30, 2), (10.674, 8.612, 0.5)],
     "a triangle of a thousandth, with an area of 4e-7: taken for one without an area, and its distance is too small",
     "facebookresearch/pytorch3d/issues/698", "no sign")  # fmt: skip

# Gradients and closest points.
GRADIENTS = "gradients"
case("gradients", GRADIENTS, unit, [(1.25, 0.5, 0.5), (-0.25, 0.5, 0.5), (0.875, 0.5, 0.4375), (0.125, 0.375, 0.5), (1.25, 1.25, 0.5),
                                   (1.25, 1.5, 1.75), (-0.5, -0.25, -0.125), (0.5, 0.0625, 0.5), (0.5, 0.5, 1.0625), (3, 0.25, 0.5)],
     "the gradient points away from the body outside and, from inside, to the surface: the sign is left out of one of them",
     "NVlabs/curobo/pull/701")  # fmt: skip
case("equal-distances", GRADIENTS, unit, [(0.5, 0.5, 0.5), (0.25, 0.25, 0.5), (0.25, 0.25, 0.25), (0.75, 0.75, 0.75), (0.5, 0.5, 0.25)],
     "several closest points: one of them, not their mean", "NVlabs/curobo/pull/701")  # fmt: skip
bend = extrude([(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (1.0, 1.0), (1.0, 4.0), (0.0, 4.0)], 0.0, 1.0)
case("bend", GRADIENTS, bend, [(2, 2, 0.5), (1.25, 1.25, 0.5), (3, 1.5, 0.5), (0.75, 0.75, 0.5), (0.5, 0.5, 0.5), (0.25, 3, 0.5), (1.5, 3.0, 0.5),
                              (1.0625, 1.125, 0.5), (0.9375, 0.875, 0.5), (2.5, 2.5, 1.5)],
     "beside a concave edge two faces are equally near outside", "python-microscopy/python-microscopy/pull/1109")  # fmt: skip

# Thin parts.
THIN = "thin"
plate = box((0.0, 0.0, 0.0), (4.0, 4.0, 0.0625))
case("plate-on-samples", THIN, plate, [(x, y, z) for x in (1.0, 2.0) for y in (2.0, 4.0) for z in (-1.0, 0.0, 0.03125, 0.0625, 1.0)],
     "a plate thinner than a voxel whose sides lie on samples", "AMReX-Codes/amrex/issues/5389")  # fmt: skip
thin = box((0.0, 0.0, 0.0), (1.0, 1.0, 2.0**-20))
case("plate-of-a-millionth", THIN, thin, [(x, y, z) for x, y in ((0.5, 0.25), (0.375, 0.5)) for z in (2.0**-21, 2.0**-22, -(2.0**-22), 2.0**-20 + 2.0**-22, 0.5, -0.5)]
     + [(-(2.0**-10), 0.5, 2.0**-21), (1.5, 1.5, 2.0**-21)],
     "a plate of a millionth: both sides are within the rounding of many boxes", "AcademySoftwareFoundation/openvdb/issues/903")  # fmt: skip
slope = extrude([(0.0, 0.0), (8.0, 8.0), (8.0, 9.0), (0.0, 1.0)], 0.0, 8.0)
case("plate-on-a-diagonal", THIN, slope, lattice((1, 0, 2), (7, 9, 6), 4) + [(4.0, 4.5, 4.0), (4.5, 4.0, 4.0), (2.0, 2.5, 1.0), (6.5, 7.0, 3.0)],
     "a plate along (1, 1, 0) whose sides are a voxel apart: a table of neighbours with a wrong entry",
     "AcademySoftwareFoundation/openvdb/pull/2306")  # fmt: skip
slit = joined(box((0.0, 0.0, 0.0), (4.0, 4.0, 1.0)), box((0.0, 0.0, 1.00390625), (4.0, 4.0, 2.0)))
case("slit", THIN, slit, [(2, 2, z) for z in (0.5, 0.99, 1.001953125, 1.0009765625, 1.5, 2.5)] + [(4.5, 2, 1.001953125), (3.96875, 2, 1.001953125), (-1, 2, 1.001953125)],
     "a slit of 1/256 between two bodies is outside", "AcademySoftwareFoundation/openvdb/issues/903")  # fmt: skip

# Faces that a person would mend without a thought.
REPAIR = "repair"
inner = [(0.5, 0.5, 0.5), (0.25, 0.5, 0.125), (0.875, 0.75, 0.5), (1.25, 0.5, 0.5), (0.5, -0.5, 0.5), (1.5, 1.5, 1.5), (0.5, 0.5, -0.25),
         (0.0625, 0.0625, 0.5), (-0.0625, -0.125, 0.5)]
case("inside-out", REPAIR, turned(unit), inner, "all faces look inwards; what they enclose is inside all the same",
     "flexcompute/tidy3d/pull/1976", "repair", unit)  # fmt: skip
case("doubled-face", REPAIR, with_faces(unit, [unit[1][0], unit[1][5]]), inner, "two faces are there twice: parity and winding number are off by one behind them",
     "libigl/libigl/issues/644", "repair", unit)  # fmt: skip
case("doubled-both-ways", REPAIR, with_faces(unit, [unit[1][0][::-1], unit[1][1][::-1]]), inner, "one side is there once more, the other way round: it cancels itself",
     "libigl/libigl/issues/644", "repair", unit)  # fmt: skip
case("turned-face", REPAIR, turned(subdivided(unit, 1), (7,)), inner, "one of 48 faces looks inwards: the winding number is 1/2 off behind it",
     "pyvista/pyacvd/issues/7", "repair", subdivided(unit, 1))  # fmt: skip
case("every-face-twice", REPAIR, joined(unit, unit), inner, "a body that is there twice: every ray meets an even number of faces",
     "facebookresearch/momentum/pull/1035", "repair", unit)  # fmt: skip
case("both-sides", REPAIR, joined(unit, turned(unit)), inner, "every face on both sides: all winding numbers are 0", "", "repair", unit)  # fmt: skip
wall = with_faces(joined(cube(1.0), box((1.0, 0.0, 0.0), (2.0, 1.0, 1.0))), [])
wall = (wall[0], [face for n, face in enumerate(wall[1]) if n not in (20, 21)])
case("wall-between", REPAIR, wall, [(0.5, 0.5, 0.5), (1.5, 0.5, 0.5), (0.875, 0.25, 0.5), (1.125, 0.75, 0.5), (1.0, 1.5, 0.5), (2.5, 0.5, 0.5), (1, 0.5, -1)],
     "two rooms with one wall between them: edges with three faces", "wildmeshing/fTetWild/issues/69", "repair", box((0.0, 0.0, 0.0), (2.0, 1.0, 1.0)))  # fmt: skip

# Holes, and sheets.
OPEN = "open"
fine = subdivided(unit, 3)
case("hole", OPEN, without(fine, (100,)), inner[:6] + [(0.5, 0.5, 0.25), (0.125, 0.5, 0.5), (-0.125, 0.5, 0.5)],
     "one of 768 faces is missing: rays slip through, and the product of distance and winding number is no distance",
     "libigl/libigl/issues/1060", "open")  # fmt: skip
case("holes", OPEN, without(rounded(subdivided(octahedron(), 3)), range(0, 512, 64)), lattice((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5), 3) + [(0, 0, 1.5), (-2, 0, 1)],
     "holes here and there in a sphere", "mikedh/trimesh/issues/1031", "open")  # fmt: skip
square = ([(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 2.0, 0.0), (0.0, 2.0, 0.0)], [(0, 1, 2), (0, 2, 3)])
case("sheet", OPEN, square, lattice((-1, -1, -1), (3, 3, 1), 3) + [(1, 1, 2.0**-20), (1, 0.5, 0), (3, 1, 0)],
     "a sheet has no inside: the distance has no sign, and is not 0 beside its rim", "libigl/libigl-python-bindings/issues/95", "no sign")  # fmt: skip
hills = ([(float(x), float(y), ((x * x * 3 + y * 5 + x * y) % 7) / 4) for y in range(6) for x in range(6)],
         [face for y in range(5) for x in range(5) for n in (6 * y + x,) for face in ((n, n + 1, n + 7), (n, n + 7, n + 6))])
case("terrain", OPEN, hills, lattice((-1, -1, -1), (6, 6, 3), 4), "a terrain: the sign of a winding number of 1/2 flips with rounding",
     "newton-physics/newton/pull/3403", "no sign")  # fmt: skip

# Scales.
SCALES = "scales"
case("offset-of-a-million", SCALES, moved(unit, (million, 3 * million, -million)),
     [(million + x, 3 * million + y, z - million) for x in (-1.0, 0.25, 0.5, 2.0) for y in (0.25, 1.0, 2.5) for z in (0.5, 1.25)],
     "coordinates of a million: floats hold the positions, but not their differences times each other",
     "LTplus-AG/ifc-lite/issues/4934", "doubles")  # fmt: skip
case("tetrahedron-at-a-million", SCALES, moved(scaled(obtuse, 4.0), (-million, million, 16.0)),
     [tuple(x + y for x, y in zip(p, (-million, million, 16.0))) for p in around(scaled(obtuse, 4.0), (0.25, 2.0))],
     "the same beside slanted faces", "tudelft3d/masbcpp/issues/1", "doubles")  # fmt: skip
nano = 2.0**-30
case("nanometres", SCALES, scaled(unit, nano), [tuple(nano * x for x in p) for p in inner + on_sites(unit)[:8]],
     "a body of 1e-9: squares of its sides are 1e-18, its areas squared 1e-36, below fixed tolerances", "", ())  # fmt: skip
case("nanometre-needle", SCALES, scaled(slanted, nano), [tuple(nano * x for x in p) for p in around(slanted, (0.03125, 8.0))],
     "a needle of that size: every face has less area than a fixed tolerance", "llnl/axom/pull/706", ())  # fmt: skip
case("gigametres", SCALES, scaled(obtuse, 2.0**30), [tuple(2.0**30 * x for x in p) for p in around(obtuse, (0.0625, 1.0))],
     "a body of 1e9: squares of areas are 1e36, near the end of floats", "", ())  # fmt: skip
case("ribbon", SCALES, box((0.0, 0.0, 0.0), (1024.0, 1.0, 0.0009765625)),
     [(512, 0.5, 0.00048828125), (512, 0.25, 1), (512, 2, 0), (-1, 0.5, 0), (1023.5, 0.5, 0.000244140625), (1025, 1.5, 0.5), (3, 0.5, -0.00048828125)],
     "sides of a million to one", "AcademySoftwareFoundation/openvdb/issues/903")  # fmt: skip

# Faces without an area.
DEGENERATE = "degenerate"
edge_middle = (unit[0] + [(0.5, 0.0, 0.0), (0.25, 0.0, 0.0)],
               [f for f in unit[1] if f != (0, 1, 5)] + [(0, 9, 5), (9, 8, 5), (8, 1, 5), (0, 1, 8), (0, 8, 9)])
case("needles-without-area", DEGENERATE, edge_middle, inner + [(0.5, -0.25, -0.25), (0.25, 0.0, -0.125), (0.375, 0.0, 0.0), (0.75, -tiny, -tiny)],
     "faces of three vertices on one line at an edge: normals are NaN, and so is what they are added to",
     "libigl/libigl/issues/905", "degenerate")  # fmt: skip
repeated = with_faces((unit[0] + [(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)], unit[1]), [(0, 0, 1), (3, 3, 3), (0, 8, 2), (7, 9, 7)])
case("repeated-vertices", DEGENERATE, repeated, inner, "faces that repeat a vertex, by its number or its place", "unibas-gravis/scalismo/issues/262", "degenerate")  # fmt: skip
parry = [singles((2.27699995, -7.9000001, 16.3180008)), singles((-0.569999993, -8.10000038, 16.6070004))]
case("segment", DEGENERATE, (parry + [parry[1]], [(0, 1, 2)]), [(1.10000002, -7.9000001, 16.5879993), (0, 0, 0), (-3, -8, 17), (5, -8, 16)],
     "a triangle that is a segment: the distance is 0 within its box", "dimforge/parry/issues/76", ("degenerate", "no sign"))  # fmt: skip
sliver_at = 2.0**-24
sliver = tetrahedron((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.5, sliver_at, 0.0), (0.5, sliver_at / 2, 1.0))
case("slivers", DEGENERATE, sliver, around(sliver, (0.25,)) + [(0.5, sliver_at / 4, 0.25), (0.5, sliver_at / 4, 0.5)],
     "faces of 6e-8 by 1: barycentric coordinates divide by an area squared of 1e-15", "optimad/bitpit/issues/355", "doubles")  # fmt: skip

# Many faces, whose answers are known without them.
LARGE = "large"
case("box-of-4800-faces", LARGE, grid_box((0.0, 0.0, 0.0), (2.5, 1.25, 5.0), 20),
     lattice((-0.5, -0.375, -1), (3, 1.5, 6), 3) + [(1.25, 0.625, 2.5), (0.0625, 0.625, 2.5), (2.5, 1.25, 5.0), (1.25, 1.25, 2.5), (2.4375, 1.1875, 4.9375)],
     "a large flat mesh: many faces share the nearest vertex, and a tree cuts off the right one", "")  # fmt: skip
