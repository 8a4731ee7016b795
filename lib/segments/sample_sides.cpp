#include "segments/sample_sides.hpp"

#include "core/bucket_sort.hpp"
#include "core/parallel.hpp"
#include "launch/prefix_sums.hpp"
#include "mesh/box_index.hpp"
#include "segments/open_edges_of_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace clsdf::segments {

namespace {

using crossing::double3;
using crossing::ExactVector;

/// Faces that one task looks at: few if there are few, which may be large.
constexpr std::size_t usual_faces = 512;

/// The looks that move by +e along x.
constexpr std::uint8_t forward_looks = 0x55;
constexpr std::uint8_t all_looks = CLSDF_ALL_LOOKS;

/// The plane of a face: on which side of it points are, mostly by a plain determinant as in orientation_in_space().
class Plane {
public:
    explicit Plane(const crossing::Corners& face) : face_(face), a_(face[0]) {
        Vec3 u{}, v{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            u[axis] = face[1][axis] - a_[axis];
            v[axis] = face[2][axis] - a_[axis];
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
            normal_[axis] = u[i] * v[j] - u[j] * v[i];
            size_[axis] = std::abs(u[i] * v[j]) + std::abs(u[j] * v[i]);
        }
        per_normal_ = 1 / normal_[0];
    }

    int side(const Vec3& p) const {
        double value = 0, size = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double w = p[axis] - a_[axis];
            value += normal_[axis] * w;
            size += size_[axis] * std::abs(w);
        }
        if (std::abs(value) > 0x1p-50 * size) return value > 0 ? 1 : -1;
        if (size == 0) return 0;
        const crossing::double3 a = crossing::vector(a_);
        return crossing::sign_of_determinant(crossing::exact_difference(crossing::vector(face_[1]), a),
                                             crossing::exact_difference(crossing::vector(face_[2]), a),
                                             crossing::exact_difference(crossing::vector(p), a));
    }

    /// Where the line along x through (y, z) meets the plane: within `error`, which may be infinite or NaN.
    struct Place {
        double x, error;
    };
    Place place(double y, double z) const {
        const double of_y = y - a_[1], of_z = z - a_[2];
        const double offset = (normal_[1] * of_y + normal_[2] * of_z) * per_normal_;
        const double size = size_[1] * std::abs(of_y) + size_[2] * std::abs(of_z) + size_[0] * std::abs(offset);
        return {a_[0] - offset, 0x1p-48 * (size * std::abs(per_normal_) + std::abs(offset) + std::abs(a_[0]))};
    }

private:
    const crossing::Corners& face_;
    Vec3 a_;
    Vec3 normal_{}, size_{};
    double per_normal_;
};

/// The edges of a face seen along x.
class Edges {
public:
    explicit Edges(const crossing::Corners& face) : corners_(face) {}

    /// The looks in which the line along x through (y, z) crosses the face.
    std::uint8_t looks(double y, double z) const {
        // Mostly as orientation_in_plane(), without branches.
        int positive = 0, negative = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 &a = corners_[i], &b = corners_[(i + 1) % 3];
            const double first = (b[1] - a[1]) * (z - a[2]), second = (b[2] - a[2]) * (y - a[1]);
            const double rounding = 0x1p-51 * (std::abs(first) + std::abs(second));
            positive += first - second > rounding ? 1 : 0;
            negative += first - second < -rounding ? 1 : 0;
        }
        if (positive * negative > 0) return 0;
        if (positive == 3 || negative == 3) return all_looks;
        return looks_at_edge(y, z);
    }

