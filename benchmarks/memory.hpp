#pragma once

#include <cstddef>
#include <optional>

namespace clsdf::bench {

/// How far this process' resident memory has grown at most since this object was made. Linux: the kernel's own
/// high-water mark is set back, so that nothing between two looks escapes; memory that the process already held does
/// not count.
class PeakMemory {
public:
    PeakMemory();

    /// Bytes; nothing where the system does not tell.
    std::optional<std::size_t> growth() const;

private:
    std::optional<std::size_t> before_;
};

}  // namespace clsdf::bench
