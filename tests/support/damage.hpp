#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

/// Files that are damaged at random.
namespace clsdf::test {

/// Seeded and the same on every platform.
class Dice {
public:
    explicit Dice(std::uint32_t seed) : engine_(seed) {}
    std::size_t below(std::size_t limit) { return limit == 0 ? 0 : engine_() % limit; }

private:
    std::mt19937 engine_;
};

/// The content with one to four changes: cut, overwritten, with something inserted, erased, replaced or repeated.
inline std::string damaged(std::string content, Dice& dice) {
    static const std::vector<std::string> pieces{"-1",
                                                 "0",
                                                 "4294967295",
                                                 "99999999999999999999",
                                                 "1e999",
                                                 "nan",
                                                 "-inf",
                                                 "\n",
                                                 "\r",
                                                 "\\\n",
                                                 "#",
                                                 " ",
                                                 "\t",
                                                 std::string(1, '\0'),
                                                 "\xFF\xFF\xFF\xFF",
                                                 "element",
                                                 "property list uchar int q\n",
                                                 "end_header\n",
                                                 "solid",
                                                 "endloop",
                                                 "f ",
                                                 "v ",
                                                 "OFF",
                                                 "1000000000"};
    const std::size_t changes = 1 + dice.below(4);
    for (std::size_t k = 0; k < changes; ++k) {
        const std::size_t place = dice.below(content.size() + 1);
        const std::size_t length = dice.below(16);
        switch (dice.below(6)) {
            case 0:
                content.resize(place);
                break;
            case 1:
                if (place < content.size()) content[place] = static_cast<char>(dice.below(256));
                break;
            case 2:
                content.insert(place, pieces[dice.below(pieces.size())]);
                break;
            case 3:
                content.erase(place, length);
                break;
            case 4:
                content.replace(place, length, pieces[dice.below(pieces.size())]);
                break;
            default:
                content.insert(place, content.substr(dice.below(content.size() + 1), 4 * length));
                break;
        }
    }
    return content;
}

}  // namespace clsdf::test
