"""Meshes by hand: pairs of a list of vertices and a list of faces. All coordinates are floats."""

import struct


def single(x):
    """The float nearest to a number."""
    return struct.unpack("<f", struct.pack("<f", x))[0]


def singles(row):
    return tuple(single(x) for x in row)


def box(lower, upper):
    """12 triangles that look outwards."""
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    vertices = [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return vertices, [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]


def cube(side=1.0, at=(0.0, 0.0, 0.0)):
    return box(at, tuple(x + side for x in at))


def tetrahedron(a, b, c, d):
    """Faces that look outwards if d is above the triangle (a, b, c), seen from where it is counterclockwise."""
    return [a, b, c, d], [(0, 2, 1), (0, 3, 2), (0, 1, 3), (1, 2, 3)]


def octahedron(radius=1.0, at=(0.0, 0.0, 0.0)):
    rays = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    vertices = [tuple(at[i] + radius * ray[i] for i in range(3)) for ray in rays]
    return vertices, [
        (0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5),
    ]  # fmt: skip


def extrude(corners, z0, z1):
    """A prism over a polygon, counterclockwise and star-shaped as seen from its first corner."""
    count = len(corners)
    vertices = [(x, y, z) for z in (z0, z1) for x, y in corners]
    faces = [(0, k + 1, k) for k in range(1, count - 1)]
    faces += [(count, count + k, count + k + 1) for k in range(1, count - 1)]
    for k in range(count):
        after = (k + 1) % count
        faces += [(k, after, count + after), (k, count + after, count + k)]
    return vertices, faces


def grid_box(lower, upper, count):
    """A box whose sides have count by count squares of two triangles each."""
    numbers, vertices, faces = {}, [], []

    def corner(i, j, k):
        if (i, j, k) not in numbers:
            numbers[i, j, k] = len(vertices)
            vertices.append(tuple(lower[a] + (upper[a] - lower[a]) * n / count for a, n in enumerate((i, j, k))))
        return numbers[i, j, k]

    def square(a, b, c, d):
        faces.extend([(a, b, c), (a, c, d)])

    for axis in range(3):
        for at in (0, count):
            for u in range(count):
                for v in range(count):
                    ends = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)]
                    if at == 0:
                        ends.reverse()
                    place = [None] * 3
                    corners = []
                    for s, t in ends:
                        place[axis], place[(axis + 1) % 3], place[(axis + 2) % 3] = at, s, t
                        corners.append(corner(*place))
                    square(*corners)
    return vertices, faces


def subdivided(mesh, times=1):
    """Each triangle in four."""
    vertices, faces = list(mesh[0]), list(mesh[1])
    for _ in range(times):
        middles, finer = {}, []

        def middle(a, b):
            key = min(a, b), max(a, b)
            if key not in middles:
                middles[key] = len(vertices)
                vertices.append(tuple((vertices[a][i] + vertices[b][i]) / 2 for i in range(3)))
            return middles[key]

        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = finer
    return vertices, faces


def rounded(mesh, radius=1.0):
    """The vertices moved onto a sphere, as floats."""
    vertices = []
    for x, y, z in mesh[0]:
        length = (x * x + y * y + z * z) ** 0.5
        vertices.append(singles((radius * x / length, radius * y / length, radius * z / length)))
    return vertices, mesh[1]


def joined(*meshes):
    """Several bodies in one mesh."""
    vertices, faces = [], []
    for some, their_faces in meshes:
        faces += [tuple(len(vertices) + corner for corner in face) for face in their_faces]
        vertices += some
    return vertices, faces


def turned(mesh, which=None):
    """The faces, or those of these numbers, look the other way."""
    vertices, faces = mesh
    return vertices, [
        (a, c, b) if which is None or number in which else (a, b, c) for number, (a, b, c) in enumerate(faces)
    ]


def moved(mesh, by):
    return [tuple(x + y for x, y in zip(vertex, by)) for vertex in mesh[0]], mesh[1]


def scaled(mesh, factors):
    factors = factors if isinstance(factors, tuple) else (factors,) * 3
    return [tuple(x * f for x, f in zip(vertex, factors)) for vertex in mesh[0]], mesh[1]


def without(mesh, which):
    return mesh[0], [face for number, face in enumerate(mesh[1]) if number not in which]


def with_faces(mesh, faces):
    return mesh[0], mesh[1] + list(faces)


# Points. Sums and products are rounded to floats.


def lattice(lower, upper, count):
    """count^3 points, both ends included."""
    axis = [[lower[a] + (upper[a] - lower[a]) * n / (count - 1) for n in range(count)] for a in range(3)]
    return [singles((x, y, z)) for z in axis[2] for y in axis[1] for x in axis[0]]


def on_sites(mesh, faces=None):
    """Every vertex, the middle of every edge and a point within every face, of some faces."""
    vertices, triangles = mesh
    found = {}
    for number in range(len(triangles)) if faces is None else faces:
        a, b, c = (vertices[corner] for corner in triangles[number])
        for weights in ((4, 0, 0), (0, 4, 0), (0, 0, 4), (2, 2, 0), (0, 2, 2), (2, 0, 2), (2, 1, 1)):
            total = tuple((weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i]) / 4 for i in range(3))
            if total == singles(total):
                found[total] = None
    return list(found)


def beside(points, step, directions=None):
    """Two points beside each one, to both sides along a direction of many."""
    directions = directions or [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1), (-1, 1, 0), (1, -2, 1)]
    result = []
    for number, point in enumerate(points):
        direction = directions[number % len(directions)]
        for side in (step, -step):
            result.append(singles(point[i] + side * direction[i] for i in range(3)))
    return result


def around(mesh, distances, faces=None):
    """Points outside vertices and middles of edges, away from the mesh's middle, near and far."""
    vertices = mesh[0]
    middle = tuple(sum(vertex[i] for vertex in vertices) / len(vertices) for i in range(3))
    result = []
    for point in on_sites(mesh, faces):
        away = tuple(point[i] - middle[i] for i in range(3))
        length = max(abs(x) for x in away) or 1
        result += [singles(point[i] + far * away[i] / length for i in range(3)) for far in distances]
    return result
