#include "bench.hpp"
#include "device_option.hpp"
#include "standard_streams.hpp"
#include "suggestion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::bench::Entry;

namespace {

/// A word that is no file may be a mistyped name. A word with an ending or a folder goes to the reader, whose message
/// says more.
void check_name(const std::string& word) {
    const std::vector<std::string> known = clsdf::bench::mesh_names();
    if (contains(known, word) || word.find_first_of("./") != std::string::npos || std::filesystem::exists(word)) return;
    throw Error(ErrorCode::invalid_argument,
                fmt::format("there is no mesh '{}'{}\nThe names are {}; any other mesh is a file.", word,
                            did_you_mean(nearest_word(word, known)), fmt::join(known, ", ")));
}

}  // namespace

bool contains(const std::vector<std::string>& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

clsdf::Device BenchOptions::open_device() const {
    return ::open_device(device);
}

std::vector<NamedMesh> BenchOptions::load_meshes(const std::vector<std::string>& own_list) const {
    for (const std::string& name : meshes) check_name(name);
    std::vector<NamedMesh> loaded;
    for (const std::string& name : meshes.empty() ? own_list : meshes) try {
            loaded.push_back({clsdf::bench::short_name(name), clsdf::bench::load_mesh(name, folder, measure.seed)});
        } catch (const Error& error) {
            if (!meshes.empty() || error.code() != ErrorCode::unreadable_input) throw;
            print_text("left out: {}\n", error.what());
        }
    return loaded;
}

std::vector<clsdf::bench::Method*> BenchOptions::choose(const std::vector<Entry>& entries) const {
    std::vector<clsdf::bench::Method*> chosen;
    for (const Entry& entry : entries) {
        if (!methods.empty() && !contains(methods, entry.name)) continue;
        if (entry.method)
            chosen.push_back(entry.method.get());
        else if (methods.empty())
            say(fmt::format("{}: {}", entry.name, entry.remedy));
        else
            throw Error(ErrorCode::unsupported, fmt::format("--method {}: {}", entry.name, entry.remedy));
    }
    return chosen;
}

std::int64_t BenchOptions::scaled(std::int64_t resolution) const {
    return quick ? resolution / 8 : resolution;
}

void BenchOptions::say(const std::string& line) const {
    if (!quiet) print_text("{}\n", line);
}
