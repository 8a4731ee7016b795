// Meshes of known solids with faults, made at random: their sign is that of the solid, or they have none
// (docs/sign.md).

#include <clsdf/topology.hpp>

#include "support/doubtful_meshes.hpp"
#include "support/open_meshes.hpp"
#include "support/winding.hpp"
#include "surface/topology.hpp"

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

namespace clsdf {

using namespace test;

namespace {

/// A box whose sides are divided into squares.
Mesh divided_box(const Vec3& lower, const Vec3& upper, std::uint32_t around, std::uint32_t along_x) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    const std::array<std::uint32_t, 3> counts{along_x, around, around};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const bool is_upper : {false, true}) {
            const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            const auto first = static_cast<std::uint32_t>(vertices.size());
            for (std::uint32_t i = 0; i <= counts[u]; ++i)
                for (std::uint32_t j = 0; j <= counts[v]; ++j) {
                    Vec3 at{};
                    at[axis] = is_upper ? upper[axis] : lower[axis];
                    at[u] = i == counts[u] ? upper[u] : lower[u] + (upper[u] - lower[u]) * i / counts[u];
                    at[v] = j == counts[v] ? upper[v] : lower[v] + (upper[v] - lower[v]) * j / counts[v];
                    vertices.push_back(at);
                }
            for (std::uint32_t i = 0; i < counts[u]; ++i)
                for (std::uint32_t j = 0; j < counts[v]; ++j) {
                    const std::uint32_t a = first + i * (counts[v] + 1) + j, b = a + counts[v] + 1;
                    std::array<Triangle, 2> two{{{a, b, b + 1}, {a, b + 1, a + 1}}};
                    for (Triangle& triangle : two) triangles.push_back(is_upper ? triangle : turned(triangle));
                }
        }
    return weld(Mesh(std::move(vertices), std::move(triangles), "box"));
}

Mesh torus(std::uint32_t around, std::uint32_t across) {
    return weld(seamed_torus(around, across), 1e-9);
}

Mesh placed(const Mesh& mesh, double size, const Vec3& at, Random& random) {
    return shifted(tilted(scaled(mesh, size), random.uniform(0, 6)), at);
}

/// Closed bodies; their union is inside.
Mesh random_solid(Random& random) {
    const Vec3 origin{random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
    const auto ball = [&](double radius) {
        return weld(round_mesh(6 + random.index(6), radius, {0, 0, 0}, false, "ball"), 1e-9);
    };
    switch (random.index(8)) {
        case 0:
            return placed(ball(1), 1, origin, random);
        case 1:
            return placed(divided_box({-1, -0.7, -0.5}, {1, 0.7, 0.5}, 5, 6), 1, origin, random);
        case 2:
            return placed(torus(20, 12), 1, origin, random);
        case 3:  // a bar
            return placed(divided_box({-1, -0.02, -0.02}, {1, 0.02, 0.02}, 2, 30), 1, origin, random);
        case 4: {  // scattered balls
            std::vector<Mesh> all;
            for (int i = 0; i < 3; ++i)
                all.push_back(shifted(ball(random.uniform(0.2, 1)), {30.0 * i, random.uniform(-9, 9), 0}));
            return placed(together(all, "balls"), 1, origin, random);
        }
        case 5:  // two that overlap
            return placed(
                together({divided_box({-1, -0.7, -0.5}, {1, 0.7, 0.5}, 5, 6), shifted(ball(0.8), {0.7, 0.4, 0.3})},
                         "box and ball"),
                1, origin, random);
        case 6:  // hollow
            return placed(together({ball(1), reversed(ball(0.5))}, "hollow ball"), 1, origin, random);
        default: {  // a frame
            std::vector<Mesh> bars;
            for (const double y : {-1.0, 1.0})
                for (const double z : {-1.0, 1.0})
                    bars.push_back(shifted(divided_box({-1, -0.02, -0.02}, {1, 0.02, 0.02}, 2, 20), {0, y, z}));
            return placed(together(bars, "bars"), 1, origin, random);
        }
    }
}

/// A mesh with faults, and the places where its sign may be another one than that of the solid.
struct Faulty {
    Mesh mesh;
    std::vector<std::pair<Vec3, double>> open;  ///< balls around holes
};

double size_of(const Mesh& mesh, const Triangle& triangle) {
    double most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = mesh.vertices()[triangle[k]], &b = mesh.vertices()[triangle[(k + 1) % 3]];
        most = std::max(most, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
    }
    return most;
}

Vec3 middle_of(const Mesh& mesh, const Triangle& triangle) {
    Vec3 middle{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const std::uint32_t v : triangle) middle[axis] += mesh.vertices()[v][axis] / 3;
    return middle;
}

void turn_some(Faulty& faulty, double share, Random& random) {
    std::vector<std::size_t> faces;
    for (std::size_t face = 0; face < faulty.mesh.triangles().size(); ++face)
        if (random.uniform(0, 1) < share) faces.push_back(face);
    faulty.mesh = with_turned(faulty.mesh, faces, "turned");
}

void remove_some(Faulty& faulty, double share, Random& random) {
    const Mesh before = faulty.mesh;
    const std::uint32_t at_least = random.index(before.triangles().size());
    faulty.mesh = with_chosen_faces(before, "holes", [&](std::size_t face) {
        if (face != at_least && random.uniform(0, 1) >= share) return true;
        const Triangle& triangle = before.triangles()[face];
        faulty.open.emplace_back(middle_of(before, triangle), 1.5 * size_of(before, triangle));
        return false;
    });
}

void double_some(Faulty& faulty, double share, Random& random) {
    std::vector<Triangle> more;
    for (const Triangle& triangle : faulty.mesh.triangles())
        if (random.uniform(0, 1) < share) more.push_back(random.index(2) == 0 ? triangle : turned(triangle));
    faulty.mesh = with_faces(faulty.mesh, more, "doubled");
}

/// Every face both ways, in random order; the lowest ones of a body alike or not.
void double_all(Faulty& faulty, bool are_mixed, Random& random) {
    const std::vector<Triangle> all = faulty.mesh.triangles();
    std::vector<Triangle> first, second;
    for (const Triangle& triangle : all) {
        const bool is_swapped = are_mixed && random.index(4) == 0;
        first.push_back(is_swapped ? turned(triangle) : triangle);
        second.push_back(is_swapped ? triangle : turned(triangle));
    }
    first.insert(first.end(), second.begin(), second.end());
    faulty.mesh = Mesh(faulty.mesh.vertices(), std::move(first), "double");
}

Mesh sheet(double size, std::uint32_t count, double height, Random& random) {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i <= count; ++i)
        for (std::uint32_t j = 0; j <= count; ++j)
            vertices.push_back({size * (i / double(count) - 0.5), size * (j / double(count) - 0.5),
                                height * size * random.uniform(-1, 1)});
    for (std::uint32_t i = 0; i < count; ++i)
        for (std::uint32_t j = 0; j < count; ++j) {
            const std::uint32_t a = i * (count + 1) + j, b = a + count + 1;
            triangles.push_back({a, b, b + 1});
            triangles.push_back({a, b + 1, a + 1});
        }
    return {std::move(vertices), std::move(triangles), "sheet"};
}

