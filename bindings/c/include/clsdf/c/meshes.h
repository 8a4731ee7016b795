#ifndef CLSDF_C_MESHES_H
#define CLSDF_C_MESHES_H

/*
 * Meshes: arrays, files, topology, welding, groups, outer surfaces.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "arrays.h"
#include "calls.h"
#include "grids.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Meshes ---- */

/* A mesh in the caller's arrays, on the host or in buffers of the device's context. Each call that takes one copies
 * what it keeps. */
typedef struct clsdf_mesh_arrays {
    size_t struct_size;
    clsdf_array vertices;  /* three float32 or float64 an item */
    clsdf_array triangles; /* three indices an item, int32, int64, uint32 or uint64, counter-clockwise from outside */
    int32_t index_base;    /* 0 or 1: what indices of vertices count from, and triangles of outputs. With 1, `triangles`
                              lie on the host, and a copy of them is made for the call */
    int32_t reserved;
    const char* name; /* of the mesh that clsdf_mesh_create() makes, in messages and files; null: "mesh" */
} clsdf_mesh_arrays;
#define CLSDF_MESH_ARRAYS_INIT \
    { sizeof(clsdf_mesh_arrays), CLSDF_ARRAY_INIT, CLSDF_ARRAY_INIT, 0, 0, NULL }

typedef struct clsdf_edge {
    double from[3];
    double to[3];
} clsdf_edge;

/* The facts that decide the sign rule. Vertices of equal coordinates count as one. If the mesh itself is not balanced,
 * another surface decides the sign, with joined vertices, doubled faces that count once and faces turned around: what
 * is said of closed and balanced meshes and of edges is true of that surface. */
typedef struct clsdf_topology {
    size_t struct_size;
    int32_t closed;     /* 1: every undirected edge has an even number of faces */
    int32_t balanced;   /* 1: every edge is used equally often in both directions */
    int32_t inside_out; /* 1: balanced, and the enclosed volume is negative; or not, and the winding number is */
    int32_t reserved;
    int64_t open_edges;            /* undirected edges with an odd number of faces */
    int64_t unbalanced_edges;      /* undirected edges not used equally often in both directions */
    int64_t non_manifold_edges;    /* undirected edges with more than two faces, of the mesh itself */
    int64_t repeated_vertex_faces; /* faces with fewer than three different vertices */
    int64_t coincident_vertices;   /* vertices in use that equal an earlier one */
    int64_t unused_vertices;
    int64_t first_open_count;       /* of first_open */
    int64_t first_unbalanced_count; /* of first_unbalanced */
    clsdf_edge first_open[5];       /* in the order of the triangles */
    clsdf_edge first_unbalanced[5];
    int64_t boundary_edges;        /* undirected edges with one face: some of the open ones */
    int64_t joined_vertices;       /* in use, differ from another one by rounding and count as it */
    int64_t duplicate_faces;       /* with the vertices of an earlier face; 0 if every edge has two faces */
    int64_t uncounted_faces;       /* of doubled faces those that do not count for the sign */
    int64_t reoriented_faces;      /* look the wrong way and are turned around for the sign */
    int64_t inner_wall_faces;      /* between regions; without them the mesh would be closed */
    int64_t first_inner_wall_face; /* the lowest of them, counted from 0, as those that follow */
    int64_t parts;                 /* of a balanced mesh: those that share no vertex; else 0 */
    int64_t inward_parts;          /* look inwards and are not wholly within others */
    int64_t first_inward_face;     /* the lowest face of the first of them */
    int64_t nested_parts;          /* lie within others, look the same way and are filled */
    int64_t first_nested_face;     /* the lowest face of the first of them */
    /* These three are 0 unless the mesh is not balanced and the rule may become solid_angle. */
    int64_t tested_points;   /* points beside faces and in the parts' boxes at which the winding number was computed */
    int64_t doubtful_points; /* tested points at which it is more than 0.1 from an integer */
    int64_t inside_points;   /* tested points at which it is at least 1/2, or at most -1/2 */
    int64_t unclear_parts;   /* parts where it is in doubt at more than a tenth of them, or at none inside */
    int64_t first_unclear_face;        /* the lowest face of the first of them */
    int64_t double_sided_faces;        /* of bodies that are there on both sides; each counts once */
    int64_t doubled_cavity_faces;      /* of cavities that are there twice, so the cavities are filled */
    int64_t first_doubled_cavity_face; /* the lowest of them */
    int64_t sheet_faces;               /* of sheets and inner walls beside closed bodies, left out for the sign */
    int64_t first_sheet_face;          /* the lowest of them */
    int64_t enclosing_faces;           /* of open sheets that are not left out, because they enclose something */
    int64_t first_enclosing_face;      /* the lowest of them */
    int64_t overlapping_parts;         /* parts of a balanced mesh that are partly within others */
    int64_t first_overlapping_face;    /* the lowest face of the first of them */
    /* The rule below needs a mesh that is not closed, whose faces look up and whose rim does not overlap. */
    int64_t downward_faces;        /* look down, to smaller z */
    int64_t first_downward_face;   /* the lowest of them */
    int64_t rim_loops;             /* of a mesh that is not closed and has no downward_faces: loops of open edges */
    int64_t overlapping_rim_edges; /* of them that cross others, seen from above, or at which the mesh lies twice */
    /* Small open parts that are attached to the others and count as details of them; 0 if the mesh has its sign without
     * that. */
    int64_t detail_parts;
    int64_t detail_faces;      /* of these parts */
    int64_t first_detail_face; /* the lowest of them */
    /* Set for a transform with CLSDF_SURFACE_OUTER; else 0. */
    int64_t partial_faces; /* faces of which parts are on the outer surface */
    int64_t hidden_faces;  /* faces that are not on it at all */
} clsdf_topology;
#define CLSDF_EDGE_INIT \
    {                   \
        {0, 0, 0}, {    \
            0, 0, 0     \
        }               \
    }
