#include "frusta/host_part.hpp"

#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "host_lists.h"
#include "launch/commands.hpp"
#include "launch/programs.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <utility>

namespace clsdf::engine {

namespace {

/// Ascending numbers below a limit, with their places.
class NumberSet {
public:
    explicit NumberSet(std::size_t limit) : bits_(chunk_count(limit, 64)), before_(bits_.size()) {}

    void add(std::uint32_t number) { bits_[number / 64] |= std::uint64_t{1} << number % 64; }
    /// All of them; then their places are known.
    std::vector<std::uint32_t> numbers() {
        std::vector<std::uint32_t> all;
        for (std::size_t word = 0; word < bits_.size(); ++word) {
            before_[word] = static_cast<std::uint32_t>(all.size());
            for (std::uint64_t left = bits_[word]; left != 0; left &= left - 1)
                all.push_back(static_cast<std::uint32_t>(64 * word) +
                              static_cast<std::uint32_t>(std::countr_zero(left)));
        }
        return all;
    }
    std::uint32_t place(std::uint32_t number) const {
        const std::uint64_t lower = bits_[number / 64] & ((std::uint64_t{1} << number % 64) - 1);
        return before_[number / 64] + static_cast<std::uint32_t>(std::popcount(lower));
    }

private:
    std::vector<std::uint64_t> bits_;
    std::vector<std::uint32_t> before_;
};

/// Of faces in any order, of a mesh with so many faces and vertices.
HostPart part_of(std::span<const ListedFace> listed, std::size_t face_count, std::size_t vertex_count) {
    NumberSet face_set(face_count), vertex_set(vertex_count);
    for (const ListedFace& face : listed) {
        face_set.add(face.number);
        for (const std::uint32_t vertex : face.vertices) vertex_set.add(vertex);
    }
    std::vector<std::uint32_t> face_numbers = face_set.numbers(), vertex_numbers = vertex_set.numbers();
    UninitializedVector<std::uint32_t> order(face_numbers.size());
    OrderedFaces faces;
    faces.triangles = UninitializedVector<Triangle>(face_numbers.size());
    faces.vertices = UninitializedVector<std::uint32_t>(vertex_numbers.size());
    Frusta frusta;
    frusta.positions = UninitializedVector<Vec3>(vertex_numbers.size());
    frusta.slopes = UninitializedVector<FaceSlopes>(face_numbers.size());
    LeftToHost left;
    std::vector<cl_uint> left_bits(vertex_numbers.size());  // of each vertex
    for (const ListedFace& from : listed) {
        const std::uint32_t face = face_set.place(from.number);
        order[face] = from.triangle;
        if ((from.left & CLSDF_LEFT_FACE) != 0) left.faces.push_back(face);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t vertex = vertex_set.place(from.vertices[k]);
            faces.triangles[face][k] = vertex;
            faces.vertices[vertex] = from.given[k];
            left_bits[vertex] |= from.left >> k & (CLSDF_LEFT_VERTEX | CLSDF_LEFT_GAP);
            std::ranges::copy(from.corners[k], frusta.positions[vertex].begin());
        }
    }
    std::ranges::sort(left.faces);
    for (std::uint32_t vertex = 0; vertex < left_bits.size(); ++vertex) {
        if ((left_bits[vertex] & CLSDF_LEFT_VERTEX) != 0) left.vertices.push_back(vertex);
        if ((left_bits[vertex] & CLSDF_LEFT_GAP) != 0) left.gaps.push_back(vertex);
    }
    OneRings rings(faces.triangles, vertex_numbers.size());
    PairedEdges edges = pair_edges(faces.triangles, rings);
    return {{std::move(order), std::move(faces), std::move(rings), std::move(edges)},
            std::move(face_numbers),
            std::move(vertex_numbers),
            std::move(left),
            std::move(frusta)};
}

}  // namespace

std::optional<HostPart> host_part(const DeviceSetUp& set_up, const DeviceTopology& topology,
                                  const DeviceAnswers& answers) {
    // Of a larger share of the mesh the host looks at all of it hardly longer.
    constexpr std::size_t few = 4096, most_groups_of_list = 1024;
    const DeviceTools& tools = set_up.tools;
    const std::size_t faces = topology.face_count(), vertices = topology.vertex_count(),
                      group = tools.programs.group_size, room = std::min(faces, faces / 4 + few);
    std::size_t words = sizeof(ListCounts) / sizeof(cl_uint);
    const auto bits = [&](std::size_t count) {
        return static_cast<cl_uint>(std::exchange(words, words + chunk_count(count, 32)));
    };
    const ListSizes sizes{
        static_cast<cl_uint>(vertices), static_cast<cl_uint>(faces), bits(faces), bits(vertices), bits(faces),
        static_cast<cl_uint>(room)};
    const auto lease = [&](std::size_t bytes) { return tools.pool->lease(bytes, "lists for the host"); };
    const auto zeros = lease(words * sizeof(cl_uint)), measured = lease(room * sizeof(cl_uint)),
               near = lease(room * sizeof(ListedFace));
    const cl::CommandQueue& queue = tools.queue();
    queue.enqueueFillBuffer(*zeros, cl_uint{0}, 0, words * sizeof(cl_uint));
    device::LentKernel list_measured = tools.kernel(tools.programs.host_lists, "list_measured"),
                       list_near = tools.kernel(tools.programs.host_lists, "list_near");
    launch(queue, list_measured, {std::max(faces, vertices), group}, sizes, answers.of_faces, answers.of_vertices,
           *topology.edges, *topology.starts, *topology.corners, *zeros, *measured, *zeros);
    launch(queue, list_near, {std::min(room, most_groups_of_list * group), group}, sizes, answers.of_faces,
           answers.of_vertices, *topology.edges, *topology.edges, *topology.starts, *topology.corners, *zeros,
           *measured, *zeros, *topology.names->triangles, *topology.order, *topology.vertices, answers.positions,
           *near);
    // Of a short list everything comes at once.
    const std::size_t short_list = std::min(room, device::PinnedCopies::least_bytes / sizeof(ListedFace));
    device::ReadBack<ListCounts> counts(tools.context);
    device::ReadBack<ListedFace> first(tools.context, short_list);
    counts.enqueue(*zeros);
    first.enqueue(*near);
    first.wait();
    counts.end();
    const ListCounts& found = counts.value();
    if (found.is_refused != 0) return std::nullopt;
    std::vector<ListedFace> longer(found.near > short_list ? found.near : 0);
    if (!longer.empty()) device::read_values(set_up.tools.context, *near, longer);
    const std::span<const ListedFace> listed = longer.empty() ? first.values().first(found.near) : longer;
    HostPart part = part_of(listed, faces, vertices);
    part.left.saddles_elsewhere = found.saddles;
    return part;
}

}  // namespace clsdf::engine
