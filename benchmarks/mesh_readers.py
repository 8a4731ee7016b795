"""Readers of .stl, .obj, .off and .ply in NumPy, which share no code with clsdf's.

read(path) returns the triangles as an array of shape (n, 3, 3), in the order of the file. Polygons become triangles by
the rule of docs/command.md: a fan around the first corner, or ears if a triangle of that fan faces against the polygon.
Anything that these readers do not know raises an exception: such a file is not judged.
"""
import numpy


def read(path):
    data = path.read_bytes()
    reader = {".stl": read_stl, ".obj": read_obj, ".off": read_off, ".ply": read_ply}[path.suffix.lower()]
    triangles = numpy.asarray(reader(data), dtype=float).reshape(-1, 3, 3)
    return triangles + 0.0  # no -0, whose bytes differ from those of 0


def read_stl(data):
    count = int.from_bytes(data[80:84], "little")
    is_text = data.lstrip()[:5].lower() == b"solid" and b"\0" not in data
    if len(data) == 84 + 50 * count or not is_text:
        rows = numpy.frombuffer(data, numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")]),
                                count, 84)
        return rows["corners"]
    corners = [line.split()[1:4] for line in data.decode("latin-1").lower().splitlines()
               if line.split()[:1] == ["vertex"]]
    if len(corners) != 3 * data.lower().count(b"facet normal"):
        raise ValueError("facets that are not three lines of a vertex each")
    return [[float(number) for number in corner] for corner in corners]


def read_obj(data):
    vertices, polygons = [], []
    for line in data.decode("utf-8", "replace").replace("\\\r\n", " ").replace("\\\n", " ").splitlines():
        words = line.split("#")[0].split()
        if words[:1] == ["v"]:
            numbers = [float(word) for word in words[1:5]]
            divisor = numbers[3] if len(words) == 5 else 1
            vertices.append([number / divisor for number in numbers[:3]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            polygons.append([corner - 1 if corner > 0 else len(vertices) + corner for corner in corners])
    return triangles_of(vertices, polygons)


def read_off(data):
    lines = [line.split("#")[0].split() for line in data.decode("latin-1").splitlines()]
    lines = [words for words in lines if words]
    if lines[0][0].upper() in ("OFF", "COFF", "NOFF", "STOFF", "CNOFF"):
        lines[0] = lines[0][1:]
    lines = lines if lines[0] else lines[1:]
    vertex_count, face_count = int(lines[0][0]), int(lines[0][1])
    vertices = [[float(word) for word in words[:3]] for words in lines[1 : 1 + vertex_count]]
    faces = lines[1 + vertex_count : 1 + vertex_count + face_count]
    return triangles_of(vertices, [[int(word) for word in words[1 : 1 + int(words[0])]] for words in faces])


PLY_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
             "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "int64": "i8", "uint64": "u8",
             "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}


def read_ply(data):
    end = data.index(b"end_header")
    body = data[data.index(b"\n", end) + 1 :]
    elements = []
    for words in (line.split() for line in data[:end].decode("latin-1").splitlines()):
        if words[:1] == ["format"]:
            order = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}[words[1]]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:1] == ["property"]:
            elements[-1][2].append((words[-1], words[1:-1]))
    rows = rows_of_text(body, elements) if order is None else rows_of_bytes(body, elements, order)
    vertices = numpy.stack([numpy.asarray(rows["vertex"][axis], dtype=float) for axis in "xyz"], -1)
    faces = rows["face"]
    return triangles_of(vertices, faces.get("vertex_indices", faces.get("vertex_index")))


def rows_of_text(body, elements):
    words = iter(body.decode("latin-1").split())
    rows = {}
    for name, count, properties in elements:
        columns = {key: [] for key, _ in properties}
        for _ in range(count):
            for key, kinds in properties:
                if kinds[0] == "list":
                    columns[key].append([int(float(next(words))) for _ in range(int(next(words)))])
                else:
                    columns[key].append(float(next(words)))
        rows[name] = columns
    return rows


