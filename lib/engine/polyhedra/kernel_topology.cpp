#include "polyhedra/kernel_topology.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

namespace clsdf::polyhedra {

namespace {

static_assert(CLSDF_FAN_ITEM % CLSDF_FAN_STRIDE == 0);

using Numbers = std::vector<std::uint32_t>;

void sort_and_unite(Numbers& numbers) {
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Collects f(part, begin, end), lists of numbers of sub-ranges, one after the other.
template <typename Function>
Numbers collected(std::size_t count, std::size_t chunk, const Function& f) {
    std::vector<Numbers> parts(chunk_count(count, chunk));
    for_each_chunk(count, chunk,
                   [&](std::size_t part, std::size_t begin, std::size_t end) { f(begin, end, parts[part]); });
    if (parts.size() == 1) return std::move(parts.front());
    Numbers all;
    for (const Numbers& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

/// The faces with an answer.
Numbers answered_faces(std::span<const std::uint8_t> answers) {
    constexpr std::size_t chunk = 1U << 16;
    return collected(answers.size(), chunk, [&](std::size_t begin, std::size_t end, Numbers& found) {
        for (std::size_t face = begin; face < end; ++face)
            if (answers[face] != 0) found.push_back(static_cast<std::uint32_t>(face));
    });
}

/// Files the vertices of closed fans by the number of their faces.
class FanFiling {
public:
    explicit FanFiling(const MeshTopology& topology)
        : topology_(topology),
          faces_(topology.rings.vertex_count()),
          fans_(3 * topology.order.size()),
          parts_(chunk_count(faces_.size(), chunk)) {}

    void run(KernelTopology& result) {
        for_each_chunk(faces_.size(), chunk,
                       [&](std::size_t part, std::size_t begin, std::size_t end) { look_at(part, begin, end); });
        set_items(result);
        for_each_chunk(faces_.size(), chunk, [&](std::size_t part, std::size_t begin, std::size_t end) {
            write(parts_[part], begin, end, result);
        });
        for (const Part& part : parts_)
            result.awkward_vertices.insert(result.awkward_vertices.end(), part.awkward.begin(), part.awkward.end());
    }

private:
    static constexpr std::size_t chunk = 4096;
    using ByFaces = std::array<std::uint32_t, CLSDF_FAN_FACES + 1>;

    struct Part {
        ByFaces counts{};  ///< of vertices; then the number of the first one among those with as many faces
        std::vector<std::uint32_t> awkward;
    };

    /// Walks around the vertices.
    void look_at(std::size_t number, std::size_t begin, std::size_t end) {
        Part& part = parts_[number];
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            const std::size_t count = topology_.rings.size(vertex);
            faces_[vertex] = 0;
            if (count >= 3 && count <= CLSDF_FAN_FACES && walk(vertex, count)) {
                faces_[vertex] = static_cast<std::uint8_t>(count);
                ++part.counts[count];
                continue;
            }
            if (!is_ordinary_border(vertex, count)) part.awkward.push_back(static_cast<std::uint32_t>(vertex));
        }
    }

    /// Whether a vertex is at an open edge, hence without a gap, and has not the two edges of a saddle vertex.
    bool is_ordinary_border(std::size_t vertex, std::size_t count) const {
        std::uint8_t marks = 0;
        std::size_t uses = 0;  // of edges with two faces: two each
        for (std::size_t i = 0; i < count; ++i) {
            const Corner corner = topology_.rings.corner(vertex, i);
            const FaceEdges& edges = topology_.edges.faces[corner.face];
            for (const std::uint32_t k : {corner.vertex, previous_of_three(corner.vertex)}) {
                marks |= edges.marks[k];
                uses += edges.marks[k] == 0 ? 1U : 0U;
            }
        }
        return marks == edge_open && uses < 4;
    }

    /// Whether the faces are one closed fan; lists its corners, counter-clockwise, if the ring has its own.
    bool walk(std::size_t vertex, std::size_t count) {
        std::uint32_t* const fan = &fans_[topology_.rings.start(vertex)];
        const Corner first = topology_.rings.corner(vertex, 0);
        Corner corner = first;
        for (std::size_t i = 0; i < count; ++i) {
            fan[i] = corner.packed();
            const FaceEdges& edges = topology_.edges.faces[corner.face];
            const std::uint32_t arriving = previous_of_three(corner.vertex);
            if ((edges.marks[corner.vertex] | edges.marks[arriving]) != 0) return false;
            corner = Corner::unpack(edges.across[arriving]);
            if (corner.face == first.face) return i + 1 == count;
        }
        return false;
    }

    void set_items(KernelTopology& result) {
        std::size_t words = 0;
        for (std::uint32_t faces = 3; faces <= CLSDF_FAN_FACES; ++faces) {
            std::uint32_t count = 0;
            for (Part& part : parts_) count += std::exchange(part.counts[faces], count);
            first_items_[faces] = static_cast<std::uint32_t>(result.fan_items.size());
            for (std::uint32_t first = 0; first < count; first += CLSDF_FAN_ITEM) {
                const std::uint32_t size = std::min<std::uint32_t>(CLSDF_FAN_ITEM, count - first);
                result.fan_items.push_back({static_cast<std::uint32_t>(words), size, faces});
                words += chunk_count(size, CLSDF_FAN_STRIDE) * block_words(faces);
            }
        }
        // Kernels number words by 32 bits; a fan has as many as corners, and a mesh has at most
        // 3 * 2^30 corners.
        result.fan_words.resize(words);
    }

    static std::size_t block_words(std::size_t faces) { return CLSDF_FAN_STRIDE * faces; }

    void write(Part& part, std::size_t begin, std::size_t end, KernelTopology& result) const {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            const std::uint32_t count = faces_[vertex];
            if (count == 0) continue;
            const std::uint32_t number = part.counts[count]++, in_item = number % CLSDF_FAN_ITEM;
            const FanItem& item = result.fan_items[first_items_[count] + number / CLSDF_FAN_ITEM];
            std::uint32_t* const words =
                &result.fan_words[item.offset + in_item / CLSDF_FAN_STRIDE * block_words(count)];
            std::uint32_t* const own = words + in_item % CLSDF_FAN_STRIDE;
            const std::uint32_t* const fan = &fans_[topology_.rings.start(vertex)];
            for (std::size_t i = 0; i < count; ++i) own[CLSDF_FAN_STRIDE * i] = fan[i];
        }
    }

    const MeshTopology& topology_;
    UninitializedVector<std::uint8_t> faces_;  // of each vertex; 0 unless they are a fan
    UninitializedVector<std::uint32_t> fans_;  // corners, packed, as in OneRings
    std::vector<Part> parts_;
    std::array<std::uint32_t, CLSDF_FAN_FACES + 1> first_items_{};
};

}  // namespace

KernelTopology::KernelTopology(const MeshTopology& topology) : opposite(3 * topology.order.size()) {
    constexpr std::size_t chunk = 4096;
    const std::size_t count = topology.order.size();
    std::vector<Numbers> awkward(chunk_count(count, chunk));
    for_each_chunk(count, chunk, [&](std::size_t part, std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) {
            const FaceEdges& edges = topology.edges.faces[face];
            std::uint8_t all = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                all |= edges.marks[k];
                if (edges.marks[k] != 0) {
                    opposite[3 * face + k] = CLSDF_NO_VERTEX;
                    continue;
                }
                const Corner across = Corner::unpack(edges.across[k]);
                opposite[3 * face + k] = topology.faces.triangles[across.face][previous_of_three(across.vertex)];
            }
            if ((all & ~edge_open) != 0) awkward[part].push_back(static_cast<std::uint32_t>(face));
        }
    });
    for (const auto& faces : awkward) awkward_faces.insert(awkward_faces.end(), faces.begin(), faces.end());
    FanFiling(topology).run(*this);
}

