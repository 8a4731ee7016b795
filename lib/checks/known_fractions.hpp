#pragma once

#include "checks/self_test.hpp"

namespace clsdf::checks {

/// The kernels that find cut cells: cutting::DeviceFractions.
TestSubject fractions_subject(const Device& device, const engine::Programs& programs);

}  // namespace clsdf::checks
