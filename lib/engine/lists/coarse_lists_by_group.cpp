#include "coarse.h"
#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "lattice/layout_of.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/programs.hpp"
#include "lists/coarse_lists.hpp"

#include <algorithm>
#include <limits>

namespace clsdf::engine {

namespace {

// An upper estimate for one core; it limits the work of a launch.
constexpr double seconds_per_comparison = 2e-9;

/// Pairs that there is room for at first, those left over included, for each polyhedron on average. If there are
/// more, they are found twice.
std::size_t expected_pairs(const Layout& layout) {
    constexpr std::size_t narrow = 14;
    return has_uniform_bounds(layout) ? narrow : narrow * 5 / 2;
}

/// The launches that make the lists of the group body. Polyhedra that follow each other form segments; a list is made
/// of its entries of each segment.
class ListsByGroup {
public:
    ListsByGroup(const ListInputs& inputs, double seconds)
        : inputs_(inputs),
          seconds_(seconds),
          bricks_(coarse_brick_count(inputs.layout)),
          per_segment_(polyhedra_of_a_segment(inputs.mesh.record_count, bricks_)),
          segments_(inputs.mesh.record_count / per_segment_ + 1),
          counts_(inputs.tools.pool->lease(bricks_ * segments_ * sizeof(cl_uint), "counts of the coarse lists")),
          taken_(inputs.tools.pool->lease(sizeof(cl_uint), pairs_purpose)),
          device_starts_(inputs.tools.pool->lease((bricks_ + 1) * sizeof(cl_uint), "starts of the coarse lists")),
          pair_kernel_(inputs.tools.kernel(inputs.tools.programs.coarse_lists, "coarse_pairs")),
          starts_found_(inputs.tools.context, bricks_ + 1),
          taken_found_(inputs.tools.context) {}

    /// Returns the start of each brick's list, and the end of the last.
    std::vector<cl_uint> make(CoarseLists& lists) {
        lists.parts = segments_;
        lists.starts =
            inputs_.tools.pool->lease((bricks_ * segments_ + 1) * sizeof(cl_uint), "starts of the coarse lists");
        const std::size_t most =
            std::min<std::size_t>(inputs_.tools.context.capabilities().largest_allocation / sizeof(CoarsePair),
                                  std::numeric_limits<cl_uint>::max());
        // The first room is a guess. If there is no memory for it, pairs are only counted at first.
        std::size_t capacity = std::min(expected_pairs(inputs_.layout) * inputs_.mesh.record_count, most);
        if (auto guess = inputs_.tools.pool->lease_if_it_fits(capacity * sizeof(CoarsePair), pairs_purpose))
            pairs_ = std::move(*guess);
        else
            pairs_ = inputs_.tools.pool->lease(capacity = 0, pairs_purpose);
        for (;;) {
            find_pairs(lists, capacity);
            if (taken_found_.value() <= capacity) break;
            capacity = taken_found_.value();
            pairs_ = {};  // the smaller one goes back first
            pairs_ = inputs_.tools.pool->lease_for_list(capacity * sizeof(CoarsePair), pairs_purpose);
        }
        write_entries(lists, taken_found_.value());
        return {starts_found_.values().begin(), starts_found_.values().end()};
    }

private:
    static constexpr const char* listed = "pairs of a triangle and a coarse brick";
    static constexpr const char* pairs_purpose = "pairs of the coarse lists";

    /// Few, because each pair of a segment is compared with the segment's others of the same brick; but more if there
    /// would be too many counters.
    static std::size_t polyhedra_of_a_segment(std::size_t polyhedra, std::size_t bricks) {
        constexpr std::size_t fewest = 256;
        const std::size_t most_segments = std::max<std::size_t>(most_counters / bricks, 1);
        return std::max(fewest, chunk_count(polyhedra, most_segments));
    }

