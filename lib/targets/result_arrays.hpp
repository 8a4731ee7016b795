#pragma once

#include <clsdf/arrays.hpp>
#include <clsdf/row_tables.hpp>

#include "targets/mapped_memory.hpp"
#include "targets/stored_rows.hpp"
#include "targets/target_overlap.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace clsdf::targets {

/// An array of the caller's into which a call writes; or none.
class ResultArray {
public:
    ResultArray() = default;
    /// Of items in one row or in a box. Memory of the device is added to `memory`, and used when that is mapped. types:
    /// those that it may have; the first one is that of an array without a type. components: of an item; are_fields:
    /// they are packed one after another, each as an array of items. name: for messages, as "the array of t". Throws
    /// Error(unsupported) for other types, Error(invalid_argument) for memory that is too small or strides that are
    /// none.
    ResultArray(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                const ElementTypes& types, MappedMemory& memory, bool are_fields = false);
    /// The same in memory of the host alone. Throws Error(unsupported) for memory of a device.
    static ResultArray on_host(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                               const ElementTypes& types, bool are_fields = false);
    /// The same in memory of the device, which its commands write. Throws Error(unsupported) for memory of the host.
    static ResultArray on_device(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                                 const ElementTypes& types, const device::Context& context, bool are_fields = false);

    bool is_given() const { return is_given_; }
    ElementType type() const { return type_; }
    /// Takes the address of what has been mapped.
    void set_mapped(const MappedMemory& memory);

    template <typename Number>
    void set(std::size_t item, std::size_t component, Number number) const {
        write(static_cast<std::ptrdiff_t>(item) * strides_[0], component, number);
    }
    template <typename Number>
    void set(const Index3& item, std::size_t component, Number number) const {
        write(item[0] * strides_[0] + item[1] * strides_[1] + item[2] * strides_[2], component, number);
    }
    /// A row of `count` items along the first axis, all alike.
    template <typename Number>
    void fill_row(const Index3& item, std::int64_t count, std::size_t component, Number number) const {
        std::byte* to = first_ + item[0] * strides_[0] + item[1] * strides_[1] + item[2] * strides_[2] +
                        static_cast<std::ptrdiff_t>(component) * component_stride_;
        for (std::int64_t n = 0; n < count; ++n, to += strides_[0]) std::memcpy(to, &number, sizeof number);
    }
    /// A real number, by the array's type.
    void set_real(std::size_t item, std::size_t component, double number) const {
        if (type_ == ElementType::float64)
            set(item, component, number);
        else
            set(item, component, static_cast<float>(number));
    }

    /// Of an array in memory of the device.
    ItemLayout layout() const { return {device_, offset_, strides_, component_stride_, components_, bytes_of(type_)}; }
    /// For refuse_overlap().
    WrittenArray written() const;

private:
    ResultArray(const OutputArray& given, const char* name, const Index3& size, std::size_t components,
                const ElementTypes& types, bool are_fields);
    /// Its bytes, in the memory that it was given. Throws Error(invalid_argument).
    ByteRange range() const;
    template <typename Number>
    void write(std::ptrdiff_t offset, std::size_t component, Number number) const {
        std::memcpy(first_ + offset + static_cast<std::ptrdiff_t>(component) * component_stride_, &number,
                    sizeof number);
    }

    bool is_given_ = false;
    std::byte* first_ = nullptr;  ///< null: in memory of the device that is not mapped
    cl_mem device_ = nullptr;
    std::size_t offset_ = 0;
    Index3 size_{};
    std::size_t components_ = 1;
    std::array<std::ptrdiff_t, 3> strides_{};
    std::ptrdiff_t component_stride_ = 0;
    ElementType type_ = ElementType::automatic;
    const char* name_ = nullptr;
};

}  // namespace clsdf::targets
