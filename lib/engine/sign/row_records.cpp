#include "sign/row_records.hpp"

#include "core/parallel.hpp"
#include "launch/commands.hpp"
#include "launch/programs.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace clsdf::engine {

namespace {

constexpr double seconds_per_record = 2e-8;  // an upper estimate for one core

// Strips of a large triangle's rows are divided among work-items.
constexpr std::size_t rows_of_a_strip = std::size_t{1} << 14;
constexpr std::size_t most_strips = 64;

}  // namespace

RowRecords::RowRecords(RecordSearch search, std::span<const SweepRecord> known,
                       std::span<const std::uint32_t> known_counts)
    : search_(std::move(search)),
      known_(known),
      known_counts_(known_counts),
      queue_(search_.tools.context.queue()),
      parts_(parts_of(search_.tools, search_.triangles)),
      block_(search_.tools.programs.body == KernelBody::by_group ? 4 : 32),
      row_counts_(search_.tools.pool->lease(search_.rows * sizeof(cl_uint), search_.purpose)),
      totals_(search_.tools.pool->lease(sizeof(SweepTotals), search_.purpose)),
      large_(
          search_.tools.pool->lease(std::max<std::size_t>(search_.triangles, 1) * sizeof(cl_uint), search_.purpose)) {
    const DeviceTools& tools = search_.tools;
    found_.starts = tools.pool->lease((search_.rows + 1) * sizeof(cl_uint), search_.purpose);
    const std::size_t left_over = std::min(parts_, search_.triangles) * block_;
    const std::size_t most = std::min<std::size_t>(
        tools.context.capabilities().largest_allocation / sizeof(SweepRecord), std::numeric_limits<cl_uint>::max());
    // The first capacity is a guess. If there is no memory for it, records are only counted at first.
    capacity_ = std::min(search_.first_room + left_over + known_.size(), most);
    if (auto guess = tools.pool->lease_if_it_fits(capacity_ * sizeof(SweepRecord), search_.purpose))
        records_ = std::move(*guess);
    else
        records_ = tools.pool->lease(capacity_ = 0, search_.purpose);
}

/// A work-item of a GPU has one triangle, unless there are very many: rows of neighbours diverge, and a work-item waits
/// for each record that it counts.
std::size_t RowRecords::parts_of(const DeviceTools& tools, std::size_t triangles) {
    constexpr std::size_t most = std::size_t{1} << 17;
    return tools.programs.body == KernelBody::by_group
               ? std::min(chunk_count(triangles, common_group) * common_group, most)
               : tools.programs.parallel_parts(tools.context, 1);
}

void RowRecords::begin() {
    queue_.enqueueFillBuffer(*totals_, cl_uint{0}, 0, sizeof(SweepTotals));
    if (known_.empty())
        queue_.enqueueFillBuffer(*row_counts_, cl_uint{0}, 0, search_.rows * sizeof(cl_uint));
    else
        begin_with_known();
    search_.launches.over(search_.triangles, search_.seconds_per_triangle, [&](std::size_t begin, std::size_t end) {
        enqueue(parts_, begin, end, search_.chosen() != nullptr, search_.chosen() != nullptr ? search_.chosen : *large_,
                0);
    });
    add_up();
}

/// The kernel counts on, behind the records that are known.
void RowRecords::begin_with_known() {
    const auto count = static_cast<cl_uint>(known_.size());
    queue_.enqueueWriteBuffer(*row_counts_, CL_FALSE, 0, search_.rows * sizeof(cl_uint), known_counts_.data());
    queue_.enqueueWriteBuffer(*totals_, CL_FALSE, offsetof(SweepTotals, records), sizeof count, &count);
    if (const std::size_t room = std::min(known_.size(), capacity_); room > 0)
        queue_.enqueueWriteBuffer(*records_, CL_FALSE, 0, room * sizeof(SweepRecord), known_.data());
    search_.tools.context.finish();
}

/// Waits, and sets the numbers of records: those that they took, also if there was room for fewer.
void RowRecords::end() {
    SweepTotals totals = wait_for_totals();
    if (totals.large > 0) {
        find_large(totals);
        add_up();
        totals = wait_for_totals();
    }
    record_count_ = totals.records;
}

void RowRecords::find_large(const SweepTotals& totals) {
    const std::size_t strips = std::min(totals.largest_rows / rows_of_a_strip + 2, most_strips);
    const double mean_rows = CLSDF_LARGE_ROWS * (static_cast<double>(totals.large_blocks) / totals.large + 1);
    const double seconds =
        search_.seconds_per_row * mean_rows + search_.seconds_per_triangle * static_cast<double>(strips);
    const DeviceTools& tools = search_.tools;
    search_.launches.over(totals.large, seconds, [&](std::size_t begin, std::size_t end) {
        enqueue(std::min((end - begin) * strips, tools.programs.parallel_parts(tools.context, 1)), begin, end, true,
                *large_, strips);
    });
}

/// Triangles [begin, end), or of those that are chosen; in strips unless their number is 0.
void RowRecords::enqueue(std::size_t items, std::size_t begin, std::size_t end, bool has_chosen,
                         const cl::Buffer& chosen, std::size_t strips) {
    set_arguments(search_.kernel, search_.arguments, static_cast<cl_uint>(begin), static_cast<cl_uint>(end),
                  *row_counts_, static_cast<cl_uint>(capacity_), block_, *records_, *totals_, *large_,
                  cl_int{has_chosen ? 1 : 0}, chosen, static_cast<cl_uint>(strips));
    launch(queue_, search_.kernel, {items, search_.tools.programs.part_group()});
}

/// Sums the records so far. The sums do not wait until it is known whether large triangles are left: waking the host
/// takes as long.
void RowRecords::add_up() {
    sums_.emplace(search_.tools, *row_counts_, *found_.starts, search_.rows, search_.listed);
    totals_found_.enqueue(*totals_);
}

SweepTotals RowRecords::wait_for_totals() {
    totals_found_.wait();
    found_.count = sums_->total();
    return totals_found_.value();
}

RowKeys RowRecords::finish() {
    const DeviceTools& tools = search_.tools;
    for (;;) {
        end();
        // The counter of records has 32 bits and wraps; the scan's total shows it.
        if (found_.count > record_count_) throw too_many(search_.listed);
        if (record_count_ <= capacity_) break;
        // Parts leave other rests in another run: the order in which large triangles are listed differs.
        capacity_ = std::min<std::size_t>(record_count_ + parts_ * block_, std::numeric_limits<cl_uint>::max());
        records_ = {};  // the smaller one goes back first
        records_ = tools.pool->lease_for_list(capacity_ * sizeof(SweepRecord), search_.purpose);
        begin();
    }
    found_.keys = tools.pool->lease_for_list(found_.count * sizeof(cl_uint), search_.purpose);
    device::LentKernel scatter = tools.kernel(search_.program, "scatter_records");
    search_.launches.over_items(scatter, record_count_, seconds_per_record, [&](cl_uint begin, cl_uint end) {
        set_arguments(scatter, 0, begin, end, *records_, *found_.starts, *found_.keys);
    });
    return std::move(found_);
}

}  // namespace clsdf::engine
