#include "scenes/meeting_lines.hpp"

#include "core/floating_point.hpp"
#include "core/parallel.hpp"
#include "core/vectors.hpp"
#include "cutting/meetings.hpp"
#include "mesh/box_index.hpp"
#include "mesh/equal_vertices.hpp"
#include "scenes/union_test.hpp"
#include "tree/wide_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <tuple>
#include <utility>

namespace clsdf::scenes {

namespace {

/// A face by the numbers of its body and of itself in this body's tree.
using FaceOfBody = std::pair<std::uint32_t, std::uint32_t>;

/// The faces whose boxes meet those of faces of other bodies, as one mesh.
struct NearFaces {
    std::vector<Vec3> vertices;  ///< times the power of two by which the largest coordinate is between 1/2 and 1
    std::vector<Triangle> triangles;
    std::vector<FaceOfBody> faces;  ///< of each triangle
    std::vector<std::array<std::uint32_t, 2>> pairs;
    int exponent = 0;

    Vec3 in_scene(Vec3 p) const {
        for (double& x : p) x = std::ldexp(x, exponent);
        return p;
    }
};

Box common_part(const Box& a, const Box& b) {
    Box common;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        common.lower[axis] = std::max(a.lower[axis], b.lower[axis]);
        common.upper[axis] = std::min(a.upper[axis], b.upper[axis]);
    }
    return common;
}

/// Bodies whose boxes meet, and where.
struct NearBodies {
    std::uint32_t first, second;
    Box common;
};

std::vector<NearBodies> near_bodies(const SearchedScene& scene) {
    std::vector<Box> boxes;
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].shape == nullptr) continue;
        numbers.push_back(i);
        boxes.push_back(scene.bodies[i].frame->to_scene(mesh_of(scene.bodies[i]).box));
    }
    std::vector<NearBodies> near;
    const BoxIndex index(boxes);
    for (std::size_t leaf = 0; leaf < index.leaf_count(); ++leaf)
        index.for_each_pair(leaf, [&](std::size_t a, std::size_t b) {
            near.push_back({numbers[a], numbers[b], common_part(boxes[a], boxes[b])});
        });
    return near;
}

/// Calls visit(face) for the faces of a body whose boxes meet one in its coordinates.
template <typename Visit>
void visit_faces(const SearchedBody& body, const Box& box, const Visit& visit) {
    engine::visit_faces(*body.shape->inputs.leaves->tree, engine::UnitBox(box, mesh_of(body).lattice),
                        [&](std::size_t face) {
                            visit(static_cast<std::uint32_t>(face));
                            return false;
                        });
}

/// The pairs of faces of two bodies whose boxes meet.
std::vector<std::array<FaceOfBody, 2>> near_pairs(const SearchedScene& scene, const NearBodies& bodies) {
    const SearchedBody &first = scene.bodies[bodies.first], &second = scene.bodies[bodies.second];
    const double margin = 4 * relative_rounding * std::max(largest_of(first), largest_of(second));
    std::vector<std::array<FaceOfBody, 2>> pairs;
    visit_faces(first, first.frame->to_body(bodies.common), [&](std::uint32_t face) {
        Box box = empty_box;
        for (const Vec3& corner : mesh_of(first).corners(face)) {
            const Vec3 p = second.frame->to_body(first.frame->to_scene(corner));
            add(box, {p, p});
        }
        visit_faces(second, widened(box, margin), [&](std::uint32_t other) {
            pairs.push_back({FaceOfBody{bodies.first, face}, FaceOfBody{bodies.second, other}});
        });
    });
    return pairs;
}

NearFaces near_faces(const SearchedScene& scene) {
    const std::vector<NearBodies> bodies = near_bodies(scene);
    std::vector<std::vector<std::array<FaceOfBody, 2>>> of_bodies(bodies.size());
    for_each_index(
        bodies.size(), [&](std::size_t i) { of_bodies[i] = near_pairs(scene, bodies[i]); }, 1);
    NearFaces near;
    for (const auto& pairs : of_bodies)
        for (const auto& pair : pairs) near.faces.insert(near.faces.end(), pair.begin(), pair.end());
    std::ranges::sort(near.faces);
    near.faces.erase(std::ranges::unique(near.faces).begin(), near.faces.end());
    const auto number_of = [&](const FaceOfBody& face) {
        return static_cast<std::uint32_t>(std::ranges::lower_bound(near.faces, face) - near.faces.begin());
    };
    for (const auto& pairs : of_bodies)
        for (const auto& [a, b] : pairs) near.pairs.push_back({number_of(a), number_of(b)});

    double largest = 0;
    std::vector<std::uint32_t> numbers;  // of the vertices of a body
    constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    for (std::size_t i = 0; i < near.faces.size(); ++i) {
        const SearchedBody& body = scene.bodies[near.faces[i].first];
        const engine::PointMesh& mesh = mesh_of(body);
        if (i == 0 || near.faces[i - 1].first != near.faces[i].first) numbers.assign(mesh.positions.size(), none);
        Triangle triangle = mesh.topology->faces.triangles[near.faces[i].second];
        for (std::uint32_t& corner : triangle) {
            std::uint32_t& known = numbers[corner];
            if (known == none) {
                known = static_cast<std::uint32_t>(near.vertices.size());
                near.vertices.push_back(body.frame->to_scene(mesh.positions[corner]));
                largest = std::max(largest, largest_of(near.vertices.back()));
            }
            corner = known;
        }
        near.triangles.push_back(triangle);
    }
    static_cast<void>(std::frexp(largest, &near.exponent));
    const std::vector<std::uint32_t> first = first_equal_vertices(near.vertices);
    std::vector<std::uint32_t> kept(first.size());
    std::size_t count = 0;
    for (std::size_t v = 0; v < first.size(); ++v) {
        if (first[v] != v) continue;
        kept[v] = static_cast<std::uint32_t>(count);
        near.vertices[count] = near.vertices[v];
        for (double& x : near.vertices[count]) x = std::ldexp(x, -near.exponent);
        ++count;
    }
    near.vertices.resize(count);
    for (Triangle& triangle : near.triangles)
        for (std::uint32_t& corner : triangle) corner = kept[first[corner]];
    return near;
}

