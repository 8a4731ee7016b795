#include "core/descriptor.hpp"

#include "core/parallel.hpp"

#include <unistd.h>
#include <atomic>
#include <cerrno>

namespace clsdf {

ReadResult read_in_parallel(const Descriptor& file, std::uint64_t offset, std::span<std::byte> room) {
    constexpr std::size_t chunk = std::size_t{4} << 20;  // bytes read by one core at a time
    std::atomic<std::size_t> bytes = 0;
    std::atomic<int> error = 0;
    for_each_chunk(room.size(), chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
        while (begin < end) {
            const ssize_t count =
                ::pread(file.number(), room.data() + begin, end - begin, static_cast<off_t>(offset + begin));
            if (count < 0 && errno == EINTR) continue;
            if (count < 0) error = errno;
            if (count <= 0) return;
            begin += static_cast<std::size_t>(count);
            bytes += static_cast<std::size_t>(count);
        }
    });
    return {bytes, error};
}

}  // namespace clsdf
