#include "scan/output_targets.hpp"

#include "core/outputs.hpp"
#include "core/parallel.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <span>

namespace clsdf::scan {

namespace {

using Element = OutputTarget::Element;

const char* name_of(Element element) {
    switch (element) {
        case Element::float32:
            return "float";
        case Element::float64:
            return "double";
        case Element::uint32:
            return "uint32";
        case Element::uint8:
            return "uint8";
        default:
            return "another type";
    }
}

/// The elements of PerOutput.
template <typename Value>
struct ElementOf {
    Element element = OutputTarget(std::span<Value>()).element;
};

Error misuse(const std::string& what) {
    return {ErrorCode::invalid_argument, what};
}

/// Sets the element of a target, and throws if there is no way to such elements.
void resolve_element(const OutputRow& row, Element natural, OutputTarget& target) {
    if (target.element == Element::automatic) target.element = natural;
    const bool has_both = row.element == OutputRow::real;
    const bool is_real = target.element == Element::float32 || target.element == Element::float64;
    if (target.element == natural || (has_both && is_real)) return;
    throw Error(ErrorCode::unsupported,
                fmt::format("the output {} cannot be written as {}; give it memory for elements of type {}", row.name,
                            name_of(target.element), has_both ? "float or double" : name_of(natural)));
}

std::ptrdiff_t width_of(Element element) {
    return element == Element::float64 ? 8 : element == Element::uint8 ? 1 : 4;
}

bool is_in_double(const OutputTarget& target) {
    return target.element == Element::float64;
}

/// Whether the elements that are computed are doubles.
bool is_computed_in_double(const OutputRow& row, const OutputTarget& target) {
    return is_in_double(target) && !is_widened(row, target);
}

/// Bytes of the samples, which lie side by side.
std::size_t packed_bytes(const OutputRow& row, const OutputTarget& target, const Grid& grid) {
    return grid.sample_count() * row.sample_bytes(is_in_double(target));
}

std::array<std::ptrdiff_t, 3> packed_strides(std::ptrdiff_t sample_bytes, const Grid& grid) {
    return {sample_bytes, sample_bytes * grid.size[0], sample_bytes * grid.size[0] * grid.size[1]};
}

/// Sets the strides that are left open; whether the target is packed.
bool resolve_strides(const OutputRow& row, const Grid& grid, OutputTarget& target) {
    const std::ptrdiff_t width = width_of(target.element);
    const bool has_strides = std::any_of(target.strides.begin(), target.strides.end(), [](auto s) { return s != 0; });
    const auto packed = packed_strides(static_cast<std::ptrdiff_t>(row.sample_bytes(is_in_double(target))), grid);
    if (target.component_stride == 0) target.component_stride = width;
    // Components that lie elsewhere leave no room between the samples.
    if (!has_strides) target.strides = target.component_stride == width ? packed : packed_strides(width, grid);
    return target.strides == packed && (row.components == 1 || target.component_stride == width);
}

/// Throws if two values of a target may lie on the same bytes: each stride must be at
/// least the span of all axes with shorter strides.
void check_overlap(const OutputRow& row, const Grid& grid, const OutputTarget& target) {
    struct Axis {
        double step, count;
        const char* name;
    };
    std::array<Axis, 4> axes{
        Axis{static_cast<double>(target.component_stride), static_cast<double>(row.components),
             "from component to component"},
        Axis{static_cast<double>(target.strides[0]), static_cast<double>(grid.size[0]), "along x"},
        Axis{static_cast<double>(target.strides[1]), static_cast<double>(grid.size[1]), "along y"},
        Axis{static_cast<double>(target.strides[2]), static_cast<double>(grid.size[2]), "along z"}};
    for (Axis& axis : axes) axis.step = std::abs(axis.step);
    std::sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.step < b.step; });
    auto span = static_cast<double>(width_of(target.element));
    for (const Axis& axis : axes) {
        if (axis.count < 2) continue;
        if (axis.step < span)
            throw misuse(
                fmt::format("the target of the output {} has a stride of {:.0f} bytes {}, and {:.0f} bytes are "
                            "written at each step: values would overlap; set all strides, or none",
                            row.name, axis.step, axis.name, span));
        span += axis.step * (axis.count - 1);
    }
}

