#pragma once

#include "support/exact_field.hpp"

#include <clsdf/papers.hpp>
#include <clsdf/tuning.hpp>

#include <array>
#include <stdexcept>
#include <string>

namespace clsdf::test {

inline constexpr std::array both_bodies{KernelBody::by_vector, KernelBody::by_group};
inline constexpr std::array both_minima{SliceMinimum::one_pass, SliceMinimum::two_passes};

struct Scanned {
    Field field;
    TransformStatistics statistics;
};

/// By slices, counted.
inline Scanned scan_slices(const Mesh& mesh, const Grid& grid, const Band& band, PapersOptions options = {},
                           KernelBody body = KernelBody::automatic) {
    options.scan = Scan::slices;
    const DistanceTransform transform = make_transform(test_device(), mesh, options, {.body = body});
    Scanned result;
    result.field = transform.compute(grid, band, Output::triangle, {.count_work = true}, &result.statistics);
    return result;
}

inline std::size_t count_of(const TransformStatistics& statistics, const std::string& name) {
    for (const MethodCount& count : statistics.work->method_counts)
        if (count.name == name) return count.value;
    throw std::out_of_range(name);
}

/// A piece is looked at only in slices that it cuts, and none is left out.
inline void check_intersections(const TransformStatistics& statistics, std::size_t passes = 1) {
    BOOST_TEST(count_of(statistics, "slice_intersections") == passes * count_of(statistics, "active_pieces"));
    BOOST_TEST(count_of(statistics, "empty_intersections") == 0U);
}

}  // namespace clsdf::test
