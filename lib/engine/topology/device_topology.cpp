#include "topology/device_topology.hpp"

#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "launch/commands.hpp"
#include "launch/programs.hpp"
#include "launch/radix_sort.hpp"
#include "launch/short_launches.hpp"
#include "mesh/input_arrays.hpp"
#include "surface/topology.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

namespace clsdf::engine {

namespace {

static_assert(volume_leaf == CLSDF_VOLUME_LEAF);
static_assert(sizeof(FaceEdges) == 16 && offsetof(FaceEdges, marks) == 12);

/// Words that begin as zeros: one array, one fill.
class Zeros {
public:
    /// Where so many words begin.
    cl_uint add(std::size_t words) { return static_cast<cl_uint>(std::exchange(count_, count_ + words)); }
    std::size_t bytes() const { return count_ * sizeof(cl_uint); }

private:
    std::size_t count_ = 0;
};

/// A copy of many values on the device, which are not needed any more when it returns.
template <class Values>
device::BufferPool::Lease sent(const DeviceSetUp& set_up, const Values& values, const char* purpose) {
    const std::size_t bytes = values.size() * sizeof(values[0]);
    device::BufferPool::Lease copy = set_up.tools.pool->lease(std::max<std::size_t>(bytes, 1), purpose);
    if (set_up.tools.context.write(set_up.tools.queue(), reinterpret_cast<const std::byte*>(values.data()), bytes,
                                   *copy))
        return copy;
    return set_up.upload(values, purpose);
}

Box box_of(const TopologyResults& results) {
    Box box;
    std::copy(results.box, results.box + 3, box.lower.begin());
    std::copy(results.box + 3, results.box + 6, box.upper.begin());
    return box;
}

class Making {
public:
    Making(const DeviceSetUp& set_up, const Mesh& mesh)
        : Making(set_up.tools, mesh.vertices().size(), mesh.triangles().size()) {
        positions_ = sent(set_up, mesh.vertices(), "vertices");
        triangles_ = sent(set_up, mesh.triangles(), "triangles");
    }
    Making(const DeviceSetUp& set_up, const DeviceTriples& vertices, const DeviceTriples& triangles)
        : Making(set_up.tools, vertices.count, triangles.count) {
        positions_ = lease<Vec3>(vertices_, "vertices");
        triangles_ = lease<Triangle>(faces_, "triangles");
        is_copied_ = true;
        run("copy_mesh", std::max(vertices_, faces_), vertices.steps, vertices.memory, triangles.steps,
            triangles.memory, *positions_, *triangles_, *zeros_);
    }

    std::optional<MadeTopology> make() {
        find_equal_vertices();
        order_faces();
        number_vertices();
        order_corners();
        pair_edges();
        sum_volumes();
        made_.results = device::read_value<TopologyResults>(tools_.context, *zeros_);
        if (made_.results.is_refused != 0) return std::nullopt;
        made_.given_vertices = vertices_;
        if (is_copied_)
            made_.mesh = std::make_shared<const DeviceMesh>(
                DeviceMesh{std::move(positions_), std::move(triangles_), vertices_, faces_});
        if (made_.results.used_vertices != made_.results.different_vertices)
            topology_.equal = std::make_shared<const EqualVertices>(EqualVertices{std::move(first_equal_), vertices_});
        topology_.are_paired = made_.results.marked_edges == 0;
        topology_.has_irregular = made_.results.irregular_faces > 0;
        topology_.names = std::make_shared<const NamedFaces>(
            NamedFaces{faces_, made_.results.vertex_count, nullptr, std::move(ordered_), std::move(names_)});
        made_.topology = std::make_shared<const DeviceTopology>(std::move(topology_));
        return std::move(made_);
    }

private:
    Making(const DeviceTools& tools, std::size_t vertices, std::size_t faces)
        : tools_(tools), vertices_(vertices), faces_(faces), program_(tools.programs.mesh_topology) {
        sizes_.vertices = static_cast<cl_uint>(vertices_);
        sizes_.faces = static_cast<cl_uint>(faces_);
        sizes_.slots = static_cast<cl_uint>(std::bit_ceil(2 * vertices_));
        sizes_.cells = 1U << morton_bits(faces_);
        Zeros zeros;
        zeros.add(sizeof(TopologyResults) / sizeof(cl_uint));
        sizes_.table = zeros.add(sizes_.slots);
        sizes_.used = zeros.add(chunk_count(vertices_, 32));
        sizes_.classes = zeros.add(chunk_count(vertices_, 32));
        sizes_.first_corners = zeros.add(vertices_);
        sizes_.above = zeros.add(vertices_);
        zeros_ = tools_.pool->lease(zeros.bytes(), "tables of vertices");
        tools_.queue().enqueueFillBuffer(*zeros_, cl_uint{0}, 0, zeros.bytes());
    }

