#include "apps/process.hpp"
#include "support/source_file.hpp"

#include <boost/test/unit_test.hpp>

#include <regex>
#include <set>
#include <utility>
#include <vector>

using clsdf::test::content_of;
using clsdf::test::exit_statuses;
using clsdf::test::matches;
using clsdf::test::Outcome;
using clsdf::test::run_command;
using clsdf::test::source_file;
using clsdf::test::subcommands;
using clsdf::test::TemporaryFolder;

namespace {

/// "--resolution": what the help page offers.
std::set<std::string> long_options(const std::string& subcommand) {
    return matches(run_command({subcommand, "--help"}).out, "\n  (?:-[a-z],)?(--[a-z-]+)");
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::string without_backslashes(std::string text) {
    std::erase(text, '\\');
    return text;
}

struct Generated {
    Generated() {
        std::filesystem::create_directory(folder.file("out"));
        const std::string out = folder.file("out");
        BOOST_REQUIRE(run_command({"generate", "--manual", out, "--completions", out}).status == 0);
    }
    std::string file(const std::string& name) const { return content_of(folder.file("out") + '/' + name); }

    TemporaryFolder folder;
};

}  // namespace

BOOST_AUTO_TEST_SUITE(documents)

BOOST_FIXTURE_TEST_CASE(have_every_option_of_every_subcommand, Generated) {
    const std::set<std::string> names = subcommands();
    const std::string bash = file("clsdf");
    const std::string zsh = file("_clsdf");
    const std::string fish = file("clsdf.fish");
    const std::string pages = without_backslashes(file("clsdf.1"));
    for (const std::string& name : names) {
        const std::string page = without_backslashes(file("clsdf-" + name + ".1"));
        const std::string bash_options = bash.substr(std::min(bash.size(), bash.rfind("        " + name + ":*)")));
        const std::string zsh_options = zsh.substr(std::min(zsh.size(), zsh.find("            " + name + ")\n")));
        BOOST_TEST(contains(pages, "fB" + name + "fR"), name);
        BOOST_TEST(contains(pages, ".BR clsdf-" + name), name);
        const std::set<std::string> options = long_options(name);
        BOOST_REQUIRE(options.size() >= 1U);
        for (const std::string& option : options) BOOST_TEST_CONTEXT(name << ' ' << option) {
                BOOST_TEST(contains(page, "fB" + option + "fR"));
                const std::string line = bash_options.substr(0, bash_options.find(";;"));
                BOOST_TEST((contains(line, option + ' ') || contains(line, option + '\'')));
                const std::string part = zsh_options.substr(0, zsh_options.find(";;"));
                BOOST_TEST((contains(part, option + '[') || contains(part, option + "=[")));
                BOOST_TEST(
                    std::regex_search(fish, std::regex("from " + name + "'[^\n]* -l " + option.substr(2) + " ")));
            }
    }
}

BOOST_FIXTURE_TEST_CASE(have_what_a_subcommand_requires_in_the_synopsis, Generated) {
    for (const auto& [name, synopsis] :
         std::vector<std::pair<std::string, std::string>>{{"query", "fIMESHfR... fIPOINTSfR fB-ofR fIRESULTfR"},
                                                          {"check", "fIMESHfR... fIFIELDfR"},
                                                          {"compute", "fIMESHfR... fB-ofR fIFIELDfR"},
                                                          {"bench", "fIBENCHMARKfR [fIMESHESfR...]"}})
        BOOST_TEST(contains(without_backslashes(file("clsdf-" + name + ".1")),
                            "fBclsdf " + name + "fR [fIOPTIONfR ...] " + synopsis + '\n'),
                   name);
}

BOOST_FIXTURE_TEST_CASE(have_the_words_that_an_option_takes_and_the_endings_of_files, Generated) {
    BOOST_TEST(contains(file("clsdf"), "_clsdf_words 'auto nonzero parity solid-angle below none'"));
    BOOST_TEST(contains(file("_clsdf"), "(auto nonzero parity solid-angle below none)"));
    BOOST_TEST(contains(file("clsdf.fish"), "-l sign -x -a 'auto nonzero parity solid-angle below none'"));
    for (const char* name : {"clsdf", "_clsdf", "clsdf.fish"})
        for (const char* word : {".off", ".ply", ".nrrd", ".npy", ".png", "seashell"})
            BOOST_TEST(contains(file(name), word), word << " in " << name);
}

BOOST_AUTO_TEST_CASE(of_the_command_have_tables_that_are_not_stale) {
    const TemporaryFolder folder;
    const std::string written = content_of(source_file("docs/command.md"));
    const std::string made = folder.file("command.md", written);
    const Outcome outcome = run_command({"generate", "--tables", made});
    BOOST_TEST(outcome.status == 0, outcome.error);
    BOOST_TEST((content_of(made) == written), "docs/command.md: make it anew, clsdf generate --tables docs/command.md");
    for (const std::string& name : subcommands()) {
        const std::size_t begin = written.find("<!-- options of " + name + " -->");
        BOOST_REQUIRE(begin != std::string::npos);
        const std::string table = written.substr(begin, written.find("<!-- end of options -->", begin) - begin);
        for (const std::string& option : long_options(name))
            if (option != "--help") BOOST_TEST(contains(table, '`' + option), name << ' ' << option);
    }
    const std::string other = folder.file("other.md", "nothing\n");
    clsdf::test::check_refused(run_command({"generate", "--tables", other}), 2, {"lacks the marks for the options of"});
}

BOOST_AUTO_TEST_CASE(of_errors_name_every_code_with_its_exit_status) {
    const std::string text = content_of(source_file("docs/errors.md"));
    std::set<std::string> codes;
    for (const auto& [code, status] : exit_statuses) {
        BOOST_TEST(contains(text, "\n| `" + code + "` | " + std::to_string(status) + " | "), code);
        codes.insert(code);
    }
    const std::string header = content_of(source_file("lib/include/clsdf/error.hpp"));
    BOOST_TEST(matches(header, "\n    ([a-z_]+) = [0-9]+, +///<") == codes, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_SUITE_END()
