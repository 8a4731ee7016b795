#include "polyhedra/face_order.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "mesh/one_rings.hpp"
#include "polyhedra/frames.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace clsdf::polyhedra {

namespace {

/// Prefetches memory, if the compiler has a built-in for it.
inline void prefetch([[maybe_unused]] const void* memory) {
#ifdef __GNUC__
    __builtin_prefetch(memory);
#endif
}

/// Bits of a coordinate: a code has 30.
constexpr unsigned most_bits = 10;

/// A vector of numbers, as wide as the processor's vectors.
constexpr std::size_t lanes = 8;

struct LaneVectors {
    std::array<double, lanes> x, y, z;
};

inline std::uint32_t cell(double place, double last) {
    const double positive = place > 0 ? place : 0;
    return spread_bits(static_cast<std::uint32_t>(static_cast<std::int32_t>(positive < last ? positive : last)));
}

/// The codes of triangles, as many at a time as a processor's vectors hold.
class CentroidCodes {
public:
    using Codes = std::array<std::uint32_t, lanes>;

    /// bits: of each coordinate, at most most_bits.
    CentroidCodes(const Mesh& mesh, unsigned bits)
        : mesh_(mesh), to_cells_{3 * to_vector(mesh.box().lower), 0, static_cast<double>(1u << bits)} {
        const double longest = mesh.box().longest_side();
        if (longest > 0) to_cells_.scale = to_cells_.count / (3 * longest);
    }

    /// Starts to bring their vertices near the processor.
    void fetch_ahead(std::size_t first) const {
        for (std::size_t i = first; i < std::min(first + lanes, mesh_.triangles().size()); ++i)
            for (const std::uint32_t vertex : mesh_.triangles()[i]) prefetch(&mesh_.vertices()[vertex]);
    }

    /// The codes of the triangles from `first` on; the last one fills the rest.
    Codes of(std::size_t first) const {
        LaneVectors sums{};
        for (std::size_t i = 0; i < lanes; ++i) {
            const auto& [a, b, c] = mesh_.triangles()[std::min(first + i, mesh_.triangles().size() - 1)];
            const Vector sum = (at(a) + at(b)) + at(c);
            sums.x[i] = sum.x();
            sums.y[i] = sum.y();
            sums.z[i] = sum.z();
        }
        Codes codes;
        encode(sums, to_cells_, codes);
        return codes;
    }

private:
    /// From the sum of a triangle's vertices.
    struct ToCells {
        Vector lower;  ///< the box's corner, three times
        double scale;
        double count;  ///< along the box's longest side
    };

    Vector at(std::uint32_t vertex) const { return to_vector(mesh_.vertices()[vertex]); }

    static void encode(const LaneVectors& sums, const ToCells& to_cells, Codes& codes);

    const Mesh& mesh_;
    ToCells to_cells_;
};

CLSDF_SEVERAL_TARGETS void CentroidCodes::encode(const LaneVectors& sums, const ToCells& to_cells, Codes& codes) {
    const auto& [lower, scale, count] = to_cells;
    for (std::size_t i = 0; i < lanes; ++i)
        codes[i] = cell((sums.x[i] - lower.x()) * scale, count - 1) |
                   cell((sums.y[i] - lower.y()) * scale, count - 1) << 1 |
                   cell((sums.z[i] - lower.z()) * scale, count - 1) << 2;
}

}  // namespace

UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh) {
    const std::size_t count = mesh.triangles().size();
    // Bits of a coordinate and of a digit. Fewer bits suffice for few triangles, and are sorted faster.
    const unsigned bits = count <= std::size_t{1} << 17 ? 8 : most_bits;
    const CentroidCodes centroids(mesh, bits);
    UninitializedVector<Coded> memory(2 * count);  // in one piece, as large as what is needed next
    const std::span<Coded> coded = std::span(memory).first(count);
    for_each_range(
        count,
        [&](std::size_t begin, std::size_t end) {
            for (std::size_t first = begin; first < end; first += lanes) {
                centroids.fetch_ahead(first + 8 * lanes);
                const CentroidCodes::Codes codes = centroids.of(first);
                for (std::size_t t = first; t < std::min(end, first + lanes); ++t)
                    coded[t] = {codes[t - first], static_cast<std::uint32_t>(t)};
            }
        },
        std::size_t{1} << 13);
    UninitializedVector<std::uint32_t> order(count);
    sort_by_code(coded, std::span(memory).subspan(count), bits, order);
    return order;
}

OrderedFaces ordered_faces(const Mesh& mesh, std::span<const std::uint32_t> order) {
    OrderedFaces faces;
    faces.triangles = UninitializedVector<Triangle>(checked_face_count(order.size()));
    for_each_index(order.size(), [&](std::size_t face) { faces.triangles[face] = mesh.triangles()[order[face]]; });
    const std::size_t vertex_count = mesh.vertices().size();
    constexpr std::uint32_t none = UINT32_MAX;
    std::vector<std::uint32_t> numbers(vertex_count, none);                 // of the mesh's vertices
    faces.vertices = UninitializedVector<std::uint32_t>(vertex_count + 1);  // the last vertex is followed by others
    std::uint32_t count = 0;
    for (Triangle& triangle : faces.triangles)
        for (std::uint32_t& vertex : triangle) {
            faces.vertices[count] = vertex;
            std::uint32_t& number = numbers[vertex];
            const bool is_new = number == none;  // not a branch: that could not be predicted
            vertex = number = is_new ? count : number;
            count += is_new ? 1U : 0U;
        }
    faces.vertices.resize(count);
    return faces;
}

}  // namespace clsdf::polyhedra
