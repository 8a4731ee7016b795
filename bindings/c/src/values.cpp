#include "values.hpp"

#include <clsdf/topology_table.h>
#include <clsdf/field.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <string>

namespace clsdf::c {

namespace {

Vec3 triple(const double* values) {
    return {values[0], values[1], values[2]};
}
Index3 triple(const std::int64_t* values) {
    return {values[0], values[1], values[2]};
}
template <typename Value>
void store(const std::array<Value, 3>& from, Value* to) {
    std::copy(from.begin(), from.end(), to);
}

/// Sets what inputs and outputs have in common.
void set_layout(const clsdf_array& from, ArrayLayout& to) {
    to.type = enumerator(from.type, ElementType::uint8, "clsdf_array.type");
    to.offset = count_of(from.offset, "clsdf_array.offset");
    for (std::size_t axis = 0; axis < 3; ++axis) to.strides[axis] = from.strides[axis];
    to.component_stride = from.component_stride;
    const std::size_t bytes = count_of(from.bytes, "clsdf_array.bytes");
    if (bytes > 0) to.bytes = bytes;
}

bool is_packed(const clsdf_array& array) {
    return array.offset == 0 && array.component_stride == 0 && array.block_stride == 0 &&
           std::all_of(array.strides, array.strides + 3, [](std::int64_t stride) { return stride == 0; });
}

OutputArray output_array_of(const clsdf_array& array) {
    OutputArray result;
    set_layout(array, result);
    result.is_pinned = flag(array.pinned, "clsdf_array.pinned");
    result.host = array.host;
    result.device = static_cast<cl_mem>(array.device);
    result.block_stride = array.block_stride;
    count_of(array.count, "clsdf_array.count");
    return result;
}

/// Samples of so many boxes; nothing if they cannot be counted, which the library refuses.
std::optional<std::int64_t> samples_of(const Index3& size, std::int64_t boxes) {
    std::int64_t samples = boxes;
    for (const std::int64_t length : size)
        if (length < 1 || __builtin_mul_overflow(samples, length, &samples)) return std::nullopt;
    return samples;
}

/// owner(items): what has the items, as "the grid has 8 samples".
template <typename Owner>
void check_count(const clsdf_target& target, std::int64_t items, const Owner& owner) {
    const clsdf_array& array = target.array;
    if (items == 0 || array.count == 0 || array.count == items || (array.host == nullptr && array.device == nullptr))
        return;
    const OutputInfo& info = info_of(static_cast<Output>(target.output));
    throw misuse(owner(std::to_string(items)) + ", and the array of the output " + info.name + " has " +
                 std::to_string(array.count) + "; give it exactly " + std::to_string(items) +
                 " items, or the count 0 if it is not known");
}

template <typename Owner>
void check_counts(const clsdf_targets& targets, std::optional<std::int64_t> items, const Owner& owner) {
    for (std::int64_t i = 0; items && i < targets.count; ++i) check_count(targets.items[i], *items, owner);
}

}  // namespace

Box box_of(const clsdf_box* box) {
    const clsdf_box& from = given(box, "box");
    return {triple(from.lower), triple(from.upper)};
}

clsdf_box as_c(const Box& box) {
    clsdf_box result{};
    store(box.lower, result.lower);
    store(box.upper, result.upper);
    return result;
}

Band band_of(const clsdf_band* band) {
    const clsdf_band& from = given(band, "band");
    return {from.inside, from.outside, flag(from.signs_only, "clsdf_band.signs_only"),
            flag(from.exact_signs, "clsdf_band.exact_signs")};
}

clsdf_band as_c(const Band& band) {
    return {band.inside, band.outside, band.has_signs_only ? 1 : 0, band.has_exact_signs ? 1 : 0};
}

Grid grid_of(const clsdf_grid* grid) {
    const clsdf_grid& from = given(grid, "grid");
    return {triple(from.origin), triple(from.spacing), triple(from.size), triple(from.first)};
}

clsdf_grid as_c(const Grid& grid) {
    clsdf_grid result{};
    store(grid.origin, result.origin);
    store(grid.spacing, result.spacing);
    store(grid.size, result.size);
    store(grid.first, result.first);
    return result;
}

Length length_of(const clsdf_length* length, const char* name) {
    const clsdf_length& from = given(length, name);
    check_reserved(from.reserved, "clsdf_length");
    return {from.value, enumerator(from.unit, Length::Unit::extent, "clsdf_length.unit")};
}

InputArray input_of(const clsdf_array* array, const char* name) {
    const clsdf_array& from = given(array, name);
    InputArray result;
    set_layout(from, result);
    if (from.type == CLSDF_AUTOMATIC)
        throw misuse(std::string(name) + ".type is 0; state the type of its numbers, as CLSDF_FLOAT64");
    result.count = count_of(from.count, "clsdf_array.count");
    if (result.count > 0 && (from.host == nullptr) == (from.device == nullptr))
        throw misuse(std::string(name) +
                     (from.host == nullptr ? " has no memory" : " has memory of the host and of the device") +
                     "; give it one address: host or device");
    result.host = from.host;
    result.device = static_cast<cl_mem>(from.device);
    result.strides[1] = result.strides[2] = 0;
    return result;
}

namespace {

OutputTargets targets_of(const clsdf_target* targets, std::int64_t count) {
    elements(targets, count, "targets");
    OutputTargets result;
    for (std::int64_t i = 0; i < count; ++i) {
        check_reserved(targets[i].reserved, "clsdf_target");
        const OutputInfo& info = info_of(static_cast<Output>(targets[i].output));
        const OutputArray array = output_array_of(targets[i].array);
        if (result.find(info.output) != nullptr)
            throw misuse(std::string("the output ") + info.name + " has two targets; give it one");
        result[info.output] = array;
    }
    return result;
}

}  // namespace

OutputTargets targets_of(const clsdf_targets& targets, const Grid& grid) {
    OutputTargets result = targets_of(targets.items, targets.count);
    check_counts(targets, samples_of(grid.size, 1),
                 [](const std::string& samples) { return "the grid has " + samples + " samples"; });
    return result;
}

OutputTargets targets_of(const clsdf_targets& targets, std::size_t points) {
    OutputTargets result = targets_of(targets.items, targets.count);
    check_counts(targets, static_cast<std::int64_t>(points),
                 [](const std::string& count) { return "there are " + count + " points"; });
    return result;
}

OutputArray output_of(const clsdf_array* array, const char* name, std::size_t points) {
    const clsdf_array& from = given(array, name);
    clsdf_target target{CLSDF_DISTANCE, 0, from};
    check_counts(clsdf_targets{&target, 1}, static_cast<std::int64_t>(points),
                 [](const std::string& count) { return "there are " + count + " points"; });
    if (from.host == nullptr && from.device == nullptr)
        throw misuse(std::string(name) + " has no memory; give it one address: host or device");
    return output_array_of(from);
}

Hits hits_of(std::int32_t hits, const char* name) {
    return enumerator(hits, Hits::faces, name);
}

OutputArray items_of(const clsdf_array& array, std::size_t items, const char* what, const char* name) {
    const std::size_t count = count_of(array.count, name);
    if (array.host == nullptr && array.device == nullptr) return {};
    if (count != 0 && count != items)
        throw misuse("there are " + std::to_string(items) + " " + what + ", and " + name + " is " +
                     std::to_string(count) + "; give it exactly " + std::to_string(items) +
                     " items, or the count 0 if it is not known");
    return output_array_of(array);
}

RayTargets ray_targets_of(const clsdf_ray_request& request, std::size_t rays) {
    const auto array_of = [rays](const clsdf_array& array, const char* name) {
        return items_of(array, rays, "rays", name);
    };
    return {.most = count_of(request.most, "clsdf_ray_request.most"),
            .t = array_of(request.t, "clsdf_ray_request.t.count"),
            .triangles = array_of(request.triangles, "clsdf_ray_request.triangles.count"),
            .counts = array_of(request.counts, "clsdf_ray_request.counts.count"),
            .any = array_of(request.any, "clsdf_ray_request.any.count")};
}

std::span<const LinkDirection> directions_of(const std::int32_t* directions, std::int64_t count) {
    static_assert(sizeof(LinkDirection) == 3 * sizeof(std::int32_t));
    elements(directions, count, "directions");
    return {reinterpret_cast<const LinkDirection*>(directions), static_cast<std::size_t>(count)};
}

LinkOptions link_options_of(const clsdf_link_options* options) {
    if (options == nullptr) return {};
    return {hits_of(options->hits, "clsdf_link_options.hits"),
            flag(options->with_between, "clsdf_link_options.with_between")};
}

LinkTargets link_targets_of(const clsdf_link_buffers& buffers, std::size_t samples) {
    LinkTargets targets;
    targets.room = count_of(buffers.room, "clsdf_link_buffers.room");
    const auto rows = [&targets](const clsdf_array& array, const char* name) {
        return items_of(array, targets.room, "rows", name);
    };
    targets.samples = rows(buffers.samples, "clsdf_link_buffers.samples.count");
    targets.directions = rows(buffers.directions, "clsdf_link_buffers.directions.count");
    targets.q = rows(buffers.q, "clsdf_link_buffers.q.count");
    targets.triangles = rows(buffers.triangles, "clsdf_link_buffers.triangles.count");
    targets.counts = rows(buffers.counts, "clsdf_link_buffers.counts.count");
    targets.flags = rows(buffers.flags, "clsdf_link_buffers.flags.count");
    targets.inside = items_of(buffers.inside, samples, "samples", "clsdf_link_buffers.inside.count");
    targets.dense = items_of(buffers.dense, samples, "samples", "clsdf_link_buffers.dense.count");
    return targets;
}

clsdf_target as_c(const OutputTarget& target) {
    clsdf_target result{};
    const OutputArray& array = target.array;
    result.output = static_cast<std::int32_t>(target.output);
    result.array.host = array.host;
    result.array.device = array.device;
    result.array.offset = static_cast<std::int64_t>(array.offset);
    std::copy(array.strides.begin(), array.strides.end(), result.array.strides);
    result.array.component_stride = array.component_stride;
    result.array.block_stride = array.block_stride;
    result.array.bytes = array.bytes == ArrayLayout::unknown_size ? 0 : static_cast<std::int64_t>(array.bytes);
    result.array.type = static_cast<std::int32_t>(array.type);
    return result;
}

OutputSet outputs_of(std::uint32_t bits) {
    OutputSet known;
    for (const OutputInfo& info : output_table()) known.insert(info.output);
    if ((bits & ~known.bits()) != 0)
        throw misuse("the set of outputs has the bits " + std::to_string(bits) + "; those of outputs are " +
                     std::to_string(known.bits()) + ": combine CLSDF_SET(...) of them");
    return bits == 0 ? OutputSet(Output::distance) : OutputSet::from_bits(bits);
}

std::vector<clsdf_target> as_c(const FieldSlab& slab) {
    std::vector<clsdf_target> result;
    for (const OutputInfo& info : output_table()) {
        const std::span<const std::byte> bytes = slab.bytes(info.output);
        const std::size_t sample = info.sample_bytes();
        if (bytes.empty() || sample == 0) continue;
        result.push_back({static_cast<std::int32_t>(info.output), 0,
                          clsdf_host_array(static_cast<std::int32_t>(info.type), bytes.data(),
                                           static_cast<std::int64_t>(bytes.size() / sample))});
        result.back().array.bytes = static_cast<std::int64_t>(bytes.size());
    }
    return result;
}

FieldSlab slab_of(const clsdf_target* values, std::int64_t count, std::int64_t samples) {
    elements(values, count, "values");
    FieldSlab slab;
    const std::size_t items = count_of(samples, "the number of samples");
    for (std::int64_t i = 0; i < count; ++i) {
        check_reserved(values[i].reserved, "clsdf_target");
        const OutputInfo& info = info_of(static_cast<Output>(values[i].output));
        const OutputArray array = output_array_of(values[i].array);
        if (array.host == nullptr && array.device == nullptr) continue;
        const std::size_t bytes = items * info.sample_bytes();
        if (array.type != ElementType::automatic && array.type != info.type)
            throw misuse(std::string("the values of the output ") + info.name + " are " + name_of(array.type) +
                         ", and files have " + name_of(info.type) + "; give an array of that type");
        check_count(values[i], samples, [](const std::string& all) { return "there are " + all + " samples"; });
        if (array.device != nullptr || !is_packed(values[i].array) ||
            (array.bytes != ArrayLayout::unknown_size && array.bytes != bytes))
            throw misuse(std::string("the values of the output ") + info.name + " are not " + std::to_string(items) +
                         " packed items on the host; copy them to such an array");
        slab.set(info.output, std::span(static_cast<const std::byte*>(array.host), bytes));
    }
    return slab;
}

static_assert(is_triple<Index3, std::int64_t> && std::is_standard_layout_v<BrickRun> &&
              sizeof(BrickRun) == sizeof(clsdf_brick_run) &&
              offsetof(BrickRun, first) == offsetof(clsdf_brick_run, first) &&
              offsetof(BrickRun, count) == offsetof(clsdf_brick_run, count));

clsdf_sparse_slab as_c(const SparseSlab& slab, const std::vector<clsdf_target>& values) {
    clsdf_sparse_slab result = CLSDF_SPARSE_SLAB_INIT;
    result.part = as_c(slab.part);
    result.bricks = reinterpret_cast<const std::int64_t*>(slab.bricks.data());
    result.brick_count = static_cast<std::int64_t>(slab.bricks.size());
    result.inside = reinterpret_cast<const clsdf_brick_run*>(slab.inside.data());
    result.run_count = static_cast<std::int64_t>(slab.inside.size());
    result.values = {values.data(), static_cast<std::int64_t>(values.size())};
    return result;
}

SparseSlab sparse_slab_of(const clsdf_sparse_slab* slab) {
    const clsdf_sparse_slab from = read_given(slab, CLSDF_SPARSE_SLAB_INIT, "clsdf_sparse_slab");
    const std::size_t bricks = count_of(from.brick_count, "clsdf_sparse_slab.brick_count");
    const std::size_t runs = count_of(from.run_count, "clsdf_sparse_slab.run_count");
    elements(from.bricks, from.brick_count, "clsdf_sparse_slab.bricks");
    elements(from.inside, from.run_count, "clsdf_sparse_slab.inside");
    elements(from.values.items, from.values.count, "clsdf_sparse_slab.values");
    std::int64_t samples = 0;
    if (__builtin_mul_overflow(from.brick_count, std::int64_t{CLSDF_BRICK_SAMPLES}, &samples))
        throw misuse("clsdf_sparse_slab.brick_count is " + std::to_string(from.brick_count) +
                     "; no field has so many bricks");
    std::vector<clsdf_target> values(from.values.items, from.values.items + from.values.count);
    for (clsdf_target& value : values) {
        clsdf_array& array = value.array;
        if (array.count > samples) {
            array.count = samples;
            array.bytes = 0;
        }
        if (value.output == CLSDF_TRIANGLE && array.type == CLSDF_INT32) array.type = CLSDF_UINT32;
    }
    return {grid_of(&from.part),
            {reinterpret_cast<const Index3*>(from.bricks), bricks},
            slab_of(values.data(), static_cast<std::int64_t>(values.size()), samples),
            {reinterpret_cast<const BrickRun*>(from.inside), runs}};
}

SignRule sign_rule_of(std::int32_t rule, const char* name) {
    return enumerator(rule, SignRule::below, name);
}

Surface surface_of(std::int32_t surface, const char* name) {
    return enumerator(surface, Surface::outer, name);
}

clsdf_topology as_c(const Topology& topology) {
    clsdf_topology result = CLSDF_TOPOLOGY_INIT;
    result.closed = topology.closed ? 1 : 0;
    result.balanced = topology.balanced ? 1 : 0;
    result.inside_out = topology.inside_out ? 1 : 0;
    const auto copy = [](const std::vector<Topology::Edge>& edges, clsdf_edge(&to)[5]) {
        const std::size_t count = std::min(edges.size(), std::size(to));
        for (std::size_t i = 0; i < count; ++i) {
            store(edges[i].from, to[i].from);
            store(edges[i].to, to[i].to);
        }
        return static_cast<std::int64_t>(count);
    };
    result.first_open_count = copy(topology.first_open_edges, result.first_open);
    result.first_unbalanced_count = copy(topology.first_unbalanced_edges, result.first_unbalanced);
#define CLSDF_COPY(member, meaning) result.member = static_cast<std::int64_t>(topology.member);
    CLSDF_TOPOLOGY_COUNTS(CLSDF_COPY)
#undef CLSDF_COPY
    return result;
}

clsdf_kept_memory as_c(const KeptMemory& memory) {
    return {sizeof(clsdf_kept_memory), static_cast<std::int64_t>(memory.host_bytes),
            static_cast<std::int64_t>(memory.device_bytes), static_cast<std::int64_t>(memory.shared_host_bytes),
            static_cast<std::int64_t>(memory.shared_device_bytes)};
}

std::span<const Box> boxes_of(const clsdf_box* boxes, std::int64_t count) {
    static_assert(std::is_standard_layout_v<Box> && sizeof(Box) == sizeof(clsdf_box) &&
                  offsetof(Box, lower) == offsetof(clsdf_box, lower) &&
                  offsetof(Box, upper) == offsetof(clsdf_box, upper));
    elements(boxes, count, "boxes");
    return {reinterpret_cast<const Box*>(boxes), static_cast<std::size_t>(count)};
}

std::span<BoxPlace> places_of(std::uint8_t* places, std::int64_t count) {
    static_assert(sizeof(BoxPlace) == 1);
    elements(places, count, "places");
    return {reinterpret_cast<BoxPlace*>(places), static_cast<std::size_t>(count)};
}

void set(const TransformStatistics& from, clsdf_statistics* to) {
    if (to != nullptr) write_struct(as_c(from), to, "clsdf_statistics");
}

clsdf_statistics as_c(const TransformStatistics& statistics) {
    clsdf_statistics result = CLSDF_STATISTICS_INIT;
    result.slabs = static_cast<std::int64_t>(statistics.slabs);
    result.device_bytes = static_cast<std::int64_t>(statistics.device_bytes);
    result.host_bytes = static_cast<std::int64_t>(statistics.host_bytes);
    result.compile_seconds = statistics.compile_seconds;
    result.polyhedra_seconds = statistics.polyhedra_seconds;
    result.field_seconds = statistics.field_seconds;
    result.first_use = statistics.first_use ? 1 : 0;
    result.unusable_points = static_cast<std::int64_t>(statistics.unusable_points);
    return result;
}

clsdf_field_description as_c(const FieldDescription& field) {
    clsdf_field_description result = CLSDF_FIELD_DESCRIPTION_INIT;
    result.grid = as_c(field.grid);
    result.band = as_c(field.band);
    result.sign = static_cast<std::int32_t>(field.sign);
    result.positive_inside = field.positive_inside ? 1 : 0;
    result.mesh_name = field.mesh_name.c_str();
    if (field.floor) result.floor = *field.floor;
    return result;
}

FieldDescription description_of(const clsdf_field_description* description) {
    const clsdf_field_description from =
        read_given(description, CLSDF_FIELD_DESCRIPTION_INIT, "clsdf_field_description");
    FieldDescription field{grid_of(&from.grid), band_of(&from.band),
                           sign_rule_of(from.sign, "clsdf_field_description.sign"), text_or(from.mesh_name, ""),
                           flag(from.positive_inside, "clsdf_field_description.positive_inside")};
    if (from.floor != std::numeric_limits<double>::max()) field.floor = from.floor;
    return field;
}

void check_callback(std::int32_t status, const char* name) {
    if (status == 0) return;
    std::string message = clsdf_last_error();
    if (message.empty()) {
        const bool is_meant = status == CLSDF_CANCELLED || status >= CLSDF_OWN_STATUS;
        message = std::string("the callback ") + name + " ended the call with status " + std::to_string(status) + " (" +
                  (status >= CLSDF_OWN_STATUS ? "the program's own" : clsdf_status_name(status)) + "); " +
                  (is_meant ? "" : "CLSDF_CANCELLED is the status to cancel with, and ") +
                  "clsdf_set_last_error() in the callback can say why";
    }
    throw CallbackEnded{status, message, clsdf_last_opencl_error()};
}

namespace {

/// Calls back with no message kept, so that one found afterwards is the callback's.
template <typename... Arguments>
void call_back(const char* name, std::int32_t (*function)(Arguments...), Arguments... arguments) {
    clsdf_set_last_error(nullptr);
    check_callback(function(arguments...), name);
}

}  // namespace

Call::Call(const clsdf_call_options* options) {
    if (options == nullptr) return;
    const clsdf_call_options from = read_struct(options, CLSDF_CALL_OPTIONS_INIT, "clsdf_call_options");
    if (from.progress != nullptr)
        options_.progress = [from](const Progress& progress) {
            const clsdf_progress now{static_cast<std::int32_t>(progress.stage), 0, progress.fraction,
                                     static_cast<std::int64_t>(progress.step),
                                     static_cast<std::int64_t>(progress.steps)};
            call_back("progress", from.progress, from.user, &now);
        };
    if (from.should_stop != nullptr)
        options_.should_stop = [from] {
            call_back("should_stop", from.should_stop, from.user);
            return false;
        };
    if (from.log != nullptr)
        options_.log = [from](const std::string& message) { call_back("log", from.log, from.user, message.c_str()); };
    wait_list_ = events_of(from.wait_list, from.wait_count);
    options_.wait_list = wait_list_;
    options_.refuse_unusable_points = flag(from.refuse_unusable_points, "refuse_unusable_points");
    check_reserved(from.reserved, "clsdf_call_options");
}

ReadOptions read_options_of(const clsdf_read_options* options) {
    ReadOptions read;
    if (options == nullptr) return read;
    const clsdf_read_options from = read_struct(options, CLSDF_READ_OPTIONS_INIT, "clsdf_read_options");
    if (from.log != nullptr)
        read.log = [from](const std::string& message) { call_back("log", from.log, from.user, message.c_str()); };
    read.scale = from.scale;
    read.translate = triple(from.translate);
    read.skip_bad_facets = flag(from.skip_bad_facets, "clsdf_read_options.skip_bad_facets");
    check_reserved(from.reserved, "clsdf_read_options");
    read.up = text_or(from.up, "z");
    read.rotate = triple(from.rotate);
    read.group_by = text_or(from.group_by, "");
    return read;
}

std::vector<cl_event> events_of(void* const* wait_list, std::int64_t count) {
    elements(wait_list, count, "wait_list");
    std::vector<cl_event> events(static_cast<std::size_t>(count));
    std::transform(wait_list, wait_list + count, events.begin(),
                   [](void* event) { return static_cast<cl_event>(event); });
    return events;
}

std::int32_t checked_index_base(std::int32_t base) {
    if (base != 0 && base != 1)
        throw misuse("index_base is " + std::to_string(base) + "; indices count from 0 or from 1");
    return base;
}

std::vector<Request> requests_of(const clsdf_request* requests, std::int64_t count) {
    elements(requests, count, "requests");
    std::vector<Request> result;
    result.reserve(static_cast<std::size_t>(count));
    const auto size = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < size; ++i)
        result.push_back(for_request(i, size, [&]() -> Request {
            const Grid grid = grid_of(&requests[i].grid);
            return {grid, band_of(&requests[i].band), targets_of(requests[i].targets, grid)};
        }));
    return result;
}

BlockSet block_set_of(const clsdf_block_set* blocks) {
    const clsdf_block_set from = read_given(blocks, CLSDF_BLOCK_SET_INIT, "clsdf_block_set");
    elements(from.first, from.block_count, "clsdf_block_set.first");
    static_assert(is_triple<Index3, std::int64_t>);
    BlockSet result;
    result.lattice = grid_of(&from.lattice);
    result.band = band_of(&from.band);
    result.size = triple(from.size);
    result.first = {reinterpret_cast<const Index3*>(from.first), static_cast<std::size_t>(from.block_count)};
    result.targets = targets_of(from.targets.items, from.targets.count);
    check_counts(from.targets, samples_of(result.size, from.block_count), [&](const std::string& samples) {
        return std::to_string(from.block_count) + " blocks have " + samples + " samples";
    });
    return result;
}

}  // namespace clsdf::c
