#pragma once

#include <clsdf/clsdf.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

namespace clsdf::bench {

/// The largest growth of this process' resident memory since the object was made. On Linux the kernel's own high-water
/// mark is reset, so short peaks count, too. Memory that the process already held does not count.
class PeakMemory {
public:
    PeakMemory();

    /// Bytes; nothing if unknown.
    std::optional<std::size_t> growth() const;

private:
    std::optional<std::size_t> before_;
};

/// The resident bytes of a process after a field, without the field's array: for a whole transform, and for one that is
/// restricted to an eighth of the domain.
struct RestrictedMemory {
    std::size_t triangles = 0;
    std::size_t without_mesh = 0;  ///< after the same calls for a small mesh, whose transform has ended
    std::size_t whole = 0;
    std::size_t restricted = 0;
    std::size_t whole_kept = 0;  ///< by DistanceTransform::memory(), on the host and on the device
    std::size_t restricted_kept = 0;
    std::size_t samples = 0;    ///< of the eighth
    std::size_t different = 0;  ///< of these, the samples whose bytes are not those of the whole transform

    double share() const { return static_cast<double>(restricted) / static_cast<double>(whole); }
    double kept_share() const { return static_cast<double>(restricted_kept) / static_cast<double>(whole_kept); }
    double share_without_mesh() const {
        return (static_cast<double>(restricted) - static_cast<double>(without_mesh)) /
               (static_cast<double>(whole) - static_cast<double>(without_mesh));
    }
};

/// `load` makes the mesh, which ends before memory is read. The domain has `resolution` samples on its longest side,
/// and a band of 3 voxels. The eighth has the largest coordinates, so that its rows cross another eighth before it.
/// Throws Error(unsupported) if the system does not state the resident memory.
RestrictedMemory measure_restricted_memory(const std::function<Mesh()>& load, const Device& device,
                                           std::int64_t resolution);

}  // namespace clsdf::bench
