#include "scan/sign_crossings.hpp"

#include "core/lifetime.hpp"
#include "device/opencl.hpp"
#include "scan/commands.hpp"
#include "scan/layout_of.hpp"
#include "scan/prefix_sums.hpp"
#include "scan/programs.hpp"
#include "sweep.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

namespace clsdf::scan {

namespace {

// Crossings that there is room for at first, for each row on average (see sign_bytes_of_slice). Where there are more
// crossings, they are found twice.
constexpr std::size_t records_per_row = 4;
constexpr const char* records_purpose = "crossings of the sign's sweep";
constexpr const char* listed = "crossings of the surface by rows of samples";

// Upper estimates for one core; they limit the work of a launch.
constexpr double seconds_per_row = 2e-8;       // that is tested against a triangle
constexpr double seconds_per_triangle = 5e-7;  // of the first launch: with CLSDF_LARGE_ROWS rows
// A large triangle is divided among work-items, each of which takes a strip of its slices.
constexpr std::size_t rows_of_a_strip = std::size_t{1} << 14;
constexpr std::size_t most_strips = 64;

}  // namespace

/// For one size of the records' buffer at a time.
class CrossingSearch::Launches {
public:
    Launches(device::Context& context, const Programs& programs, const std::shared_ptr<device::BufferPool>& pool,
             const Layout& layout, const SweepMesh& mesh, const SweepSelection& selection,
             const ShortLaunches& launches)
        : context_(context),
          queue_(context.queue()),
          programs_(programs),
          pool_(pool),
          mesh_(mesh),
          selection_(selection),
          seen_(layout),
          row_count_(sign_row_count(layout)),
          triangle_count_(selection.triangles() != nullptr ? selection.count : mesh.triangle_count),
          parts_(programs.parallel_parts(context, 1)),
          launches_(launches),
          row_counts_(pool->lease(row_count_ * sizeof(cl_uint), "counts of the sign's crossings")),
          totals_(pool->lease(sizeof(SweepTotals), "totals of the sign's sweep")),
          large_(pool->lease(triangle_count_ * sizeof(cl_uint), "large triangles of the sign's sweep")),
          small_kernel_(programs.sign_sweep, "sign_crossings"),
          large_kernel_(programs.sign_sweep, "sign_crossings_of_large") {
        seen_.brick_first[0] -= mesh.first_x / CLSDF_BRICK;
    }

    Launches(const Launches&) = delete;
    Launches& operator=(const Launches&) = delete;
    ~Launches() {
        // After an error: what is under way reads the mesh where the host has it.
        if (is_under_way_ && !context_.drain()) keep_for_good(totals_found_);
    }

    device::BufferPool& pool() const { return *pool_; }

    /// Records that the work-items of a launch may leave over.
    std::size_t left_over() const { return std::min(parts_, triangle_count_) * CLSDF_RECORD_BLOCK; }

    /// Enqueues the search for the crossings with room for `capacity` records, and what says where each row's start.
    void begin(Crossings& crossings, std::size_t capacity) {
        is_under_way_ = true;
        queue_.enqueueFillBuffer(*row_counts_, cl_uint{0}, 0, row_count_ * sizeof(cl_uint));
        queue_.enqueueFillBuffer(*totals_, cl_uint{0}, 0, sizeof(SweepTotals));
        capacity_ = static_cast<cl_uint>(capacity);
        const bool has_chosen = selection_.triangles() != nullptr;
        launches_.over(triangle_count_, seconds_per_triangle, [&](std::size_t begin, std::size_t end) {
            launch(small_kernel_, cl::NDRange(parts_), cl::NDRange(programs_.part_group()), begin, end, crossings,
                   cl_int{has_chosen ? 1 : 0}, has_chosen ? selection_.triangles : mesh_.triangles());
        });
        add_up(crossings);
    }

    /// Waits, and sets the crossings' numbers: of the records those that it took, also if there was room for fewer.
    void end(Crossings& crossings) {
        SweepTotals totals = wait_for_totals(crossings);
        crossings.has_large_triangles = totals.large > 0;
        if (totals.large > 0) {
            find_large(totals, crossings);
            add_up(crossings);
            totals = wait_for_totals(crossings);
        }
        crossings.record_count = totals.records;
        is_under_way_ = false;
    }

private:
    void find_large(const SweepTotals& totals, const Crossings& crossings) {
        const std::size_t strips = std::min(totals.largest_rows / rows_of_a_strip + 1, most_strips);
        const double mean_rows = CLSDF_LARGE_ROWS * (static_cast<double>(totals.large_blocks) / totals.large + 1);
        const double seconds = seconds_per_row * mean_rows + seconds_per_triangle * static_cast<double>(strips);
        launches_.over(totals.large, seconds, [&](std::size_t begin, std::size_t end) {
            launch(large_kernel_, cl::NDRange(in_whole_groups(end - begin), strips), cl::NDRange(common_group, 1),
                   begin, end, crossings);
        });
    }

