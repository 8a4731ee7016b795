#pragma once

#include <clsdf/mesh.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

/// The meshes on which bounding polyhedra are known to fail: closed, consistently oriented, with short exact
/// coordinates. Each comes with a half width and with samples whose distance is known.
namespace clsdf::test {

/// Peikert & Sigg's polyhedra do not hold the sample at all.
inline constexpr double uncovered = std::numeric_limits<double>::infinity();

struct KnownSample {
    Vec3 position;
    double distance;   ///< unsigned
    double tolerance;  ///< half a unit of the last digit of `distance`, or more if the position is rounded
    std::optional<double>
        paper;            ///< the value of Peikert & Sigg's polyhedra (with closed gaps if `closed`), if it is known
    bool closed = false;  ///< after the gaps were closed as in the paper
};

struct Counterexample {
    Mesh mesh;
    double half_width;  ///< of a symmetric band
    std::vector<KnownSample> samples;

    const std::string& name() const { return mesh.name(); }
};

/// A fan of triangles around the origin, closed from below by a second apex at (0, 0, -8). The ring runs
/// counter-clockwise seen from above: vertices 0 (apex), 1 ... n (ring), n + 1 (closing apex).
inline Mesh closed_fan(std::string name, const std::vector<Vec3>& ring) {
    const auto count = static_cast<std::uint32_t>(ring.size());
    std::vector<Vec3> vertices{{0, 0, 0}};
    vertices.insert(vertices.end(), ring.begin(), ring.end());
    vertices.push_back({0, 0, -8});
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t next = 1 + (i + 1) % count;
        triangles.push_back({0, 1 + i, next});
        triangles.push_back({count + 1, next, 1 + i});
    }
    return {std::move(vertices), std::move(triangles), std::move(name)};
}

/// A tip at (0, 0, height) over a ring of radius 10 whose vertices lie `wave` above and below the plane in turn.
inline Mesh tip(std::uint32_t ring, double height, double wave) {
    std::vector<Vec3> vertices{{0, 0, height}};
    std::vector<Triangle> triangles;
    for (std::uint32_t i = 0; i < ring; ++i) {
        const double angle = 6.283185307179586 * i / ring;
        vertices.push_back({10 * std::cos(angle), 10 * std::sin(angle), i % 2 == 0 ? wave : -wave});
        triangles.push_back({0, 1 + i, 1 + (i + 1) % ring});
    }
    return {std::move(vertices), std::move(triangles), "tip"};
}

/// Concave side: a step 0.01 high. Samples over the low floor lie only in the riser's polyhedron.
inline Counterexample a1_step() {
    std::vector<Vec3> vertices;
    for (const double y : {0.0, 20.0}) {
        vertices.insert(vertices.end(),
                        {{0, y, -10}, {20, y, -10}, {20, y, 0.01}, {10, y, 0.01}, {10, y, 0}, {0, y, 0}});
    }
    std::vector<Triangle> triangles{{0, 7, 1},  {0, 6, 7},  {1, 8, 2},   {1, 7, 8},  {2, 9, 3},  {2, 8, 9}, {3, 10, 4},
                                    {3, 9, 10}, {4, 11, 5}, {4, 10, 11}, {5, 6, 0},  {5, 11, 6}, {4, 5, 0}, {10, 6, 11},
                                    {4, 0, 1},  {10, 7, 6}, {4, 1, 2},   {10, 8, 7}, {4, 2, 3},  {10, 9, 8}};
    return {Mesh(std::move(vertices), std::move(triangles), "a1_step"),
            2,
            {{{9.5, 10.3, 1}, 1, 1e-12, 1.10909873},
             {{8.5, 10.3, 1.9}, 1.9, 1e-12, 2.41290282},
             {{9.9, 10.3, 0.2}, 0.2, 1e-12, 0.214709106}}};
}

