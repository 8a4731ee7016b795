#include "conformance/set.hpp"
#include "support/exact_field.hpp"
#include "support/temporary_folder.hpp"

#include <clsdf/clsdf.hpp>
#include <clsdf/io.hpp>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr double no_limit = std::numeric_limits<double>::infinity();
const OutputSet wanted = Output::triangle | Output::closest | Output::gradient;

/// conformance/judge.py on a folder of results.
bool passes(const std::string& results) {
    // The judge uses no device: nothing lies between it and OpenCL's loader.
    const std::string command = std::string("env -u LD_PRELOAD '") + CLSDF_TEST_PYTHON + "' '" + CLSDF_JUDGE + "' '" +
                                CLSDF_CONFORMANCE_SET + "' '" + results + "' >&2";
    return std::system(command.c_str()) == 0;
}

/// A transform of each case is kept, so that all of them are on the device in turn.
std::vector<std::unique_ptr<DistanceTransform>> transforms_of(const std::vector<ConformanceCase>& cases,
                                                              const char* file) {
    std::vector<std::unique_ptr<DistanceTransform>> transforms;
    for (const ConformanceCase& one : cases)
        transforms.push_back(
            std::make_unique<DistanceTransform>(test_device(), read_mesh((one.folder / file).string())));
    return transforms;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_answer_to_a_query_is_right) {
    const std::vector<ConformanceCase> cases = conformance_cases(CLSDF_CONFORMANCE_SET);
    BOOST_REQUIRE(cases.size() >= 60);
    for (const char* const file : {"mesh.obj", "mesh.stl"}) {
        const auto transforms = transforms_of(cases, file);
        const TemporaryFolder results;
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const std::vector<Vec3> points = read_points((cases[i].folder / "points.npy").string());
            Field field;
            for (const Output output : {Output::distance, Output::triangle, Output::closest, Output::gradient})
                field.resize(output, points.size());
            transforms[i]->query(points, no_limit, field.targets());
            BOOST_TEST((transforms[i]->sign() != SignRule::none || cases[i].asks("no sign")), cases[i].name());
            write_points(points, field.slab(), results.file(cases[i].name() + ".npy"), wanted);

            std::vector<double> doubles(points.size());
            transforms[i]->query(points, no_limit, OutputTargets(std::span(doubles)));
            const double side = read_mesh((cases[i].folder / file).string()).box().longest_side();
            for (std::size_t k = 0; k < points.size(); ++k) {
                const double right = cases[i].answers["distance"][k];
                BOOST_TEST(std::fabs(std::fabs(doubles[k]) - right) <= 2e-13 * std::max(side, right),
                           cases[i].name() << ", point " << k << ": " << doubles[k] << " instead of " << right);
                BOOST_TEST((doubles[k] < 0) == (cases[i].answers["sign"][k] < 0), cases[i].name() << ", point " << k);
            }
        }
        BOOST_TEST(passes(results.file("")), file << ": conformance/judge.py found faults");
    }
}
