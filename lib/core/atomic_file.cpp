#include "core/atomic_file.hpp"

#include "core/descriptor.hpp"
#include "core/unfinished_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>
#include <cerrno>
#include <filesystem>
#include <system_error>

namespace clsdf {

namespace {

namespace fs = std::filesystem;

/// A path that names a standard stream stands for the process's own stream: opening it again would restart a redirected
/// file at its beginning.
int standard_stream(const std::string& path) {
    if (path == "/dev/stdout") return STDOUT_FILENO;
    if (path == "/dev/stderr") return STDERR_FILENO;
    return -1;
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
    if (path_.empty()) fail(ENOENT);
    if (const int stream = standard_stream(path_); stream >= 0) {
        open_directly(::dup(stream));
        return;
    }
    std::error_code error;
    const fs::file_status status = fs::status(path_, error);
    if (status.type() == fs::file_type::directory) fail(EISDIR);
    if (fs::exists(status) && status.type() != fs::file_type::regular) {
        open_directly(::open(path_.c_str(), O_WRONLY | O_CLOEXEC));
        return;
    }
    // A rename would replace a write-protected file without a question.
    if (fs::exists(status) && ::access(path_.c_str(), W_OK) != 0) fail(errno);
    const fs::path target = fs::weakly_canonical(path_, error);
    open_beside(error ? path_ : target.string());
}

AtomicFile::~AtomicFile() {
    if (!temporary_.empty()) remove_temporary();
}

void AtomicFile::remove_temporary() {
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    const std::lock_guard lock(files.mutex);
    ::unlink(temporary_.c_str());
    files.names.erase(temporary_);
}

void AtomicFile::open_directly(int descriptor) {
    if (descriptor < 0) fail(errno);
    file_.reset(::fdopen(descriptor, "wb"));
    if (!file_) {
        const int error = errno;
        ::close(descriptor);
        fail(error);
    }
}

void AtomicFile::open_beside(const std::string& target) {
    target_ = target;
    const fs::path folder = fs::path(target).parent_path();
    std::error_code error;
    if (!folder.empty() && !fs::is_directory(folder, error))
        throw Error(ErrorCode::output_failure,
                    fmt::format("cannot write '{}': there is no folder '{}'", path_, folder.string()));
    std::string name;
    const int descriptor = create_unfinished_file(folder, name);
    if (descriptor < 0) fail(errno);
    temporary_ = name;
    try {
        open_directly(descriptor);
    } catch (...) {
        remove_temporary();
        throw;
    }
}

void AtomicFile::write(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail(errno);
    position_ += bytes.size();
}

void AtomicFile::write(std::string_view text) {
    write(std::as_bytes(std::span(text)));
}

void AtomicFile::seek(std::uint64_t position) {
    if (position == position_) return;
    // The seek is relative, because a redirected stream may have begun anywhere.
    const auto step = static_cast<off_t>(position) - static_cast<off_t>(position_);
    if (::fseeko(file_.get(), step, SEEK_CUR) != 0) fail(errno);
    position_ = position;
}

const std::string& AtomicFile::temporary() const {
    if (temporary_.empty())
        throw Error(ErrorCode::output_failure,
                    fmt::format("cannot write '{}': this format needs a regular file, and it is none", path_));
    return temporary_;
}

void AtomicFile::commit() {
    // A second descriptor keeps the file locked until it has its name.
    const Descriptor locked(temporary_.empty() ? -1 : ::fcntl(::fileno(file_.get()), F_DUPFD_CLOEXEC, 0));
    if (!temporary_.empty() && locked.number() < 0) fail(errno);
    // Some file systems report a full disk only here.
    if (std::fclose(file_.release()) != 0) fail(errno);
    if (temporary_.empty()) return;
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    const std::lock_guard lock(files.mutex);
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
    files.names.erase(temporary_);
    temporary_.clear();
}

void AtomicFile::fail(int error) const {
    throw Error(ErrorCode::output_failure,
                fmt::format("cannot write '{}': {}", path_, std::generic_category().message(error)));
}

}  // namespace clsdf
