#include "small_workload.hpp"

#include "benchmarks/meshes.hpp"
#include "benchmarks/papers.hpp"

#include <boost/test/unit_test.hpp>

#include <cmath>
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

// Time over the value is a straight line on logarithmic scales.
BOOST_AUTO_TEST_CASE(crossovers_are_found_between_the_values) {
    const auto times = [](double value, double first_exponent, double second) {
        return TimesOfTwo{value, std::pow(value, first_exponent), second};
    };
    const std::vector<TimesOfTwo> rising{times(1, 0.5, 4), times(10, 0.5, 4), times(100, 0.5, 4)};
    const std::vector<double> once = crossovers(rising);
    BOOST_TEST_REQUIRE(once.size() == 1U);
    BOOST_TEST(once[0] == 16, boost::test_tools::tolerance(1e-9));
    const std::vector<TimesOfTwo> above{times(1, 0.5, 40), times(100, 0.5, 40)};
    BOOST_TEST(crossovers(above).empty());
    const std::vector<TimesOfTwo> there_and_back{{1, 1, 2}, {10, 2, 1}, {100, 1, 2}};
    BOOST_TEST(crossovers(there_and_back).size() == 2U);
}

BOOST_AUTO_TEST_CASE(under_sampled_grids_have_the_number_of_triangles_per_voxel) {
    for (const UnderSampledCase& c : under_sampled_cases("sphere6", make_shape("sphere6"), true))
        for (const Length& half_width : {Length::of_extent(0.1), Length::infinite()}) {
            const Layout layout = c.layout(half_width);
            if (layout.resolution < 10) continue;  // the smallest grid
            const Workload workload = make_workload(layout, "sphere", c.mesh, Device::strongest());
            BOOST_TEST(1 / mean_area_voxels(workload) == c.triangles_per_voxel, boost::test_tools::tolerance(0.1));
        }
}

// Two right triangles, a square of two voxels on a side.
BOOST_AUTO_TEST_CASE(the_mean_area_is_in_voxels) {
    const Mesh square({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
    BOOST_TEST(triangle_area(square, 1) == 0.5);
    Grid grid;
    grid.spacing = {0.5, 0.5, 0.5};
    BOOST_TEST(mean_area_voxels({"small", "square", square, grid, {}, {}, {}, 0}) == 2);
}

BOOST_AUTO_TEST_SUITE_END()
