#include "mesh/vertices.hpp"

#include <clsdf/error.hpp>

#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "mesh/equal_vertices.hpp"
#include "mesh/mesh_arrays.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace clsdf::engine {

namespace {

void check_rotation(const std::array<Vec3, 3>& rotation) {
    const auto product = [&](std::size_t a, std::size_t b) {
        return rotation[a][0] * rotation[b][0] + rotation[a][1] * rotation[b][1] + rotation[a][2] * rotation[b][2];
    };
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = a; b < 3; ++b)
            if (const double expected = a == b ? 1 : 0; !(std::abs(product(a, b) - expected) <= 1e-12))
                refuse(
                    "the matrix is no rotation: the product of its rows {} and {} is {}, and must be {} "
                    "to 1e-12; make its rows unit vectors at right angles in double precision, for "
                    "example from an angle or a quaternion",
                    a, b, product(a, b), expected);
    const auto& [x, y, z] = rotation;
    const double determinant =
        x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
    if (determinant < 0)
        refuse(
            "the matrix is a reflection, whose determinant is -1, and would turn the mesh inside out; make "
            "the determinant 1, or mirror the mesh and exchange two vertices of each triangle");
}

}  // namespace

Vertices::Vertices(Mesh& mesh, const std::vector<std::uint32_t>& first) : Vertices(mesh.vertices().size()) {
    Mesh one_of_each = merged(mesh, first);
    welded_.assign(count_, no_vertex);
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) welded_[mesh.triangles()[t][k]] = one_of_each.triangles()[t][k];
    mesh = std::move(one_of_each);
}

std::vector<std::uint32_t> Vertices::numbers(const std::vector<std::uint32_t>& first) {
    std::vector<std::uint32_t> numbers(first.size());
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < first.size(); ++i) numbers[i] = first[i] == i ? next++ : numbers[first[i]];
    return numbers;
}

std::vector<Vec3> Vertices::moved(const Mesh& mesh, std::span<const Vec3> positions) const {
    if (positions.size() != count_)
        refuse("{} has {} vertices, and {} positions are given; give one for each", mesh.name(), count_,
               positions.size());
    if (welded_.empty()) return {positions.begin(), positions.end()};
    std::vector<Vec3> result(mesh.vertices());
    std::vector<std::uint32_t> first(result.size(), no_vertex);
    for (std::uint32_t vertex = 0; vertex < count_; ++vertex) {
        const std::uint32_t index = welded_[vertex];
        if (index == no_vertex) continue;
        const Vec3& to = positions[vertex];
        if (!is_finite(to))
            throw Error(ErrorCode::invalid_mesh,
                        fmt::format("{}: vertex {}, counted from 0, moves to ({}, {}, {}), which is not finite",
                                    mesh.name(), vertex, to[0], to[1], to[2]));
        if (first[index] == no_vertex) {
            first[index] = vertex;
            result[index] = to;
        } else if (const Vec3& other = result[index]; other != to) {
            refuse(
                "vertices {} and {} of {} had equal coordinates and count as one, and they move "
                "apart, to ({}, {}, {}) and ({}, {}, {}); move them together, or make a new "
                "transform",
                first[index], vertex, mesh.name(), other[0], other[1], other[2], to[0], to[1], to[2]);
        }
    }
    return result;
}

std::size_t Vertices::callers_number(std::uint32_t vertex) const {
    if (welded_.empty()) return vertex;
    return static_cast<std::size_t>(std::ranges::find(welded_, vertex) - welded_.begin());
}

std::vector<std::uint32_t> Vertices::callers_numbers(std::size_t count) const {
    std::vector<std::uint32_t> numbers(count, no_vertex);
    if (welded_.empty()) std::iota(numbers.begin(), numbers.end(), 0U);
    for (std::uint32_t vertex = 0; vertex < welded_.size(); ++vertex)
        if (welded_[vertex] < count) numbers[welded_[vertex]] = std::min(numbers[welded_[vertex]], vertex);
    return numbers;
}

std::vector<Vec3> Vertices::moved(std::span<const Vec3> first, const std::array<Vec3, 3>& rotation,
                                  const Vec3& translation) {
    check_rotation(rotation);
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!std::isfinite(translation[axis]))
            refuse("the translation's component {} is {}; give a finite one", "xyz"[axis], translation[axis]);
    std::vector<Vec3> positions(first.size());
    for_each_index(positions.size(), [&](std::size_t vertex) {
        const Vec3& x = first[vertex];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const Vec3& row = rotation[axis];
            positions[vertex][axis] =
                std::fma(row[0], x[0], std::fma(row[1], x[1], std::fma(row[2], x[2], translation[axis])));
        }
    });
    return positions;
}

}  // namespace clsdf::engine
