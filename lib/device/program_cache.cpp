#include "device/program_cache.hpp"

#include "core/files.hpp"
#include "core/unfinished_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <thread>

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view record_mark = "clsdf tested 1\n";
constexpr std::string_view marker_mark = "clsdf builds 1\nattempts ";

constexpr std::chrono::milliseconds poll_interval{20};
// A process that holds a lock for longer hangs; others go on without.
constexpr std::chrono::minutes longest_wait{10};

constexpr const char* record_ending = ".tested";
constexpr const char* marker_ending = ".building";

std::string content_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

void make_folder(const fs::path& folder) {
    if (fs::create_directories(folder)) fs::permissions(folder, fs::perms::owner_all);
}

bool is_trusted(const struct stat& status) {
    return S_ISREG(status.st_mode) && (status.st_uid == ::geteuid() || status.st_uid == 0);
}

/// Opens the marker and locks it; negative if the file system has no locks or the file cannot be had. A marker that
/// was removed while this process waited for its lock is no longer the one that others lock.
int open_locked(const fs::path& path, const std::function<void()>& waiting) {
    const auto begin = std::chrono::steady_clock::now();
    for (;;) {
        const int descriptor = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (descriptor < 0) return -1;
        try {
            while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
                if (errno == EINTR) continue;
                if (errno != EWOULDBLOCK || std::chrono::steady_clock::now() - begin > longest_wait) {
                    ::close(descriptor);
                    return -1;
                }
                if (waiting) waiting();
                std::this_thread::sleep_for(poll_interval);
            }
        } catch (...) {
            ::close(descriptor);
            throw;
        }
        struct stat opened {};
        struct stat named {};
        if (::fstat(descriptor, &opened) != 0 || !is_trusted(opened)) {
            ::close(descriptor);
            return -1;
        }
        if (::lstat(path.c_str(), &named) == 0 && named.st_ino == opened.st_ino && named.st_dev == opened.st_dev)
            return descriptor;
        ::close(descriptor);
    }
}

unsigned attempts_in(int descriptor) {
    std::array<char, 64> buffer{};
    const ssize_t size = ::pread(descriptor, buffer.data(), buffer.size(), 0);
    std::string_view content(buffer.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
    if (!content.starts_with(marker_mark)) return 0;
    content.remove_prefix(marker_mark.size());
    unsigned attempts = 0;
    std::from_chars(content.data(), content.data() + content.size(), attempts);
    return attempts;
}

}  // namespace

std::uint64_t hash_of(std::string_view bytes) {
    std::uint64_t hash = 0xCBF29CE484222325U;
    for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001B3U;
    return hash;
}

bool is_trusted_file(const fs::path& path) {
    struct stat status {};
    return ::lstat(path.c_str(), &status) == 0 && is_trusted(status);
}

fs::path BuildRecords::record_of(const std::string& key) const {
    return folder_ / fmt::format("{:016x}{}", hash_of(key), record_ending);
}

fs::path BuildRecords::marker_of(const std::string& key) const {
    return folder_ / fmt::format("{:016x}{}", hash_of(key), marker_ending);
}

bool BuildRecords::has(const std::string& key) const noexcept {
    if (folder_.empty()) return false;
    try {
        const fs::path path = record_of(key);
        if (!is_trusted_file(path)) return false;
        const std::string content = content_of(path);
        return content.starts_with(record_mark) && content.substr(record_mark.size()) == key;
    } catch (const std::exception&) {
        return false;
    }
}

void BuildRecords::note(const std::string& key) const noexcept {
    if (folder_.empty()) return;
    try {
        make_folder(folder_);
        AtomicFile file(record_of(key).string());
        file.write(record_mark);
        file.write(key);
        file.commit();
    } catch (const std::exception&) {
        // Write-protected, full or gone: the next process tests again.
    }
}

void BuildRecords::forget(const std::string& begin_of_key) const noexcept {
    if (folder_.empty()) return;
    try {
        for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
            const fs::path& path = entry.path();
            const bool is_record = path.extension() == record_ending;
            if ((!is_record && path.extension() != marker_ending) || !is_trusted_file(path)) continue;
            const std::string content = content_of(path);
            // The key begins a line of its own.
            if (content.find('\n' + begin_of_key) == std::string::npos) continue;
            const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
            if (is_record || (file.number() >= 0 && ::flock(file.number(), LOCK_EX | LOCK_NB) == 0))
                ::unlink(path.c_str());
        }
    } catch (const std::exception&) {
        // No folder: nothing to forget.
    }
}

BuildMarker::BuildMarker(const BuildRecords& records, const std::string& key, const std::function<void()>& waiting)
    : key_(key) {
    if (records.folder().empty()) return;
    try {
        make_folder(records.folder());
    } catch (const fs::filesystem_error&) {
        return;
    }
    path_ = records.marker_of(key);
    descriptor_ = open_locked(path_, waiting);
    if (descriptor_ >= 0) earlier_attempts_ = attempts_in(descriptor_);
}

void BuildMarker::begin() {
    begun_ = true;
    if (descriptor_ < 0) return;
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    {
        const std::scoped_lock lock(files.mutex);
        files.markers.insert(path_.native());
    }
    const std::string content = fmt::format("{}{}\n{}", marker_mark, earlier_attempts_ + 1, key_);
    // A disk that is full takes none: then nothing is recognised.
    if (::pwrite(descriptor_, content.data(), content.size(), 0) != static_cast<ssize_t>(content.size()))
        static_cast<void>(!::ftruncate(descriptor_, 0));
}

