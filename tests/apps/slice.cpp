#include "apps/process.hpp"
#include "picture/example.hpp"

#include <clsdf/io.hpp>

#include <boost/test/unit_test.hpp>

#include <nlohmann/json.hpp>

using clsdf::test::check_refused;
using clsdf::test::content_of;
using clsdf::test::is_png;
using clsdf::test::Outcome;
using clsdf::test::Process;
using clsdf::test::run_command;
using clsdf::test::TemporaryFolder;
using clsdf::test::two_balls;

BOOST_AUTO_TEST_SUITE(the_slice_command)

BOOST_AUTO_TEST_CASE(draws_one_slice_or_a_mosaic) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    const std::string picture = folder.file("balls.png");
    BOOST_TEST(run_command({"slice", field, "-o", picture, "--pixels", "150"}).status == 0);
    BOOST_TEST(is_png(picture));
    const std::string middle = content_of(picture);
    BOOST_TEST(run_command({"slice", field, "-o", picture, "--pixels", "150", "--axis", "z", "--index", "10"}).status ==
               0);
    BOOST_TEST((content_of(picture) == middle));
    BOOST_TEST(run_command({"slice", field, "-o", picture, "--pixels", "150", "--axis", "x", "--index", "3"}).status ==
               0);
    BOOST_TEST(run_command({"slice", field, "-o", picture, "--pixels", "150", "--axis", "x", "--index", "3", "--quiet"})
                   .error.empty());
    BOOST_TEST((content_of(picture) != middle));
    const Outcome mosaic = run_command({"slice", field, "-o", picture, "--pixels", "150", "--mosaic", "--json"});
    BOOST_TEST(mosaic.status == 0);
    BOOST_TEST(nlohmann::json::parse(mosaic.out)["pictures"][0] == picture);
    BOOST_TEST(is_png(picture));
}

BOOST_AUTO_TEST_CASE(draws_every_slice_as_a_numbered_file) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    const Outcome outcome =
        run_command({"slice", field, "-o", folder.file("b.png"), "--all", "--pixels", "100", "--json"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(folder.file_count() == 1U + 21U);
    for (const char* name : {"b_00.png", "b_09.png", "b_20.png"}) BOOST_TEST(is_png(folder.file(name)));
    BOOST_TEST(nlohmann::json::parse(outcome.out)["pictures"].size() == 21U);
}

BOOST_AUTO_TEST_CASE(leaves_whole_pictures_only_where_it_is_interrupted) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    Process process({"slice", field, "-o", folder.file("b.png"), "--all", "--axis", "x", "--pixels", "2000"});
    process.wait_until([&] { return folder.file_count() >= 3; });
    process.send(SIGINT);
    const Outcome outcome = process.wait();
    check_refused(outcome, 6, {"cancelled", "of 51 pictures"});
    BOOST_TEST(folder.file_count() < 51U);
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(field).parent_path()))
        if (entry.path() != field) {
            BOOST_TEST(is_png(entry.path()));
            BOOST_TEST(content_of(entry.path()).ends_with("IEND\xae\x42\x60\x82"));
        }
}

BOOST_AUTO_TEST_CASE(refuses_what_it_cannot_draw_and_writes_nothing) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    const std::string picture = folder.file("balls.png");
    check_refused(run_command({"slice", field, "-o", picture, "--index", "21"}), 2,
                  {"no sample 21 along z", "0 to 20"});
    check_refused(run_command({"slice", field, "-o", picture, "--axis", "w"}), 2, {"'w'", "x, y, z"});
    check_refused(run_command({"slice", field, "-o", picture, "--pixels", "7"}), 2,
                  {"--pixels: a whole number from 100 to 10000, not '7'"});
    check_refused(run_command({"slice", field, "-o", picture, "--index", "-1"}), 2, {"--index", "-1"});
    check_refused(run_command({"slice", field, "-o", folder.file("balls.gif")}), 2, {".gif", ".png or .pdf"});
    check_refused(run_command({"slice", field, "-o", folder.file("none/balls.png")}), 5, {"no folder"});
    check_refused(run_command({"slice", field, "-o", picture, "--all", "--index", "2"}), 2, {"--index", "--all"});
    check_refused(run_command({"slice", field, "-o", picture, "--mosaic", "--axis", "x"}), 2, {"--mosaic", "--axis"});
    check_refused(run_command({"slice", field}), 2, {"--output"});
    check_refused(run_command({"slice", folder.file("none.nrrd"), "-o", picture}), 3, {"none.nrrd"});
    BOOST_TEST(folder.file_count() == 1U);
}

BOOST_AUTO_TEST_CASE(draws_on_a_machine_without_fonts) {
    const TemporaryFolder folder;
    const std::string field = folder.file("balls.nrrd");
    write_field(two_balls(), field);
    const std::string no_fonts = folder.file("fonts.conf", "<fontconfig></fontconfig>");
    const std::string picture = folder.file("balls.png");
    const Outcome outcome = run_command({"slice", field, "-o", picture}, {"FONTCONFIG_FILE=" + no_fonts});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.error == "wrote " + picture + "\n");
    BOOST_TEST(is_png(picture));
}

BOOST_AUTO_TEST_CASE(has_a_help_page_with_examples) {
    const Outcome outcome = run_command({"slice", "--help"});
    BOOST_TEST(outcome.status == 0);
    BOOST_TEST(outcome.out.find("Examples:\n  clsdf slice ") != std::string::npos);
}

BOOST_AUTO_TEST_SUITE_END()
