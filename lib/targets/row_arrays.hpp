#pragma once

#include <clsdf/row_tables.hpp>

#include "targets/mapped_memory.hpp"
#include "targets/result_arrays.hpp"
#include "targets/target_overlap.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace clsdf::targets {

/// Writes a column into an array, on all cores. own: the type of the values.
void store_column(const ResultArray& to, const ColumnValues& values, ElementType own, std::size_t components,
                  float (*as_float)(double));

/// Whether an array of rows is given.
template <typename Table, typename Targets>
bool has_rows(const Table& table, const Targets& given) {
    return std::ranges::any_of(table, [&](const auto& column) { return (given.*column.target).is_given(); });
}

/// The caller's arrays for rows, by the table of their columns, checked.
template <typename Column>
class RowArrays {
public:
    /// make(array, name, size, components, types) returns the ResultArray, or throws as it does. table: must live as
    /// long as this.
    template <typename Make>
    RowArrays(std::span<const Column> table, const typename Column::Targets& given, const Make& make)
        : table_(table), room_(given.room) {
        arrays_.reserve(table.size());
        for (const Column& column : table)
            arrays_.push_back(make(given.*column.target, column.phrase, Index3{static_cast<std::int64_t>(room_), 1, 1},
                                   column.components(), column.types));
    }

    std::size_t room() const { return room_; }
    bool has_rows() const { return std::ranges::any_of(arrays_, &ResultArray::is_given); }
    /// For refuse_overlap().
    void add_to(std::vector<WrittenArray>& written) const {
        for (const ResultArray& array : arrays_)
            if (array.is_given() && room_ > 0) written.push_back(array.written());
    }
    void set_mapped(const MappedMemory& memory) {
        for (ResultArray& array : arrays_) array.set_mapped(memory);
    }
    /// Calls f(number of the column, its array) for the arrays that are given.
    template <typename Function>
    void for_each_given(const Function& f) const {
        for (std::size_t n = 0; n < arrays_.size(); ++n)
            if (arrays_[n].is_given()) f(n, arrays_[n]);
    }
    void store(const typename Column::Rows& rows) const {
        for_each_given([&](std::size_t n, const ResultArray& array) {
            const Column& column = table_[n];
            store_column(array, column.values(rows), *column.types.begin(), column.components(), column.as_float);
        });
    }

private:
    std::span<const Column> table_;
    std::size_t room_;
    std::vector<ResultArray> arrays_;  // as the table
};

}  // namespace clsdf::targets
