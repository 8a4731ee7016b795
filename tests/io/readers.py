"""Opens a field with the program that its format is for, and compares it with what was written.

    readers.py FORMAT FIELD EXPECTED

EXPECTED.json states the grid, EXPECTED.f32 and EXPECTED.u32 hold the plain values. Exit status 3: the program is missing.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

PACKAGES = {"vti": "python3-vtk9", "vti_rewritten": "python3-vtk9", "vtkhdf": "python3-vtk9",
            "vtkhdf_rewritten": "python3-h5py", "h5": "python3-h5py", "nrrd": "teem-apps",
            "npy": "python3-numpy", "sparse_npy": "python3-numpy", "sparse_h5": "python3-h5py", "sdf": "python3-numpy",
            "vdb": "python3-openvdb", "vdb_unequal": "python3-openvdb", "vdb_rewritten": "python3-openvdb"}


def check(statement, what):
    if not statement:
        sys.exit("wrong: " + what)


def check_values(name, found, expected):
    import numpy
    found = numpy.asarray(found)
    check(found.shape == expected.shape, f"{name}: shape {found.shape}, not {expected.shape}")
    check(found.dtype == expected.dtype, f"{name}: type {found.dtype}, not {expected.dtype}")
    check(found.tobytes() == expected.tobytes(), f"{name}: values")


def check_description(text, expected):
    description = json.loads(text)
    for name in ("mesh", "sign", "band"):
        check(description[name] == expected[name], f"{name}: {description[name]}")
    check(description["program"].startswith("clsdf "), "program")


def read_image(path):
    from vtkmodules.vtkIOXML import vtkXMLImageDataReader
    reader = vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    check(reader.GetErrorCode() == 0, f"VTK's error {reader.GetErrorCode()}")
    return reader.GetOutput()


def check_image(image, expected, distance, triangle):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    nx, ny, nz = expected["size"]
    check(image.GetExtent() == (0, nx - 1, 0, ny - 1, 0, nz - 1), f"extent {image.GetExtent()}")
    check(list(image.GetOrigin()) == expected["origin"], f"origin {image.GetOrigin()}")
    check(list(image.GetSpacing()) == expected["spacing"], f"spacing {image.GetSpacing()}")
    data = image.GetPointData()
    check_values("distance", vtk_to_numpy(data.GetArray("distance")).reshape(nz, ny, nx), distance)
    check_values("triangle", vtk_to_numpy(data.GetArray("triangle")).reshape(nz, ny, nx), triangle)


def vti(path, expected, distance, triangle):
    image = read_image(path)
    check(image.GetPointData().GetScalars().GetName() == "distance", "the scalars' name")
    check_image(image, expected, distance, triangle)
    check_description(image.GetFieldData().GetAbstractArray("clsdf").GetValue(0), expected)


def vti_rewritten(path, expected, distance, triangle):
    """Reads it with VTK and writes it in each of VTK's ways, for clsdf to read."""
    from vtkmodules.vtkIOXML import vtkXMLImageDataWriter
    image = read_image(path)
    for name, prepare in (("appended", lambda w: (w.SetDataModeToAppended(), w.EncodeAppendedDataOff())),
                          ("base64", lambda w: w.SetDataModeToBinary()),
                          ("ascii", lambda w: w.SetDataModeToAscii()),
                          ("encoded", lambda w: w.SetDataModeToAppended()),
                          ("compressed", None),  # as VTK writes by default: zlib, appended base64
                          ("compressed_raw", lambda w: w.EncodeAppendedDataOff()),
                          ("compressed_base64", lambda w: w.SetDataModeToBinary()),
                          ("lz4", lambda w: w.SetCompressorTypeToLZ4())):
        for header in (32, 64):
            writer = vtkXMLImageDataWriter()
            writer.SetFileName(f"{path[:-4]}_{name}_{header}.vti")
            writer.SetInputData(image)
            writer.SetHeaderType(header)
            writer.SetBlockSize(1024)  # so that there are several
            if name in ("appended", "base64", "ascii", "encoded"):
                writer.SetCompressorTypeToNone()
            if prepare:
                prepare(writer)
            check(writer.Write() == 1, "VTK does not write " + name)


