#pragma once

#include <clsdf.h>

#include <clsdf/mesh.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// A mesh in the caller's arrays, and copies that the library's own forms need.
namespace clsdf::c {

class MeshArrays {
public:
    explicit MeshArrays(const clsdf_mesh_arrays* arrays);
    MeshArrays(const MeshArrays&) = delete;
    MeshArrays& operator=(const MeshArrays&) = delete;

    const MeshView& view() const { return *view_; }
    std::int32_t index_base() const { return index_base_; }
    const std::string& name() const { return name_; }

private:
    std::vector<Triangle> triangles_;  ///< from 0, if the caller's count from 1
    std::optional<MeshView> view_;
    std::int32_t index_base_ = 0;
    std::string name_;
};

}  // namespace clsdf::c
