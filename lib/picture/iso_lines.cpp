#include "picture/iso_lines.hpp"

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace clsdf::picture {
namespace {

// The number of a lattice edge: twice its lower left sample, plus one if it leads upwards.
using Edge = std::int64_t;
using Links = std::array<Edge, 2>;  // the edges that the line goes on to, one in each square beside this edge
constexpr Edge none = -1;

class Tracer {
public:
    Tracer(const Plane& plane, double level) : plane_(plane), level_(level) {
        for (std::int64_t row = 0; row + 1 < plane.size[1]; ++row)
            for (std::int64_t column = 0; column + 1 < plane.size[0]; ++column) cross_square(column, row);
    }

    std::vector<Polyline> lines() {
        std::vector<Polyline> result;
        // First the open lines, from an end; the remaining lines are closed. The order is that of the squares, not of
        // the map.
        for (const Edge edge : order_)
            if (!drawn(edge) && links_.at(edge)[1] == none) result.push_back(follow(edge));
        for (const Edge edge : order_)
            if (!drawn(edge)) {
                Polyline closed = follow(edge);
                closed.push_back(closed.front());
                result.push_back(std::move(closed));
            }
        return result;
    }

private:
    void cross_square(std::int64_t column, std::int64_t row) {
        const std::array corners{plane_.sample(column, row), plane_.sample(column + 1, row),
                                 plane_.sample(column + 1, row + 1), plane_.sample(column, row + 1)};
        unsigned above = 0;
        for (std::size_t corner = 0; corner < 4; ++corner) {
            if (!std::isfinite(corners[corner])) return;
            above |= static_cast<unsigned>(corners[corner] >= level_) << corner;
        }
        const Edge sample = row * plane_.size[0] + column;
        const Edge bottom = 2 * sample;
        const Edge right = 2 * (sample + 1) + 1;
        const Edge top = 2 * (sample + plane_.size[0]);
        const Edge left = 2 * sample + 1;
        switch (above < 8 ? above : 15 - above) {
            case 1:
                return join(left, bottom);
            case 2:
                return join(bottom, right);
            case 3:
                return join(left, right);
            case 4:
                return join(right, top);
            case 6:
                return join(bottom, top);
            case 7:
                return join(left, top);
            case 5: {
                // If the saddle of the bilinear interpolant is above the level, it joins the two corners above.
                const double saddle = (corners[0] * corners[2] - corners[1] * corners[3]) /
                                      (corners[0] + corners[2] - corners[1] - corners[3]);
                const bool first_joined = (saddle >= level_) == (above == 5);
                join(left, first_joined ? top : bottom);
                join(first_joined ? bottom : top, right);
                return;
            }
            default:
                return;
        }
    }

    void join(Edge one, Edge other) {
        link(one, other);
        link(other, one);
    }

    void link(Edge from, Edge to) {
        const auto [entry, fresh] = links_.try_emplace(from, Links{to, none});
        if (fresh)
            order_.push_back(from);
        else
            entry->second[1] = to;
    }

    bool drawn(Edge edge) const { return links_.at(edge)[0] == none; }

    // Takes the line out of the links, edge by edge.
    Polyline follow(Edge edge) {
        Polyline line;
        Edge before = none;
        while (edge != none) {
            line.push_back(point_on(edge));
            Links& links = links_.at(edge);
            const Edge next = links[0] == before ? links[1] : links[0];
            links = {none, none};
            before = edge;
            edge = next != none && !drawn(next) ? next : none;
        }
        return line;
    }

    PlanePoint point_on(Edge edge) const {
        const std::int64_t column = edge / 2 % plane_.size[0];
        const std::int64_t row = edge / 2 / plane_.size[0];
        const bool upwards = edge % 2 == 1;
        const double from = plane_.sample(column, row);
        const double to = upwards ? plane_.sample(column, row + 1) : plane_.sample(column + 1, row);
        const double part = (level_ - from) / (to - from);
        return {static_cast<double>(column) + (upwards ? 0 : part), static_cast<double>(row) + (upwards ? part : 0)};
    }

    const Plane& plane_;
    double level_;
    std::unordered_map<Edge, Links> links_;
    std::vector<Edge> order_;
};

}  // namespace

std::vector<Polyline> iso_lines(const Plane& plane, double level) {
    return Tracer(plane, level).lines();
}

}  // namespace clsdf::picture
