#pragma once

#include <clsdf/grid.hpp>

#include "plan/job.hpp"

#include <optional>

namespace clsdf::engine {

/// The box outside which no triangle decides a sample of the job's bricks; nothing if there is no such box.
std::optional<Box> box_near_bricks(const Job& job);

/// The box of all triangles that rows of the job's bricks can cross before their samples.
Box box_near_rows(const Job& job);

/// Whether a selection of this share of the mesh pays off.
inline bool is_small(double share) {
    return share < 0.5;
}

/// The fraction of the mesh's box that lies in another box, 0 to 1.
double share_of(const Box& mesh, const Box& box);

}  // namespace clsdf::engine