private:
    std::uint8_t looks_at_edge(double y, double z) const {
        std::array<int, 3> turns{};
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 &a = corners_[i], &b = corners_[(i + 1) % 3];
            turns[i] = crossing::orientation_in_plane(a[1], a[2], b[1], b[2], y, z);
        }
        const auto [least, most] = std::minmax({turns[0], turns[1], turns[2]});
        if (least < 0 && most > 0) return 0;
        if (least == most && least != 0) return all_looks;
        ExactVector along{};
        along.x.high = 1;
        std::uint32_t all = all_looks, any = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const ExactVector edge =
                crossing::exact_difference(crossing::vector(corners_[(i + 1) % 3]), crossing::vector(corners_[i]));
            const std::uint32_t positive = crossing::positive_looks(turns[i], along, edge);
            all &= positive;
            any |= positive;
        }
        return static_cast<std::uint8_t>(all | (all_looks & ~any));
    }

    const crossing::Corners& corners_;
};

/// Sets bits [begin, end).
void set_bits(std::uint64_t* words, std::int32_t begin, std::int32_t end) {
    const auto first = static_cast<std::size_t>(begin) / 64, last = static_cast<std::size_t>(end - 1) / 64;
    const std::uint64_t from = ~std::uint64_t{0} << (begin % 64), to = ~std::uint64_t{0} >> (63 - (end - 1) % 64);
    if (first == last) {
        words[first] |= from & to;
        return;
    }
    words[first] |= from;
    for (std::size_t word = first + 1; word < last; ++word) words[word] = ~std::uint64_t{0};
    words[last] |= to;
}

}  // namespace

BoxSides::BoxSides(const engine::CrossedFaces& faces, SignRule rule, const SampleBox& box,
                   const std::vector<engine::RecordRange>* near)
    : box_(box),
      has_film_(faces.mesh.film != nullptr),
      words_((static_cast<std::size_t>(box.size[0]) + 63) / 64),
      bits_(1 + box.row_count() * (words_ + 1)) {
    for_each_range(
        bits_.size(),
        [&](std::size_t begin, std::size_t end) {
            std::fill(bits_.begin() + static_cast<std::ptrdiff_t>(begin),
                      bits_.begin() + static_cast<std::ptrdiff_t>(end), 0);
        },
        std::size_t{1} << 16);
    if (box.row_count() >= std::numeric_limits<std::uint32_t>::max()) throw engine::too_many("rows of samples");
    row_begins_.assign(box.row_count() + 1, 0);
    if (rule == SignRule::none) return;
    find_changes(faces, near != nullptr ? *near : std::vector<engine::RecordRange>{{0, faces.count()}});
    constexpr std::size_t rows_together = 256;
    const FilmTree* const film = faces.mesh.film.get();
    for_each_index(
        box.row_count(), [&](std::size_t row) { sweep(row, rule, film); }, film != nullptr ? 1 : rows_together);
}

void BoxSides::find_changes(const engine::CrossedFaces& faces, const std::vector<engine::RecordRange>& ranges) {
    std::size_t count = 0;
    std::vector<std::size_t> begins;  // of the ranges, counted in their faces
    for (const engine::RecordRange& range : ranges) {
        begins.push_back(count);
        count += range.end - range.begin;
    }
    const std::size_t together = std::clamp<std::size_t>(count / 64, 1, usual_faces);
    std::vector<std::vector<Change>> found(chunk_count(count, together));
    for_each_chunk(count, together, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        found[chunk].reserve(end - begin);
        auto number = static_cast<std::size_t>(std::ranges::upper_bound(begins, begin) - begins.begin() - 1);
        for (std::size_t at = begin; at < end; ++at) {
            while (at - begins[number] >= ranges[number].end - ranges[number].begin) ++number;
            add_changes(faces, ranges[number].begin + (at - begins[number]), found[chunk]);
        }
    });
    if (has_film_) add_changes_of_edges(faces, found.emplace_back());
    sort_changes(found);
}