def rows_of_bytes(body, elements, order):
    offset, rows = 0, {}
    for name, count, properties in elements:
        lengths = [None] * len(properties)
        kind = None
        if count > 0:
            # Most lists of a file are of one length. Then a row is a struct.
            at, fields = offset, []
            for index, (key, kinds) in enumerate(properties):
                if kinds[0] == "list":
                    number = numpy.dtype(order + PLY_TYPES[kinds[1]])
                    lengths[index] = int(numpy.frombuffer(body, number, 1, at)[0])
                    fields += [(key + " length", number), (key, order + PLY_TYPES[kinds[2]], (lengths[index],))]
                else:
                    fields.append((key, order + PLY_TYPES[kinds[0]]))
                at = offset + numpy.dtype(fields).itemsize
            kind = numpy.dtype(fields)
            found = None
            if offset + count * kind.itemsize <= len(body):
                found = numpy.frombuffer(body, kind, count, offset)
                for index, (key, _) in enumerate(properties):
                    if lengths[index] is not None and (found[key + " length"] != lengths[index]).any():
                        found = None
                        break
            if found is not None:
                rows[name] = {key: found[key] for key, _ in properties}
                offset += count * kind.itemsize
                continue
        columns = {key: [] for key, _ in properties}
        for _ in range(count):
            for key, kinds in properties:
                length = 1
                if kinds[0] == "list":
                    number = numpy.dtype(order + PLY_TYPES[kinds[1]])
                    length = int(numpy.frombuffer(body, number, 1, offset)[0])
                    offset += number.itemsize
                value = numpy.dtype(order + PLY_TYPES[kinds[-1]])
                values = numpy.frombuffer(body, value, length, offset)
                offset += value.itemsize * length
                columns[key].append(values if kinds[0] == "list" else values[0])
        rows[name] = columns
    return rows


def triangles_of(vertices, polygons):
    vertices = numpy.asarray(vertices, dtype=float).reshape(-1, 3)
    if isinstance(polygons, numpy.ndarray) and polygons.ndim == 2 and polygons.shape[1] == 3:
        return vertices[polygons.astype(numpy.int64)]
    corners = []
    for polygon in polygons:
        polygon = [int(corner) for corner in polygon]
        corners += [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, len(polygon) - 1)] \
            if len(polygon) <= 3 or fan_is_right(vertices[polygon]) else ears(vertices, polygon)
    corners = numpy.array(corners, dtype=numpy.int64).reshape(-1, 3)
    if corners.size and (corners.min() < 0 or corners.max() >= len(vertices)):
        raise ValueError("an index is out of range")
    return vertices[corners]


def normals_of_fan(corners):
    spokes = corners[1:] - corners[0]
    spokes = spokes / max(numpy.abs(spokes).max(), 1e-300)
    return numpy.cross(spokes[:-1], spokes[1:])


def fan_is_right(corners):
    normals = normals_of_fan(corners)
    return bool((normals @ normals.sum(0) >= 0).all())


def ears(vertices, polygon):
    """Spikes are cut off first, then ears, and corners on a straight line only if no corner is an ear."""
    normal = normals_of_fan(vertices[polygon]).sum(0)
    axis = int(numpy.abs(normal).argmax())
    plane = [(axis + 1) % 3, (axis + 2) % 3]
    at = [tuple(position) for position in vertices[polygon][:, plane if normal[axis] > 0 else plane[::-1]]]
    fan = [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, len(polygon) - 1)]

    def area(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    def is_spike(a, b, c):
        return area(a, b, c) == 0 and (a[0] - b[0]) * (c[0] - b[0]) + (a[1] - b[1]) * (c[1] - b[1]) >= 0

    def is_ear(left, k):
        a, b, c = at[left[k - 1]], at[left[k]], at[left[(k + 1) % len(left)]]
        if area(a, b, c) <= 0:
            return False
        others = [at[left[(k + step) % len(left)]] for step in range(2, len(left))]  # from c's next one to a
        for p, q in zip(others, others[1:]):
            if area(c, a, p) >= 0 and p not in (a, c) and area(a, b, p) > 0 and area(b, c, p) > 0:
                return False
            if area(c, a, p) * area(c, a, q) < 0 and area(p, q, a) * area(p, q, c) < 0:
                return False
        return True

    left, found = list(range(len(polygon))), []
    tests = [lambda k: is_spike(at[left[k - 1]], at[left[k]], at[left[(k + 1) % len(left)]]),
             lambda k: is_ear(left, k),
             lambda k: area(at[left[k - 1]], at[left[k]], at[left[(k + 1) % len(left)]]) == 0]
    wanted, k, rejected = 0, 1, 0
    while len(left) > 2:
        k %= len(left)
        if tests[wanted](k):
            found.append((polygon[left[k - 1]], polygon[left[k]], polygon[left[(k + 1) % len(left)]]))
            del left[k]
            rejected = 0
            wanted = 1 if wanted == 2 else wanted
            continue
        k, rejected = k + 1, rejected + 1
        if rejected == len(left):
            if wanted == 2:
                return fan
            wanted, rejected = wanted + 1, 0
    return found
