#pragma once

#include "finish/given_faces.hpp"
#include "frusta/mesh_part.hpp"
#include "plan/movable_part.hpp"
#include "plan/restriction.hpp"
#include "surface/open_edges.hpp"

#include <clsdf/topology.hpp>

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clsdf::engine {

/// The part of a mesh that some regions need, and what only the whole mesh tells.
struct RegionPart {
    MeshPart mesh;
    Restriction restriction;
    std::optional<bool> encloses_negative_volume = false;  ///< the whole mesh; nothing if the part cannot tell
    std::optional<GivenFaces> given_faces{};
    std::shared_ptr<const OpenBoundary> boundary{};  ///< of the whole mesh; null if none counts for the sign
    std::shared_ptr<const MovablePart> movable{};    ///< null if its vertices stay where they are
};

/// The facts of the whole mesh that a transform of a part has.
struct SignOfWhole {
    SignRule sign = SignRule::none;
    std::optional<double> floor{};
    Topology topology{};
};

/// A part as bytes, which another process makes it of again: a head with the version, the number of bytes and a hash of
/// them, then the values as this machine has them. The same part has the same bytes. It has no given faces.
std::vector<std::byte> bytes_of(const RegionPart& part, const SignOfWhole& sign);

/// Throws Error(invalid_argument) if the bytes are no part, are not whole, are damaged, or are those of another version
/// or of another kind of machine. Their indices are checked, too.
struct StoredPart {
    RegionPart part;
    SignOfWhole sign;
};
StoredPart part_of_bytes(std::span<const std::byte> bytes);

}  // namespace clsdf::engine
