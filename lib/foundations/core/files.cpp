#include "core/files.hpp"

#include "core/parallel.hpp"
#include "core/unfinished_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <sys/stat.h>

#include <fcntl.h>
#include <unistd.h>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <string_view>
#include <system_error>

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

namespace {

namespace fs = std::filesystem;

/// A path that names a standard stream stands for the process's own stream: opening it again would restart a redirected
/// file at its beginning.
int standard_stream(const std::string& path) {
    if (path == "/dev/stdout") return STDOUT_FILENO;
    if (path == "/dev/stderr") return STDERR_FILENO;
    return -1;
}

/// The path with its symbolic links followed, even if the last one names a file that does not exist.
std::string without_links(fs::path path) {
    std::error_code error;
    for (int links = 0; links < 40 && fs::is_symlink(path, error); ++links)
        path = path.parent_path() / fs::read_symlink(path, error);
    const fs::path target = fs::weakly_canonical(path, error);
    return error ? path.string() : target.string();
}

}  // namespace

std::string ending_of(const std::string& path) {
    std::string ending = fs::path(path).extension().string();
    for (char& letter : ending)
        if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter + 32);
    return ending;
}

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
    if (path_.empty()) fail(ENOENT);
    if (const int stream = standard_stream(path_); stream >= 0) {
        open_directly(::dup(stream));
        return;
    }
    std::error_code error;
    const fs::file_status status = fs::status(path_, error);
    if (status.type() == fs::file_type::none) fail(error.value());  // e.g. a name that is too long
    if (status.type() == fs::file_type::directory) fail(EISDIR);
    if (fs::exists(status) && status.type() != fs::file_type::regular) {
        open_directly(::open(path_.c_str(), O_WRONLY | O_CLOEXEC));
        return;
    }
    // A rename would replace a write-protected file without a question.
    if (fs::exists(status) && ::access(path_.c_str(), W_OK) != 0) fail(errno);
    open_beside(without_links(path_));
}

void check_writable(const std::string& path) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status))
        AtomicFile(std::string(path));  // without commit() it leaves nothing
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
    // A file that is replaced keeps its access rights.
    if (struct stat earlier{}; ::stat(target.c_str(), &earlier) == 0) ::fchmod(descriptor, earlier.st_mode & 0777U);
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
    AtomicFile* const self = this;
    commit_all({&self, 1});
}

void AtomicFile::commit_all(std::span<AtomicFile* const> files) {
    for (AtomicFile* const file : files) file->close();
    const std::lock_guard lock(UnfinishedFiles::of_process().mutex);
    for (AtomicFile* const file : files) file->rename();
}

void AtomicFile::close() {
    // A second descriptor keeps the file locked until it has its name.
    if (!temporary_.empty() && lock_.emplace(::fcntl(::fileno(file_.get()), F_DUPFD_CLOEXEC, 0)).number() < 0)
        fail(errno);
    // Some file systems report a full disk only here.
    if (std::fclose(file_.release()) != 0) fail(errno);
}

// The caller holds the mutex of UnfinishedFiles.
void AtomicFile::rename() {
    if (temporary_.empty()) return;
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(errno);
    UnfinishedFiles::of_process().names.erase(temporary_);
    temporary_.clear();
    lock_.reset();
}

void AtomicFile::fail(int error) const {
    throw Error(ErrorCode::output_failure,
                fmt::format("cannot write '{}': {}", path_, std::generic_category().message(error)));
}

}  // namespace clsdf
