#include "sign/sign_sweep.hpp"

#include "core/parallel.hpp"
#include "device/opencl.hpp"
#include "device/read_back.hpp"
#include "lattice/layout_of.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/programs.hpp"
#include "sweep.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>

namespace clsdf::engine {

namespace {

// The first room for crossings, per row on average (see sign_bytes_of_slice). If there are more crossings, they are
// found twice.
constexpr std::size_t records_per_row = 4;
constexpr const char* records_purpose = "crossings of the sign's sweep";
constexpr const char* listed = "crossings of the surface by rows of samples";

// Upper estimates for one core; they limit the work of a launch.
constexpr double seconds_per_row = 2e-8;       // that is tested against a triangle
constexpr double seconds_per_triangle = 5e-7;  // of the first launch: with CLSDF_LARGE_ROWS rows
constexpr double seconds_per_record = 2e-8;
constexpr double seconds_per_word = 5e-9;  // of sign bits

// Strips of a large triangle's slices are divided among work-items.
constexpr std::size_t rows_of_a_strip = std::size_t{1} << 14;
constexpr std::size_t most_strips = 64;

// Rows that lie together, most of which meet no surface, of one work-item on a processor.
constexpr std::size_t rows_of_a_core = 64;

}  // namespace

/// The launches that find the crossings of the part's rows of samples and the surface, and make bits of them.
class CrossingSearch {
public:
    /// film: crossings that are known; it must outlive this.
    CrossingSearch(const SweepInputs& inputs, const FilmCrossings& film)
        : inputs_(inputs),
          film_(film),
          queue_(inputs.tools.context.queue()),
          seen_(inputs.layout),
          row_count_(sign_row_count(inputs.layout)),
          triangle_count_(has_selection() ? inputs.selection.count : inputs.mesh->triangle_count),
          parts_(parts_of(inputs, triangle_count_)),
          block_(inputs.tools.programs.body == KernelBody::by_group ? 4 : 32),
          row_counts_(inputs.tools.pool->lease(row_count_ * sizeof(cl_uint), "counts of the sign's crossings")),
          totals_(inputs.tools.pool->lease(sizeof(SweepTotals), "totals of the sign's sweep")),
          large_(inputs.tools.pool->lease(triangle_count_ * sizeof(cl_uint), "large triangles of the sign's sweep")),
          kernel_(inputs.tools.kernel(inputs.tools.programs.sign_sweep, "sign_crossings")) {
        seen_.brick_first[0] -= inputs.mesh->first_x / CLSDF_BRICK;
        starts_ = inputs.tools.pool->lease((row_count_ + 1) * sizeof(cl_uint), "starts of the sign's crossings");
        const std::size_t left_over = std::min(parts_, triangle_count_) * block_;
        const std::size_t most =
            std::min<std::size_t>(inputs.tools.context.capabilities().largest_allocation / sizeof(SweepRecord),
                                  std::numeric_limits<cl_uint>::max());
        // The first capacity is a guess. If there is no memory for it, crossings are only counted at first.
        capacity_ = std::min(records_per_row * row_count_ + left_over + film.records.size(), most);
        if (auto guess = inputs.tools.pool->lease_if_it_fits(capacity_ * sizeof(SweepRecord), records_purpose))
            records_ = std::move(*guess);
        else
            records_ = inputs.tools.pool->lease(capacity_ = 0, records_purpose);
    }

    /// Enqueues the search with room for `capacity_` records, and what says where each row's start; does not wait.
    void begin() {
        queue_.enqueueFillBuffer(*totals_, cl_uint{0}, 0, sizeof(SweepTotals));
        if (film_.records.empty())
            queue_.enqueueFillBuffer(*row_counts_, cl_uint{0}, 0, row_count_ * sizeof(cl_uint));
        else
            begin_with_film();
        inputs_.launches.over(triangle_count_, seconds_per_triangle, [&](std::size_t begin, std::size_t end) {
            enqueue(parts_, begin, end, has_selection(),
                    has_selection() ? inputs_.selection.triangles : inputs_.mesh->triangles(), 0);
        });
        add_up();
    }

