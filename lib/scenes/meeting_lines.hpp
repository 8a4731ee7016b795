#pragma once

#include "scenes/searched_bodies.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace clsdf::scenes {

/// A straight line on the surface of the union in which faces of different bodies meet, in the scene's coordinates.
struct MeetingLine {
    Vec3 from, to;
    std::uint32_t body;      ///< the lowest of those whose faces are on the union beside the line,
    std::uint32_t face;      ///< and its face, as its tree numbers it
    std::uint32_t triangle;  ///< the same in the caller's order, the lowest
};

/// The lines in which faces of different bodies meet, as far as they are on the surface of the union, at one pose of
/// each body. The faces that meet are found by exact predicates, for vertices rounded in the scene's coordinates.
class MeetingLines {
public:
    explicit MeetingLines(const SearchedScene& scene);

    struct Nearest {
        const MeetingLine* line = nullptr;  ///< null: none is within the limit
        Vec3 closest{};
        double distance = 0;
    };
    /// Of those with the same distance the lowest body's lowest face.
    Nearest nearest(const Vec3& p, double most) const;

    std::size_t count() const { return lines_.size(); }
    std::size_t host_bytes() const { return lines_.size() * (sizeof(MeetingLine) + 2 * sizeof(Box)); }

private:
    std::vector<MeetingLine> lines_;
    BodyTree tree_;  // of their boxes
};

}  // namespace clsdf::scenes
