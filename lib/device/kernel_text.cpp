#include "device/kernel_text.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "kernel_sources.hpp"

namespace clsdf::device {

namespace {

const KernelFile* find_file(std::string_view name, KernelFiles files) {
    const auto found =
        std::find_if(files.begin(), files.end(), [&](const KernelFile& candidate) { return candidate.name == name; });
    return found != files.end() ? &*found : nullptr;
}

void append_file(std::string_view file_name, KernelFiles beside, std::set<std::string_view>& included,
                 std::string& text) {
    const KernelFile* file = find_file(file_name, beside);
    if (file == nullptr) file = find_file(file_name, kernels::files);
    if (file == nullptr)
        throw Error(ErrorCode::device_failure, fmt::format("the kernel file {} is not part of this build", file_name));
    if (!included.insert(file->name).second) return;
    constexpr std::string_view directive = "#include \"";
    for (std::string_view rest = file->text; !rest.empty();) {
        const std::size_t end = std::min(rest.find('\n'), rest.size() - 1);
        const std::string_view line = rest.substr(0, end + 1);
        rest.remove_prefix(end + 1);
        if (line.starts_with(directive)) {
            const std::string_view named = line.substr(directive.size());
            append_file(named.substr(0, named.find('"')), beside, included, text);
        } else {
            text += line;
        }
    }
}

}  // namespace

std::string kernel_text(std::string_view file_name, KernelFiles beside) {
    std::set<std::string_view> included;
    std::string text;
    append_file(file_name, beside, included, text);
    return text;
}

}  // namespace clsdf::device
