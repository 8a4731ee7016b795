#include "core/outputs.hpp"

#include "core/refuse.hpp"
#include "layout.h"

#include <clsdf/error.hpp>

#include <fmt/format.h>

namespace clsdf {
namespace {

static_assert(no_triangle == CLSDF_NO_TRIANGLE);

// A row of the table of the kernels, which begins after the distance.
#define CLSDF_ROW(name, description, element, components, number) \
    OutputInfo{Output::name, #name, description, ElementType::element, components},
constexpr std::array table{OutputInfo{Output::distance, "distance", "distance", ElementType::float32, 1},
                           CLSDF_OUTPUTS(CLSDF_ROW)};
#undef CLSDF_ROW
#define CLSDF_NUMBER(name, description, element, components, number) \
    static_assert(static_cast<int>(Output::name) == CLSDF_OUTPUT_##name);
static_assert(static_cast<int>(Output::distance) == CLSDF_OUTPUT_distance);
CLSDF_OUTPUTS(CLSDF_NUMBER)
#undef CLSDF_NUMBER
static_assert(CLSDF_OUTPUT_COUNT <= detail::most_outputs);

}  // namespace

const char* name_of(ElementType type) {
    constexpr std::array names{"automatic", "float", "double", "int32", "int64", "uint32", "uint64", "uint8"};
    const auto number = static_cast<std::size_t>(type);
    return number < names.size() ? names[number] : "unknown";
}

std::span<const OutputInfo> output_table() {
    return table;
}

const OutputInfo& info_of(Output output) {
    for (const OutputInfo& info : table)
        if (info.output == output) return info;
    refuse("there is no output number {}; the last one is {}, {}", static_cast<int>(output),
           static_cast<int>(table.back().output), table.back().name);
}

void detail::check_type(Output output, ElementType type) {
    const OutputInfo& info = info_of(output);
    if (type != info.type)
        refuse("values of the output {} are given as {}; in fields they are {}", info.name, name_of(type),
               name_of(info.type));
}

void detail::check_targets(std::span<const OutputTarget> targets) {
    OutputSet given;
    for (const OutputTarget& target : targets) {
        if (given.contains(target.output))
            refuse("the output {} has two targets; give it one", info_of(target.output).name);
        given.insert(target.output);
    }
}

std::vector<OutputInfo> infos_of(OutputSet outputs) {
    std::vector<OutputInfo> infos;
    for (const OutputInfo& info : table)
        if (info.output == Output::distance || outputs.contains(info.output)) infos.push_back(info);
    return infos;
}

Field::Field(const FieldDescription& description, OutputSet outputs) : FieldDescription(description) {
    grid.validate();
    const std::size_t samples = grid.sample_count();
    try {
        for (const OutputInfo& info : table)
            if (outputs.contains(info.output)) resize(info.output, samples);
    } catch (const std::exception&) {
        throw Error(ErrorCode::out_of_memory,
                    fmt::format("a field of {} x {} x {} samples does not fit the memory; compute parts of the grid",
                                grid.size[0], grid.size[1], grid.size[2]));
    }
}

std::span<std::byte> Field::resize(Output output, std::size_t samples) {
    FieldArray<std::byte>& array = arrays_[detail::index_of(output)];
    array.resize(samples * info_of(output).sample_bytes());
    return array;
}

void Field::negate() {
    clsdf::negate(distance());
    clsdf::negate(gradient());
    positive_inside = !positive_inside;
}

FieldSlab Field::slab() const {
    FieldSlab slab;
    for (const OutputInfo& info : table) slab.set(info.output, bytes(info.output));
    return slab;
}

OutputTargets Field::targets() {
    OutputTargets targets;
    for (const OutputInfo& info : table) {
        const std::span<std::byte> memory = bytes(info.output);
        if (memory.empty()) continue;
        OutputArray& array = targets[info.output];
        array.host = memory.data();
        array.bytes = memory.size();
        array.type = info.type;
    }
    return targets;
}

}  // namespace clsdf
