"""seeded_faults.py SOURCES SET [COMMAND]: the judges pass right results and find each seeded fault.

The judges are conformance/judge.py with the answers of the set, the same by brute force, and `clsdf check --points`.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import numpy
except ImportError:
    print("skipped: this Python has no NumPy")
    sys.exit()

sources, set_folder = map(pathlib.Path, sys.argv[1:3])
command = sys.argv[3] if len(sys.argv) > 3 else ""
sys.path.insert(0, str(sources))
import judge  # noqa: E402

NO_TRIANGLE = 0xFFFFFFFF


class Results:
    """Right results of a case, to be spoilt."""

    def __init__(self, name):
        self.name = name
        self.answers, self.points = judge.case_of(set_folder / name)
        self.right = numpy.array(self.answers["distance"])
        self.sign = numpy.array(self.answers["sign"])
        self.voxel = self.answers["tolerance"] * 1e5
        self.distance = numpy.where(self.sign < 0, -self.right, self.right)
        self.closest = numpy.array([places[0] for places in self.answers["closest"]])
        self.triangles = numpy.array([numbers[0] for numbers in self.answers["triangle"]], dtype=numpy.uint32)
        away = self.points - self.closest
        length = numpy.linalg.norm(away, axis=1)
        self.gradients = numpy.where(self.sign < 0, -1, 1)[:, None] * away / numpy.where(length > 0, length, 1)[:, None]

    def first(self, wanted):
        """The number of the first point of which this is true: inside, outside, on (the surface), beside it, far."""
        is_wanted = {
            "inside": self.sign < 0,
            "outside": self.sign > 0,
            "on": self.right == 0,
            "beside": (self.right > 0) & (self.right < 2e-6),
            "beside and inside": (self.right > 0) & (self.right < 2e-6) & (self.sign < 0),
            "far": self.right == self.right.max(),
        }[wanted]
        return int(numpy.flatnonzero(is_wanted)[0])

    def judged(self):
        """What each judge says: the names of the counts that are not 0."""
        everything = {"closest": self.closest, "gradients": self.gradients, "triangles": self.triangles}
        answers = judge.judge(self.answers, self.points, self.distance, **everything)
        yield "answers", {count for count in judge.COUNTS if answers[count]}
        if "repair" not in self.answers["asks"] and "doubles" not in self.answers["asks"]:
            corners = judge.read_obj(set_folder / self.name / "mesh.obj")
            has_sign = "no sign" not in self.answers["asks"]
            brute = judge.answers_by_brute_force(corners, self.points, has_sign)
            report = judge.judge(brute, self.points, self.distance, **everything)
            yield "brute force", {count for count in judge.COUNTS if report[count]}
        if command:
            yield "clsdf check", self.by_command()

    def by_command(self):
        with tempfile.TemporaryDirectory() as folder:
            files = {}
            for option in ("distances", "closest", "gradients", "triangles"):
                files[option] = f"{folder}/{option}.npy"
                numpy.save(files[option], self.distance if option == "distances" else getattr(self, option))
            case = set_folder / self.name
            line = [command, "check", case / "mesh.obj", "--points", case / "points.npy", "--json", "--quiet"]
            for option, file in files.items():
                line += ["--" + option, file]
            ended = subprocess.run(line, capture_output=True, text=True)
            if ended.returncode not in (0, 1):
                return {f"exit status {ended.returncode}: {ended.stderr}"}
            report = json.loads(ended.stdout)
            found = {count for count in judge.COUNTS if report[count]}
            if (ended.returncode == 0) != (not found) or report["passed"] != (not found):
                found.add(f"exit status {ended.returncode}")
            return found


def at(which, change):
    """A fault of one point: change(results, its number)."""

    def spoil(results):
        change(results, results.first(which))

    return spoil


def put(name, value):
    """The value, or value(results, n), in an array at the point."""

    def change(results, n):
        getattr(results, name)[n] = value(results, n) if callable(value) else value

    return change


def swap_triangles(results):
    n = next(k for k in range(len(results.points) - 1)
             if results.triangles[k] not in results.answers["triangle"][k + 1])  # fmt: skip
    results.triangles[[n, n + 1]] = results.triangles[[n + 1, n]]


def all_of(name, change):
    def spoil(results):
        setattr(results, name, change(results))

    return spoil


def along(results, n, step):
    """The closest point moved within its face."""
    side = numpy.cross(results.gradients[n], [0.3, 0.5, 0.8])
    return results.closest[n] + step * side / numpy.linalg.norm(side)


D, S, C, G, T = judge.COUNTS
FAULTS = [
    ("a wrong sign inside", "cavity", at("inside", put("distance", lambda r, n: -r.distance[n])), S),
    ("a wrong sign outside", "tetrahedron", at("outside", put("distance", lambda r, n: -r.distance[n])), S),
    ("a wrong sign 1e-6 beside the surface", "cube-surface", at("beside", put("distance", lambda r, n: -r.distance[n])), S),
    ("a zero just inside", "cube-surface", at("beside and inside", put("distance", 0.0)), S),
    ("a wrong sign far away", "cube-far", at("far", put("distance", lambda r, n: -r.distance[n])), S),
    ("a wrong sign at the last place", "last-place", at("inside", put("distance", lambda r, n: -r.distance[n])), S),
    ("2e-5 voxel too much", "gradients", at("outside", put("distance", lambda r, n: r.distance[n] + 2e-5 * r.voxel)), D),
    ("2e-5 voxel too little", "bend", at("inside", put("distance", lambda r, n: r.distance[n] + 2e-5 * r.voxel)), D),
    ("three last places far away", "cube-far", at("far", put("distance", lambda r, n: r.distance[n] + 3 * float(numpy.spacing(numpy.float32(r.right[n]))))), D),
    ("no number", "needle", at("outside", put("distance", numpy.nan)), D),
    ("infinity", "needle", at("outside", put("distance", numpy.inf)), D),
    ("zero off the surface", "stairs", at("outside", put("distance", 0.0)), D),
    ("1e-4 on the surface", "tetrahedron-surface", at("on", put("distance", 1e-4)), D),
    ("squared distances", "pocket", all_of("distance", lambda r: numpy.sign(r.distance) * r.distance**2), D),
    ("distances of half precision", "sphere-lattice", all_of("distance", lambda r: r.distance.astype(numpy.float16).astype(float)), D),
    ("distances a millionth too long", "two-bodies", all_of("distance", lambda r: r.distance * (1 + 1e-6)), D),
    ("results of the next point", "star", all_of("distance", lambda r: numpy.roll(r.distance, 1)), D),
    ("distances to the other body", "in-turn-1", all_of("distance", lambda r: Results("in-turn-2").distance), D),
    ("distances as if one of two bodies were alone", "overlap", at("inside", put("distance", lambda r, n: 3 * r.distance[n])), D),
    ("all signs opposite", "obtuse-tetrahedron", all_of("distance", lambda r: -r.distance), S),
    ("a cavity that is filled", "nested-shells", all_of("distance", lambda r: numpy.where(numpy.abs(r.points).max(1) < 8, -r.right, r.right)), S),
    ("a negative distance to a sheet", "sheet", at("far", put("distance", lambda r, n: -r.distance[n])), S),
    ("two triangles exchanged", "tetrahedron", swap_triangles, T),
    ("a triangle that is not nearest", "octahedron-axes", at("inside", put("triangles", lambda r, n: next(t for t in range(8) if t not in r.answers["triangle"][n]))), T),
    ("no triangle", "hole", at("outside", put("triangles", NO_TRIANGLE)), T),
    ("triangles counted from 1", "bend", all_of("triangles", lambda r: r.triangles + 1), T),
    ("a closest point moved by 1e-4 voxel", "gradients", at("outside", put("closest", lambda r, n: along(r, n, 1e-4 * r.voxel) + 1e-4 * r.voxel * r.gradients[n])), C),
    ("the mean of several closest points", "equal-distances", at("inside", put("closest", lambda r, n: numpy.mean(r.answers["closest"][n], axis=0))), C),
    ("the point as its own closest point", "plate-on-samples", at("outside", put("closest", lambda r, n: r.points[n])), C),
    ("axes of a closest point exchanged", "pocket", at("outside", put("closest", lambda r, n: r.closest[n][[1, 2, 0]])), C),
    ("a gradient into the body outside", "gradients", at("outside", put("gradients", lambda r, n: -r.gradients[n])), G),
    ("a gradient without the sign inside", "bend", at("inside", put("gradients", lambda r, n: -r.gradients[n])), G),
    ("a gradient that is not of unit length", "gradients", at("outside", put("gradients", lambda r, n: 1.001 * r.gradients[n])), G),
    ("a gradient off by 1e-4", "slit", at("outside", put("gradients", lambda r, n: r.gradients[n] + 1e-4 * numpy.roll(r.gradients[n], 1))), G),
    ("a gradient that is no number", "tetrahedron", at("outside", put("gradients", numpy.nan)), G),
]  # fmt: skip


def main():
    faults, judged = [], 0
    for name in sorted({name for _, name, _, _ in FAULTS}):
        for judge_name, found in Results(name).judged():
            if found:
                faults.append(f"{judge_name}: {name} without a fault: {sorted(found)}")
    for what, name, spoil, expected in FAULTS:
        results = Results(name)
        spoil(results)
        for judge_name, found in results.judged():
            judged += 1
            if expected not in found:
                faults.append(f"{judge_name}: {what} ({name}): {sorted(found)} instead of {expected}")
    print(f"{len(FAULTS)} faults, {judged} times judged")
    for fault in faults:
        print(fault)
    return 1 if faults or len(FAULTS) < 30 else 0


sys.exit(main())
