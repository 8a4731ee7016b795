#include "checks/known_field.hpp"

#include "binary_tree.h"
#include "frusta/frames.hpp"

#include <clsdf/outputs.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace clsdf::checks {

namespace {

using engine::to_vector;
using engine::Vector;
using targets::HostArray;
using targets::HostArrays;

// In voxels: what a field is held to (docs/accuracy.md), twice.
constexpr double tolerance = 2e-5;

// The saddle vertex.
constexpr Vec3 saddle{5.31, 4.22, 3.13};
constexpr double fan_scale = 1.1;

constexpr Vec3 cube_centre{-4.37, -4.71, -4.13};

struct Surface {
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles;
};

/// A cube, slightly sheared, that holds a whole brick deeper than the band. On the sides across x, triangles have so
/// many rows of samples that the sweep divides them; on the other sides they are so small that their polyhedra are
/// slender, except on a fine grid.
Surface make_cube() {
    constexpr std::array<int, 3> cells{4, 2, 2};
    Surface cube;
    std::array<std::uint32_t, 45> numbers{};
    const auto place = [](const std::array<int, 3>& p) {
        return static_cast<std::size_t>(p[0] + 5 * (p[1] + 3 * p[2]));
    };
    for (int z = 0; z <= cells[2]; ++z)
        for (int y = 0; y <= cells[1]; ++y)
            for (int x = 0; x <= cells[0]; ++x) {
                if (x % cells[0] != 0 && y % cells[1] != 0 && z % cells[2] != 0) continue;
                const double u = x / 2.0 - 1, v = y - 1, w = z - 1;
                numbers[place({x, y, z})] = static_cast<std::uint32_t>(cube.vertices.size());
                cube.vertices.push_back({cube_centre[0] + 5.7 * (u + 0.05 * v - 0.03 * w),
                                         cube_centre[1] + 5.7 * (v - 0.04 * u + 0.05 * w),
                                         cube_centre[2] + 5.7 * (w + 0.03 * u - 0.05 * v)});
            }
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const int side : {0, cells[axis]})
            for (int i = 0; i < cells[(axis + 1) % 3]; ++i)
                for (int j = 0; j < cells[(axis + 2) % 3]; ++j) {
                    const auto number = [&](int a, int b) {
                        std::array<int, 3> p{};
                        p[axis] = side;
                        p[(axis + 1) % 3] = i + a;
                        p[(axis + 2) % 3] = j + b;
                        return numbers[place(p)];
                    };
                    // Outwards.
                    const int a = side == 0 ? 0 : 1, b = 1 - a;
                    cube.triangles.push_back({number(0, 0), number(a, b), number(1, 1)});
                    cube.triangles.push_back({number(0, 0), number(1, 1), number(b, a)});
                }
    return cube;
}

/// A double cone, whose faces all meet at the lower or the upper vertex.
Surface make_double_cone() {
    constexpr std::uint32_t sides = CLSDF_LISTED_FACES + 4;
    Surface cone;
    cone.vertices = {{0, 0, 0}, {0.1, 0, 4}};
    for (std::uint32_t i = 0; i < sides; ++i) {
        const double angle = 2 * std::numbers::pi * (i + 0.3) / sides;
        cone.vertices.push_back({0.8 * std::cos(angle), 0.8 * std::sin(angle), 2.2});
        const std::uint32_t here = 2 + i, next = 2 + (i + 1) % sides;
        cone.triangles.push_back({0, next, here});
        cone.triangles.push_back({1, here, next});
    }
    return cone;
}

/// Three closed, oriented surfaces that lie apart, in voxels. The first vertex of the second one is a saddle: samples
/// beyond it lie in the polyhedron of no triangle. The third one has a sliver, 9 long and a few hundredths wide.
Mesh make_mesh(bool many_at_vertex) {
    Surface all = make_cube();
    const auto add = [&](const Vec3& centre, double scale, const Surface& surface) {
        const auto first = static_cast<std::uint32_t>(all.vertices.size());
        for (const Vec3& p : surface.vertices)
            all.vertices.push_back({centre[0] + scale * p[0], centre[1] + scale * p[1], centre[2] + scale * p[2]});
        for (const Triangle& face : surface.triangles)
            all.triangles.push_back({first + face[0], first + face[1], first + face[2]});
    };
    add(saddle, fan_scale,
        {{{0, 0, 0}, {0, -1, -4}, {-1, -4, 1}, {-1, -4, 0}, {-4, 1, -1}, {-4, 0, -1}, {1, -1, -4}},
         {{0, 2, 1},
          {0, 3, 2},
          {0, 4, 3},
          {0, 5, 4},
          {0, 6, 5},
          {0, 1, 6},
          {1, 2, 3},
          {3, 4, 5},
          {1, 3, 5},
          {1, 5, 6}}});
    add({0, 0, 0}, 1,
        {{{-5.2, 1.9, 4.6}, {3.9, 3.1, 5.3}, {-0.6, 2.52, 4.99}, {-1.1, 3.0, 6.2}},
         {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}});
    if (many_at_vertex) add({-3.5, 3.6, -1}, 1, make_double_cone());
    return {std::move(all.vertices), std::move(all.triangles), "known field"};
}

