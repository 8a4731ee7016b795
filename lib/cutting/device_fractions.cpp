#include "cutting/device_fractions.hpp"

#include "core/parallel_sort.hpp"
#include "cut_grid.h"
#include "cutting/cut_slab.hpp"
#include "device/read_back.hpp"
#include "launch/commands.hpp"
#include "launch/programs.hpp"
#include "launch/short_launches.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace clsdf::cutting {

namespace {

// Upper estimates for one core; they limit the work of a launch.
constexpr double seconds_per_vertex = 2e-7;
constexpr double seconds_per_face = 5e-7;
constexpr double seconds_per_item = 1e-5;
constexpr double seconds_per_record = 2e-6;
constexpr double seconds_per_row = 5e-5;
constexpr double seconds_per_stored = 1e-6;

cl::Program program_of(const engine::DeviceTools& tools, const char* file, const device::BuildWatch& watch = {}) {
    return tools.context.program({file, tools.programs.common_options(1)}, watch);
}
cl::Program cut_cells(const engine::DeviceTools& tools) {
    return program_of(tools, "cut_cells.cl");
}
cl::Program store_cells(const engine::DeviceTools& tools) {
    return program_of(tools, "store_cells.cl");
}

constexpr const char* purpose = "cut cells";
constexpr std::size_t most_numbers = DeviceFractions::most_numbers;

/// Launches a kernel whose last arguments are a range of [0, items), behind these.
template <class... Arguments>
void launch_over(const engine::DeviceTools& tools, const engine::Launches& launches, const cl::Program& program,
                 const char* name, std::size_t items, double core_seconds, const Arguments&... arguments) {
    device::LentKernel kernel = launches.kernel(program, name);
    const cl_uint range = engine::set_arguments(kernel, 0, arguments...);
    engine::ShortLaunches(tools.context, {}).over(items, core_seconds, [&](std::size_t begin, std::size_t end) {
        engine::set_arguments(kernel, range, static_cast<cl_uint>(begin), static_cast<cl_uint>(end));
        launches.launch(kernel, engine::WorkItems{end - begin});
    });
}

template <class... Arguments>
void launch_one(const engine::DeviceTools& tools, const engine::Launches& launches, const char* name,
                const Arguments&... arguments) {
    launches.launch(cut_cells(tools), name, {1}, arguments...);
}

void enqueue_sums(engine::SumLaunches& sums, const engine::Launches& launches) {
    sums.each([&](device::LentKernel& kernel, const engine::WorkItems& items) { launches.launch(kernel, items); });
}

DeviceFractions::Lease lease(const engine::DeviceTools& tools, std::size_t count, std::size_t bytes = sizeof(cl_uint)) {
    return tools.pool->lease(std::max<std::size_t>(count, 1) * bytes, purpose);
}

/// For each corner of a triangle, at which an edge begins, the next corner of the edge's triangles, in a ring.
std::vector<std::uint32_t> rings_of_edges(std::span<const Triangle> triangles) {
    struct Corner {
        std::uint64_t ends;
        std::uint32_t corner;
        bool operator<(const Corner& other) const {
            return ends != other.ends ? ends < other.ends : corner < other.corner;
        }
    };
    std::vector<Corner> corners(3 * triangles.size());
    for (std::uint32_t n = 0; n < corners.size(); ++n) {
        const Triangle& triangle = triangles[n / 3];
        const auto [low, high] = std::minmax(triangle[n % 3], triangle[(n + 1) % 3]);
        corners[n] = {std::uint64_t{low} << 32 | high, n};
    }
    sort_on_all_cores(corners);
    std::vector<std::uint32_t> next(corners.size());
    for (std::size_t begin = 0, end = 0; begin < corners.size(); begin = end) {
        for (end = begin + 1; end < corners.size() && corners[end].ends == corners[begin].ends; ++end)
            next[corners[end - 1].corner] = corners[end].corner;
        next[corners[end - 1].corner] = corners[begin].corner;
    }
    return next;
}

/// Numbers the keys of records.
CutGrid with_keys(CutGrid grid) {
    const auto cells = static_cast<clsdf_uint32>(grid.counts[0] * grid.counts[1] * grid.counts[2]);
    clsdf_uint32 keys = cells;
    for (clsdf_uint32* const from : {grid.faces_from, grid.lines_from})
        for (std::size_t axis = 0; axis < 3; ++axis) {
            from[axis] = keys;
            keys += cells + cells / static_cast<clsdf_uint32>(grid.counts[axis]);
        }
    grid.keys = keys;
    return grid;
}

}  // namespace