void BoxSides::add_changes(const engine::CrossedFaces& faces, std::size_t face, std::vector<Change>& changes) const {
    const int count = faces.mesh.sign_count(face);
    if (count == 0) return;
    const crossing::Corners corners = faces.sign_corners(face);
    Box box = {corners[0], corners[0]};
    for (const Vec3& corner : corners) add(box, {corner, corner});
    const std::int32_t samples = box_.size[0];
    if (box.lower[0] > box_.at[0].back() || box.upper[1] < box_.at[1].front() || box.lower[1] > box_.at[1].back() ||
        box.upper[2] < box_.at[2].front() || box.lower[2] > box_.at[2].back())
        return;
    const std::int32_t begin_y = box_.first_not_below(1, box.lower[1]), end_y = box_.first_above(1, box.upper[1]);
    if (begin_y >= end_y) return;
    const std::int32_t begin_z = box_.first_not_below(2, box.lower[2]), end_z = box_.first_above(2, box.upper[2]);
    if (begin_z >= end_z) return;
    // The side of points far ahead. A face that is parallel to x is not crossed in any look.
    const auto& [a, b, c] = corners;
    const int ahead = crossing::orientation_in_plane(a[1], a[2], b[1], b[2], c[1], c[2]);
    if (ahead == 0) return;
    const Plane plane(corners);
    const Edges edges(corners);
    const double per_spacing = box_.per_spacing[0];
    for (std::int32_t z = begin_z; z < end_z; ++z)
        for (std::int32_t y = begin_y; y < end_y; ++y) {
            const Vec3 first = box_.position({0, y, z});
            const std::uint8_t looks = edges.looks(first[1], first[2]);
            if (looks == 0) continue;
            const auto is_behind = [&](std::int32_t sample) {
                return plane.side({box_.at[0][static_cast<std::size_t>(sample)], first[1], first[2]}) == ahead;
            };
            const Plane::Place place = plane.place(first[1], first[2]);
            const double steps = (std::clamp(place.x, box.lower[0], box.upper[0]) - box_.at[0][0]) * per_spacing;
            const double guess = std::isfinite(steps) ? std::ceil(steps) : 0;
            auto sample = static_cast<std::int32_t>(std::clamp(guess, 0.0, static_cast<double>(samples)));
            // Beside samples, by more than roundings, the place decides.
            const double off = place.error * per_spacing + 2 * box_.rounding + 0x1p-48 * std::abs(steps);
            bool is_tie = false;
            if (!(guess - steps > off && steps - (guess - 1) > off)) {
                while (sample > 0 && is_behind(sample - 1)) --sample;
                while (sample < samples && !is_behind(sample)) ++sample;
                is_tie = sample > 0 &&
                         plane.side({box_.at[0][static_cast<std::size_t>(sample - 1)], first[1], first[2]}) == 0;
            }
            const auto change = static_cast<std::int8_t>(-count * ahead);
            const auto push = [&](std::int32_t at, unsigned of_looks) {
                if (of_looks != 0 && at < samples)
                    changes.push_back({static_cast<std::uint32_t>(box_.row({0, y, z})), at,
                                       static_cast<std::uint8_t>(of_looks), change});
            };
            push(is_tie ? sample - 1 : sample, is_tie ? looks & forward_looks : looks);
            if (is_tie) push(sample, looks & ~unsigned{forward_looks} & all_looks);
        }
}

