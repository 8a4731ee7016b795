#include "sign/sign_sweep.hpp"

#include "core/parallel.hpp"
#include "device/opencl.hpp"
#include "lattice/layout_of.hpp"
#include "launch/commands.hpp"
#include "launch/programs.hpp"
#include "sign/row_records.hpp"

#include <cstddef>
#include <utility>

namespace clsdf::engine {

namespace {

// The first room for crossings, per row on average (see sign_bytes_of_slice).
constexpr std::size_t records_per_row = 4;

constexpr double seconds_per_word = 5e-9;  // of sign bits; an upper estimate for one core

// Rows that lie together, most of which meet no surface, of one work-item on a processor.
constexpr std::size_t rows_of_a_core = 64;

}  // namespace

/// The launches that find the crossings of the part's rows of samples and the surface, and make bits of them.
class CrossingSearch {
public:
    /// film: crossings that are known; it must outlive this.
    CrossingSearch(const SweepInputs& inputs, const FilmCrossings& film)
        : inputs_(inputs), records_(search_of(inputs), film.records, film.row_counts) {}

    /// Enqueues the search; does not wait.
    void begin() { records_.begin(); }

    /// See RowRecords::finish(). Enqueues the launches that make the bits.
    void finish(const cl::Buffer& bits) {
        const RowKeys found = records_.finish();
        const Layout& layout = inputs_.layout;
        const Programs& programs = inputs_.tools.programs;
        const std::size_t rows = sign_row_count(layout);
        device::LentKernel sweep = inputs_.tools.kernel(programs.sign_sweep, "sign_rows");
        const std::size_t item_rows = programs.body == KernelBody::by_group ? 1 : rows_of_a_core;
        const double words_and_keys =
            layout.sign_words + 8.0 * static_cast<double>(found.count) / static_cast<double>(rows);
        inputs_.launches.over(rows, seconds_per_word * words_and_keys, [&](std::size_t begin, std::size_t end) {
            const std::size_t items = chunk_count(end - begin, item_rows);
            engine::launch(inputs_.tools.queue(), sweep, {items, programs.part_group()}, layout,
                           static_cast<cl_uint>(begin), static_cast<cl_uint>(end), static_cast<cl_uint>(item_rows),
                           cl_int{inputs_.rule == SignRule::parity ? 1 : 0}, *found.starts, *found.keys, bits);
        });
    }

private:
    static RecordSearch search_of(const SweepInputs& inputs) {
        const DeviceTools& tools = inputs.tools;
        const SweepMesh& mesh = *inputs.mesh;
        Layout seen = inputs.layout;  // from where the mesh's x is counted
        seen.brick_first[0] -= mesh.first_x / CLSDF_BRICK;
        device::LentKernel kernel = tools.kernel(tools.programs.sign_sweep, "sign_crossings");
        const cl_uint arguments =
            set_arguments(kernel, 0, seen, mesh.triangles(), *mesh.vertices, cl_int{mesh.bits_y}, cl_int{mesh.bits_z});
        const bool has_selection = inputs.selection.triangles() != nullptr;
        const std::size_t rows = sign_row_count(inputs.layout);
        return {.tools = tools,
                .launches = inputs.launches,
                .program = tools.programs.sign_sweep,
                .kernel = std::move(kernel),
                .arguments = arguments,
                .rows = rows,
                .triangles = has_selection ? inputs.selection.count : mesh.triangle_count,
                .chosen = inputs.selection.triangles,
                .first_room = records_per_row * rows,
                .purpose = "crossings of the sign's sweep",
                .listed = "crossings of the surface by rows of samples"};
    }

    const SweepInputs& inputs_;
    RowRecords records_;
};

SignSweep::SignSweep(const SweepInputs& inputs) : inputs_(inputs) {
    device::guarded([&] {
        const std::size_t bytes = sign_bytes(inputs.layout);
        if (inputs.make_bits) {
            bits_ = inputs.make_bits(inputs.layout);
            return;
        }
        bits_ = inputs.tools.pool->lease(bytes, "sign bits");
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
