#include <clsdf/error.hpp>
#include <clsdf/topology.hpp>

#include <fmt/format.h>

#include <array>
#include <utility>

namespace clsdf {

namespace {

constexpr std::array<std::pair<SignRule, const char*>, 4> names{{{SignRule::automatic, "auto"},
                                                                 {SignRule::nonzero, "nonzero"},
                                                                 {SignRule::parity, "parity"},
                                                                 {SignRule::none, "none"}}};

std::string text_of(const Vec3& point) {
    return fmt::format("({}, {}, {})", point[0], point[1], point[2]);
}

/// "3 open edges: (0, 0, 0) to (1, 0, 0), ... and 1 more".
std::string list_edges(std::size_t count, const char* kind, const std::vector<Topology::Edge>& first) {
    std::string text = fmt::format("{} {} {}", count, kind, count == 1 ? "edge" : "edges");
    const char* separator = ": ";
    for (const Topology::Edge& edge : first) {
        text += fmt::format("{}{} to {}", separator, text_of(edge.from), text_of(edge.to));
        separator = ", ";
    }
    if (count > first.size()) text += fmt::format(" and {} more", count - first.size());
    return text;
}

std::string list_open_edges(const Topology& topology) {
    return list_edges(topology.open_edges, "open", topology.first_open_edges);
}

std::string list_unbalanced_edges(const Topology& topology) {
    return list_edges(topology.unbalanced_edges, "unbalanced", topology.first_unbalanced_edges);
}

std::string inside_out_warning(const Topology& topology) {
    if (!topology.inside_out) return {};
    return "the mesh is inside out (its faces look inwards); the region that it encloses is inside all the same";
}

}  // namespace

const char* name_of(SignRule rule) {
    for (const auto& [known, name] : names)
        if (known == rule) return name;
    return "unknown";
}

ResolvedSignRule resolve_sign_rule(SignRule asked, const Topology& topology) {
    switch (asked) {
        case SignRule::automatic:
            if (topology.balanced) return {SignRule::nonzero, inside_out_warning(topology)};
            if (topology.closed)
                return {
                    SignRule::parity,
                    fmt::format("the mesh is closed, but its faces are not oriented alike, so the sign follows from "
                                "parity; it has {}",
                                list_unbalanced_edges(topology))};
            return {SignRule::none, fmt::format("the mesh is not closed, so the distance has no sign; it has {}",
                                                list_open_edges(topology))};
        case SignRule::nonzero:
            if (!topology.balanced)
                throw Error(ErrorCode::invalid_mesh,
                            fmt::format("the sign rule nonzero needs a mesh whose edges are used equally often in both "
                                        "directions, but this one has {}; {}",
                                        list_unbalanced_edges(topology),
                                        topology.closed ? "the rule parity would do" : "only the rule none would do"));
            return {SignRule::nonzero, inside_out_warning(topology)};
        case SignRule::parity:
            if (!topology.closed)
                throw Error(ErrorCode::invalid_mesh,
                            fmt::format("the sign rule parity needs a closed mesh, but this one has {}; only the rule "
                                        "none would do",
                                        list_open_edges(topology)));
            return {SignRule::parity, inside_out_warning(topology)};
        case SignRule::none:
            break;
    }
    return {SignRule::none, {}};
}

}  // namespace clsdf