/// Concave side: an acute flap 0.02 high on a large floor. The paper's error is several half widths.
inline Counterexample a3_flap() {
    std::vector<Vec3> vertices;
    for (const double y : {0.0, 20.0}) {
        vertices.insert(vertices.end(),
                        {{0, y, -5}, {20, y, -5}, {20, y, 0}, {10.01, y, 0}, {9.9, y, 0.02}, {10, y, 0}, {0, y, 0}});
    }
    std::vector<Triangle> triangles{{0, 8, 1},  {0, 7, 8},   {1, 9, 2},   {1, 8, 9},   {2, 10, 3},   {2, 9, 10},
                                    {3, 11, 4}, {3, 10, 11}, {4, 12, 5},  {4, 11, 12}, {5, 13, 6},   {5, 12, 13},
                                    {6, 7, 0},  {6, 13, 7},  {0, 1, 5},   {1, 3, 5},   {1, 2, 3},    {3, 4, 5},
                                    {0, 5, 6},  {7, 12, 8},  {8, 12, 10}, {8, 10, 9},  {10, 12, 11}, {7, 13, 12}};
    return {Mesh(std::move(vertices), std::move(triangles), "a3_flap"),
            1,
            {{{6, 10.3, 0.7}, 0.7, 1e-12, 3.95883821}, {{8, 10.3, 0.4}, 0.4, 1e-12, 1.93762742}}};
}

