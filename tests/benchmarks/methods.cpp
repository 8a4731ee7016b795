#include "small_workload.hpp"

#include "benchmarks/method.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>

using namespace clsdf;
using namespace clsdf::bench;
using clsdf::test::small_workload;

BOOST_AUTO_TEST_SUITE(methods)

// Embree searches in float, OpenVDB's distances are approximate; both get the slack that their rows show.
BOOST_AUTO_TEST_CASE(every_method_that_is_there_computes_the_same_job_within_its_own_accuracy) {
    for (const Length half_width : {Length::of_extent(0.1), Length::infinite()}) {
        const Workload workload = small_workload(half_width);
        for (const Entry& entry : all_methods(Device::strongest())) {
            if (!entry.method) continue;
            const Measurement found = test::measure(workload, *entry.method);
            BOOST_TEST_CONTEXT(entry.name << ", half width " << workload.band.outside) {
                const bool approximate = entry.name == "openvdb";
                BOOST_TEST(found.judgement.wrong_signs == 0U);
                BOOST_TEST(found.judgement.max_error_voxels < (approximate ? 0.5 : 1e-5));
                if (!approximate) BOOST_TEST(found.judgement.exact());
                BOOST_TEST(found.judgement.samples == (entry.method->takes_list() ? workload.list.count(found.stride)
                                                                                  : workload.grid.sample_count()));
            }
        }
    }
}

BOOST_AUTO_TEST_CASE(what_is_not_there_says_how_to_get_it) {
    for (const Entry& entry : all_methods(Device::strongest()))
        BOOST_TEST((entry.method == nullptr) == !entry.remedy.empty(), entry.name);
}

BOOST_AUTO_TEST_CASE(a_method_that_takes_the_list_computes_every_so_manieth_brick_and_nothing_else) {
    const Workload workload = small_workload();
    std::vector<float> distance(workload.grid.sample_count(), NAN);
    constexpr std::size_t stride = 4;
    cgal_entry().method->compute(workload, distance, stride);
    std::size_t computed = 0;
    for (const float value : distance) computed += std::isfinite(value) ? 1U : 0U;
    BOOST_TEST(computed == workload.list.count(stride));
    BOOST_TEST(computed < workload.list.samples.size() / 2);
    BOOST_TEST(computed > 0U);
}

BOOST_AUTO_TEST_SUITE_END()
