#pragma once

#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <span>

namespace clsdf {

/// A file descriptor that is closed at the end of its scope; negative if there is none.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    int number() const { return number_; }

private:
    int number_;
};

/// The result of a read: the number of bytes read, and the system's error number, or 0.
struct ReadResult {
    std::size_t bytes = 0;
    int error = 0;
};

/// Fills `room` with the bytes of a file from `offset` on, on all cores. Reads fewer bytes if the file ends before or
/// cannot be read.
ReadResult read_in_parallel(const Descriptor& file, std::uint64_t offset, std::span<std::byte> room);

}  // namespace clsdf
