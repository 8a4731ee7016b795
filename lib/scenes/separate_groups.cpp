#include "scenes/separate_groups.hpp"

#include "mesh/box_index.hpp"

#include <algorithm>

namespace clsdf::scenes {

std::vector<std::vector<std::uint32_t>> separate_groups(std::span<const Box> boxes) {
    const BoxIndex index(boxes);
    std::vector<std::vector<std::uint32_t>> groups;
    std::vector<std::uint32_t> group_of(boxes.size());
    std::vector<std::uint32_t> taken;  // by group: by a neighbour of box number `taken` - 1, or an earlier one
    for (std::uint32_t box = 0; box < boxes.size(); ++box) {
        index.any(boxes[box], [&](std::size_t other) {
            if (other < box) taken[group_of[other]] = box + 1;
            return false;
        });
        const auto free = std::ranges::find_if(taken, [&](std::uint32_t by) { return by != box + 1; });
        const auto group = static_cast<std::uint32_t>(free - taken.begin());
        if (free == taken.end()) {
            taken.push_back(0);
            groups.emplace_back();
        }
        groups[group].push_back(box);
        group_of[box] = group;
    }
    return groups;
}

}  // namespace clsdf::scenes
