#include "mesh/file_content.hpp"

#include "core/descriptor.hpp"
#include "core/parallel_read.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <cerrno>
#include <span>
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
    bytes_.resize(static_cast<std::size_t>(status.st_size));
    const ReadResult result =
        read_in_parallel(file, 0, std::as_writable_bytes(std::span(bytes_.data(), bytes_.size())));
    if (result.error != 0) fail(path_, result.error);
    if (result.bytes != bytes_.size())
        fail(path_, fmt::format("it became shorter, {} instead of {} bytes", result.bytes, bytes_.size()));
}

}  // namespace clsdf
