#include "core/parallel.hpp"
#include "core/refuse.hpp"
#include "core/word_hash.hpp"
#include "mesh/box_index.hpp"
#include "mesh/equal_vertices.hpp"
#include "mesh/input_arrays.hpp"
#include "mesh/join_vertices.hpp"
#include "mesh/mesh_arrays.hpp"

#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string_view>
#include <unordered_set>
#include <utility>

namespace clsdf {

namespace {

/// Throws if one of the triangle's indices is out of range, or its vertex not finite.
void throw_if_bad(std::size_t t, const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                  const std::string& name) {
    for (const std::uint32_t index : triangles[t]) {
        if (index >= vertices.size())
            throw Error(ErrorCode::invalid_mesh,
                        fmt::format("{}: triangle {} has the vertex index {}{}, but there are only {} vertices; "
                                    "triangles and indices count from 0",
                                    name, t, index,
                                    index >> 31 != 0 ? fmt::format(" (signed: {})", static_cast<std::int32_t>(index))
                                                     : std::string(),
                                    vertices.size()));
        const Vec3& vertex = vertices[index];
        if (!is_finite(vertex))
            throw Error(ErrorCode::invalid_mesh,
                        fmt::format("{}: vertex {}, used by triangle {}, is not finite: ({}, "
                                    "{}, {}); repair it, or leave the triangle out (both count from "
                                    "0)",
                                    name, index, t, vertex[0], vertex[1], vertex[2]));
    }
}

/// The properties of a sub-range of the triangles.
struct Examined {
    Box box = empty_box;
    std::size_t first_bad = std::numeric_limits<std::size_t>::max();  ///< triangle that throw_if_bad() throws for