/// Sample (16, 16, 16), in the middle of a coarse brick, is the cube's centre. The rows along x lie in this coarse
/// brick, in the next one, which a face of the cube crosses, and in one outside.
Grid make_fine_grid(const KnownFieldKind& kind) {
    Grid grid;
    grid.spacing = {0.15, 0.15, 0.15};
    if (kind.long_bricks) grid.spacing[2] *= 1.7;
    for (std::size_t axis = 0; axis < 3; ++axis) grid.origin[axis] = cube_centre[axis] - 16 * grid.spacing[axis];
    grid.first = {-36, 12, 12};
    grid.size = {40, 4, 4};
    return grid;
}

/// The grid's sample (0, 0, 0) is the common corner of eight coarse bricks. Some samples of the lattice on the surface
/// lie a few 1e-9 beside vertices and faces of the second surface. They are so near that their gradient is the
/// pseudonormal, and farther than the rounding of this arithmetic, so that their sign is certain.
Grid make_grid(const KnownFieldKind& kind) {
    if (kind.fine) return make_fine_grid(kind);
    Grid grid;
    if (kind.on_surface) {
        grid.origin = {saddle[0] + 2e-9, saddle[1] + 5e-9, saddle[2] - 3e-9};
        grid.spacing = Vec3{fan_scale / 2, fan_scale / 2, fan_scale / 2};
        grid.first = {-15, -15, -13};
        grid.size = {18, 18, 18};
    } else {
        grid.origin = {0.13, -0.21, 0.37};
        grid.spacing = Vec3{0.55, 0.55, 0.55};
        grid.first = {-11, -10, -9};
        grid.size = {23, 21, 20};
    }
    if (kind.long_bricks) grid.spacing[2] *= 1.7;
    return grid;
}

Band make_band(const KnownFieldKind& kind, double voxel) {
    return kind.wide ? Band::full() : Band{1.3 * voxel, 1.6 * voxel};
}

/// Squared; the cases are the regions of the triangle's plane nearest to its corners, edges and face (C. Ericson,
/// Real-Time Collision Detection, 2005, 5.1.5).
double squared_distance(const Vector& p, const Vector& a, const Vector& b, const Vector& c) {
    const Vector ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = ab.dot(ap), d2 = ac.dot(ap);
    if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
    const double d3 = ab.dot(bp), d4 = ac.dot(bp);
    if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
    const double d5 = ab.dot(cp), d6 = ac.dot(cp);
    if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
        return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).squaredNorm();
    const Vector normal = ab.cross(ac);
    const double height = normal.dot(ap);
    return height * height / normal.squaredNorm();
}

/// A crossing of the row through (y, z) along x and a triangle, and the direction in which the surface faces there.
struct Crossing {
    double x;
    int winding;
};

std::optional<Crossing> crossing_of(double y, double z, const Vector& a, const Vector& b, const Vector& c) {
    const auto side = [&](const Vector& from, const Vector& to) {
        return (to.y() - from.y()) * (z - from.z()) - (to.z() - from.z()) * (y - from.y());
    };
    const double of_c = side(a, b), of_a = side(b, c), of_b = side(c, a);
    if ((of_a > 0) != (of_b > 0) || (of_b > 0) != (of_c > 0)) return std::nullopt;
    return Crossing{(of_a * a.x() + of_b * b.x() + of_c * c.x()) / (of_a + of_b + of_c), of_a > 0 ? 1 : -1};
}

std::string text_of(const Vec3& p) {
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", p[0], p[1], p[2]);
}

}  // namespace

std::vector<Vec3> positions_of(const Grid& grid) {
    std::vector<Vec3> positions;
    positions.reserve(grid.sample_count());
    for (std::int64_t k = 0; k < grid.size[2]; ++k)
        for (std::int64_t j = 0; j < grid.size[1]; ++j)
            for (std::int64_t i = 0; i < grid.size[0]; ++i) positions.push_back(grid.position(i, j, k));
    return positions;
}

KnownField::KnownField(const KnownFieldKind& kind)
    : mesh_(make_mesh(kind.many_at_vertex)),
      grid_(make_grid(kind)),
      band_(make_band(kind, grid_.voxel())),
      outputs_(mesh_, grid_) {}

double KnownField::distance_to(std::uint32_t triangle, const Vec3& point) const {
    const Triangle& t = mesh_.triangles()[triangle];
    const std::vector<Vec3>& v = mesh_.vertices();
    return std::sqrt(squared_distance(to_vector(point), to_vector(v[t[0]]), to_vector(v[t[1]]), to_vector(v[t[2]])));
}

