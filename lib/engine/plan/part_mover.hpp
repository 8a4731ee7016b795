#pragma once

#include "frusta/homed_mesh.hpp"
#include "homes/kept.hpp"
#include "plan/movable_part.hpp"

#include <clsdf/calls.hpp>
#include <clsdf/mesh.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf::engine {

/// A part of a mesh at new positions, with the values of the whole mesh that it has.
struct MovedPart {
    Box box;                      ///< of the whole mesh
    std::vector<Vec3> positions;  ///< of the part's vertices
    Frusta frusta;                ///< sums are those of the faces that the part is made with
    SurfaceSample sample;
    std::shared_ptr<const OpenBoundary> boundary{};  ///< null if none counts
    std::optional<bool> encloses_negative_volume{};
};

/// Makes a part of a mesh again at new positions, with the bytes that the whole mesh would give it: the frusta of the
/// part's faces and their neighbours are made in the way in which the device makes those of a whole mesh.
class PartMover {
public:
    PartMover(const DeviceTools& tools, std::shared_ptr<const MovablePart> movable)
        : tools_(tools), movable_(std::move(movable)) {}
    PartMover(const PartMover&) = delete;
    PartMover& operator=(const PartMover&) = delete;

    const std::shared_ptr<const MovablePart>& movable() const { return movable_; }

    /// positions: of the vertices of MovablePart::mesh. topology, surface: of the part. Throws Error(invalid_argument)
    /// if there are not as many, if one is farther than the margin from its first place, if joined vertices move apart,
    /// or if one moves down to the floor of the sign rule `below`; Error(invalid_mesh) if one is not finite.
    MovedPart moved(std::span<const Vec3> positions, const MeshTopology& topology, const SignSurface& surface);

    KeptMemory memory() const;

private:
    Box checked_box(std::span<const Vec3> positions) const;
    /// The frusta of the part, of those of all faces.
    Frusta part_of(const Frusta& all, const MeshTopology& topology, std::span<const Vec3> positions) const;

    DeviceTools tools_;
    std::shared_ptr<const MovablePart> movable_;
    KeptValues kept_;                   // of the next
    std::unique_ptr<HomedMesh> faces_;  // of MovablePart::mesh, from the first move on
};

}  // namespace clsdf::engine
