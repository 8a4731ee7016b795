#include "lists/coarse_lists.hpp"

#include "coarse.h"
#include "core/parallel.hpp"
#include "device/in_flight.hpp"
#include "lattice/layout_of.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/programs.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <limits>
#include <numeric>

namespace clsdf::engine {

namespace {

// Upper estimates for one core; they limit the work of a launch.
constexpr double seconds_per_surface_point = 2e-8;  // for a vector of columns of four bricks
constexpr double seconds_per_cluster = 2e-6;        // and group of coarse bricks

std::size_t coarse_group_count(const Layout& layout) {
    std::size_t count = 1;
    for (int axis = 0; axis < 3; ++axis) count *= static_cast<std::size_t>(coarse_groups(layout, axis));
    return count;
}

/// Pairs of a cluster of polyhedra and a coarse brick that there is room for at first, for each polyhedron on average
/// (an estimate). If there are more, they are found twice.
std::size_t expected_pairs(const Layout& layout, std::size_t lanes) {
    const std::size_t narrow = lanes == 8 ? 3 : 2;
    return has_uniform_bounds(layout) ? narrow : narrow * 5 / 2;
}

/// The time of a cluster's tests against groups of coarse bricks, if its triangles are small.
double seconds_of_a_cluster(const Layout& layout) {
    double groups = 1;
    for (const std::int32_t bricks : layout.coarse_bricks)
        groups *= std::min(bricks / 4.0 + 1, 2.0 * static_cast<double>(layout.half_width) / (4.0 * CLSDF_COARSE) + 1.5);
    return groups * seconds_per_cluster;
}

device::BufferPool::Lease find_bounds(const ListInputs& inputs) {
    const std::size_t groups = coarse_group_count(inputs.layout), bricks = groups * CLSDF_COARSE_GROUP;
    auto bounds = inputs.tools.pool->lease(bricks * sizeof(float), "bounds of the coarse bricks");
    if (!inputs.points) {
        inputs.tools.queue().enqueueFillBuffer(*bounds, inputs.layout.half_width, 0, bricks * sizeof(float));
        return bounds;
    }
    const std::size_t count = inputs.points->size();
    const auto points = inputs.tools.pool->lease(count * sizeof(SurfacePoint), "points of the surface");
    const auto* const first = reinterpret_cast<const std::byte*>(inputs.points->data());
    if (!inputs.tools.context.write(inputs.tools.queue(), first, count * sizeof(SurfacePoint), *points))
        inputs.tools.queue().enqueueWriteBuffer(*points, CL_FALSE, 0, count * sizeof(SurfacePoint), first);

    device::LentKernel kernel = inputs.tools.kernel(inputs.tools.programs.coarse_lists, "coarse_bounds");
    const double seconds = seconds_per_surface_point * static_cast<double>(count);
    // PoCL compiles a kernel anew for each size of a group: one size for all grids.
    const cl::NDRange alone = inputs.tools.programs.body == KernelBody::by_group ? cl::NullRange : cl::NDRange(1);
    inputs.launches.over(
        groups * CLSDF_COARSE_COLUMNS / inputs.tools.programs.lanes, seconds, [&](std::size_t begin, std::size_t end) {
            set_arguments(kernel, 0, inputs.layout, static_cast<cl_uint>(count), *points, *bounds,
                          static_cast<cl_uint>(begin));
            inputs.tools.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(end - begin), alone);
            kernel.note_launch();
        });
    return bounds;
}

/// The launches that make the lists of the vector body.
class ListsByVector {
public:
    explicit ListsByVector(const ListInputs& inputs)
        : inputs_(inputs),
          bricks_(coarse_brick_count(inputs.layout)),
          parts_(inputs.tools.programs.parallel_parts(inputs.tools.context, bricks_)),
          counters_(bricks_ * parts_),
          histograms_(inputs.tools.pool->lease(counters_ * sizeof(cl_uint), "histograms of the coarse lists")),
          pair_counts_(inputs.tools.pool->lease(parts_ * sizeof(cl_uint), pairs_purpose)),
          pair_starts_(inputs.tools.pool->lease((parts_ + 1) * sizeof(cl_uint), pairs_purpose)),
          host_(inputs.tools.context, {{}, std::vector<cl_uint>(parts_), std::vector<cl_uint>(counters_ + 1)}) {}

