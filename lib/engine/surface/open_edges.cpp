#include "surface/open_edges.hpp"

#include "surface/edge_counts.hpp"
#include "surface/loop_turns.hpp"

#include <algorithm>
#include <utility>

namespace clsdf {

namespace {

/// Walks along edges and cuts off each loop that the path closes.
class LoopWalk {
public:
    explicit LoopWalk(std::vector<OpenEdge> edges) : edges_(std::move(edges)) {
        std::ranges::sort(edges_, {}, [](const OpenEdge& edge) { return std::pair(edge.from, edge.to); });
        for (const OpenEdge& edge : edges_) {
            if (vertices_.empty() || vertices_.back() != edge.from) {
                vertices_.push_back(edge.from);
                next_.push_back(static_cast<std::size_t>(&edge - edges_.data()));
            }
        }
        place_on_path_.assign(vertices_.size(), none);
    }

    OpenLoops loops() {
        for (std::size_t start = 0; start < vertices_.size(); ++start)
            while (has_edge(start)) walk(start);
        return std::move(loops_);
    }

private:
    static constexpr std::size_t none = ~std::size_t{0};

    bool has_edge(std::size_t vertex) {
        std::size_t& edge = next_[vertex];
        while (edge < edges_.size() && edges_[edge].from == vertices_[vertex] && edges_[edge].count == 0) ++edge;
        return edge < edges_.size() && edges_[edge].from == vertices_[vertex];
    }

    std::size_t place_of(std::uint32_t vertex) const {
        return static_cast<std::size_t>(std::ranges::lower_bound(vertices_, vertex) - vertices_.begin());
    }

    /// Until the path is back at its start, with nothing left of it.
    void walk(std::size_t start) {
        std::vector<std::size_t> path{start};
        place_on_path_[start] = 0;
        // As many edges end at a vertex as begin there: the walk ends at its start only.
        while (has_edge(path.back())) {
            OpenEdge& edge = edges_[next_[path.back()]];
            --edge.count;
            const std::size_t to = place_of(edge.to);
            if (place_on_path_[to] == none) {
                place_on_path_[to] = path.size();
                path.push_back(to);
                continue;
            }
            const std::size_t begin = place_on_path_[to];
            for (std::size_t i = begin; i < path.size(); ++i) {
                loops_.vertices.push_back(vertices_[path[i]]);
                if (i > begin) place_on_path_[path[i]] = none;
            }
            loops_.begins.push_back(loops_.vertices.size());
            path.resize(begin + 1);
            if (begin == 0) break;
        }
        place_on_path_[start] = none;
    }

    std::vector<OpenEdge> edges_;
    std::vector<std::uint32_t> vertices_;     // at which edges begin, ascending
    std::vector<std::size_t> next_;           // of each of them, the first of its edges that may be left
    std::vector<std::size_t> place_on_path_;  // of each of them
    OpenLoops loops_;
};

}  // namespace

OpenLoops loops_of(std::vector<OpenEdge> edges) {
    return LoopWalk(std::move(edges)).loops();
}

OpenLoops loops_of(const EdgeCounts& edges) {
    std::vector<OpenEdge> open;
    open.reserve(edges.unbalanced.size());
    for (const UnbalancedEdge& edge : edges.unbalanced) {
        if (edge.net > 0)
            open.push_back({edge.lower, edge.higher, static_cast<std::uint32_t>(edge.net)});
        else
            open.push_back({edge.higher, edge.lower, static_cast<std::uint32_t>(-edge.net)});
    }
    return loops_of(std::move(open));
}

OpenBoundary::OpenBoundary(const OpenLoops& loops, std::span<const Vec3> positions)
    : corners(loops.vertices.size()), begins(loops.begins), floor(loops.floor) {
    for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = positions[loops.vertices[i]];
}

SolidAngle angle_of(const OpenBoundary& boundary, const Vec3& point, double unit) {
    Turns turns = no_turns();
    for (std::size_t loop = 0; loop + 1 < boundary.begins.size(); ++loop) {
        const std::size_t begin = boundary.begins[loop];
        turns = turned_by_loop(
            turns, boundary.begins[loop + 1] - begin,
            [&](std::size_t i) -> const Vec3& { return boundary.corners[begin + i]; }, point, unit);
    }
    return {rounded_turns(turns), turns_of(turns)};
}

}  // namespace clsdf
