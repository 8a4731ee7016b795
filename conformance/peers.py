#!/usr/bin/env python3
"""Runs other programs over the conformance set and prints the table of docs/conformance.md: scripts/conformance --peers.

    peers.py --folder FOLDER [--seconds N] [--command CLSDF] [NAME ...]

FOLDER gets the virtual environment with the packages of `requirements` below, the set, and the results. Each program runs
in a process of its own. A process that ends by a signal or hangs costs the case that it was at; the rest goes on in a new
one. A program is used as its documentation says, with its strongest sign, at exactly the points of the set.
"""

import argparse
import datetime
import importlib.metadata
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE))

# What is installed for the programs; python3-openvdb is Debian's. pysdf is compiled, with Eigen's headers: by hand, if at all.
requirements = """numpy==2.4.6 trimesh==5.2.0 rtree==1.4.1 scipy embreex==4.4.0.post1 libigl==2.6.3 open3d==0.20.0
point-cloud-utils==0.34.0 fcpw==1.2.0 nanobind-backend vtk==9.7.1 warp-lang==1.19.0 cgal==6.0.1.post202410241521
pymeshlab==2025.7.post1 gpytoolbox==0.3.8 drake==1.51.1""".split()

SIDE = 64  # voxels of OpenVDB on the longest side


# Each takes vertices (n, 3) and faces (m, 3) and returns a function of points (k, 3), whose result is the signed distance,
# negative inside. They import their package only when they run.


def trimesh_signed_distance(vertices, faces):
    import trimesh

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    return lambda points: -trimesh.proximity.signed_distance(mesh, points)


def igl_by(sign):
    def prepare(vertices, faces):
        import igl

        kind = getattr(igl.SignedDistanceType, "SIGNED_DISTANCE_TYPE_" + sign)
        return lambda points: igl.signed_distance(points, vertices, faces, kind)[0]

    return prepare


def open3d_scene(vertices, faces):
    import numpy
    import open3d

    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(vertices.astype(numpy.float32), faces.astype(numpy.uint32))
    return lambda points: scene.compute_signed_distance(points.astype(numpy.float32), nsamples=11).numpy()


def point_cloud_utils_distance(vertices, faces):
    import point_cloud_utils

    return lambda points: point_cloud_utils.signed_distance_to_mesh(points, vertices, faces)[0]