/// Obtuse corners of a convex solid.
inline Counterexample b1() {
    return {Mesh({{0, -1, 0.5}, {0, 1, 0.5}, {-1, 3, 2.5}, {1, -1.5, -0.5}},
                 {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, "b1"),
            1,
            {{{-0.15, 2.05, 0.35}, 0.851469318, 5e-10, 1.07121426}}};
}

inline Counterexample b2() {
    return {
        Mesh({{0, 0, 0}, {-4, -4, -3}, {1, 1, 3}, {-2, -1, -2}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, "b2"),
        1,
        {{{0.75, 0.5, 0.25}, 0.715096942, 5e-10, 0.935414347}}};
}

/// Gaps that the paper's test of adjacent pairs of bisector planes does not see.
inline Counterexample g1() {
    return {closed_fan("g1", {{4, 0, 2}, {3, 2, -1}, {-2, 2, 3}, {-3, 1, 3}, {-1, -2, 4}, {3, -3, 1}}),
            1,
            {{{0.1034, 0.09185, 0.4805}, 0.341836, 5e-5, uncovered}}};
}

inline Counterexample g2() {
    return {closed_fan("g2", {{3, 1, 3}, {2, 2, 1}, {-3, 4, 2}, {-5, 1, 1}, {-3, -3, 3}, {1, -3, 2}}),
            1,
            {{{-0.1085, 0.08581, 0.4805}, 0.391383, 5e-5, uncovered}}};
}

/// Gaps that the paper's test sees, and whose closing leaves wrong samples.
inline Counterexample w0() {
    return {
        closed_fan("w0",
                   {{3, -1, 0}, {2, 4, -2}, {1, 3, 2}, {-3, 2, 1}, {-4, 0, 4}, {-2, -2, 0}, {-1, -3, 2}, {2, -2, -3}}),
        1,
        {{{-0.397068, 0.269484, -0.985719}, 0.99499, 5e-6, uncovered, true}}};
}

inline Counterexample w1() {
    return {closed_fan("w1", {{3, 1, -4}, {3, 2, 1}, {-3, 2, -2}, {-3, 0, 4}, {-1, -4, -2}, {1, -4, 1}}),
            0.3,
            {{{0.0775012, -0.0418187, 0.228767}, 0.203602, 1e-6, uncovered},
             {{0.0703438, -0.0292885, 0.359641}, 0.273632, 1e-6, 0.341199, true}}};
}

inline Counterexample w2() {
    return {closed_fan("w2", {{3, -1, -1}, {1, 3, 2}, {-2, 4, -4}, {-5, -1, 4}, {-3, -3, -1}, {2, -2, 4}}),
            1,
            {{{-0.0344, 0.133193, 1.19946}, 0.792351, 5e-6, 0.949022, true}}};
}

/// h1 to h6: vertices with a gap; without a point site the sample lies in no leaned frustum.
inline Counterexample h1() {
    return {Mesh({{0, 0, 0}, {0, -1, -4}, {-1, -4, 1}, {-1, -4, 0}, {-4, 1, -1}, {-4, 0, -1}, {1, -1, -4}},
                 {{0, 2, 1},
                  {0, 3, 2},
                  {0, 4, 3},
                  {0, 5, 4},
                  {0, 6, 5},
                  {0, 1, 6},
                  {1, 2, 3},
                  {3, 4, 5},
                  {1, 3, 5},
                  {1, 5, 6}},
                 "h1"),
            1,
            {{{0.5, 0.5, 0.5}, 0.866025404, 5e-10, std::nullopt},
             {{0.375, 0.25, 0.875}, 0.984250984, 5e-10, std::nullopt}}};
}

inline Counterexample h2() {
    return {Mesh({{0, 0, 0}, {12, -2, -10}, {9, -1, -8}, {-11, -6, -12}, {-4, -3, -7}, {-2, 12, -4}, {-2, 10, -4}},
                 {{0, 2, 1},
                  {0, 3, 2},
                  {0, 4, 3},
                  {0, 5, 4},
                  {0, 6, 5},
                  {0, 1, 6},
                  {6, 1, 2},
                  {2, 3, 4},
                  {6, 2, 4},
                  {4, 5, 6}},
                 "h2"),
            1,
            {{{0, 0, 1}, 1, 1e-12, std::nullopt}}};
}

inline Counterexample h3() {
    return {Mesh({{0, 0, 0}, {-3, 1, -3}, {-4, 2, -4}, {3, 2, -2}, {4, 3, -3}, {0, 3, 2}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1}, {5, 2, 1}, {2, 4, 3}, {2, 5, 4}}, "h3"),
            1,
            {{{0.375, -0.875, 0.25}, 0.984250984, 5e-10, std::nullopt}}};
}

inline Counterexample h4() {
    return {Mesh({{0, 0, 0}, {4, 2, 0}, {-2, 3, -4}, {-3, 4, -4}, {2, -4, -4}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {4, 2, 1}, {2, 4, 3}}, "h4"),
            1,
            {{{-0.375, 0.25, 0.875}, 0.984250984, 5e-10, std::nullopt}}};
}

inline Counterexample h5() {
    return {Mesh({{0, 0, 0}, {1, -3, 1}, {-3, -2, -4}, {-4, 0, 3}, {1, -4, 1}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {4, 2, 1}, {2, 4, 3}}, "h5"),
            1,
            {{{0.625, 0.75, 0.125}, 0.984250984, 5e-10, std::nullopt}}};
}

/// Thin folded sheets that intersect themselves; coordinates are in voxels.
inline Counterexample h6() {
    const double f = 0.00588843655;
    return {Mesh({{0, 0, 0},
                  {f * -579, f * -552, f * -960},
                  {f * 593, f * -685, f * 984},
                  {f * 439, f * -966, f * 729},
                  {f * 200, f * -568, f * 331},
                  {9.627862130587927, -29.215411399169266, 17.791194788496334}},
                 {{0, 1, 2}, {5, 2, 1}, {0, 2, 3}, {5, 3, 2}, {0, 3, 4}, {5, 4, 3}, {0, 4, 1}, {5, 1, 4}}, "h6"),
            20,
            {{{-1.13327998, 19.8571109, -1.90032167}, 19.98, 5e-3, std::nullopt}}};
}

inline std::vector<Counterexample> all_counterexamples() {
    return {a1_step(), a3_flap(), b1(), b2(), g1(), g2(), w0(), w1(), w2(), h1(), h2(), h3(), h4(), h5(), h6()};
}

}  // namespace clsdf::test