    /// Waits for what was found, unless the host has waited for later commands of the queue. Searches again if there
    /// was too little room, and enqueues the launches that make the bits.
    void finish(const cl::Buffer& bits) {
        for (;;) {
            end();
            // The counter of records has 32 bits and wraps; the scan's total shows it.
            if (count_ > record_count_) throw too_many(listed);
            if (record_count_ <= capacity_) break;
            capacity_ = record_count_;
            records_ = {};  // the smaller one goes back first
            records_ = inputs_.tools.pool->lease_for_list(capacity_ * sizeof(SweepRecord), records_purpose);
            begin();
        }
        sweep_rows(bits);
    }

private:
    /// A work-item of a GPU has one triangle, unless there are very many: rows of neighbours diverge, and a work-item
    /// waits for each crossing that it counts.
    static std::size_t parts_of(const SweepInputs& inputs, std::size_t triangles) {
        constexpr std::size_t most = std::size_t{1} << 17;
        const Programs& programs = inputs.tools.programs;
        return programs.body == KernelBody::by_group
                   ? std::min(chunk_count(triangles, common_group) * common_group, most)
                   : programs.parallel_parts(inputs.tools.context, 1);
    }

    /// The kernel counts on, behind the crossings of the film.
    void begin_with_film() {
        const auto count = static_cast<cl_uint>(film_.records.size());
        queue_.enqueueWriteBuffer(*row_counts_, CL_FALSE, 0, row_count_ * sizeof(cl_uint), film_.row_counts.data());
        queue_.enqueueWriteBuffer(*totals_, CL_FALSE, offsetof(SweepTotals, records), sizeof count, &count);
        if (const std::size_t room = std::min(film_.records.size(), capacity_); room > 0)
            queue_.enqueueWriteBuffer(*records_, CL_FALSE, 0, room * sizeof(SweepRecord), film_.records.data());
        inputs_.tools.context.finish();
    }

    bool has_selection() const { return inputs_.selection.triangles() != nullptr; }

    /// Waits, and sets the crossings' numbers: of the records those that it took, also if there was room for fewer.
    void end() {
        SweepTotals totals = wait_for_totals();
        if (totals.large > 0) {
            find_large(totals);
            add_up();
            totals = wait_for_totals();
        }
        record_count_ = totals.records;
    }

    void find_large(const SweepTotals& totals) {
        const std::size_t strips = std::min(totals.largest_rows / rows_of_a_strip + 2, most_strips);
        const double mean_rows = CLSDF_LARGE_ROWS * (static_cast<double>(totals.large_blocks) / totals.large + 1);
        const double seconds = seconds_per_row * mean_rows + seconds_per_triangle * static_cast<double>(strips);
        inputs_.launches.over(totals.large, seconds, [&](std::size_t begin, std::size_t end) {
            enqueue(std::min((end - begin) * strips, inputs_.tools.programs.parallel_parts(inputs_.tools.context, 1)),
                    begin, end, true, *large_, strips);
        });
    }

    /// Triangles [begin, end), or of those that are chosen; in strips unless their number is 0.
    void enqueue(std::size_t items, std::size_t begin, std::size_t end, bool has_chosen, const cl::Buffer& chosen,
                 std::size_t strips) {
        const SweepMesh& mesh = *inputs_.mesh;
        launch(queue_, kernel_, {items, inputs_.tools.programs.part_group()}, seen_, static_cast<cl_uint>(begin),
               static_cast<cl_uint>(end), mesh.triangles(), *mesh.vertices, cl_int{mesh.bits_y}, cl_int{mesh.bits_z},
               *row_counts_, static_cast<cl_uint>(capacity_), block_, *records_, *totals_, *large_,
               cl_int{has_chosen ? 1 : 0}, chosen, static_cast<cl_uint>(strips));
    }

    /// Sums the crossings so far. The sums do not wait until it is known whether large triangles are left: waking the
    /// host takes as long.
    void add_up() {
        sums_.emplace(inputs_.tools, *row_counts_, *starts_, row_count_, listed);
        totals_found_.enqueue(*totals_);
    }

    SweepTotals wait_for_totals() {
        totals_found_.wait();
        count_ = sums_->total();
        return totals_found_.value();
    }

