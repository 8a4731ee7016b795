#include "io/meshes/face_groups.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>
#include <utility>

namespace clsdf {

std::string name_in(TextScanner& scanner) {
    std::string name;
    for (std::string_view word = scanner.word(); !word.empty(); word = scanner.word())
        name.append(name.empty() ? "" : " ").append(word);
    return name;
}

std::uint32_t NamedGroups::number_of(const std::string& name) {
    const auto [found, is_new] = numbers_.try_emplace(name, static_cast<std::uint32_t>(groups_.names.size()));
    if (is_new) groups_.names.push_back(name);
    return found->second;
}

void NamedGroups::add(const std::string& name, std::size_t triangles) {
    if (triangles > 0) groups_.numbers.insert(groups_.numbers.end(), triangles, number_of(name));
}

void NamedGroups::add_file(const std::string& path, const FaceGroups& groups, std::size_t triangles) {
    // Files of one name in different folders stay apart.
    const std::string stem = std::filesystem::path(path).stem().string();
    std::string file = stem;
    for (std::size_t other = 2; !files_.insert(file).second; ++other) file = fmt::format("{}_{}", stem, other);
    if (groups.names.size() <= 1) return add(file, triangles);
    std::vector<std::uint32_t> numbers;
    for (const std::string& name : groups.names)
        numbers.push_back(number_of(name.empty() ? file : fmt::format("{}/{}", file, name)));
    for (const std::uint32_t number : groups.numbers) groups_.numbers.push_back(numbers[number]);
}

FaceGroups NamedGroups::take() {
    if (groups_.names.size() == 1 && groups_.names[0].empty()) return {};
    return std::move(groups_);
}

FaceGroups groups_of(std::span<const GroupRun> runs, std::size_t triangles) {
    NamedGroups groups;
    if (runs.empty()) return {};
    groups.add({}, runs[0].first_triangle);
    for (std::size_t i = 0; i < runs.size(); ++i) {
        const std::size_t end = i + 1 < runs.size() ? runs[i + 1].first_triangle : triangles;
        groups.add(runs[i].name, end - runs[i].first_triangle);
    }
    return groups.take();
}

}  // namespace clsdf
