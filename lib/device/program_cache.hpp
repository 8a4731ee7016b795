#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clsdf::device {

/// Small files in a folder: records of what was built and tested with success, and markers of what is being built. Keys
/// are texts of a few lines; a record's file holds its key. A file that cannot be read counts as missing,
/// and a file that cannot be written is not kept. Any number of threads and processes may use one folder.
class BuildRecords {
public:
    /// An empty folder keeps nothing. The folder is made when the first file is written.
    explicit BuildRecords(std::filesystem::path folder) : folder_(std::move(folder)) {}

    const std::filesystem::path& folder() const { return folder_; }

    /// Whether note() was called with the very same key, by this user or root.
    bool has(const std::string& key) const noexcept;
    void note(const std::string& key) const noexcept;
    /// Forgets all records and markers whose key begins like that, but markers that a living process holds.
    void forget(const std::string& begin_of_key) const noexcept;

    std::filesystem::path record_of(const std::string& key) const;
    std::filesystem::path marker_of(const std::string& key) const;

private:
    std::filesystem::path folder_;
};

/// The marker of a build: a file that is written before the build and removed after it, also by an exception. Its
/// writer holds a file lock on it, so that one process builds while others wait, and so that a marker without a lock
/// tells that its writer was ended during the build, e.g. by the OpenCL compiler. The marker counts such attempts.
class BuildMarker {
public:
    /// So many attempts in a row that did not end: a further one is refused. One is not enough, because a user may have
    /// killed the process while it compiled.
    static constexpr unsigned most_attempts = 2;

    /// Waits for other processes and threads that build the same; `waiting`, which may be empty and may throw, is
    /// called again and again meanwhile. Does nothing if the records have no folder, or the file system no locks.
    BuildMarker(const BuildRecords& records, const std::string& key, const std::function<void()>& waiting = {});
    /// Removes the marker.
    ~BuildMarker();
    BuildMarker(const BuildMarker&) = delete;
    BuildMarker& operator=(const BuildMarker&) = delete;

    /// Attempts before this one, in a row, whose process was ended.
    unsigned earlier_attempts() const { return earlier_attempts_; }
    const std::filesystem::path& path() const { return path_; }

    /// Writes this attempt into the marker. If it is never called, a marker of earlier attempts stays unchanged.
    void begin();

private:
    std::string key_;
    std::filesystem::path path_;
    int descriptor_ = -1;
    unsigned earlier_attempts_ = 0;
    bool begun_ = false;
};

/// Callbacks of a build, on the thread that waits for it. Each may be empty, and may throw.
struct BuildWatch {
    std::function<void()> begins{};   ///< a program is compiled, or a part of one
    std::function<void()> waiting{};  ///< called again and again while another process builds the same
    std::function<void(const std::string& message)> log{};
};

struct BuildSubject {
    std::string key;       ///< of its record and marker
    std::string name;      ///< for messages
    std::string identity;  ///< of the device, see Context::identity()
};

/// Runs build() if is_done() is false. One of all processes that share the folder builds; the others wait for it. If
/// is_done is empty, the records decide: build() runs if they lack the subject's key, which is noted afterwards. A
/// marker tells the next process if build() ended this one. Throws Error(device_failure) that names the device and the
/// remedy if BuildMarker::most_attempts earlier ones did.
void build_once(const BuildRecords& records, const BuildSubject& subject, const BuildWatch& watch,
                const std::function<void()>& build, const std::function<bool()>& is_done = {});

/// "platform A, version B, device C, driver D" from the lines of Context::identity().
std::string one_line(const std::string& identity);

/// FNV-1a (Fowler, Noll, Vo) of 64 bits.
std::uint64_t hash_of(std::string_view bytes);

/// Whether the path is a regular file, no link, of this user or of root: others may have written anything.
bool is_trusted_file(const std::filesystem::path& path);

/// Compiled programs in a folder, a file each. Nothing here fails: what cannot be read, or is not whole, is not there,
/// and what cannot be written is not kept. Any number of threads and processes may use one folder.
class ProgramCache {
public:
    using Binary = std::vector<unsigned char>;

    static constexpr std::uintmax_t default_limit = std::uintmax_t{64} << 20;

    /// An empty folder keeps nothing. The folder is made when the first program is stored.
    explicit ProgramCache(std::filesystem::path folder, std::uintmax_t limit = default_limit)
        : folder_(std::move(folder)), limit_(limit) {}

    const std::filesystem::path& folder() const { return folder_; }

    /// The program stored under the very same key, if it is whole and belongs to this user or to root.
    std::optional<Binary> find(const std::string& key) const noexcept;

    /// Replaces what was stored under the key, and deletes the programs that were not used for longest while all of
    /// them take more than the limit.
    void store(const std::string& key, std::span<const unsigned char> binary) const noexcept;

    /// The path of a key's program.
    std::filesystem::path path_of(const std::string& key) const;

private:
    void prune(const std::filesystem::path& newest) const;

    std::filesystem::path folder_;
    std::uintmax_t limit_;
};

}  // namespace clsdf::device
