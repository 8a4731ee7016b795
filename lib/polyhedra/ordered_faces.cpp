#include "polyhedra/ordered_faces.hpp"

#include "polyhedra/one_rings.hpp"
#include "polyhedra/parallel.hpp"

#include <atomic>

namespace clsdf::polyhedra {

namespace {

/// Which stretch names a vertex first, and the vertex' place among those of that stretch, in one word: the least of
/// several is that of the first stretch.
class Name {
public:
    static constexpr unsigned place_bits = 13;
    static constexpr std::uint32_t no_place = (1U << place_bits) - 1;
    static_assert(3 * OrderedFaces::stretch <= no_place && most_faces / OrderedFaces::stretch <= UINT32_MAX >> place_bits);

    explicit Name(std::uint32_t packed) : packed_(packed) {}
    Name(std::size_t stretch, std::uint32_t place)
        : packed_(static_cast<std::uint32_t>(stretch) << place_bits | place) {}

    std::uint32_t packed() const { return packed_; }
    std::size_t stretch() const { return packed_ >> place_bits; }
    std::uint32_t place() const { return packed_ & no_place; }

private:
    std::uint32_t packed_;
};

/// The names of all vertices, for all threads.
class Names {
public:
    Names(std::size_t vertices, ScratchMemory* scratch) : packed_(vertices, scratch) {
        for_each_index(vertices, [&](std::size_t vertex) { packed_[vertex] = UINT32_MAX; });
    }

    Name get(std::uint32_t vertex) { return Name(std::atomic_ref(packed_[vertex]).load(std::memory_order_relaxed)); }
    void set(std::uint32_t vertex, const Name& name) {
        std::atomic_ref(packed_[vertex]).store(name.packed(), std::memory_order_relaxed);
    }
    void lower(std::uint32_t vertex, const Name& name) {
        const std::atomic_ref packed(packed_[vertex]);
        std::uint32_t known = packed.load(std::memory_order_relaxed);
        while (known > name.packed() &&
               !packed.compare_exchange_weak(known, name.packed(), std::memory_order_relaxed)) {
        }
    }

private:
    UninitializedVector<std::uint32_t> packed_;
};

}  // namespace

OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order, ScratchMemory* scratch) {
    check_face_count(order.size());
    const std::size_t stretches = stretch_count(order.size(), OrderedFaces::stretch);
    const auto for_each_stretch = [&](const auto& f) {
        polyhedra::for_each_stretch(order.size(), OrderedFaces::stretch, f);
    };

    OrderedFaces faces;
    faces.triangles = UninitializedVector<Triangle>(order.size(), scratch);
    faces.first_vertices.assign(stretches + 1, 0);
    Names names(mesh.vertices().size(), scratch);
    for_each_stretch([&](std::size_t stretch, std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) {
            faces.triangles[face] = mesh.triangles()[order[face]];
            for (const std::uint32_t vertex : faces.triangles[face]) names.lower(vertex, {stretch, Name::no_place});
        }
    });
    for_each_stretch([&](std::size_t stretch, std::size_t begin, std::size_t end) {
        std::uint32_t count = 0;
        for (std::size_t face = begin; face < end; ++face) {
            for (const std::uint32_t vertex : faces.triangles[face]) {
                const Name name = names.get(vertex);
                if (name.stretch() != stretch) continue;
                const bool is_new = name.place() == Name::no_place;  // not a branch: that could not be predicted
                names.set(vertex, {stretch, is_new ? count : name.place()});
                count += is_new ? 1U : 0U;
            }
        }
        faces.first_vertices[stretch + 1] = count;
    });
    for (std::size_t i = 0; i < stretches; ++i) faces.first_vertices[i + 1] += faces.first_vertices[i];

    faces.vertices = UninitializedVector<std::uint32_t>(faces.first_vertices.back(), scratch);
    faces.positions = UninitializedVector<Vec3>(faces.first_vertices.back(), scratch);
    for_each_stretch([&](std::size_t stretch, std::size_t begin, std::size_t end) {
        for (std::size_t face = begin; face < end; ++face) {
            for (std::uint32_t& vertex : faces.triangles[face]) {
                const Name name = names.get(vertex);
                const std::uint32_t number = faces.first_vertices[name.stretch()] + name.place();
                if (name.stretch() == stretch) faces.vertices[number] = vertex;
                vertex = number;
            }
        }
        for (std::size_t i = faces.first_vertices[stretch]; i < faces.first_vertices[stretch + 1]; ++i)
            faces.positions[i] = mesh.vertices()[faces.vertices[i]];
    });
    return faces;
}

}  // namespace clsdf::polyhedra