    std::size_t corners() const { return 3 * faces_; }

    template <class Value>
    device::BufferPool::Lease lease(std::size_t count, const char* purpose) const {
        return tools_.pool->lease(std::max<std::size_t>(count, 1) * sizeof(Value), purpose);
    }

    template <class... Arguments>
    void run(const char* name, std::size_t items, const Arguments&... arguments) const {
        device::LentKernel kernel = tools_.kernel(program_, name);
        launch(tools_.queue(), kernel, {items, tools_.programs.group_size}, sizes_, arguments...);
    }
    template <class... Arguments>
    void run_group(const char* name, const Arguments&... arguments) const {
        device::LentKernel kernel = tools_.kernel(program_, name);
        launch(tools_.queue(), kernel, {1, tools_.programs.group_size}, arguments...);
    }

    /// The box, the vertices in use and those of equal coordinates.
    void find_equal_vertices() {
        const std::size_t group = tools_.programs.group_size,
                          groups = std::min<std::size_t>(chunk_count(faces_, group), CLSDF_BOX_GROUPS);
        const auto boxes = lease<double>(6 * groups, "boxes of faces");
        const auto slots = lease<cl_uint>(vertices_, "slots of vertices");
        first_equal_ = lease<cl_uint>(vertices_, "equal vertices");
        run("file_vertices", vertices_, *positions_, *zeros_, *slots, *zeros_);
        run("look_at_faces", groups * group, *positions_, *triangles_, *zeros_, *boxes, *zeros_);
        run_group("join_group_boxes", static_cast<cl_uint>(groups), *boxes, *zeros_);
        run("count_vertices", vertices_, *zeros_, *slots, *first_equal_, *zeros_);
    }

    void order_faces() {
        const auto codes = lease<cl_uint>(faces_, "codes of faces");
        topology_.order = lease<cl_uint>(faces_, "order of the faces");
        run("face_codes", faces_, *positions_, *triangles_, *zeros_, *codes);
        sort_by_keys(tools_, *codes, faces_, 3 * morton_bits(faces_), *topology_.order);
        named_ = lease<cl_uint>(corners(), "vertices of faces");
        run("order_faces", faces_, *topology_.order, *triangles_, *first_equal_, *zeros_, *named_, *zeros_);
    }

    void number_vertices() {
        const std::size_t tiles = chunk_count(corners(), CLSDF_CORNER_TILE), group = tools_.programs.group_size;
        const auto counts = lease<cl_uint>(tiles, "counts of vertices");
        const auto numbers = lease<cl_uint>(vertices_, "numbers of vertices");
        topology_.vertices = lease<cl_uint>(vertices_, "vertices of faces");
        made_.positions = lease<Vec3>(vertices_, "vertices");
        ordered_ = lease<Triangle>(faces_, "triangles");
        keys_ = lease<cl_uint>(corners(), "vertices of corners");
        run("count_first_corners", tiles * group, *named_, *zeros_, *counts);
        run("number_vertices", tiles * group, *named_, *zeros_, *counts, *positions_, *numbers, *topology_.vertices,
            *made_.positions, *zeros_);
        run("name_corners", corners(), *named_, *numbers, *ordered_, *keys_);
    }

    void order_corners() {
        const auto sorted = lease<cl_uint>(corners(), "order of corners");
        topology_.starts = lease<cl_uint>(vertices_ + 1, "corners at vertices");
        topology_.corners = lease<cl_uint>(corners(), "corners at vertices");
        sort_by_keys(tools_, *keys_, corners(), static_cast<unsigned>(std::bit_width(vertices_ - 1)), *sorted);
        run("order_corners", corners(), *sorted, *named_, *zeros_, *ordered_, *zeros_, *topology_.starts,
            *topology_.corners);
    }

    void pair_edges() {
        topology_.edges = lease<FaceEdges>(faces_, "edges of faces");
        topology_.opposite = lease<Triangle>(faces_, "opposite vertices");
        names_ = lease<cl_uint>(faces_, "numbers of the triangles");
        run("pair_edges", corners(), *ordered_, *topology_.starts, *topology_.corners, *topology_.edges,
            *topology_.edges, *topology_.opposite, *zeros_);
        run("join_faces", faces_, *topology_.order, *ordered_, *topology_.edges, *zeros_, *names_, *zeros_);
    }

