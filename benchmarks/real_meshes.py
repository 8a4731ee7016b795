"""Judges "clsdf info" and "clsdf query" on the mesh files of packages: scripts/real-meshes.

Files of equal content count once. The sign rule of each follows from what "info" counts. A share of the files, chosen by
their content and the seed, is judged by points, and the rule with them. Half of a file's points lie in its box and up to 10% around it, the others within
1e-5 to 3% of its longest side from random places of its surface. A file of more than 100,000 triangles gets fewer
points, so that it has 15 million pairs, but 10 at least.

The distance is compared with that to all triangles by brute force in double, the sign with

- nonzero: the sum of the solid angles in double, whose integer is the winding number;
- parity: the crossings of three random rays, which must agree;
- solid-angle: that sum, whose magnitude is 1/2 or more inside;
- none: no distance may be negative.

Points in doubt are counted apart: within 1e-6 of the longest side from the surface, or a winding number within 0.1 of
1/2 (1e-8 for solid-angle), or rays that do not agree.

Readers and the rules of docs/sign.md are written once more here, so the command's rule and the surface that decides the
sign are compared, too. Only the tests of winding numbers are not: whether an open mesh has a sign, whether its parts are
turned, and whether its sheets are left out. The command's answers are taken. The faces that are turned or left out then
are found here.
"""
import argparse
import collections
import concurrent.futures
import datetime
import hashlib
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

import numpy

import mesh_readers

ENDINGS = {".stl", ".obj", ".off", ".ply"}
CHUNK = 16384  # pairs of a point and a triangle whose values stay in the cache
FORMAT = 5  # of what is kept; another number judges all files again


# Truth ----------------------------------------------------------------------------------------------------------------
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def squared_distances(points, corners):
    """Of each point (n, 1) from each triangle (m). No value is below the square of the distance but by rounding."""
    best = None
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start = corners[first]
        edge = [corners[second][axis] - start[axis] for axis in range(3)]
        offset = [points[axis] - start[axis] for axis in range(3)]
        length = dot(edge, edge)
        along = numpy.clip(dot(offset, edge) / numpy.where(length > 0, length, 1), 0, 1)
        rest = [offset[axis] - along * edge[axis] for axis in range(3)]
        best = dot(rest, rest) if best is None else numpy.minimum(best, dot(rest, rest))
        if first == 0:
            ab, from_a = edge, offset
    ac = [corners[2][axis] - corners[0][axis] for axis in range(3)]
    bb, bc, cc = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    determinant = bb * cc - bc * bc
    safe = numpy.where(determinant > 0, determinant, 1)
    b, c = dot(from_a, ab), dot(from_a, ac)
    u, v = (cc * b - bc * c) / safe, (bb * c - bc * b) / safe
    within = (determinant > 0) & (u >= 0) & (v >= 0) & (u + v <= 1)
    rest = [from_a[axis] - u * ab[axis] - v * ac[axis] for axis in range(3)]
    return numpy.where(within, numpy.minimum(best, dot(rest, rest)), best)


def solid_angles(points, corners):
    """Of each triangle (m) at each point (n, 1), as parts of 4 pi (van Oosterom and Strackee 1983)."""
    a, b, c = ([corner[axis] - points[axis] for axis in range(3)] for corner in corners)
    la, lb, lc = (numpy.sqrt(dot(side, side)) for side in (a, b, c))
    across = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb
    return numpy.arctan2(dot(a, cross(b, c)), across) / (2 * numpy.pi)


def crossings(points, corners, direction):
    """Whether the ray from each point (n, 1) crosses each triangle (m) (Moeller and Trumbore 1997)."""
    ab, ac = ([corners[k][axis] - corners[0][axis] for axis in range(3)] for k in (1, 2))
    h = cross(direction, ac)
    determinant = dot(ab, h)
    safe = numpy.where(determinant != 0, determinant, 1)
    offset = [points[axis] - corners[0][axis] for axis in range(3)]
    q = cross(offset, ab)
    u, v, t = dot(offset, h) / safe, dot(direction, q) / safe, dot(ac, q) / safe
    return (determinant != 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)


