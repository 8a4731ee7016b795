#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/error.hpp>

#include "plan/job.hpp"
#include "plan/slabs.hpp"
#include "targets/output_targets.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

namespace clsdf::plans {

/// Requests of one lattice, one band and the same outputs that are computed together, as one block of the lattice.
struct Batch {
    engine::Job job;
    std::vector<std::size_t> requests{};  ///< their indices
    double cost = 1;                      ///< estimated, in nanoseconds of a processor with two cores
    targets::HostArrays arrays{};         ///< of the first request: which outputs, and the elements that are computed
    bool in_place = false;                ///< it is one request, whose arrays the device can compute in
};

/// Slices of a batch's grid that are computed at once.
struct Slab {
    const Batch* batch;
    Grid grid;

    bool is_whole() const { return grid == batch->job.grid; }
};

/// The slabs of batches, in their order. limits_in_place: of those that are computed in place.
std::vector<Slab> slabs_of(std::span<const Batch> batches, const engine::SlabLimits& limits,
                           const engine::SlabLimits& limits_in_place);

/// The requests of blocks [begin, end). Throws Error(invalid_argument) for arrays that cannot hold all blocks.
std::vector<Request> requests_of(const BlockSet& blocks, std::size_t begin, std::size_t end);

/// Returns what `of_request` does for request number n of `count`. If there are several, the number stands in the
/// message of the Error that it throws.
template <class Function>
auto for_request(std::size_t n, std::size_t count, const Function& of_request) {
    try {
        return of_request();
    } catch (const Error& error) {
        if (count == 1) throw;  // a call for one grid has no numbers
        throw Error(error.code(), fmt::format("request {} of {}: {}", n, count, error.what()), error.opencl_code());
    }
}

/// make(request), HostTargets or DeviceTargets, for request number n of `count`, whose grid and band are valid. Adds
/// its arrays to `written`. Throws what a call for the request alone would throw; see for_request().
template <class Make>
auto targets_of(const Request& request, std::size_t n, std::size_t count, const Make& make,
                std::vector<targets::WrittenArray>& written) {
    return for_request(n, count, [&] {
        request.grid.validate();
        request.band.validate();
        return device::guarded([&] {
            auto targets = make(request);
            targets.add_written(n, written);
            return targets;
        });
    });
}

/// The same for each of them. Throws if their arrays overlap.
template <class Make>
auto targets_of(std::span<const Request> requests, const Make& make) {
    std::vector<std::invoke_result_t<Make, const Request&>> all;
    std::vector<targets::WrittenArray> written;
    all.reserve(requests.size());
    for (std::size_t n = 0; n < requests.size(); ++n)
        all.push_back(targets_of(requests[n], n, requests.size(), make, written));
    targets::refuse_overlap(written);
    return all;
}

/// Each request in one batch. `jobs` and `arrays`: those of each, with the outputs and their elements. A block has
/// samples that no request asks for, and a call for each request has a cost of its own: requests of a lattice are
/// divided if that is estimated to be cheaper. The division changes no byte. box: the mesh's.
std::vector<Batch> batches_of(std::span<const engine::Job> jobs, std::span<const targets::HostArrays> arrays,
                              const Box& box);

/// The same of the requests' targets, HostTargets or DeviceTargets.
template <class Targets>
std::vector<Batch> batches_of(std::span<const engine::Job> jobs, std::span<const Targets> targets, const Box& box) {
    std::vector<targets::HostArrays> arrays;
    for (const Targets& target : targets) arrays.push_back(target.arrays);
    std::vector<Batch> batches = batches_of(jobs, std::span<const targets::HostArrays>(arrays), box);
    for (Batch& batch : batches)
        batch.in_place = batch.requests.size() == 1 && targets[batch.requests.front()].can_be_in_place();
    return batches;
}

}  // namespace clsdf::plans
