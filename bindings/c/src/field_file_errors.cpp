// libclsdf_c_io reports to libclsdf_c, which keeps the messages of both.
#include "errors.hpp"
#include "handles.hpp"
#include "same_version.hpp"

namespace {

[[gnu::used]] void (*const needed)() = clsdf_c_same_version;

}  // namespace

void clsdf::c::record(const char* message, int /*opencl_code*/) noexcept {
    clsdf_set_last_error(message);
}