/// The bytes of a target's samples. Throws if they do not lie within `bytes` bytes, or not where its elements can.
ByteRange range_of(const OutputRow& row, const Grid& grid, const OutputTarget& target, std::size_t bytes) {
    if (grid.sample_count() == 0) return {};
    const std::ptrdiff_t width = width_of(target.element);
    // In double, which no sum of such products overflows.
    double lowest = static_cast<double>(target.offset), highest = lowest + static_cast<double>(width);
    const auto extend = [&](std::ptrdiff_t stride, double steps) {
        (stride < 0 ? lowest : highest) += static_cast<double>(stride) * steps;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) extend(target.strides[axis], static_cast<double>(grid.size[axis] - 1));
    extend(target.component_stride, static_cast<double>(row.components - 1));
    if (lowest < 0 || highest > static_cast<double>(bytes))
        throw misuse(
            fmt::format("the target of the output {} reaches from byte {:.0f} to {:.0f} with its offset and "
                        "strides, and its memory holds {} bytes",
                        row.name, lowest, highest, bytes));
    const auto is_whole = [&](std::ptrdiff_t length) { return length % width == 0; };
    if (!is_whole(static_cast<std::ptrdiff_t>(target.offset)) || !is_whole(target.component_stride) ||
        !std::all_of(target.strides.begin(), target.strides.end(), is_whole))
        throw misuse(
            fmt::format("the offset and the strides of the target of the output {} are no multiples of its "
                        "elements' {} bytes",
                        row.name, width));
    check_overlap(row, grid, target);
    return {static_cast<std::size_t>(lowest), static_cast<std::size_t>(highest)};
}

void check_host_memory(const OutputRow& row, const Grid& grid, const char* owner, const OutputTarget& target,
                       bool is_plain) {
    if (target.device != nullptr)
        throw Error(ErrorCode::unsupported,
                    fmt::format("the target of the output {} is memory of the device, and this call writes to the "
                                "host's; give all targets memory of the host, or all memory of the device",
                                row.name));
    const std::ptrdiff_t width = width_of(target.element);
    if (is_plain) {
        if (target.bytes == packed_bytes(row, target, grid)) return;
        throw misuse(
            fmt::format("{}, and the array given for the output {} holds {} values of {}; give a span of "
                        "exactly these, or set the strides",
                        fmt::format(fmt::runtime(owner), grid.sample_count()), row.name,
                        target.bytes / static_cast<std::size_t>(width),
                        static_cast<std::size_t>(grid.sample_count()) * row.components));
    }
    range_of(row, grid, target, target.bytes);
}

void require_distance(const OutputTargets& targets) {
    if (!targets.distance.is_given())
        throw misuse("the distance has no target; give it memory, whatever else is asked for");
}

}  // namespace

Outputs outputs_of(const OutputTargets& targets) {
    Outputs outputs;
    for_each_extra([](const OutputRow&, const OutputTarget& target, bool& wanted) { wanted = target.is_given(); },
                   targets, outputs);
    return outputs;
}

Outputs outputs_of(const HostArrays& arrays) {
    Outputs outputs;
    for_each_extra([](const OutputRow&, const HostArray& array, bool& wanted) { wanted = array.is_wanted; }, arrays,
                   outputs);
    return outputs;
}

HostTargets::HostTargets(const OutputTargets& targets, const Grid& grid)
    : HostTargets(targets, grid, "the grid has {} samples") {}

HostTargets::HostTargets(const OutputTargets& targets, const Grid& grid, const char* owner)
    : targets_(targets), grid_(grid) {
    require_distance(targets);
    const PerOutput<ElementOf> elements;
    for_each_output(
        [&](const OutputRow& row, OutputTarget& target, const auto& natural, HostArray& array) {
            if (!target.is_given()) return;
            resolve_element(row, natural.element, target);
            const bool is_plain =
                target.offset == 0 && target.component_stride == 0 && target.strides == OutputTarget().strides;
            const bool is_packed = resolve_strides(row, grid, target);
            check_host_memory(row, grid, owner, target, is_plain);
            are_packed_ = are_packed_ && is_packed && !is_widened(row, target);
            array = {true, is_computed_in_double(row, target), static_cast<std::byte*>(target.host) + target.offset};
        },
        targets_, elements, arrays_);
}

