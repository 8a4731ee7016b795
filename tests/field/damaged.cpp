#include "field/example_field.hpp"
#include "support/temporary_folder.hpp"

#include <clsdf/error.hpp>
#include <clsdf/field.hpp>

#include <boost/test/unit_test.hpp>

#include <functional>
#include <random>

using clsdf::Error;
using clsdf::ErrorCode;
using clsdf::Field;
using clsdf::test::content_of;
using clsdf::test::TemporaryFolder;

namespace {

// Each file that makes up a field, and the one that is read.
struct Case {
    std::string damaged;
    std::string read;
};

const std::vector<Case> cases{{"field.nrrd", "field.nrrd"},
                              {"field_triangle.nrrd", "field.nrrd"},
                              {"field.npy", "field.npy"},
                              {"field.npy.json", "field.npy"},
                              {"field_triangle.npy", "field.npy"}};

// Runs a statement for each file of a field, in a folder with undamaged ones; `whole` is its content.
void for_each_case(
    const std::function<void(const TemporaryFolder& folder, const Case& one, const std::string& whole)>& statement) {
    for (const Case& one : cases) {
        const TemporaryFolder folder;
        clsdf::test::example_field().write(folder.file("field.nrrd"));
        clsdf::test::example_field().write(folder.file("field.npy"));
        statement(folder, one, content_of(folder.file(one.damaged)));
    }
}

// Some file systems make the disk catch up when a file is overwritten, but not when it is new.
void replace(const TemporaryFolder& folder, const std::string& name, const std::string& content) {
    std::filesystem::remove(folder.file(name));
    folder.file(name, content);
}

// Whether it is read at all; the only other answer is the error of an unreadable file.
bool can_be_read(const std::string& path) {
    try {
        const Field field = Field::read(path);
        BOOST_TEST(field.distance.size() == field.grid.sample_count());
        return true;
    } catch (const Error& error) {
        BOOST_CHECK(error.code() == ErrorCode::unreadable_input);
        return false;
    }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(a_damaged_field)

BOOST_AUTO_TEST_CASE(is_refused_wherever_it_is_cut_off) {
    for_each_case([](const TemporaryFolder& folder, const Case& one, const std::string& whole) {
        const bool is_text = one.damaged.ends_with(".json");
        for (std::size_t length = 0; length + (is_text ? 2 : 0) < whole.size(); ++length) {
            BOOST_TEST_CONTEXT(one.damaged << " cut to " << length << " bytes") {
                replace(folder, one.damaged, whole.substr(0, length));
                BOOST_TEST(!can_be_read(folder.file(one.read)));
            }
        }
    });
}

BOOST_AUTO_TEST_CASE(is_read_or_refused_but_nothing_else_whatever_bytes_change) {
    for_each_case([](const TemporaryFolder& folder, const Case& one, const std::string& whole) {
        constexpr unsigned seed = 3;
        std::mt19937 random(seed);
        for (int round = 0; round < 2000; ++round) {
            BOOST_TEST_CONTEXT("seed " << seed << ", round " << round << " of " << one.damaged) {
                std::string mutated = whole;
                for (unsigned changes = 1 + random() % 4; changes > 0; --changes) {
                    const std::size_t position = random() % mutated.size();
                    switch (random() % 3) {
                        case 0:
                            mutated[position] = static_cast<char>(random());
                            break;
                        case 1:
                            mutated.insert(position, 1, "0123456789 -,.()\n"[random() % 17]);
                            break;
                        default:
                            mutated.erase(position, 1 + random() % 3);
                            break;
                    }
                    if (mutated.empty()) break;
                }
                replace(folder, one.damaged, mutated);
                can_be_read(folder.file(one.read));
            }
        }
    });
}

BOOST_AUTO_TEST_SUITE_END()
