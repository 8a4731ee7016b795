#include "apps/process.hpp"
#include "picture/example.hpp"

#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

using clsdf::test::check_refused;
using clsdf::test::content_of;
using clsdf::test::is_png;
using clsdf::test::no_devices;
using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::two_balls;

BOOST_AUTO_TEST_SUITE(the_render_command)

BOOST_AUTO_TEST_CASE(opens_a_solid_of_which_no_distances_are_known) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    clsdf::Field balls = two_balls();
    balls.band.inside = 0;
    for (float& distance : balls.distance())
        if (distance < 0) distance = -0.0F;
    write_field(balls, field);
    const Outcome outcome =
        run_command({"render", field, "-o", folder.file("balls.png"), "--size", "60", "--cut", "z", "--quiet"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.error.empty());
}

BOOST_AUTO_TEST_CASE(draws_what_its_options_say) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    const std::string picture = folder.file("balls.png");
    const Outcome plain = run_command({"render", field, "-o", picture, "--size", "100", "--json"});
    BOOST_TEST(plain.status == 0);
    const std::string up = nlohmann::json::parse(plain.out)["up"];
    BOOST_TEST((up == "y" || up == "z"));
    BOOST_TEST(plain.error == "wrote " + picture + ", " + up + " upwards (--up)\n");
    BOOST_TEST(nlohmann::json::parse(plain.out)["picture"] == picture);
    BOOST_TEST(nlohmann::json::parse(plain.out)["offset"] == 0.0);
    BOOST_TEST(is_png(picture));
    std::string before = content_of(picture);
    for (const std::vector<std::string>& options : {std::vector<std::string>{"--view", "side"},
                                                    {"--view", "-30,-20.5"},
                                                    {"--up", "-y"},
                                                    {"--perspective", "40"},
                                                    {"--size", "90x70"},
                                                    {"--colour", "3366cc"},
                                                    {"--cut", "x=0.1"},
                                                    {"--cut", "x", "--cut", "z=-0.1"},
                                                    {"--cut", "x", "--bare"},
                                                    {"--offset", "-0.05"},
                                                    {"--offset", "0.2"},
                                                    {"--rays", "1"},
                                                    {"--transparent"}})
        BOOST_TEST_CONTEXT(options[0] << (options.size() > 1 ? " " + options[1] : "")) {
            std::vector<std::string> arguments{"render", field, "-o", picture, "--quiet"};
            if (options[0] != "--size") arguments.insert(arguments.end(), {"--size", "100"});
            arguments.insert(arguments.end(), options.begin(), options.end());
            const Outcome outcome = run_command(arguments);
            BOOST_TEST(outcome.status == 0);
            BOOST_TEST(outcome.error.empty());
            BOOST_TEST(is_png(picture));
            BOOST_TEST((content_of(picture) != before));
            before = content_of(picture);
        }
}

BOOST_AUTO_TEST_CASE(refuses_what_it_cannot_draw_and_writes_nothing) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    const std::string picture = folder.file("balls.png");
    const auto refused = [&](int status, const std::vector<std::string>& fragments,
                             const std::vector<std::string>& options) {
        std::vector<std::string> arguments{"render", field, "-o", picture};
        arguments.insert(arguments.end(), options.begin(), options.end());
        check_refused(run_command(arguments), status, fragments);
    };
    refused(2, {"\"behind\"", "front", "AZIMUTH,ELEVATION"}, {"--view", "behind"});
    refused(2, {"\"up\"", "-z"}, {"--up", "up"});
    refused(2, {"--size", "WxH", "'100x'"}, {"--size", "100x"});
    refused(2, {"--size", "'5'", "16 to 10000"}, {"--size", "5"});
    refused(2, {"--colour", "six hexadecimal digits", "'red'"}, {"--colour", "red"});
    refused(2, {"--cut", "x=0.3", "'x=left'"}, {"--cut", "x=left"});
    refused(2, {"\"w\"", "x, y or z"}, {"--cut", "w=1"});
    refused(2, {"cut at x = 9", "reaches from -1.2"}, {"--cut", "x=9"});
    refused(2, {"--offset", "'wide'"}, {"--offset", "wide"});
    refused(2, {"--offset"}, {"--offset", ""});
    refused(2, {"band ends at distance 0.4", "wider band"}, {"--offset", "1"});
    refused(2, {"--rays", "'0'"}, {"--rays", "0"});
    refused(2, {"--perspective", "'-1'"}, {"--perspective", "-1"});
    refused(2, {"perspective of 170"}, {"--perspective", "170"});
    refused(4, {"--device no such device"}, {"--device", "no such device"});
    check_refused(run_command({"render", field, "-o", picture}, no_devices), 4, {"OpenCL"});
    check_refused(run_command({"render", field, "-o", folder.file("balls.pdf")}), 2, {".pdf", "choose .png"});
    check_refused(run_command({"render", field, "-o", folder.file("none/balls.png")}), 5, {"no folder"});
    check_refused(run_command({"render", folder.file("none.nrrd"), "-o", picture}), 3, {"none.nrrd"});
    check_refused(run_command({"render", field}), 2, {"--output"});
    check_refused(run_command({"render", field, "-o", picture, "--elevation", "3"}), 2, {"--elevation"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(leaves_nothing_where_it_is_interrupted) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    Process process({"render", field, "-o", folder.file("b.png"), "--size", "6000", "--rays", "8"});
    process.wait_until([&] { return process.cpu_seconds_so_far() >= 1; });
    process.send(SIGINT);
    check_refused(process.wait(), 6, {"cancelled"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(has_a_help_page_with_examples) {
    const Outcome outcome = run_command({"render", "--help"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.out.find("Examples:\n  clsdf render ") != std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