def over_triangles(points, triangles, function, reduce, start):
    """Reduces function(points, triangles) over the triangles; of a point, in the order of the blocks."""
    result = numpy.full(len(points), start, dtype=float)
    columns = [points[:, axis, None] for axis in range(3)]
    block = max(1, CHUNK // max(1, len(points)))
    for begin in range(0, len(triangles), block):
        part = triangles[begin : begin + block]
        corners = [[part[:, k, axis] for axis in range(3)] for k in range(3)]
        result = reduce(result, function(columns, corners), slice(begin, begin + block))
    return result


def points_of(triangles, count, side, random):
    lower, upper = triangles.min((0, 1)), triangles.max((0, 1))
    box = random.uniform(lower - 0.1 * side, upper + 0.1 * side, (count - count // 2, 3))
    normal = numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = numpy.linalg.norm(normal, axis=1)
    weights = area / area.sum() if area.sum() > 0 else None
    chosen = random.choice(len(triangles), count // 2, p=weights)
    u, v = random.random((2, count // 2, 1))
    u, v = numpy.where(u + v > 1, 1 - u, u), numpy.where(u + v > 1, 1 - v, v)
    a, b, c = (triangles[chosen, k] for k in range(3))
    distance = side * 10 ** random.uniform(-5, -1.5, (count // 2, 1)) * random.choice([-1, 1], (count // 2, 1))
    unit = normal[chosen] / numpy.maximum(area[chosen, None], 1e-300)
    return numpy.concatenate([box, a + u * (b - a) + v * (c - a) + distance * unit])


# The surface that decides the sign (docs/sign.md) ---------------------------------------------------------------------
class Edges:
    """The undirected edges of the faces that count, as often as they count in each direction."""

    def __init__(self, faces, counts):
        self.faces = numpy.flatnonzero(counts)
        start = faces[self.faces].reshape(-1)
        end = numpy.roll(faces[self.faces], -1, axis=1).reshape(-1)
        forward = numpy.where(start < end, 1, -1) * numpy.repeat(counts[self.faces], 3)
        key = numpy.minimum(start, end) * (int(faces.max(initial=0)) + 1) + numpy.maximum(start, end)
        unique, first, self.edge, self.uses = numpy.unique(key, return_index=True, return_inverse=True,
                                                           return_counts=True)
        self.ends = numpy.stack([start[first], end[first]], -1)
        self.direction = forward
        self.net = numpy.bincount(self.edge, forward, len(unique)).astype(int)
        self.closed = not (self.uses % 2).any()
        self.balanced = not self.net.any()


def joined(positions, candidates, side):
    """For each vertex that whose position counts: candidates within rounding are one."""
    stands_for = numpy.arange(len(positions))
    tolerance = side * 2.0**-43
    lower = positions.min(0)
    parent = {}

    def root(vertex):
        while parent.setdefault(vertex, vertex) != vertex:
            vertex = parent[vertex]
        return vertex

    # Two positions within the tolerance are in one cell of four tolerances, in one of eight lattices.
    for shift in numpy.ndindex(2, 2, 2):
        cells = numpy.floor((positions[candidates] - lower) / (4 * tolerance) + 0.5 * numpy.array(shift))
        order = numpy.lexsort(cells.T)
        same = (cells[order][1:] == cells[order][:-1]).all(1)
        for run in numpy.split(order, numpy.flatnonzero(~same) + 1) if same.any() else []:
            for k, one in enumerate(run):
                for other in run[k + 1 :]:
                    pair = candidates[one], candidates[other]
                    if (numpy.abs(positions[pair[0]] - positions[pair[1]]) <= tolerance).all():
                        parent[root(pair[0])] = root(pair[1])
    clusters = collections.defaultdict(list)
    for vertex in parent:
        clusters[root(vertex)].append(vertex)
    for cluster in clusters.values():
        if (numpy.ptp(positions[cluster], axis=0) <= side * 2.0**-41).all():
            stands_for[cluster] = min(cluster, key=lambda vertex: tuple(positions[vertex]))
    return stands_for


def without_doubled(faces, counts):
    """Faces of the same three vertices count by their net number, at most once; and once those that cancel each other,
    whose rim is open, if all is closed then."""
    order = numpy.argsort(faces, axis=1)
    odd = numpy.array([[0, 1, 2], [1, 2, 0], [2, 0, 1]])
    is_even = (order[:, None] == odd).all(2).any(1)
    _, group, size = numpy.unique(numpy.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    net = numpy.bincount(group, numpy.where(is_even, 1, -1) * counts, len(size))
    doubled = (size[group] > 1) & (counts != 0)
    counts = numpy.where(doubled, 0, counts)
    found = set()
    for face in numpy.flatnonzero(doubled):
        direction = 1 if is_even[face] else -1
        if group[face] not in found and net[group[face]] * direction > 0:
            found.add(group[face])
            counts[face] = 1
    edges = Edges(faces, counts)
    repeated = numpy.flatnonzero(doubled)
    lowest = repeated[numpy.unique(group[repeated], return_index=True)[1]]
    cancelled = lowest[net[group[lowest]] == 0].tolist()
    if edges.closed or not cancelled:
        return counts
    open_edges = {frozenset(ends) for ends in edges.ends[edges.uses % 2 == 1].tolist()}
    once = numpy.zeros_like(counts)
    once[cancelled] = 1
    own = Edges(faces, once)
    parent = {face: face for face in cancelled}

    def root(face):
        while parent[face] != face:
            face = parent[face]
        return face

    at_edge = collections.defaultdict(list)
    for index, edge in enumerate(own.edge.tolist()):
        at_edge[edge].append(int(own.faces[index // 3]))
    for pair in at_edge.values():
        if len(pair) == 2:
            parent[root(pair[0])] = root(pair[1])
    rims = collections.defaultdict(list)
    for edge, at in at_edge.items():
        if len(at) % 2 == 1:
            for face in at:
                rims[root(face)].append(frozenset(own.ends[edge].tolist()) in open_edges)
    more = counts.copy()
    for face in cancelled:
        if rims[root(face)] and all(rims[root(face)]):
            more[face] = 1
    return more if Edges(faces, more).closed else counts


def has_odd_face(faces):
    return (numpy.unique(numpy.sort(faces, axis=1), axis=0, return_counts=True)[1] % 2).any()


def oriented(edges, faces, counts, areas):
    """Each part with the orientation of most of its area. A part that has none stays; are_all: there is none."""
    pairs = collections.defaultdict(list)
    for index, (edge, direction) in enumerate(zip(edges.edge.tolist(), edges.direction.tolist())):
        if edges.uses[edge] == 2:
            pairs[edge].append((int(edges.faces[index // 3]), direction))
    beside = collections.defaultdict(list)
    for (one, first), (other, second) in pairs.values():
        beside[one].append((other, first == second))
        beside[other].append((one, first == second))
    turned = {}
    counts = counts.copy()
    are_all = True
    for seed in edges.faces.tolist():
        if seed in turned:
            continue
        turned[seed], part, has_one = False, [seed], True
        for face in part:
            for other, differs in beside[face]:
                if other not in turned:
                    turned[other] = turned[face] ^ differs
                    part.append(other)
                elif turned[other] != turned[face] ^ differs:
                    has_one = False
        if not has_one:
            are_all = False
            continue
        against = sum(areas[face] for face in part if turned[face])
        along = sum(areas[face] for face in part if not turned[face])
        for face in part:
            if turned[face] != (against > along):
                counts[face] = -counts[face]
    return counts, are_all


def parts_over(groups):
    """Numbers that are the same for members of a group, and of groups that share a member: of a dictionary's keys."""
    parent = {}

    def root(one):
        while parent.setdefault(one, one) != one:
            parent[one] = parent[parent[one]]
            one = parent[one]
        return one

    for group in groups:
        for one in group:
            parent[root(one)] = root(group[0])
    return {one: root(one) for one in list(parent)}


def parts_over_edges(edges):
    """The faces at each edge, and parts of faces that are joined over edges of two."""
    at_edge = collections.defaultdict(list)
    for index, edge in enumerate(edges.edge.tolist()):
        at_edge[edge].append(int(edges.faces[index // 3]))
    return at_edge, parts_over([[face] for face in edges.faces.tolist()] +
                               [at for at in at_edge.values() if len(at) == 2])


def without_sheets(triangles, faces, counts):
    """Without free sheets that are no bodies with holes, and without inner walls of what is left."""
    edges = Edges(faces, counts)
    at_edge, part_of = parts_over_edges(edges)
    left = {edge: len(at) for edge, at in at_edge.items()}
    edges_of = collections.defaultdict(list)
    for edge, at in at_edge.items():
        if len(at) != 2:
            for face in at:
                edges_of[part_of[face]].append(edge)
    free = set()
    found = [part_of[at[0]] for at in at_edge.values() if len(at) == 1]
    while found:
        part = found.pop()
        if part in free:
            continue
        free.add(part)
        for edge in edges_of[part]:
            left[edge] -= 1
        found += [part_of[face] for edge in edges_of[part] if left[edge] == 1 for face in at_edge[edge]
                  if part_of[face] not in free]
    taken = [face for face in edges.faces.tolist() if part_of[face] in free]
    vertex_of = parts_over([faces[face].tolist() for face in taken])
    sets = collections.defaultdict(list)
    for face in taken:
        sets[vertex_of[int(faces[face][0])]].append(face)
    rest = counts.copy()
    for one in sets.values():
        if len(one) < 3 or not has_clear_winding_number(triangles[one], counts[one]):
            rest[one] = 0
    edges = Edges(faces, rest)
    if edges.closed or (edges.uses == 1).any():
        return rest
    at_edge, part_of = parts_over_edges(edges)
    edges_of = collections.defaultdict(list)
    is_odd = {edge: len(at) % 2 == 1 for edge, at in at_edge.items() if len(at) != 2}
    for edge in is_odd:
        for face in at_edge[edge]:
            edges_of[part_of[face]].append(edge)
    area = collections.Counter()
    normal = numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    for face, own in zip(edges.faces.tolist(), numpy.linalg.norm(normal[edges.faces], axis=1).tolist()):
        area[part_of[face]] += own
    walls = set()
    for part in sorted(edges_of, key=lambda part: area[part]):
        often = collections.Counter(edges_of[part])
        changed = [edge for edge, times in often.items() if times % 2 == 1]
        if sum(-1 if is_odd[edge] else 1 for edge in changed) < 0:
            walls.add(part)
            for edge in changed:
                is_odd[edge] = not is_odd[edge]
    if not any(is_odd.values()):
        rest[[face for face in edges.faces.tolist() if part_of[face] in walls]] = 0
    return rest


def without_walls(positions, faces, counts):
    """By what can be reached: how often each face counts, without walls and sheets of surfaces that have edges of three
    faces or more. Angles around edges are in double, and faces that cross are not looked for."""
    once = numpy.where(counts != 0, 1, 0)
    _, first = numpy.unique(numpy.sort(faces, axis=1), axis=0, return_index=True)
    once[numpy.setdiff1d(numpy.arange(len(faces)), first)] = 0
    edges = Edges(faces, once)
    at_edge = collections.defaultdict(list)  # faces, and whether they run along the edge as it is kept
    for index, edge in enumerate(edges.edge.tolist()):
        face = int(edges.faces[index // 3])
        at_edge[edge].append((face, faces[face][index % 3] == edges.ends[edge][0]))
    surface_of = parts_over([[face for face, _ in at] for at in at_edge.values()])
    walked = {surface_of[at[0][0]] for at in at_edge.values() if len(at) > 2}
    joins = []  # of sides: a face and whether it is the front
    for edge, at in at_edge.items():
        if surface_of[at[0][0]] not in walked:
            continue
        if len(at) > 2:
            a, b = positions[edges.ends[edge]]
            along = (b - a) / numpy.linalg.norm(b - a)
            away = [positions[next(v for v in faces[face] if v not in edges.ends[edge])] - a for face, _ in at]
            away = [one - along * (one @ along) for one in away]
            across = numpy.cross(along, away[0])
            angle = [numpy.arctan2(one @ across / numpy.linalg.norm(across), one @ away[0] / numpy.linalg.norm(away[0]))
                     % (2 * numpy.pi) if n > 0 else 0 for n, one in enumerate(away)]
            at = [at[n] for n in numpy.argsort(angle)]
        for one, other in zip(at, at[1:] + at[:1]):
            joins.append([one, (other[0], not other[1])])
    region = parts_over(joins)
    is_skin = {face for face in edges.faces.tolist()
               if surface_of[face] in walked and region[face, True] != region[face, False]}
    body_of = parts_over([[face for face, _ in at if face in is_skin] or [next(iter(is_skin))] for at in at_edge.values()]
                         if is_skin else [])
    bodies = collections.defaultdict(list)
    for face in is_skin:
        bodies[body_of[face]].append(face)
    result = counts.copy()
    result[[face for face in edges.faces.tolist() if surface_of[face] in walked and face not in is_skin]] = 0
    for body in bodies.values():
        corners = positions[faces[body]]
        normal = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # The vertex that is farthest along a direction, and of its faces one that the direction leaves by.
        random = numpy.random.default_rng(1)
        seen = None
        while seen is None:
            direction = random.normal(size=3)
            origin = corners.mean(1)[random.integers(len(body))]
            with numpy.errstate(all="ignore"):
                far = numpy.einsum("ij,ij->i", corners[:, 0] - origin, normal) / (normal @ direction)
                hit = origin + far[:, None] * direction
                inside = numpy.isfinite(far)
                for k in range(3):
                    side = numpy.cross(corners[:, (k + 1) % 3] - corners[:, k], hit - corners[:, k])
                    inside &= numpy.einsum("ij,ij->i", side, normal) > 0
            if inside.any():
                last = numpy.flatnonzero(inside)[far[inside].argmax()]
                seen = region[body[last], bool(normal[last] @ direction > 0)]
        areas = numpy.linalg.norm(normal, axis=1)
        outwards = sum(area * ((region[face, True] == seen) - int(region[face, False] == seen))
                       for face, area in zip(body, areas))
        look = -1 if outwards < 0 else 1
        is_inside = collections.Counter()
        for face in body:
            for front in (True, False):
                is_inside[region[face, front]] += region[face, not front] == seen or front == (look < 0)
        for face in body:
            front, back = (region[face, side] != seen and is_inside[region[face, side]] > 0 for side in (True, False))
            result[face] = look * (int(back) - int(front))
    return result


def sign_surface(triangles, side, are_turned, are_sheets_out):
    """The rule, how often each face counts, what was done last to get there, how many faces do not count, are turned
    and are left out, and whether the mesh itself is closed. An open mesh has the rule "open". are_turned,
    are_sheets_out: what is done if it is open."""
    positions, faces = numpy.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    faces = faces.reshape(-1, 3)

    def proper(faces):
        a, b, c = faces.T
        return ((a != b) & (b != c) & (c != a)).astype(int)

    counts = proper(faces)
    edges, step = Edges(faces, counts), "as given"
    done = {"uncounted": 0, "turned": 0, "sheets": 0}
    is_closed = edges.closed
    if not edges.balanced:
        unbalanced = numpy.unique(edges.ends[edges.net != 0])
        stands_for = joined(positions, unbalanced, side)
        if (stands_for != numpy.arange(len(positions))).any():
            faces = stands_for[faces]
            counts = proper(faces)
            edges, step = Edges(faces, counts), "joined"
    if not edges.balanced:
        fewer = without_doubled(faces, counts)
        after = Edges(faces, fewer)
        opens = edges.closed and not after.closed and has_odd_face(faces[counts != 0])
        if (fewer != counts).any() and not opens and numpy.count_nonzero(after.net) <= numpy.count_nonzero(edges.net):
            done["uncounted"] = int(((fewer == 0) & (counts != 0)).sum())
            counts, edges, step = fewer, after, "doubled"
    normal = numpy.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    if not edges.balanced and (edges.closed or are_turned):
        turned, are_all = oriented(edges, faces, counts, numpy.linalg.norm(normal, axis=1))
        after = Edges(faces, turned)
        if after.balanced and are_all or not edges.closed:
            done["turned"] = int((turned != counts).sum())
            counts, edges, step = turned, after, "turned"
    if not edges.balanced and are_sheets_out and (edges.uses > 2).any():
        without = without_walls(positions, faces, counts)
        after = Edges(faces, without)
        if numpy.count_nonzero(after.net) < numpy.count_nonzero(edges.net):
            done["sheets"] = int(((without == 0) & (counts != 0)).sum())
            done["turned"] = int((without == -counts)[without != 0].sum())
            counts, edges, step = without, after, "sheets"
    if not edges.closed and are_sheets_out:
        without = without_sheets(triangles, faces, counts)
        done["sheets"] += int(((without == 0) & (counts != 0)).sum())
        counts, edges, step = without, Edges(faces, without), "sheets"
    return "nonzero" if edges.balanced else "parity" if edges.closed else "open", counts, step, done, is_closed


def halton(number, base):
    digit, result = 1.0, 0.0
    while number > 0:
        digit /= base
        result += digit * (number % base)
        number //= base
    return result


def has_clear_winding_number(triangles, counts):
    """Whether a set of sheets is a body with a hole, nearly as the command decides it."""
    lower, upper = triangles.min((0, 1)), triangles.max((0, 1))
    share = numpy.array([[halton(i, base) for base in (2, 3, 5)] for i in range(1, 513)])
    points = lower * (1 - share) + upper * share
    for begin in range(0, 512, 64):  # until there is too much doubt
        some = over_triangles(points[begin:begin + 64], triangles, solid_angles,
                              lambda sum, values, part: sum + values @ counts[part], 0)
        winding = some if begin == 0 else numpy.concatenate([winding, some])
        if 10 * (numpy.abs(winding - numpy.round(winding)) > 0.1).sum() > 512:
            return False
    return bool((numpy.abs(winding) >= 0.5).any())


# Judging --------------------------------------------------------------------------------------------------------------
def run(command, *arguments):
    outcome = subprocess.run([command, *map(str, arguments), "--json"], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, timeout=900)
    try:
        return json.loads(outcome.stdout)
    except ValueError:
        return {"error": {"message": f"ends with {outcome.returncode} and no result", "exit_status": outcome.returncode}}


def reason_of(message, path):
    """The message without what belongs to this file: places, numbers, quoted text."""
    text = re.sub(r"^(line|row) [0-9]+( of '[a-z]*')?: ", "", message.replace(f"{path}: ", ""))
    text = re.sub(r"'[^']*'", "'...'", text)
    return re.sub(r"[0-9][0-9.e+]*", "N", text)


def truth_of(path, sha, defects, options):
    """Points, distances, winding numbers and the surface of a file: kept, since no command changes more of them than
    whether faces are turned or left out."""
    are_turned, are_sheets_out = defects["reoriented_faces"] > 0, defects["sheet_faces"] > 0
    name = sha + "-turned" * are_turned + "-sheets" * are_sheets_out
    kept = options.folder / "truth" / f"{FORMAT}-{options.seed}-{options.points}" / f"{name}.npz"
    if kept.exists():
        with numpy.load(kept) as file:
            return {key: file[key] for key in file.files}
    triangles = mesh_readers.read(path)
    side = (triangles.max((0, 1)) - triangles.min((0, 1))).max()
    count = int(max(min(options.points, 10), min(options.points, 15_000_000 // len(triangles))))
    random = numpy.random.default_rng([options.seed, int(sha[:12], 16)])
    points = points_of(triangles, count, side if side > 0 else 1, random)
    rule, counts, step, done, is_closed = sign_surface(triangles, side, are_turned, are_sheets_out)
    squares = over_triangles(points, triangles, squared_distances,
                             lambda best, values, _: numpy.minimum(best, values.min(1)), numpy.inf)
    winding = numpy.zeros((2, count))
    for row, factors in enumerate((numpy.ones(len(triangles)), counts)):
        if row == 0 or (counts < 1).any():
            winding[row] = over_triangles(points, triangles, solid_angles,
                                          lambda sum, values, part: sum + values @ factors[part], 0)
        else:
            winding[1] = winding[0]
    odd = numpy.zeros((3, count))
    # A command without these rules has parity for every mesh that is closed and not balanced.
    if rule == "parity" or (is_closed and step != "as given"):
        for ray in range(3):
            direction = random.normal(size=3)
            odd[ray] = over_triangles(points, triangles[counts != 0] if rule == "parity" else triangles,
                                      lambda points, corners: crossings(points, corners, direction),
                                      lambda sum, values, _: sum + values.sum(1), 0) % 2
    truth = dict(points=points, distance=numpy.sqrt(squares), given=winding[0], winding=winding[1], odd=odd,
                 rule=numpy.array(rule), step=numpy.array(step), side=numpy.array(side),
                 done=numpy.array(list(done.values())), triangles=numpy.array(len(triangles)))
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=kept.parent, suffix=".npz", delete=False) as file:
        numpy.savez(file, **truth)
    os.replace(file.name, kept)
    return truth


def seconds_of_children():
    """Of processor time."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def rule_of(defects):
    """The sign rule that "query" chooses for a mesh with these counts."""
    if defects["balanced"]:
        return "nonzero"
    if defects["closed"]:
        return "parity"
    return "solid-angle" if defects["tested_points"] > 0 and defects["unclear_parts"] == 0 else "none"


def step_of(defects):
    """What was done last to get the surface that decides the sign."""
    steps = {"sheets": "sheet_faces", "turned": "reoriented_faces", "doubled": "uncounted_faces", "joined": "joined_vertices"}
    return next((step for step, count in steps.items() if defects[count] > 0), "as given")


def is_chosen(sha, options):
    """Whether a file is judged by points."""
    number = int(hashlib.sha256(f"{options.seed} {sha}".encode()).hexdigest()[:8], 16)
    return number < options.share / 100 * 2**32


def judge(path, sha, options):
    start = seconds_of_children()
    result = {"bytes": path.stat().st_size}
    info = run(options.command, "info", path)
    if "error" in info:
        return result | {"unreadable": reason_of(info["error"]["message"], path),
                         "failed": info["error"]["exit_status"] not in (2, 3)}
    result |= {"triangles": info["triangles"], "defects": info["defects"], "sign": rule_of(info["defects"]),
               "step": step_of(info["defects"]), "seconds": seconds_of_children() - start}
    if not is_chosen(sha, options):
        return result
    try:
        truth = truth_of(path, sha, info["defects"], options)
        if truth["triangles"] != info["triangles"]:
            raise ValueError(f"{truth['triangles']} triangles here, {info['triangles']} in the command")
    except Exception as error:
        result["not_judged"] = f"{type(error).__name__}: {error}"
        truth = None
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        points = truth["points"] if truth else numpy.zeros((1, 3))
        numpy.save(f"{folder}/points.npy", points)
        query = run(options.command, "query", path, f"{folder}/points.npy", "-o", f"{folder}/result.npy", "--quiet")
        if "error" in query:
            return result | {"failed": True, "not_judged": reason_of(query["error"]["message"], path)}
        found = numpy.load(f"{folder}/result.npy")["distance"]
    if query["sign"] != result["sign"]:
        result["not_judged"] = f"query has the sign rule {query['sign']}, and info counts what means {result['sign']}"
        truth = None
    result |= {"sign": query["sign"], "device": query["device"]["name"], "warnings": query["warnings"]}
    if truth is None:
        return result
    side, distance = float(truth["side"]), truth["distance"]
    voxel = side / 256 if side > 0 else 1.0
    error = numpy.abs(numpy.abs(found.astype(float)) - distance)
    limit = numpy.maximum(2 * numpy.spacing(distance.astype(numpy.float32)).astype(float), 1e-5 * voxel)
    rule = query["sign"]
    doubt = distance <= 1e-6 * side
    if rule == "nonzero":
        doubt |= numpy.abs(numpy.abs(truth["winding"]) - 0.5) < 0.1
        inside = numpy.abs(numpy.round(truth["winding"])) >= 1
    elif rule == "solid-angle":
        doubt |= numpy.abs(numpy.abs(truth["winding"]) - 0.5) < 1e-8
        inside = numpy.abs(truth["winding"]) >= 0.5
    elif rule == "parity":
        doubt |= (truth["odd"] != truth["odd"][0]).any(0)
        inside = truth["odd"][0] > 0
    else:
        doubt[:] = False
        inside = numpy.zeros(len(found), dtype=bool)
    far = numpy.abs(truth["given"] - numpy.round(truth["given"])) > 0.1
    here = str(truth["rule"])
    reported = [info["defects"][key] for key in ("uncounted_faces", "reoriented_faces", "sheet_faces")]
    # The script does not look for bodies that are there on both sides (docs/sign.md), which have an inside by that.
    is_other = info["defects"].get("double_sided_faces", 0) > 0 and truth["done"].tolist() != reported
    differing = int(((numpy.signbit(found) != inside) & ~doubt).sum())
    return result | {
        "points": len(found),
        "rule_here": rule if here == "open" and rule in ("solid-angle", "none") else here,
        "done": reported,
        "done_here": truth["done"].tolist(),
        "wrong_values": int((~(error <= limit)).sum()),
        "error_voxels": float(error.max() / voxel),
        "doubt": int(doubt.sum()),
        "wrong_signs": 0 if is_other else differing,
        "other_signs": differing if is_other else 0,
        "inside": int(inside.sum()),
        "not_integer": int(far.sum()),
        "beyond_half": int((numpy.abs(truth["given"]) > 0.5).sum()),
    }


def judged(task):
    package, path, sha, options = task
    kept = options.kept / f"{sha}.json"
    if kept.exists():
        return json.loads(kept.read_text())
    if time.monotonic() > options.end:
        return None
    result = {"package": package, "file": path.name, "sha256": sha} | judge(path, sha, options)
    kept.with_suffix(".part").write_text(json.dumps(result))
    os.replace(kept.with_suffix(".part"), kept)
    return result


# The record -----------------------------------------------------------------------------------------------------------
KINDS = ["no boundary, an inner wall", "no boundary, other edges of an odd number of faces",
         "boundary edges: fewer than 1% of the faces", "1% to 10%", "10% to 100%", "as many as faces, or more"]


def kind_without_sign(result):
    defects = result["defects"]
    if defects["boundary_edges"] == 0:
        return KINDS[0] if defects.get("inner_wall_faces", 0) > 0 else KINDS[1]
    share = defects["boundary_edges"] / max(1, result["triangles"])
    return KINDS[2 + sum(share >= limit for limit in (0.01, 0.1, 1))]


def table(head, rows):
    """In Markdown; columns of numbers are on the right."""
    columns = list(zip(*rows))[1:]
    numbers = [all(re.fullmatch(r"[0-9,]+(\.[0-9]+(e[-+][0-9]+)?)?", str(cell)) for cell in column) for column in columns]
    lines = ["| " + " | ".join(map(str, line)) + " |" for line in (head, *rows)]
    return "\n".join([lines[0], "|-|" + "".join("-:|" if is_number else "-|" for is_number in numbers), *lines[1:]])


def machine():
    model = re.search(r"model name\s*:\s*(.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{model.group(1) if model else 'unknown'}, {len(os.sched_getaffinity(0))} cores"


KEPT = "## Files whose sign changed"  # written by hand; stays


def record_of(results, left, files, options):
    read = [result for result in results if "unreadable" not in result]
    tested = [result for result in read if "points" in result]
    signed = [result for result in read if result.get("sign", "none") != "none"]
    wrong_signs = sum(result["wrong_signs"] for result in tested)
    wrong_values = sum(result["wrong_values"] for result in tested)
    rows = []
    for package in [*options.packages, None]:
        mine = [result for result in results if package in (None, result["package"])]
        if not mine:
            continue
        mine_read = [result for result in mine if "unreadable" not in result]
        mine_tested = [result for result in mine if "points" in result]
        steps = collections.Counter(result["step"] for result in mine_read if result["sign"] != "none")
        signs = collections.Counter(result.get("sign") for result in mine_read)
        rows.append([package or "all", options.packages.get(package, ""),
                     sum(files.values()) if package is None else files[package], len(mine_read),
                     len(mine) - len(mine_read), signs["nonzero"], signs["parity"], signs["solid-angle"], signs["none"],
                     *(steps[step] for step in ("joined", "doubled", "turned", "sheets")), len(mine_tested),
                     sum(result["wrong_signs"] for result in mine_tested),
                     sum(result["wrong_values"] for result in mine_tested),
                     f"{max((result['error_voxels'] for result in mine_tested), default=0):.1e}",
                     f"{sum(result['seconds'] for result in mine_read) / max(1, len(mine_read)):.2f}"])
    unreadable = collections.Counter(result["unreadable"] for result in results if "unreadable" in result)
    unsigned = collections.defaultdict(list)
    for result in read:
        if result.get("sign") == "none":
            unsigned[kind_without_sign(result)].append(result)
    other_rule = [result for result in tested
                  if result["rule_here"] != result["sign"] or result["done_here"] != result["done"]]
    not_judged = [result for result in read if "not_judged" in result]
    failed = [result for result in results if result.get("failed")]

    def settled(group):
        return sum(result.get("not_integer", 1) == 0 and result["beyond_half"] > 0 for result in group)

    parts = [
        "# Mesh files of public packages",
        "",
        f"{len(read):,} different files that can be read, out of packages of PyPI and Debian (robots, printers, CFD cases,\n"
        f"CAD, test models). **{len(signed):,} of {len(read):,} ({len(signed) / max(1, len(read)):.0%}) have a sign; "
        f"of {len(tested):,} files\nthat were judged by points, a random {options.share:g}%, {wrong_signs:,} signs and {wrong_values:,} distances are wrong.**\n"
        "`scripts/real-meshes` fetches them and writes this page; its `--help` and `benchmarks/real_meshes.py` say how\n"
        "files are judged.",
        "",
        *([f"**This run is not complete: {left:,} of {len(results) + left:,} files are left.** Run it again to judge them.",
           ""] if left else []),
        "| | |",
        "|-|-|",
        f"| points | {sum(result['points'] for result in tested):,} in {len(tested):,} files, {sum(result['inside'] for result in tested):,} of them inside; seed {options.seed}; "
        f"{options.points} a file, fewer above 100,000 triangles |",
        f"| wrong | {wrong_signs:,} signs, {wrong_values:,} distances beyond max(1e-5 voxel, 2 ulp) |",
        f"| not compared | {sum(result.get('other_signs', 0) for result in tested):,} signs that differ in "
        f"{sum(result.get('other_signs', 0) > 0 for result in tested):,} files with bodies that are there on both sides, "
        "for which the script does not look |",
        f"| in doubt | {sum(result['doubt'] for result in tested):,} points whose sign was not judged |",
        f"| largest error | {max((result['error_voxels'] for result in tested), default=0):.1e} voxel, of 1/256 of the "
        "longest side |",
        f"| crashes, refusals of points | {len(failed)} |",
        f"| triangles | {sum(result['triangles'] for result in read):,}; the largest file has "
        f"{max((result['triangles'] for result in read), default=0):,} |",
        f"| command | {options.version} |",
        f"| date | {datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M} UTC |",
        f"| machine | {machine()} |",
        f"| device | {next((result['device'] for result in read if 'device' in result), 'unknown')} |",
        "",
        "## By package",
        "",
        "Files of equal content count once, for the first package that has them. `joined`, `doubled`, `turned` and `sheets`\n"
        "are files with a sign for which [these rules](../docs/sign.md) changed the surface that decides: noise around zero,\n"
        "doubled faces, faces that look the wrong way, sheets beside bodies. The last rule counts. `judged` files\n"
        "were judged by points; seconds are of processor time, of `info` of a file on average.",
        "",
        table(["package", "version", "files", "read", "unreadable", "nonzero", "parity", "solid angle", "no sign", "joined", "doubled",
               "turned", "sheets", "judged", "wrong signs", "wrong distances", "largest error, voxel", "seconds"], rows),
        "",
        "## Files that cannot be read",
        "",
    ]
    if unreadable:
        parts.append(table(["message, `N` for its numbers", "files"],
                           [[reason.replace("|", "\\|"), count] for reason, count in unreadable.most_common()]))
    else:
        parts.append("None.")
    parts += [
        "",
        "## Files without a sign",
        "",
        "`settled` are files whose sum of solid angles is within 0.1 of an integer at every point, and beyond 1/2 at one or\n"
        "more.",
        "",
    ]
    if unsigned:
        parts.append(table(["defect", "files", "settled", "for instance"],
                           [[kind, len(group), settled(group),
                             ", ".join(f"`{result['file']}`" for result in
                                       sorted(group, key=lambda one: (one["defects"]["boundary_edges"], one["file"]))[:3])]
                            for kind in KINDS if (group := unsigned[kind])]))
    else:
        parts.append("None.")
    if other_rule:
        parts += ["", "## Another rule than expected", "",
                  "The rules of docs/sign.md, written once more in the script, give another rule or another surface for\n"
                  "these files: faces that do not count, that are turned, that are left out.", "",
                  table(["file", "package", "rule", "expected", "faces", "expected"],
                        [[f"`{result['file']}`", result["package"], result["sign"], result["rule_here"],
                          ", ".join(map(str, result["done"])), ", ".join(map(str, result["done_here"]))]
                         for result in other_rule[:20]])]
        if len(other_rule) > 20:
            parts.append(f"\nand {len(other_rule) - 20} more.")
    if not_judged:
        parts += ["", "## Files that could not be judged", "",
                  table(["file", "package", "reason"],
                        [[f"`{result['file']}`", result["package"], result["not_judged"]] for result in not_judged])]
    return "\n".join(parts) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--command", required=True)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--points", type=int, default=150)
    parser.add_argument("--share", type=float, default=10, help="percent of the files that are judged by points")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=float("inf"),
                        help="begins no file after that; the record says how many are left for the next run")
    parser.add_argument("--only", default="", help="files whose path contains this text; writes no record")
    parser.add_argument("--record", type=pathlib.Path, default=pathlib.Path("benchmarks/REAL-MESHES.md"))
    options = parser.parse_args()
    options.end = time.monotonic() + 60 * options.minutes

    options.version = subprocess.run([options.command, "--version"], stdout=subprocess.PIPE, text=True,
                                     check=True).stdout.splitlines()[0]
    build = hashlib.sha256(pathlib.Path(options.command).read_bytes()).hexdigest()[:12]
    options.kept = options.folder / "judged" / f"{build}-{FORMAT}-{options.seed}-{options.points}-{options.share:g}"
    options.kept.mkdir(parents=True, exist_ok=True)
    options.packages = {folder.name: (folder / "version").read_text().strip()
                        for folder in sorted((options.folder / "files").iterdir())}
    print(f"{options.version}, seed {options.seed}", flush=True)
    tasks, seen, files = [], set(), collections.Counter()
    for package in options.packages:
        for path in sorted((options.folder / "files" / package).rglob("*")):
            if path.suffix.lower() not in ENDINGS or not path.is_file():
                continue
            files[package] += 1
            sha = hashlib.sha256(path.read_bytes()).hexdigest()
            if sha not in seen and options.only in str(path):
                tasks.append((package, path, sha, options))
            seen.add(sha)
    print(f"{sum(files.values())} files, {len(tasks)} different ones", flush=True)
    results = []
    with concurrent.futures.ProcessPoolExecutor(options.jobs) as pool:
        for result in pool.map(judged, tasks):
            if result is None:
                continue
            results.append(result)
            told = [f"{key} {result[key]}" for key in ("wrong_signs", "wrong_values", "not_judged", "failed")
                    if result.get(key)]
            if told or len(results) % 100 == 0:
                print(f"{len(results)} of {len(tasks)}: {result['package']} {result['file']}: "
                      f"{', '.join(told) or 'as expected'}", flush=True)
    if options.only:
        print(json.dumps(results, indent=1))
    else:
        kept = options.record.read_text().partition(KEPT) if options.record.exists() else ("", "", "")
        record = record_of(results, len(tasks) - len(results), files, options)
        options.record.write_text(record.rstrip() + "\n" + ("\n" + "".join(kept[1:]) if kept[1] else ""))
        print(f"Written: {options.record}")
    sys.exit(any(result.get("wrong_signs") or result.get("wrong_values") or result.get("failed")
                 for result in results))


main()
