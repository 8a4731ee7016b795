#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace clsdf {

/// A file that appears under its final name complete, or not at all. Bytes go to a temporary file in the same folder,
/// and commit() gives it its name. Without commit() no file stays, and an earlier file of that name is unchanged. A
/// target that is no regular file (/dev/null, /dev/stdout, a named pipe) is written directly.
///
/// A process that is killed leaves its temporary file; a later one that writes into the folder removes it, see
/// unfinished_files.hpp.
///
/// Every function throws Error(output_failure) that names the file and the system's reason.
class AtomicFile {
public:
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::span<const std::byte> bytes);
    void write(std::string_view text);

    /// Sets the position of the next bytes, counted from the first byte written. A gap may be filled later; else it has
    /// zeros. Throws if the file is a pipe and the position changes.
    void seek(std::uint64_t position);

    /// The temporary name of the file, for libraries that open it themselves. They must not overwrite bytes that were
    /// written before. Throws if the target is no regular file.
    const std::string& temporary() const;

    /// Closes the file and gives it its final name. Nothing may be written afterwards.
    void commit();

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };

    void open_directly(int descriptor);
    void open_beside(const std::string& target);
    void remove_temporary();
    [[noreturn]] void fail(int error) const;

    std::string path_;       // as the caller named it, for messages
    std::string target_;     // path_ with its symbolic links followed
    std::string temporary_;  // empty if the target is written directly
    std::unique_ptr<std::FILE, Close> file_;
    std::uint64_t position_ = 0;
};

}  // namespace clsdf
