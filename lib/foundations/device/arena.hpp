#pragma once

#include "device/free_ranges.hpp"
#include "device/opencl.hpp"

#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

namespace clsdf::device {

/// Memory in a device of its own that transforms take parts of: to make, touch and release a buffer takes longer than a
/// small kernel. Small parts lie in blocks, as sub-buffers; a large part is a buffer of its own. Blocks of which no
/// part is lent, and large buffers that no transform uses, are kept for the next transform. They are few enough not to
/// be missed; if memory is short, all are released.
///
/// Commands in the context's queue may still use a part that comes back. The next user enqueues after them.
class Arena {
public:
    // NOLINTNEXTLINE(bugprone-exception-escape): OpenCL's binding would throw from a move if a release fails
    struct Part {
        cl::Buffer buffer;
        std::size_t bytes = 0;
    };

    /// Without limits there are no blocks, and nothing is kept.
    struct Limits {
        std::size_t kept_bytes = 0;   ///< the most that is kept while no transform uses it
        std::size_t block_bytes = 0;  ///< of a block
        std::size_t alignment = 1;    ///< of a part in its block
    };
    void set_limits(const Limits& limits) { limits_ = limits; }

    /// A part of at least `wanted` bytes, without a new buffer; a large one is not far larger. Throws cl::Error.
    std::optional<Part> take(std::size_t wanted);
    /// The size of the block to add for a part of so many bytes; 0: it is to be a buffer of its own.
    std::size_t block_for(std::size_t wanted) const {
        return wanted <= limits_.block_bytes / 2 ? limits_.block_bytes : 0;
    }
    void add_block(cl::Buffer buffer, std::size_t bytes);
    /// Takes a part back, or a buffer of its own.
    void keep(Part part) noexcept;
    /// Releases what no transform uses. Returns its bytes.
    std::size_t release();
    /// Bytes of the device's memory that are not lent.
    std::size_t free_bytes() const;

private:
    // NOLINTNEXTLINE(bugprone-exception-escape): as above
    struct Block {
        cl::Buffer buffer;
        std::size_t bytes;
        FreeRanges free;
    };
    struct Place {
        cl_mem block;
        std::size_t offset, bytes;
    };

    std::optional<Part> take_in_blocks(std::size_t wanted);
    void give_back(const Place& place);
    /// Releases what was kept longest until no more than `most` bytes are kept. Returns the bytes that were released.
    std::size_t keep_within(std::size_t most);

    Limits limits_;
    mutable std::mutex mutex_;
    std::vector<Part> large_;  // kept longest first
    std::vector<Block> blocks_;
    std::map<cl_mem, Place> lent_;  // by the sub-buffer
};

/// The smallest that is large enough, and not so large that its memory would be wasted; the end if there is none.
template <class Buffers>
auto smallest_fit(Buffers& buffers, std::size_t wanted) {
    auto best = buffers.end();
    for (auto it = buffers.begin(); it != buffers.end(); ++it)
        if (it->bytes >= wanted && it->bytes <= 2 * wanted + 4096 && (best == buffers.end() || it->bytes < best->bytes))
            best = it;
    return best;
}

}  // namespace clsdf::device
