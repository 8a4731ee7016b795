#include "papers/convex_polyhedron.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace clsdf::papers {

namespace {

constexpr std::uint32_t none = UINT32_MAX;
constexpr double rounding = 0x1p-44;  // 256 ulp; a vertex between two others is no farther off a plane than they are

ConvexPolyhedron box_polyhedron(const Box& box) {
    ConvexPolyhedron result;
    for (std::size_t i = 0; i < 3; ++i)
        if (!(box.upper[i] > box.lower[i])) return result;
    for (std::uint32_t i = 0; i < 8; ++i) {
        result.vertices.emplace_back((i & 1U) ? box.upper[0] : box.lower[0], (i & 2U) ? box.upper[1] : box.lower[1],
                                     (i & 4U) ? box.upper[2] : box.lower[2]);
    }
    result.corners = {0, 4, 6, 2, 1, 3, 7, 5, 0, 1, 5, 4, 2, 6, 7, 3, 0, 2, 3, 1, 4, 5, 7, 6};
    for (std::uint32_t first = 0; first < result.corners.size(); first += 4)
        result.faces.push_back({ConvexPolyhedron::start_box, first, 4});
    return result;
}

/// Cuts by one plane after the other. Which vertices are cut off is decided by their distances, but so that both they
/// and the others are connected by edges: whatever rounding does, the cut is then one cycle and the result a sphere
/// (Sugihara & Iri, A robust topology-oriented incremental algorithm for Voronoi diagrams).
class Clipper {
public:
    explicit Clipper(const Box& start) : solid_(box_polyhedron(start)) {
        for (const Vector& vertex : solid_.vertices) size_ = std::max(size_, vertex.cwiseAbs().maxCoeff());
    }

    void cut(const HalfSpace& half_space, std::size_t index) {
        if (solid_.is_empty()) return;
        tolerance_ = rounding * half_space.normal.norm() * size_;
        heights_.clear();
        for (const Vector& vertex : solid_.vertices)
            heights_.push_back(half_space.normal.dot(vertex) - half_space.offset);
        const auto [lowest, highest] = std::minmax_element(heights_.begin(), heights_.end());
        if (!(*highest > tolerance_)) return;
        if (!(*lowest < -tolerance_)) {
            solid_ = {};
            return;
        }
        choose_sides(static_cast<std::uint32_t>(lowest - heights_.begin()),
                     static_cast<std::uint32_t>(highest - heights_.begin()));
        while (!cut_faces()) connect_the_kept(static_cast<std::uint32_t>(lowest - heights_.begin()));
        add_cap(index);
        drop_unused_vertices();
    }

    ConvexPolyhedron take() { return std::move(solid_); }

private:
    struct Crossing {
        std::uint32_t kept;
        std::uint32_t removed;
        std::uint32_t vertex;
    };

    void choose_sides(std::uint32_t lowest, std::uint32_t highest) {
        is_removed_.assign(heights_.size(), false);
        for (std::size_t i = 0; i < heights_.size(); ++i) is_removed_[i] = heights_[i] > tolerance_;
        find_components();
        for (std::uint32_t i = 0; i < heights_.size(); ++i)
            is_removed_[i] = is_removed_[i] && component(i) == component(highest);
        connect_the_kept(lowest);
    }

    void connect_the_kept(std::uint32_t lowest) {
        find_components();
        for (std::uint32_t i = 0; i < heights_.size(); ++i) is_removed_[i] = component(i) != component(lowest);
    }

    /// Finds the components of the graph of edges whose ends are on one side.
    void find_components() {
        parents_.resize(heights_.size());
        std::iota(parents_.begin(), parents_.end(), 0U);
        for (const ConvexPolyhedron::Face& face : solid_.faces) {
            std::uint32_t from = solid_.polygon(face).back();
            for (const std::uint32_t to : solid_.polygon(face)) {
                if (is_removed_[from] == is_removed_[to]) parents_[component(from)] = component(to);
                from = to;
            }
        }
    }

    std::uint32_t component(std::uint32_t vertex) {
        while (parents_[vertex] != vertex) vertex = parents_[vertex] = parents_[parents_[vertex]];
        return vertex;
    }

