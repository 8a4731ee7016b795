#include "mesh/file_content.hpp"

#include "core/descriptor.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
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

    // Read, not mapped: a mapped file that another process cuts short ends the program with a signal.
    const auto length = static_cast<std::size_t>(status.st_size);
    bytes_ = std::make_unique_for_overwrite<char[]>(length);
    while (size_ < length) {
        const ssize_t count = ::read(file.number(), bytes_.get() + size_, length - size_);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail(path_, errno);
        if (count == 0) fail(path_, fmt::format("it became shorter, {} instead of {} bytes", size_, length));
        size_ += static_cast<std::size_t>(count);
    }
}

}  // namespace clsdf
