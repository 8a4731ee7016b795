#include "frusta/kernel_topology.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

namespace clsdf::engine {

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

/// Whether an edge has three faces or more, or two of different orientations, or runs from a vertex to itself.
bool is_irregular(const FaceEdges& edges) {
    const auto& [a, b, c] = edges.marks;
    return ((a | b | c) & ~edge_open) != 0;
}

/// The faces with an answer.
Numbers answered_faces(std::span<const std::uint8_t> answers) {
    constexpr std::size_t chunk = 1U << 16;
    return collected(answers.size(), chunk, [&](std::size_t begin, std::size_t end, Numbers& found) {
        for (std::size_t face = begin; face < end; ++face)
            if (answers[face] != 0) found.push_back(static_cast<std::uint32_t>(face));
    });
}

/// Files the vertices of closed fans and of borders by the number of their faces.
class FanFiling {
public:
    explicit FanFiling(const MeshTopology& topology)
        : topology_(topology), kinds_(topology.rings.vertex_count()), fans_(3 * topology.order.size()) {}

    void run(KernelTopology& result) {
        for_each_index(kinds_.size(), [&](std::size_t vertex) { kinds_[vertex] = kind_of(vertex); });
        UninitializedVector<std::uint32_t> sorted(kinds_.size());
        const UninitializedVector<std::uint32_t> first = bucket_sort(
            kinds_.size(), first_border_kind + CLSDF_FAN_FACES + 1, [&](std::size_t vertex) { return kinds_[vertex]; },
            [&](std::size_t vertex, std::size_t place) { sorted[place] = static_cast<std::uint32_t>(vertex); });
        result.irregular_vertices.assign(sorted.begin() + first[irregular], sorted.begin() + first[irregular + 1]);
        std::vector<std::uint32_t> firsts;  // of each item, in `sorted`
        std::size_t words = 0;
        for (std::uint32_t kind = irregular + 1; kind <= first_border_kind + CLSDF_FAN_FACES; ++kind)
            for (std::uint32_t begin = first[kind]; begin < first[kind + 1]; begin += CLSDF_FAN_ITEM) {
                const std::uint32_t size = std::min<std::uint32_t>(CLSDF_FAN_ITEM, first[kind + 1] - begin);
                const bool is_border = kind > first_border_kind;
                const std::uint32_t faces = is_border ? kind - first_border_kind : kind;
                result.fan_items.push_back({static_cast<std::uint32_t>(words), size, faces, is_border ? 1U : 0U});
                firsts.push_back(begin);
                words += chunk_count(size, CLSDF_FAN_STRIDE) * CLSDF_FAN_STRIDE * faces;
            }
        // Kernels number words by 32 bits; a fan has as many as corners, and a mesh has at most
        // 3 * 2^30 corners.
        result.fan_words.resize(words);
        constexpr std::size_t grain = 8;
        for_each_index(
            firsts.size(),
            [&](std::size_t item) { write(result.fan_items[item], &sorted[firsts[item]], result.fan_words); }, grain);
    }

private:
    /// The kinds of vertices beside those of closed fans, whose kind is the number of their faces. The kind of
    /// a border is that number and first_border_kind.
    enum : std::uint8_t { regular_border, irregular, first_border_kind = CLSDF_FAN_FACES };

    std::uint8_t kind_of(std::size_t vertex) {
        const std::size_t count = topology_.rings.size(vertex);
        if (count >= 3 && count <= CLSDF_FAN_FACES && walk(vertex, count)) return static_cast<std::uint8_t>(count);
        return kind_of_border(vertex, count);
    }

    /// A vertex at an open edge has no gap. It is regular if it has not the two other edges of a saddle vertex. Lists
    /// the corners of others.
    std::uint8_t kind_of_border(std::size_t vertex, std::size_t count) {
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
        if (marks != edge_open) return irregular;
        if (uses < 4) return regular_border;
        if (count > CLSDF_FAN_FACES) return irregular;
        for (std::size_t i = 0; i < count; ++i)
            fans_[topology_.rings.start(vertex) + i] = topology_.rings.corner(vertex, i).packed();
        return static_cast<std::uint8_t>(first_border_kind + count);
    }

    /// Whether the faces are one closed fan; lists its corners, counter-clockwise, if the ring has its own.
    bool walk(std::size_t vertex, std::size_t count) {
        std::uint32_t* place = &fans_[topology_.rings.start(vertex)];
        return walk_fan(topology_.edges.faces, topology_.rings.corner(vertex, 0), count, [&](const Corner& corner) {
            *place++ = corner.packed();
            return true;
        });
    }

    void write(const FanItem& item, const std::uint32_t* vertices, std::span<std::uint32_t> words) const {
        for (std::uint32_t i = 0; i < item.count; ++i) {
            const std::uint32_t in_block = i % CLSDF_FAN_STRIDE, block = (i - in_block) * item.faces;
            std::uint32_t* const own = &words[item.offset + block + in_block];
            const std::uint32_t* const fan = &fans_[topology_.rings.start(vertices[i])];
            for (std::size_t k = 0; k < item.faces; ++k) own[CLSDF_FAN_STRIDE * k] = fan[k];
        }
    }

    const MeshTopology& topology_;
    UninitializedVector<std::uint8_t> kinds_;  // of each vertex
    UninitializedVector<std::uint32_t> fans_;  // corners of vertices of items, packed, as in OneRings
};

}  // namespace

KernelTopology::KernelTopology(const MeshTopology& topology) : opposite(opposite_words(topology)) {
    constexpr std::size_t chunk = 1U << 16;
    irregular_faces =
        collected(topology.order.size(), chunk, [&](std::size_t begin, std::size_t end, Numbers& irregular) {
            for (std::size_t face = begin; face < end; ++face)
                if (is_irregular(topology.edges.faces[face])) irregular.push_back(static_cast<std::uint32_t>(face));
        });
    FanFiling(topology).run(*this);
}

LeftToHost KernelTopology::left_to_host(const MeshTopology& topology, std::span<const std::uint8_t> face_answers,
                                        std::span<const std::uint8_t> vertex_answers) const {
    LeftToHost left;
    left.faces = answered_faces(face_answers);
    left.faces.insert(left.faces.end(), irregular_faces.begin(), irregular_faces.end());
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
    left.vertices.insert(left.vertices.end(), irregular_vertices.begin(), irregular_vertices.end());
    std::sort(left.vertices.begin(), left.vertices.end());
    left.saddles_elsewhere = saddles;
    return left;
}

LeftToHost left_by_answers(const MeshTopology& topology, std::span<const std::uint8_t> face_answers,
                           std::span<const std::uint8_t> vertex_answers) {
    LeftToHost left;
    for (std::uint32_t face = 0; face < face_answers.size(); ++face) {
        if (face_answers[face] != 0 || is_irregular(topology.edges.faces[face])) left.faces.push_back(face);
    }
    for (std::uint32_t vertex = 0; vertex < vertex_answers.size(); ++vertex) {
        if ((vertex_answers[vertex] & CLSDF_VERTEX_IS_OPEN) != 0) left.vertices.push_back(vertex);
        if (vertex_answers[vertex] == CLSDF_VERTEX_IS_SADDLE) ++left.saddles_elsewhere;
    }
    return left;
}

std::size_t KernelTopology::host_bytes() const {
    return (opposite.size() + fan_words.size() + irregular_faces.size() + irregular_vertices.size()) *
               sizeof(std::uint32_t) +
           fan_items.size() * sizeof(FanItem);
}

}  // namespace clsdf::engine
