#include "device/find/bundled_driver.hpp"

#include "core/tuning_variables.hpp"
#include "device/find/opened_driver.hpp"
#include "device/opencl.hpp"
#include "device/prepared_programs.hpp"

#include <clsdf/error.hpp>

#include <atomic>
#include <system_error>

#if defined(CLSDF_BUNDLED_DRIVER) && defined(__GLIBC__)
#include <dlfcn.h>
#include <link.h>
#endif

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

/// Set when the driver has been opened.
std::atomic<cl_platform_id> opened = nullptr;

#if defined(CLSDF_BUNDLED_DRIVER) && defined(__GLIBC__)
/// The folder `driver` beside that of the program or shared library that contains this function; empty if that is
/// unknown.
fs::path folder_of_package() {
    Dl_info info{};
    void* map = nullptr;
    if (::dladdr1(reinterpret_cast<void*>(&folder_of_package), &info, &map, RTLD_DL_LINKMAP) == 0) return {};
    const fs::path name = static_cast<const link_map*>(map)->l_name;
    std::error_code error;
    // The program itself has no name there.
    const fs::path file = fs::canonical(name.empty() ? "/proc/self/exe" : name, error);
    return error ? fs::path() : file.parent_path().parent_path() / "driver";
}
#else
/// Nothing: anybody could have put a driver beside a program in a folder for all, such as /tmp.
fs::path folder_of_package() {
    return {};
}
#endif

fs::path driver_folder() {
    const char* const folder = tuning_variable("CLSDF_DRIVER");
    return folder != nullptr ? folder : folder_of_package();
}

BundledDriver find() {
    BundledDriver driver;
    const fs::path folder = driver_folder(), file = folder / "libclsdf_pocl.so";
    std::error_code none;
    if (folder.empty() || !fs::exists(file, none)) return driver;
    driver.folder = folder;
    driver.file = file;
    try {
        driver.platform = guarded([&] { return open_driver(file).front(); });
        opened = driver.platform();
    } catch (const Error& error) {
        driver.why_not = error.what();
    }
    return driver;
}

}  // namespace

const BundledDriver& bundled_driver() {
    // Never destroyed: its threads may run until the process ends.
    static const BundledDriver& driver = *new BundledDriver(find());
    return driver;
}

bool is_bundled(const cl::Device& device) {
    const cl_platform_id bundled = opened;
    return bundled != nullptr && cl::Platform(device.getInfo<CL_DEVICE_PLATFORM>())() == bundled;
}

fs::path bundled_programs(const cl::Device& device) {
    const fs::path folder = bundled_driver().folder / "programs" / processor_level(device);
    std::error_code none;
    return fs::is_directory(folder, none) ? folder : fs::path();
}

std::vector<BundledLevel> bundled_levels(const cl::Device& device) {
    // It ends with the device's own level.
    std::string target = target_of(device);
    target.resize(target.size() - processor_level(device).size());
    std::vector<BundledLevel> levels;
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(bundled_driver().folder / "programs", none)) {
        const std::string name = entry.path().filename().string();
        levels.push_back({name, entry.path(), target + name});
    }
    return levels;
}

std::string platform_name(const cl::Device& device) {
    const cl::Platform platform(device.getInfo<CL_DEVICE_PLATFORM>());
    return platform.getInfo<CL_PLATFORM_NAME>() + (is_bundled(device) ? ", bundled with clsdf" : "");
}

}  // namespace clsdf::device
