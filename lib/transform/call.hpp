#pragma once

#include <clsdf/distance_transform.hpp>

#include "device/context.hpp"

#include <cstddef>
#include <functional>
#include <string>

namespace clsdf::transform {

/// Throws Error(cancelled) if the caller wants a call to stop.
void throw_if_stopped(const CallOptions& call);

/// Adds what a slab took to what the slabs before it took.
void add_slab(TransformStatistics& total, const TransformStatistics& slab);

/// Adds what a call took to what the calls before it took.
void add_call(TransformStatistics& total, const TransformStatistics& call);

/// The building, loading and testing of programs by one call.
class Compiling {
public:
    Compiling(const CallOptions& call, const std::function<void(const std::string&)>& log) : call_(call), log_(log) {}

    /// `variant_steps`: those of building beside the programs that all computations need.
    device::BuildWatch watch(std::size_t variant_steps);

    double seconds = 0;
    bool first_use = false;

private:
    const CallOptions& call_;
    const std::function<void(const std::string&)>& log_;
    std::size_t step_ = 0;
};

}  // namespace clsdf::transform
