#pragma once

#include <clsdf/export.hpp>

namespace clsdf {

/// The value of an environment variable for tests and tools; null if it is not set, or if the process did not call
/// tuning::read_environment(). A process has one such call, so a shared core exports this function (see
/// cmake/Libraries.cmake).
CLSDF_EXPORT const char* tuning_variable(const char* name) noexcept;

}  // namespace clsdf
