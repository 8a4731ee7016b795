#include "picture/picture_file.hpp"

#include "core/atomic_file.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

namespace clsdf::picture {

namespace fs = std::filesystem;

std::string ending_of(const std::string& path, std::initializer_list<std::string_view> endings) {
    std::string ending = fs::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](char letter) {
        return letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter + 32) : letter;
    });
    if (std::find(endings.begin(), endings.end(), ending) == endings.end())
        throw Error(ErrorCode::unsupported, fmt::format("{}: no picture format ends in \"{}\"; choose {}", path, ending,
                                                        fmt::join(endings, " or ")));
    return ending;
}

void check_writable(const std::string& path) {
    std::error_code ignored;
    const fs::file_status status = fs::status(path, ignored);
    if (!fs::exists(status) || fs::is_regular_file(status) || fs::is_directory(status))
        AtomicFile(std::string(path));  // without commit() it leaves nothing
}

void write_file(const std::string& path, const std::string& bytes) {
    AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

}  // namespace clsdf::picture
