#pragma once

#include "targets/row_arrays.hpp"

#include <clsdf/segments.hpp>

#include <cstddef>

namespace clsdf::segments {

/// The caller's arrays for the links of a grid, checked.
class LinkArrays {
public:
    /// directions: their number. memory: of the device, to be mapped before store(). Throws as
    /// DistanceTransform::links() does.
    LinkArrays(const LinkTargets& given, const Grid& grid, std::size_t directions, targets::MappedMemory& memory);

    /// Throws Error(invalid_argument) if the rows have less room.
    void require_room(std::size_t links) const;
    void store(const Links& links, const targets::MappedMemory& memory);

private:
    void store_inside(const SampleSides& inside) const;
    void store_dense(const Links& links) const;

    std::size_t field_count_;
    Grid grid_;
    targets::RowArrays<LinkColumn> rows_;
    targets::ResultArray inside_, dense_;
};

}  // namespace clsdf::segments
