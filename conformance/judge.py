#!/usr/bin/env python3
"""Judges signed distances of any program. It needs numpy alone.

    judge.py SET RESULTS                       the whole set: RESULTS/NAME.npy or NAME.csv for each case
    judge.py SET/NAME --distances D            one case
    judge.py MESH --points P --distances D     any mesh, .obj or .stl, by looking at every triangle in double precision

D is an .npy file of one number for each point, negative inside, or a .csv file with a column "distance". In SET RESULTS
an .npy file may also have the members distance, closest (3), gradient (3) and triangle, and a .csv file the columns
closest_x, closest_y, closest_z, gradient_x, ..., triangle, as "clsdf query" writes them.

A distance is right within the case's tolerance (1e-5 of 1/256 of the mesh's longest side), or two last places of a
float if that is more. The sign must be right at every point off the surface. A closest point, a gradient and a triangle
must be one of those that the case allows. The exit status is 1 if something is wrong.
"""

import argparse
import json
import pathlib
import sys

import numpy

COUNTS = ("wrong_distances", "wrong_signs", "wrong_closest", "wrong_gradients", "wrong_triangles")
MOST_FINDINGS = 10


def judge(answers, points, distance, closest=None, gradients=None, triangles=None, tolerance=None):
    """Compares results with answers, as of answers.json, and returns a report.

    points: (n, 3). distance: (n,), negative inside. closest, gradients: (n, 3). triangles: (n,), numbers from 0 on.
    tolerance: replaces that of the answers, in units of the mesh.
    """
    points = numpy.asarray(points, dtype=float)
    count = len(answers["distance"])
    results = {"points": points, "distances": distance, "closest": closest, "gradients": gradients, "triangles": triangles}
    for name, values in results.items():
        width = (count,) if name in ("distances", "triangles") else (count, 3)
        if values is not None and numpy.shape(values) != width:
            raise ValueError(f"{name} have the shape {numpy.shape(values)}, and there are {count} points: give {width}")
    distance = numpy.asarray(distance, dtype=float)
    right = numpy.array(answers["distance"], dtype=float)
    sign = numpy.array(answers["sign"], dtype=int)
    has_sign = not answers["rule"].startswith("no sign")
    voxel = answers["tolerance"] * 1e5
    with numpy.errstate(over="ignore"):
        last_place = numpy.spacing(right) if tolerance is not None else numpy.spacing(right.astype(numpy.float32))
    allowed = numpy.maximum(answers["tolerance"] if tolerance is None else tolerance, 2 * last_place.astype(float))
    error = numpy.abs(numpy.abs(distance) - right)

    report = {"points": count, **{name: 0 for name in COUNTS}, "findings": []}
    finite = error[numpy.isfinite(error)]
    report["max_error"] = float(numpy.max(finite)) if len(finite) else 0.0
    if len(finite) < count:
        report["max_error"] = float("inf")

    def find(what, number, text):
        report[what] += 1
        if len(report["findings"]) < MOST_FINDINGS:
            report["findings"].append({"point": int(number), "position": points[number].tolist(), "what": text})

    for n in range(count):
        d = float(distance[n])
        if not error[n] <= allowed[n]:
            find("wrong_distances", n, f"the distance is {d!r} instead of {float(right[n])!r}")
        if has_sign and sign[n] and not numpy.isnan(d):
            # Zero has the sign of its last place, unless no float is nearer to the surface.
            negative = bool(numpy.signbit(d))
            if negative != (sign[n] < 0) and not (d == 0 and numpy.float32(right[n]) == 0):
                find("wrong_signs", n, f"{'inside' if sign[n] < 0 else 'outside'}, but the distance is {d!r}")
        elif not has_sign and d < 0:
            find("wrong_signs", n, f"the mesh has no inside, but the distance is {d!r}")
        places = numpy.array(answers["closest"][n], dtype=float)
        largest = max(numpy.abs(points[n]).max(), numpy.abs(places).max())
        rounding = 4 * numpy.finfo(float).eps * largest
        if closest is not None:
            off = numpy.linalg.norm(places - numpy.asarray(closest[n], dtype=float), axis=1).min()
            if not off <= max(allowed[n], rounding):
                find("wrong_closest", n, f"the closest point {numpy.asarray(closest[n]).tolist()} is off by {off:.3g}")
        if gradients is not None and right[n] > 1e-10 * voxel:
            away = points[n] - places
            lengths = numpy.linalg.norm(away, axis=1)
            if numpy.all(lengths > 0):
                side = -1.0 if sign[n] < 0 else 1.0
                given = numpy.asarray(gradients[n], dtype=float)
                off = numpy.linalg.norm(side * away / lengths[:, None] - given, axis=1).min()
                if not off <= 1e-5 + (2e-6 * voxel + rounding) / right[n]:
                    find("wrong_gradients", n, f"the gradient {given.tolist()} is off by {off:.3g}")
        if triangles is not None and int(triangles[n]) not in answers["triangle"][n]:
            find("wrong_triangles", n, f"triangle {int(triangles[n])} is not among {answers['triangle'][n][:8]}")
    report["passed"] = not any(report[name] for name in COUNTS)
    return report


