#pragma once

#include "device/buffer_pool.hpp"
#include "device/read_back.hpp"
#include "launch/device_tools.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/short_launches.hpp"
#include "sweep.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace clsdf::engine {

/// What rows and triangles meet is found by a kernel of kernels/sign/row_records.h.
struct RecordSearch {
    DeviceTools tools;
    const ShortLaunches& launches;
    cl::Program program;  ///< which has scatter_records
    device::LentKernel kernel;
    cl_uint arguments;  ///< of the kernel that are set: its own, which come first
    std::size_t rows;
    std::size_t triangles;       ///< all, or those that are chosen
    cl::Buffer chosen{};         ///< their numbers; null: all
    std::size_t first_room = 0;  ///< for records; if there are more, they are found twice
    const char* purpose;         ///< of the memory, as in "crossings of the sign's sweep"
    const char* listed;          ///< the records, for messages
    // Upper estimates for one core; they limit the work of a launch.
    double seconds_per_row = 2e-8;       ///< that is tested against a triangle
    double seconds_per_triangle = 5e-7;  ///< of the first launch: with CLSDF_LARGE_ROWS rows
};

/// Keys, row by row.
struct RowKeys {
    device::BufferPool::Lease starts;  ///< of the rows' keys, and their number
    device::BufferPool::Lease keys;
    std::size_t count = 0;
};

/// The launches that find the records of rows, in no order, and move their keys to their rows.
class RowRecords {
public:
    /// known: records that the host has, and how many each row has; they must outlive this.
    explicit RowRecords(RecordSearch search, std::span<const SweepRecord> known = {},
                        std::span<const std::uint32_t> known_counts = {});

    /// Enqueues the search, and what says where each row's keys start; does not wait.
    void begin();
    /// Waits for what was found, unless the host has waited for later commands of the queue. Searches again if there
    /// was too little room, and enqueues the launches that move the keys. Throws Error(out_of_memory) if there are 2^32
    /// records or more.
    RowKeys finish();
    /// What the kernel has counted, after finish().
    const SweepTotals& totals() const { return totals_found_.value(); }

private:
    static std::size_t parts_of(const DeviceTools& tools, std::size_t triangles);
    void begin_with_known();
    void end();
    void find_large(const SweepTotals& totals);
    void enqueue(std::size_t items, std::size_t begin, std::size_t end, bool has_chosen, const cl::Buffer& chosen,
                 std::size_t strips);
    void add_up();
    SweepTotals wait_for_totals();

    RecordSearch search_;
    std::span<const SweepRecord> known_;
    std::span<const std::uint32_t> known_counts_;
    const cl::CommandQueue& queue_;
    std::size_t parts_;
    cl_uint block_;  ///< records that a part takes at a time
    device::BufferPool::Lease row_counts_;
    device::BufferPool::Lease totals_;
    device::BufferPool::Lease large_;
    std::optional<PrefixSums> sums_;
    RowKeys found_;
    device::BufferPool::Lease records_;  ///< SweepRecord, in no order
    std::size_t record_count_ = 0;       ///< those that are left over included
    std::size_t capacity_ = 0;           ///< records that there is room for
    device::ReadBack<SweepTotals> totals_found_{search_.tools.context};
};

}  // namespace clsdf::engine
