"""Distances, closest points and winding numbers in whole numbers of any size: every coordinate is a double, so the
lengths of a mesh are whole multiples of a power of two.

Nothing here rounds but the last step of each answer: a root becomes the nearest double, as does each coordinate of a
closest point. Winding numbers of closed surfaces are counts of crossings. Those of open surfaces are sums of solid
angles with 60 digits.
"""

import decimal
import math
import random
from fractions import Fraction


def subtract(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def root(numerator, denominator):
    """The double nearest to the square root of a fraction."""
    if numerator == 0:
        return 0.0
    bits = max(0, 160 + denominator.bit_length() - numerator.bit_length()) // 2 + 1
    scaled, rest = divmod(numerator << (2 * bits), denominator)
    floor = math.isqrt(scaled)
    # A bit below the last one says that the root is more than that.
    is_more = rest != 0 or floor * floor != scaled
    return float(Fraction(2 * floor + is_more, 2 << bits))


def closest_on_segment(p, a, b):
    """The squared distance as numerator and denominator, and the point as whole numbers over a denominator."""
    along, to = subtract(b, a), subtract(p, a)
    length, way = dot(along, along), dot(along, to)
    if way <= 0 or length == 0:
        return dot(to, to), 1, a, 1
    if way >= length:
        to = subtract(p, b)
        return dot(to, to), 1, b, 1
    return dot(to, to) * length - way * way, length, tuple(a[i] * length + along[i] * way for i in range(3)), length


def closest_on_triangle(p, a, b, c):
    """The same for a triangle, also for one without an area."""
    normal = cross(subtract(b, a), subtract(c, a))
    square = dot(normal, normal)
    if square and all(dot(cross(subtract(t, s), subtract(p, s)), normal) >= 0 for s, t in ((a, b), (b, c), (c, a))):
        height = dot(subtract(p, a), normal)
        return height * height, square, tuple(p[i] * square - normal[i] * height for i in range(3)), square
    best = closest_on_segment(p, a, b)
    for start, end in ((b, c), (c, a)):
        found = closest_on_segment(p, start, end)
        if found[0] * best[1] < best[0] * found[1]:
            best = found
    return best


_random = random.Random(80)
DIRECTIONS = [tuple(_random.randrange(-(10**6), 10**6) for _ in range(3)) for _ in range(100)]


def crossings(p, triangles):
    """The winding number and the count of crossings of a ray that meets no edge and no vertex."""
    for direction in DIRECTIONS:
        winding = count = 0
        for a, b, c in triangles:
            a, b, c = subtract(a, p), subtract(b, p), subtract(c, p)
            sides = [dot(direction, cross(s, t)) for s, t in ((a, b), (b, c), (c, a))]
            if min(sides) < 0 < max(sides):
                continue
            if 0 in sides:
                if any(sides):
                    break  # through an edge or a vertex: another direction
                if dot(cross(subtract(b, a), subtract(c, a)), cross(subtract(b, a), subtract(c, a))):
                    break  # within the plane of a triangle
                continue
            normal = cross(subtract(b, a), subtract(c, a))
            slope = dot(normal, direction)
            if (dot(normal, a) > 0) == (slope > 0):
                winding += 1 if slope > 0 else -1
                count += 1
        else:
            return winding, count
    raise AssertionError("every direction meets an edge")


decimal.getcontext().prec = 60
PI = decimal.Decimal("3.14159265358979323846264338327950288419716939937510582097494459")


def arc_tangent(y, x):
    if y == 0 and x == 0:
        return decimal.Decimal(0)
    if x < 0:
        return (PI if y >= 0 else -PI) - arc_tangent(y, -x)
    if abs(y) > x:
        return PI / 2 - arc_tangent(x, y) if y > 0 else arc_tangent(x, -y) - PI / 2
    t, factor = y / x, 1
    while abs(t) > decimal.Decimal("0.01"):
        t, factor = t / (1 + (1 + t * t).sqrt()), 2 * factor
    term, sum_, square = t, t, t * t
    for odd in range(3, 61, 2):
        term = -term * square
        sum_ += term / odd
    return factor * sum_


def solid_angles(p, triangles):
    """The winding number of an open surface: the solid angles of its faces (van Oosterom and Strackee) over 4 pi."""
    total = decimal.Decimal(0)
    for corners in triangles:
        a, b, c = (subtract(corner, p) for corner in corners)
        la, lb, lc = (decimal.Decimal(dot(v, v)).sqrt() for v in (a, b, c))
        volume = decimal.Decimal(dot(a, cross(b, c)))
        total += arc_tangent(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    return total / (2 * PI)


class Surface:
    """The triangles of a mesh and some points, as whole numbers of one unit."""

    def __init__(self, vertices, faces, points, solid=None):
        numbers = [x for row in (*vertices, *points, *(solid[0] if solid else ())) for x in row]
        self.unit = max(float(x).as_integer_ratio()[1] for x in numbers)
        self.triangles = self.whole_triangles(vertices, faces)
        self.solid = self.whole_triangles(*solid) if solid else self.triangles

    def whole(self, point):
        return tuple(int(Fraction(float(x)) * self.unit) for x in point)

    def whole_triangles(self, vertices, faces):
        places = [self.whole(vertex) for vertex in vertices]
        return [tuple(places[corner] for corner in face) for face in faces]

    def nearest(self, point, tolerance, candidates=None):
        """The distance, and of each triangle that is at most `tolerance` farther its number and its closest point; the
        nearest first, the lowest among equals."""
        p = self.whole(point)
        numbers = range(len(self.triangles)) if candidates is None else candidates
        found = {number: closest_on_triangle(p, *self.triangles[number]) for number in numbers}
        least = None
        for square, over, _, _ in found.values():
            if least is None or square * least[1] < least[0] * over:
                least = square, over
        distance = root(least[0], least[1] * self.unit * self.unit)
        allowed = []
        for number, (square, over, place, place_over) in found.items():
            away = root(square, over * self.unit * self.unit)
            if away <= distance + tolerance:
                allowed.append((away, number, tuple(float(Fraction(x, place_over * self.unit)) for x in place)))
        return distance, [(number, place) for _, number, place in sorted(allowed)]

    def winding(self, point):
        return crossings(self.whole(point), self.solid)

    def open_winding(self, point):
        return solid_angles(self.whole(point), self.solid)
