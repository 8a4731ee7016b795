"""Distances by Python packages from PyPI beside those of clsdf's: scripts/python-peers.

All get the same points and the same samples of a grid, of which each is one call; grids of the peers are points, as they
have no grids. A time is the median of some calls after one that warms up; "set-up" is what a package does once a mesh.
Errors are those against libigl's distances in double with the sign of its winding number, which is why libigl's own row
has its default sign. A voxel is 1/256 of the mesh's longest side. fcpw has no sign, and its wheel is built without vector
instructions.
"""

import argparse
import importlib.metadata
import time

import clsdf
import fcpw
import igl
import numpy
import open3d
import point_cloud_utils
import trimesh


def points_of(kind, vertices, faces, count, random):
    lower, upper = vertices.min(0), vertices.max(0)
    side = (upper - lower).max()
    if kind == "uniform":
        return random.uniform(lower - 0.1 * side, upper + 0.1 * side, (count, 3))
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(faces), count, p=area / area.sum())
    u, v = random.random((2, count, 1))
    u, v = numpy.where(u + v > 1, 1 - u, u), numpy.where(u + v > 1, 1 - v, v)
    on_surface = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    return on_surface + random.uniform(-0.012 * side, 0.012 * side, (count, 3))


# Each makes a function of points that returns the signed distances, negative inside, and says whether they have a sign.
def by_clsdf(vertices, faces):
    body = clsdf.Transform((vertices, faces))
    return lambda points: body.query(points).distance, True


def by_trimesh(vertices, faces):
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    return lambda points: -trimesh.proximity.signed_distance(mesh, points), True


def by_libigl(vertices, faces):
    return lambda points: igl.signed_distance(points, vertices, faces)[0], True


def by_open3d(vertices, faces):
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(vertices.astype(numpy.float32), faces.astype(numpy.uint32))
    return lambda points: scene.compute_signed_distance(points.astype(numpy.float32)).numpy(), True


def by_point_cloud_utils(vertices, faces):
    return lambda points: point_cloud_utils.signed_distance_to_mesh(points, vertices, faces)[0], True


def by_fcpw(vertices, faces):
    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(numpy.asfortranarray(vertices, dtype=numpy.float32), 0)
    scene.set_object_triangles(numpy.asfortranarray(faces, dtype=numpy.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)

    def query(points):
        found = fcpw.interaction_3D_list()
        limits = numpy.full(len(points), numpy.inf, dtype=numpy.float32)
        scene.find_closest_points(numpy.asfortranarray(points, dtype=numpy.float32), limits, found)
        return numpy.array([one.d for one in found])

    return query, False


PACKAGES = {
    "clsdf": by_clsdf,
    "trimesh": by_trimesh,
    "libigl": by_libigl,
    "open3d": by_open3d,
    "point-cloud-utils": by_point_cloud_utils,
    "fcpw": by_fcpw,
}


def median_seconds(call, repetitions):
    call()
    seconds = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        result = call()
        seconds.append(time.perf_counter() - begin)
    return float(numpy.median(seconds)), result


def row(name, what, set_up, seconds, distance, truth, voxel, has_sign):
    error = numpy.abs(numpy.abs(distance.astype(float)) - numpy.abs(truth)) / voxel
    # On the surface there is no sign.
    beside = numpy.abs(truth) > 1e-6 * voxel
    wrong = int((numpy.signbit(distance) != numpy.signbit(truth))[beside].sum()) if has_sign else "no sign"
    version = importlib.metadata.version(name)
    print(
        f"| {what} | {name} {version} | {1e3 * set_up:,.0f} | {1e3 * seconds:,.1f} | {1e-6 * truth.size / seconds:.3f} "
        f"| {wrong} | {numpy.nanmax(error):.1e} |",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh", help="a file, or the name of a shape, as sphere6")
    parser.add_argument("--points", type=int, default=20_000)
    parser.add_argument("--resolution", type=int, default=32, help="samples on the longest side of the grid")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--packages", nargs="+", choices=PACKAGES, default=list(PACKAGES))
    options = parser.parse_args()
    vertices, faces = (clsdf.read_mesh if "." in options.mesh else clsdf.make_shape)(options.mesh)
    faces = faces.astype(numpy.int64)
    voxel = (vertices.max(0) - vertices.min(0)).max() / 256
    random = numpy.random.default_rng(options.seed)
    body = clsdf.Transform((vertices, faces))
    grid = body.grid(options.resolution, margin="5%")
    x, y, z = numpy.meshgrid(*(range(side) for side in grid.size), indexing="ij")
    samples = numpy.array(grid.origin) + numpy.stack([x, y, z], -1).transpose(2, 1, 0, 3) * grid.spacing
    places = {
        "uniform": points_of("uniform", vertices, faces, options.points, random),
        "near": points_of("near", vertices, faces, options.points, random),
        f"grid of {len(samples.reshape(-1, 3)):,}": samples.reshape(-1, 3),
    }
    print("| points | package | set-up, ms | ms | million a second | wrong signs | largest error, voxel |")
    print("|-|-|-:|-:|-:|-:|-:|")
    for what, points in places.items():
        truth = igl.signed_distance(
            points, vertices, faces, igl.SignedDistanceType.SIGNED_DISTANCE_TYPE_WINDING_NUMBER
        )[0]
        if what.startswith("grid"):
            seconds, field = median_seconds(lambda: body.field(grid, band="full"), options.repetitions)
            row("clsdf", what + ", field()", 0, seconds, field.distance.reshape(-1), truth, voxel, True)
        for name in options.packages:
            begin = time.perf_counter()
            query, has_sign = PACKAGES[name](vertices, faces)
            query(points[:1])
            set_up = time.perf_counter() - begin
            seconds, distance = median_seconds(lambda: query(points), options.repetitions)
            row(name, what, set_up, seconds, distance, truth, voxel, has_sign)
    one = points[:1].copy()
    query, _ = by_clsdf(vertices, faces)
    seconds, _ = median_seconds(lambda: [query(one) for _ in range(10_000)], options.repetitions)
    print(f"\nA query of one point by clsdf takes {100 * seconds:.2f} microseconds.")


main()
