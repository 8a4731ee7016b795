#include "mesh/file_content.hpp"

#include "core/descriptor.hpp"
#include "core/parallel.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <atomic>
#include <cerrno>
#include <system_error>
#include <utility>

namespace clsdf {

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
    throw Error(ErrorCode::unreadable_input, fmt::format("cannot read '{}': {}", path, reason));
}

[[noreturn]] void fail(const std::string& path, int error) {
    fail(path, std::generic_category().message(error));
}

}  // namespace

FileContent::FileContent(std::string path) : path_(std::move(path)) {
    // Not blocking: opening a pipe would wait for its writer.
    const Descriptor file(::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (file.number() < 0) fail(path_, errno);
    struct stat status {};
    if (::fstat(file.number(), &status) != 0) fail(path_, errno);
    if (S_ISDIR(status.st_mode)) fail(path_, EISDIR);
    if (!S_ISREG(status.st_mode)) fail(path_, "it is a device or a pipe, not a file");

    // Read, not mapped: a mapped file that another process cuts short ends the program with a signal. On all cores,
    // into memory on huge pages: most of the time goes into fresh memory and into copying.
    constexpr std::size_t stretch = std::size_t{4} << 20;
    bytes_.resize(static_cast<std::size_t>(status.st_size));
    std::atomic<int> error = 0;
    std::atomic<std::size_t> size = 0;
    for_each_stretch(bytes_.size(), stretch, [&](std::size_t, std::size_t begin, std::size_t end) {
        while (begin < end) {
            const ssize_t count = ::pread(file.number(), bytes_.data() + begin, end - begin, static_cast<off_t>(begin));
            if (count < 0 && errno == EINTR) continue;
            if (count < 0) error = errno;
            if (count <= 0) return;
            begin += static_cast<std::size_t>(count);
            size += static_cast<std::size_t>(count);
        }
    });
    if (error != 0) fail(path_, error);
    if (size != bytes_.size())
        fail(path_, fmt::format("it became shorter, {} instead of {} bytes", size.load(), bytes_.size()));
}

}  // namespace clsdf