# Any mesh, by brute force.


def read_obj(path):
    vertices, faces = [], []
    for line in pathlib.Path(path).read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [corner - 1 if corner > 0 else len(vertices) + corner for corner in corners]
            faces += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
    return numpy.array(vertices, dtype=float)[numpy.array(faces, dtype=int)]


def read_stl(path):
    data = pathlib.Path(path).read_bytes()
    count = int.from_bytes(data[80:84], "little")
    if len(data) != 84 + 50 * count:
        raise ValueError(f"{path}: only binary .stl files are read")
    rows = numpy.frombuffer(data[84:], dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    return rows["corners"].astype(float)


def closest_on_triangles(point, corners):
    """Distances and closest points of all triangles, without a division by an area."""
    best = numpy.full(len(corners), numpy.inf)
    places = numpy.empty((len(corners), 3))
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    for start, end in ((a, b), (b, c), (c, a)):
        along = end - start
        square = (along * along).sum(1)
        way = numpy.clip(((point - start) * along).sum(1) / numpy.where(square > 0, square, 1), 0, 1)
        place = start + way[:, None] * along
        place[way == 1] = end[way == 1]
        far = numpy.linalg.norm(point - place, axis=1)
        nearer = far < best
        best[nearer], places[nearer] = far[nearer], place[nearer]
    normal = numpy.cross(b - a, c - a)
    length = numpy.linalg.norm(normal, axis=1)
    within = length > 0
    for start, end in ((a, b), (b, c), (c, a)):
        within &= (numpy.cross(end - start, point - start) * normal).sum(1) >= 0
    unit = normal / numpy.where(length > 0, length, 1)[:, None]
    height = ((point - a) * unit).sum(1)
    nearer = within & (numpy.abs(height) < best)
    best[nearer] = numpy.abs(height[nearer])
    places[nearer] = (point - height[:, None] * unit)[nearer]
    return best, places


def winding_number(point, corners):
    """The solid angles of all faces over 4 pi."""
    a, b, c = (corners[:, k] - point for k in range(3))
    la, lb, lc = (numpy.linalg.norm(v, axis=1) for v in (a, b, c))
    volume = (a * numpy.cross(b, c)).sum(1)
    rest = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return numpy.arctan2(volume, rest).sum() / (2 * numpy.pi)


def answers_by_brute_force(corners, points, has_sign=True):
    """Answers for any mesh. A sign is 0, and not judged, if the winding number is within 1e-6 of 1/2, and within rounding
    of the surface."""
    side = (corners.max((0, 1)) - corners.min((0, 1))).max()
    tolerance = side / 25_600_000
    rule = "inside: the winding number is 1/2 or more, or -1/2 or less" if has_sign else "no sign: none was asked for"
    answers = {"tolerance": tolerance, "rule": rule, "distance": [], "sign": [], "closest": [], "triangle": []}
    for point in numpy.asarray(points, dtype=float):
        distances, places = closest_on_triangles(point, corners)
        least = distances.min()
        near = numpy.flatnonzero(distances <= least + max(tolerance, 4e-16 * least))
        winding = abs(winding_number(point, corners)) if has_sign else 0
        is_clear = has_sign and least > 1e-15 * numpy.abs(corners).max() and abs(winding - 0.5) > 1e-6
        answers["distance"].append(float(least))
        answers["sign"].append((-1 if winding > 0.5 else 1) if is_clear else 0)
        answers["closest"].append(places[near].tolist())
        answers["triangle"].append(near.tolist())
    return answers


# Files.


def read_column(path, names):
    """A number, or a vector, for each point."""
    path = pathlib.Path(path)
    if path.suffix == ".csv":
        with open(path) as file:
            header = [word.strip() for word in file.readline().lstrip("#").split(",")]
        missing = [name for name in names if name not in header]
        if missing:
            return None
        columns = [header.index(name) for name in names]
        values = numpy.loadtxt(path, delimiter=",", skiprows=1, usecols=columns, ndmin=2)
        return values[:, 0] if len(names) == 1 else values
    values = numpy.load(path, allow_pickle=False)
    if values.dtype.names:
        member = names[0].rsplit("_", 1)[0] if len(names) == 3 else names[0]
        return values[member] if member in values.dtype.names else None
    return values.reshape(-1) if len(names) == 1 else values


def vector(name):
    return [f"{name}_{axis}" for axis in "xyz"]


def results_of(folder, name):
    """What a file of RESULTS has for a case; None if there is no file."""
    for ending in (".npy", ".csv"):
        path = pathlib.Path(folder) / (name + ending)
        if path.exists():
            is_bare = ending == ".npy" and numpy.load(path, allow_pickle=False).dtype.names is None
            found = {"distance": read_column(path, ["distance"])}
            if not is_bare:
                found["closest"] = read_column(path, vector("closest"))
                found["gradients"] = read_column(path, vector("gradient"))
                found["triangles"] = read_column(path, ["triangle"])
            return found
    return None


def case_of(folder):
    folder = pathlib.Path(folder)
    return json.loads((folder / "answers.json").read_text()), numpy.load(folder / "points.npy")


def row(name, report):
    wrong = " | ".join(str(report[count]) for count in COUNTS)
    return f"| {name} | {report['points']} | {report['max_error']:.3g} | {wrong} |"


HEADING = """| case | points | largest error | wrong distances | wrong signs | wrong closest points | wrong gradients | wrong triangles |
|-|-:|-:|-:|-:|-:|-:|-:|"""


def judge_set(folder, results, tolerance):
    """Reports by the name of the case. A case without results is refused."""
    reports = {}
    for about in json.loads((pathlib.Path(folder) / "index.json").read_text()):
        found = results_of(results, about["name"])
        answers, points = case_of(pathlib.Path(folder) / about["name"])
        if found is None:
            reports[about["name"]] = {"refused": True, "passed": False, "points": len(points)}
        else:
            reports[about["name"]] = judge(answers, points, tolerance=tolerance, **found)
    return reports


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", metavar="SET|CASE|MESH", type=pathlib.Path)
    parser.add_argument("results", metavar="RESULTS", nargs="?", type=pathlib.Path)
    parser.add_argument("--points", metavar="P", help=".npy of shape (n, 3), or .csv with the columns x, y and z")
    parser.add_argument("--distances", metavar="D")
    parser.add_argument("--closest", metavar="C", help=".npy of shape (n, 3), or .csv with the columns closest_x, ...")
    parser.add_argument("--gradients", metavar="G", help=".npy of shape (n, 3), or .csv with the columns gradient_x, ...")
    parser.add_argument("--triangles", metavar="T", help=".npy of whole numbers, or .csv with the column triangle")
    parser.add_argument("--no-sign", action="store_true", help="of a mesh: it has no inside")
    parser.add_argument("--tolerance", type=float, help="in units of the mesh")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if (options.results is None) == (options.distances is None):
        parser.error("give RESULTS for a set, or --distances for a case or a mesh")
    if options.results is None and options.what.is_file() and options.points is None:
        parser.error("give the --points of a mesh")
    return options


def column_of(path, names):
    if path is None:
        return None
    values = read_column(path, names)
    if values is None:
        raise SystemExit(f"{path}: there is no column {names[0]}")
    return values


def main():
    options = parse()
    if options.results is not None:
        reports = judge_set(options.what, options.results, options.tolerance)
    else:
        if options.what.is_file():
            points = column_of(options.points, ["x", "y", "z"])
            corners = (read_stl if options.what.suffix.lower() == ".stl" else read_obj)(options.what)
            answers = answers_by_brute_force(corners, points, not options.no_sign)
        else:
            answers, points = case_of(options.what)
        found = {
            "distance": column_of(options.distances, ["distance"]),
            "closest": column_of(options.closest, vector("closest")),
            "gradients": column_of(options.gradients, vector("gradient")),
            "triangles": column_of(options.triangles, ["triangle"]),
        }
        reports = {options.what.name: judge(answers, points, tolerance=options.tolerance, **found)}
    passed = all(report["passed"] for report in reports.values())
    if options.json:
        print(json.dumps({"passed": passed, "cases": reports}, indent=1))
    else:
        print(HEADING)
        for name, report in reports.items():
            print(f"| {name} | {report['points']} | refused | | | | | |" if report.get("refused") else row(name, report))
        for name, report in reports.items():
            for finding in report.get("findings", []):
                print(f"{name}: point {finding['point']} {tuple(finding['position'])}: {finding['what']}")
        print("passed" if passed else "FAILED")
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