void BoxSides::add_changes_of_edges(const engine::CrossedFaces& faces, std::vector<Change>& changes) const {
    const OpenBoundary& boundary = faces.mesh.film->boundary();
    const auto add_of_row = [&](const Vec3& a, const Vec3& b, std::int32_t y, std::int32_t z, double about_x) {
        Vec3 point = box_.position({0, y, z});
        if (!is_on_row(a, b, point[1], point[2])) return;
        const auto is_past = [&](std::int32_t x) {
            point[0] = box_.at[0][static_cast<std::size_t>(x)];
            return is_beyond(a, b, point);
        };
        std::int32_t sample = box_.first_not_below(0, about_x);
        while (sample > 0 && is_past(sample - 1)) --sample;
        while (sample < box_.size[0] && !is_past(sample)) ++sample;
        if (sample == box_.size[0]) return;
        visit_looks_of_edge(a, b, point[1], point[2], [&](std::uint32_t looks, std::int32_t change) {
            changes.push_back({static_cast<std::uint32_t>(box_.row({0, y, z})), sample,
                               static_cast<std::uint8_t>(looks), static_cast<std::int8_t>(change)});
        });
    };
    for_each_open_edge(boundary, faces.per_unit, [&](const Vec3& a, const Vec3& b) {
        const auto [low_y, high_y] = std::minmax(a[1], b[1]);
        const auto [low_z, high_z] = std::minmax(a[2], b[2]);
        const std::int32_t begin_y = box_.first_not_below(1, low_y), end_y = box_.first_above(1, high_y),
                           begin_z = box_.first_not_below(2, low_z), end_z = box_.first_above(2, high_z);
        for (std::int32_t z = begin_z; z < end_z; ++z) {
            if (low_z == high_z) {
                for (std::int32_t y = begin_y; y < end_y; ++y) {
                    const double share = (box_.at[1][static_cast<std::size_t>(y)] - a[1]) / (b[1] - a[1]);
                    add_of_row(a, b, y, z, a[0] + share * (b[0] - a[0]));
                }
                continue;
            }
            // The one row that the edge may meet: its y is off by far less than half a spacing.
            const double share = (box_.at[2][static_cast<std::size_t>(z)] - a[2]) / (b[2] - a[2]);
            const double steps = (a[1] + share * (b[1] - a[1]) - box_.at[1][0]) * box_.per_spacing[1];
            if (!(steps > -0.5 && steps < box_.size[1] - 0.5)) continue;
            add_of_row(a, b, static_cast<std::int32_t>(std::lround(steps)), z, a[0] + share * (b[0] - a[0]));
        }
    });
}

void BoxSides::sort_changes(std::vector<std::vector<Change>>& found) {
    std::size_t count = 0;
    for (const auto& changes : found) count += changes.size();
    if (count >= std::numeric_limits<std::uint32_t>::max()) throw engine::too_many("crossings of rows of samples");
    std::vector<Change> all;
    all.reserve(count);
    for (auto& changes : found) {
        all.insert(all.end(), changes.begin(), changes.end());
        changes = {};
    }
    changes_.resize(count);
    row_begins_ = bucket_sort(
        count, box_.row_count(), [&](std::size_t i) { return all[i].row; },
        [&](std::size_t i, std::size_t place) { changes_[place] = all[i]; });
    for_each_index(box_.row_count(), [&](std::size_t row) {
        std::sort(changes_.begin() + row_begins_[row], changes_.begin() + row_begins_[row + 1],
                  [](const Change& a, const Change& b) { return a.sample < b.sample; });
    });
}

void BoxSides::sweep(std::size_t row, SignRule rule, const FilmTree* film) {
    if (film != nullptr) return sweep_with_film(row, rule, *film, 1 / box_.scale);
    std::uint64_t* const words = bits_.data() + (this->row(row) - bits_.data());
    Windings at;
    for (std::uint32_t i = row_begins_[row]; i < row_begins_[row + 1];) {
        const std::int32_t begin = changes_[i].sample;
        for (; i < row_begins_[row + 1] && changes_[i].sample == begin; ++i)
            at.add(changes_[i].looks, changes_[i].change);
        const std::int32_t end = i < row_begins_[row + 1] ? changes_[i].sample : box_.size[0];
        if (at.are_inside(rule)) set_bits(words, begin, end);
    }
}

