#pragma once

#include "peikert_sigg/bisector_planes.hpp"

#include <cstddef>
#include <memory>
#include <span>

namespace clsdf::peikert_sigg {

/// Signs that the bisector planes of one fan decide, each exact for the coordinates as given: by interval arithmetic,
/// and where that leaves one open by numbers with square roots. To be used, and destroyed, by the thread that made it.
class FanSigns {
public:
    /// The fan must outlive it.
    explicit FanSigns(const Fan& fan);
    ~FanSigns();

    const Fan& fan() const { return fan_; }

    /// On which side of bisector plane k the direction A_i x A_j lies: 1, -1, or 0 on the plane or where the planes i
    /// and j are parallel. The normal A_k points out of face k.
    int side(std::size_t i, std::size_t j, std::size_t k);

    /// The same of the faces' planes, moved to the vertex, with their normals.
    int side_of_face(std::size_t i, std::size_t j, std::size_t k);

    /// A power of two by which the line in which two planes of a kind meet is about as long as others.
    double line_weight(PlaneKind kind, std::size_t i, std::size_t j) const;

    /// Chooses a direction for side_of_direction(): the sum of lines in which planes of a kind meet.
    void set_direction(PlaneKind kind, std::span<const PlaneLine> lines);

    /// On which side of plane k of that kind the chosen direction lies: 1 where the normal points, -1, or 0 on it.
    int side_of_direction(std::size_t k);

    /// Whether face i is seen from its front (1), from its back (-1) or edgewise (0) along the average of the faces'
    /// unit normals.
    int facing(std::size_t i);

    std::size_t decisions() const { return decisions_; }
    std::size_t exact_decisions() const { return exact_decisions_; }

private:
    struct Filter;
    struct Exact;
    struct Direction;

    /// The sign of what `value` computes from the planes in either arithmetic.
    template <typename Value>
    int decide(const Value& value);
    const Exact& exact();

    const Fan& fan_;
    std::unique_ptr<Filter> filter_;
    std::unique_ptr<Exact> exact_;  // made when it is needed
    std::unique_ptr<Direction> direction_;
    std::size_t decisions_ = 0;
    std::size_t exact_decisions_ = 0;
};

}  // namespace clsdf::peikert_sigg