#define CLSDF_FIVE_EDGES_INIT \
    { CLSDF_EDGE_INIT, CLSDF_EDGE_INIT, CLSDF_EDGE_INIT, CLSDF_EDGE_INIT, CLSDF_EDGE_INIT }
#define CLSDF_TOPOLOGY_INIT                                                                                            \
    {                                                                                                                  \
        CLSDF_RESULT_SIZE(clsdf_topology), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, CLSDF_FIVE_EDGES_INIT,                  \
            CLSDF_FIVE_EDGES_INIT, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, \
            0, 0, 0, 0, 0, 0, 0                                                                                        \
    }

/* Defects beside those of edges. The distance is exact in spite of them. */
typedef struct clsdf_defects {
    size_t struct_size;
    int64_t zero_area_faces; /* three different vertices on one line, exactly */
    int64_t duplicate_faces; /* with the vertices of an earlier face, in whatever order */
    int64_t components;      /* parts that share no vertex */
} clsdf_defects;
#define CLSDF_DEFECTS_INIT \
    { CLSDF_RESULT_SIZE(clsdf_defects), 0, 0, 0 }

/* How files of meshes are read. */
typedef struct clsdf_read_options {
    size_t struct_size;
    void* user; /* the first argument of the function */
    /* Warnings, each with the file: what was skipped (faces of one or two corners, bytes after the last row of a binary
     * .ply, unknown lines) or changed (vertices of an .obj with a fourth number are divided by it). May be null. */
    clsdf_log_function log;
    double scale;        /* a position x becomes R (x * scale) + translate; without a rotation R, product and sum are
                            each rounded once; > 0 */
    double translate[3]; /* in the units after the scale */
    /* 1: faces with a coordinate that is not finite, or that name a vertex that does not exist, are left out; log gets
     * their number and the first of them. 0: they are errors. */
    int32_t skip_bad_facets;
    int32_t reserved;
    const char* up;       /* the axis of the file that points up: "x", "y", "z", "-x", "-y" or "-z"; null: "z". The mesh
                             gets z up: of a file with y up, (x, y, z) becomes (x, -z, y) */
    double rotate[3];     /* degrees about the fixed axes x, y and z, one after the other, after `up`; exact for
                             multiples of 90 */
    const char* group_by; /* a property of the faces of .ply files, whose values name the groups; null: none */
} clsdf_read_options;
#define CLSDF_READ_OPTIONS_INIT \
    { sizeof(clsdf_read_options), NULL, NULL, 1, {0, 0, 0}, 0, 0, NULL, {0, 0, 0}, NULL }

/* How a mesh differs from the one that it was welded from, face by face. */
typedef struct clsdf_weld_report {
    size_t struct_size;
    int64_t lost_faces;       /* had three different vertices, and have fewer now, so no area */
    int64_t coinciding_faces; /* have the three vertices of other faces now, and did not before */
    /* A closed mesh has its volume, > 0 if its faces look outwards; an open one that of the cones from the faces to the
     * centre of the box. */
    double volume_before;
    double volume_after;
} clsdf_weld_report;
#define CLSDF_WELD_REPORT_INIT \
    { CLSDF_RESULT_SIZE(clsdf_weld_report), 0, 0, 0, 0 }

