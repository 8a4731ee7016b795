#pragma once

#include "checks/self_test.hpp"

namespace clsdf::checks {

/// The kernels that find the exact sides of samples on a GPU: engine::find_exact_sides().
TestSubject exact_sides_subject(const Device& device, const engine::Programs& programs);

/// The kernels that find links on a GPU, and those of exact sides: segments::links_by_kernels().
TestSubject links_subject(const Device& device, const engine::Programs& programs);

}  // namespace clsdf::checks
