#include "polyhedra/one_rings.hpp"

#include "core/parallel.hpp"
#include "polyhedra/mesh_topology.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace clsdf::polyhedra {

std::size_t checked_face_count(std::size_t count) {
    if (count > most_faces)
        throw Error(
            ErrorCode::unsupported,
            fmt::format("{} triangles are more than the {} that can be prepared; split the mesh", count, most_faces));
    return count;
}

/// Each part of the faces has vertices of its own, a range of their numbers, and files the corners there, so that no
/// two parts write to one ring. Corners that its faces have at other parts' vertices it sets aside for those.
class OneRings::Filing {
public:
    /// Where a part begins: its first face and its first vertex.
    struct Border {
        std::size_t face, vertex;
    };

    /// The last border is the end of both.
    Filing(std::span<const Triangle> triangles, std::vector<Border> borders, OneRings& rings)
        : triangles_(triangles), borders_(std::move(borders)), rings_(rings), parts_(borders_.size() - 1) {}

    void run() {
        rings_.start_[0] = 0;
        for_each_part([&](std::size_t part) { count(part); });
        for_each_part([&](std::size_t part) { count_set_aside(part); });
        std::uint32_t corners = 0;
        for (Part& part : parts_) {
            part.first_corner = corners;
            corners += part.corner_count;
        }
        for_each_part([&](std::size_t part) { file(part); });
    }

private:
    /// A corner at a vertex of another part.
    struct SetAside {
        std::uint32_t vertex;
        std::uint32_t corner;

        friend bool operator<(const SetAside& a, const SetAside& b) {
            return a.vertex != b.vertex ? a.vertex < b.vertex : a.corner < b.corner;
        }
    };

    struct Part {
        std::vector<SetAside> set_aside;
        std::uint32_t corner_count = 0;  ///< at its vertices
        std::uint32_t first_corner = 0;  ///< the place of the first of them
    };

    template <typename Function>
    void for_each_part(const Function& f) {
        for_each_stretch(parts_.size(), 1, [&](std::size_t part, std::size_t, std::size_t) { f(part); });
    }

    /// Calls own(vertex, corner) for corners of the part's faces at its own vertices, other(vertex, corner) elsewhere.
    template <typename Own, typename Other>
    void for_each_corner(std::size_t part, const Own& own, const Other& other) const {
        const auto first = static_cast<std::uint32_t>(borders_[part].vertex);
        const auto count = static_cast<std::uint32_t>(borders_[part + 1].vertex) - first;
        for (std::size_t face = borders_[part].face; face < borders_[part + 1].face; ++face)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t vertex = triangles_[face][k];
                const std::uint32_t corner = Corner{static_cast<std::uint32_t>(face), k}.packed();
                if (vertex - first < count) {
                    own(vertex, corner);
                } else {
                    other(vertex, corner);
                }
            }
    }

    /// What one part has set aside for another, by vertex and face.
    std::span<const SetAside> set_aside(std::size_t from, std::size_t part) const {
        const std::vector<SetAside>& all = parts_[from].set_aside;
        const auto place = [&](std::size_t vertex) {
            return std::lower_bound(all.begin(), all.end(), vertex,
                                    [](const SetAside& a, std::size_t v) { return a.vertex < v; });
        };
        return {place(borders_[part].vertex), place(borders_[part + 1].vertex)};
    }

    void count(std::size_t part) {
        std::uint32_t* const start = rings_.start_.data();
        // Counted one place further on, so that filing turns each ring's start into the next one's.
        std::fill(start + borders_[part].vertex + 1, start + borders_[part + 1].vertex + 1, 0U);
        std::vector<SetAside> aside;
        for_each_corner(
            part, [&](std::uint32_t vertex, std::uint32_t) { ++start[vertex + 1]; },
            [&](std::uint32_t vertex, std::uint32_t corner) {
                aside.push_back({vertex, corner});
            });
        std::sort(aside.begin(), aside.end());
        const std::size_t faces = borders_[part + 1].face - borders_[part].face;
        parts_[part].corner_count = static_cast<std::uint32_t>(3 * faces - aside.size());
        parts_[part].set_aside = std::move(aside);
    }

    void count_set_aside(std::size_t part) {
        for (std::size_t from = 0; from < parts_.size(); ++from)
            for (const SetAside& aside : set_aside(from, part)) {
                ++rings_.start_[aside.vertex + 1];
                ++parts_[part].corner_count;
            }
    }

    void file(std::size_t part) {
        std::uint32_t* const start = rings_.start_.data();
        std::uint32_t* const corners = rings_.corners_.data();
        std::uint32_t next = parts_[part].first_corner;
        for (std::size_t vertex = borders_[part].vertex; vertex < borders_[part + 1].vertex; ++vertex)
            next += std::exchange(start[vertex + 1], next);
        const auto take = [&](std::uint32_t vertex, std::uint32_t corner) { corners[start[vertex + 1]++] = corner; };
        const auto take_from = [&](std::size_t from) {
            for (const SetAside& aside : set_aside(from, part)) take(aside.vertex, aside.corner);
        };
        for (std::size_t from = 0; from < part; ++from) take_from(from);
        for_each_corner(part, take, [](std::uint32_t, std::uint32_t) {});
        for (std::size_t from = part + 1; from < parts_.size(); ++from) take_from(from);
    }

    std::span<const Triangle> triangles_;
    std::vector<Border> borders_;
    OneRings& rings_;
    std::vector<Part> parts_;
};

OneRings::OneRings(std::span<const Triangle> triangles, std::size_t vertex_count)
    : start_(vertex_count + 1), corners_(3 * checked_face_count(triangles.size())) {
    const std::size_t size = stretch_for_all_cores(triangles.size(), OrderedFaces::stretch);
    const std::size_t parts = std::max<std::size_t>(1, stretch_count(triangles.size(), size));
    std::vector<Filing::Border> borders;
    for (std::size_t part = 0; part <= parts; ++part)
        borders.push_back({std::min(triangles.size(), part * size), vertex_count * part / parts});
    Filing(triangles, std::move(borders), *this).run();
}

OneRings::OneRings(const OrderedFaces& faces)
    : start_(faces.vertices.size() + 1), corners_(3 * faces.triangles.size()) {
    const std::size_t count = faces.triangles.size();
    const std::size_t size = stretch_for_all_cores(count, OrderedFaces::stretch);
    std::vector<Filing::Border> borders;
    for (std::size_t face = 0; face < count; face += size)
        borders.push_back({face, faces.first_vertices[face / OrderedFaces::stretch]});
    borders.push_back({count, faces.vertices.size()});
    Filing(faces.triangles, std::move(borders), *this).run();
}

}  // namespace clsdf::polyhedra