/* A checked copy of arrays of the host. CLSDF_INVALID_MESH names the element, the value and the base of its numbers. */
CLSDF_API clsdf_status clsdf_mesh_create(const clsdf_mesh_arrays* arrays, clsdf_mesh** mesh);
/* A mesh made by code: "sphere0" to "sphere9", "torus", "knot", ... */
CLSDF_API clsdf_status clsdf_mesh_shape(const char* name, clsdf_mesh** mesh);
/* Reads .off, .obj, .stl or .ply; polygons become triangles. CLSDF_UNREADABLE_INPUT names the line and the value. */
CLSDF_API clsdf_status clsdf_mesh_read(const char* path, clsdf_mesh** mesh);
/* Reads files as one mesh: the vertices and the triangles of each follow those of the one before it. Each file is a
 * group with the name of the file; a file with several groups has "file/group". `options` may be null. */
CLSDF_API clsdf_status clsdf_mesh_read_files(const char* const* paths, int64_t count, const clsdf_read_options* options,
                                             clsdf_mesh** mesh);
/* The mesh in which vertices of equal coordinates are one, with the same index base. */
CLSDF_API clsdf_status clsdf_mesh_weld(const clsdf_mesh* mesh, clsdf_mesh** welded);
/* The mesh in which vertices are one, too, if they differ by at most `tolerance` on every axis, in the mesh's units, or
 * are connected by others that do; clusters longer than four tolerances are left apart. */
CLSDF_API clsdf_status clsdf_mesh_weld_within(const clsdf_mesh* mesh, double tolerance, clsdf_mesh** welded);
/* A terrain closed by walls from its rim down to z = `floor`, and by a floor there: what CLSDF_SIGN_BELOW takes to be
 * inside. The vertices and triangles of `mesh` come first; no groups. CLSDF_INVALID_MESH if the mesh does not meet that
 * rule, CLSDF_INVALID_ARGUMENT if the floor is not below all vertices. */
CLSDF_API clsdf_status clsdf_mesh_close_down(const clsdf_mesh* mesh, double floor, clsdf_mesh** closed);
/* What clsdf_mesh_weld_within() did to `mesh`: a wall that is thinner than the tolerance is flat. The warning, which
 * may be "", says so, with the remedy. */
CLSDF_API clsdf_status clsdf_mesh_describe_weld(const clsdf_mesh* mesh, const clsdf_mesh* welded,
                                                clsdf_weld_report* report, char* warning, int64_t size,
                                                int64_t* length);
/* Writes by the file's ending, complete or not at all. `colours`: red, green, blue of each triangle, as uint8_t
 * [colour_count][3], or null and 0. Without them a .ply of an outer surface has the property given_face of each
 * triangle. Threads: any number. */
CLSDF_API clsdf_status clsdf_mesh_write(const clsdf_mesh* mesh, const char* path, const uint8_t* colours,
                                        int64_t colour_count);
/* Names and descriptions of shapes, 0 <= index < count; null beyond. They live as long as the process. */
CLSDF_API int64_t clsdf_shape_count(void);
CLSDF_API const char* clsdf_shape_name(int64_t index);
CLSDF_API const char* clsdf_shape_description(int64_t index);

/* New positions of the same vertices, on the host. A mesh of clsdf_mesh_outer() is a mesh like others then. Threads:
 * one. */
CLSDF_API clsdf_status clsdf_mesh_set_positions(clsdf_mesh* mesh, const clsdf_array* positions);
/* Sets the index base that transforms of this mesh have from now on: 0 (as of files and shapes) or 1. Threads: one. */
CLSDF_API clsdf_status clsdf_mesh_set_index_base(clsdf_mesh* mesh, int32_t index_base);
/* The mesh's own memory, as long as the mesh lives: count[3] doubles, and count[3] indices from 0, whatever the index
 * base. clsdf_mesh_set_positions() writes the new positions there. Threads: any number, as in all that follow. */