void BoxSides::sweep_with_film(std::size_t row, SignRule rule, const FilmTree& film, double unit) {
    std::uint64_t* const words = bits_.data() + (this->row(row) - bits_.data());
    const auto y = static_cast<std::int32_t>(row % static_cast<std::size_t>(box_.size[1])),
               z = static_cast<std::int32_t>(row / static_cast<std::size_t>(box_.size[1]));
    const auto callers = [&](double x) {
        const Vec3 p = box_.position({0, y, z});
        return Vec3{x * unit, p[1] * unit, p[2] * unit};
    };
    const auto x_of = [&](std::int32_t sample) { return box_.at[0][static_cast<std::size_t>(sample)]; };
    Windings at;
    // Samples between faces; the part of the open edges is the same within a ball that it hardly changes in.
    const auto set_range = [&](const auto& self, std::int32_t begin, std::int32_t end) -> void {
        if (begin >= end) return;
        int rounded = 0;
        if (end - begin > 1) {
            const double middle = 0.5 * (x_of(begin) + x_of(end - 1));
            const double radius = 0.5 * (x_of(end - 1) - x_of(begin)) * (1 + 1e-9);
            const double change = film.change_within(callers(middle), radius);
            const bool may_be_one = change < 0.5;
            const FilmTree::View view = may_be_one ? film.look(callers(middle), change) : FilmTree::View{};
            if (!may_be_one || !(change < view.to_half)) {
                const std::int32_t half = begin + (end - begin) / 2;
                self(self, begin, half);
                self(self, half, end);
                return;
            }
            rounded = view.rounded;
        } else {
            rounded = film.look(callers(x_of(begin))).rounded;
        }
        Windings all = at;
        all.add(all_looks, rounded);
        if (all.are_inside(rule)) set_bits(words, begin, end);
    };
    std::int32_t begin = 0;
    for (std::uint32_t i = row_begins_[row]; i < row_begins_[row + 1];) {
        const std::int32_t sample = changes_[i].sample;
        set_range(set_range, begin, sample);
        for (; i < row_begins_[row + 1] && changes_[i].sample == sample; ++i)
            at.add(changes_[i].looks, changes_[i].change);
        begin = sample;
    }
    set_range(set_range, begin, box_.size[0]);
}

Windings BoxSides::windings(const Place& p) const {
    Windings at;
    const std::size_t row = box_.row(p);
    for (std::uint32_t i = row_begins_[row]; i < row_begins_[row + 1] && changes_[i].sample <= p[0]; ++i)
        at.add(changes_[i].looks, changes_[i].change);
    return at;
}

SampleSides BoxSides::of_grid() const {
    SampleSides sides;
    for (std::size_t axis = 0; axis < 3; ++axis) sides.size[axis] = box_.size[axis] - 2 * box_.margin[axis];
    const auto [count_x, count_y, count_z] = sides.size;
    const auto samples = static_cast<std::size_t>(count_x * count_y * count_z);
    sides.bits.assign((samples + 7) / 8, 0);
    // Tasks of whole words: eight rows begin at a byte.
    constexpr std::size_t rows = 64;
    for_each_chunk(
        static_cast<std::size_t>(count_y * count_z), rows, [&](std::size_t, std::size_t begin, std::size_t end) {
            std::size_t to = begin * static_cast<std::size_t>(count_x);
            for (std::size_t number = begin; number < end; ++number) {
                const Place first{
                    box_.margin[0],
                    static_cast<std::int32_t>(number % static_cast<std::size_t>(count_y)) + box_.margin[1],
                    static_cast<std::int32_t>(number / static_cast<std::size_t>(count_y)) + box_.margin[2]};
                const std::uint64_t* const words = row(box_.row(first));
                for (std::int64_t x = 0; x < count_x;) {
                    const std::int64_t from = x + first[0];
                    const auto taken = static_cast<unsigned>(
                        std::min<std::int64_t>({8 - static_cast<std::int64_t>(to % 8), 64 - from % 64, count_x - x}));
                    const std::uint64_t bits = words[from / 64] >> (from % 64) & ((std::uint64_t{1} << taken) - 1);
                    sides.bits[to / 8] = static_cast<std::uint8_t>(sides.bits[to / 8] | bits << (to % 8));
                    to += taken;
                    x += taken;
                }
            }
        });
    return sides;
}

}  // namespace clsdf::segments
