"""Arrays of every layout are used where they lie, and those that cannot be are refused before any work."""

from __future__ import annotations

import pickle
import tracemalloc
import types

import numpy as np
import pytest
from brute_force import BruteForce

import clsdf


def test_points_of_every_layout(body, brute, points):
    expected = body.query(points).distance
    assert np.allclose(expected, brute.distance(points), atol=1e-6)
    wide = np.zeros((len(points), 7))
    wide[:, 1:6:2] = points
    layouts = {
        "strided": wide[:, 1:6:2],
        "Fortran": np.asfortranarray(points),
        "reversed": points[::-1][::-1],
        "memoryview": memoryview(np.ascontiguousarray(points)),
        "list": points.tolist(),
        "read-only": np.frombuffer(points.tobytes()).reshape(-1, 3),
    }
    for name, layout in layouts.items():
        assert np.array_equal(body.query(layout).distance, expected), name
    assert np.array_equal(body.query(points[::-1]).distance, expected[::-1])
    single = points.astype(np.float32)
    assert np.array_equal(body.query(single).distance, body.query(single.astype(float)).distance)


class OnlyDLPack:
    """An array that has DLPack alone."""

    def __init__(self, array):
        self._array, self.shape = array, array.shape

    def __len__(self):
        return len(self._array)

    def __dlpack__(self, **options):
        return self._array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self._array.__dlpack_device__()


def test_dlpack(body, points):
    assert np.array_equal(body.query(OnlyDLPack(points)).distance, body.query(points).distance)
    out = np.empty(len(points), np.float32)
    body.query(points, out=OnlyDLPack(out))
    assert np.array_equal(out, body.query(points).distance)


@pytest.mark.parametrize("index", [np.int32, np.int64, np.uint32, np.uint64])
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_types_of_meshes(solid, points, index, real):
    vertices, faces = solid[0].astype(real), solid[1].astype(index)
    body = clsdf.Transform((vertices, faces[:, ::-1][:, ::-1]))
    assert np.allclose(body.query(points).distance, BruteForce(vertices, faces).distance(points), atol=1e-6)


def test_a_large_input_is_not_copied(body):
    points = np.zeros((1_000_000, 4))[:, :3]
    out = np.empty(len(points), np.float32)
    body.query(points, within=0.01, out=out)
    tracemalloc.start()
    body.query(points, within=0.01, out=out)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < points.nbytes / 100


def test_results_are_written_where_out_lies(body):
    field = body.field(resolution=20, outputs="distance gradient")
    expected = {name: array.copy() for name, array in field.arrays.items()}
    addresses = [array.ctypes.data for array in field.arrays.values()]
    for array in field.arrays.values():
        array[:] = 7
    again = body.field(field.grid, band=field.band, out=field)
    assert again is field
    assert [array.ctypes.data for array in again.arrays.values()] == addresses
    for name, array in expected.items():
        assert np.array_equal(again.arrays[name], array, equal_nan=True), name


def test_out_of_every_layout(body):
    field = body.field(resolution=20, outputs="distance gradient")
    nz, ny, nx = field.grid.shape
    large = np.full((nz + 2, ny + 4, nx + 6, 2), 7, np.float32)
    inner = large[1:-1, 2:-2, 3:-3, 1]
    body.field(field.grid, band=field.band, out=inner)
    assert np.array_equal(inner, field.distance)
    inner[:] = 7
    assert (large == 7).all()  # nothing beside it was written
    fortran = np.empty(field.grid.shape, np.float32, order="F")
    upside_down = np.empty(field.grid.shape, np.float32)[::-1, :, ::-1]
    planes = np.empty((3, nz, ny, nx), np.float32)
    out = {"distance": fortran, "gradient": np.moveaxis(planes, 0, -1)}
    body.field(field.grid, band=field.band, out=out)
    body.field(field.grid, band=field.band, out=upside_down)
    assert np.array_equal(fortran, field.distance) and np.array_equal(upside_down, field.distance)
    assert np.array_equal(planes, np.moveaxis(field.gradient, -1, 0), equal_nan=True)


