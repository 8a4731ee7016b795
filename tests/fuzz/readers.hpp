#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Damaged files: for every file its reader returns a value that keeps its promises, or throws clsdf::Error.
namespace clsdf::fuzz {

/// A reader and its inputs.
struct Reader {
    std::string format;              ///< "off", ...; the folder of corpus/ that holds its kept inputs
    std::string damaged;             ///< name of the file that is damaged
    std::string read;                ///< name of the file that is read; the same, or it names the damaged one
    std::vector<std::string> seeds;  ///< sound files, by the library's own writers
    std::vector<std::pair<std::string, std::string>> beside;  ///< names and contents of sound files beside it
    /// Reads a file and returns the number of bytes of the values. Ends the process by fail() if they break a promise.
    std::function<std::size_t(const std::string& path)> take;
    /// Bytes of the values for each byte of the file, at most.
    std::size_t expansion = 64;
};

/// The formats that reader_of() knows.
std::vector<std::string> formats();

/// The seeds are made in `folder`.
Reader reader_of(const std::string& format, const std::filesystem::path& folder);

/// Seeds, and the inputs that are kept in corpus/: files as they are, or, named *.hex, the bytes that they spell.
std::vector<std::string> sound_and_kept(const Reader& reader);

/// Prints what went wrong and ends the process by SIGABRT, as libFuzzer expects it of a finding.
[[noreturn]] void fail(const std::string& what);

}  // namespace clsdf::fuzz