def fcpw_scene(vertices, faces):
    import fcpw
    import numpy

    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(numpy.asfortranarray(vertices, dtype=numpy.float32), 0)
    scene.set_object_triangles(numpy.asfortranarray(faces, dtype=numpy.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)

    def query(points):
        places = numpy.asfortranarray(points, dtype=numpy.float32)
        found = fcpw.interaction_3D_list()
        scene.find_closest_points(places, numpy.full(len(points), numpy.inf, dtype=numpy.float32), found)
        inside = numpy.array([scene.contains(numpy.ascontiguousarray(place)) for place in places])
        return numpy.where(inside, -1, 1) * numpy.array([one.d for one in found])

    return query


def vtk_function(vertices, faces):
    import numpy
    import vtk
    from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

    places = vtk.vtkPoints()
    places.SetData(numpy_to_vtk(numpy.ascontiguousarray(vertices), deep=True))
    cells = vtk.vtkCellArray()
    rows = numpy.hstack([numpy.full((len(faces), 1), 3), faces]).astype(numpy.int64)
    cells.SetCells(len(faces), numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
    surface = vtk.vtkPolyData()
    surface.SetPoints(places)
    surface.SetPolys(cells)
    function = vtk.vtkImplicitPolyDataDistance()
    function.SetInput(surface)
    return lambda points: numpy.array([function.EvaluateFunction(point) for point in points])


def pysdf_function(vertices, faces):
    import numpy
    import pysdf

    function = pysdf.SDF(vertices.astype(numpy.float32), faces.astype(numpy.uint32))
    return lambda points: -function(points.astype(numpy.float32))


def cgal_side(vertices, faces):
    import numpy
    from CGAL import CGAL_AABB_tree, CGAL_Kernel, CGAL_Polygon_mesh_processing, CGAL_Polyhedron_3

    soup = CGAL_Polygon_mesh_processing.Point_3_Vector()
    for vertex in vertices:
        soup.append(CGAL_Kernel.Point_3(*map(float, vertex)))
    polygons = CGAL_Polygon_mesh_processing.Polygon_Vector()
    for face in faces:
        polygon = CGAL_Polygon_mesh_processing.Int_Vector()
        for corner in face:
            polygon.append(int(corner))
        polygons.append(polygon)
    body = CGAL_Polyhedron_3.Polyhedron_3()
    CGAL_Polygon_mesh_processing.polygon_soup_to_polygon_mesh(soup, polygons, body)
    if body.size_of_facets() != len(faces):
        raise RuntimeError("the faces are no polyhedron: edges with more than two faces, or faces that repeat a vertex")
    if not body.is_closed():
        raise RuntimeError("Side_of_triangle_mesh needs a closed mesh")
    corners = [CGAL_Kernel.Point_3(*map(float, vertex)) for vertex in vertices]
    triangles = [CGAL_Kernel.Triangle_3(corners[a], corners[b], corners[c]) for a, b, c in faces]
    tree = CGAL_AABB_tree.AABB_tree_Triangle_3_soup(triangles)
    side = CGAL_Polygon_mesh_processing.Side_of_triangle_mesh(body)

    def query(points):
        found = []
        for point in points:
            place = CGAL_Kernel.Point_3(*map(float, point))
            inside = side.bounded_side(place) == CGAL_Kernel.ON_BOUNDED_SIDE
            found.append((-1 if inside else 1) * tree.squared_distance(place) ** 0.5)
        return numpy.array(found)

    query.keep = triangles, body
    return query


def warp_by(query):
    def prepare(vertices, faces):
        import numpy
        import warp

        warp.config.quiet = True
        warp.init()
        kernel = WARP_KERNELS[query] if query in WARP_KERNELS else WARP_KERNELS.setdefault(query, warp_kernel(query))
        mesh = warp.Mesh(
            points=warp.array(vertices.astype(numpy.float32), dtype=warp.vec3, device="cpu"),
            indices=warp.array(faces.astype(numpy.int32).ravel(), dtype=int, device="cpu"),
            support_winding_number=True,
        )

        def run(points):
            places = warp.array(points.astype(numpy.float32), dtype=warp.vec3, device="cpu")
            found = warp.zeros(len(points), dtype=float, device="cpu")
            warp.launch(kernel, dim=len(points), inputs=[mesh.id, places], outputs=[found], device="cpu")
            return found.numpy()

        run.keep = mesh
        return run

    return prepare


WARP_KERNELS = {}


def warp_kernel(query):
    """Kernels are read from a file's source, so they are in one of their own."""
    import warp_kernels

    return getattr(warp_kernels, query)


def pymeshlab_filter(vertices, faces):
    import numpy
    import pymeshlab

    def query(points):
        meshes = pymeshlab.MeshSet()
        meshes.add_mesh(pymeshlab.Mesh(vertices, faces), "body")
        meshes.add_mesh(pymeshlab.Mesh(points), "points")
        meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(measuremesh=1, refmesh=0, signeddist=True)
        return numpy.array(meshes.mesh(1).vertex_scalar_array())

    return query


def gpytoolbox_distance(vertices, faces):
    import gpytoolbox

    return lambda points: gpytoolbox.signed_distance(points, vertices, faces)[0]


def drake_query(vertices, faces):
    import tempfile

    import numpy
    from pydrake.geometry import GeometryInstance, Mesh, ProximityProperties, SceneGraph
    from pydrake.math import RigidTransform

    with tempfile.NamedTemporaryFile("w", suffix=".obj", delete=False) as file:
        file.writelines(f"v {' '.join(repr(float(x)) for x in vertex)}\n" for vertex in vertices)
        file.writelines(f"f {' '.join(str(corner + 1) for corner in face)}\n" for face in faces)
    graph = SceneGraph()
    source = graph.RegisterSource("body")
    instance = GeometryInstance(RigidTransform(), Mesh(file.name), "body")
    instance.set_proximity_properties(ProximityProperties())
    graph.RegisterAnchoredGeometry(source, instance)
    pathlib.Path(file.name).unlink()
    context = graph.CreateDefaultContext()
    query_object = graph.get_query_output_port().Eval(context)

    def query(points):
        return numpy.array([query_object.ComputeSignedDistanceToPoint(point)[0].distance for point in points])

    query.keep = graph, context
    return query


def openvdb_level_set(vertices, faces):
    """A grid for each point, moved so that a voxel lies on it: the value there is that of meshToVolume, and no mean."""
    import numpy
    import pyopenvdb

    used = vertices[numpy.unique(faces)]
    voxel = float((used.max(0) - used.min(0)).max()) / SIDE
    transform = pyopenvdb.createLinearTransform(voxelSize=1.0)

    def query(points):
        found = []
        for point in points:
            moved = ((vertices - point) / voxel).astype(numpy.float32)
            grid = pyopenvdb.FloatGrid.createLevelSetFromPolygons(moved, faces.astype(numpy.uint32), transform=transform, halfWidth=3.0)
            found.append(grid.getConstAccessor().getValue((0, 0, 0)) * voxel)
        return numpy.array(found)

    return query


# name: (function, package, what is used, what it does not promise, of the words that a case `asks`)
CLOSED = ("open", "no sign", "repair")
PARITY = ("overlaps", *CLOSED)
SIMPLE = ("overlaps", "degenerate", *CLOSED)
FLOATS = ("doubles",)
PEERS = {
    "trimesh": (trimesh_signed_distance, "trimesh", "`proximity.signed_distance`, rays by embreex", PARITY + FLOATS),
    "libigl": (igl_by("WINDING_NUMBER"), "libigl", "`signed_distance`, winding number", ("repair",)),
    "libigl-pseudonormal": (igl_by("PSEUDONORMAL"), "libigl", "`signed_distance`, pseudonormals", SIMPLE),
    "open3d": (open3d_scene, "open3d", "`compute_signed_distance`, 11 rays", PARITY + FLOATS),
    "point-cloud-utils": (point_cloud_utils_distance, "point-cloud-utils", "`signed_distance_to_mesh`", ("repair",)),
    "fcpw": (fcpw_scene, "fcpw", "`find_closest_points`, `contains`", PARITY + FLOATS),
    "pysdf": (pysdf_function, "pysdf", "`SDF`", PARITY + FLOATS),
    "vtk": (vtk_function, "vtk", "`vtkImplicitPolyDataDistance`", SIMPLE),
    "cgal": (cgal_side, "cgal", "`AABB_tree_Triangle_3_soup`, `Side_of_triangle_mesh`", SIMPLE),
    "warp": (warp_by("winding_number"), "warp-lang", "`mesh_query_point_sign_winding_number`", ("repair", *FLOATS)),
    "warp-parity": (warp_by("parity"), "warp-lang", "`mesh_query_point_sign_parity`", PARITY + FLOATS),
    "warp-normal": (warp_by("normal"), "warp-lang", "`mesh_query_point_sign_normal`", SIMPLE + FLOATS),
    "pymeshlab": (pymeshlab_filter, "pymeshlab", "`compute_scalar_by_distance_...`", SIMPLE + FLOATS),
    "gpytoolbox": (gpytoolbox_distance, "gpytoolbox", "`signed_distance`", ("repair",)),
    "drake": (drake_query, "drake", "`ComputeSignedDistanceToPoint` of a `Mesh`", SIMPLE),
    "openvdb": (openvdb_level_set, "python3-openvdb", f"`createLevelSetFromPolygons`, {SIDE} voxels a side",
                ("cavities", *CLOSED, *FLOATS)),
}  # fmt: skip
ASKS = ("cavities", "overlaps", "open", "no sign", "repair", "degenerate", "doubles")


def read(folder):
    import numpy

    lines = (folder / "mesh.obj").read_text().splitlines()
    vertices = numpy.array([line.split()[1:] for line in lines if line.startswith("v ")], dtype=float)
    faces = numpy.array([line.split()[1:] for line in lines if line.startswith("f ")], dtype=int) - 1
    return vertices, faces, numpy.load(folder / "points.npy")


def work(name, cases, folder, results):
    """The process of a program: NAME.npy of each case, or NAME.refused with its words."""
    import numpy

    for case in cases:
        (results / "at").write_text(case)
        vertices, faces, points = read(folder / case)
        try:
            distance = numpy.asarray(PEERS[name][0](vertices, faces)(points), dtype=float).reshape(-1)
            if len(distance) != len(points):
                raise RuntimeError(f"{len(distance)} distances for {len(points)} points")
            numpy.save(results / (case + ".npy"), distance)
        except Exception as error:  # whatever the program says
            (results / (case + ".refused")).write_text(f"{type(error).__name__}: {error}")
    (results / "at").write_text("")


def run_peer(name, python, cases, folder, results, seconds):
    """Runs a program over all cases. Returns the cases at which its process ended or hung."""
    results.mkdir(parents=True, exist_ok=True)
    for old in results.iterdir():
        old.unlink()
    lost, left = {}, list(cases)
    while left:
        command = [python, str(HERE / "peers.py"), "--work", name, "--folder", str(folder), "--results", str(results), *left]
        (results / "at").write_text(left[0])
        try:
            with open(results / "log", "ab") as log:
                ended = subprocess.run(command, stdout=log, stderr=log, timeout=seconds).returncode
        except subprocess.TimeoutExpired:
            ended = f"longer than {seconds} s"
        at = (results / "at").read_text()
        if ended == 0 and not at:
            break
        if not at:
            break
        lost[at] = f"signal {-ended}" if isinstance(ended, int) and ended < 0 else f"{ended}"
        left = left[left.index(at) + 1 :]
    return lost


def judged(name, folder, results, lost, index):
    """The row of a program: of the cases that ask nothing further, and of the others the wrong signs by what they ask."""
    import numpy

    import judge

    row = {"worst": 0.0, "off": 0, "signs": 0, "refused": 0, "crashed": len(lost), "cases": {}}
    row.update({word: [0, 0] for word in ASKS})  # wrong signs, cases with a result
    for about in index:
        case = about["name"]
        answers, points = judge.case_of(folder / case)
        path = results / (case + ".npy")
        if case in lost:
            continue
        if not path.exists():
            row["refused"] += 1
            continue
        distance = numpy.load(path)
        side = answers["tolerance"] * 25_600_000
        right = numpy.array(answers["distance"])
        wrong = judge.judge(answers, points, distance)["wrong_signs"]
        if wrong:
            row["cases"][case] = wrong
        for word in about["asks"]:
            row[word][0] += wrong
            row[word][1] += 1
        if about["asks"]:
            continue
        row["signs"] += wrong
        # Beyond the band of OpenVDB there is the band's limit.
        in_band = right < 2.9 * side / SIDE if name == "openvdb" else numpy.ones(len(points), dtype=bool)
        error = numpy.abs(numpy.abs(distance) - right) / side
        error = numpy.where(numpy.isnan(error), numpy.inf, error)[in_band]
        if len(error):
            row["worst"] = max(row["worst"], float(error.max()))
            # What floats can do: 1e-5 of the side and 1e-6 of the coordinates.
            scale = numpy.abs(points).max(1)[in_band] / side
            row["off"] += int((error > 1e-5 + 1e-6 * scale).sum())
    return row


def version_of(python, package):
    if package.startswith("python3-"):
        return subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True).stdout
    code = f"import importlib.metadata as m; print(m.version({package!r}))"
    return subprocess.run([python, "-c", code], capture_output=True, text=True).stdout.strip()


def install(folder):
    python = folder / "venv" / "bin" / "python"
    if not (folder / "complete").exists():
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(["/usr/bin/python3", "-m", "venv", folder / "venv"], check=True)
        for requirement in requirements:
            pip = [python, "-m", "pip", "install", "-q", "--only-binary", ":all:", requirement]
            if subprocess.run(pip).returncode:
                print(f"peers.py: no {requirement}", file=sys.stderr)
        (folder / "complete").touch()
    return str(python)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="of a program, or of cases with --work")
    parser.add_argument("--folder", type=pathlib.Path, required=True)
    parser.add_argument("--kept", action="store_true", help="judge the results of the last run again")
    parser.add_argument("--seconds", type=float, default=120, help="limit of a process")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    parser.add_argument("--results", type=pathlib.Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.work:
        return work(options.work, options.names, options.folder, options.results)
    python = install(options.folder)
    if pathlib.Path(sys.executable).resolve() != pathlib.Path(python).resolve() and not sys.prefix.startswith(str(options.folder)):
        return subprocess.run([python, str(HERE / "peers.py"), *sys.argv[1:]]).returncode  # the judge needs numpy
    set_folder = options.folder / "set"
    subprocess.run([python, str(HERE / "make.py"), str(set_folder)], check=True)
    index = json.loads((set_folder / "index.json").read_text())
    cases = [about["name"] for about in index]
    print(f"{datetime.date.today()}, {len(cases)} cases\n")
    print("| program | used | largest error | distances off | wrong signs | " + " | ".join(ASKS) + " | refused | crashed |")
    print("|-|-|" + "-:|" * (5 + len(ASKS)))
    notes = []
    for name in options.names or PEERS:
        _, package, used, unpromised = PEERS[name]
        interpreter = "/usr/bin/python3" if package.startswith("python3-") else python
        version = version_of(interpreter, package)
        if not version:
            print(f"| {name} | not installed |" + " |" * (5 + len(ASKS)), flush=True)
            continue
        results = options.folder / "results" / name
        if not options.kept:
            lost = run_peer(name, interpreter, cases, set_folder, results, options.seconds)
            (results / "lost.json").write_text(json.dumps(lost))
        elif (results / "lost.json").exists():
            lost = json.loads((results / "lost.json").read_text())
        else:
            continue
        row = judged(name, set_folder, results, lost, index)
        signs = []
        for word in ASKS:
            text = str(row[word][0]) if row[word][1] else "-"
            signs.append(f"({text})" if word in unpromised and text != "-" else text)
        print(
            f"| {package} {version} | {used} | {row['worst']:.1e} | {row['off']} | {row['signs']} | {' | '.join(signs)} "
            f"| {row['refused']} | {row['crashed']} |",
            flush=True,
        )
        notes.append((name, row["cases"], lost))
    for name, wrong, lost in notes:
        print(f"\n{name}: wrong signs in " + (", ".join(f"{case} ({count})" for case, count in wrong.items()) or "no case"))
        if lost:
            print(f"{name}: lost at " + ", ".join(f"{case} ({why})" for case, why in lost.items()))


if __name__ == "__main__":
    sys.exit(main())
