#include "segments/result_arrays.hpp"

#include "mesh/input_arrays.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace clsdf::segments {

ResultArray::ResultArray(const OutputArray& given, const char* name, std::size_t items, std::size_t components,
                         std::initializer_list<ElementType> types)
    : items_(items), components_(components), name_(name) {
    if (!given.is_given()) return;
    if (given.device != nullptr)
        throw Error(ErrorCode::unsupported,
                    fmt::format("{} is memory of the device, and this call writes to the host's; give it memory of the "
                                "host",
                                name));
    type_ = given.type == ElementType::automatic ? *types.begin() : given.type;
    if (std::ranges::find(types, type_) == types.end()) {
        std::string allowed;
        for (const ElementType type : types)
            allowed += fmt::format("{}{}", allowed.empty() ? "" : " or ", name_of(type));
        throw Error(ErrorCode::unsupported, fmt::format("{} has the type {}; give {}", name, name_of(type_), allowed));
    }
    const auto width = static_cast<std::ptrdiff_t>(bytes_of(type_));
    if (given.strides[1] != 0 || given.strides[2] != 0)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} has the strides ({}, {}, {}); it has one row: set strides[0] alone", name,
                                given.strides[0], given.strides[1], given.strides[2]));
    if (static_cast<std::ptrdiff_t>(given.offset) % width != 0 || given.strides[0] % width != 0 ||
        given.component_stride % width != 0)
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{}: the offset {} and the strides {} and {} are not all multiples of its numbers' {} "
                                "bytes",
                                name, given.offset, given.strides[0], given.component_stride, width));
    component_stride_ = given.component_stride != 0 ? given.component_stride : width;
    stride_ = given.strides[0] != 0                           ? given.strides[0]
              : component_stride_ == width || components == 1 ? width * static_cast<std::ptrdiff_t>(components)
                                                              : width;
    ArrayLayout layout = given;
    layout.type = type_;
    const auto [lowest, highest] = extent_of(
        layout, {{stride_, static_cast<double>(items)}, {component_stride_, static_cast<double>(components)}});
    const bool is_plain = given.offset == 0 && given.strides[0] == 0 && given.component_stride == 0;
    if (items > 0 && given.bytes != ArrayLayout::unknown_size &&
        (lowest < 0 || highest > static_cast<double>(given.bytes) ||
         (is_plain && given.bytes != items * components * static_cast<std::size_t>(width))))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("{} has room for {} numbers; {} are needed{}", name,
                                given.bytes / static_cast<std::size_t>(width), items * components,
                                is_plain ? "" : ", with its offset and strides"));
    first_ = static_cast<std::byte*>(given.host) + given.offset;
}

targets::WrittenArray ResultArray::written() const {
    return {.first = reinterpret_cast<std::uintptr_t>(first_),
            .width = bytes_of(type_),
            .size = {static_cast<std::int64_t>(items_), 1, 1},
            .strides = {stride_, 0, 0},
            .components = components_,
            .component_stride = component_stride_,
            .name = name_};
}

}  // namespace clsdf::segments
