#include "segments/film_walls.hpp"

#include "points/signs_by_host.hpp"
#include "segments/face_hits.hpp"
#include "tree/ray_walk.hpp"

#include <clsdf/outputs.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

namespace clsdf::segments {

namespace {

/// Between faces the winding number changes where it passes a half integer. There it is asked for at points.
class FilmWalk {
public:
    FilmWalk(const FilmLine& line, SignRule rule, const Windings& at, const std::function<bool(const Wall&)>& visit)
        : line_(line),
          film_(*line.searched.mesh.film),
          rule_(rule),
          visit_(visit),
          unit_(line.searched.mesh.lattice.unit),
          at_(at),
          is_inside_(at.are_inside(rule)) {
        double square = 0;
        for (const double x : line.along) square += x * x;
        length_ = std::sqrt(square);
    }

    void walk(std::span<const Crossed> crossed, const Windings& at_last) {
        double low = line_.first;
        if (crossed.empty() || crossed[0].place > low) agree(low);
        for_each_place(crossed, by_place(line_.exact), [&](std::span<const Crossed> faces) {
            const double place = std::clamp(faces[0].place, low, line_.last);
            find_to_face(low, place);
            for (const Crossed& face : faces) at_.add(face.looks, face.change);
            low = place;
            update(faces[0].place, faces[0].triangle);
            agree(low);
            return is_done_;
        });
        // Looks differ at the end alone; the last wall is there then.
        find(low, line_.last, at_last.of_looks[0]);
        at_ = at_last;
        update(line_.last, no_triangle);
    }

private:
    /// In the caller's coordinates.
    Vec3 point(double place) const {
        Vec3 p{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] = std::fma(place, line_.along[axis], line_.from[axis]) * unit_;
        return p;
    }
    int winding_at(double place) const { return points::rounded_winding_number(line_.searched, point(place)); }
    /// Whether open edges do not change the winding number there.
    bool is_without_film(double low, double high) const {
        const Vec3 middle = point(0.5 * (low + high));
        const double change = film_.change_within(middle, 0.5 * (high - low) * length_ * (1 + 1e-9));
        return change < 0.5 && change < film_.look(middle, change).to_half;
    }
    /// Whether a part of the line is so short that it is not divided.
    bool is_short(double low, double high) const {
        const double middle = 0.5 * (low + high);
        return high - low <= line_.resolution || middle <= low || middle >= high;
    }

    /// Whether the line may run within a face. Else looks differ at open edges alone that the line meets.
    bool may_be_in_face() {
        if (!may_be_in_face_) {
            const engine::PointMesh& mesh = line_.searched.mesh;
            const engine::CrossedFaces faces{mesh};
            const int exponent = exponent_of(line_.along);
            const engine::TreeRay ray = engine::tree_ray(mesh, point(0), times_power(line_.along, -exponent));
            const float end = ray.end_at(std::ldexp(line_.last * (1 + 0x1p-40), exponent));
            may_be_in_face_ = engine::visit_faces(line_.searched.tree, ray, end, [&](std::size_t face) {
                return mesh.sign_count(face) != 0 && is_in_plane(line_.exact, faces.sign_corners(face));
            });
        }
        return *may_be_in_face_;
    }
    /// Behind open edges all looks see what the first one sees, to which the film fits.
    void agree(double place) {
        const bool do_agree =
            std::ranges::all_of(at_.of_looks, [&](std::int32_t winding) { return winding == at_.of_looks[0]; });
        if (do_agree || place >= line_.last || may_be_in_face()) return;
        at_ = Windings(at_.of_looks[0]);
        update(place, no_triangle);
    }
    void update(double place, std::uint32_t triangle) {
        if (is_done_ || at_.are_inside(rule_) == is_inside_) return;
        is_inside_ = !is_inside_;
        is_done_ = visit_({place, triangle});
    }
    /// From `low` on, where the winding number is that of at_, to `high`, where it is `winding`.
    void find(double low, double high, int winding) {
        if (is_done_) return;
        if (winding == at_.of_looks[0] && (high - low <= line_.pair || is_without_film(low, high))) return;
        const double middle = 0.5 * (low + high);
        if (is_short(low, high)) {
            at_.add(CLSDF_ALL_LOOKS, winding - at_.of_looks[0]);
            update(middle, no_triangle);
            return;
        }
        find(low, middle, winding_at(middle));
        find(middle, high, winding);
    }
    /// The same to a face, where the winding number is not known.
    void find_to_face(double low, double high) {
        while (!is_done_ && !is_short(low, high) && !is_without_film(low, high)) {
            const double middle = 0.5 * (low + high);
            find(low, middle, winding_at(middle));
            low = middle;
        }
    }

    const FilmLine& line_;
    const FilmTree& film_;
    SignRule rule_;
    const std::function<bool(const Wall&)>& visit_;
    double unit_, length_ = 0;
    Windings at_;
    bool is_inside_, is_done_ = false;
    std::optional<bool> may_be_in_face_;  // asked for when looks differ
};

}  // namespace

void walk_with_film(const FilmLine& line, std::span<const Crossed> crossed, SignRule rule, const Windings& at,
                    const Windings& at_last, const std::function<bool(const Wall&)>& visit) {
    FilmWalk(line, rule, at, visit).walk(crossed, at_last);
}

}  // namespace clsdf::segments