BuildMarker::~BuildMarker() {
    if (descriptor_ < 0) return;
    UnfinishedFiles& files = UnfinishedFiles::of_process();
    const std::scoped_lock lock(files.mutex);
    if (begun_ || earlier_attempts_ == 0) ::unlink(path_.c_str());
    files.markers.erase(path_.native());
    ::close(descriptor_);
}

std::string one_line(const std::string& identity) {
    std::array<std::string, 6> lines;
    std::size_t begin = 0;
    for (std::string& line : lines) {
        const std::size_t end = std::min(identity.find('\n', begin), identity.size());
        line = identity.substr(begin, end - begin);
        begin = std::min(end + 1, identity.size());
    }
    const auto& [platform, platform_version, vendor, device, device_version, driver] = lines;
    return fmt::format("\"{}\" (platform {}, {}, driver {})", device, platform, platform_version, driver);
}

void build_once(const BuildRecords& records, const BuildSubject& subject, const BuildWatch& watch,
                const std::function<void()>& build, const std::function<bool()>& is_done) {
    const auto is_there = [&] { return is_done ? is_done() : records.has(subject.key); };
    if (is_there()) return;
    BuildMarker marker(records, subject.key, watch.waiting);
    if (is_there()) return;  // the process that was waited for has built it
    if (marker.earlier_attempts() >= BuildMarker::most_attempts)
        throw Error(
            ErrorCode::device_failure,
            fmt::format("{} attempts in a row to compile {} for {} ended the whole process, so it is not tried "
                        "again: its OpenCL compiler may crash. Update that driver, or take another device "
                        "(\"clsdf devices\" lists them, --device or CLSDF_DEVICE chooses). If something else "
                        "ended those processes, \"clsdf devices --prepare --again\" tries once more, or delete "
                        "'{}'",
                        marker.earlier_attempts(), subject.name, one_line(subject.identity), marker.path().string()));
    if (marker.earlier_attempts() > 0 && watch.log)
        watch.log(fmt::format("the last process that compiled {} for {} was ended meanwhile; it is tried once more",
                              subject.name, one_line(subject.identity)));
    marker.begin();
    build();
    if (!is_done) records.note(subject.key);
}

namespace {

namespace fs = std::filesystem;

constexpr std::string_view ending = ".program";

// A file is: the mark, the sizes and a check sum of what follows, the key, the binary. The key is kept in full, because
// two keys may have one name.
constexpr std::string_view mark = "clsdf program 1\n";

struct Header {
    std::uint64_t key_size;
    std::uint64_t binary_size;
    std::uint64_t check_sum;
};

std::optional<ProgramCache::Binary> parse(std::string_view content, std::string_view key) {
    if (!content.starts_with(mark)) return std::nullopt;
    content.remove_prefix(mark.size());
    Header header{};
    if (content.size() < sizeof header) return std::nullopt;
    std::memcpy(&header, content.data(), sizeof header);
    content.remove_prefix(sizeof header);
    if (header.key_size != key.size() || content.size() < key.size() ||
        header.binary_size != content.size() - key.size() || header.check_sum != hash_of(content) ||
        !content.starts_with(key))
        return std::nullopt;
    content.remove_prefix(key.size());
    return ProgramCache::Binary(content.begin(), content.end());
}

/// The time of the last use is that of the last change; once a day is often enough.
void note_use(const fs::path& path) {
    std::error_code ignored;
    const auto now = fs::file_time_type::clock::now();
    if (now - fs::last_write_time(path, ignored) > std::chrono::hours(24)) fs::last_write_time(path, now, ignored);
}

struct StoredFile {
    fs::path path;
    std::uintmax_t size;
    fs::file_time_type used;
};

}  // namespace

fs::path ProgramCache::path_of(const std::string& key) const {
    return folder_ / fmt::format("{:016x}{}", hash_of(key), ending);
}

std::optional<ProgramCache::Binary> ProgramCache::find(const std::string& key) const noexcept {
    if (folder_.empty()) return std::nullopt;
    try {
        const fs::path path = path_of(key);
        if (!is_trusted_file(path) || fs::file_size(path) > limit_) return std::nullopt;
        std::ifstream file(path, std::ios::binary);
        const std::string content((std::istreambuf_iterator<char>(file)), {});
        std::optional<Binary> binary = parse(content, key);
        if (binary) note_use(path);
        return binary;
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

void ProgramCache::store(const std::string& key, std::span<const unsigned char> binary) const noexcept {
    if (folder_.empty() || binary.empty()) return;
    try {
        if (fs::create_directories(folder_)) fs::permissions(folder_, fs::perms::owner_all);
        std::string content = key;
        content.append(reinterpret_cast<const char*>(binary.data()), binary.size());
        const Header header{key.size(), binary.size(), hash_of(content)};
        const fs::path path = path_of(key);
        AtomicFile file(path.string());
        file.write(mark);
        file.write(std::as_bytes(std::span(&header, 1)));
        file.write(content);
        file.commit();
        prune(path);
    } catch (const std::exception&) {
        // Write-protected, full or gone: the next run compiles again.
    }
}

void ProgramCache::prune(const fs::path& newest) const {
    std::error_code ignored;
    std::vector<StoredFile> files;
    std::uintmax_t total = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        const fs::path& path = entry.path();
        const fs::file_time_type used = entry.last_write_time(ignored);
        std::error_code gone;
        const std::uintmax_t size = entry.file_size(gone);
        if (gone || path.extension() != ending) continue;
        files.push_back({path, size, used});
        total += size;
    }
    std::sort(files.begin(), files.end(),
              [](const StoredFile& one, const StoredFile& other) { return one.used < other.used; });
    for (const StoredFile& file : files) {
        if (total <= limit_) break;
        if (file.path == newest) continue;
        fs::remove(file.path, ignored);
        total -= file.size;
    }
}

}  // namespace clsdf::device