/// Finds those parts of the lines in a face that are on the union.
class LinesOfFace {
public:
    LinesOfFace(const UnionTest& test, const NearFaces& near, std::uint32_t number)
        : test_(test),
          near_(near),
          body_(near.faces[number].first),
          face_(near.faces[number].second),
          placed_(test.scene().bodies[body_], face_) {}

    /// other: the face in which it meets this one, by its number among the near ones; none: it is in the same plane.
    void add(const Vec3& from, const Vec3& to, std::optional<std::uint32_t> other, std::vector<MeetingLine>& lines) {
        const Vec3 way = difference(to, from);
        const double all = length(way);
        if (!(all > 0)) return;
        const Vec3 along{way[0] / all, way[1] / all, way[2] / all};
        const double least = 8 * test_.rounding(body_, body_, from);
        find_third_bodies(from, to, other ? near_.faces[*other].first : body_);
        find_places(from, to);
        const std::uint32_t triangle = lowest_triangle();
        for (std::size_t i = 0; i + 1 < places_.size(); ++i) {
            if (places_.size() > 2 && (places_[i + 1] - places_[i]) * all < least) continue;
            const Vec3 begin = at(from, way, places_[i]),
                       end = i + 2 == places_.size() ? to : at(from, way, places_[i + 1]);
            const Vec3 middle = at(from, way, (places_[i] + places_[i + 1]) / 2);
            if (is_on_union(middle, along, other)) lines.push_back({begin, end, body_, face_, triangle});
        }
    }

private:
    static Vec3 at(const Vec3& from, const Vec3& way, double place) {
        return {from[0] + place * way[0], from[1] + place * way[1], from[2] + place * way[2]};
    }

    std::uint32_t lowest_triangle() const {
        const auto* const faces = static_cast<const PointFace*>(mesh_of(test_.scene().bodies[body_]).faces->on_host());
        return faces[faces[face_].lowest].triangle;
    }

    /// Bodies that may cut or hide the line.
    void find_third_bodies(const Vec3& from, const Vec3& to, std::uint32_t other) {
        third_.clear();
        const Vec3 middle = at(from, difference(to, from), 0.5);
        test_.visit_near(middle, length(difference(to, from)) / 2, [&](std::uint32_t body) {
            if (body != body_ && body != other) third_.push_back(body);
            return true;
        });
    }

    /// Where planes of their faces cut it: 0 and 1 and what is between.
    void find_places(const Vec3& from, const Vec3& to) {
        places_.assign({0, 1});
        for (const std::uint32_t number : third_) {
            const SearchedBody& body = test_.scene().bodies[number];
            const Vec3 a = body.frame->to_body(from), b = body.frame->to_body(to);
            Box box{a, a};
            clsdf::add(box, {b, b});
            const engine::PointMesh& mesh = mesh_of(body);
            engine::visit_faces(
                *body.shape->inputs.leaves->tree, engine::UnitBox(box, mesh.lattice), [&](std::size_t face) {
                    const Corners corners = mesh.corners(face);
                    const Vec3 normal = cross(difference(corners[1], corners[0]), difference(corners[2], corners[0]));
                    const double of_a = dot(normal, difference(a, corners[0])),
                                 of_b = dot(normal, difference(b, corners[0]));
                    // Ends on the same side, or on the plane, leave nothing between them.
                    if (of_a == 0 || of_b == 0 || (of_a < 0) == (of_b < 0)) return false;
                    const double place = of_a / (of_a - of_b);
                    if (place > 0 && place < 1) places_.push_back(place);
                    return false;
                });
        }
        std::ranges::sort(places_);
    }

