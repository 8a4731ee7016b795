#include "checks/known_topology.hpp"

#include "device/buffer_pool.hpp"
#include "device/read_back.hpp"
#include "frusta/cluster_index.hpp"
#include "frusta/kernel_topology.hpp"
#include "lattice/layout_of.hpp"
#include "launch/device_tools.hpp"
#include "mesh/equal_vertices.hpp"
#include "mesh/vertices.hpp"
#include "sign/sweep_mesh.hpp"
#include "surface/parts.hpp"
#include "surface/topology.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace clsdf::checks {

namespace {

using Numbers = std::vector<std::uint32_t>;

/// The first `count` values of a buffer.
template <class Value>
std::vector<Value> read(const engine::DeviceSetUp& set_up, const cl::Buffer& buffer, std::size_t count) {
    std::vector<Value> values(count);
    device::read_values(set_up.tools.context, buffer, values);
    return values;
}

/// Collects the first difference.
class Comparison {
public:
    template <class Values, class Expected>
    void compare(const char* what, const Values& values, const Expected& expected) {
        if (difference_) return;
        const std::size_t count = std::min(values.size(), expected.size());
        for (std::size_t i = 0; i < count; ++i)
            if (values[i] != expected[i]) {
                difference_ = fmt::format("number {} of the {} is wrong", i, what);
                return;
            }
        compare_count(what, values.size(), expected.size());
    }
    void compare_count(const char* what, std::size_t value, std::size_t expected) {
        if (!difference_ && value != expected)
            difference_ = fmt::format("there are {} {}, in place of {}", value, what, expected);
    }

    const std::optional<std::string>& difference() const { return difference_; }

private:
    std::optional<std::string> difference_;
};

/// Across the edges of all faces, and their marks.
std::array<Numbers, 2> words_of(std::span<const engine::FaceEdges> faces) {
    std::array<Numbers, 2> words;
    for (const engine::FaceEdges& edges : faces) {
        words[0].insert(words[0].end(), edges.across.begin(), edges.across.end());
        words[1].insert(words[1].end(), edges.marks.begin(), edges.marks.end());
    }
    return words;
}

std::vector<double> sides_of(const std::vector<Box>& boxes) {
    std::vector<double> sides;
    for (const Box& box : boxes)
        for (const Vec3& corner : {box.lower, box.upper}) sides.insert(sides.end(), corner.begin(), corner.end());
    return sides;
}

Numbers names_of(const engine::MeshTopology& topology) {
    Numbers names(topology.order.begin(), topology.order.end());
    for (std::size_t face = 0; face < names.size(); ++face)
        if (topology.edges.is_non_manifold(face)) names[face] |= CLSDF_NAME_NON_MANIFOLD;
    return names;
}

void compare_parts(const engine::MeshTopology& topology, const engine::MeshTopology& expected, Comparison& comparison) {
    comparison.compare("faces in their order", topology.order, expected.order);
    comparison.compare("triangles", topology.faces.triangles, expected.faces.triangles);
    comparison.compare("vertices", topology.faces.vertices, expected.faces.vertices);
    comparison.compare("places of rings", topology.rings.starts(), expected.rings.starts());
    comparison.compare("corners of rings", topology.rings.corners(), expected.rings.corners());
    const auto [across, marks] = words_of(topology.edges.faces);
    const auto [expected_across, expected_marks] = words_of(expected.edges.faces);
    comparison.compare("faces across edges", across, expected_across);
    comparison.compare("marks of edges", marks, expected_marks);
    comparison.compare("ends of edges of three faces", topology.edges.non_manifold_ends,
                       expected.edges.non_manifold_ends);
    comparison.compare_count("meshes of paired edges", topology.edges.are_paired, expected.edges.are_paired);
}

/// A torus of quadrilaterals, without the first one.
void add_torus(std::uint32_t around, std::uint32_t across, const Vec3& centre, std::vector<Vec3>& vertices,
               std::vector<Triangle>& triangles) {
    const auto first = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
            const double radius = 3 + std::cos(v);
            vertices.push_back(
                {centre[0] + radius * std::cos(u), centre[1] + radius * std::sin(u), centre[2] + std::sin(v)});
        }
    const auto number = [&](std::uint32_t i, std::uint32_t j) { return first + i % around * across + j % across; };
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = i == 0 ? 1 : 0; j < across; ++j) {
            triangles.push_back({number(i, j), number(i + 1, j), number(i + 1, j + 1)});
            triangles.push_back({number(i, j), number(i + 1, j + 1), number(i, j + 1)});
        }
}

}  // namespace

