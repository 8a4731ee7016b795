#include "mesh_arrays.hpp"

#include "errors.hpp"
#include "values.hpp"

#include <array>
#include <cstring>

namespace clsdf::c {

namespace {

/// visit(item, component, number) for all numbers, as doubles or 64-bit integers. Throws Error(unsupported) for memory
/// of the device.
template <typename Number, typename Visit>
void visit_triples(const InputArray& array, const char* what, const Visit& visit) {
    if (array.device != nullptr)
        throw Error(ErrorCode::unsupported,
                    std::string(what) + " lie in memory of the device; give an array of the host");
    const auto width = static_cast<std::ptrdiff_t>(sizeof(Number));
    const std::ptrdiff_t component = array.component_stride == 0 ? width : array.component_stride;
    // Components that lie elsewhere leave no room between the items.
    const std::ptrdiff_t item = array.strides[0] != 0 ? array.strides[0] : component == width ? 3 * width : width;
    const std::byte* at = static_cast<const std::byte*>(array.host) + array.offset;
    for (std::size_t i = 0; i < array.count; ++i, at += item)
        for (std::size_t k = 0; k < 3; ++k) {
            Number number;
            std::memcpy(&number, at + static_cast<std::ptrdiff_t>(k) * component, sizeof number);
            visit(i, k, number);
        }
}

std::vector<Triangle> triangles_from_0(const MeshView& mesh, const std::string& name) {
    const InputArray& array = mesh.triangles();
    const std::size_t vertices = mesh.vertices().count;
    std::vector<Triangle> triangles(array.count);
    const auto store = [&](std::size_t t, std::size_t corner, auto index) {
        if (index < 1 || static_cast<std::uint64_t>(index) > vertices)
            throw Error(ErrorCode::invalid_mesh, name + ": triangle " + std::to_string(t + 1) +
                                                     " has the vertex index " + std::to_string(index) +
                                                     "; with index base 1 they are 1 to " + std::to_string(vertices));
        triangles[t][corner] = static_cast<std::uint32_t>(index - 1);
    };
    const char* what = "triangles with index base 1";
    switch (array.type) {
        case ElementType::int32:
            visit_triples<std::int32_t>(array, what, store);
            break;
        case ElementType::int64:
            visit_triples<std::int64_t>(array, what, store);
            break;
        case ElementType::uint64:
            visit_triples<std::uint64_t>(array, what, store);
            break;
        default:
            visit_triples<std::uint32_t>(array, what, store);
    }
    return triangles;
}

}  // namespace

MeshArrays::MeshArrays(const clsdf_mesh_arrays* arrays) {
    const clsdf_mesh_arrays from = read_given(arrays, CLSDF_MESH_ARRAYS_INIT, "clsdf_mesh_arrays");
    check_reserved(from.reserved, "clsdf_mesh_arrays");
    index_base_ = checked_index_base(from.index_base);
    name_ = text_or(from.name, "mesh");
    view_.emplace(input_of(&from.vertices, "vertices"), input_of(&from.triangles, "triangles"));
    if (index_base_ == 0) return;
    triangles_ = triangles_from_0(*view_, name_);
    view_.emplace(view_->vertices(), triangles_);
}

std::vector<Vec3> positions_of(const InputArray& positions) {
    std::vector<Vec3> result(positions.count);
    const auto store = [&](std::size_t i, std::size_t k, auto number) { result[i][k] = static_cast<double>(number); };
    if (positions.type == ElementType::float32)
        visit_triples<float>(positions, "positions", store);
    else
        visit_triples<double>(positions, "positions", store);
    return result;
}

}  // namespace clsdf::c