    void sum_volumes() const {
        cl_uint levels = 0;
        for (std::size_t most = faces_; most > volume_leaf; most = (most + 1) / 2) ++levels;
        const auto sums = lease<double>(std::size_t{2} << levels, "volumes");
        run("sum_volumes", std::size_t{1} << levels, levels, *positions_, *triangles_, *zeros_, *sums);
        run_group("join_volumes", levels, *sums, *zeros_);
    }

    const DeviceTools& tools_;
    std::size_t vertices_, faces_;
    cl::Program program_;
    TopologySizes sizes_{};
    DeviceTopology topology_;
    MadeTopology made_;
    device::BufferPool::Lease positions_, triangles_;  // as given
    bool is_copied_ = false;                           // these are copies of memory of the device
    device::BufferPool::Lease zeros_;                  // the results, and what sizes_ has places of
    device::BufferPool::Lease first_equal_, named_, keys_, ordered_, names_;
};

}  // namespace

NamedFaces device_names(const DeviceSetUp& set_up, std::shared_ptr<const MeshTopology> topology) {
    const std::size_t count = topology->order.size();
    set_up.tools.pool->check_size(count * sizeof(Triangle), "triangles");
    device::HostFilling filling(set_up.tools.context, set_up.tools.pool, count * sizeof(cl_uint),
                                "numbers of the triangles");
    auto* const names = static_cast<cl_uint*>(filling.memory());
    for_each_index(count, [&](std::size_t face) {
        names[face] = topology->order[face] | (topology->edges.is_non_manifold(face) ? CLSDF_NAME_NON_MANIFOLD : 0U);
    });
    auto triangles = set_up.input(topology, topology->faces.triangles, "triangles");
    const std::size_t vertex_count = topology->faces.vertices.size();
    return {count, vertex_count, std::move(topology), std::move(triangles), filling.finish()};
}

DeviceTriples device_triples(const InputArray& array) {
    constexpr auto word = static_cast<std::ptrdiff_t>(sizeof(cl_uint));
    const Steps steps = steps_of(array);
    return {cl::Buffer(array.device, true),
            array.count,
            {array.offset / sizeof(cl_uint), steps.triple / word, steps.number / word, steps.width == 8, 0}};
}

MeshArrays DeviceMesh::read(const DeviceSetUp& set_up) const {
    MeshArrays arrays{std::vector<Vec3>(vertex_count), std::vector<Triangle>(face_count)};
    set_up.tools.context.run_or_drain([&] {
        device::read_values(set_up.tools.context, *vertices, arrays.vertices);
        device::read_values(set_up.tools.context, *triangles, arrays.triangles);
    });
    return arrays;
}

bool MadeTopology::encloses_negative_volume() const {
    return is_negative_volume(results.volume[0], results.volume[1], topology->face_count());
}

Box MadeTopology::box() const {
    return box_of(results);
}

std::vector<std::uint32_t> EqualVertices::read(const DeviceSetUp& set_up) const {
    std::vector<std::uint32_t> numbers(count);
    set_up.tools.context.run_or_drain([&] { device::read_values(set_up.tools.context, *first, numbers); });
    for (std::uint32_t& number : numbers) number &= ~CLSDF_IN_USE;
    return numbers;
}

MeshTopology DeviceTopology::read(const DeviceSetUp& set_up, std::span<const std::uint32_t> numbers) const {
    UninitializedVector<std::uint32_t> of_faces(face_count()), of_corners(3 * face_count());
    UninitializedVector<std::uint32_t> of_vertices(vertex_count() + 1);
    OrderedFaces faces;
    faces.triangles = UninitializedVector<Triangle>(face_count());
    faces.vertices = UninitializedVector<std::uint32_t>(vertex_count());
    PairedEdges pairs;
    pairs.faces = UninitializedVector<FaceEdges>(face_count());
    set_up.tools.context.run_or_drain([&] {
        device::read_values(set_up.tools.context, *order, of_faces);
        device::read_values(set_up.tools.context, *names->triangles, faces.triangles);
        device::read_values(set_up.tools.context, *vertices, faces.vertices);
        device::read_values(set_up.tools.context, *starts, of_vertices);
        device::read_values(set_up.tools.context, *corners, of_corners);
        device::read_values(set_up.tools.context, *edges, pairs.faces);
    });
    if (!numbers.empty())
        for (std::uint32_t& vertex : faces.vertices) vertex = numbers[vertex];
    pairs.are_paired = are_paired;
    if (has_irregular) {
        std::vector<std::uint32_t>& ends = pairs.non_manifold_ends;
        for (std::uint32_t face = 0; face < face_count(); ++face)
            for (std::uint32_t k = 0; k < 3; ++k)
                if (has_mark(pairs.faces, {face, k}, edge_non_manifold))
                    ends.push_back(std::min(faces.triangles[face][k], faces.triangles[face][next_of_three(k)]));
        std::ranges::sort(ends);
        const auto repeated = std::ranges::unique(ends);
        ends.erase(repeated.begin(), repeated.end());
    }
    return {std::move(of_faces), std::move(faces), OneRings(std::move(of_vertices), std::move(of_corners)),
            std::move(pairs)};
}

std::size_t DeviceTopology::device_bytes() const {
    return order.bytes() + vertices.bytes() + starts.bytes() + corners.bytes() + edges.bytes() + opposite.bytes() +
           (equal ? equal->device_bytes() : 0);
}

std::optional<MadeTopology> make_device_topology(const DeviceSetUp& set_up, const Mesh& mesh) {
    return device::guarded([&] { return Making(set_up, mesh).make(); });
}

std::optional<MadeTopology> make_device_topology(const DeviceSetUp& set_up, const DeviceTriples& vertices,
                                                 const DeviceTriples& triangles) {
    return device::guarded([&] { return Making(set_up, vertices, triangles).make(); });
}

MovedVertices move_vertices(const DeviceSetUp& set_up, const DeviceTopology& topology, const DeviceTriples& positions) {
    const DeviceTools& tools = set_up.tools;
    const EqualVertices* const equal = topology.equal.get();
    const std::size_t count = topology.vertex_count(), group = tools.programs.group_size,
                      groups = std::min<std::size_t>(chunk_count(count, group), CLSDF_BOX_GROUPS);
    return device::guarded([&] {
        MovedVertices moved{tools.pool->lease(count * sizeof(Vec3), "vertices"), {}};
        const auto boxes = tools.pool->lease(groups * 6 * sizeof(double), "boxes of vertices");
        const auto results = tools.pool->lease(sizeof(TopologyResults), "box of the mesh");
        tools.queue().enqueueFillBuffer(*results, cl_uint{0}, 0, sizeof(TopologyResults));
        if (equal != nullptr) {
            device::LentKernel compare = tools.kernel(tools.programs.mesh_topology, "compare_equal_vertices");
            launch(tools.queue(), compare, {equal->count, group}, static_cast<cl_uint>(equal->count), *equal->first,
                   positions.steps, positions.memory, *results);
        }
        device::LentKernel move = tools.kernel(tools.programs.mesh_topology, "move_vertices"),
                           join = tools.kernel(tools.programs.mesh_topology, "join_group_boxes");
        launch(tools.queue(), move, {groups * group, group}, static_cast<cl_uint>(count), *topology.vertices,
               positions.steps, positions.memory, *moved.positions, *boxes, *results);
        launch(tools.queue(), join, {1, group}, static_cast<cl_uint>(groups), *boxes, *results);
        const auto found = device::read_value<TopologyResults>(tools.context, *results);
        moved.are_usable = found.is_refused == 0;
        moved.box = box_of(found);
        return moved;
    });
}

MovedVertices move_vertices(const DeviceSetUp& set_up, const DeviceTopology& topology,
                            std::span<const Vec3> positions) {
    const device::BufferPool::Lease given = sent(set_up, positions, "vertices");
    constexpr cl_long words = 2;
    return move_vertices(set_up, topology, {*given, positions.size(), {0, 3 * words, words, 1, 0}});
}

DeviceTopology device_topology(const DeviceSetUp& set_up, std::shared_ptr<const NamedFaces> names,
                               const MeshTopology& topology) {
    DeviceTopology result;
    result.names = std::move(names);
    result.order = set_up.upload(topology.order, "order of the faces");
    result.vertices = set_up.upload(topology.faces.vertices, "vertices of faces");
    result.starts = set_up.upload(topology.rings.starts(), "corners at vertices");
    result.corners = set_up.upload(topology.rings.corners(), "corners at vertices");
    result.edges = set_up.upload(topology.edges.faces, "edges of faces");
    result.opposite = set_up.upload(opposite_words(topology), "opposite vertices");
    result.are_paired = topology.edges.are_paired;
    return result;
}

}  // namespace clsdf::engine
