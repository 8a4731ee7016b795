// write_bundle_stand_in FOLDER makes a folder with the form of a bundled driver, for tests: the installed PoCL, and the
// programs of a field without other outputs.
#include "device/context.hpp"
#include "device/prepared_programs.hpp"
#include "support/pocl.hpp"

#include <clsdf/clsdf.hpp>

#include <fmt/format.h>

#include <filesystem>

using namespace clsdf;

namespace {

namespace fs = std::filesystem;

void write_to(const fs::path& folder) {
    const Device device = Device::select("Portable Computing Language");
    const fs::path driver = test::file_of_pocl();
    if (driver.empty()) throw Error(ErrorCode::unsupported, "PoCL is loaded, and its file has another name");
    fs::remove_all(folder);
    const std::string level =
        device::guarded([&] { return device::processor_level(device::context_of(device).device()); });
    device.write_programs(folder / "programs" / level);
    const Mesh mesh = make_shape("cube");
    const Band band = Band::symmetric(0.2);
    DistanceTransform(device, mesh).compile(Grid::around(mesh, 32, band), band, {});
    fs::create_symlink(driver, folder / "libclsdf_pocl.so");
    // Debian's PoCL has its devices in files of their own, which it looks for beside itself.
    fs::create_symlink(driver.parent_path() / "pocl", folder / "pocl");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        fmt::print(stderr, "usage: write_bundle_stand_in FOLDER\n");
        return 2;
    }
    try {
        write_to(argv[1]);
    } catch (const std::exception& error) {
        fmt::print(stderr, "write_bundle_stand_in: {}\n", error.what());
        return 5;
    }
    return 0;
}
