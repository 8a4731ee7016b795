#include "mesh/nearest_name.hpp"

#include "core/edit_distance.hpp"

#include <limits>

namespace clsdf {

std::string nearest_name(std::string_view text, std::span<const std::string> candidates) {
    std::string nearest;
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (const std::string& candidate : candidates) {
        const std::size_t distance = edit_distance(text, candidate);
        if (distance < least) {
            least = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

}  // namespace clsdf