void add_sheets(Faulty& faulty, Random& random) {
    const Box& box = faulty.mesh.box();
    std::vector<Mesh> all{faulty.mesh};
    for (std::uint32_t i = 0; i <= random.index(3); ++i) {
        Vec3 at{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            at[axis] = random.uniform(2 * box.lower[axis] - box.upper[axis], 2 * box.upper[axis] - box.lower[axis]);
        if (random.index(2) == 0) {  // through or beside a face
            const Mesh& mesh = faulty.mesh;
            at = middle_of(mesh, mesh.triangles()[random.index(mesh.triangles().size())]);
        }
        all.push_back(placed(sheet(random.uniform(0.1, 1.5), 1 + random.index(4), random.index(2) * 0.03, random), 1,
                             at, random));
    }
    faulty.mesh = together(all, "sheets");
}

/// Sheets that share edges with a body.
void attach_sheets(Faulty& faulty, Random& random) {
    std::vector<Vec3> vertices = faulty.mesh.vertices();
    std::vector<Triangle> triangles = faulty.mesh.triangles();
    for (std::uint32_t i = 0; i <= random.index(3); ++i) {
        const Triangle& face = faulty.mesh.triangles()[random.index(faulty.mesh.triangles().size())];
        const Vec3 middle = middle_of(faulty.mesh, face);
        vertices.push_back(along(middle, random.uniform(0.05, 0.6), random.direction()));
        triangles.push_back({face[0], face[1], static_cast<std::uint32_t>(vertices.size() - 1)});
    }
    faulty.mesh = Mesh(std::move(vertices), std::move(triangles), "attached");
}

struct Verdict {
    bool has_sign = false;
    std::size_t wrong = 0, judged = 0;
    std::string first;
};

Verdict judge(const Faulty& faulty, const Mesh& meant, Random& random) {
    const DescribedMesh described = describe_mesh(faulty.mesh);
    const ResolvedSignRule resolved = resolve_sign_rule(SignRule::automatic, described.topology);
    Verdict verdict;
    verdict.has_sign = resolved.rule != SignRule::none;
    verdict.first = resolved.warning;
    if (!verdict.has_sign) return verdict;
    std::vector<Triangle> counting;
    for (std::size_t face = 0; face < faulty.mesh.triangles().size(); ++face)
        counting.push_back(described.surface.triangle(faulty.mesh.triangles()[face], face));
    const Mesh surface(faulty.mesh.vertices(), counting);
    const Box& box = meant.box();
    for (int i = 0; i < 60; ++i) {
        Vec3 point{};
        if (i < 20) {
            for (std::size_t axis = 0; axis < 3; ++axis) point[axis] = random.uniform(box.lower[axis], box.upper[axis]);
        } else {
            const std::vector<Triangle>& of = i % 2 == 0 ? faulty.mesh.triangles() : meant.triangles();
            const Mesh& mesh = i % 2 == 0 ? faulty.mesh : meant;
            const Triangle& triangle = of[random.index(of.size())];
            point = along(middle_of(mesh, triangle), size_of(mesh, triangle) * std::pow(10, random.uniform(-3, 0)),
                          random.direction());
        }
        if (std::ranges::any_of(faulty.open, [&](const auto& ball) {
                const auto& [at, radius] = ball;
                return std::hypot(point[0] - at[0], point[1] - at[1], point[2] - at[2]) < radius;
            }))
            continue;
        const double winding = winding_by_faces(surface, point), expected = winding_by_faces(meant, point);
        const bool is_inside =
            resolved.rule == SignRule::parity ? std::llround(winding) % 2 != 0 : std::abs(winding) >= 0.5;
        ++verdict.judged;
        if (is_inside == (std::abs(expected) >= 0.5)) continue;
        if (verdict.wrong++ == 0)
            verdict.first = fmt::format("({}, {}, {}), winding number {}, of the solid {}; {}", point[0], point[1],
                                        point[2], winding, expected, resolved.warning);
    }
    return verdict;
}

/// Kinds of faults; those below `single` are of one kind on at most 5% of the faces.
constexpr std::size_t single = 5, kinds = 13;
const char* const kind_names[kinds] = {"turned",
                                       "removed",
                                       "doubled",
                                       "both ways",
                                       "sheets",
                                       "attached sheets",
                                       "both ways, mixed",
                                       "turned and removed",
                                       "sheets and removed",
                                       "both ways and removed",
                                       "sheets and turned",
                                       "all at once",
                                       "many turned, one removed"};

Faulty with_faults(const Mesh& solid, std::size_t kind, Random& random) {
    Faulty faulty{solid, {}};
    const double share = random.uniform(0, 0.05);
    switch (kind) {
        case 0:
            turn_some(faulty, share, random);
            break;
        case 1:
            remove_some(faulty, share, random);
            break;
        case 2:
            double_some(faulty, share, random);
            break;
        case 3:
            double_all(faulty, false, random);
            break;
        case 4:
            add_sheets(faulty, random);
            break;
        case 5:
            attach_sheets(faulty, random);
            break;
        case 6:
            double_all(faulty, true, random);
            break;
        case 7:
            turn_some(faulty, share, random);
            remove_some(faulty, 0.01, random);
            break;
        case 8:
            remove_some(faulty, 0.01, random);
            add_sheets(faulty, random);
            break;
        case 9:
            double_all(faulty, false, random);
            remove_some(faulty, 0.01, random);
            break;
        case 10:
            turn_some(faulty, share, random);
            add_sheets(faulty, random);
            break;
        case 11:
            turn_some(faulty, share, random);
            double_some(faulty, share, random);
            remove_some(faulty, 0.01, random);
            if (random.index(2) == 0) attach_sheets(faulty, random);
            add_sheets(faulty, random);
            break;
        default:
            turn_some(faulty, 0.4, random);
            remove_some(faulty, 0, random);
            break;
    }
    return faulty;
}

}  // namespace

