#pragma once

#include <cstddef>
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

}  // namespace clsdf::bench
