#include <clsdf/version.hpp>

namespace clsdf {

std::string version() {
    return CLSDF_VERSION;
}

}  // namespace clsdf
