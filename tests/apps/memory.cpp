#include "apps/process.hpp"

#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>

#include <array>

using clsdf::test::content_of;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::tetrahedron;
using nlohmann::json;

namespace {

constexpr std::size_t mebibyte = std::size_t{1} << 20;

const std::vector<std::string> largest_allocation_of_16_mebibytes{"CLSDF_MAX_ALLOCATION=16777216"};

Outcome compute_slices(const TemporaryFolder& folder, int slices, const std::string& output,
                       const std::vector<std::string>& environment) {
    const std::string mesh = folder.file("mesh.off", tetrahedron);
    Outcome outcome = run_command({"compute", mesh, "-o", output, "--size", "256,256," + std::to_string(slices),
                                   "--origin", "-0.1,-0.1,-0.1", "--spacing", "0.005", "--json"},
                                  environment);
    BOOST_TEST_CONTEXT("message: " << outcome.error)
    BOOST_REQUIRE(outcome.status == 0);
    return outcome;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(the_memory_of_a_computation)

BOOST_AUTO_TEST_CASE(does_not_grow_with_the_slices_of_the_field) {
    const TemporaryFolder folder;
    const auto run = [&](int slices) {
        return compute_slices(folder, slices, folder.file("field.nrrd"), largest_allocation_of_16_mebibytes);
    };
    run(64);  // compiles
    const Outcome small = run(64);
    const Outcome large = run(1024);  // 256 MiB
    BOOST_TEST(std::filesystem::file_size(folder.file("field.nrrd")) > 256 * mebibyte);
    BOOST_TEST(large.peak_bytes < small.peak_bytes + 64 * mebibyte);
}

BOOST_AUTO_TEST_CASE(is_told_as_it_is_and_the_bytes_are_the_same_however_little_the_device_has) {
    const TemporaryFolder folder;
    const json whole = json::parse(compute_slices(folder, 100, folder.file("whole.nrrd"), {}).out)["statistics"];
    const json slabs = json::parse(
        compute_slices(folder, 100, folder.file("slabs.nrrd"), {"CLSDF_MAX_ALLOCATION=4194304"}).out)["statistics"];
    BOOST_TEST((content_of(folder.file("whole.nrrd")) == content_of(folder.file("slabs.nrrd"))));
    constexpr std::size_t slice = 256 * 256 * 4;
    BOOST_TEST(whole["slabs"].get<std::size_t>() == 1U);
    BOOST_TEST(slabs["slabs"].get<std::size_t>() == 7U);  // of 16 slices
    BOOST_TEST(whole["host_bytes"].get<std::size_t>() == 100 * slice);
    BOOST_TEST(slabs["host_bytes"].get<std::size_t>() == 2 * 16 * slice);
    BOOST_TEST(whole["device_bytes"].get<std::size_t>() > 0U);
    BOOST_TEST(slabs["band_samples"] == whole["band_samples"]);
}

BOOST_AUTO_TEST_SUITE_END()
