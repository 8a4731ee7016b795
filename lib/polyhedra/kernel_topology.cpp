#include "polyhedra/kernel_topology.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace clsdf::polyhedra {

namespace {

static_assert(CLSDF_FAN_ITEM % CLSDF_FAN_STRIDE == 0);

/// Files the vertices of closed fans by the number of their faces.
class FanFiling {
public:
    explicit FanFiling(const MeshTopology& topology)
        : topology_(topology),
          faces_(topology.rings.vertex_count()),
          fans_(3 * topology.order.size()),
          parts_(stretch_count(faces_.size(), stretch)) {}

    void run(KernelTopology& result) {
        for_each_stretch(faces_.size(), stretch,
                         [&](std::size_t part, std::size_t begin, std::size_t end) { look_at(part, begin, end); });
        set_items(result);
        for_each_stretch(faces_.size(), stretch, [&](std::size_t part, std::size_t begin, std::size_t end) {
            write(parts_[part], begin, end, result);
        });
        for (const Part& part : parts_) {
            result.awkward_vertices.insert(result.awkward_vertices.end(), part.awkward.begin(), part.awkward.end());
            result.border_vertices.insert(result.border_vertices.end(), part.border.begin(), part.border.end());
        }
    }

private:
    static constexpr std::size_t stretch = 4096;
    using ByFaces = std::array<std::uint32_t, CLSDF_FAN_FACES + 1>;

    struct Part {
        ByFaces counts{};  ///< of vertices; then the number of the first one among those with as many faces
        std::vector<std::uint32_t> awkward, border;
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
            std::uint8_t marks = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const Corner corner = topology_.rings.corner(vertex, i);
                const FaceEdges& edges = topology_.edges.faces[corner.face];
                marks |= edges.marks[corner.vertex];
                marks |= edges.marks[previous_of_three(corner.vertex)];
            }
            (marks == edge_open ? part.border : part.awkward).push_back(static_cast<std::uint32_t>(vertex));
        }
    }

    /// Whether the faces are one closed fan; lists its corners, counter-clockwise, where the ring has its own.
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
                words += stretch_count(size, CLSDF_FAN_STRIDE) * block_words(faces);
            }
        }
        // Kernels number words by 32 bits; a mesh has at most 2^30 faces, hence 6 * 2^30 words: see suits().
        result.fan_words.resize(words);
    }

    static std::size_t block_words(std::size_t faces) { return CLSDF_FAN_STRIDE * (1 + 2 * faces); }

    void write(Part& part, std::size_t begin, std::size_t end, KernelTopology& result) const {
        for (std::size_t vertex = begin; vertex < end; ++vertex) {
            const std::uint32_t count = faces_[vertex];
            if (count == 0) continue;
            const std::uint32_t number = part.counts[count]++, in_item = number % CLSDF_FAN_ITEM;
            const FanItem& item = result.fan_items[first_items_[count] + number / CLSDF_FAN_ITEM];
            std::uint32_t* const words =
                &result.fan_words[item.offset + in_item / CLSDF_FAN_STRIDE * block_words(count)];
            std::uint32_t* const own = words + in_item % CLSDF_FAN_STRIDE;
            own[0] = static_cast<std::uint32_t>(vertex);
            const std::uint32_t* const fan = &fans_[topology_.rings.start(vertex)];
            for (std::size_t i = 0; i < count; ++i) {
                const Corner corner = Corner::unpack(fan[i]);
                own[CLSDF_FAN_STRIDE * (1 + i)] = topology_.faces.triangles[corner.face][next_of_three(corner.vertex)];
                own[CLSDF_FAN_STRIDE * (1 + count + i)] = 3 * corner.face + corner.vertex;
            }
        }
    }

    const MeshTopology& topology_;
    UninitializedVector<std::uint8_t> faces_;  // of each vertex; 0 unless they are a fan
    UninitializedVector<std::uint32_t> fans_;  // corners, packed, as in OneRings
    std::vector<Part> parts_;
    std::array<std::uint32_t, CLSDF_FAN_FACES + 1> first_items_{};
};

}  // namespace

KernelTopology::KernelTopology(const MeshTopology& topology)
    : opposite(3 * topology.order.size()), names(topology.order.size()) {
    constexpr std::size_t stretch = 4096;
    std::vector<std::vector<std::uint32_t>> awkward(stretch_count(names.size(), stretch));
    for_each_stretch(names.size(), stretch, [&](std::size_t part, std::size_t begin, std::size_t end) {
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
            names[face] = topology.order[face] | ((all & edge_non_manifold) != 0 ? CLSDF_NAME_NON_MANIFOLD : 0U);
            if ((all & ~edge_open) != 0) awkward[part].push_back(static_cast<std::uint32_t>(face));
        }
    });
    for (const auto& faces : awkward) awkward_faces.insert(awkward_faces.end(), faces.begin(), faces.end());
    FanFiling(topology).run(*this);
}

std::size_t KernelTopology::bytes() const {
    return (opposite.size() + names.size() + fan_words.size() + awkward_faces.size() + awkward_vertices.size() +
            border_vertices.size()) *
               sizeof(std::uint32_t) +
           fan_items.size() * sizeof(FanItem);
}

}  // namespace clsdf::polyhedra