Mesh mesh_of_known_topology() {
    std::vector<Vec3> vertices{{-0.0, 0, 0}};  // equals another one, and has no use
    std::vector<Triangle> triangles;
    add_torus(36, 20, {0, 0, 0}, vertices, triangles);
    add_torus(12, 9, {1, 7, -2}, vertices, triangles);
    // Every fifth face has vertices of its own.
    for (std::size_t face = 0; face < triangles.size(); face += 5)
        for (std::uint32_t& vertex : triangles[face]) {
            vertices.push_back(vertices[vertex]);
            vertex = static_cast<std::uint32_t>(vertices.size() - 1);
        }
    const Triangle first = triangles[0], second = triangles[100], third = triangles[200];
    const auto tip = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), {{0, 0, 0}, {0, 0, -0.0}, {5, 0.5, 0.5}});
    triangles.insert(triangles.end(), {{first[0], first[1], tip},        // a third face at an edge
                                       {second[1], second[0], tip + 1},  // and one that runs along it the same way
                                       {third[0], third[0], third[1]},
                                       {tip, tip + 1, tip},
                                       {tip, tip + 2, third[2]},
                                       {tip + 2, tip, third[0]},
                                       {tip, tip + 2, third[1]}});
    for (Vec3& vertex : vertices)
        for (double& x : vertex) x = static_cast<double>(static_cast<float>(x));
    std::swap(triangles[50][1], triangles[50][2]);  // all of its edges: two faces that run the same way
    return {std::move(vertices), std::move(triangles), "known topology"};
}

namespace {

/// From a mesh's arrays in memory of the device, with a number between two positions.
template <class Real, class Index>
std::optional<engine::MadeTopology> made_of_device_arrays(const engine::DeviceSetUp& set_up, const Mesh& mesh) {
    std::vector<Real> numbers;
    for (const Vec3& vertex : mesh.vertices()) {
        for (const double x : vertex) numbers.push_back(static_cast<Real>(x));
        numbers.push_back(0);
    }
    std::vector<Index> indices;
    for (const Triangle& triangle : mesh.triangles()) indices.insert(indices.end(), triangle.begin(), triangle.end());
    const auto positions = set_up.upload(numbers, "vertices"), triangles = set_up.upload(indices, "triangles");
    constexpr cl_long of_real = sizeof(Real) / sizeof(cl_uint), of_index = sizeof(Index) / sizeof(cl_uint);
    return engine::make_device_topology(
        set_up, {*positions, mesh.vertices().size(), {0, 4 * of_real, of_real, of_real - 1, 0}},
        {*triangles, mesh.triangles().size(), {0, 3 * of_index, of_index, of_index - 1, 0}});
}

bool has_floats(const Mesh& mesh) {
    return std::ranges::all_of(mesh.vertices(), [](const Vec3& vertex) {
        return std::ranges::all_of(
            vertex, [](double x) { return std::isnan(x) || static_cast<double>(static_cast<float>(x)) == x; });
    });
}

std::optional<std::string> difference_of(const engine::DeviceSetUp& set_up, const Mesh& given,
                                         const std::optional<engine::MadeTopology>& made) {
    if (!made) return "the mesh is refused";
    Comparison comparison;
    const Numbers first = first_equal_vertices(given.vertices());
    const Topology counts = describe_vertices(given, first);
    comparison.compare_count("unused vertices", given.vertices().size() - made->results.used_vertices,
                             counts.unused_vertices);
    comparison.compare_count("vertices that equal others",
                             made->results.used_vertices - made->results.different_vertices,
                             counts.coincident_vertices);
    if (comparison.difference()) return comparison.difference();
    const engine::EqualVertices* const equal = made->topology->equal.get();
    if (equal != nullptr) comparison.compare("equal vertices", equal->read(set_up), first);
    const Mesh mesh = equal != nullptr ? merged(given, first) : given;
    const Numbers numbers = equal != nullptr ? engine::Vertices::numbers(first) : Numbers();
    const engine::MeshTopology expected(mesh);
    const engine::DeviceTopology& topology = *made->topology;
    comparison.compare_count("vertices in use", topology.vertex_count(), expected.faces.vertices.size());
    if (comparison.difference()) return comparison.difference();
    compare_parts(topology.read(set_up, numbers), expected, comparison);
    comparison.compare("opposite vertices", read<std::uint32_t>(set_up, *topology.opposite, 3 * topology.face_count()),
                       engine::opposite_words(expected));
    comparison.compare("names", read<std::uint32_t>(set_up, *topology.names->names, topology.face_count()),
                       names_of(expected));
    comparison.compare("positions", read<Vec3>(set_up, *made->positions, topology.vertex_count()),
                       engine::ordered_positions(expected, mesh.vertices()));
    const engine::DeviceFaces faces{
        topology.names, std::make_shared<const device::BufferPool::Lease>(nullptr, *made->positions, 0), {}};
    comparison.compare("sides of clusters' boxes", sides_of(engine::cluster_boxes(set_up, faces)),
                       sides_of(engine::cluster_boxes(expected.faces.triangles,
                                                      engine::ordered_positions(expected, mesh.vertices()))));
    comparison.compare_count("meshes in one part", made->is_one_part(),
                             is_one_part(expected.faces.triangles, mesh.vertices().size()));
    comparison.compare_count("meshes inside out", made->encloses_negative_volume(), encloses_negative_volume(mesh));
    const Box& box = mesh.box();
    comparison.compare("sides of the box", std::span(made->results.box),
                       std::array{box.lower[0], box.lower[1], box.lower[2], box.upper[0], box.upper[1], box.upper[2]});
    const engine::MovedVertices moved = engine::move_vertices(set_up, topology, given.vertices());
    comparison.compare("positions that are set", read<Vec3>(set_up, *moved.positions, topology.vertex_count()),
                       engine::ordered_positions(expected, mesh.vertices()));
    comparison.compare("sides of their box", sides_of({moved.box}), sides_of({box}));
    return comparison.difference();
}

/// The same mesh without vertices that no triangle uses.
Mesh without_unused_vertices(const Mesh& mesh) {
    std::vector<std::uint32_t> numbers(mesh.vertices().size(), 0xFFFFFFFFU);
    std::vector<Vec3> vertices;
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& triangle : triangles)
        for (std::uint32_t& vertex : triangle) {
            std::uint32_t& number = numbers[vertex];
            if (number == 0xFFFFFFFFU) {
                number = static_cast<std::uint32_t>(vertices.size());
                vertices.push_back(mesh.vertices()[vertex]);
            }
            vertex = number;
        }
    return {std::move(vertices), std::move(triangles), mesh.name()};
}

