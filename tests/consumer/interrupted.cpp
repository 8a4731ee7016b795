#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <cstdlib>
#include <filesystem>
#include <iostream>

namespace {

std::size_t markers_in(const std::filesystem::path& folder) {
    std::size_t count = 0;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
        count += entry.path().extension() == ".building" ? 1 : 0;
    return count;
}

}  // namespace

// A program that is interrupted while the core compiles: interrupted FOLDER. clsdf::io finds the core's marker of the
// compilation, so there is one list of unfinished files, in shared libraries, too.
int main(int count, char** arguments) try {
    if (count != 2) return 2;
    const std::filesystem::path folder = arguments[1];
    const clsdf::Device device = clsdf::Device::automatic();
    device.keep_records(folder.string());
    clsdf::CallOptions options;
    options.progress = [&](const clsdf::Progress& progress) {
        if (progress.stage != clsdf::Progress::Stage::compiling || markers_in(folder) == 0) return;
        clsdf::abandon_unfinished_files(true);
        const std::size_t left = markers_in(folder);
        std::cout << left << " markers of compilations are left" << std::endl;
        std::_Exit(left == 0 ? 0 : 3);
    };
    const clsdf::DistanceTransform transform(device, clsdf::make_shape("cube"), {}, options);
    std::cerr << "no compilation had a marker\n";
    return 4;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
