#include "polyhedra/mesh_topology.hpp"

#include "core/parallel.hpp"
#include "polyhedra/morton_order.hpp"
#include "polyhedra/one_rings.hpp"
#include "polyhedra/prefetch.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

namespace clsdf::polyhedra {

namespace {

/// Numbers vertices as faces first name them, by parts of the faces. Each part lists the vertices that it names and no
/// earlier part has named so far; for the time being the vertex at place i of the list has the number
/// 3 * (first face) + i, so that earlier parts give lower ones. Parts run side by side, so several may list the same
/// vertex; it belongs to the first of them, however far the others were.
class Numbering {
public:
    Numbering(const Mesh& mesh, std::span<const std::uint32_t> order, OrderedFaces& faces)
        : mesh_(mesh), order_(order), faces_(faces), numbers_(mesh.vertices().size()) {
        const std::size_t size = stretch_for_all_cores(order.size(), OrderedFaces::stretch);
        for (std::size_t begin = 0; begin < order.size(); begin += size)
            parts_.push_back({begin, std::min(order.size(), begin + size)});
    }

    void run() {
        for_each_index(numbers_.size(), [&](std::size_t vertex) { numbers_[vertex] = none; });
        faces_.triangles = UninitializedVector<Triangle>(order_.size());
        faces_.first_vertices.resize(stretch_count(order_.size(), OrderedFaces::stretch) + 1);
        // With room for what is stored and not counted.
        faces_.vertices = UninitializedVector<std::uint32_t>(numbers_.size() + 1);
        std::uint32_t count = 0;
        if (parts_.size() == 1) {
            list(parts_[0], faces_.vertices);
            count = parts_[0].list_end;
        } else if (parts_.size() > 1) {
            UninitializedVector<std::uint32_t> listed(3 * order_.size());
            for_each_part([&](Part& part) { list(part, listed); });
            find_shared(listed);
            for (Part& part : parts_) part.first = std::exchange(count, count + part.own_before(part.list_end));
            renumber(listed);
        }
        faces_.first_vertices.back() = count;
        faces_.vertices.resize(count);
    }

private:
    static constexpr std::uint32_t none = UINT32_MAX;

    /// An entry of a list, and the first one of the same vertex.
    struct Shared {
        std::uint32_t number;
        std::uint32_t first;
    };

    struct Part {
        std::size_t begin;
        std::size_t end;
        std::uint32_t list_end = 0;
        std::vector<Shared> shared{};  ///< entries that are not the first of their vertex
        std::uint32_t first = 0;       ///< of its own vertices

        std::uint32_t list_begin() const { return static_cast<std::uint32_t>(3 * begin); }

        /// Own vertices on the list before a number.
        std::uint32_t own_before(std::uint32_t number) const {
            const auto place = std::lower_bound(shared.begin(), shared.end(), number,
                                                [](const Shared& entry, std::uint32_t n) { return entry.number < n; });
            return number - list_begin() - static_cast<std::uint32_t>(place - shared.begin());
        }
    };

    template <typename Function>
    void for_each_part(const Function& f) {
        for_each_stretch(parts_.size(), 1, [&](std::size_t part, std::size_t, std::size_t) { f(parts_[part]); });
    }

    void list(Part& part, std::span<std::uint32_t> listed) {
        // A batch at a time: other cores have written to the lines where the vertices' numbers are, or they are far.
        constexpr std::size_t batch = 256;
        static_assert(OrderedFaces::stretch % batch == 0);
        std::uint32_t next = part.list_begin();
        for (std::size_t begin = part.begin; begin < part.end; begin += batch) {
            const std::size_t end = std::min(part.end, begin + batch);
            for (std::size_t face = begin; face < end; ++face) {
                const Triangle& triangle = mesh_.triangles()[order_[face]];
                for (const std::uint32_t vertex : triangle) prefetch(&numbers_[vertex]);
                faces_.triangles[face] = triangle;
            }
            if (begin % OrderedFaces::stretch == 0) faces_.first_vertices[begin / OrderedFaces::stretch] = next;
            for (std::size_t face = begin; face < end; ++face)
                for (std::uint32_t& vertex : faces_.triangles[face]) {
                    const std::atomic_ref number(numbers_[vertex]);
                    const std::uint32_t known = number.load(std::memory_order_relaxed);
                    const bool is_new = known >= next;  // not a branch: that could not be predicted
                    listed[next] = vertex;
                    vertex = is_new ? next : known;
                    number.store(vertex, std::memory_order_relaxed);
                    next += is_new ? 1U : 0U;
                }
        }
        part.list_end = next;
    }

    void find_shared(std::span<const std::uint32_t> listed) {
        // Where parts met a vertex at a time, any of their numbers may have been stored last.
        for_each_part([&](const Part& part) {
            for (std::uint32_t number = part.list_begin(); number < part.list_end; ++number) {
                const std::atomic_ref first(numbers_[listed[number]]);
                std::uint32_t known = first.load(std::memory_order_relaxed);
                while (known > number && !first.compare_exchange_weak(known, number, std::memory_order_relaxed)) {
                }
            }
        });
        for_each_part([&](Part& part) {
            for (std::uint32_t number = part.list_begin(); number < part.list_end; ++number) {
                const std::uint32_t first = numbers_[listed[number]];
                if (first != number) part.shared.push_back({number, first});
            }
        });
    }

    /// Puts the final numbers into the lists, and from there into the triangles.
    void renumber(std::span<std::uint32_t> listed) {
        for_each_part([&](const Part& part) {
            std::uint32_t next = part.first;
            auto shared = part.shared.begin();
            for (std::uint32_t number = part.list_begin(); number < part.list_end; ++number) {
                if (shared != part.shared.end() && shared->number == number) {
                    ++shared;
                } else {
                    faces_.vertices[next] = listed[number];
                    listed[number] = next++;
                }
            }
            for (std::size_t face = part.begin; face < part.end; face += OrderedFaces::stretch) {
                std::uint32_t& first = faces_.first_vertices[face / OrderedFaces::stretch];
                first = part.first + part.own_before(first);
            }
        });
        for_each_part([&](const Part& part) {
            for (const Shared& entry : part.shared) listed[entry.number] = listed[entry.first];
        });
        for_each_index(order_.size(), [&](std::size_t face) {
            for (std::uint32_t& vertex : faces_.triangles[face]) vertex = listed[vertex];
        });
    }

    const Mesh& mesh_;
    std::span<const std::uint32_t> order_;
    OrderedFaces& faces_;
    std::vector<Part> parts_;
    UninitializedVector<std::uint32_t> numbers_;  // of the mesh's vertices
};

}  // namespace

OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order) {
    checked_face_count(order.size());
    OrderedFaces faces;
    Numbering(mesh, order, faces).run();
    return faces;
}

MeshTopology::MeshTopology(const Mesh& mesh) : MeshTopology(mesh, morton_order(mesh)) {}

MeshTopology::MeshTopology(const Mesh& mesh, UninitializedVector<std::uint32_t> order_in)
    : order(std::move(order_in)),
      faces(ordered_faces(mesh, order)),
      rings(faces),
      edges(pair_edges(faces.triangles, rings)) {}

std::size_t MeshTopology::bytes() const {
    return order.size() * sizeof(order[0]) + faces.triangles.size() * sizeof(Triangle) +
           faces.vertices.size() * sizeof(std::uint32_t) + rings.bytes() + edges.faces.size() * sizeof(FaceEdges);
}

}  // namespace clsdf::polyhedra