    /// Builds the faces that are left and the cycle of the cap. False, with one more vertex removed, if the cycle
    /// would pass through that one twice.
    bool cut_faces() {
        solid_.vertices.resize(heights_.size());
        crossings_.clear();
        faces_.clear();
        corners_.clear();
        after_.assign(heights_.size(), none);
        for (const ConvexPolyhedron::Face& face : solid_.faces) {
            const auto first = static_cast<std::uint32_t>(corners_.size());
            std::uint32_t leaves = none;
            std::uint32_t returns = none;
            std::uint32_t from = solid_.polygon(face).back();
            for (const std::uint32_t to : solid_.polygon(face)) {
                if (!is_removed_[from] && is_removed_[to]) append(first, leaves = crossing(from, to));
                if (is_removed_[from] && !is_removed_[to]) append(first, returns = crossing(to, from));
                if (!is_removed_[to]) append(first, to);
                from = to;
            }
            if (leaves != returns) {
                if (after_[returns] != none) {
                    is_removed_[returns] = true;
                    return false;
                }
                after_[returns] = leaves;
            }
            close_polygon(face.half_space, first);
        }
        return true;
    }

    void append(std::uint32_t first, std::uint32_t vertex) {
        if (corners_.size() == first || corners_.back() != vertex) corners_.push_back(vertex);
    }

    /// Two vertices are an edge, of which the neighbours' polygons have both directions.
    void close_polygon(std::size_t half_space, std::uint32_t first) {
        if (corners_.size() > first + 1 && corners_.back() == corners_[first]) corners_.pop_back();
        const auto size = static_cast<std::uint32_t>(corners_.size()) - first;
        if (size < 3)
            corners_.resize(first);
        else
            faces_.push_back({half_space, first, size});
    }

    /// The vertex in which an edge meets the plane: the kept one if that lies in it.
    std::uint32_t crossing(std::uint32_t kept, std::uint32_t removed) {
        const double low = heights_[kept];
        const double high = heights_[removed];
        if (!(low < -tolerance_)) return kept;
        const auto known = std::find_if(crossings_.begin(), crossings_.end(), [&](const Crossing& crossing) {
            return crossing.kept == kept && crossing.removed == removed;
        });
        if (known != crossings_.end()) return known->vertex;
        const double part = std::clamp(low / (low - high), 0.0, 1.0);
        const auto vertex = static_cast<std::uint32_t>(solid_.vertices.size());
        solid_.vertices.emplace_back((1 - part) * solid_.vertices[kept] + part * solid_.vertices[removed]);
        after_.push_back(none);
        crossings_.push_back({kept, removed, vertex});
        return vertex;
    }

    void add_cap(std::size_t half_space) {
        const auto start = std::find_if(after_.begin(), after_.end(), [](std::uint32_t next) { return next != none; });
        if (start != after_.end()) {
            const auto first = static_cast<std::uint32_t>(corners_.size());
            const auto begin = static_cast<std::uint32_t>(start - after_.begin());
            std::uint32_t vertex = begin;
            do {
                corners_.push_back(vertex);
                vertex = after_[vertex];
            } while (vertex != begin);
            close_polygon(half_space, first);
        }
        solid_.faces.swap(faces_);
        solid_.corners.swap(corners_);
    }

    void drop_unused_vertices() {
        after_.assign(solid_.vertices.size(), none);
        for (const std::uint32_t vertex : solid_.corners) after_[vertex] = 0;
        std::uint32_t count = 0;
        for (std::size_t i = 0; i < after_.size(); ++i) {
            if (after_[i] == none) continue;
            solid_.vertices[count] = solid_.vertices[i];
            after_[i] = count++;
        }
        solid_.vertices.resize(count);
        for (std::uint32_t& vertex : solid_.corners) vertex = after_[vertex];
    }

    ConvexPolyhedron solid_;
    double size_ = 0;
    // For the current plane:
    double tolerance_ = 0;
    std::vector<double> heights_;  // of the vertices before the cut; further vertices are crossings
    std::vector<bool> is_removed_;
    std::vector<std::uint32_t> parents_;
    std::vector<Crossing> crossings_;
    std::vector<std::uint32_t> after_;  // the next vertex of the cap
    std::vector<ConvexPolyhedron::Face> faces_;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

double ConvexPolyhedron::volume() const {
    double sum = 0;
    for (const Face& face : faces) {
        const std::span<const std::uint32_t> ring = polygon(face);
        const Vector apex = vertices[ring[0]] - vertices[0];
        for (std::size_t i = 2; i < ring.size(); ++i)
            sum += apex.dot((vertices[ring[i - 1]] - vertices[0]).cross(vertices[ring[i]] - vertices[0]));
    }
    return sum / 6;
}

ConvexPolyhedron clip(const Box& start, std::span<const HalfSpace> half_spaces) {
    Clipper clipper(start);
    for (std::size_t i = 0; i < half_spaces.size(); ++i) clipper.cut(half_spaces[i], i);
    return clipper.take();
}

}  // namespace clsdf::papers
