#include <clsdf/version.hpp>

namespace clsdf {

std::string version() {
    return std::to_string(CLSDF_VERSION_MAJOR) + '.' + std::to_string(CLSDF_VERSION_MINOR) + '.' +
           std::to_string(CLSDF_VERSION_PATCH);
}

}  // namespace clsdf
