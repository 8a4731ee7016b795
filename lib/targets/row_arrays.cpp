#include "targets/row_arrays.hpp"

#include "core/parallel.hpp"

#include <cstring>

namespace clsdf::targets {

namespace {

/// convert(number): in the array's type.
template <typename Number, typename Convert>
void store_as(const ResultArray& to, const ColumnValues& values, std::size_t components, const Convert& convert) {
    constexpr std::size_t rows_together = 4096;
    for_each_index(
        values.count,
        [&](std::size_t row) {
            const std::byte* from = values.first + row * values.stride;
            for (std::size_t n = 0; n < components; ++n, from += sizeof(Number)) {
                Number number;
                std::memcpy(&number, from, sizeof number);
                to.set(row, n, convert(number));
            }
        },
        rows_together);
}

}  // namespace

void store_column(const ResultArray& to, const ColumnValues& values, ElementType own, std::size_t components,
                  float (*as_float)(double)) {
    const auto as_it_is = [](auto number) { return number; };
    if (own == ElementType::float64 && to.type() == ElementType::float32) {
        if (as_float != nullptr)
            store_as<double>(to, values, components, as_float);
        else
            store_as<double>(to, values, components, [](double number) { return static_cast<float>(number); });
        return;
    }
    // The types of whole numbers that an array may have are as wide as the values.
    switch (bytes_of(own)) {
        case 1:
            return store_as<std::uint8_t>(to, values, components, as_it_is);
        case 4:
            return store_as<std::uint32_t>(to, values, components, as_it_is);
        default:
            return store_as<std::uint64_t>(to, values, components, as_it_is);
    }
}

}  // namespace clsdf::targets