def vtkhdf(path, expected, distance, triangle):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader
    reader = vtkHDFReader()
    check(reader.CanReadFile(path) == 1, "CanReadFile")
    reader.SetFileName(path)
    reader.Update()
    check(reader.GetErrorCode() == 0, f"VTK's error {reader.GetErrorCode()}")
    image = reader.GetOutputDataObject(0)
    check_image(image, expected, distance, triangle)
    group = vtk_to_numpy(image.GetPointData().GetArray("group")).reshape(distance.shape)
    beyond = triangle == 0xFFFFFFFF
    check_values("group", group, (triangle % 2 + beyond * 0xFFFFFFFE).astype("u4"))
    try:
        import h5py
    except ImportError:
        return
    with h5py.File(path, "r") as file:
        names = [bytes(name).decode() for name in file["VTKHDF/PointData/group"].attrs["names"]]
        check(names == ["even", "odd ones"], f"the groups' names {names}")


def vtkhdf_rewritten(path, expected, distance, triangle):
    """Writes it as other programs do: HDF5's default format, and in chunks; compressed, which clsdf refuses."""
    import h5py
    import numpy
    with h5py.File(path, "r") as file:
        about, attributes = file.attrs["clsdf"], dict(file["VTKHDF"].attrs)
    if not isinstance(about, bytes):
        about = about.encode()
    for name, options in (("plain", {}), ("chunks", {"chunks": (4, 5, 6)}),
                          ("compressed", {"chunks": (4, 5, 6), "compression": "gzip"})):
        for version in ("earliest", "latest"):
            with h5py.File(f"{path[:-7]}_{name}_{version}.vtkhdf", "w", libver=version) as file:
                file.attrs["clsdf"] = numpy.bytes_(about)
                root = file.create_group("VTKHDF")
                for key, value in attributes.items():
                    root.attrs[key] = value if key != "Type" else numpy.bytes_(b"ImageData")
                root.attrs["WholeExtent"] = numpy.asarray(attributes["WholeExtent"], "i4")
                points = root.create_group("PointData")
                points.attrs["Scalars"] = numpy.bytes_(b"phi")
                points.create_dataset("phi", data=distance.astype("f8"), **options)
                points.create_dataset("triangle", data=triangle, **options)


def h5(path, expected, distance, triangle):
    import h5py
    with h5py.File(path, "r") as file:
        for name, values in (("distance", distance), ("triangle", triangle)):
            check_values(name, file[name][...], values)
            check(file[name].chunks is None, "chunks")
            check(list(file[name].attrs["origin"]) == expected["origin"], "origin")
            check(list(file[name].attrs["spacing"]) == expected["spacing"], "spacing")
        text = file.attrs["clsdf"]
        check_description(text.decode() if isinstance(text, bytes) else text, expected)
        check_xdmf(path, expected, file)


def check_xdmf(path, expected, file):
    """Debian's VTK has no reader of XDMF, so the description is held against what h5py finds."""
    folder, name = os.path.split(path)
    grid = xml.etree.ElementTree.parse(os.path.join(folder, name[:-3] + ".xdmf")).getroot().find("Domain/Grid")
    check(grid.get("GridType") == "Uniform", "GridType")
    topology = grid.find("Topology")
    check(topology.get("TopologyType") == "3DCoRectMesh", "TopologyType")
    check(topology.get("Dimensions").split() == [str(n) for n in expected["size"][::-1]], "Dimensions")
    geometry = grid.find("Geometry")
    check(geometry.get("GeometryType") == "ORIGIN_DXDYDZ", "GeometryType")
    for item, key in zip(geometry.findall("DataItem"), ("origin", "spacing")):
        check([float(word) for word in item.text.split()] == expected[key][::-1], "XDMF's " + key)
    attributes = grid.findall("Attribute")
    check([a.get("Name") for a in attributes] == ["distance", "triangle"], "XDMF's attributes")
    for attribute in attributes:
        item = attribute.find("DataItem")
        where, dataset = item.text.strip().split(":")
        check(where == name and attribute.get("Center") == "Node", "XDMF's file")
        dtype = file[dataset].dtype
        check(item.get("Dimensions").split() == [str(n) for n in file[dataset].shape], "XDMF's dimensions")
        kind = {"Float": "f", "UInt": "u"}[item.get("NumberType")] + item.get("Precision")
        check(dtype.str.lstrip("<>=|") == kind, f"XDMF's type {kind}, and h5py's {dtype}")


