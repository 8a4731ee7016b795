"""Distances at points by libraries from PyPI, beside those of "clsdf query": scripts/peers-points.

A row is the median of some calls, each for all points, after one that warms up; those of clsdf are by "clsdf bench
points --points". point-cloud-utils and libigl set up their trees in each call; the set-up of clsdf is that of the first
call, by "clsdf query". fcpw gives no sign. A voxel is 1/256 of the mesh's longest side.

The errors of the libraries are those against the results of "clsdf query". The errors of clsdf are those against its own
reference, at 20,000 of the points.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile
import time

import fcpw
import igl
import numpy
import point_cloud_utils


def read_off(path):
    words = pathlib.Path(path).read_text().split("\n", 1)[1].split()
    vertices, faces = int(words[0]), int(words[1])
    numbers = numpy.array(words[3:3 + 3 * vertices + 4 * faces], dtype=float)
    triangles = numbers[3 * vertices:].reshape(faces, 4)
    if (triangles[:, 0] != 3).any():
        raise SystemExit(f"{path} has a face that is no triangle")
    return numbers[:3 * vertices].reshape(vertices, 3), triangles[:, 1:].astype(numpy.int64)


def points_of(kind, vertices, triangles, count, random):
    """The kinds of "clsdf bench points", from another generator."""
    lower, upper = vertices.min(0), vertices.max(0)
    side = (upper - lower).max()
    if kind == "uniform":
        return random.uniform(lower - 0.1 * side, upper + 0.1 * side, (count, 3))
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(triangles), count, p=area / area.sum())
    u, v = random.random((2, count, 1))
    u, v = numpy.where(u + v > 1, 1 - u, u), numpy.where(u + v > 1, 1 - v, v)
    on_surface = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    return on_surface + random.uniform(-0.012 * side, 0.012 * side, (count, 3))


def fcpw_query(vertices, triangles):
    begin = time.perf_counter()
    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(numpy.asfortranarray(vertices, dtype=numpy.float32), 0)
    scene.set_object_triangles(numpy.asfortranarray(triangles, dtype=numpy.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)
    set_up = time.perf_counter() - begin

    def query(points):
        found = fcpw.interaction_3D_list()
        limits = numpy.full(len(points), numpy.inf, dtype=numpy.float32)
        scene.find_closest_points(numpy.asfortranarray(points, dtype=numpy.float32), limits, found)
        return found

    return query, lambda found: numpy.array([one.d for one in found], dtype=float), False, set_up


def pcu_query(vertices, triangles):
    return (lambda points: point_cloud_utils.signed_distance_to_mesh(points, vertices, triangles),
            lambda result: numpy.asarray(result[0], dtype=float), True, None)


def igl_query(vertices, triangles):
    sign = igl.SignedDistanceType.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    return (lambda points: igl.signed_distance(points, vertices, triangles, sign),
            lambda result: numpy.asarray(result[0], dtype=float), True, None)


def measured(call, repetitions):
    seconds = []
    for _ in range(repetitions + 1):
        begin = time.perf_counter()
        result = call()
        seconds.append(time.perf_counter() - begin)
    return float(numpy.median(seconds[1:])), result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("--command", required=True)
    parser.add_argument("--points", type=int, default=200000)
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    vertices, triangles = read_off(options.mesh)
    voxel = (vertices.max(0) - vertices.min(0)).max() / 256
    random = numpy.random.default_rng(options.seed)
    print("| points | method | set-up, ms | ms | million a second | off by over 1e-5 voxel | wrong signs "
          "| largest error, voxel |")
    print("|-|-|-:|-:|-:|-:|-:|-:|")
    for kind in ("uniform", "near"):
        points = points_of(kind, vertices, triangles, options.points, random)
        with tempfile.TemporaryDirectory() as folder:
            numpy.save(f"{folder}/points.npy", points)

            def ask_command(*arguments):
                return json.loads(subprocess.run([options.command, *arguments, "--json"], check=True,
                                                 capture_output=True).stdout)

            query = ("query", options.mesh, f"{folder}/points.npy", "-o", f"{folder}/distance.npy")
            set_ups = [ask_command(*query)["seconds"]["set_up"] for _ in range(options.repetitions + 1)][1:]
            expected = numpy.load(f"{folder}/distance.npy")["distance"].astype(float)
            rows = ask_command("bench", "points", options.mesh, "--points", f"{folder}/points.npy", "--repetitions",
                               str(options.repetitions))["rows"]
            row = next(row for row in rows if row["method"] == "clsdf")
        seconds = row["seconds"]["median"]
        print(f"| {kind} | clsdf | {1e3 * float(numpy.median(set_ups)):,.0f} | {1e3 * seconds:,.0f} "
              f"| {1e-6 * len(points) / seconds:.2f} | {row['wrong']:,} of {row['judged']:,} | {row['wrong_signs']:,} "
              f"| {row['max_error_voxels']:.1e} |", flush=True)
        for name, make in (("fcpw", fcpw_query), ("point-cloud-utils", pcu_query), ("libigl", igl_query)):
            ask, distances_of, has_sign, set_up = make(vertices, triangles)
            seconds, result = measured(lambda: ask(points), options.repetitions)
            distance = distances_of(result)
            error = numpy.abs(numpy.abs(distance) - numpy.abs(expected))
            wrong = int((~(error <= numpy.maximum(1e-5 * voxel, 3e-7 * numpy.abs(expected)))).sum())
            signs = f"{int((numpy.signbit(distance) != numpy.signbit(expected)).sum()):,}" if has_sign else "no sign"
            apart = f"{1e3 * set_up:,.0f}" if set_up else "in the call"
            print(f"| | {name} | {apart} | {1e3 * seconds:,.0f} | {1e-6 * len(points) / seconds:.2f} | {wrong:,} "
                  f"| {signs} | {numpy.nanmax(error) / voxel:.1e} |", flush=True)


main()
