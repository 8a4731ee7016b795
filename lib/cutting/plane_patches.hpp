#pragma once

#include <clsdf/mesh.hpp>

#include "surface/sign_surface.hpp"

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

namespace clsdf::cutting {

/// Faces of one plane that are joined over edges, as a lid is: its outline cuts other faces of the plane, and the edges
/// within it cut none. Found at the first question: few meshes have faces that lie in each other.
class PlanePatches {
public:
    /// Keeps the arguments.
    PlanePatches(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const SignSurface& surface)
        : vertices_(vertices), triangles_(triangles), surface_(surface) {}

    /// Whether edge k of a face is within its patch. Thread-safe.
    bool is_within(std::uint32_t face, std::size_t k) const {
        std::call_once(once_, [this] { find(); });
        return (unsigned{within_[face]} >> k & 1U) != 0;
    }
    /// The lowest face of a face's patch; the face itself if nobody has asked for edges. Not while others ask.
    std::uint32_t lowest(std::uint32_t face) const { return lowest_.empty() ? face : lowest_[face]; }

private:
    void find() const;

    std::span<const Vec3> vertices_;
    std::span<const Triangle> triangles_;
    const SignSurface& surface_;
    mutable std::once_flag once_;
    mutable std::vector<std::uint8_t> within_;  // bits
    mutable std::vector<std::uint32_t> lowest_;
};

}  // namespace clsdf::cutting
