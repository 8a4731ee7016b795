// The counters of Topology: one table for stored values, C and Python. A new one is a member of Topology, which says
// what it counts, a row here, at the end, and a member of clsdf_topology.
#ifndef CLSDF_TOPOLOGY_TABLE_H
#define CLSDF_TOPOLOGY_TABLE_H

// ROW(member, what it is). Their order is that of stored meshes, and never changes.
#define CLSDF_TOPOLOGY_COUNTS(ROW)                                                                                    \
    ROW(open_edges, "Number of edges with an odd number of faces.")                                                   \
    ROW(unbalanced_edges, "Number of edges that are not used equally often.")                                         \
    ROW(non_manifold_edges, "Number of edges with more than two faces.")                                              \
    ROW(repeated_vertex_faces, "Faces with fewer than three vertices.")                                               \
    ROW(coincident_vertices, "Vertices in use that equal an earlier one.")                                            \
    ROW(unused_vertices, "Vertices of no face.")                                                                      \
    ROW(boundary_edges, "Undirected edges with one face: some of the open ones.")                                     \
    ROW(joined_vertices, "Vertices in use that differ from another one by rounding and count as it.")                 \
    ROW(duplicate_faces, "Faces with the vertices of an earlier one; 0 if every edge has two faces.")                 \
    ROW(uncounted_faces, "Of doubled faces those that do not count for the sign.")                                    \
    ROW(reoriented_faces, "Faces that look the wrong way and are turned around for the sign.")                        \
    ROW(inner_wall_faces, "Faces between regions; without them the mesh would be closed.")                            \
    ROW(first_inner_wall_face, "The lowest of them.")                                                                 \
    ROW(parts, "Parts of a balanced mesh that share no vertex; else 0.")                                              \
    ROW(inward_parts, "Parts that look inwards and are not wholly within others.")                                    \
    ROW(first_inward_face, "The lowest face of the first of them.")                                                   \
    ROW(nested_parts, "Parts that lie within others, look the same way and are filled.")                              \
    ROW(first_nested_face, "The lowest face of the first of them.")                                                   \
    ROW(tested_points,                                                                                                \
        "Points beside the faces of a mesh that is not closed and in the boxes of its parts, at which the "           \
        "winding\nnumber is looked at; else 0.")                                                                      \
    ROW(doubtful_points, "Of them those at which it is more than 0.1 from an integer.")                               \
    ROW(inside_points, "Of them those at which it is one half or more, or minus one half or less.")                   \
    ROW(unclear_parts, "Parts in which it is in doubt at more than a tenth of them, or at none inside.")              \
    ROW(first_unclear_face, "The lowest face of the first of them.")                                                  \
    ROW(double_sided_faces, "Faces of bodies that are there on both sides; each counts once.")                        \
    ROW(doubled_cavity_faces, "Faces of cavities that are there twice, so the cavities are filled.")                  \
    ROW(first_doubled_cavity_face, "The lowest of them.")                                                             \
    ROW(sheet_faces, "Faces of sheets and inner walls beside closed bodies, left out for the sign.")                  \
    ROW(first_sheet_face, "The lowest of them.")                                                                      \
    ROW(enclosing_faces, "Faces of open sheets that are not left out, because they enclose something.")               \
    ROW(first_enclosing_face, "The lowest of them.")                                                                  \
    ROW(overlapping_parts, "Parts of a balanced mesh that are partly within others.")                                 \
    ROW(first_overlapping_face, "The lowest face of the first of them.")                                              \
    ROW(downward_faces, "Faces that look down, to smaller z: the rule 'below' takes none.")                           \
    ROW(first_downward_face, "The lowest of them.")                                                                   \
    ROW(rim_loops, "Of a mesh that is not closed and has no downward_faces: loops of open edges.")                    \
    ROW(overlapping_rim_edges,                                                                                        \
        "Edges of these loops that cross others, seen from above, or at which the mesh lies twice.")                  \
    ROW(detail_parts,                                                                                                 \
        "Small open parts that are attached to the others and count as details of them; 0 if the mesh has "           \
        "its\nsign without that.")                                                                                    \
    ROW(detail_faces, "Their faces.")                                                                                 \
    ROW(first_detail_face, "The lowest of them.")                                                                     \
    ROW(partial_faces, "Of a transform with surface='outer', else 0: faces of which parts are on the outer surface.") \
    ROW(hidden_faces, "Faces that are not on it at all.")

#endif
