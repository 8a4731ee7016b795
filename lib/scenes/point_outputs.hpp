#pragma once

#include "core/outputs.hpp"
#include "scenes/least_field.hpp"
#include "scenes/searched_bodies.hpp"
#include "targets/host_arrays.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace clsdf::scenes {

/// What is known of a point.
struct Found {
    /// The least signed distance so far, squared, with its sign, in the scene's units: infinite beyond the half width.
    double value = std::numeric_limits<double>::infinity();
    std::uint32_t body = no_body;  ///< whose value is the least, or inside which the point lies beyond the half width
    std::uint32_t face = CLSDF_NO_FACE;
    std::uint8_t sign = CLSDF_POINT_OUTSIDE;
    bool is_left_out = false;                                       ///< a body is too far away to be searched
    double not_searched = std::numeric_limits<double>::infinity();  ///< the least distance from their boxes

    bool is_inside() const { return sign == CLSDF_POINT_INSIDE; }
};

/// The outputs of one point, in double, and then in the scene's coordinates.
class Outputs {
public:
    /// wanted: the outputs of all points.
    explicit Outputs(const targets::HostArrays& wanted);

    Vec3 closest() const;

    /// Stores the outputs of a point by one body at its place among all. Returns whether it is within the half width,
    /// and has set closest() then, in the scene's coordinates.
    bool store(const SearchedBody* body, const Found& found, const Vec3& point, const HalfWidths& half_widths,
               std::size_t at);

    /// The same of a point inside the union whose closest point, in the scene's coordinates, is on a cut in a face of
    /// the body. distance: between the two, above 0 and within the half width.
    void store_cut(const SearchedBody& body, std::uint32_t number, std::uint32_t face, const Vec3& point,
                   const Vec3& closest, double distance, std::size_t at);

    /// Stores those of a point beyond the half width.
    void leave(double distance, std::size_t at) const;

private:
    void turn(Output output, const Frame& frame);
    void copy(std::size_t at) const;

    const targets::HostArrays& wanted_;
    targets::HostArrays arrays_;
    std::array<double, 3 * CLSDF_OUTPUT_COUNT> room_{};
};

}  // namespace clsdf::scenes
