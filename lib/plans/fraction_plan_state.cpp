#include "plans/fraction_plan_state.hpp"

#include "core/refuse.hpp"
#include "cutting/fraction_checks.hpp"
#include "mesh/input_arrays.hpp"
#include "points/device_points.hpp"
#include "targets/mapped_memory.hpp"
#include "targets/row_arrays.hpp"

#include <clsdf/error.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>

namespace clsdf::plans {

namespace {

using cutting::StoredNumbers;
using targets::ResultArray;

bool is_on_host(const OutputArray& array) {
    return array.is_given() && array.device == nullptr;
}

cutting::StoredCells stored(const ResultArray& array, std::size_t member, cutting::StoredNumbers numbers) {
    const targets::ItemLayout layout = array.layout();
    return {
        layout.memory, layout.first, layout.strides[0], layout.component_stride, static_cast<int>(layout.components),
        member,        numbers};
}

}  // namespace

bool are_on_device(const FractionRows& rows) {
    return !is_on_host(rows.full) && std::ranges::none_of(cell_columns, [&](const CellColumn& column) {
        return is_on_host(rows.*column.target);
    });
}

StoredRows::StoredRows(const FractionRows& rows, const Grid& grid, const device::Context& context)
    : has_pieces(rows.pieces.is_given()) {
    using enum ElementType;
    const auto array_of = [&](const OutputArray& array, const char* name, const Index3& size, std::size_t components,
                              const ElementTypes& types) {
        return ResultArray::on_device(array, name, size, components, types, context, false);
    };
    const targets::RowArrays<CellColumn> arrays(cell_columns, rows, array_of);
    arrays.add_to(written);
    static const std::vector<CellFraction> one(1);  // for the places of its members
    arrays.for_each_given([&](std::size_t n, const ResultArray& array) {
        if (rows.room == 0) return;
        const std::byte* const member = cell_columns[n].values(one).first;
        members.push_back(stored(array,
                                 static_cast<std::size_t>(member - reinterpret_cast<const std::byte*>(one.data())),
                                 array.type() == float64   ? StoredNumbers::doubles
                                 : array.type() == float32 ? StoredNumbers::floats
                                                           : StoredNumbers::words));
    });
    if (!rows.full.is_given()) return;
    const auto [nx, ny, nz] = Fractions{grid, {}, {}}.counts();
    const std::size_t count = nx * ny * nz;
    const ResultArray of_full =
        array_of(rows.full, "the array of full cells", {static_cast<std::int64_t>(count), 1, 1}, 1, {uint8});
    written.push_back(of_full.written());
    full = stored(of_full, 0, StoredNumbers::words);
}

void StoredRows::enqueue(const cutting::DeviceFractions& cuts, const engine::DeviceTools& tools,
                         const engine::Launches& launches) const {
    for (const cutting::StoredCells& member : members) cuts.enqueue_store(tools, launches, member);
    if (full) cuts.enqueue_store_full(tools, launches, *full);
}

void FractionPlanState::make(const OuterSurface& surface, AskedFractions asked,
                             const std::function<void(double)>& between) {
    // What bodies that move need beside what they need now.
    const auto with_slack = [](std::size_t count) {
        return std::min(count + count / 4 + 1024, cutting::DeviceFractions::most_numbers);
    };
    update(std::move(asked), [&] {
        const AskedFractions& now = this->asked();
        cutting::check_cells(now.grid);
        cutting::check_options(now.options);
        if (!cutting::DeviceFractions::can_number(surface.mesh, now.grid))
            refuse_unsupported(
                "32 bits cannot number the cells of the grid and their faces, or the triangles; plan a part of "
                "the grid");
        context().begin_call();
        PlannedFractions made;
        context().run_or_drain([&] {
            const engine::DeviceTools tools = this->tools();
            made.vertices = device::uploaded(context(), pool, surface.mesh.vertices(), "vertices");
            cutting::DeviceFractions& cuts = made.cuts.emplace(tools, surface.mesh, now.grid, now.options, true);
            if (!cuts.run_and_make_room(tools, cutting::device_vertices(*made.vertices, cuts.vertex_count()), 0,
                                        between))
                cutting::refuse_far_vertices(surface.mesh, now.grid);
            cuts.make_item_room(tools, with_slack(cuts.item_room()));
            cuts.make_record_room(tools, with_slack(cuts.record_room()));
            cuts.make_row_room(tools, now.room);
            // Drivers may allocate a buffer when it is used first.
            cuts.enqueue_all(tools, engine::Launches(tools.queue(), context().kernels()),
                             cutting::device_vertices(*made.vertices, cuts.vertex_count()), now.room);
            made.rows = cuts.read(tools).rows;
        });
        made_ = std::move(made);
        pool->hand_back();
        published = {};
        published.device_bytes = made_.cuts->device_bytes() + made_.vertices.bytes();
        failures = context().failures();
    });
}

void FractionPlanState::enqueue(const RunOptions& options, const InputArray* vertices, const FractionRows& rows,
                                const DeviceRange& count) {
    require_whole();
    if (rows.room > asked().room)
        refuse(
            "the arrays have room for {} cells, and the plan has room for {}; give that, or make "
            "the plan with more",
            rows.room, asked().room);
    const device::Context& context = this->context();
    cutting::DeviceFractions& cuts = *made_.cuts;
    StoredRows stored(rows, asked().grid, context);
    engine::DeviceTriples from = cutting::device_vertices(*made_.vertices, cuts.vertex_count());
    if (vertices != nullptr) {
        check_array(*vertices, ArrayKind::positions, "vertices", ErrorCode::invalid_argument);
        if (vertices->count != cuts.vertex_count())
            refuse(
                "{} vertices are given, and the surface of the plan has {}; give as many, in its "
                "order",
                vertices->count, cuts.vertex_count());
        points::check_device_points(context, *vertices);
        stored.written.push_back(points::array_of(*vertices));
        from = cutting::given_vertices(*vertices);
    }
    cl::Buffer of_count;
    if (count.memory != nullptr) {
        of_count = targets::checked_range(context, count, sizeof(DeviceFractionCount), sizeof(std::uint64_t),
                                          "the memory of the count");
        const targets::BufferPlace begin = targets::place_of(count.memory, count.offset);
        stored.written.push_back({.memory = begin.memory(),
                                  .first = begin.byte,
                                  .width = sizeof(DeviceFractionCount),
                                  .name = "the memory of the count"});
    }
    targets::refuse_overlap(stored.written);
    // Full cells alone need no room.
    const std::size_t most = targets::has_rows(cell_columns, rows) ? rows.room
                             : rows.full.is_given()                ? SIZE_MAX
                                                                   : asked().room;
    run(options, [&](engine::CommandChain& chain) {
        const engine::Launches launches(chain, context.kernels());
        const engine::DeviceTools tools = this->tools();
        cuts.enqueue_all(tools, launches, from, most);
        stored.enqueue(cuts, tools, launches);
        if (of_count() == nullptr) return;
        chain.then([&](auto& queue, auto* wait, auto* event) {
            queue.enqueueCopyBuffer(cuts.counts(), of_count, 0, count.offset, sizeof(DeviceFractionCount), wait, event);
        });
    });
}

}  // namespace clsdf::plans
