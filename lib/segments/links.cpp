#include "segments/links.hpp"

#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "core/parallel_sort.hpp"
#include "core/refuse.hpp"
#include "segments/link_places.hpp"
#include "segments/link_raster.hpp"
#include "segments/link_table.hpp"
#include "segments/link_walls.hpp"
#include "segments/sample_sides.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <utility>

namespace clsdf::segments {

namespace {

constexpr std::size_t most_directions = 32;
constexpr std::int32_t longest_component = 16;
/// Faces that one task looks at: few if there are few, which may be large.
constexpr std::size_t usual_faces = 256;

Place sum(const Place& a, const Place& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

/// A face that a link may cross; `link` is a number in the table, or a sample and a direction.
struct Record {
    std::uint64_t link;
    std::uint32_t face;

    bool operator<(const Record& other) const { return link != other.link ? link < other.link : face < other.face; }
};

using Records = UninitializedVector<Record>;

/// Finds the links of one grid.
class Finder {
public:
    Finder(const LinkInputs& inputs, const Grid& grid, std::span<const LinkDirection> directions,
           const LinkChoice& choice)
        : inputs_(inputs),
          choice_(choice),
          faces_(inputs.faces),
          box_(grid, margin_of(directions), faces_.per_unit),
          sides_(faces_, inputs.rule, box_),
          steps_(directions.begin(), directions.end()) {
        report(0.2);
        if (choice.hits == Hits::walls) table_ = std::make_unique<LinkTable>(box_, sides_, steps_);
    }

    std::size_t count() {
        const std::size_t count = table_ ? table_->size() : 0;
        if (has_no_extras()) return count;
        search();
        return count + solve_extras().size();
    }

    Links find() {
        search();
        Links links;
        const std::vector<Extra> extras = solve_extras();
        const std::size_t count = table_ ? table_->size() : 0, all = count + extras.size();
        constexpr std::size_t bytes_each = 12 + 1 + 8 + 4 + 4 + 1;
        const std::string lacking = fmt::format(
            "for {} links, which take {} bytes; ask for those of a part of the grid", all, all * bytes_each);
        with_host_memory(lacking.c_str(), [&] {
            links.samples.resize(all);
            links.directions.resize(all);
            links.q.resize(all);
            links.triangles.resize(all);
            links.counts.resize(all);
            links.flags.resize(all);
        });
        report(0.7);
        if (count > 0) {
            table_->for_each([&](std::size_t number, const Place& sample, std::size_t direction) {
                links.samples[number] = on_lattice(sample);
                links.directions[number] = static_cast<std::uint8_t>(direction);
            });
            solve_table(links, count);
        }
        if (!extras.empty()) merge(links, count, extras);
        report(0.95);
        links.inside = sides_.of_grid();
        return links;
    }

private:
    static constexpr std::uint32_t no_face = 0xffffffff;

    /// A link that is not in the table.
    struct Extra {
        std::uint64_t link;
        Met met;
        SegmentFlag flag;
    };

    void report(double fraction) const {
        if (inputs_.between) inputs_.between(fraction);
    }
    bool has_no_extras() const { return choice_.hits == Hits::walls && !choice_.with_between && !choice_.with_gaps; }

    std::array<std::int32_t, 3> on_lattice(const Place& sample) const {
        std::array<std::int32_t, 3> number{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            number[axis] = static_cast<std::int32_t>(box_.grid.first[axis] + sample[axis]);
        return number;
    }
    Place in_box(const std::array<std::int32_t, 3>& number) const {
        Place sample{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            sample[axis] = static_cast<std::int32_t>(number[axis] - box_.grid.first[axis]);
        return sample;
    }

    // Links beside the table, in the order of the rows.
    std::uint64_t key_of(const Place& sample, std::size_t direction) const {
        const std::uint64_t row = box_.row(sample);
        return (row * static_cast<std::uint64_t>(box_.size[0]) + static_cast<std::uint64_t>(sample[0])) *
                   most_directions +
               direction;
    }
    std::pair<Place, std::size_t> link_of(std::uint64_t key) const {
        const std::uint64_t sample = key / most_directions;
        const auto size_x = static_cast<std::uint64_t>(box_.size[0]), size_y = static_cast<std::uint64_t>(box_.size[1]);
        return {Place{static_cast<std::int32_t>(sample % size_x), static_cast<std::int32_t>(sample / size_x % size_y),
                      static_cast<std::int32_t>(sample / size_x / size_y)},
                static_cast<std::size_t>(key % most_directions)};
    }

    void search();
    Met solve(const Place& sample, std::size_t direction, LinkWalls& walls,
              std::span<const std::uint32_t> faces) const {
        const Place other = sum(sample, steps_[direction]);
        return choice_.hits == Hits::faces ? walls.faces(sample, other, faces) : walls.walls(sample, other, faces);
    }
    std::vector<Extra> solve_extras();
    void solve_table(Links& links, std::size_t count);
    void merge(Links& links, std::size_t count, const std::vector<Extra>& extras) const;

    const LinkInputs& inputs_;
    const LinkChoice choice_;
    const engine::CrossedFaces& faces_;
    SampleBox box_;
    BoxSides sides_;
    std::vector<Place> steps_;
    std::unique_ptr<LinkTable> table_;  ///< null: all links are extras

    UninitializedVector<std::uint32_t> first_faces_;  ///< by number in the table; no_face: none
    Records further_;                                 ///< of links in the table that have more than one
    Records extras_;
};

/// The records of all threads, sorted.
template <typename PerThread>
Records sorted_records(PerThread& found) {
    Records records;
    std::size_t count = 0;
    for (const auto& own : found) count += own.size();
    records.reserve(count);
    for (auto& own : found) records.insert(records.end(), own.begin(), own.end());
    sort_on_all_cores(records);
    return records;
}

void Finder::search() {
    const PairedDirections directions = paired(steps_);
    const std::vector<Place>& steps = directions.steps;
    const std::vector<DirectionPair>& pairs = directions.pairs;
    if (table_) {
        first_faces_.resize(table_->size());
        for_each_range(
            first_faces_.size(),
            [&](std::size_t begin, std::size_t end) {
                std::fill(first_faces_.begin() + static_cast<std::ptrdiff_t>(begin),
                          first_faces_.begin() + static_cast<std::ptrdiff_t>(end), no_face);
            },
            std::size_t{1} << 16);
    }
    const bool as_given = choice_.hits == Hits::faces;
    const LinkRaster raster(box_, steps);
    using Own = std::vector<Record>;
    tbb::enumerable_thread_specific<Own> further, extras;
    const std::size_t together = std::clamp<std::size_t>(faces_.count() / 64, 1, usual_faces);
    for_each_range(
        faces_.count(),
        [&](std::size_t begin, std::size_t end) {
            Own &own_further = further.local(), &own_extras = extras.local();
            for (std::size_t face = begin; face < end; ++face) {
                if (as_given ? faces_.triangle(face) == no_triangle : faces_.mesh.sign_count(face) == 0) continue;
                const crossing::Corners corners = as_given ? faces_.corners(face) : faces_.sign_corners(face);
                raster.visit_links(corners, [&](const Place& from, std::size_t number, bool is_sure) {
                    const Place to = sum(from, steps[number]);
                    if (!box_.is_in_box(to)) return;
                    const bool from_inside = sides_.is_inside(from), to_inside = sides_.is_inside(to);
                    const bool in_table = table_ && from_inside != to_inside;
                    if (!in_table && !as_given && !(from_inside ? choice_.with_gaps : choice_.with_between)) return;
                    const std::size_t forward =
                                          box_.is_in_grid(from) ? pairs[number].forward : DirectionPair::not_asked,
                                      backward =
                                          box_.is_in_grid(to) ? pairs[number].backward : DirectionPair::not_asked;
                    if (forward == DirectionPair::not_asked && backward == DirectionPair::not_asked) return;
                    if (in_table && (from_inside ? backward : forward) == DirectionPair::not_asked) return;
                    if (!is_sure &&
                        crossing::crossing_of(corners, crossing::segment(box_.position(from), box_.position(to)))
                                .looks == 0)
                        return;
                    const auto record = static_cast<std::uint32_t>(face);
                    if (in_table) {
                        const std::size_t link =
                            from_inside ? table_->number(to, backward) : table_->number(from, forward);
                        std::uint32_t none = no_face;
                        if (!std::atomic_ref(first_faces_[link])
                                 .compare_exchange_strong(none, record, std::memory_order_relaxed))
                            own_further.push_back({link, record});
                        return;
                    }
                    if (forward != DirectionPair::not_asked) own_extras.push_back({key_of(from, forward), record});
                    if (backward != DirectionPair::not_asked) own_extras.push_back({key_of(to, backward), record});
                });
            }
        },
        together);
    further_ = sorted_records(further);
    extras_ = sorted_records(extras);
}

std::vector<Finder::Extra> Finder::solve_extras() {
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < extras_.size(); ++i)
        if (i == 0 || extras_[i].link != extras_[i - 1].link) begins.push_back(i);
    begins.push_back(extras_.size());
    std::vector<Extra> all(begins.size() - 1);
    for_each_range(
        all.size(),
        [&](std::size_t begin, std::size_t end) {
            LinkWalls walls(inputs_, faces_, box_, sides_);
            std::vector<std::uint32_t> faces;
            for (std::size_t n = begin; n < end; ++n) {
                faces.clear();
                for (std::size_t i = begins[n]; i < begins[n + 1]; ++i) faces.push_back(extras_[i].face);
                Extra& extra = all[n];
                extra.link = extras_[begins[n]].link;
                const auto [sample, direction] = link_of(extra.link);
                extra.met = solve(sample, direction, walls, faces);
                const bool is_inside = sides_.is_inside(sample);
                const bool are_equal = is_inside == sides_.is_inside(sum(sample, steps_[direction]));
                extra.flag = choice_.hits == Hits::faces ? (are_equal ? SegmentFlag::sheet : SegmentFlag::none)
                             : is_inside                 ? gap_flag
                                                         : SegmentFlag::between;
            }
        },
        64);
    std::erase_if(all, [](const Extra& extra) { return extra.met.count == 0; });
    return all;
}

void Finder::solve_table(Links& links, std::size_t count) {
    const bool has_film = faces_.mesh.film != nullptr;
    for_each_range(
        count,
        [&](std::size_t begin, std::size_t end) {
            LinkWalls walls(inputs_, faces_, box_, sides_);
            std::vector<std::uint32_t> faces;
            LinkPlaces places;
            std::array<std::size_t, LinkPlaces::most> numbers{};
            std::size_t waiting = 0;
            const auto compute = [&] {
                places.compute();
                for (std::size_t i = 0; i < waiting; ++i) links.q[numbers[i]] = places.places.of[i];
                waiting = 0;
            };
            auto next = std::lower_bound(further_.begin(), further_.end(), Record{begin, 0});
            for (std::size_t n = begin; n < end; ++n) {
                const Place sample = in_box(links.samples[n]);
                const std::size_t direction = links.directions[n];
                const std::uint32_t face = first_faces_[n];
                const bool has_more = next != further_.end() && next->link == n;
                if (!has_film && !has_more && face != no_face) {
                    // One face is crossed, so it is the wall.
                    places.set(waiting, faces_.sign_corners(face), box_.position(sample),
                               box_.position(sum(sample, steps_[direction])));
                    numbers[waiting] = n;
                    if (++waiting == LinkPlaces::most) compute();
                    links.triangles[n] = faces_.triangle(face);
                    links.counts[n] = 1;
                    links.flags[n] = Met{.triangle = links.triangles[n]}.flag();
                    continue;
                }
                faces.clear();
                if (face != no_face) faces.push_back(face);
                for (; next != further_.end() && next->link == n; ++next) faces.push_back(next->face);
                const Met met = solve(sample, direction, walls, faces);
                if (met.count % 2 == 0) refuse_link(links.samples[n], direction);
                links.q[n] = met.q;
                links.triangles[n] = met.triangle;
                links.counts[n] = met.count;
                links.flags[n] = met.flag();
            }
            if (waiting > 0) compute();
        },
        512);
}

void Finder::merge(Links& links, std::size_t count, const std::vector<Extra>& extras) const {
    // From behind, in place: the rows of the table lie at the begin.
    std::size_t table = count, extra = extras.size();
    for (std::size_t to = count + extras.size(); extra > 0;) {
        --to;
        const bool is_extra = table == 0 || key_of(in_box(links.samples[table - 1]), links.directions[table - 1]) <
                                                extras[extra - 1].link;
        if (is_extra) {
            const auto& [link, met, flag] = extras[--extra];
            const auto [sample, direction] = link_of(link);
            links.samples[to] = on_lattice(sample);
            links.directions[to] = static_cast<std::uint8_t>(direction);
            links.q[to] = met.q;
            links.triangles[to] = met.triangle;
            links.counts[to] = met.count;
            links.flags[to] = static_cast<SegmentFlag>(static_cast<unsigned>(flag) | static_cast<unsigned>(met.flag()));
            continue;
        }
        --table;
        links.samples[to] = links.samples[table];
        links.directions[to] = links.directions[table];
        links.q[to] = links.q[table];
        links.triangles[to] = links.triangles[table];
        links.counts[to] = links.counts[table];
        links.flags[to] = links.flags[table];
    }
}

}  // namespace

void refuse_link(const std::array<std::int32_t, 3>& sample, std::size_t direction) {
    throw Error(ErrorCode::wrong_results,
                fmt::format("the link from sample ({}, {}, {}) in direction {} joins outside and inside and meets no "
                            "wall; this is a fault of clsdf: please report it with the mesh and the grid",
                            sample[0], sample[1], sample[2], direction));
}

void check_directions(std::span<const LinkDirection> directions) {
    if (directions.empty() || directions.size() > most_directions)
        refuse("links have {} directions; give 1 to {} in a call", directions.size(), most_directions);
    for (std::size_t n = 0; n < directions.size(); ++n) {
        const auto& [x, y, z] = directions[n];
        for (const std::int32_t component : directions[n])
            if (component < -longest_component || component > longest_component)
                refuse("direction {}, ({}, {}, {}), has a component beyond {}; give shorter ones", n, x, y, z,
                       longest_component);
        for (std::size_t m = 0; m < n; ++m)
            if (directions[m] == directions[n])
                refuse("directions {} and {} are both ({}, {}, {}); give each once", m, n, x, y, z);
    }
}

Place margin_of(std::span<const LinkDirection> directions) {
    Place margin{};
    for (const LinkDirection& direction : directions)
        for (std::size_t axis = 0; axis < 3; ++axis) margin[axis] = std::max(margin[axis], std::abs(direction[axis]));
    return margin;
}

Links find_links(const LinkInputs& inputs, const Grid& grid, std::span<const LinkDirection> directions,
                 const LinkChoice& choice) {
    return Finder(inputs, grid, directions, choice).find();
}

std::size_t count_links(const LinkInputs& inputs, const Grid& grid, std::span<const LinkDirection> directions,
                        const LinkChoice& choice) {
    return Finder(inputs, grid, directions, choice).count();
}

}  // namespace clsdf::segments