LeftToHost KernelTopology::left_to_host(const MeshTopology& topology, std::span<const std::uint8_t> face_answers,
                                        std::span<const std::uint8_t> vertex_answers) const {
    LeftToHost left;
    left.faces = answered_faces(face_answers);
    left.faces.insert(left.faces.end(), awkward_faces.begin(), awkward_faces.end());
    sort_and_unite(left.faces);
    std::atomic<std::size_t> saddles = 0;
    constexpr std::size_t items_of_chunk = (1U << 16) / CLSDF_FAN_ITEM;
    left.vertices =
        collected(fan_items.size(), items_of_chunk, [&](std::size_t begin, std::size_t end, Numbers& found) {
            std::size_t saddles_here = 0;
            for (std::size_t number = begin; number < end; ++number) {
                const FanItem& item = fan_items[number];
                const std::uint8_t* const answers = &vertex_answers[number * CLSDF_FAN_ITEM];
                saddles_here += static_cast<std::size_t>(
                    std::count(answers, answers + item.count, std::uint8_t{CLSDF_VERTEX_IS_SADDLE}));
                for (std::uint32_t i = 0; i < item.count; ++i) {
                    if ((answers[i] & CLSDF_VERTEX_IS_OPEN) == 0) continue;
                    const std::uint32_t in_block = i % CLSDF_FAN_STRIDE, block = (i - in_block) * item.faces;
                    const Corner corner = Corner::unpack(fan_words[item.offset + block + in_block]);
                    found.push_back(topology.faces.triangles[corner.face][corner.vertex]);
                }
            }
            saddles += saddles_here;
        });
    left.vertices.insert(left.vertices.end(), awkward_vertices.begin(), awkward_vertices.end());
    std::sort(left.vertices.begin(), left.vertices.end());
    left.saddles_elsewhere = saddles;
    return left;
}

std::size_t KernelTopology::bytes() const {
    return (opposite.size() + fan_words.size() + awkward_faces.size() + awkward_vertices.size()) *
               sizeof(std::uint32_t) +
           fan_items.size() * sizeof(FanItem);
}

}  // namespace clsdf::polyhedra
