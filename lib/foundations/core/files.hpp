#pragma once

#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace clsdf {

/// The ending of a file's name in lower case, as ".h5"; empty if it has none. Formats are chosen by it.
std::string ending_of(const std::string& path);

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

/// A file that appears under its final name complete, or not at all. Bytes go to a temporary file in the same folder,
/// and commit() gives it its name. Without commit() no file stays, and an earlier file of that name is unchanged. A
/// target that is no regular file (/dev/null, /dev/stdout, a named pipe) is written directly.
///
/// A process that is killed leaves its temporary file; a later one that writes into the folder removes it
/// (core/unfinished_files.hpp).
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

    /// The same for files that belong together. All are closed before the first one gets its name, so a full disk
    /// leaves every earlier file unchanged. A signal that ends the process leaves either all earlier files or none.
    static void commit_all(std::span<AtomicFile* const> files);

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };

    void open_directly(int descriptor);
    void open_beside(const std::string& target);
    void remove_temporary();
    void close();
    void rename();
    [[noreturn]] void fail(int error) const;

    std::string path_;       // as the caller named it, for messages
    std::string target_;     // path_ with its symbolic links followed
    std::string temporary_;  // empty if the target is written directly
    std::unique_ptr<std::FILE, Close> file_;
    std::optional<Descriptor> lock_;  // from close() to rename()
    std::uint64_t position_ = 0;
};

/// Throws as AtomicFile does if the file cannot be written. Leaves nothing. Does not open a pipe or a device, whose
/// reader would take that for the end.
void check_writable(const std::string& path);

}  // namespace clsdf