std::vector<cl::Program> fraction_programs(const engine::DeviceTools& tools, const device::BuildWatch& watch) {
    return {program_of(tools, "cut_cells.cl", watch), program_of(tools, "store_cells.cl", watch)};
}

DeviceFractions::DeviceFractions(DeviceFractions&&) noexcept = default;
DeviceFractions& DeviceFractions::operator=(DeviceFractions&&) noexcept = default;
DeviceFractions::~DeviceFractions() = default;

bool DeviceFractions::can_number(const Mesh& mesh, const Grid& grid) {
    double cells = 1, faces = 0;
    for (const std::int64_t size : grid.size) cells *= static_cast<double>(size - 1);
    for (const std::int64_t size : grid.size) faces += cells / static_cast<double>(size - 1) + cells;
    return cells + 2 * faces < static_cast<double>(most_numbers) && cells <= std::numeric_limits<clsdf_int32>::max() &&
           mesh.triangles().size() <= most_numbers / 3 && mesh.vertices().size() <= most_numbers;
}

DeviceFractions::DeviceFractions(const engine::DeviceTools& tools, const Mesh& mesh, const Grid& grid,
                                 const FractionOptions& options, bool with_pieces)
    : grid_(std::make_unique<CutGrid>(with_keys(cut_grid_of(grid, options)))),
      faces_(mesh.triangles().size()),
      vertices_(mesh.vertices().size()),
      with_pieces_(with_pieces) {
    device::guarded([&] {
        triangles_ = device::uploaded(tools.context, tools.pool, mesh.triangles(), purpose);
        if (with_pieces)
            next_of_edge_ = device::uploaded(tools.context, tools.pool, rings_of_edges(mesh.triangles()), purpose);
        counts_ = lease(tools, 1, sizeof(CutCounts));
        positions_ = lease(tools, vertices_, sizeof(CutPoint));
        layers_ = lease(tools, faces_);
        layer_starts_ = lease(tools, faces_ + 1);
        layer_sums_.emplace(tools, *layers_, *layer_starts_, faces_, "layers of triangles");
    });
}

void DeviceFractions::enqueue_layers(const engine::DeviceTools& tools, const engine::Launches& launches,
                                     const engine::DeviceTriples& vertices) {
    const cl::Program program = cut_cells(tools);
    launch_one(tools, launches, "begin_cuts", *counts_);
    launch_over(tools, launches, program, "place_vertices", vertices_, seconds_per_vertex, *grid_, vertices.steps,
                vertices.memory, *positions_, *counts_);
    launch_over(tools, launches, program, "count_layers", faces_, seconds_per_face, *grid_, *triangles_, *positions_,
                *counts_, *layers_);
    enqueue_sums(*layer_sums_, launches);
}

void DeviceFractions::make_item_room(const engine::DeviceTools& tools, std::size_t items) {
    device::guarded([&] {
        record_sums_.reset();
        item_records_ = lease(tools, items);
        record_starts_ = lease(tools, items + 1);
        record_sums_.emplace(tools, *item_records_, *record_starts_, items, "layers of triangles");
        item_room_ = items;
    });
}

void DeviceFractions::enqueue_record_counts(const engine::DeviceTools& tools, const engine::Launches& launches) {
    launch_one(tools, launches, "limit_items", layer_sums_->sums(), static_cast<cl_uint>(layer_sums_->parts()),
               static_cast<cl_uint>(item_room_), *counts_);
    launch_over(tools, launches, cut_cells(tools), "count_records", item_room_, seconds_per_item, *grid_, *triangles_,
                *positions_, static_cast<cl_uint>(faces_), *layer_starts_, *counts_, *item_records_);
    enqueue_sums(*record_sums_, launches);
}