namespace {

Grid row_of(std::size_t count) {
    Grid row;
    row.size = {static_cast<std::int64_t>(count), 1, 1};
    return row;
}

/// visit(row, target, range, is_packed) for targets in memory of the device; their elements and strides are set.
template <typename Visit>
void visit_device_targets(OutputTargets& targets, std::size_t points, const Visit& visit) {
    const Grid grid = row_of(points);
    const PerOutput<ElementOf> elements;
    for_each_output(
        [&](const OutputRow& row, OutputTarget& target, const auto& natural) {
            if (target.device == nullptr) return;
            resolve_element(row, natural.element, target);
            const bool is_packed = resolve_strides(row, grid, target);
            const std::size_t bytes =
                device::guarded([&] { return cl::Buffer(target.device, true).getInfo<CL_MEM_SIZE>(); });
            visit(row, target, points == 0 ? ByteRange{} : range_of(row, grid, target, bytes), is_packed);
        },
        targets, elements);
}

}  // namespace

HostTargets HostTargets::of_points(const OutputTargets& targets, std::size_t count) {
    return {targets, row_of(count), "there are {} points"};
}

void add_targets(const OutputTargets& targets, std::size_t points, device::MappedMemory& memory) {
    using Use = device::MappedMemory::Use;
    OutputTargets resolved = targets;
    visit_device_targets(resolved, points,
                         [&](const OutputRow& row, const OutputTarget& target, const ByteRange& range, bool is_packed) {
                             memory.add(target.device, range, is_packed ? Use::overwrite : Use::write,
                                        fmt::format("output {}", row.name));
                         });
}

OutputTargets on_host(const OutputTargets& targets, std::size_t points, const device::MappedMemory& memory) {
    static std::byte nothing{};
    OutputTargets result = targets;
    visit_device_targets(result, points,
                         [&](const OutputRow&, OutputTarget& target, const ByteRange& range, bool is_packed) {
                             target.host = range.is_empty() ? &nothing : memory.at(target.device, range.begin);
                             target.device = nullptr;
                             target.offset = range.is_empty() ? 0 : target.offset - range.begin;
                             target.bytes = range.end - range.begin;
                             if (is_packed) target.strides = {};
                         });
    return result;
}

bool overlap(const OutputTargets& targets, std::span<const std::byte> bytes) {
    bool result = false;
    const std::less<const std::byte*> is_before;
    for_each_output(
        [&](const OutputRow&, const OutputTarget& target) {
            const auto* begin = static_cast<const std::byte*>(target.host);
            if (begin == nullptr || bytes.empty()) return;
            result = result ||
                     (is_before(begin, bytes.data() + bytes.size()) && is_before(bytes.data(), begin + target.bytes));
        },
        targets);
    return result;
}

void HostTargets::store(const Grid& slab, const HostArrays& values) const {
    // The samples that both have, by their numbers on the lattice.
    Index3 begin{}, count{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        begin[axis] = std::max(slab.first[axis], grid_.first[axis]);
        count[axis] = std::min(slab.first[axis] + slab.size[axis], grid_.first[axis] + grid_.size[axis]) - begin[axis];
        if (count[axis] <= 0) return;
    }
    const auto width = static_cast<std::size_t>(count[0]), rows_of_slice = static_cast<std::size_t>(count[1]);
    for_each_output(
        [&](const OutputRow& row, const OutputTarget& target, const HostArray& array) {
            if (!target.is_given()) return;
            const std::size_t sample = row.sample_bytes(array.in_double), element = sample / row.components;
            const bool is_row_packed = target.strides[0] == static_cast<std::ptrdiff_t>(sample) &&
                                       (row.components == 1 || target.component_stride == width_of(target.element)) &&
                                       !is_widened(row, target);
            std::byte* const first = static_cast<std::byte*>(target.host) + target.offset;
            for_each_index(rows_of_slice * static_cast<std::size_t>(count[2]), [&](std::size_t number) {
                const Index3 at{begin[0], begin[1] + static_cast<std::int64_t>(number % rows_of_slice),
                                begin[2] + static_cast<std::int64_t>(number / rows_of_slice)};
                const std::byte* from = array.data + sample * slab.offset(at[0] - slab.first[0], at[1] - slab.first[1],
                                                                          at[2] - slab.first[2]);
                std::byte* to = first;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    to += static_cast<std::ptrdiff_t>(at[axis] - grid_.first[axis]) * target.strides[axis];
                if (is_row_packed) {
                    std::memcpy(to, from, width * sample);
                    return;
                }
                if (is_widened(row, target)) {
                    for (std::size_t x = 0; x < width; ++x, to += target.strides[0], from += element) {
                        float value = 0;
                        std::memcpy(&value, from, sizeof value);
                        const auto widened = static_cast<double>(value);
                        std::memcpy(to, &widened, sizeof widened);
                    }
                    return;
                }
                for (std::size_t x = 0; x < width; ++x, to += target.strides[0])
                    for (std::size_t c = 0; c < row.components; ++c, from += element)
                        std::memcpy(to + static_cast<std::ptrdiff_t>(c) * target.component_stride, from, element);
            });
        },
        targets_, values);
}