def nrrd(path, expected, distance, triangle):
    import numpy
    unu = shutil.which("teem-unu") or shutil.which("unu")  # Debian's name for it, and its own
    if unu is None:
        raise ImportError("unu is not installed")
    triangle_path = path[:-5] + "_triangle.nrrd"
    for name, values in ((path, distance), (triangle_path, triangle)):
        with tempfile.TemporaryDirectory() as folder:
            raw = os.path.join(folder, "values.raw")
            subprocess.run([unu, "data", name], stdout=open(raw, "wb"), check=True)
            check_values(name, numpy.fromfile(raw, values.dtype).reshape(values.shape), values)
        header = subprocess.run([unu, "head", name], capture_output=True, text=True, check=True).stdout
        fields = dict(line.split(": ", 1) for line in header.splitlines() if ": " in line and line[0] != "#")
        check([int(word) for word in fields["sizes"].split()] == expected["size"], "sizes")
        origin = [float(word) for word in fields["space origin"].strip("()").split(",")]
        check(origin == expected["origin"], "space origin")
        directions = [[float(x) for x in v.strip("()").split(",")] for v in fields["space directions"].split()]
        spacing = expected["spacing"]
        check(directions == [[spacing[0], 0, 0], [0, spacing[1], 0], [0, 0, spacing[2]]], "space directions")
    # teem parses every field and pair where it does something with the array, and answers in its own words.
    copy = subprocess.run([unu, "crop", "-min", "0", "0", "0", "-max", "M", "M", "M", "-i", path],
                          capture_output=True, check=True).stdout
    check(b"clsdf_sign:=" + expected["sign"].encode() in copy, "the sign rule after unu crop")


def npy(path, expected, distance, triangle):
    import numpy
    check_values("distance", numpy.load(path, mmap_mode="r"), distance)
    check_values("triangle", numpy.load(path[:-4] + "_triangle.npy"), triangle)
    text = open(path + ".json", encoding="utf-8").read()
    check_description(text, expected)
    for name in ("origin", "spacing", "size"):
        check(json.loads(text)[name] == expected[name], name)


def check_sparse(distance, bricks, runs, about, expected):
    """Looks every sample up as docs/sparse.md does."""
    import numpy
    check(distance.dtype == numpy.float32 and distance.shape == (len(bricks), 8, 8, 8), "the shape of the values")
    check(bricks.dtype == numpy.int64 and bricks.shape[1:] == (3,), "the shape of the bricks")
    check(runs.dtype == numpy.int64 and runs.shape[1:] == (4,) and len(runs) > 0, "the shape of the runs")
    number = {tuple(brick): n for n, brick in enumerate(bricks.tolist())}

    def distance_at(x, y, z):
        brick = (x & ~7, y & ~7, z & ~7)
        if brick in number:
            return distance[number[brick], z & 7, y & 7, x & 7]
        first, count = runs[:, :3], runs[:, 3]
        along = brick[0] - first[:, 0]
        is_inside = ((first[:, 1:] == brick[1:]).all(1) & (along >= 0) & (along < 8 * count)).any()
        return -about["band"]["inside"] if is_inside else about["band"]["outside"]

    first = numpy.array(about["lattice"]["first"])
    for (z, y, x), value in numpy.ndenumerate(expected[::2, ::3, ::5]):
        sample = first + (5 * x, 3 * y, 2 * z)
        check(numpy.float32(distance_at(*sample.tolist())) == value, f"distance at {sample}")
    index = bricks[:, None] + numpy.indices((8, 8, 8)).reshape(3, -1).T[:, ::-1]
    position = numpy.array(about["lattice"]["origin"]) + numpy.array(about["spacing"]) * index
    check((index[0, 9] == bricks[0] + (1, 1, 0)).all(), "the order of samples")
    check(position.shape == (len(bricks), 512, 3), "the shape of the positions")


