#include "calls/transform/transform_state.hpp"
#include "plans/requests.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace clsdf {

namespace {

// Blocks are computed so many at once, because as requests with their jobs and targets they take about a kilobyte each.
// Neighbours in the list are mostly neighbours in space.
constexpr std::size_t most_at_once = std::size_t{1} << 15;

}  // namespace

void DistanceTransform::State::check_all(const BlockSet& blocks) const {
    constexpr std::size_t at_once = std::size_t{1} << 10;
    const std::size_t count = blocks.first.size();
    const bool on_device = targets::are_on_device(blocks.targets);
    std::vector<targets::WrittenArray> written;
    for (std::size_t begin = 0; begin < count; begin += at_once) {
        std::size_t n = begin;
        std::vector<engine::Job> jobs;
        for (const Request& request : plans::requests_of(blocks, begin, std::min(begin + at_once, count))) {
            if (on_device)
                plans::targets_of(request, n, count, device_targets(jobs), written);
            else
                plans::targets_of(request, n, count, host_targets(jobs), written);
            ++n;
        }
    }
    targets::refuse_overlap(written);
}

CallStatistics DistanceTransform::State::compute(const BlockSet& blocks, const CallOptions& call) {
    const std::size_t count = blocks.first.size();
    if (count > most_at_once) check_all(blocks);  // else compute() checks them all
    CallStatistics total;
    const auto share = [&](std::size_t part) { return static_cast<double>(part) / static_cast<double>(count); };
    for (std::size_t begin = 0; begin < count; begin += most_at_once) {
        const std::size_t end = std::min(begin + most_at_once, count);
        try {
            add_call(total,
                     compute(plans::requests_of(blocks, begin, end), calls::part_of(call, share(begin), share(end))));
        } catch (const Error& error) {
            if (count <= most_at_once || error.code() != ErrorCode::invalid_argument) throw;
            throw Error(error.code(), fmt::format("of the blocks {} to {}: {}", begin, end - 1, error.what()),
                        error.opencl_code());
        }
    }
    return total;
}

}  // namespace clsdf
