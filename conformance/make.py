"""Writes the conformance set: make.py FOLDER [--archive FILE] [--digest].

A folder for each case, with mesh.obj, mesh.stl, points.npy, points.csv and answers.json (README.md says what is in
them), and index.json. --archive also writes all of it, with README.md and judge.py, as a .zip file. --digest prints the
SHA-256 of the names and contents. Python alone is needed. The same bytes on every run.
"""

import argparse
import hashlib
import json
import pathlib
import struct
import sys
import zipfile

from cases import CASES
from exact import Surface
from shapes import single

HERE = pathlib.Path(__file__).parent
RULES = {
    "closed": "inside: the winding number is not 0",
    "open": "inside: the winding number is 1/2 or more, or -1/2 or less",
    "repair": "inside: what the surface encloses, with doubled faces once and turned faces turned back",
    "no sign": "no sign: the mesh has no inside",
}


def longest_side(mesh):
    used = [mesh[0][corner] for face in mesh[1] for corner in face]
    return max(max(vertex[a] for vertex in used) - min(vertex[a] for vertex in used) for a in range(3))


def candidates(case, point):
    """The triangles that can be nearest, by balls around them, or None for all of a small mesh."""
    vertices, faces = case.mesh
    if len(faces) < 500:
        return None

    def distance(a, b):
        return sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5

    bounds = []
    for a, b, c in (tuple(vertices[corner] for corner in face) for face in faces):
        middle = tuple((a[i] + b[i] + c[i]) / 3 for i in range(3))
        bounds.append((distance(point, middle), max(distance(middle, corner) for corner in (a, b, c))))
    least = min(far for far, _ in bounds) * (1 + 1e-9)
    return [number for number, (far, radius) in enumerate(bounds) if far - radius <= least + 1e-9 + 1e-6 * radius]


def is_closed(mesh):
    """Whether each edge is used equally often both ways, by places."""
    uses = {}
    for face in mesh[1]:
        corners = [tuple(mesh[0][corner]) for corner in face]
        for a, b in zip(corners, corners[1:] + corners[:1]):
            uses[a, b] = uses.get((a, b), 0) + 1
            uses[b, a] = uses.get((b, a), 0) - 1
    return not any(uses.values())


def answers_of(case):
    vertices, faces = case.mesh
    for row in vertices if "doubles" in case.asks else [*vertices, *case.points]:
        assert all(x == single(x) for x in row), (case.name, row)
    has_sign = "no sign" not in case.asks
    is_open = "open" in case.asks
    assert not has_sign or is_open or is_closed(case.solid or case.mesh), case.name
    # 1e-5 of 1/256 of the longest side.
    tolerance = longest_side(case.mesh) / 25_600_000
    surface = Surface(vertices, faces, case.points, case.solid)
    rule = "no sign" if not has_sign else next((word for word in ("repair", "open") if word in case.asks), "closed")
    answers = {
        "name": case.name,
        "kind": case.kind,
        "fails": case.fails,
        "thread": "https://github.com/" + case.thread if case.thread else None,
        "asks": list(case.asks),
        "rule": RULES[rule],
        "tolerance": tolerance,
        "triangles_of_mesh": len(faces),
        "distance": [],
        "sign": [],
        "closest": [],
        "triangle": [],
    }
    if is_open:
        answers["winding"] = []
    for point in case.points:
        distance, allowed = surface.nearest(point, tolerance, candidates(case, point))
        answers["distance"].append(distance)
        answers["triangle"].append([number for number, _ in allowed])
        answers["closest"].append(list(dict.fromkeys(place for _, place in allowed)))
        if distance == 0 or not has_sign:
            inside = False
        elif is_open:
            winding = surface.open_winding(point)
            assert abs(abs(winding) - type(winding)("0.5")) > type(winding)("0.01"), (case.name, point, winding)
            inside = abs(winding) > type(winding)("0.5")
            answers["winding"].append(float(winding))
        else:
            inside = surface.winding(point)[0] != 0
        answers["sign"].append(0 if distance == 0 or not has_sign else -1 if inside else 1)
    return answers


def obj(case):
    lines = [f"# {case.name}"]
    lines += [f"v {' '.join(repr(float(x)) for x in vertex)}" for vertex in case.mesh[0]]
    lines += [f"f {' '.join(str(corner + 1) for corner in face)}" for face in case.mesh[1]]
    return ("\n".join(lines) + "\n").encode()


def stl(case):
    """Binary; without normals, which readers compute."""
    vertices, faces = case.mesh
    parts = [b"clsdf conformance".ljust(80), struct.pack("<I", len(faces))]
    for face in faces:
        parts.append(struct.pack("<12fH", 0, 0, 0, *(x for corner in face for x in vertices[corner]), 0))
    return b"".join(parts)


def npy(points):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({len(points)}, 3), }}"
    text = header.ljust(117) + "\n"
    rows = b"".join(struct.pack("<3d", *point) for point in points)
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode() + rows


def csv(points):
    return ("x,y,z\n" + "".join(",".join(repr(float(x)) for x in point) + "\n" for point in points)).encode()


def text_of(answers):
    """A member a line, so that differences are readable."""
    members = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in answers.items()]
    return ("{\n" + ",\n".join(members) + "\n}\n").encode()


def files():
    """Names and contents, in order."""
    index = []
    for case in CASES:
        answers = answers_of(case)
        index.append({name: answers[name] for name in ("name", "kind", "fails", "thread", "asks")})
        yield f"{case.name}/mesh.obj", obj(case)
        yield f"{case.name}/mesh.stl", stl(case)
        yield f"{case.name}/points.npy", npy(case.points)
        yield f"{case.name}/points.csv", csv(case.points)
        yield f"{case.name}/answers.json", text_of(answers)
    lines = ",\n".join(json.dumps(row) for row in index)
    yield "index.json", f"[\n{lines}\n]\n".encode()


def archive(contents):
    """The bytes of a .zip file; times and rights are always the same."""
    import io

    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as file:
        for name, content in contents:
            info = zipfile.ZipInfo("clsdf-conformance/" + name, (1980, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            info.create_system = 3
            file.writestr(info, content, compresslevel=9)
    return buffer.getvalue()


def digest(contents):
    sum_ = hashlib.sha256()
    for name, content in contents:
        sum_.update(f"{name} {len(content)}\n".encode() + content)
    return sum_.hexdigest()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--archive", type=pathlib.Path)
    parser.add_argument("--digest", action="store_true")
    options = parser.parse_args()
    contents = list(files())
    for name, content in contents:
        path = options.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    if options.archive:
        with_tools = [(name, (HERE / name).read_bytes()) for name in ("README.md", "judge.py")] + contents
        options.archive.write_bytes(archive(with_tools))
        print(f"{options.archive}: {options.archive.stat().st_size} bytes", file=sys.stderr)
    if options.digest:
        print(digest(contents))


if __name__ == "__main__":
    main()
