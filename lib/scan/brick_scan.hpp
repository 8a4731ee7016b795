#pragma once

#include "scan/field_scan.hpp"

#include <memory>

namespace clsdf::scan {

/// The scan of leaned polyhedra by bricks.
std::unique_ptr<FieldScan> make_brick_scan(const ScanInputs& inputs);

}  // namespace clsdf::scan