    /// Returns the start of each brick's list, and the end of the last.
    std::vector<cl_uint> make(CoarseLists& lists) {
        lists.parts = parts_;
        lists.starts = inputs_.tools.pool->lease((counters_ + 1) * sizeof(cl_uint), "starts of the coarse lists");
        find_pairs(*lists.bounds, *lists.starts);
        lists.pairs = host_->starts.back();
        lists.entries = inputs_.tools.pool->lease_for_list((lists.pairs + vector) * sizeof(cl_uint), "coarse lists");
        write_entries(*lists.starts, *lists.entries);
        std::vector<cl_uint> list_starts(bricks_ + 1);
        for (std::size_t brick = 0; brick <= bricks_; ++brick) list_starts[brick] = host_->starts[brick * parts_];
        return list_starts;
    }

private:
    static constexpr const char* pairs_purpose = "pairs of the coarse lists";
    static constexpr std::size_t vector = 16;  // kernels read whole ones at a list's end

    /// Counts the entries, where those of each coarse brick and part start, and keeps the pairs.
    void find_pairs(const cl::Buffer& bounds, const cl::Buffer& starts) {
        const auto counts = inputs_.tools.pool->lease(counters_ * sizeof(cl_uint), "counts of the coarse lists");
        const bool has_groups = inputs_.selection.groups() != nullptr;
        const std::size_t records =
            has_groups ? inputs_.selection.group_count * record_group : inputs_.mesh.record_count;
        const std::size_t clusters = chunk_count(records, inputs_.tools.programs.lanes);
        device::LentKernel kernel = inputs_.tools.kernel(inputs_.tools.programs.coarse_lists, "coarse_count");
        const double seconds = seconds_of_a_cluster(inputs_.layout) * static_cast<double>(clusters);
        const std::size_t expected =
            std::min({expected_pairs(inputs_.layout, inputs_.tools.programs.lanes) * records,
                      inputs_.tools.context.capabilities().largest_allocation / sizeof(ClusterPair) / 2,
                      static_cast<std::size_t>(std::numeric_limits<cl_uint>::max())});
        // The first room is a guess. If there is no memory for it, the first pass only counts pairs.
        std::vector<cl_uint> room(parts_, static_cast<cl_uint>(expected / parts_));
        if (auto guess = inputs_.tools.pool->lease_if_it_fits(bytes_of(room), pairs_purpose))
            pairs_ = std::move(*guess);
        else
            make_room(room = std::vector<cl_uint>(parts_));
        for (;;) {
            place_parts(room);
            launch(kernel, seconds, inputs_.layout, static_cast<cl_uint>(inputs_.mesh.record_count),
                   static_cast<cl_uint>(clusters), *inputs_.mesh.polyhedra, cl_int{has_groups ? 1 : 0},
                   has_groups ? inputs_.selection.groups : *inputs_.mesh.polyhedra, bounds,
                   cl_int{has_uniform_bounds(inputs_.layout) ? 1 : 0}, *pair_starts_, *pairs_, *pair_counts_,
                   *histograms_, *counts);
            // All that the host waits for at once: to wake it takes as long as a small kernel.
            PrefixSums sums(inputs_.tools, *counts, starts, counters_, "pairs of a triangle and a coarse brick");
            const std::size_t launched = inputs_.tools.context.kernels().launched().count();
            cl::Event are_read;
            inputs_.tools.queue().enqueueReadBuffer(*pair_counts_, CL_FALSE, 0, parts_ * sizeof(cl_uint),
                                                    host_->pairs_found.data());
            inputs_.tools.queue().enqueueReadBuffer(starts, CL_FALSE, 0, host_->starts.size() * sizeof(cl_uint),
                                                    host_->starts.data(), nullptr, &are_read);
            inputs_.tools.context.wait(are_read, launched);
            sums.total();  // throws if the starts do not hold it
            if (std::equal(host_->pairs_found.begin(), host_->pairs_found.end(), room.begin(), std::less_equal<>()))
                break;
            make_room(room = host_->pairs_found);
        }
        host_.end();
        pair_count_ = std::accumulate(host_->pairs_found.begin(), host_->pairs_found.end(), std::size_t{0});
    }

    static std::size_t bytes_of(const std::vector<cl_uint>& pairs_of_parts) {
        return sizeof(ClusterPair) * std::accumulate(pairs_of_parts.begin(), pairs_of_parts.end(), std::size_t{0});
    }