void HostTargets::store_row(std::size_t first, std::size_t count, const HostArrays& values) const {
    Grid row;
    row.first = {static_cast<std::int64_t>(first), 0, 0};
    row.size = {static_cast<std::int64_t>(count), 1, 1};
    store(row, values);
}

namespace {

/// The buffer from `offset` on, which is aligned.
cl::Buffer buffer_from(const cl::Buffer& buffer, std::size_t offset, std::size_t bytes) {
    if (offset == 0) return buffer;
    cl::Buffer parent = buffer;
    if (const auto whole = buffer.getInfo<CL_MEM_ASSOCIATED_MEMOBJECT>(); whole() != nullptr) {
        offset += buffer.getInfo<CL_MEM_OFFSET>();
        parent = cl::Buffer(whole(), true);
    }
    const cl_buffer_region region{offset, bytes};
    return parent.createSubBuffer(0, CL_BUFFER_CREATE_TYPE_REGION, &region);
}

/// Memory that kernels cannot or may not write would fail later and less clearly.
void check_memory(const OutputRow& row, const cl::Memory& memory, const device::Context& context) {
    device::require_buffer(context, memory, fmt::format("the target of the output {}", row.name));
    if ((memory.getInfo<CL_MEM_FLAGS>() & CL_MEM_READ_ONLY) != 0)
        throw misuse(
            fmt::format("the target of the output {} is a buffer made with CL_MEM_READ_ONLY; kernels write to "
                        "it, so make it with CL_MEM_READ_WRITE",
                        row.name));
}

}  // namespace

DeviceTargets::DeviceTargets(const OutputTargets& targets, const Grid& grid, const device::Context& context)
    : targets_(targets) {
    require_distance(targets);
    OutputBuffers buffers;
    const std::size_t alignment = context.device().getInfo<CL_DEVICE_MEM_BASE_ADDR_ALIGN>() / 8;
    const PerOutput<ElementOf> elements;
    for_each_output(
        [&](const OutputRow& row, OutputTarget& target, const auto& natural, HostArray& array, cl::Buffer& buffer) {
            if (!target.is_given()) {
                target = {};
                return;
            }
            if (target.device == nullptr)
                throw Error(ErrorCode::unsupported,
                            fmt::format("the target of the output {} is memory of the host, and this call writes to "
                                        "the device's; give all targets memory of the device, or all memory of the "
                                        "host",
                                        row.name));
            resolve_element(row, natural.element, target);
            const bool is_packed = resolve_strides(row, grid, target);
            const cl::Buffer memory(target.device, true);
            check_memory(row, memory, context);
            range_of(row, grid, target, memory.getInfo<CL_MEM_SIZE>());
            array = {true, is_computed_in_double(row, target), nullptr};
            if (array.in_double) buffers.in_double |= row.bit;
            if (!why_not_in_place_.empty()) return;
            if (!is_packed)
                why_not_in_place_ = fmt::format("{} has strides", row.name);
            else if (is_widened(row, target))
                why_not_in_place_ = fmt::format("{} has doubles", row.name);
            else if (target.offset % alignment != 0)
                why_not_in_place_ = fmt::format("{} begins at byte {} of its buffer, which is no multiple of {}",
                                                row.name, target.offset, alignment);
            else
                buffer = buffer_from(memory, target.offset, packed_bytes(row, target, grid));
        },
        targets_, elements, arrays_, buffers);
    if (why_not_in_place_.empty()) in_place_ = buffers;
}

DeviceTargets::DeviceTargets(const Outputs& outputs, const Grid& grid)
    : arrays_(arrays_for(outputs)), in_place_(OutputBuffers()) {
    const PerOutput<ElementOf> elements;
    for_each_output(
        [&](const OutputRow& row, OutputTarget& target, const auto& natural, const HostArray& array) {
            if (!array.is_wanted) return;
            resolve_element(row, natural.element, target);
            resolve_strides(row, grid, target);
        },
        targets_, elements, arrays_);
}

}  // namespace clsdf::scan