    void take(const Examined& other) {
        first_bad = std::min(first_bad, other.first_bad);
        add(box, other.box);
    }
};

/// Adds triangles [begin, end). Their vertices are looked at without a branch, and one by one only if one is bad.
void examine(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, std::size_t begin,
             std::size_t end, Examined& examined) {
    Extent extent{examined.box};
    bool are_in_range = true;
    for (std::size_t t = begin; t != end; ++t)
        for (const std::uint32_t index : triangles[t]) {
            are_in_range &= index < vertices.size();
            extent.add(vertices[index < vertices.size() ? index : 0]);
        }
    examined.box = extent.box;
    if (are_in_range && extent.is_finite()) return;
    const auto is_bad = [&](std::uint32_t index) { return index >= vertices.size() || !is_finite(vertices[index]); };
    for (std::size_t t = begin; t != end; ++t)
        if (std::any_of(triangles[t].begin(), triangles[t].end(), is_bad)) {
            examined.first_bad = std::min(examined.first_bad, t);
            return;
        }
}

/// Throws if an index is out of range or a vertex in use is not finite, and returns the box of the vertices in use.
Box check(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles, const std::string& name) {
    if (triangles.empty()) throw Error(ErrorCode::invalid_mesh, fmt::format("{}: there is no triangle", name));
    // 0xFFFFFFFF is the index that means no triangle.
    constexpr std::size_t limit = std::numeric_limits<std::uint32_t>::max();
    if (triangles.size() >= limit || vertices.size() >= limit)
        refuse_unsupported(
            "{}: {} vertices and {} triangles are more than 32-bit indices "
            "can number",
            name, vertices.size(), triangles.size());
    if (vertices.empty()) throw_if_bad(0, vertices, triangles, name);
    constexpr std::size_t grain = 4096;
    const Examined all = reduce_ranges(
        triangles.size(), grain, Examined(),
        [&](std::size_t begin, std::size_t end, Examined examined) {
            examine(vertices, triangles, begin, end, examined);
            return examined;
        },
        [](Examined a, const Examined& b) {
            a.take(b);
            return a;
        });
    if (all.first_bad < triangles.size()) throw_if_bad(all.first_bad, vertices, triangles, name);
    return without_negative_zeros(all.box);
}

}  // namespace

MeshView::MeshView(const InputArray& vertices, const InputArray& triangles)
    : vertices_(vertices), triangles_(triangles) {
    check_array(vertices_, ArrayKind::positions, "vertices", ErrorCode::invalid_mesh);
    check_array(triangles_, ArrayKind::indices, "triangles", ErrorCode::invalid_mesh);
}

Mesh::Mesh(std::vector<Vec3> vertices, std::vector<Triangle> triangles, std::string name)
    : vertices_(std::move(vertices)),
      triangles_(std::move(triangles)),
      name_(std::move(name)),
      box_(check(vertices_, triangles_.get(), name_)) {}

Mesh::Mesh(const MeshView& view, std::string name)
    : Mesh(read_positions(view.vertices()), read_triangles(view.triangles(), name), std::string(name)) {}

void Mesh::set_positions(std::vector<Vec3> positions) {
    if (positions.size() != vertices_.size())
        refuse(
            "{} has {} vertices, and {} positions are given; give one "
            "for each",
            name_, vertices_.size(), positions.size());
    box_ = check(positions, triangles_.get(), name_);
    // Not moved: the C interface promises that the address of the vertices stays.
    std::ranges::copy(positions, vertices_.begin());
}

void Mesh::set_positions(const InputArray& positions) {
    check_array(positions, ArrayKind::positions, "positions", ErrorCode::invalid_argument);
    set_positions(read_positions(positions));
}

const FaceGroups& Mesh::groups() const {
    static const FaceGroups none;
    return groups_ ? *groups_ : none;
}

void Mesh::set_groups(FaceGroups groups) {
    if (groups.names.empty() && groups.numbers.empty()) {
        groups_.reset();
        return;
    }
    if (groups.numbers.size() != triangles().size())
        refuse("{} has {} triangles, and the groups have numbers for {}; give one for each", name_, triangles().size(),
               groups.numbers.size());
    const auto bad = std::ranges::find_if(groups.numbers, [&](std::uint32_t n) { return n >= groups.names.size(); });
    if (bad != groups.numbers.end())
        refuse("{}: triangle {} has the group {}, but there are only {} names; both count from 0", name_,
               bad - groups.numbers.begin(), *bad, groups.names.size());
    std::unordered_set<std::string_view> names;
    for (const std::string& name : groups.names)
        if (!names.insert(name).second)
            refuse("{}: two groups have the name '{}'; make them one, or give them different names", name_, name);
    groups_ = std::make_shared<const FaceGroups>(std::move(groups));
}

std::uint64_t Mesh::hash() const {
    WordHash hash;
    hash.add(vertices_.size());
    for (const Vec3& vertex : vertices_)
        for (const double coordinate : vertex) hash.add(std::bit_cast<std::uint64_t>(coordinate));
    for (const Triangle& triangle : triangles())
        for (const std::uint32_t index : triangle) hash.add(index);
    return hash.value();
}

namespace {

/// Triangles keep their groups.
Mesh merged_with_groups(const Mesh& mesh, const std::vector<std::uint32_t>& first) {
    Mesh result = merged(mesh, first);
    result.set_groups(mesh.groups());
    return result;
}

}  // namespace

Mesh weld(const Mesh& mesh) {
    return merged_with_groups(mesh, first_equal_vertices(mesh.vertices()));
}

Mesh weld(const Mesh& mesh, double tolerance) {
    if (!(tolerance >= 0) || !std::isfinite(tolerance))
        refuse("vertices are to be joined within {}; give a length of 0 or more, in the mesh's units", tolerance);
    std::vector<std::uint32_t> first = first_equal_vertices(mesh.vertices());
    std::vector<bool> is_used(first.size());
    for (const Triangle& triangle : mesh.triangles())
        for (const std::uint32_t index : triangle) is_used[first[index]] = true;
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t vertex = 0; vertex < first.size(); ++vertex)
        if (is_used[vertex]) candidates.push_back(vertex);
    std::vector<std::uint32_t> least(first.size());
    std::iota(least.begin(), least.end(), std::uint32_t{0});
    for (const auto& [vertex, other] : join_vertices(mesh.vertices(), std::move(candidates), tolerance))
        least[vertex] = other;
    const auto has_face = [&] {
        return std::ranges::any_of(mesh.triangles(), [&](const Triangle& t) {
            return first[t[0]] != first[t[1]] && first[t[1]] != first[t[2]] && first[t[2]] != first[t[0]];
        });
    };
    const bool had_face = has_face();
    for (std::uint32_t& index : first) index = least[index];
    if (had_face && !has_face())
        refuse(
            "vertices are to be joined within {}, but then no face of the mesh, whose longest side "
            "is {}, keeps three vertices; give a length below that of the edges",
            tolerance, mesh.box().longest_side());
    return merged_with_groups(mesh, first);
}

}  // namespace clsdf