    /// For so many pairs of each part.
    void make_room(const std::vector<cl_uint>& pairs_of_parts) {
        pairs_ = {};  // the smaller one goes back first
        pairs_ = inputs_.tools.pool->lease_for_list(bytes_of(pairs_of_parts), pairs_purpose);
    }

    /// Writes the start of the room for each part's pairs. Does not wait: the launch that follows is waited for.
    void place_parts(const std::vector<cl_uint>& pairs_of_parts) {
        host_.begin();
        host_->room_starts.assign(parts_ + 1, 0);
        std::partial_sum(pairs_of_parts.begin(), pairs_of_parts.end(), host_->room_starts.begin() + 1);
        inputs_.tools.queue().enqueueWriteBuffer(
            *pair_starts_, CL_FALSE, 0, host_->room_starts.size() * sizeof(cl_uint), host_->room_starts.data());
    }

    void write_entries(const cl::Buffer& starts, const cl::Buffer& entries) {
        device::LentKernel kernel = inputs_.tools.kernel(inputs_.tools.programs.coarse_lists, "coarse_fill");
        launch(kernel, seconds_per_pair * static_cast<double>(pair_count_), inputs_.layout, *pair_starts_, *pairs_,
               *pair_counts_, starts, *histograms_, entries);
    }

    /// All parts, in steps, that take a core so many seconds together. The step and the number of steps follow the
    /// other arguments.
    template <class... Arguments>
    void launch(device::LentKernel& kernel, double core_seconds, const Arguments&... arguments) const {
        const std::size_t steps = inputs_.launches.steps(core_seconds);
        inputs_.launches.one_by_one(steps, [&](std::size_t step) {
            engine::launch(inputs_.tools.queue(), kernel, {parts_, inputs_.tools.programs.part_group()}, arguments...,
                           static_cast<cl_uint>(step), static_cast<cl_uint>(steps));
        });
    }

    const ListInputs& inputs_;
    std::size_t bricks_;
    std::size_t parts_;
    std::size_t counters_;  ///< one a brick and part
    device::BufferPool::Lease histograms_;
    device::BufferPool::Lease pair_counts_;
    device::BufferPool::Lease pair_starts_;  ///< where the room for each part's pairs begins
    device::BufferPool::Lease pairs_;
    std::size_t pair_count_ = 0;
    /// Copies on the host.
    struct OnHost {
        std::vector<cl_uint> room_starts;
        std::vector<cl_uint> pairs_found;  ///< of each part
        std::vector<cl_uint> starts;       ///< of the lists
    };
    device::InFlight<OnHost> host_;
};

/// The long lists first, so that cores end together; among those of like length neighbours follow each other, because
/// they share polyhedra.
void order_by_length(CoarseLists& lists, const std::vector<cl_uint>& starts) {
    const auto length = [&](cl_uint brick) { return starts[std::size_t{brick} + 1] - starts[brick]; };
    for (cl_uint brick = 0; brick + 1 < starts.size(); ++brick)
        if (length(brick) > 0) lists.order.push_back(brick);
    std::stable_sort(lists.order.begin(), lists.order.end(),
                     [&](cl_uint a, cl_uint b) { return std::bit_width(length(a)) > std::bit_width(length(b)); });
    lists.lengths.reserve(lists.order.size());
    for (const cl_uint brick : lists.order) lists.lengths.push_back(length(brick));
}

}  // namespace

bool has_uniform_bounds(const Layout& layout) {
    return layout.half_width <= 2 * layout.coarse_radius;
}

CoarseLists make_coarse_lists(const ListInputs& inputs) {
    return device::guarded([&] {
        device::InFlight<std::shared_ptr<const SurfacePoints>> points(inputs.tools.context, inputs.points);
        if (inputs.points) points.begin();
        CoarseLists lists;
        lists.bounds = find_bounds(inputs);
        order_by_length(lists, inputs.tools.programs.body == KernelBody::by_group
                                   ? make_lists_by_group(inputs, seconds_of_a_cluster(inputs.layout), lists)
                                   : ListsByVector(inputs).make(lists));
        inputs.tools.queue().flush();
        points.end();  // the host has read the lists' lengths, which were computed behind the copy
        return lists;
    });
}

}  // namespace clsdf::engine