void DeviceFractions::make_record_room(const engine::DeviceTools& tools, std::size_t records) {
    device::guarded([&] {
        head_sums_.reset();
        sums_of_ways_.reset();
        sort_.reset();
        for (Lease* const words : {&keys_, &key_copies_, &words_, &order_, &sorted_words_, &heads_, &ways_})
            *words = lease(tools, records);
        row_starts_ = lease(tools, records + 1);
        way_sums_ = lease(tools, records + 1);
        head_sums_.emplace(tools, *heads_, *row_starts_, records, "triangles in cells");
        sums_of_ways_.emplace(tools, *ways_, *way_sums_, records, "triangles in cells");
        sort_.emplace(*tools.pool, std::max<std::size_t>(records, 1));
        record_room_ = records;
    });
}

void DeviceFractions::enqueue_records(const engine::DeviceTools& tools, const engine::Launches& launches) {
    const cl::Program program = cut_cells(tools);
    launch_one(tools, launches, "limit_records", record_sums_->sums(), static_cast<cl_uint>(record_sums_->parts()),
               static_cast<cl_uint>(record_room_), *counts_);
    launch_over(tools, launches, program, "write_records", item_room_, seconds_per_item, *grid_, *triangles_,
                *positions_, static_cast<cl_uint>(faces_), *layer_starts_, *counts_, *record_starts_, *keys_, *words_);
    launch_over(tools, launches, program, "copy_keys", record_room_, seconds_per_record, *grid_, *counts_, *keys_,
                *key_copies_);
    if (record_room_ > 0)
        engine::sort_by_keys(launches, tools.programs, *sort_, *keys_, record_room_,
                             static_cast<unsigned>(std::bit_width(grid_->keys)), *order_);
    // The sort needs the keys no more.
    launch_over(tools, launches, program, "take_sorted", record_room_, seconds_per_record, *grid_, *counts_, *order_,
                *key_copies_, *words_, *keys_, *sorted_words_, *heads_, *ways_);
    enqueue_sums(*head_sums_, launches);
    enqueue_sums(*sums_of_ways_, launches);
}

void DeviceFractions::make_row_room(const engine::DeviceTools& tools, std::size_t rows) {
    device::guarded([&] {
        rows_ = lease(tools, rows, sizeof(FractionRow));
        row_firsts_ = lease(tools, rows + 1);
        row_room_ = rows;
    });
}

void DeviceFractions::enqueue_rows(const engine::DeviceTools& tools, const engine::Launches& launches,
                                   std::size_t asked) {
    const cl::Program program = cut_cells(tools);
    launch_one(tools, launches, "limit_rows", *row_starts_, static_cast<cl_uint>(record_room_),
               static_cast<cl_uint>(std::min(asked, most_numbers)), static_cast<cl_uint>(row_room_), *counts_);
    if (row_room_ == 0) return;
    // The order is known, so its memory has the sets of joined faces.
    launch_over(tools, launches, program, "list_rows", record_room_, seconds_per_record, *grid_, *counts_, *keys_,
                *heads_, *row_starts_, *row_firsts_, *order_);
    if (with_pieces_)
        launch_over(tools, launches, program, "join_faces", record_room_, seconds_per_record, *grid_, *triangles_,
                    *positions_, *next_of_edge_, *counts_, *sorted_words_, *row_starts_, *row_firsts_, *keys_, *order_);
    launch_over(tools, launches, program, "write_rows", row_room_, seconds_per_row, *grid_, *triangles_, *positions_,
                *counts_, *keys_, *sorted_words_, *way_sums_, *row_firsts_, *order_, cl_int{with_pieces_ ? 1 : 0},
                *rows_);
}

void DeviceFractions::enqueue_all(const engine::DeviceTools& tools, const engine::Launches& launches,
                                  const engine::DeviceTriples& vertices, std::size_t asked) {
    enqueue_layers(tools, launches, vertices);
    enqueue_record_counts(tools, launches);
    enqueue_records(tools, launches);
    enqueue_rows(tools, launches, asked);
}

