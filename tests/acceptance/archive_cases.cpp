#include "acceptance/cases.hpp"

#include <clsdf/error.hpp>
#include <clsdf/io.hpp>
#include <clsdf/topology.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace clsdf::acceptance {

namespace {

/// The closed meshes of the benchmarks.
constexpr std::array judged{"bunny00", "refined_elephant", "armadillo", "fandisk_large", "knot2"};

/// Balanced meshes of different kinds: scans, sculptures, machine parts, thin and long ones, one not manifold
/// (diplodocus), one inside out (ellipe0.003).
constexpr std::array varied{"elephant", "anchor_dense", "rotor",  "blobby",     "camel",       "cow",    "dragknob",
                            "helmet",   "joint",        "pinion", "diplodocus", "ellipe0.003", "turbine"};

/// Open meshes, and soups (polygon_mesh, pig.stl) whose triangles do not meet.
constexpr std::array open{"mannequin-devil", "ChineseDragon-10kv", "elephant-with-holes", "polygon_mesh", "b9_mesh",
                          "pig.stl"};

/// Fewer samples each, because the remaining meshes are many.
constexpr Setting setting_of_others{128, 0.03};

Problem read_problem(const std::filesystem::path& path, const Setting& setting) {
    Mesh mesh = read_mesh(path.string());
    const SignRule sign = describe_topology(mesh).closed ? SignRule::automatic : SignRule::none;
    return problem(std::move(mesh), setting, sign);
}

Case case_of(const char* kind, const std::filesystem::path& path, const Setting& setting) {
    return {kind, fmt::format("{}, {}", path.stem().string(), name_of(setting)),
            [=] { return read_problem(path, setting); }};
}

std::filesystem::path path_of(const std::filesystem::path& folder, const std::string& name) {
    return folder / (name.ends_with(".stl") ? name : name + ".off");
}

bool is_mesh_file(const std::filesystem::path& path) {
    const std::string ending = path.extension().string();
    return ending == ".off" || ending == ".obj" || ending == ".stl" || ending == ".ply";
}

void add_others(const std::filesystem::path& folder, const std::set<std::filesystem::path>& named,
                ArchiveCases& result) {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (is_mesh_file(entry.path()) && !named.contains(entry.path())) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    for (const std::filesystem::path& path : paths) {
        try {
            const bool closed = describe_topology(read_mesh(path.string())).closed;
            const char* kind = closed ? "other closed mesh" : "other open mesh or soup";
            Case other = case_of(kind, path, setting_of_others);
            other.name = fmt::format("{}, {}", path.filename().string(), name_of(setting_of_others));
            result.cases.push_back(std::move(other));
        } catch (const Error& error) {
            result.unreadable.emplace_back(path.filename().string() + ": " + error.what());
        }
    }
}

}  // namespace

ArchiveCases archive_cases(const std::filesystem::path& folder) {
    ArchiveCases result;
    std::set<std::filesystem::path> named;
    const auto add = [&](const char* kind, const std::string& name) {
        const std::filesystem::path path = path_of(folder, name);
        named.insert(path);
        for (const Setting& setting : {Setting{96, 0.10}, {192, 0.03}, {256, 0.01}, {256, 0.10}})
            result.cases.push_back(case_of(kind, path, setting));
    };
    for (const char* name : judged) add("closed mesh", name);
    for (const char* name : varied) add("closed mesh", name);
    for (const char* name : open) add("open mesh or soup", name);
    add_others(folder, named, result);
    return result;
}

}  // namespace clsdf::acceptance
