#pragma once

#include "acceptance/case.hpp"

#include <clsdf/device.hpp>

#include <vector>

namespace clsdf::acceptance {

/// A measure of the fit of the polyhedra, with its limits.
struct CostLimit {
    std::string name;
    double found = 0;
    double least = 0;
    double most = 0;

    bool kept() const { return found >= least && found <= most; }
};

/// The limits for the Stanford bunny at 256 samples and a half width of 10%. Throws clsdf::Error.
std::vector<CostLimit> bunny_costs(const Device& device, const Problem& bunny);

}  // namespace clsdf::acceptance
