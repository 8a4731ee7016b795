#include "topology/face_order.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "mesh/one_rings.hpp"
#include "spread_bits.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace clsdf::engine {

namespace {

using Vector = Eigen::Vector3d;

std::uint32_t cell(double place, double last) {
    const double positive = place > 0 ? place : 0;  // 0 for a NaN, too
    return spread_bits(static_cast<std::uint32_t>(static_cast<std::int32_t>(positive < last ? positive : last)));
}

}  // namespace

UninitializedVector<std::uint32_t> morton_order(const Mesh& mesh) {
    const std::size_t count = mesh.triangles().size();
    const unsigned bits = morton_bits(count);
    const double longest = mesh.box().longest_side(), cells = 1u << bits;
    const double scale = longest > 0 ? cells / (3 * longest) : 0;
    const Vector lower = 3 * Vector(mesh.box().lower.data());
    const auto at = [&](std::uint32_t vertex) { return Vector(mesh.vertices()[vertex].data()); };
    UninitializedVector<Coded> memory(2 * count);  // in one piece, as large as what is needed next
    const std::span<Coded> coded = std::span(memory).first(count);
    for_each_index(count, [&](std::size_t t) {
        const auto& [a, b, c] = mesh.triangles()[t];
        const Vector place = scale * (((at(a) + at(b)) + at(c)) - lower);
        coded[t] = {cell(place.x(), cells - 1) | cell(place.y(), cells - 1) << 1 | cell(place.z(), cells - 1) << 2,
                    static_cast<std::uint32_t>(t)};
    });
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

}  // namespace clsdf::engine
