#include <clsdf/error.hpp>
#include <clsdf/topology.hpp>

#include "surface/open_edges.hpp"
#include "surface/terrain.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace clsdf {

namespace {

constexpr std::array<std::pair<SignRule, const char*>, 6> names{{{SignRule::automatic, "auto"},
                                                                 {SignRule::nonzero, "nonzero"},
                                                                 {SignRule::parity, "parity"},
                                                                 {SignRule::none, "none"},
                                                                 {SignRule::solid_angle, "solid-angle"},
                                                                 {SignRule::below, "below"}}};

std::string text_of(const Vec3& point) {
    return fmt::format("({}, {}, {})", point[0], point[1], point[2]);
}

/// "1 face", "3 faces".
std::string counted(std::size_t count, const char* thing) {
    return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

/// ": (0, 0, 0) to (1, 0, 0), ... and 1 more".
std::string list_edges(std::size_t count, const std::vector<Topology::Edge>& first) {
    std::string text;
    const char* separator = ": ";
    for (const Topology::Edge& edge : first) {
        text += fmt::format("{}{} to {}", separator, text_of(edge.from), text_of(edge.to));
        separator = ", ";
    }
    if (count > first.size()) text += fmt::format(" and {} more", count - first.size());
    return text;
}

std::string doubled_faces(const Topology& topology) {
    const std::size_t count = topology.duplicate_faces;
    return count == 1 ? "1 face is there twice" : fmt::format("{} faces are there twice or more often", count);
}

/// "it has 3 open edges: ..."; never open if nothing is.
std::string list_open_edges(const Topology& topology) {
    const std::size_t open = topology.open_edges, boundary = topology.boundary_edges;
    const std::string edges = list_edges(open, topology.first_open_edges);
    const std::string remedy = boundary > 0 ? "; if they are seams, --weld LENGTH (weld()) joins near vertices" : "";
    if (open == boundary)
        return fmt::format("it has {} open {}{}{}", open, open == 1 ? "edge" : "edges", edges, remedy);
    std::string text = fmt::format("{} {} an odd number of faces", counted(open, "edge"), open == 1 ? "has" : "have");
    if (boundary > 0) text += fmt::format(" ({} of them one face)", boundary);
    text += edges + remedy;
    if (topology.duplicate_faces > 0) text += "; " + doubled_faces(topology);
    return text;
}

/// Empty if there is none.
std::string inner_wall(const Topology& topology) {
    if (topology.inner_wall_faces == 0) return {};
    return fmt::format(
        "{} an inner wall: leave out triangle {} and those joined to it over edges of two faces",
        topology.inner_wall_faces == 1 ? "1 face is" : fmt::format("{} faces are", topology.inner_wall_faces),
        topology.first_inner_wall_face);
}

std::string list_unbalanced_edges(const Topology& topology) {
    const std::size_t count = topology.unbalanced_edges;
    return fmt::format("{} unbalanced {}{}", count, count == 1 ? "edge" : "edges",
                       list_edges(count, topology.first_unbalanced_edges));
}

/// Sentences that a semicolon parts. The command prints those that two lines hold, so remedies come first.
class Sentences {
public:
    void add(const std::string& sentence) { text_ += (text_.empty() || sentence.empty() ? "" : "; ") + sentence; }
    std::string text() const { return text_; }

private:
    std::string text_;
};

/// The difference of the surface that decides the sign from the mesh; empty if there is none.
std::string difference_of(const Topology& topology) {
    std::string text;
    const auto add = [&](std::size_t count, const std::string& what) {
        if (count > 0) text += (text.empty() ? "for the sign, " : ", ") + what;
    };
    const std::size_t joined = topology.joined_vertices, turned = topology.reoriented_faces;
    add(joined, fmt::format("{} from another one by rounding and {} as it",
                            joined == 1 ? "1 vertex differs" : fmt::format("{} vertices differ", joined),
                            joined == 1 ? "counts" : "count"));
    const std::size_t double_sided = topology.double_sided_faces, uncounted = topology.uncounted_faces;
    add(double_sided, fmt::format("{} faces of bodies that are there on both sides, so that nothing would be inside, "
                                  "count once",
                                  double_sided));
    add(uncounted > double_sided ? uncounted : 0,
        uncounted == 1 ? "1 face is there twice and counts once"
                       : fmt::format("{} faces repeat others or cancel them and do not count", uncounted));
    // If the mesh is inside out, neither these faces nor the others look outwards as they should.
    add(turned,
        fmt::format("{} {} and {} turned around", turned == 1 ? "1 face looks" : fmt::format("{} faces look", turned),
                    topology.inside_out ? "another way than their neighbours" : "the wrong way",
                    turned == 1 ? "is" : "are"));
    const std::size_t sheets = topology.sheet_faces, walls = topology.inner_wall_faces;
    add(sheets, fmt::format("{} of {} {} left out ({}triangle {})", counted(sheets, "face"),
                            walls == 0        ? "sheets that enclose nothing"
                            : walls == sheets ? "inner walls"
                                              : "sheets that enclose nothing and of inner walls",
                            sheets == 1 ? "is" : "are", sheets == 1 ? "" : "the first is ", topology.first_sheet_face));
    if (sheets > walls) text += "; if one bounds a chamber, that has a hole and is outside: close it";
    return text;
}

std::string warning_of_parts(const Topology& topology) {
    Sentences sentences;
    if (topology.inward_parts > 0)
        sentences.add(fmt::format(
            "{} of {} parts {} inwards and {} not wholly within others, so an overlap with another part, if there "
            "is one, is outside: turn the faces of {} around ({} triangle {})",
            topology.inward_parts, topology.parts, topology.inward_parts == 1 ? "looks" : "look",
            topology.inward_parts == 1 ? "is" : "are", topology.inward_parts == 1 ? "this part" : "these parts",
            topology.inward_parts == 1 ? "that of" : "the first is that of", topology.first_inward_face));
    if (topology.overlapping_parts > 0)
        sentences.add(fmt::format(
            "{} of {} parts {} partly within others, and the distance is that to all faces, also to those within: "
            "clsdf outer (outer()) makes the mesh of the outer surface, if that is wanted (the first is that of "
            "triangle {})",
            topology.overlapping_parts, topology.parts, topology.overlapping_parts == 1 ? "is" : "are",
            topology.first_overlapping_face));
    if (topology.nested_parts > 0)
        sentences.add(fmt::format(
            "{} of {} parts {} within others and {} the same way, so {} no cavity (that of triangle {}{}): the sign "
            "rule parity makes cavities of such parts, and so do faces that look inwards",
            topology.nested_parts, topology.parts, topology.nested_parts == 1 ? "lies" : "lie",
            topology.nested_parts == 1 ? "looks" : "look", topology.nested_parts == 1 ? "it is" : "they are",
            topology.first_nested_face, topology.nested_parts == 1 ? "" : " is the first"));
    return sentences.text();
}

/// "at 3% of 512 points of the mesh's box".
std::string share_in_doubt(const Topology& topology) {
    const double percent =
        100 * static_cast<double>(topology.doubtful_points) / static_cast<double>(topology.tested_points);
    return fmt::format("at {:.3g}% of {} points beside its faces and in the boxes of its parts", percent,
                       topology.tested_points);
}

/// "it has 3 open edges".
std::string count_holes(const Topology& topology) {
    const std::size_t count = topology.unbalanced_edges;
    const char* const edges = count == 1 ? "edge" : "edges";
    if (topology.boundary_edges == count) return fmt::format("it has {} open {}", count, edges);
    return fmt::format("it has {} unbalanced {}, {} of them with one face", count, edges, topology.boundary_edges);
}

/// Of the rule solid_angle for a mesh that is not balanced.
std::string warning_of_holes(const Topology& topology) {
    if (topology.tested_points == 0) return {};
    if (topology.inside_points == 0)
        return fmt::format(
            "none of {} points beside its faces and in the boxes of its parts is inside, so perhaps nothing is; the "
            "sign rule none gives the distance alone",
            topology.tested_points);
    Sentences sentences;
    const std::string kind = topology.closed ? "the mesh is not balanced" : "the mesh is not closed";
    const char* const effect = "so the sign follows from the winding number";
    if (topology.detail_parts > 0) {
        // First, so that the command's two lines have them.
        const bool is_one = topology.detail_parts == 1;
        sentences.add(fmt::format("{}, {}", kind, effect));
        sentences.add(fmt::format("{} {} of the body: close {}, or the sign rule none gives the distance alone",
                                  counted(topology.detail_parts, "small open part"),
                                  is_one ? "is a detail" : "are details", is_one ? "it" : "them"));
        sentences.add(fmt::format("{} ({} triangle {}), closed by films",
                                  is_one ? fmt::format("the detail has {}", counted(topology.detail_faces, "face"))
                                         : fmt::format("the details have {} faces", topology.detail_faces),
                                  topology.detail_faces == 1 ? "it is" : "the first is", topology.first_detail_face));
        sentences.add(count_holes(topology));
    } else {
        sentences.add(fmt::format("{}, {}, {}", kind, count_holes(topology), effect));
        sentences.add("the sign rule none gives the distance alone");
    }
    sentences.add(
        fmt::format("inside is where the magnitude of the winding number is one half or more; {} it is in doubt",
                    share_in_doubt(topology)));
    return sentences.text();
}

/// Whether it is in doubt at more than a third of the points.
bool is_much_in_doubt(const Topology& topology) {
    return 3 * topology.doubtful_points > topology.tested_points;
}

/// Why `automatic` does not take it.
std::string refusal_of_winding_number(const Topology& topology) {
    if (topology.tested_points == 0) return {};
    const std::string tested =
        topology.inside_points == 0
            ? fmt::format("none of {} points beside its faces and in the boxes of its parts is inside",
                          topology.tested_points)
            : fmt::format("{} its winding number is in doubt", share_in_doubt(topology));
    Sentences sentences;
    if (is_terrain(topology)) {
        sentences.add(
            "close the surface, for example by walls and a floor (the sign rule below with a floor Z does so for the "
            "sign "
            "alone); the sign rule none gives the distance alone");
        sentences.add(tested);
    } else if (topology.inside_points == 0 || is_much_in_doubt(topology)) {
        sentences.add(
            "close the surface, for example by walls and a floor, or give each body as a mesh of its own; the sign "
            "rule "
            "none gives the distance alone");
        sentences.add(tested);
    } else {
        sentences.add("the sign rule solid-angle takes it all the same");
        sentences.add(fmt::format("{} ({}), and 10% is the limit for each part and for the points inside", tested,
                                  topology.unclear_parts > 1
                                      ? fmt::format("{} parts, the first is that of triangle {}",
                                                    topology.unclear_parts, topology.first_unclear_face)
                                      : fmt::format("the part of triangle {}", topology.first_unclear_face)));
    }
    if (topology.enclosing_faces > 0)
        sentences.add(fmt::format(
            "the open sheets beside closed bodies enclose something, so they are not left out (the first is "
            "that of triangle {})",
            topology.first_enclosing_face));
    return sentences.text();
}

std::string warning_of_no_sign(const Topology& topology) {
    Sentences sentences;
    sentences.add("the mesh is not closed, so the distance has no sign");
    sentences.add(inner_wall(topology));
    sentences.add(refusal_of_winding_number(topology));
    sentences.add(list_open_edges(topology));
    return sentences.text();
}

/// The warnings about a mesh that has a sign.
std::string warning_of(const Topology& topology, SignRule rule) {
    Sentences sentences;
    if (topology.doubled_cavity_faces > 0)
        sentences.add(fmt::format(
            "{} of cavities {} there twice, so the cavities are filled: leave one of each out (the first is triangle "
            "{})",
            counted(topology.doubled_cavity_faces, "face"), topology.doubled_cavity_faces == 1 ? "is" : "are",
            topology.first_doubled_cavity_face));
    if (topology.balanced && topology.tested_points > 0 && topology.inside_points == 0)
        sentences.add(
            fmt::format("none of {} points beside its faces is inside, so perhaps nothing is: {}, and faces that look "
                        "both ways cancel "
                        "each other; leave one of each out",
                        topology.tested_points, doubled_faces(topology)));
    if (rule == SignRule::nonzero) sentences.add(warning_of_parts(topology));
    if (topology.inside_out)
        sentences.add(fmt::format(
            "the mesh is inside out ({}its faces look inwards); the region that it encloses is inside all the same",
            topology.reoriented_faces > 0 ? "turned to look alike, " : ""));
    sentences.add(difference_of(topology));
    return sentences.text();
}

/// Throws unless the rule `below` suits the mesh.
void require_terrain(const Topology& topology) {
    const auto refuse = [](const std::string& text) {
        throw Error(ErrorCode::invalid_mesh, "the sign rule below needs a terrain, " + text);
    };
    if (topology.closed && topology.sheet_faces == 0) refuse("but this mesh is closed; the rule auto would do");
    if (topology.downward_faces > 0)
        refuse(
            fmt::format("whose faces look up, but {} of this mesh {} down (the first is triangle {}); turn them "
                        "around, or cut off what hangs over",
                        counted(topology.downward_faces, "face"), topology.downward_faces == 1 ? "looks" : "look",
                        topology.first_downward_face));
    if (topology.rim_loops == 0) refuse("but no face of this mesh looks up");
    if (topology.overlapping_rim_edges > 0)
        refuse(fmt::format(
            "whose rim does not overlap itself, seen from above, but {} of this mesh's rim {}{}; join "
            "cracks (--weld LENGTH, weld()), or give each layer as a mesh of its own",
            counted(topology.overlapping_rim_edges, "edge"), topology.overlapping_rim_edges == 1 ? "does" : "do",
            list_edges(topology.overlapping_rim_edges, topology.first_overlapping_rim_edges)));
}

/// Of a topology that describe_topology() describes for the rule `automatic`, which alone leaves sheets out.
void refuse_sheets(SignRule asked, const Topology& topology) {
    if (topology.sheet_faces > 0)
        throw Error(
            ErrorCode::invalid_mesh,
            fmt::format("the sign rule {} needs a closed mesh, but this one has {} of sheets or inner walls (the "
                        "first is triangle {}), which the rule auto alone leaves out; the rules auto, "
                        "solid-angle and none would do",
                        name_of(asked), counted(topology.sheet_faces, "face"), topology.first_sheet_face));
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
            if (topology.balanced) return {SignRule::nonzero, warning_of(topology, SignRule::nonzero)};
            if (topology.closed) {
                Sentences sentences;
                sentences.add(fmt::format(
                    "the mesh is closed, but its faces are not oriented alike, so the sign "
                    "follows from parity, and regions within an even number of shells are outside; it has {}",
                    list_unbalanced_edges(topology)));
                sentences.add(warning_of(topology, SignRule::parity));
                return {SignRule::parity, sentences.text()};
            }
            if (topology.tested_points > 0 && topology.unclear_parts == 0) {
                Sentences sentences;
                sentences.add(warning_of_holes(topology));
                sentences.add(warning_of(topology, SignRule::solid_angle));
                return {SignRule::solid_angle, sentences.text()};
            }
            return {SignRule::none, warning_of_no_sign(topology)};
        case SignRule::nonzero:
            refuse_sheets(asked, topology);
            if (!topology.balanced)
                throw Error(ErrorCode::invalid_mesh,
                            fmt::format("the sign rule nonzero needs a mesh whose edges are used equally often in both "
                                        "directions, but this one has {}; {}",
                                        list_unbalanced_edges(topology),
                                        topology.closed ? "the rules parity and solid-angle would do"
                                                        : "the rules solid-angle and none would do"));
            return {SignRule::nonzero, warning_of(topology, SignRule::nonzero)};
        case SignRule::parity:
            refuse_sheets(asked, topology);
            if (!topology.closed) {
                Sentences sentences;
                sentences.add("the sign rule parity needs a closed mesh");
                sentences.add(list_open_edges(topology));
                sentences.add(inner_wall(topology));
                sentences.add("the rules solid-angle and none would do");
                throw Error(ErrorCode::invalid_mesh, sentences.text());
            }
            return {SignRule::parity, warning_of(topology, SignRule::parity)};
        case SignRule::solid_angle: {
            Sentences sentences;
            if (!topology.balanced) sentences.add(warning_of_holes(topology));
            sentences.add(warning_of(topology, topology.balanced ? SignRule::nonzero : SignRule::solid_angle));
            return {SignRule::solid_angle, sentences.text()};
        }
        case SignRule::below:
            require_terrain(topology);
            return {SignRule::below, warning_of(topology, SignRule::below)};
        case SignRule::none:
            break;
    }
    return {SignRule::none, {}};
}

}  // namespace clsdf
