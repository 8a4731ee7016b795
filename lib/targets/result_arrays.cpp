#include "targets/result_arrays.hpp"

#include "core/refuse.hpp"
#include "device/opencl.hpp"
#include "mesh/input_arrays.hpp"
#include "targets/target_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace clsdf::targets {

ResultArray::ResultArray(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                         const ElementTypes& types, MappedMemory& memory, bool are_fields)
    : ResultArray(given, name, size, components, types, are_fields) {
    if (given.device == nullptr || size[0] * size[1] * size[2] == 0) return;
    memory.add(given.device, range(), MappedMemory::Use::write, std::string("items of ") + name);
}

ResultArray ResultArray::on_host(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                                 const ElementTypes& types, bool are_fields) {
    if (given.device != nullptr)
        refuse_unsupported("{} is memory of a device, and the host writes it; give it memory of the host", name);
    return {given, name, size, components, types, are_fields};
}

ResultArray ResultArray::on_device(const OutputArray& given, const char* name, const Index3& size,
                                   std::size_t components, const ElementTypes& types, const device::Context& context,
                                   bool are_fields) {
    if (given.host != nullptr)
        refuse_unsupported(
            "{} is memory of the host, and a plan writes to the device's; give it a buffer of the "
            "device",
            name);
    ResultArray array(given, name, size, components, types, are_fields);
    if (given.device == nullptr || size[0] * size[1] * size[2] == 0) return array;
    const ByteRange bytes = array.range();
    checked_range(context, {given.device, bytes.begin}, bytes.end - bytes.begin, bytes_of(array.type_), name);
    return array;
}

ByteRange ResultArray::range() const {
    ArrayLayout layout;
    layout.type = type_;
    layout.offset = offset_;
    const auto [lowest, highest] = extent_of(layout, {{strides_[0], static_cast<double>(size_[0])},
                                                      {strides_[1], static_cast<double>(size_[1])},
                                                      {strides_[2], static_cast<double>(size_[2])},
                                                      {component_stride_, static_cast<double>(components_)}});
    if (lowest < 0 || highest > 0x1p62)
        refuse("{} reaches from byte {} to {}, which no memory has", name_, lowest, highest);
    return {static_cast<std::size_t>(lowest), static_cast<std::size_t>(highest)};
}

ResultArray::ResultArray(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                         const ElementTypes& types, bool are_fields)
    : is_given_(given.is_given()),
      device_(given.device),
      offset_(given.offset),
      size_(size),
      components_(components),
      name_(name) {
    if (!is_given_) return;
    type_ = given.type == ElementType::automatic ? *types.begin() : given.type;
    if (std::ranges::find(types, type_) == types.end()) {
        std::string allowed;
        for (const ElementType type : types)
            allowed += fmt::format("{}{}", allowed.empty() ? "" : " or ", name_of(type));
        refuse_unsupported("{} has the type {}; give {}", name, name_of(type_), allowed);
    }
    const auto width = static_cast<std::ptrdiff_t>(bytes_of(type_));
    const auto& strides = given.strides;
    if (!are_fields && (strides[1] != 0 || strides[2] != 0))
        refuse("{} has the strides ({}, {}, {}); it has one row: set strides[0] alone", name, strides[0], strides[1],
               strides[2]);
    if (static_cast<std::ptrdiff_t>(given.offset) % width != 0 || strides[0] % width != 0 || strides[1] % width != 0 ||
        strides[2] % width != 0 || given.component_stride % width != 0)
        refuse(
            "{}: the offset {} and the strides ({}, {}, {}) and {} are not all multiples of its "
            "numbers' {} bytes",
            name, given.offset, strides[0], strides[1], strides[2], given.component_stride, width);
    const bool has_strides = strides[0] != 0 || strides[1] != 0 || strides[2] != 0;
    const auto packed = [&size](std::ptrdiff_t item) {
        return std::array<std::ptrdiff_t, 3>{item, item * size[0], item * size[0] * size[1]};
    };
    if (are_fields) {
        if (has_strides && (given.component_stride == 0 || strides[0] == 0 || strides[1] == 0 || strides[2] == 0))
            refuse(
                "{} has the strides ({}, {}, {}) and the component_stride {}; give all of them, or "
                "none for a packed array",
                name, strides[0], strides[1], strides[2], given.component_stride);
        strides_ = has_strides ? strides : packed(width);
        component_stride_ = given.component_stride != 0 ? given.component_stride : width * size[0] * size[1] * size[2];
    } else {
        component_stride_ = given.component_stride != 0 ? given.component_stride : width;
        strides_ =
            packed(strides[0] != 0                                 ? strides[0]
                   : component_stride_ == width || components == 1 ? width * static_cast<std::ptrdiff_t>(components)
                                                                   : width);
    }
    if (size[0] * size[1] * size[2] > 0)
        refuse_values_on_others(name, width, size, strides_, components, component_stride_);
    if (device_ != nullptr) return;
    ArrayLayout layout = given;
    layout.type = type_;
    const auto [lowest, highest] = extent_of(layout, {{strides_[0], static_cast<double>(size[0])},
                                                      {strides_[1], static_cast<double>(size[1])},
                                                      {strides_[2], static_cast<double>(size[2])},
                                                      {component_stride_, static_cast<double>(components)}});
    const bool is_plain = given.offset == 0 && !has_strides && given.component_stride == 0;
    const auto items = static_cast<std::size_t>(size[0] * size[1] * size[2]);
    if (items > 0 && given.bytes != ArrayLayout::unknown_size &&
        (lowest < 0 || highest > static_cast<double>(given.bytes) ||
         (is_plain && given.bytes != items * components * static_cast<std::size_t>(width))))
        refuse("{} has room for {} numbers; {} are needed{}", name, given.bytes / static_cast<std::size_t>(width),
               items * components, is_plain ? "" : ", with its offset and strides");
    first_ = static_cast<std::byte*>(given.host) + given.offset;
}

void ResultArray::set_mapped(const MappedMemory& memory) {
    if (device_ != nullptr && size_[0] * size_[1] * size_[2] > 0) first_ = memory.at(device_, offset_);
}

WrittenArray ResultArray::written() const {
    WrittenArray array{.first = reinterpret_cast<std::uintptr_t>(first_),
                       .width = bytes_of(type_),
                       .size = size_,
                       .strides = strides_,
                       .components = components_,
                       .component_stride = component_stride_,
                       .name = name_};
    if (device_ == nullptr) return array;
    return device::guarded([&] {
        const BufferPlace begin = place_of(device_, offset_);
        array.memory = begin.memory();
        array.first = begin.byte;
        return array;
    });
}

}  // namespace clsdf::targets