    /// Finds the pairs, and waits for their number and the lists' starts.
    void find_pairs(CoarseLists& lists, std::size_t capacity) {
        const cl::CommandQueue& queue = inputs_.tools.queue();
        const std::size_t counters = bricks_ * segments_;
        queue.enqueueFillBuffer(*counts_, cl_uint{0}, 0, counters * sizeof(cl_uint));
        queue.enqueueFillBuffer(*taken_, cl_uint{0}, 0, sizeof(cl_uint));
        inputs_.launches.over_items(pair_kernel_, inputs_.mesh.record_count, seconds_, [&](cl_uint begin, cl_uint end) {
            set_arguments(pair_kernel_, 0, inputs_.layout, begin, end, *inputs_.mesh.polyhedra, *lists.bounds,
                          cl_int{has_uniform_bounds(inputs_.layout) ? 1 : 0}, static_cast<cl_uint>(per_segment_),
                          static_cast<cl_uint>(segments_), *counts_, *taken_, static_cast<cl_uint>(capacity), *pairs_);
        });
        PrefixSums sums(inputs_.tools, *counts_, *lists.starts, counters, listed);
        device::LentKernel gather = inputs_.tools.kernel(inputs_.tools.programs.coarse_lists, "coarse_list_starts");
        launch(queue, gather, {bricks_ + 1}, static_cast<cl_uint>(bricks_), static_cast<cl_uint>(segments_),
               *lists.starts, *device_starts_);
        starts_found_.enqueue(*device_starts_);
        taken_found_.enqueue(*taken_);
        taken_found_.wait();
        starts_found_.end();
        // The counter of pairs has 32 bits and wraps; the scan's total shows it.
        lists.pairs = sums.total();
        if (lists.pairs > taken_found_.value()) throw too_many(listed);
    }

    void write_entries(CoarseLists& lists, std::size_t taken) {
        const auto scattered = inputs_.tools.pool->lease_for_list(lists.pairs * sizeof(cl_uint), "coarse lists");
        lists.entries = inputs_.tools.pool->lease_for_list(lists.pairs * sizeof(cl_uint), "coarse lists");
        device::LentKernel scatter = inputs_.tools.kernel(inputs_.tools.programs.coarse_lists, "coarse_scatter"),
                           sort = inputs_.tools.kernel(inputs_.tools.programs.coarse_lists, "coarse_sort");
        const auto per_segment = static_cast<cl_uint>(per_segment_), segments = static_cast<cl_uint>(segments_);
        inputs_.launches.over_items(scatter, taken, seconds_per_pair, [&](cl_uint begin, cl_uint end) {
            set_arguments(scatter, 0, begin, end, *pairs_, per_segment, segments, *lists.starts, *scattered);
        });
        inputs_.launches.over_items(sort, taken,
                                    seconds_per_pair + seconds_per_comparison * static_cast<double>(per_segment_),
                                    [&](cl_uint begin, cl_uint end) {
                                        set_arguments(sort, 0, begin, end, *pairs_, per_segment, segments,
                                                      *lists.starts, *scattered, *lists.entries);
                                    });
    }

    const ListInputs& inputs_;
    double seconds_;  ///< of a polyhedron, on a core
    std::size_t bricks_;
    std::size_t per_segment_;  ///< polyhedra
    std::size_t segments_;
    device::BufferPool::Lease counts_;  ///< one a brick and segment
    device::BufferPool::Lease taken_;   ///< of the pairs' room
    device::BufferPool::Lease device_starts_;
    device::LentKernel pair_kernel_;
    device::BufferPool::Lease pairs_;
    device::ReadBack<cl_uint> starts_found_;  ///< where the lists begin, and where the last one ends
    device::ReadBack<cl_uint> taken_found_;   ///< how much of the pairs' room was taken
};

}  // namespace

std::vector<cl_uint> make_lists_by_group(const ListInputs& inputs, double seconds, CoarseLists& lists) {
    return ListsByGroup(inputs, seconds).make(lists);
}

}  // namespace clsdf::engine
