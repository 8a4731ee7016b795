#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace clsdf {

/// A file that appears under its final name complete, or not at all: what is written goes to a temporary file in the
/// same folder, and commit() gives it its name. Without commit() nothing is left behind, and a file that had the name
/// before is untouched. What is no regular file (/dev/null, /dev/stdout, a named pipe) is written directly.
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

    /// Where the next bytes go, counted from the first one written; what is skipped is filled later, or with zeros.
    /// Throws where the file is a pipe, unless it is there already.
    void seek(std::uint64_t position);

    /// The name of the file as long as it has none, for libraries that want to open it themselves. What was written to
    /// it must not be overwritten by what they write. Throws where the target is no regular file.
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
    std::string target_;     // where the file goes: path_ with its symbolic links followed
    std::string temporary_;  // empty where the target is written directly
    std::unique_ptr<std::FILE, Close> file_;
    std::uint64_t position_ = 0;
};

}  // namespace clsdf