def test_types_of_out(body):
    field = body.field(resolution=16, band="10%", outputs="distance triangle offset")
    out = {
        "distance": np.empty(field.grid.shape),
        "triangle": np.empty(field.grid.shape, np.int32),
        "offset": np.empty((*field.grid.shape, 3)),
    }
    body.field(field.grid, band=field.band, out=out)
    assert np.allclose(out["distance"], field.distance, atol=1e-6)
    assert np.array_equal(out["triangle"].view(np.uint32), field.triangle) and (out["triangle"] == -1).any()
    assert np.array_equal(out["offset"].astype(np.float32), field.offset, equal_nan=True)
    with pytest.raises(clsdf.Error, match="closest .* float; .* double, or ask for the output offset"):
        body.field(field.grid, out={"distance": out["distance"], "closest": np.empty((*field.grid.shape, 3), np.float32)})
    for dtype in (np.int64, np.float16, np.complex64, np.longdouble, object, "U4"):
        with pytest.raises(clsdf.Error, match="cannot be written as int64|elements of type"):
            body.field(field.grid, band=field.band, out=np.empty(field.grid.shape, dtype))
    with pytest.raises(clsdf.Error, match="for site uint8"):
        out = {"distance": out["distance"], "site": np.empty(field.grid.shape, np.int16)}
        body.field(field.grid, band=field.band, out=out)


@pytest.mark.parametrize("module", ["jaxlib._jax", "jax._src.array", "tensorflow.python.framework.ops"])
def test_arrays_that_never_change_are_no_out(body, points, module):
    class Constant:
        """What these packages give: __dlpack__ of memory that looks writable."""

        def __init__(self, array):
            self.array, self.shape, self.dtype = array, array.shape, array.dtype

        def __len__(self):
            return len(self.array)

        def __dlpack__(self, **_):
            return self.array.__dlpack__()

        def __dlpack_device__(self):
            return self.array.__dlpack_device__()

    memory = np.full(len(points), 7, np.float32)
    body.query(points, out=Constant(memory.copy()))
    vectors = Constant(np.array(points))
    Constant.__module__ = module
    with pytest.raises(clsdf.Error, match=f"'distance' is an array of {module.split('.')[0].removesuffix('lib')}, and these never change") as error:
        body.query(points, out=Constant(memory))
    assert error.value.code == "invalid_argument" and (memory == 7).all()
    assert np.array_equal(body.query(vectors).distance, body.query(points).distance)


def misaligned(shape):
    return np.frombuffer(bytearray(4 * int(np.prod(shape)) + 1), np.uint8)[1:].view(np.float32).reshape(shape)