CLSDF_API clsdf_status clsdf_mesh_vertices(const clsdf_mesh* mesh, const double** vertices, int64_t* count);
CLSDF_API clsdf_status clsdf_mesh_triangles(const clsdf_mesh* mesh, const uint32_t** triangles, int64_t* count);
CLSDF_API clsdf_status clsdf_mesh_index_base(const clsdf_mesh* mesh, int32_t* index_base);
CLSDF_API clsdf_status clsdf_mesh_name(const clsdf_mesh* mesh, const char** name);
/* Groups of triangles: the solids of an ASCII STL file, the groups and objects of an OBJ file, several files, or those
 * that are set. A mesh without groups has 0 names and 0 numbers. Welded meshes have the same groups. All is the mesh's
 * own memory, as long as it lives and until clsdf_mesh_set_groups(). */
CLSDF_API clsdf_status clsdf_mesh_group_count(const clsdf_mesh* mesh, int64_t* count);
/* 0 <= index < count; all names are different. */
CLSDF_API clsdf_status clsdf_mesh_group_name(const clsdf_mesh* mesh, int64_t index, const char** name);
/* The index of its name for each triangle, from 0 whatever the index base. */
CLSDF_API clsdf_status clsdf_mesh_group_numbers(const clsdf_mesh* mesh, const uint32_t** numbers, int64_t* count);
/* Sets copies of names and numbers, a number for each triangle; none of both removes the groups. Threads: one. */
CLSDF_API clsdf_status clsdf_mesh_set_groups(clsdf_mesh* mesh, const char* const* names, int64_t name_count,
                                             const uint32_t* numbers, int64_t count);
/* The box of the vertices in use. */
CLSDF_API clsdf_status clsdf_mesh_box(const clsdf_mesh* mesh, clsdf_box* box);
/* A hash of all vertices and triangles in their order, the same on every machine. It tells whether ranks have the same
 * mesh. The index base and the name do not count. */
CLSDF_API clsdf_status clsdf_mesh_hash(const clsdf_mesh* mesh, uint64_t* hash);
CLSDF_API clsdf_status clsdf_mesh_topology(const clsdf_mesh* mesh, clsdf_topology* topology);
CLSDF_API clsdf_status clsdf_mesh_defects(const clsdf_mesh* mesh, clsdf_defects* defects);
/* The rule that a transform would use, and a warning about it, which may be "". CLSDF_INVALID_MESH if the mesh does not
 * meet the rule. */
CLSDF_API clsdf_status clsdf_mesh_sign(const clsdf_mesh* mesh, int32_t asked, int32_t* rule, char* warning,
                                       int64_t size, int64_t* length);

/* ---- Outer surfaces ---- */

/* An outer surface, beside the faces as given. */
typedef struct clsdf_outer_report {
    size_t struct_size;
    int64_t whole_faces;   /* faces as given that are on the outer surface wholly, */
    int64_t partial_faces; /* in parts, */
    int64_t hidden_faces;  /* and not at all */
    double volume;         /* inside, in cubed units of the mesh */
    double area;           /* of the outer surface, in squared units */
} clsdf_outer_report;
#define CLSDF_OUTER_REPORT_INIT \
    { CLSDF_RESULT_SIZE(clsdf_outer_report), 0, 0, 0, 0, 0 }

/* The outer surface of a mesh whose parts may overlap, touch, repeat or contain each other: closed, its faces look
 * outwards, with the groups of the faces as given. Distances to it are those to the union of the parts. `sign`:
 * CLSDF_SIGN_AUTOMATIC, CLSDF_SIGN_NONZERO or CLSDF_SIGN_PARITY; of `call`, which may be null, should_stop counts;
 * `report` may be null. CLSDF_UNSUPPORTED for other rules, also if the mesh has one of them; CLSDF_INVALID_MESH if the
 * mesh does not meet the rule or nothing is inside. */
CLSDF_API clsdf_status clsdf_mesh_outer(const clsdf_mesh* mesh, int32_t sign, const clsdf_call_options* call,
                                        clsdf_mesh** outer, clsdf_outer_report* report);
/* The number of the face as given that each triangle of a mesh of clsdf_mesh_outer() is a part of, from 0 whatever the
 * index base, in the mesh's own memory, as long as it lives; 0 numbers for other meshes. */
CLSDF_API clsdf_status clsdf_mesh_given_faces(const clsdf_mesh* mesh, const uint32_t** faces, int64_t* count);
/* The same for a mesh of clsdf_scene_outer(): the body of each triangle, from 0; the faces count within its mesh. */
CLSDF_API clsdf_status clsdf_mesh_given_bodies(const clsdf_mesh* mesh, const uint32_t** bodies, int64_t* count);

#ifdef __cplusplus
}
#endif

#endif
