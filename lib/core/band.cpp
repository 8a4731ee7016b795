#include <clsdf/band.hpp>
#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <limits>

namespace clsdf {

Band Band::full() {
    return symmetric(std::numeric_limits<double>::infinity());
}

void Band::validate() const {
    // Written so that a NaN fails.
    if (!(inside >= 0) || !(outside >= 0))
        throw Error(ErrorCode::invalid_argument,
                    fmt::format("band: the half widths are {} inside and {} outside; each must be 0 or more (infinite "
                                "for a full field)",
                                inside, outside));
}

}  // namespace clsdf