BOOST_AUTO_TEST_CASE(meshes_with_faults_have_the_sign_of_the_solid_or_none) {
    const char* const more = std::getenv("CLSDF_MEANT_SOLIDS");
    const std::uint64_t first = more != nullptr ? std::strtoull(more, nullptr, 10) : 1;
    const std::uint64_t count = more != nullptr ? 1000 : 130;
    BOOST_TEST_MESSAGE("seeds " << first << " to " << first + count - 1);
    struct Counts {
        std::size_t right = 0, none = 0, wrong = 0;
    };
    std::vector<Counts> counts(kinds);
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        Random random(seed);
        const std::size_t kind = seed % kinds;
        const Mesh solid = random_solid(random);
        const Faulty faulty = with_faults(solid, kind, random);
        const Verdict verdict = judge(faulty, solid, random);
        Counts& own = counts[kind];
        ++(!verdict.has_sign ? own.none : verdict.wrong > 0 ? own.wrong : own.right);
        if (verdict.has_sign && verdict.wrong == 0) continue;
        BOOST_TEST_MESSAGE("seed " << seed << ", " << kind_names[kind] << ", " << solid.name() << ": "
                                   << (verdict.has_sign ? "wrong" : "none") << ", " << verdict.wrong << " of "
                                   << verdict.judged << "; " << verdict.first.substr(0, 400));
    }
    std::size_t right = 0, all = 0;
    for (std::size_t kind = 0; kind < kinds; ++kind) {
        const auto& [own_right, none, wrong] = counts[kind];
        BOOST_TEST_MESSAGE(kind_names[kind] << ": " << own_right << " right, " << none << " none, " << wrong
                                            << " wrong");
        BOOST_TEST(wrong == 0U);
        if (kind >= single) continue;
        right += own_right;
        all += own_right + none + wrong;
    }
    BOOST_TEST(10 * right >= 9 * all);
}

}  // namespace clsdf
