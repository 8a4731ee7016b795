#include "device/find/unregistered_drivers.hpp"

#include "core/tuning_variables.hpp"
#include "device/find/opened_driver.hpp"
#include "device/find/system_library.hpp"
#include "device/opencl.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>

namespace clsdf::device {

namespace {

namespace fs = std::filesystem;

struct Maker {
    const char* name;
    const char* library;
    std::string_view gpu;  ///< the name of a GPU's file in /dev, without a number; empty: only render nodes
    bool is_numbered;
    const char* remedy;  ///< if the library is missing
};

constexpr std::array<Maker, 3> makers{
    Maker{"NVIDIA", "libnvidia-opencl.so.1", "nvidia", true,
          "install it (Debian: nvidia-opencl-icd), or start the container with "
          "NVIDIA_DRIVER_CAPABILITIES=compute,utility in its environment"},
    Maker{"AMD", "libamdocl64.so", "kfd", false,
          "install it (Debian 13: rocm-opencl-icd, or AMD's own ROCm), and name its folder in LD_LIBRARY_PATH if "
          "ldconfig -p does not list it"},
    Maker{"Intel", "libigdrcl.so", "", false, "install it (Debian: intel-opencl-icd)"}};

bool is_number(std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// The first file in the folder whose name is the prefix, or the prefix and a number; empty if there is none.
fs::path first_file(const fs::path& folder, std::string_view prefix, bool is_numbered) {
    std::optional<fs::path> first;
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
        const std::string name = entry.path().filename();
        if (!name.starts_with(prefix)) continue;
        const std::string_view rest = std::string_view(name).substr(prefix.size());
        if (is_numbered ? is_number(rest) : rest.empty()) first = first ? std::min(*first, entry.path()) : entry.path();
    }
    return first.value_or(fs::path());
}

UnregisteredDriver open(const Maker& maker) {
    UnregisteredDriver driver;
    driver.maker = maker.name;
    for (const fs::path& file : system_libraries(maker.library)) {
        try {
            driver.platforms = guarded([&] { return open_driver(file); });
            driver.file = file;
            driver.why_not.clear();
            return driver;
        } catch (const Error& error) {
            // The next one may be of this machine's architecture.
            driver.why_not += (driver.why_not.empty() ? "" : "; ") + std::string(error.what());
        }
    }
    if (driver.why_not.empty())
        driver.why_not = fmt::format("{}, {}'s driver of OpenCL, is in no folder of the system's loader; {}",
                                     maker.library, maker.name, maker.remedy);
    return driver;
}

const UnregisteredDriver& opened(const Maker& maker) {
    // Never destroyed, as the drivers.
    static auto& mutex = *new std::mutex;
    static auto& drivers = *new std::map<std::string_view, UnregisteredDriver>;
    const std::scoped_lock lock(mutex);
    const auto known = drivers.find(maker.name);
    return known != drivers.end() ? known->second : drivers.emplace(maker.name, open(maker)).first->second;
}

bool is_set(const char* variable) {
    const char* const value = std::getenv(variable);
    return value != nullptr && *value != 0;
}

}  // namespace

std::vector<UnregisteredDriver> unregistered_drivers() {
    std::vector<UnregisteredDriver> drivers;
    if (is_set("OCL_ICD_VENDORS") || is_set("OPENCL_VENDOR_PATH")) return drivers;
    const char* const named = tuning_variable("CLSDF_DEVICE_FILES");
    const fs::path folder = named != nullptr ? named : "/dev";
    const bool has_render_node = !first_file(folder / "dri", "renderD", true).empty();
    for (const Maker& maker : makers) {
        const fs::path gpu = maker.gpu.empty() ? fs::path() : first_file(folder, maker.gpu, maker.is_numbered);
        if (gpu.empty() && !has_render_node) continue;
        drivers.push_back(opened(maker));
        drivers.back().gpu = gpu;
    }
    return drivers;
}

}  // namespace clsdf::device