std::vector<double> KnownField::signs() const {
    const std::vector<Vec3>& v = mesh_.vertices();
    std::vector<double> signs(grid_.sample_count(), 1);
    for (std::int64_t k = 0; k < grid_.size[2]; ++k)
        for (std::int64_t j = 0; j < grid_.size[1]; ++j) {
            const Vec3 row = grid_.position(0, j, k);
            std::vector<Crossing> crossings;
            for (const Triangle& t : mesh_.triangles())
                if (const auto crossing =
                        crossing_of(row[1], row[2], to_vector(v[t[0]]), to_vector(v[t[1]]), to_vector(v[t[2]])))
                    crossings.push_back(*crossing);
            for (std::int64_t i = 0; i < grid_.size[0]; ++i) {
                const double x = grid_.position(i, j, k)[0];
                int winding = 0;
                for (const Crossing& crossing : crossings)
                    if (crossing.x < x) winding += crossing.winding;
                if (winding != 0) signs[grid_.offset(i, j, k)] = -1;
            }
        }
    return signs;
}

std::vector<double> KnownField::values() const {
    std::vector<std::array<Vector, 3>> corners;
    for (const Triangle& t : mesh_.triangles())
        corners.push_back(
            {to_vector(mesh_.vertices()[t[0]]), to_vector(mesh_.vertices()[t[1]]), to_vector(mesh_.vertices()[t[2]])});
    std::vector<double> values = signs();
    const std::vector<Vec3> positions = positions_of(grid_);
    for (std::size_t at = 0; at < values.size(); ++at) {
        double least = std::numeric_limits<double>::infinity();
        for (const auto& [a, b, c] : corners)
            least = std::min(least, squared_distance(to_vector(positions[at]), a, b, c));
        values[at] *= std::sqrt(least);
    }
    return values;
}

KnownField KnownField::within(double half_width) const {
    KnownField result = *this;
    result.band_ = Band::symmetric(half_width);
    return result;
}

double KnownField::error() const {
    return tolerance * grid_.voxel();
}

double KnownField::limit(bool negative, const HostArray& distance) const {
    const double half_width = negative ? band_.inside : band_.outside;
    return distance.in_double ? half_width : static_cast<double>(static_cast<float>(half_width));
}

std::size_t KnownField::band_samples(const HostArrays& found) const {
    const HostArray& distance = found[Output::distance];
    const double inside = -limit(true, distance), outside = limit(false, distance);
    std::size_t count = 0;
    for (std::size_t at = 0; at < grid_.sample_count(); ++at) {
        const double value = number_at(found, Output::distance, at);
        count += static_cast<std::size_t>(inside < value && value < outside);
    }
    return count;
}

std::string KnownField::wrong_distance(const HostArrays& found, const KnownSample& sample) const {
    // Beyond the band a sample carries the band's limit.
    const double expected = std::clamp(sample.distance, -band_.inside, band_.outside);
    const double distance = number_at(found, Output::distance, sample.at);
    // A comparison that a NaN fails, too.
    if (std::abs(distance - expected) <= error()) return {};
    return fmt::format("has the distance {:.9g} instead of {:.7g}", distance, expected);
}

std::string KnownField::wrong_triangle(const HostArrays& found, const KnownSample& sample) const {
    const auto triangle = static_cast<std::uint32_t>(number_at(found, Output::triangle, sample.at));
    const double limit = sample.distance < 0 ? band_.inside : band_.outside, length = std::abs(sample.distance);
    const bool is_none = triangle == no_triangle;
    const bool is_nearest =
        triangle < mesh_.triangles().size() && distance_to(triangle, sample.position) <= length + error();
    if (is_none ? length >= limit - error() : length <= limit + error() && is_nearest) return {};
    return fmt::format("has the triangle {}, which is not nearest", triangle);
}

std::optional<std::string> KnownField::difference(const HostArrays& found) const {
    const std::vector<double> known = values();
    std::size_t wrong = 0;
    std::string first;
    for (std::int64_t k = 0; k < grid_.size[2]; ++k)
        for (std::int64_t j = 0; j < grid_.size[1]; ++j)
            for (std::int64_t i = 0; i < grid_.size[0]; ++i) {
                const std::size_t at = grid_.offset(i, j, k);
                const KnownSample sample{
                    at,
                    {static_cast<double>(grid_.first[0] + i), static_cast<double>(grid_.first[1] + j),
                     static_cast<double>(grid_.first[2] + k)},
                    grid_.position(i, j, k),
                    known[at],
                    limit(known[at] < 0, found[Output::distance])};
                std::string what = wrong_distance(found, sample);
                if (what.empty() && found[Output::triangle].is_wanted) what = wrong_triangle(found, sample);
                if (what.empty() && found[Output::closest].is_wanted)
                    what = outputs_.difference(found, sample, error());
                if (what.empty()) continue;
                if (wrong++ == 0)
                    first = fmt::format("sample ({}, {}, {}) at {} {}", grid_.first[0] + i, grid_.first[1] + j,
                                        grid_.first[2] + k, text_of(sample.position), what);
            }
    if (wrong == 0) return std::nullopt;
    return fmt::format("{}; {} of {} samples are wrong", first, wrong, known.size());
}

}  // namespace clsdf::checks