REFUSED = {
    "read-only": (lambda shape: np.broadcast_to(np.float32(7), shape).copy(), "read-only"),
    "swapped": (lambda shape: np.full(shape, 7, np.dtype(np.float32).newbyteorder("S")), "swapped bytes"),
    "transposed": (lambda shape: np.full(shape[::-1], 7, np.float32), r"has the shape \(\d+, \d+, \d+\); expected"),
    "flat": (lambda shape: np.full(int(np.prod(shape)), 7, np.float32), r"has the shape \(\d+,\); expected"),
    "overlapping": (
        lambda shape: np.lib.stride_tricks.as_strided(np.full(10**5, 7, np.float32), shape, (4, 4, 4)),
        "overlap|same",
    ),
    "stride 0": (
        lambda shape: np.lib.stride_tricks.as_strided(np.full(10**5, 7, np.float32), shape, (0, 0, 0)),
        "stride 0",
    ),
    "misaligned": (misaligned, "address"),
    "list": (lambda shape: np.full(shape, 7.0).tolist(), "list"),
    "none": (lambda shape: {"gradient": np.empty((*shape, 3), np.float32)}, "no array of the distance"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_out_is_refused_before_any_work(body, name):
    make, message = REFUSED[name]
    grid = body.grid(10, margin="20%", cubic=False)
    out = make(grid.shape)
    if name == "read-only":
        out.flags.writeable = False
    calls = []
    with pytest.raises(clsdf.Error, match=message) as error:
        body.field(grid, out=out, progress=lambda stage, part: calls.append(stage))
    assert error.value.code == "invalid_argument"
    assert not calls
    if isinstance(out, np.ndarray) and name != "misaligned":
        assert (out == 7).all()


def test_outputs_that_overlap_are_refused(body, points):
    memory = np.full(4 * len(points), 7, np.float32)
    out = {"distance": memory[: len(points)], "gradient": memory[len(points) - 1 : -1 + 4 * len(points)][: 3 * len(points)].reshape(-1, 3)}
    with pytest.raises(clsdf.Error, match="overlap|same bytes"):
        body.query(points, out=out)
    assert (memory == 7).all()


@pytest.mark.parametrize(
    "points, message",
    [
        (np.zeros((4, 2)), r"shape \(4, 2\)"),
        (np.zeros((4, 3), np.complex64), "complex64"),
        (np.zeros((4, 3), ">f8"), "swapped"),
        (np.broadcast_to(np.zeros(3), (4, 3)), "stride 0"),
        (np.zeros((4, 3), bool), "bool"),
    ],
)
def test_points_that_cannot_be_read(body, points, message):
    with pytest.raises(clsdf.Error, match=message) as error:
        body.query(points)
    assert error.value.code in ("invalid_argument", "unsupported")


def test_points_that_are_not_finite_have_no_distance(body, points):
    marked = np.array(points[:5])
    marked[1] = np.nan
    marked[3] = 1e30
    warning = r"1 of 5 points.*point 1, counted from 0, at \(nan, nan, nan\).*1 of 5.*point 3"
    with pytest.warns(clsdf.MeshWarning, match=warning) as warned:
        found = body.query(marked, outputs="triangle closest", within=0.25)
    assert len(warned) == 1 and warned[0].filename == __file__
    assert np.isnan(found.distance[1]) and found.distance[3] == 0.25
    assert (found.triangle[[1, 3]] == 0xFFFFFFFF).all() and np.isnan(found.closest[[1, 3]]).all()
    expected = body.query(points[:5], outputs="triangle closest", within=0.25)
    for name, array in found.arrays.items():
        assert np.array_equal(array[[0, 2, 4]], expected.arrays[name][[0, 2, 4]], equal_nan=True)
    for bad, message in [(marked, r"point 1, counted from 0, at \(nan, nan, nan\)"),
                         ([[0, np.inf, 0]], r"point 0, counted from 0, at \(0, inf, 0\)")]:
        with pytest.raises(clsdf.Error, match=message) as error:
            body.query(bad, refuse_unusable_points=True)
        assert error.value.code == "invalid_argument"


def test_files_of_one_body_are_read_as_one_mesh(tmp_path):
    for name, x in (("a.obj", 0), ("b.obj", 5)):
        (tmp_path / name).write_text(f"v {x} 0 0\nv {x + 1} 0 0\nv {x} 1 0\nf 1 2\nf 1 2 3\n")
    with pytest.warns(clsdf.MeshWarning, match="1 face of fewer than three corners is skipped") as warned:
        vertices, faces = clsdf.read_mesh(tmp_path / "a.obj", tmp_path / "b.obj")
    assert len(warned) == 2
    assert vertices[:, 0].tolist() == [0, 1, 0, 5, 6, 5] and faces.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_bad_facets_of_a_file_are_left_out_if_asked_for(tmp_path):
    path = tmp_path / "bad.obj"
    path.write_text("v 0 0 0\nv 1.0D+00 0 0\nv 0 1 0\nv 1 nan 0\nf 1 2 3\nf 1 2 4\nf 1 2 9\n")
    with pytest.raises(clsdf.Error, match="skip_bad_facets"):
        clsdf.read_mesh(path)
    with pytest.warns(clsdf.MeshWarning, match="2 faces .* left out, the first at line 6"):
        vertices, faces = clsdf.read_mesh(path, skip_bad_facets=True)
    assert faces.tolist() == [[0, 1, 2]] and vertices[1].tolist() == [1, 0, 0]


def test_a_mesh_has_groups_of_faces(tmp_path, solid):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng floor\nf 1 3 2\ng walls\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    path = tmp_path / "room.obj"
    path.write_text(text)
    mesh = clsdf.read_mesh(path)
    vertices, faces = mesh
    names, numbers = mesh.groups
    assert names == ["floor", "walls"] and numbers.dtype == np.int32 and numbers.tolist() == [0, 1, 1, 1]
    assert vertices is mesh.vertices and faces is mesh.faces and mesh.name == "room.obj"
    body = clsdf.Transform(mesh)
    assert body.mesh_name == "room.obj"
    points = np.array([[0.1, 0.1, -1], [2, 2, 2], [-9, 0, 0]])
    r = body.query(points, outputs="triangle", within=5)
    assert mesh.groups.of(r.triangle).tolist() == [0, 1, -1]
    assert [names[n] for n in numbers[r.triangle[:2]]] == ["floor", "walls"]

    two = clsdf.read_mesh(path, path, weld=1e-6)
    assert two.groups.names == ["room/floor", "room/walls", "room_2/floor", "room_2/walls"]
    assert two.groups.numbers.tolist() == [0, 1, 1, 1, 2, 3, 3, 3]
    assert clsdf.weld(mesh).groups.names == names
    assert pickle.loads(pickle.dumps(mesh)).groups.names == names

    mine = clsdf.Mesh(*solid)
    assert mine.groups.names == [] and mine.groups.numbers.size == 0
    assert mine.groups.of([0, 1]).tolist() == [-1, -1]
    mine = clsdf.Mesh(vertices, faces, groups=(["a", "b"], [1, 0, 0, 0]))
    assert mine.groups.of([[0, 1]]).tolist() == [[1, 0]]
    for groups, message in [((["a"], [0, 0]), "one for each of 4 faces"), ((["a"], [0, 0, 0, 1]), "0 to 1"),
                            ((["a", "a"], [0] * 4), "the same"), ((["a"], [0.5] * 4), "no pair"), (3, "no pair")]:
        with pytest.raises(clsdf.Error, match=message):
            clsdf.Mesh(vertices, faces, groups=groups)

    field = body.field(resolution=8, outputs="distance triangle")
    clsdf.write_field(field, tmp_path / "plain.vti")
    clsdf.write_field(field, tmp_path / "groups.vti", groups=mesh.groups)
    content = (tmp_path / "groups.vti").read_bytes()
    assert b'Name="group"' in content and b'Name="group"' not in (tmp_path / "plain.vti").read_bytes()
    assert mesh.groups.of(field.triangle).astype("<u4").tobytes() in content

    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty int id\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n17 3 0 1 2\n"
    )
    assert clsdf.read_mesh(tmp_path / "a.ply", group_by="id").groups.names == ["17"]


def test_rows_of_a_mesh_are_named(solid):
    vertices, faces = solid
    bad = vertices.copy()
    bad[5, 1] = np.nan
    with pytest.raises(clsdf.Error, match="vertex 5.*nan") as error:
        clsdf.Transform((bad, faces))
    assert error.value.code == "invalid_mesh"
    for value in (len(vertices), -1):
        wrong = faces.astype(np.int64)
        wrong[3, 2] = value
        with pytest.raises(clsdf.Error, match=f"triangle 3 .*index.* {value}|triangle 3 .*index"):
            clsdf.Transform((vertices, wrong))
    with pytest.raises(clsdf.Error, match=r"faces has the shape"):
        clsdf.Transform((vertices, np.zeros((4, 4), int)))
    with pytest.raises(clsdf.Error, match="no mesh that is known"):
        clsdf.Transform(3)


def test_one_point_and_no_point(body, brute):
    one = body.query((0.3, 0.1, 0.05), outputs="distance gradient")
    assert np.shape(one.distance) == () and one.gradient.shape == (3,)
    assert float(one.distance) == pytest.approx(brute.distance([(0.3, 0.1, 0.05)])[0], abs=1e-6)
    none = body.query(np.empty((0, 3)), outputs="distance closest")
    assert none.distance.shape == (0,) and none.closest.shape == (0, 3)


def test_a_limited_search(body, brute, points):
    found = body.query(points, "distance triangle", within=0.1)
    expected = brute.distance(points)
    near = np.abs(expected) < 0.1
    assert np.allclose(found.distance[near], expected[near], atol=1e-6)
    assert np.allclose(found.distance[~near], np.copysign(0.1, expected[~near]))
    assert np.array_equal(found.triangle == clsdf.no_triangle, ~near)


def test_results_outlive_the_transform(solid):
    body = clsdf.Transform(solid)
    field, found = body.field(resolution=16), body.query(np.zeros((5, 3)))
    distance, values = field.distance, found.distance
    before = distance.copy(), values.copy()
    del body, field, found
    trash = [np.full(16**3, 3, np.float32) for _ in range(50)]
    assert np.array_equal(distance, before[0]) and np.array_equal(values, before[1]) and trash


def test_meshes_of_other_packages(solid, points):
    vertices, faces = solid
    expected = clsdf.Transform(solid).query(points).distance
    like_open3d = types.SimpleNamespace(vertices=vertices.tolist(), triangles=faces.tolist())
    for mesh in (like_open3d, [vertices, faces], (vertices.tolist(), faces.tolist())):
        assert np.array_equal(clsdf.Transform(mesh).query(points).distance, expected)
    assert np.array_equal(clsdf.Transform(vertices, faces).query(points).distance, expected)
    kinds = []
    for package in ("trimesh", "meshio", "pyvista", "open3d"):
        try:
            module = __import__(package)
        except ImportError:
            continue
        if package == "trimesh":
            mesh = module.Trimesh(vertices, faces, process=False)
        elif package == "meshio":
            mesh = module.Mesh(vertices, {"triangle": faces})
        elif package == "pyvista":
            mesh = module.PolyData(vertices, np.insert(faces, 0, 3, axis=1).astype(np.int64))
        else:
            mesh = module.geometry.TriangleMesh(
                module.utility.Vector3dVector(vertices), module.utility.Vector3iVector(faces.astype(np.int32))
            )
        # pyvista keeps floats.
        assert np.allclose(clsdf.Transform(mesh).query(points).distance, expected, atol=1e-5), package
        kinds.append(package)
    assert "trimesh" in kinds


def test_a_mesh_from_a_file(tmp_path, solid, points):
    path = tmp_path / "solid.obj"
    vertices, faces = solid
    path.write_text(
        "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in vertices.tolist())
        + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces.tolist())
    )
    read = clsdf.read_mesh(path)
    assert np.array_equal(read[0], vertices) and np.array_equal(read[1], faces)
    scaled, _ = clsdf.read_mesh(path, scale=0.5, translate=(1, 2, 3))
    upright, _ = clsdf.read_mesh(path, up="y", rotate=(0, 0, 90))
    x, y, z = read[0].T
    assert np.array_equal(upright, np.stack([z, x, y], 1))
    with pytest.raises(clsdf.Error, match="'up' is no axis"):
        clsdf.read_mesh(path, up="up")
    assert np.array_equal(scaled, vertices * 0.5 + (1.0, 2.0, 3.0))
    with pytest.raises(clsdf.Error, match="scale: -1"):
        clsdf.read_mesh(path, scale=-1)
    body = clsdf.Transform(path)
    assert body.mesh_name == "solid.obj"
    assert np.array_equal(body.query(points).distance, clsdf.Transform(solid).query(points).distance)
    with pytest.raises(clsdf.Error, match="nothing.off") as error:
        clsdf.Transform(tmp_path / "nothing.off")
    assert error.value.code == "unreadable_input"


