#include <clsdf/band.hpp>
#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace clsdf {

Band Band::full() {
    return symmetric(std::numeric_limits<double>::infinity());
}

void Band::validate() const {
    if (std::isnan(inside) || std::isnan(outside))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("band: the half widths are {} inside and {} outside, and one that is nan was not set; "
                                "give both, e.g. Band::symmetric(3 * grid.voxel()), or Band::full() for a full field",
                                inside, outside));
    if (!(inside >= 0) || !(outside >= 0))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("band: the half widths are {} inside and {} outside; each must be 0 or more (infinite "
                                "for a full field)",
                                inside, outside));
}

}  // namespace clsdf
