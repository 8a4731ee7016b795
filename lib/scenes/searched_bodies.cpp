#include "scenes/searched_bodies.hpp"

#include "points/signs_by_host.hpp"

#include <algorithm>
#include <cmath>

namespace clsdf::scenes {

double largest_of(const Vec3& p) {
    return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
}

double largest_of(const SearchedBody& body) {
    const Box& box = mesh_of(body).box;
    return std::max({largest_of(box.lower), largest_of(box.upper), largest_of(body.frame->translation)});
}

double rounding_of(const SearchedBody& body, const Vec3& p) {
    return relative_rounding * std::max(largest_of(body), largest_of(p));
}

points::NearestOfPoint nearest_within(const SearchedBody& body, const Vec3& in_body, double half_width,
                                      std::uint32_t& near) {
    const engine::PointMesh& mesh = mesh_of(body);
    return points::find_nearest(body.shape->inputs, mesh.in_units(in_body), points::search_limit(mesh, half_width),
                                near);
}

void find_signs(const SearchedBody& body, std::span<const Vec3> in_body, std::span<const double> squared,
                std::span<std::uint8_t> signs) {
    std::array<std::uint32_t, most_at_once> order;
    for (std::size_t i = 0; i < in_body.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
    points::find_signs({mesh_of(body), *body.shape->inputs.leaves->tree}, body.shape->inputs.sign,
                       {in_body, std::span(order).first(in_body.size()), squared}, signs);
}

PlaceInBody place_in(const SearchedBody& body, const Vec3& point, double rounding) {
    const Vec3 in_body = body.frame->to_body(point);
    if (!is_usable(body, in_body)) return PlaceInBody::outside;
    if (!body.shape->has_film && distance_to(body.shape->sign_box, in_body) > rounding) return PlaceInBody::outside;
    std::uint32_t near = CLSDF_NO_FACE;
    const points::NearestOfPoint nearest = nearest_within(body, in_body, rounding, near);
    const double most = rounding / mesh_of(body).lattice.unit;
    if (nearest.face != CLSDF_NO_FACE && nearest.squared <= most * most) return PlaceInBody::on;
    std::uint8_t sign = CLSDF_POINT_UNDECIDED;
    find_signs(body, std::span(&in_body, 1), std::span(&nearest.squared, 1), std::span(&sign, 1));
    return sign == CLSDF_POINT_OUTSIDE ? PlaceInBody::outside : PlaceInBody::inside;
}

}  // namespace clsdf::scenes
