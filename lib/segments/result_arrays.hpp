#pragma once

#include <clsdf/arrays.hpp>

#include "targets/target_overlap.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>

namespace clsdf::segments {

/// An array of the caller's on the host into which a call writes; or none.
class ResultArray {
public:
    ResultArray() = default;
    /// types: those that it may have; the first one is that of an array without a type. components: of an item. name:
    /// for messages, as "the array of t". Throws Error(unsupported) for memory of the device and other types,
    /// Error(invalid_argument) for memory that is too small or strides that are none.
    ResultArray(const OutputArray& given, const char* name, std::size_t items, std::size_t components,
                std::initializer_list<ElementType> types);

    bool is_given() const { return first_ != nullptr; }
    ElementType type() const { return type_; }

    template <typename Number>
    void set(std::size_t item, std::size_t component, Number number) const {
        std::memcpy(first_ + static_cast<std::ptrdiff_t>(item) * stride_ +
                        static_cast<std::ptrdiff_t>(component) * component_stride_,
                    &number, sizeof number);
    }
    /// A real number, by the array's type.
    void set_real(std::size_t item, std::size_t component, double number) const {
        if (type_ == ElementType::float64)
            set(item, component, number);
        else
            set(item, component, static_cast<float>(number));
    }

    /// For refuse_overlap().
    targets::WrittenArray written() const;

private:
    std::byte* first_ = nullptr;
    std::size_t items_ = 0, components_ = 1;
    std::ptrdiff_t stride_ = 0, component_stride_ = 0;
    ElementType type_ = ElementType::automatic;
    const char* name_ = nullptr;
};

}  // namespace clsdf::segments