    /// Whether a point of the line is, and so the part of it around that no third body cuts.
    bool is_on_union(const Vec3& p, const Vec3& along, std::optional<std::uint32_t> other) const {
        if (!other || !cross_at(p, along, *other)) return test_.is_on_union_beside(p, along, body_, placed_);
        // One side of each of the two faces is in none of the two bodies.
        PlaceInBody of_third = PlaceInBody::outside;
        for (const std::uint32_t third : third_) {
            of_third =
                std::max(of_third, place_in(test_.scene().bodies[third], p, 4 * test_.rounding(body_, third, p)));
            if (of_third == PlaceInBody::inside) return false;
        }
        return of_third == PlaceInBody::outside || test_.is_on_union_beside(p, along, body_, placed_);
    }

    /// Whether two faces cross each other at a point of both, beyond rounding.
    bool cross_at(const Vec3& p, const Vec3& along, std::uint32_t other) const {
        constexpr double least_sine = 1e-3;
        const auto [other_body, other_face] = near_.faces[other];
        const PlacedFace others(test_.scene().bodies[other_body], other_face);
        if (!(length(cross(placed_.normal, others.normal)) > least_sine)) return false;
        const double least = 8 * test_.rounding(body_, other_body, p);
        return continues(placed_, p, along, least) && continues(others, p, along, least);
    }
    /// On both sides of the line.
    static bool continues(const PlacedFace& face, const Vec3& p, const Vec3& along, double least) {
        const Vec3 across = cross(face.normal, along);
        return extent(face, p, across) > least && extent(face, p, {-across[0], -across[1], -across[2]}) > least;
    }

    const UnionTest& test_;
    const NearFaces& near_;
    std::uint32_t body_, face_;
    PlacedFace placed_;
    std::vector<std::uint32_t> third_;
    std::vector<double> places_;
};

}  // namespace

MeetingLines::MeetingLines(const SearchedScene& scene) {
    const DefaultFloatingPoint as_kernels;
    const NearFaces near = near_faces(scene);
    if (near.triangles.empty()) return;
    const std::vector<cutting::View> views = cutting::views_of(near.vertices, near.triangles);
    std::vector<std::array<std::uint32_t, 2>> pairs;
    std::ranges::copy_if(near.pairs, std::back_inserter(pairs), [&](const auto& pair) {
        return views[pair[0]].direction != 0 && views[pair[1]].direction != 0;
    });
    cutting::CutPoints points(near.vertices, near.triangles);
    const cutting::Meetings meetings(points, views, pairs, scene.cancellation);

    std::vector<std::uint32_t> met;
    for (std::uint32_t number = 0; number < near.triangles.size(); ++number)
        if (!meetings.of(number).empty()) met.push_back(number);
    const UnionTest test(scene);
    std::vector<std::vector<MeetingLine>> of_face(met.size());
    for_each_index(
        met.size(),
        [&](std::size_t i) {
            scene.cancellation.check();
            LinesOfFace lines(test, near, met[i]);
            for (const cutting::FaceSegment& segment : meetings.of(met[i])) {
                const bool crosses = segment.cutter.axis == cutting::Cutter::of_face;
                // Both faces have the same ends in the same order.
                lines.add(near.in_scene(points.rounded(std::min(segment.from, segment.to))),
                          near.in_scene(points.rounded(std::max(segment.from, segment.to))),
                          crosses ? std::optional(segment.cutter.first) : std::nullopt, of_face[i]);
            }
        },
        8);
    for (const std::vector<MeetingLine>& lines : of_face) lines_.insert(lines_.end(), lines.begin(), lines.end());
    std::ranges::sort(lines_, {},
                      [](const MeetingLine& line) { return std::tuple(line.from, line.to, line.body, line.triangle); });
    const auto repeated = std::ranges::unique(
        lines_, [](const MeetingLine& a, const MeetingLine& b) { return a.from == b.from && a.to == b.to; });
    lines_.erase(repeated.begin(), repeated.end());
    lines_.shrink_to_fit();

    std::vector<Box> around(lines_.size());
    std::vector<std::uint32_t> numbers(lines_.size());
    for (std::uint32_t i = 0; i < lines_.size(); ++i) {
        around[i] = {lines_[i].from, lines_[i].from};
        add(around[i], {lines_[i].to, lines_[i].to});
        numbers[i] = i;
    }
    tree_ = BodyTree(around, numbers);
}

MeetingLines::Nearest MeetingLines::nearest(const Vec3& p, double most) const {
    Nearest found;
    found.distance = most;
    tree_.visit_near(p, most, [&](std::uint32_t number) {
        const MeetingLine& line = lines_[number];
        const Vec3 way = difference(line.to, line.from);
        const double place = std::clamp(dot(difference(p, line.from), way) / dot(way, way), 0.0, 1.0);
        Vec3 closest;
        for (std::size_t axis = 0; axis < 3; ++axis)
            closest[axis] = place == 1 ? line.to[axis] : line.from[axis] + place * way[axis];
        const double distance = length(difference(p, closest));
        const auto rank = [](const MeetingLine& of) { return std::pair(of.body, of.triangle); };
        if (distance < found.distance ||
            (distance == found.distance && (found.line == nullptr || rank(line) < rank(*found.line))))
            found = {&line, closest, distance};
        return found.distance;
    });
    return found;
}

}  // namespace clsdf::scenes