    /// With the arguments that both kernels have, and those that only one has.
    template <class... Arguments>
    void launch(cl::Kernel& kernel, const cl::NDRange& items, const cl::NDRange& group, std::size_t begin,
                std::size_t end, const Crossings& crossings, const Arguments&... others) const {
        set_arguments(kernel, 0, seen_, static_cast<cl_uint>(begin), static_cast<cl_uint>(end), mesh_.triangles(),
                      *mesh_.vertices, cl_int{mesh_.bits_y}, cl_int{mesh_.bits_z}, *row_counts_, capacity_,
                      *crossings.records, *totals_, *large_, others...);
        queue_.enqueueNDRangeKernel(kernel, cl::NullRange, items, group);
    }

    /// Sums the crossings so far. The sums do not wait until it is known whether large triangles are left: waking the
    /// host takes as long.
    void add_up(Crossings& crossings) {
        sums_.emplace(context_, programs_, pool_, *row_counts_, *crossings.starts, row_count_, listed);
        CommandGate gate(context_);
        sums_->enqueue();
        queue_.enqueueReadBuffer(*totals_, CL_FALSE, 0, sizeof(SweepTotals), totals_found_.get(), nullptr,
                                 &totals_read_);
        gate.open();
    }

    SweepTotals wait_for_totals(Crossings& crossings) {
        device::wait_for(totals_read_);
        crossings.count = sums_->total();
        return *totals_found_;
    }

    device::Context& context_;
    const cl::CommandQueue& queue_;
    const Programs& programs_;
    const std::shared_ptr<device::BufferPool>& pool_;
    const SweepMesh& mesh_;
    const SweepSelection& selection_;
    Layout seen_;  ///< from where the mesh's x is counted
    cl_uint capacity_ = 0;
    std::size_t row_count_;
    std::size_t triangle_count_;
    std::size_t parts_;
    const ShortLaunches& launches_;
    device::BufferPool::Lease row_counts_;
    device::BufferPool::Lease totals_;
    device::BufferPool::Lease large_;
    cl::Kernel small_kernel_;
    cl::Kernel large_kernel_;
    std::unique_ptr<SweepTotals> totals_found_ = std::make_unique<SweepTotals>();
    cl::Event totals_read_;
    std::optional<PrefixSums> sums_;
    bool is_under_way_ = false;
};

CrossingSearch::CrossingSearch(device::Context& context, const Programs& programs,
                               const std::shared_ptr<device::BufferPool>& pool, const Layout& layout,
                               const SweepMesh& mesh, const SweepSelection& selection, const ShortLaunches& launches)
    : search_(std::make_unique<Launches>(context, programs, pool, layout, mesh, selection, launches)) {
    const std::size_t rows = sign_row_count(layout);
    crossings_.starts = pool->lease((rows + 1) * sizeof(cl_uint), "starts of the sign's crossings");
    const std::size_t most = std::min<std::size_t>(context.capabilities().largest_allocation / sizeof(SweepRecord),
                                                   std::numeric_limits<cl_uint>::max());
    // The first capacity is a guess. If there is no memory for it, crossings are only counted at first.
    capacity_ = std::min(records_per_row * rows + search_->left_over(), most);
    if (auto guess = pool->lease_if_it_fits(capacity_ * sizeof(SweepRecord), records_purpose))
        crossings_.records = std::move(*guess);
    else
        crossings_.records = pool->lease(capacity_ = 0, records_purpose);
    search_->begin(crossings_, capacity_);
}

CrossingSearch::~CrossingSearch() = default;

Crossings CrossingSearch::finish() {
    for (;;) {
        search_->end(crossings_);
        // The counter of records has 32 bits and wraps; the scan's total shows it.
        if (crossings_.count > crossings_.record_count) throw too_many(listed);
        if (crossings_.record_count <= capacity_) return std::move(crossings_);
        capacity_ = crossings_.record_count;
        crossings_.records = {};  // the smaller one goes back first
        crossings_.records = search_->pool().lease(capacity_ * sizeof(SweepRecord), records_purpose);
        search_->begin(crossings_, capacity_);
    }
}

}  // namespace clsdf::scan