    /// The keys of the crossings, row by row.
    device::BufferPool::Lease keys_by_row() const {
        auto keys =
            inputs_.tools.pool->lease_for_list(count_ * sizeof(cl_uint), "crossings of the sign's sweep by rows");
        device::LentKernel scatter = inputs_.tools.kernel(inputs_.tools.programs.sign_sweep, "sign_scatter");
        inputs_.launches.over_items(scatter, record_count_, seconds_per_record, [&](cl_uint begin, cl_uint end) {
            set_arguments(scatter, 0, begin, end, *records_, *starts_, *keys);
        });
        return keys;
    }

    void sweep_rows(const cl::Buffer& bits) const {
        const Layout& layout = inputs_.layout;
        const auto keys = keys_by_row();
        device::LentKernel sweep = inputs_.tools.kernel(inputs_.tools.programs.sign_sweep, "sign_rows");
        const std::size_t item_rows = inputs_.tools.programs.body == KernelBody::by_group ? 1 : rows_of_a_core;
        const double words_and_keys =
            layout.sign_words + 8.0 * static_cast<double>(record_count_) / static_cast<double>(row_count_);
        inputs_.launches.over(row_count_, seconds_per_word * words_and_keys, [&](std::size_t begin, std::size_t end) {
            const std::size_t items = chunk_count(end - begin, item_rows);
            engine::launch(queue_, sweep, {items, inputs_.tools.programs.part_group()}, layout,
                           static_cast<cl_uint>(begin), static_cast<cl_uint>(end), static_cast<cl_uint>(item_rows),
                           cl_int{inputs_.rule == SignRule::parity ? 1 : 0}, *starts_, *keys, bits);
        });
    }

    const SweepInputs& inputs_;
    const FilmCrossings& film_;
    const cl::CommandQueue& queue_;
    Layout seen_;  ///< from where the mesh's x is counted
    std::size_t row_count_;
    std::size_t triangle_count_;
    std::size_t parts_;
    cl_uint block_;  ///< records that a part takes at a time
    device::BufferPool::Lease row_counts_;
    device::BufferPool::Lease totals_;
    device::BufferPool::Lease large_;
    device::LentKernel kernel_;
    std::optional<PrefixSums> sums_;
    std::size_t count_ = 0;
    device::BufferPool::Lease starts_;   ///< of the rows' crossings, were they listed row by row; and `count_`
    device::BufferPool::Lease records_;  ///< SweepRecord, in no order
    std::size_t record_count_ = 0;       ///< those that are left over included
    std::size_t capacity_ = 0;           ///< records that there is room for
    device::ReadBack<SweepTotals> totals_found_{inputs_.tools.context};
};

SignSweep::SignSweep(const SweepInputs& inputs) : inputs_(inputs) {
    device::guarded([&] {
        const std::size_t bytes =
            sign_row_count(inputs.layout) * static_cast<std::size_t>(inputs.layout.sign_words) * sizeof(cl_uint);
        constexpr const char* purpose = "sign bits";
        if (inputs.write_bits) {
            device::HostFilling filling(inputs.tools.context, inputs.tools.pool, bytes, purpose);
            inputs.write_bits(inputs.layout, {static_cast<cl_uint*>(filling.memory()), bytes / sizeof(cl_uint)});
            bits_ = filling.finish();
            return;
        }
        bits_ = inputs.tools.pool->lease(bytes, purpose);
        if (inputs.mesh != nullptr && inputs.mesh->boundary) {
            const LatticeBoundary& boundary = *inputs.mesh->boundary;
            film_ = (boundary.floor ? wall_crossings : film_crossings)(
                boundary, inputs.layout, [&] { inputs.launches.one_by_one(1, [](std::size_t) {}); });
        }
        const bool is_empty = inputs.mesh == nullptr || inputs.mesh->triangle_count == 0 ||
                              (inputs.selection.triangles() != nullptr && inputs.selection.count == 0);
        if (is_empty && film_.records.empty()) {
            inputs.tools.context.queue().enqueueFillBuffer(*bits_, cl_uint{0}, 0, bytes);
        } else {
            search_ = std::make_unique<CrossingSearch>(inputs_, film_);
            search_->begin();
        }
    });
}

SignSweep::~SignSweep() = default;

device::BufferPool::Lease SignSweep::finish() {
    return device::guarded([&] {
        if (search_) search_->finish(*bits_);
        search_.reset();
        return std::move(bits_);
    });
}

}  // namespace clsdf::engine
