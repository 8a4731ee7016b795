#pragma once

#include "transform/field_method.hpp"

#include <memory>

namespace clsdf::papers {

/// The distance at every sample to every triangle, on the device: exact, and a time that grows with their product. It
/// gives the distance and the triangle.
std::shared_ptr<const FieldMethod> make_brute_force();

/// The program of the distances; slices_finish.cl makes the outputs of them.
scan::ProgramSource brute_force_source(const scan::ProgramSources& programs, const scan::BrickVariant& variant);

}  // namespace clsdf::papers