def sparse_npy(path, expected, distance, triangle):
    import numpy
    about = json.load(open(path + ".json", encoding="utf-8"))
    check_sparse(numpy.load(path), numpy.load(path[:-4] + "_bricks.npy"), numpy.load(path[:-4] + "_inside_runs.npy"),
                 about, distance)


def sparse_h5(path, expected, distance, triangle):
    import h5py
    with h5py.File(path, "r") as file:
        text = file.attrs["clsdf"]
        about = json.loads(text.decode() if isinstance(text, bytes) else text)
        check(list(file["bricks"].attrs["origin"]) == about["lattice"]["origin"], "origin")
        check(list(file["bricks"].attrs["spacing"]) == expected["spacing"], "spacing")
        check_sparse(file["distance"][...], file["bricks"][...], file["inside_runs"][...], about, distance)


def sdf(path, expected, distance, triangle):
    """As SDFGen writes it: three lines, then a value on each."""
    import numpy
    lines = open(path, encoding="ascii").read().split("\n")
    check([int(word) for word in lines[0].split(" ")] == expected["size"], "sizes")
    check([float(word) for word in lines[1].split(" ")] == expected["origin"], "origin")
    check([float(lines[2])] * 3 == expected["spacing"], "spacing")
    check(lines[-1] == "", "the last line")
    check_values("distance", numpy.array(lines[3:-1]).astype(numpy.float32).reshape(distance.shape), distance)


def openvdb_module():
    """pyopenvdb, or openvdb as newer releases call it."""
    try:
        import pyopenvdb
        return pyopenvdb
    except ImportError:
        import openvdb
        return openvdb


def vdb_unequal(path, expected, distance, triangle):
    vdb(path, expected, distance, triangle, "unknown")


def vdb(path, expected, distance, triangle, grid_class="level set"):
    import numpy
    pyopenvdb = openvdb_module()
    # Debian's module has no grids of integers, so the triangles are left to clsdf's own reader.
    grid = pyopenvdb.read(path, "distance")
    check_description(grid["clsdf"], expected)
    check(grid.gridClass == grid_class, f"class {grid.gridClass}")
    outside, inside = (numpy.float32(expected["band"][side]) for side in ("outside", "inside"))
    check(numpy.float32(grid.background) == outside, f"background {grid.background}")
    for corner in ((0, 0, 0), (3, 2, 1)):
        place = [o + c * s for o, c, s in zip(expected["origin"], corner, expected["spacing"])]
        found = grid.transform.indexToWorld(corner)
        check(numpy.allclose(found, place, rtol=1e-14, atol=0), f"sample {corner} lies at {found}, not {place}")
    nx, ny, nz = expected["size"]
    values = numpy.zeros((nx, ny, nz), numpy.float32)
    grid.copyToArray(values)
    check_values("distance", numpy.ascontiguousarray(values.transpose(2, 1, 0)), distance)
    in_band = numpy.count_nonzero((distance != outside) & (distance != -inside))
    check(grid.activeVoxelCount() == in_band, f"{grid.activeVoxelCount()} active voxels, not {in_band}")


def vdb_rewritten(path, expected, distance, triangle):
    """The distance alone, as another program would write it, for clsdf to read."""
    pyopenvdb = openvdb_module()
    grid = pyopenvdb.read(path, "distance")
    del grid["clsdf"]
    grid.name = "surface"
    pyopenvdb.write(path[:-4] + "_rewritten.vdb", grid)


def main():
    kind, path, expected_path = sys.argv[1:]
    try:
        import numpy
        with open(expected_path + ".json", encoding="utf-8") as file:
            expected = json.load(file)
        shape = tuple(expected["size"][::-1])
        distance = numpy.fromfile(expected_path + ".f32", numpy.float32).reshape(shape)
        triangle = numpy.fromfile(expected_path + ".u32", numpy.uint32).reshape(shape)
        globals()[kind](path, expected, distance, triangle)
    except ImportError as error:
        print(f"{error}; apt-get install {PACKAGES[kind]} (scripts/setup --tests does)", file=sys.stderr)
        sys.exit(3)


main()
