#include "small_workload.hpp"

#include "benchmarks/papers.hpp"

#include <boost/test/unit_test.hpp>

#include <set>

using namespace clsdf;
using namespace clsdf::bench;

BOOST_AUTO_TEST_SUITE(papers)

// The stairs are what the paper's polyhedra get wrong.
BOOST_AUTO_TEST_CASE(only_the_papers_polyhedra_are_wrong_and_only_they_are_reported_so) {
    const Workload workload =
        make_workload({"small", 60, Length::of_extent(0.1)}, "stairs", make_shape("stairs"), Device::strongest());
    const std::vector<std::unique_ptr<PapersMethod>> methods = papers_methods(Device::strongest(), workload);
    BOOST_TEST(methods.size() == 7U);
    for (const auto& method : methods) BOOST_TEST_CONTEXT(method->name()) {
            const Judgement found = test::measure(workload, *method).judgement;
            const bool is_papers = method->name().starts_with("peikert-sigg");
            const bool is_software = method->name().find("software") != std::string::npos;
            BOOST_TEST((found.missed + found.wrong_values > found.samples / 1000) == is_papers);
            BOOST_TEST(found.wrong_signs == 0U);
            BOOST_TEST(found.leaked == 0U);
            if (!is_papers) BOOST_TEST(found.max_error_voxels < (is_software ? 1e-4 : 2e-6));
            const Work work = method->work(workload);
            BOOST_TEST(work.polyhedra > 0U);
            BOOST_TEST(work.distances >= workload.list.samples.size() * 9 / 10);
        }
}

BOOST_AUTO_TEST_CASE(each_case_is_named_by_its_own_grid_and_the_bunny_has_three_widths) {
    std::set<int> widths;
    for (PapersCase c : papers_cases()) {
        if (c.mesh == "bunny00" && c.resolution == 256) widths.insert(c.percent);
        c.resolution = 32;
        BOOST_TEST(c.layout().name == "32, " + std::to_string(c.percent) + '%');
        BOOST_TEST(c.layout().resolution == 32);
    }
    BOOST_TEST((widths == std::set<int>{1, 3, 10}));
}

BOOST_AUTO_TEST_CASE(mauch_has_the_same_polyhedra_in_software_and_on_the_device) {
    for (const char* name : {"sphere4", "knot", "torus"}) {
        const Workload workload =
            make_workload({"small", 60, Length::of_extent(0.05)}, name, make_shape(name), Device::strongest());
        const Work software = make_software_mauch(0)->work(workload);
        const Work device = make_scanned(Device::strongest(), "mauch", Polyhedra::mauch, Scan::slices)->work(workload);
        BOOST_TEST(software.polyhedra == device.polyhedra, name);
        BOOST_TEST(static_cast<double>(software.distances) < 1.1 * static_cast<double>(device.distances));
        BOOST_TEST(static_cast<double>(software.distances) > 0.9 * static_cast<double>(device.distances));
    }
}

BOOST_AUTO_TEST_SUITE_END()
