// write_programs FOLDER writes the programs that the library builds for a GPU, each as a pair of files. NAME.cl is the
// text and NAME.options are the options that clBuildProgram gets. scripts/gpu-compile and the test without_inlining
// read them.
#include "device/context.hpp"
#include "papers/scans.hpp"
#ifdef CLSDF_TEST_PICTURE
#include "picture/tracer.hpp"

#include <clsdf/tuning.hpp>
#endif

#include <fmt/format.h>

#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

using namespace clsdf;

namespace {

namespace fs = std::filesystem;

/// The kernel file with the defined words, but for LANES, which names the body: bricks_by_group-group128-nearest.
std::string name_of(const device::ProgramSource& source) {
    std::string name = fs::path(source.kernel_file).stem().string();
    std::istringstream options(source.options);
    for (std::string option; options >> option;) {
        if (!option.starts_with("-D") || option.starts_with("-DLANES=")) continue;
        name += '-';
        for (const char c : option.substr(2))
            if (c != '=') name += c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return name;
}

void write(const fs::path& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) throw Error(ErrorCode::output_failure, fmt::format("{} cannot be written", path.string()));
}

std::vector<device::ProgramSource> sources_of_gpus() {
    std::vector<device::ProgramSource> sources;
    for (const std::size_t largest_group : {256U, 64U}) {
        device::Context::Capabilities gpu;
        gpu.rounds_roots = true;
        gpu.largest_group = largest_group;
        const engine::ProgramSources programs(gpu, KernelBody::automatic);
        const std::vector<device::ProgramSource> added = programs.every_source();
        sources.insert(sources.end(), added.begin(), added.end());
        for (const engine::BrickVariant& variant : engine::every_variant()) {
            sources.push_back(papers::brute_force_source(programs, variant));
            for (const bool key_64 : {false, true})
                if (variant.nearest || !key_64) sources.push_back(papers::slices_source(programs, {variant, key_64}));
        }
    }
#ifdef CLSDF_TEST_PICTURE
    sources.push_back(picture::tracer_source());
#endif
    return sources;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        fmt::print(stderr, "usage: write_programs FOLDER\n");
        return 2;
    }
    try {
        const fs::path folder = argv[1];
        fs::create_directories(folder);
        for (const device::ProgramSource& source : sources_of_gpus()) {
            write(folder / (name_of(source) + ".cl"), device::kernel_text(source.kernel_file, source.files));
            write(folder / (name_of(source) + ".options"), source.options);
        }
    } catch (const std::exception& error) {
        fmt::print(stderr, "write_programs: {}\n", error.what());
        return 5;
    }
    return 0;
}
