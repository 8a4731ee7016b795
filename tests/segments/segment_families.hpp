#pragma once

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

/// Meshes that touch samples, links and each other in every way, with the grids on which they do.
namespace clsdf::test {

struct Family {
    std::string name;
    Mesh mesh;
    Grid grid;
    SignRule rule = SignRule::nonzero;
};

struct Parts {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;

    Mesh mesh(const std::string& name) const { return {vertices, triangles, name}; }
};

inline Parts box_between(const Vec3& a, const Vec3& b) {
    return {{{a[0], a[1], a[2]},
             {b[0], a[1], a[2]},
             {b[0], b[1], a[2]},
             {a[0], b[1], a[2]},
             {a[0], a[1], b[2]},
             {b[0], a[1], b[2]},
             {b[0], b[1], b[2]},
             {a[0], b[1], b[2]}},
            {{0, 2, 1},
             {0, 3, 2},
             {4, 5, 6},
             {4, 6, 7},
             {0, 1, 5},
             {0, 5, 4},
             {1, 2, 6},
             {1, 6, 5},
             {2, 3, 7},
             {2, 7, 6},
             {3, 0, 4},
             {3, 4, 7}}};
}

inline Parts joined(const std::vector<Parts>& all) {
    Parts result;
    for (const Parts& part : all) {
        const auto first = static_cast<std::uint32_t>(result.vertices.size());
        result.vertices.insert(result.vertices.end(), part.vertices.begin(), part.vertices.end());
        for (const auto& [a, b, c] : part.triangles) result.triangles.push_back({a + first, b + first, c + first});
    }
    return result;
}

inline Parts turned(Parts parts) {
    for (Triangle& t : parts.triangles) std::swap(t[1], t[2]);
    return parts;
}

inline Parts octahedron(const Vec3& m, double r) {
    return {{{m[0] + r, m[1], m[2]},
             {m[0] - r, m[1], m[2]},
             {m[0], m[1] + r, m[2]},
             {m[0], m[1] - r, m[2]},
             {m[0], m[1], m[2] + r},
             {m[0], m[1], m[2] - r}},
            {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

inline double volume_of(const std::array<Vec3, 4>& v) {
    std::array<Vec3, 3> d{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) d[i][axis] = v[i + 1][axis] - v[0][axis];
    return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) + d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
           d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
}

inline Parts tetrahedron(const std::array<Vec3, 4>& v) {
    Parts parts{{v.begin(), v.end()}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
    return volume_of(v) > 0 ? parts : turned(parts);
}

/// Tetrahedra whose coordinates are multiples of `step` between 1 and top - 1.
inline Parts soup(std::uint64_t seed, int count, double step, double top) {
    std::mt19937_64 generator(seed);
    std::uniform_int_distribution<int> number(static_cast<int>(1 / step), static_cast<int>((top - 1) / step));
    std::vector<Parts> parts;
    while (parts.size() < static_cast<std::size_t>(count)) {
        std::array<Vec3, 4> v{};
        for (Vec3& p : v)
            for (double& x : p) x = number(generator) * step;
        if (std::abs(volume_of(v)) > 1e-9) parts.push_back(tetrahedron(v));
    }
    return joined(parts);
}

inline Parts moved(Parts parts, double factor, const Vec3& offset) {
    for (Vec3& v : parts.vertices)
        for (std::size_t axis = 0; axis < 3; ++axis) v[axis] = v[axis] * factor + offset[axis];
    return parts;
}

inline std::vector<Family> families() {
    std::vector<Family> all;
    const auto add = [&](const std::string& name, const Parts& parts, const Grid& grid,
                         SignRule rule = SignRule::nonzero) {
        all.push_back({name, parts.mesh(name), grid, rule});
    };
    const auto unit = [](std::int64_t x, std::int64_t y, std::int64_t z) {
        return Grid{{0, 0, 0}, {1, 1, 1}, {x, y, z}, {0, 0, 0}};
    };
    add("cube on planes", box_between({2, 2, 2}, {5, 5, 5}), unit(8, 8, 8));
    add("cube between", box_between({1.5, 1.25, 1.75}, {5.5, 5.25, 5.125}), unit(7, 7, 7));
    add("octahedron on samples", octahedron({4, 4, 4}, 3), unit(9, 9, 9));
    add("octahedron at halves", octahedron({3.5, 3.5, 3.5}, 2.5), unit(8, 8, 8));
    add("touching boxes", joined({box_between({2, 2, 2}, {4, 5, 5}), box_between({4, 2, 2}, {7, 5, 5})}),
        unit(9, 8, 8));
    add("overlapping boxes", joined({box_between({1, 1, 1}, {4, 5, 5}), box_between({3, 2, 1}, {7, 6, 5})}),
        unit(9, 8, 7));
    add("nested, filled", joined({box_between({1, 1, 1}, {7, 7, 7}), box_between({3, 3, 3}, {5, 5, 5})}),
        unit(9, 9, 9));
    add("nested, common faces", joined({box_between({1, 1, 1}, {6, 6, 6}), box_between({1, 1, 1}, {4, 4, 6})}),
        unit(8, 8, 8));
    add("cavity, common face", joined({box_between({1, 1, 1}, {7, 7, 7}), turned(box_between({1, 3, 3}, {5, 5, 5}))}),
        unit(9, 9, 9));
    add("parity of two boxes", joined({box_between({1, 1, 1}, {5, 5, 5}), box_between({3, 3, 3}, {7, 7, 7})}),
        unit(9, 9, 9), SignRule::parity);
    add("doubled cube", joined({box_between({2, 2, 2}, {5, 5, 5}), box_between({2, 2, 2}, {5, 5, 5})}), unit(8, 8, 8));
    add("slivers",
        joined({tetrahedron({{{1, 1, 1}, {7, 7, 7}, {7, 7, 7.0000000001}, {6, 7, 7}}}),
                tetrahedron({{{0.5, 3, 3}, {7.5, 3, 3}, {7.5, 3.0000001, 3}, {7.5, 3, 3.0001}}}),
                box_between({1, 5, 3}, {6, 6, 3.000000001})}),
        unit(9, 9, 9));
    add("thin plate", box_between({1, 1, 3.25}, {6, 6, 3.5}), unit(8, 8, 7));
    add("large beside the grid", box_between({-1e5, -3e4, -2e5}, {3.25, 4, 5e5}), unit(6, 6, 6));
    for (std::uint64_t seed = 0; seed < 4; ++seed)
        add(fmt::format("soup of whole numbers {}", seed), soup(seed, 8, 1, 8), unit(9, 9, 9));
    for (std::uint64_t seed = 10; seed < 12; ++seed)
        add(fmt::format("soup of halves {}", seed), soup(seed, 8, 0.5, 8), unit(9, 9, 9));
    add("soup, parity", soup(20, 8, 1, 8), unit(9, 9, 9), SignRule::parity);
    add("soup, random", soup(30, 8, 0.001, 8), unit(9, 9, 9));
    add("decimal box", box_between({0.2, 0.2, 0.2}, {0.7, 0.7, 0.7}), {{0, 0, 0}, {0.1, 0.1, 0.1}, {10, 10, 10}, {}});
    add("decimal octahedron", octahedron({0.5, 0.5, 0.5}, 0.3), {{0, 0, 0}, {0.1, 0.1, 0.1}, {11, 11, 11}, {}});
    add("decimal soup", moved(soup(40, 6, 1, 8), 0.1, {0.3, -0.7, 1.1}),
        {{0.3, -0.7, 1.1}, {0.1, 0.1, 0.1}, {9, 9, 9}, {}});
    add("unequal spacing", moved(soup(41, 6, 1, 8), 0.3, {0, 0, 0}), {{0, 0, 0}, {0.1, 0.3, 0.7}, {25, 9, 5}, {}});
    add("far away", moved(soup(42, 6, 1, 8), 1, {1e6, -1e6, 1e6}), {{1e6, -1e6, 1e6}, {1, 1, 1}, {9, 9, 9}, {}});
    add("far by number", moved(soup(42, 6, 1, 8), 1, {1e6, -1e6, 1e6}),
        {{0, 0, 0}, {1, 1, 1}, {9, 9, 9}, {1000000, -1000000, 1000000}});
    add("far, decimal", moved(soup(43, 6, 1, 8), 0.1, {1e6, -1e6, 1e6}),
        {{1e6, -1e6, 1e6}, {0.1, 0.1, 0.1}, {9, 9, 9}, {}});
    add("tiny", moved(soup(44, 6, 1, 8), 0x1p-100, {0, 0, 0}),
        {{0, 0, 0}, {0x1p-100, 0x1p-100, 0x1p-100}, {9, 9, 9}, {}});
    return all;
}

}  // namespace clsdf::test