/// Of equal vertices that move together, and apart: these the host looks at.
std::optional<std::string> move_difference(const engine::DeviceSetUp& set_up, const Mesh& mesh) {
    const Mesh used = without_unused_vertices(mesh);
    const auto made = engine::make_device_topology(set_up, used);
    if (!made || !made->topology->equal) return std::nullopt;
    const auto is_taken = [&](const std::vector<Vec3>& positions) {
        return engine::move_vertices(set_up, *made->topology, positions).are_usable;
    };
    Comparison comparison;
    comparison.compare_count("equal vertices that move together and are taken", is_taken(used.vertices()), 1);
    const Numbers first = first_equal_vertices(used.vertices());
    std::vector<Vec3> apart = used.vertices();
    for (std::size_t vertex = apart.size(); vertex-- > 0;)
        if (first[vertex] != vertex) {
            double& z = apart[vertex][2];
            z = z == 0 ? 1 : 2 * z;
            break;
        }
    comparison.compare_count("equal vertices that move apart and are taken", is_taken(apart), 0);
    return comparison.difference();
}

}  // namespace

std::optional<std::string> topology_difference(const engine::DeviceSetUp& set_up, const Mesh& mesh) {
    if (auto difference = difference_of(set_up, mesh, engine::make_device_topology(set_up, mesh))) return difference;
    if (auto difference = move_difference(set_up, mesh)) return difference;
    auto difference = difference_of(set_up, mesh, made_of_device_arrays<double, std::uint32_t>(set_up, mesh));
    if (!difference && has_floats(mesh))
        difference = difference_of(set_up, mesh, made_of_device_arrays<float, std::uint64_t>(set_up, mesh));
    if (difference) *difference += ", from memory of the device";
    return difference;
}

std::optional<std::string> sweep_difference(const engine::DeviceSetUp& set_up) {
    const Mesh mesh = mesh_of_known_topology();
    const engine::MeshTopology topology(mesh);
    const engine::DeviceFaces faces{std::make_shared<const engine::NamedFaces>(
                                        engine::NamedFaces{topology.order.size(),
                                                           topology.faces.vertices.size(),
                                                           nullptr,
                                                           set_up.upload(topology.faces.triangles, "triangles"),
                                                           {}}),
                                    std::make_shared<const device::BufferPool::Lease>(set_up.upload(
                                        engine::ordered_positions(topology, mesh.vertices()), "vertices")),
                                    {}};
    constexpr std::size_t cluster = engine::ClusterIndex::cluster;
    const std::size_t last = (mesh.triangles().size() - 1) / cluster * cluster;
    const engine::NearRecords near{
        {{cluster, 3 * cluster}, {last, mesh.triangles().size()}}, {}, 2 * cluster + mesh.triangles().size() - last, 0};
    const Grid grid = Grid::around(mesh, 50, Band::symmetric(1));
    const engine::LatticeView view = engine::lattice_of(grid);
    const engine::SweepMesh made = engine::near_sweep_mesh(set_up, grid, view, mesh.box(), faces, near);
    const engine::SweepMesh expected =
        engine::near_sweep_mesh(set_up.tools, grid, view, mesh, {}, nullptr, topology, near.faces);
    const std::size_t corners = 3 * near.face_count;
    Comparison comparison;
    const auto words_of_vertices = [&](const engine::SweepMesh& sweep) {
        constexpr std::size_t words = sizeof(SweepVertex) / sizeof(std::uint64_t);
        return read<std::uint64_t>(set_up, *sweep.vertices, words * corners);
    };
    comparison.compare("words of the sweep's vertices", words_of_vertices(made), words_of_vertices(expected));
    comparison.compare("corners of the sweep's triangles", read<std::uint32_t>(set_up, made.triangles(), corners),
                       read<std::uint32_t>(set_up, expected.triangles(), corners));
    return comparison.difference();
}

}  // namespace clsdf::checks