bool DeviceFractions::run_and_make_room(const engine::DeviceTools& tools, const engine::DeviceTriples& vertices,
                                        std::size_t most, const std::function<void(double)>& between) {
    return device::guarded([&] {
        const engine::Launches launches(tools.queue(), tools.context.kernels());
        enqueue_layers(tools, launches, vertices);
        // With room for none the numbers are told.
        launch_one(tools, launches, "limit_items", layer_sums_->sums(), static_cast<cl_uint>(layer_sums_->parts()),
                   cl_uint{0}, *counts_);
        FoundCells found = read(tools);
        if (found.far_vertex != CLSDF_NO_VERTEX) return false;
        if (found.items > most_numbers) throw engine::too_many("layers of triangles in the cells");
        between(0.1);
        make_item_room(tools, found.items);
        enqueue_record_counts(tools, launches);
        launch_one(tools, launches, "limit_records", record_sums_->sums(), static_cast<cl_uint>(record_sums_->parts()),
                   cl_uint{0}, *counts_);
        found = read(tools);
        if (found.records > most_numbers) throw engine::too_many("triangles in cells");
        between(0.3);
        make_record_room(tools, found.records);
        enqueue_records(tools, launches);
        row_room_ = 0;
        enqueue_rows(tools, launches, most_numbers);
        found = read(tools);
        between(0.6);
        if (most == 0 || found.rows > most) return true;
        make_row_room(tools, found.rows);
        enqueue_rows(tools, launches, found.rows);
        return true;
    });
}

FoundCells DeviceFractions::read(const engine::DeviceTools& tools) const {
    static_assert(sizeof(FoundCells) == sizeof(CutCounts) &&
                  offsetof(FoundCells, items) == offsetof(CutCounts, items) &&
                  offsetof(FoundCells, far_vertex) == offsetof(CutCounts, far_vertex));
    return device::read_value<FoundCells>(tools.context, *counts_);
}

void DeviceFractions::enqueue_store(const engine::DeviceTools& tools, const engine::Launches& launches,
                                    const StoredCells& to) const {
    static_assert(static_cast<int>(StoredNumbers::words) == CLSDF_STORED_WORDS &&
                  static_cast<int>(StoredNumbers::doubles) == CLSDF_STORED_DOUBLES &&
                  static_cast<int>(StoredNumbers::floats) == CLSDF_STORED_FLOATS);
    launch_over(tools, launches, store_cells(tools), "store_rows", row_room_, seconds_per_stored, *counts_, *rows_,
                static_cast<cl_int>(to.member), static_cast<cl_int>(to.components), static_cast<cl_int>(to.numbers),
                static_cast<cl_long>(to.first), static_cast<cl_long>(to.stride),
                static_cast<cl_long>(to.component_stride), cl::Buffer(to.memory, true));
}

void DeviceFractions::enqueue_store_full(const engine::DeviceTools& tools, const engine::Launches& launches,
                                         const StoredCells& to) const {
    const cl::Program program = store_cells(tools);
    const cl::Buffer memory(to.memory, true);
    const auto lines = static_cast<std::size_t>(grid_->counts[0]) * static_cast<std::size_t>(grid_->counts[2]);
    const auto first = static_cast<cl_long>(to.first), stride = static_cast<cl_long>(to.stride);
    launch_over(tools, launches, program, "store_full", lines,
                seconds_per_stored * static_cast<double>(grid_->counts[1]), *grid_, *triangles_, *positions_, *counts_,
                *keys_, *sorted_words_, *way_sums_, first, stride, memory);
    launch_over(tools, launches, program, "clear_full", record_room_, seconds_per_stored, *grid_, *counts_, *keys_,
                first, stride, memory);
}

std::size_t DeviceFractions::device_bytes() const {
    std::size_t bytes = 0;
    for (const Lease* const one : {&triangles_, &next_of_edge_, &counts_, &positions_, &layers_, &layer_starts_,
                                   &item_records_, &record_starts_, &keys_, &key_copies_, &words_, &order_,
                                   &sorted_words_, &heads_, &ways_, &row_starts_, &way_sums_, &row_firsts_, &rows_})
        bytes += one->bytes();
    for (const auto* const sums : {&layer_sums_, &record_sums_, &head_sums_, &sums_of_ways_})
        if (*sums) bytes += (*sums)->bytes();
    return bytes + (sort_ ? sort_->device_bytes() : 0);
}

engine::DeviceTriples device_vertices(const cl::Buffer& packed, std::size_t count) {
    engine::DeviceTriples vertices{packed, count, {}};
    vertices.steps.triple = 6;  // words
    vertices.steps.number = 2;
    vertices.steps.is_long = 1;
    return vertices;
}

engine::DeviceTriples given_vertices(const InputArray& vertices) {
    return engine::device_triples(vertices);
}

}  // namespace clsdf::cutting
