#pragma once

#include <clsdf/export.hpp>
#include <clsdf/mesh.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace clsdf {

/// The rule that decides which points are inside; inside is negative. The values of the enumerators never change.
enum class SignRule : std::int32_t {
    automatic = 0,    ///< balanced: nonzero; closed: parity; open: solid_angle if few points are in doubt; else
                      ///< unsigned (with a warning unless it is nonzero)
    nonzero = 1,      ///< inside if the winding number is not zero; needs a balanced mesh
    parity = 2,       ///< inside if a ray crosses the surface an odd number of times; needs a closed mesh
    none = 3,         ///< no sign: the distance alone
    solid_angle = 4,  ///< inside if the winding number is one half or more, or minus one half or less; any mesh
    below = 5,        ///< of a terrain: inside below it and above TransformOptions::floor, between vertical walls from
                      ///< its rim; needs faces that all look up, and a rim that does not overlap, seen from above
};

/// "auto", "nonzero", "parity", "none", "solid-angle", "below".
CLSDF_EXPORT const char* name_of(SignRule rule);

/// The properties of a mesh that the sign rule depends on. Vertices of equal coordinates count as one. Faces with
/// repeated vertices are left out; faces of zero area count.
///
/// If the mesh itself is not balanced, another surface decides the sign (docs/sign.md): vertices that differ by
/// rounding are joined, doubled faces count once, faces that look the wrong way are turned around. What is said of
/// closed and balanced meshes and of edges is true of that surface.
struct Topology {
    struct Edge {
        Vec3 from;
        Vec3 to;

        friend bool operator==(const Edge&, const Edge&) = default;
    };

    bool closed = false;      ///< every undirected edge has an even number of faces
    bool balanced = false;    ///< every edge is used equally often in both directions
    bool inside_out = false;  ///< balanced, and the enclosed volume is negative; or not balanced, and the winding
                              ///< number is negative at most of inside_points

    std::size_t open_edges = 0;             ///< undirected edges with an odd number of faces
    std::size_t unbalanced_edges = 0;       ///< undirected edges not used equally often in both directions
    std::size_t non_manifold_edges = 0;     ///< undirected edges with more than two faces, of the mesh itself
    std::size_t repeated_vertex_faces = 0;  ///< faces with fewer than three different vertices
    std::size_t coincident_vertices = 0;    ///< vertices in use that equal an earlier one
    std::size_t unused_vertices = 0;
    std::vector<Edge> first_open_edges;        ///< up to five, in the order of the triangles
    std::vector<Edge> first_unbalanced_edges;  ///< up to five

    std::size_t boundary_edges = 0;    ///< undirected edges with one face: some of the open ones
    std::size_t joined_vertices = 0;   ///< vertices in use that differ from another one by rounding and count as it
    std::size_t duplicate_faces = 0;   ///< with the vertices of an earlier face; 0 if every edge has two faces
    std::size_t uncounted_faces = 0;   ///< of doubled faces those that do not count for the sign
    std::size_t reoriented_faces = 0;  ///< faces that look the wrong way and are turned around for the sign
    std::size_t inner_wall_faces = 0;  ///< faces between regions; without them the mesh would be closed
    std::size_t first_inner_wall_face = 0;  ///< the lowest of them
    std::size_t parts = 0;                  ///< of a balanced mesh: those that share no vertex; else 0
    std::size_t inward_parts = 0;           ///< parts that look inwards and are not wholly within others
    std::size_t first_inward_face = 0;      ///< the lowest face of the first of them
    std::size_t nested_parts = 0;           ///< parts that lie within others, look the same way and are filled
    std::size_t first_nested_face = 0;      ///< the lowest face of the first of them

    /// The winding number is looked at if the mesh is not closed and the rule may become solid_angle: at so many fixed
    /// points beside its faces and in the boxes of its parts.
    std::size_t tested_points = 0;
    std::size_t doubtful_points = 0;  ///< of them those at which it is more than 0.1 from an integer
    std::size_t inside_points = 0;    ///< of them those at which it is one half or more, or minus one half or less

    std::size_t unclear_parts = 0;  ///< parts that share no vertex and where the winding number is in doubt at more
                                    ///< than a tenth of the tested points or of those inside, or at none inside
    std::size_t first_unclear_face = 0;         ///< the lowest face of the first of them
    std::size_t double_sided_faces = 0;         ///< faces of bodies that are there on both sides; each counts once
    std::size_t doubled_cavity_faces = 0;       ///< faces of cavities that are there twice, so the cavities are filled
    std::size_t first_doubled_cavity_face = 0;  ///< the lowest of them
    std::size_t sheet_faces = 0;       ///< faces of sheets and inner walls beside closed bodies, left out for the sign
    std::size_t first_sheet_face = 0;  ///< the lowest of them
    std::size_t enclosing_faces = 0;   ///< faces of open sheets that are not left out, because they enclose something
    std::size_t first_enclosing_face = 0;    ///< the lowest of them
    std::size_t overlapping_parts = 0;       ///< parts of a balanced mesh that are partly within others, by up to 128
                                             ///< points of each: the distance is that to all faces, also within others
    std::size_t first_overlapping_face = 0;  ///< the lowest face of the first of them

    /// The rule `below` needs a mesh that is not closed, whose faces look up. They are looked at for it and
    /// `automatic`.
    std::size_t downward_faces = 0;       ///< faces that look down, to smaller z; those of vertical walls do not
    std::size_t first_downward_face = 0;  ///< the lowest of them
    std::size_t rim_loops = 0;  ///< of such a mesh without downward_faces: loops of open edges, holes included; 0 also
                                ///< if no face looks up
    std::size_t overlapping_rim_edges = 0;  ///< of these loops the edges that cross others, seen from above, or on
                                            ///< whose left side the mesh lies more than once
    std::vector<Edge> first_overlapping_rim_edges;  ///< up to five

    std::size_t detail_parts = 0;  ///< small open parts that are attached to the others and count as details of them;
                                   ///< 0 if the mesh has its sign without that
    std::size_t detail_faces = 0;  ///< their faces
    std::size_t first_detail_face = 0;  ///< the lowest of them

    /// Set for a transform with TransformOptions::surface outer; else 0.
    std::size_t partial_faces = 0;  ///< faces of which parts are on the outer surface
    std::size_t hidden_faces = 0;   ///< faces that are not on it at all

    friend bool operator==(const Topology&, const Topology&) = default;
};

/// Throws Error(unsupported) for 2^30 triangles or more.
CLSDF_EXPORT Topology describe_topology(const Mesh& mesh);

/// The rule in use, and a warning about it, which may be empty.
struct ResolvedSignRule {
    SignRule rule = SignRule::none;  ///< never `automatic`
    std::string warning;
};

/// Throws Error(invalid_mesh) with the number of offending edges and the first of them if the mesh does not meet the
/// rule.
CLSDF_EXPORT ResolvedSignRule resolve_sign_rule(SignRule asked, const Topology& topology);

/// A terrain, closed by vertical walls from its rim down to z = `floor`, and by a floor there: the mesh whose inside
/// the sign rule `below` takes. The vertices and triangles of `mesh` come first, with their numbers; then follow two
/// triangles for each edge of the rim, and one on the floor below each triangle. The result has no groups. Throws
/// Error(invalid_mesh) if the mesh does not meet the rule `below`; Error(invalid_argument) for a floor that is not
/// finite or not below the lowest vertex.
CLSDF_EXPORT Mesh close_down(const Mesh& mesh, double floor);

}  // namespace clsdf