# Of tests/mesh/mesh.cpp, which has its hash, too.
TETRAHEDRON = ([(0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])


def test_the_hash_of_a_mesh_is_that_of_cpp(tmp_path):
    assert clsdf.mesh_hash(TETRAHEDRON) == 7316670834777255572
    vertices, faces = np.array(TETRAHEDRON[0], np.float32), np.array(TETRAHEDRON[1], np.uint64)
    assert clsdf.mesh_hash((vertices, faces)) == clsdf.mesh_hash(TETRAHEDRON)
    assert clsdf.mesh_hash(types.SimpleNamespace(vertices=vertices[::-1][::-1], faces=faces)) == clsdf.mesh_hash(TETRAHEDRON)
    path = tmp_path / "tetrahedron.off"
    path.write_text("OFF\n4 4 0\n" + "".join("%g %g %g\n" % v for v in TETRAHEDRON[0])
                    + "".join("3 %d %d %d\n" % f for f in TETRAHEDRON[1]))
    assert clsdf.mesh_hash(path) == clsdf.mesh_hash(TETRAHEDRON)


def test_a_mesh_is_welded_and_its_defects_are_counted(solid):
    vertices, faces = solid
    soup = vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    welded, corners = clsdf.weld(soup)
    assert len(welded) == len(vertices) and np.array_equal(welded[corners], vertices[faces])
    defects = clsdf.find_defects((vertices, np.concatenate([faces, faces[:2, ::-1]])))
    assert (defects.zero_area_faces, defects.duplicate_faces, defects.components) == (0, 2, 1)
    assert "2 duplicate faces" in repr(defects)
    unbalanced = clsdf.Transform(vertices, faces[1:], sign="none").topology
    assert unbalanced.unbalanced_edges == len(unbalanced.first_unbalanced_edges) == 3
    assert unbalanced.boundary_edges == 3


def test_what_another_surface_than_the_mesh_decides_is_counted(solid):
    vertices, faces = solid
    turned = np.concatenate([faces[:1, ::-1], faces[1:], faces[1:2]])
    noise = vertices[turned].reshape(-1, 3)
    noise[::2] *= 1 + 2.0**-52
    with pytest.warns(clsdf.MeshWarning, match="for the sign, "):
        body = clsdf.Transform(noise, np.arange(turned.size).reshape(-1, 3))
    topology = body.topology
    assert body.sign == "nonzero" and topology.balanced and topology.parts == 1
    assert topology.joined_vertices > 0 and topology.reoriented_faces == 1
    assert topology.duplicate_faces == topology.uncounted_faces == 1
    assert topology.inner_wall_faces == topology.inward_parts == topology.nested_parts == 0
    torn = noise.copy()
    torn[0] += 1e-6
    with pytest.raises(clsdf.Error, match="move apart"):
        body.set_positions(torn)


def test_vertices_that_are_near_are_welded(solid, tmp_path):
    vertices, faces = solid
    soup = vertices[faces].reshape(-1, 3)
    soup[::2] += 1e-7
    corners = np.arange(faces.size).reshape(-1, 3)
    assert len(clsdf.weld((soup, corners))[0]) > len(vertices)
    assert len(clsdf.weld((soup, corners), 1e-6)[0]) == len(vertices)
    path = tmp_path / "soup.off"
    rows = [f"{len(soup)} {len(faces)} 0", *(f"{x!r} {y!r} {z!r}" for x, y, z in soup.tolist())]
    path.write_text("\n".join(["OFF", *rows, *(f"3 {a} {b} {c}" for a, b, c in corners.tolist()), ""]))
    assert len(clsdf.read_mesh(path)[0]) == len(soup)
    assert len(clsdf.read_mesh(path, weld=1e-6)[0]) == len(vertices)
    with pytest.raises(clsdf.Error, match="0 or more"):
        clsdf.weld((soup, corners), -1)
    plate = clsdf.make_shape("cube")[0] * (1, 1, 5e-4), clsdf.make_shape("cube")[1]
    with pytest.warns(clsdf.MeshWarning, match="within 0.002: .* faces lose their area.*give a smaller"):
        clsdf.weld(plate, 0.002)


def test_other_meshes_have_other_hashes(solid):
    vertices, faces = solid
    turned = np.roll(faces, 1, axis=1)
    moved = vertices.copy()
    moved[-1, 2] = np.nextafter(moved[-1, 2], 9)
    unused = np.concatenate([vertices, [(0, 0, 0)]])
    meshes = [(vertices, faces), (vertices, turned), (moved, faces), (unused, faces), (vertices, faces[:-1])]
    hashes = {clsdf.mesh_hash(mesh) for mesh in meshes}
    assert len(hashes) == len(meshes) and all(0 <= number < 2**64 for number in hashes)
    with pytest.raises(clsdf.Error) as error:
        clsdf.mesh_hash((vertices, faces + len(vertices)))
    assert error.value.code == "invalid_mesh"
