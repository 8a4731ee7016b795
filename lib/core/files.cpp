#include "core/files.hpp"

#include "core/parallel.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
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

namespace {

constexpr std::string_view beginning = ".clsdf-";
constexpr std::string_view ending = ".part";

/// Magic numbers of statfs(2): ext2 to ext4, XFS, Btrfs, F2FS, ZFS, bcachefs, tmpfs and overlays. On a file system that
/// several machines share, a lock may cover this machine's processes only, and may wait for a server.
constexpr std::array<std::uint32_t, 8> file_systems_of_one_machine{0xEF53,     0x58465342, 0x9123683E, 0xF2F52010,
                                                                   0x2FC12FC1, 0xCA451A4E, 0x01021994, 0x794C7630};

bool is_of_one_machine(int descriptor) {
    struct statfs status {};
    return ::fstatfs(descriptor, &status) == 0 &&
           std::ranges::count(file_systems_of_one_machine, static_cast<std::uint32_t>(status.f_type)) > 0;
}

/// ".clsdf-PID-N.part".
bool is_name_of_unfinished(std::string_view name) {
    if (!name.starts_with(beginning) || !name.ends_with(ending)) return false;
    name.remove_prefix(beginning.size());
    name.remove_suffix(ending.size());
    return std::ranges::count(name, '-') == 1 && name.front() != '-' && name.back() != '-' &&
           name.find_first_not_of("0123456789-") == std::string_view::npos;
}

bool is_removed(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && status.st_nlink == 0;
}

/// Whether the path still names the open file. Only the holder of its lock removes or renames a file.
bool is_named(int descriptor, const std::string& path) {
    struct stat opened {};
    struct stat named {};
    return ::fstat(descriptor, &opened) == 0 && ::lstat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
           opened.st_ino == named.st_ino;
}

bool is_own_file(int descriptor) {
    struct stat status {};
    return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid();
}

bool try_to_lock(int descriptor) {
    while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
        if (errno != EINTR) return false;
    return true;
}

/// Whether this is the process's first file in the folder.
bool is_first_file_in(const fs::path& folder) {
    static std::mutex mutex;
    static std::set<std::string>& known = *new std::set<std::string>;
    std::error_code error;
    const std::string path = fs::absolute(folder, error).string();
    const std::lock_guard lock(mutex);
    return !error && known.insert(path).second;
}

}  // namespace

UnfinishedFiles& UnfinishedFiles::of_process() {
    static UnfinishedFiles& files = *new UnfinishedFiles;
    return files;
}

int create_unfinished_file(const fs::path& folder, std::string& name) {
    if (const fs::path here = folder.empty() ? "." : folder; is_first_file_in(here)) remove_stale_files(here);
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    const std::lock_guard lock(files.mutex);
    for (unsigned attempt = 0;; ++attempt) {
        // Not derived from the target's name, which may already have the greatest length.
        name = (folder / fmt::format("{}{}-{}{}", beginning, ::getpid(), attempt, ending)).string();
        const int descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor < 0 && errno == EEXIST) continue;
        if (descriptor < 0) return descriptor;
        // Another process may have removed it as stale before it was locked.
        if (is_of_one_machine(descriptor) && (!try_to_lock(descriptor) || is_removed(descriptor))) {
            ::close(descriptor);
            continue;
        }
        files.names.insert(name);
        return descriptor;
    }
}

void remove_stale_files(const fs::path& folder) noexcept {
    try {
        const Descriptor opened_folder(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (opened_folder.number() < 0 || !is_of_one_machine(opened_folder.number())) return;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            if (!is_name_of_unfinished(entry.path().filename().string())) continue;
            const std::string path = entry.path().string();
            const Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
            if (file.number() >= 0 && is_own_file(file.number()) && try_to_lock(file.number()) &&
                is_named(file.number(), path))
                ::unlink(path.c_str());
        }
    } catch (const std::exception&) {
        // A file that cannot be removed does no harm.
    }
}

void UnfinishedFiles::abandon(bool is_interrupted) noexcept {
    mutex.lock();  // for ever: nothing may be created or renamed from here on
    for (const std::string& name : names) ::unlink(name.c_str());
    if (!is_interrupted) return;
    for (const std::string& marker : markers) ::unlink(marker.c_str());
}

}  // namespace clsdf
