#pragma once

#include "same_bytes/meshes.hpp"
#include "same_bytes/results.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <span>
#include <string>
#include <vector>

/// A mesh with the grid, the points and the boxes that are asked for.
namespace clsdf::test {

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr std::size_t few_points = 40;  // the calling thread answers at most 96
inline constexpr std::size_t some_points = 1500;
inline constexpr std::size_t many_points = 17000;  // from 16,384 on a processor groups them

inline OutputSet all_outputs() {
    OutputSet all;
    for (const OutputInfo& info : output_table()) all.insert(info.output);
    return all;
}

inline constexpr Layout in_doubles{.doubles = true};
inline constexpr Layout strided{.order = Layout::strided};
inline constexpr Layout planes{.order = Layout::planes};
inline constexpr Layout on_device{.on_device = true};
inline constexpr Layout on_device_in_doubles{.on_device = true, .doubles = true};
inline constexpr Layout on_device_strided{.on_device = true, .order = Layout::strided};

inline Vec3 middle_of(const Box& box) {
    return {0.5 * (box.lower[0] + box.upper[0]), 0.5 * (box.lower[1] + box.upper[1]),
            0.5 * (box.lower[2] + box.upper[2])};
}

/// A mesh, and what is asked about it.
struct Subject {
    explicit Subject(const NamedMesh& named)
        : name(named.name),
          mesh(named.arrays.vertices, named.arrays.triangles, "mesh"),
          side(mesh.box().longest_side()),
          middle(middle_of(mesh.box())),
          grid(Grid::around(mesh.box(), {.resolution = 40, .margin = Length::of_extent(0.08)})),
          band(Band::symmetric(0.06 * side)) {
        // A block that does not begin at the lattice's sample (0, 0, 0).
        grid.first = {-5, 9, 3};
        for (std::size_t axis = 0; axis < 3; ++axis)
            grid.origin[axis] -= grid.spacing[axis] * static_cast<double>(grid.first[axis]);

        Random random;
        const Box box = mesh.box();
        for (std::size_t k = 0; k < many_points; ++k) {
            const auto vertex = static_cast<std::size_t>(random() * static_cast<double>(mesh.vertices().size()));
            Vec3 point{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const double extent = box.upper[axis] - box.lower[axis];
                point[axis] = k % 2 == 0 ? box.lower[axis] + extent * (1.4 * random() - 0.2)
                                         : mesh.vertices()[vertex][axis] + 0.02 * side * (random() - 0.5);
            }
            if (k % 16 == 1) point = mesh.vertices()[vertex];  // unused vertices, too
            points.push_back(point);
        }
        points[3][1] = std::numeric_limits<double>::quiet_NaN();
        points[5] = {1e30, 0, 0};
        for (const Vec3& p : points)
            for (const double x : p) points_as_floats.push_back(static_cast<float>(x));
    }

    std::string name;
    Mesh mesh;
    double side;
    Vec3 middle;
    Grid grid;
    Band band;
    std::vector<Vec3> points;
    std::vector<float> points_as_floats;
};

inline Buffer buffer_of(const auto& values) {
    return Buffer(std::as_bytes(std::span(values)));
}

/// Boxes of three lattices, of which some share samples, with several bands and outputs.
struct Boxes {
    Boxes(const Subject& s, const Layout& layout, std::size_t count) {
        Random random;
        const std::array<Grid, 3> lattices{s.grid, s.grid.refined(2), s.grid.cell_centred()};
        for (std::size_t k = 0; k < count; ++k) {
            const Grid& lattice = lattices[k % 3];
            Index3 first{}, size{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                size[axis] = 3 + static_cast<std::int64_t>(9 * random());
                const double end = static_cast<double>(lattice.size[axis]);
                first[axis] = lattice.first[axis] + static_cast<std::int64_t>(random() * end) - 2;
            }
            const Grid box = lattice.block(first, size);
            const Band band = k % 5 == 4 ? Band::full() : s.band;
            const OutputSet outputs = k % 7 == 6 ? all_outputs() : OutputSet(Output::distance);
            results.emplace_back(outputs, box.size, layout);
            requests.push_back({box, band, results.back().targets()});
        }
    }
    void report(Line& line) const {
        for (const Results& result : results) result.report(line);
    }
    std::deque<Results> results;
    std::vector<Request> requests;
};

/// Blocks of 4 x 4 x 4 samples, in a checkered order.
inline std::vector<Index3> first_of_blocks(const Grid& grid) {
    std::vector<Index3> first;
    for (std::int64_t z = 0; z < grid.size[2]; z += 8)
        for (std::int64_t y = 0; y < grid.size[1]; y += 8)
            for (std::int64_t x = grid.size[0] - 4 - (y + z) % 3; x >= 0; x -= 8)
                first.push_back({grid.first[0] + x, grid.first[1] + y, grid.first[2] + z});
    return first;
}

inline Index3 size_of_blocks(const std::vector<Index3>& first) {
    return {4, 4, static_cast<std::int64_t>(4 * first.size())};
}

}  // namespace clsdf::test
