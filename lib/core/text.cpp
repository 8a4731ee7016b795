#include "core/text.hpp"

#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace clsdf {

std::string quoted(std::string_view text, std::size_t limit) {
    std::string shown(text.substr(0, limit));
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
    return fmt::format("'{}'{}", shown, text.size() > limit ? "..." : "");
}

std::string version() {
    return std::to_string(CLSDF_VERSION_MAJOR) + '.' + std::to_string(CLSDF_VERSION_MINOR) + '.' +
           std::to_string(CLSDF_VERSION_PATCH);
}

}  // namespace clsdf
