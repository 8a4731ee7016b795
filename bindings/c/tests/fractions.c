/* Fractions of cells: two cubes that overlap, in rows and in arrays of AMReX's order. */
#include "test.h"

/* Two cubes of side 2, about (0, 0, 0) and (1, 0, 0): a bar of 3 by 2 by 2. */
static clsdf_mesh* bar(void) {
    double vertices[16][3];
    int32_t faces[24][3];
    static const int32_t cube[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                        {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    clsdf_mesh_arrays arrays = CLSDF_MESH_ARRAYS_INIT;
    clsdf_mesh* mesh;
    int i, k;
    for (i = 0; i < 16; ++i) {
        vertices[i][0] = (i & 1 ? 1 : -1) + (i < 8 ? 0 : 1);
        vertices[i][1] = i & 2 ? 1 : -1;
        vertices[i][2] = i & 4 ? 1 : -1;
    }
    for (i = 0; i < 24; ++i)
        for (k = 0; k < 3; ++k) faces[i][k] = cube[i % 12][k] + (i < 12 ? 0 : 8);
    arrays.vertices = clsdf_host_array(CLSDF_FLOAT64, vertices, 16);
    arrays.triangles = clsdf_host_array(CLSDF_INT32, faces, 24);
    OK(clsdf_mesh_create(&arrays, &mesh));
    return mesh;
}

struct sums {
    double volume, area;
    int64_t grids, cells, full;
    int ends;
};

static int32_t add(void* user, int64_t grid_number, const clsdf_cell_fraction* cells, int64_t count,
                   const uint8_t* full) {
    struct sums* const sums = user;
    int64_t i;
    if (sums->ends) return CLSDF_OWN_STATUS;
    CHECK(grid_number == sums->grids++);
    for (i = 0; i < count; ++i) {
        sums->volume += cells[i].volume;
        sums->area += cells[i].area;
        CHECK(cells[i].pieces >= 1 && cells[i].cell[0] >= 0 && cells[i].cell[0] < 7);
    }
    sums->cells += count;
    for (i = 0; i < 7 * 5 * 5; ++i) sums->full += full[i / 8] >> i % 8 & 1;
    return CLSDF_OK;
}

/* Of slabs, whose rows come in the order of the whole grid's. */
static int32_t add_slab(void* user, const clsdf_grid* part, const clsdf_cell_fraction* cells, int64_t count,
                        const uint8_t* full) {
    struct sums* const sums = user;
    CHECK(part->size[0] == 8 && part->size[1] == 6 && part->first[2] == sums->ends && full != NULL);
    sums->ends += (int)part->size[2] - 1;
    sums->cells += count;
    return count > 0 && cells[0].cell[2] < part->first[2] ? CLSDF_OWN_STATUS : CLSDF_OK;
}

static int32_t stop(void* user) {
    (void)user;
    return CLSDF_CANCELLED;
}

int main(void) {
    enum { NX = 7, NY = 5, NZ = 5, CELLS = NX * NY * NZ, FACES = (NX + 1) * NY * NZ };
    /* Samples a quarter of a cell beyond the walls. */
    const clsdf_grid grid = {{-1.25, -1.25, -1.25}, {0.5, 0.5, 0.5}, {NX + 1, NY + 1, NZ + 1}, {0, 0, 0}};
    clsdf_grid grids[2];
    clsdf_fraction_options options = CLSDF_FRACTION_OPTIONS_INIT;
    clsdf_fraction_request request;
    clsdf_call_options call = CLSDF_CALL_OPTIONS_INIT;
    struct sums sums = {0, 0, 0, 0, 0, 0};
    clsdf_mesh *mesh = bar(), *outer;
    clsdf_fraction_row_arrays arrays;
    clsdf_cell_fraction rows[CELLS];
    double volume[CELLS], normal[3][CELLS], across_x[FACES], sum = 0;
    uint8_t types[CELLS];
    int64_t count = 0;
    int i;

    OK(clsdf_mesh_outer(mesh, CLSDF_SIGN_AUTOMATIC, NULL, &outer, NULL));
    grids[0] = grids[1] = grid;
    OK(clsdf_fractions(mesh, CLSDF_SIGN_AUTOMATIC, grids, 2, NULL, add, &sums, NULL));
    CHECK(sums.grids == 2 && sums.area > 64 - 1e-12 && sums.area < 64 + 1e-12);
    CHECK((sums.volume + (double)sums.full) * 0.125 > 24 - 1e-12 &&
          (sums.volume + (double)sums.full) * 0.125 < 24 + 1e-12);
    CHECK(sums.full == 2 * 5 * 3 * 3 && sums.cells == 2 * (CELLS - 5 * 3 * 3));
    sums.ends = 1;
    CHECK(clsdf_fractions(outer, CLSDF_SIGN_AUTOMATIC, grids, 2, NULL, add, &sums, NULL) == CLSDF_OWN_STATUS);

    /* By slabs, counted, and into rows of the caller's with a stride. */
    memset(&sums, 0, sizeof sums);
    OK(clsdf_fraction_slabs(outer, CLSDF_SIGN_AUTOMATIC, &grid, NULL, add_slab, &sums, NULL));
    CHECK(sums.ends == NZ && sums.cells == CELLS - 5 * 3 * 3);
    OK(clsdf_count_fractions(mesh, CLSDF_SIGN_AUTOMATIC, &grid, NULL, NULL, &count));
    CHECK(count == sums.cells);
    memset(&arrays, 0, sizeof arrays);
    memset(rows, 0, sizeof rows);
    arrays.room = count - 1;
    arrays.volume = clsdf_host_array(CLSDF_FLOAT64, &rows[0].volume, 0);
    arrays.volume.strides[0] = sizeof rows[0];
    arrays.cells = clsdf_host_array(CLSDF_INT32, rows[0].cell, 0);
    arrays.cells.strides[0] = sizeof rows[0];
    arrays.full = clsdf_host_array(CLSDF_UINT8, types, CELLS);
    FAILS(CLSDF_INVALID_ARGUMENT, "room for 129",
          clsdf_fraction_rows(outer, CLSDF_SIGN_AUTOMATIC, NULL, &grid, &arrays, NULL, NULL, &count));
    CHECK(count == 130 && rows[0].volume == 0);
    arrays.room = CELLS;
    OK(clsdf_fraction_rows(outer, CLSDF_SIGN_AUTOMATIC, NULL, &grid, &arrays, NULL, NULL, &count));
    for (i = 0; i < CELLS; ++i) sum += rows[i].volume + types[i];
    CHECK(count == 130 && sum * 0.125 > 12 - 1e-12 && sum * 0.125 < 12 + 1e-12);
    CHECK(rows[129].cell[0] == NX - 1 && rows[129].cell[2] == NZ - 1 && rows[130].volume == 0);
    FAILS(CLSDF_INVALID_ARGUMENT, "count is null",
          clsdf_fraction_rows(outer, CLSDF_SIGN_AUTOMATIC, NULL, &grid, &arrays, NULL, NULL, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "sink is null",
          clsdf_fraction_slabs(outer, CLSDF_SIGN_AUTOMATIC, &grid, NULL, NULL, NULL, NULL));

    /* As AMReX has them: the fluid, the normal into the solid, components one after another. */
    OK(clsdf_fraction_convention("amrex", &options));
    CHECK(options.part == CLSDF_PART_FLUID && options.walls == CLSDF_WALL_FLUID && options.normals_into_solid == 1 &&
          options.no_surface_centroid == -1 && options.struct_size == sizeof options);
    memset(&request, 0, sizeof request);
    request.grid = grid;
    request.types = clsdf_host_array(CLSDF_UINT8, types, CELLS);
    request.volume = clsdf_host_array(CLSDF_FLOAT64, volume, CELLS);
    request.normal = clsdf_host_array(CLSDF_FLOAT64, normal, CELLS);
    request.normal.component_stride = sizeof normal[0];
    request.face_fractions[0] = clsdf_host_array(CLSDF_FLOAT64, across_x, FACES);
    OK(clsdf_fraction_arrays(outer, CLSDF_SIGN_AUTOMATIC, &request, 1, &options, NULL));
    sum = 0;
    for (i = 0; i < CELLS; ++i) {
        sum += volume[i];
        if (types[i] != CLSDF_CELL_CUT) CHECK(volume[i] == (types[i] == CLSDF_CELL_FULL ? 1 : 0));
    }
    CHECK(sum * 0.125 > CELLS * 0.125 - 12 - 1e-12 && sum * 0.125 < CELLS * 0.125 - 12 + 1e-12);
    /* The middle of the low wall across x: half a cell of fluid, and the wall above it. */
    i = (2 * NY + 2) * NX;
    CHECK(types[i] == CLSDF_CELL_CUT && volume[i] == 0.5);
    CHECK(normal[0][i] == 1 && normal[1][i] == 0 && normal[2][i] == 0);
    CHECK(across_x[(2 * NY + 2) * (NX + 1)] == 1 && across_x[(2 * NY + 2) * (NX + 1) + 1] == 0);

    request.volume.count = 7;
    FAILS(CLSDF_INVALID_ARGUMENT, "there are 175 cells",
          clsdf_fraction_arrays(outer, CLSDF_SIGN_AUTOMATIC, &request, 1, &options, NULL));
    FAILS(CLSDF_INVALID_ARGUMENT, "'vof'", clsdf_fraction_convention("vof", &options));
    options.part = 2;
    FAILS(CLSDF_INVALID_ARGUMENT, "clsdf_fraction_options.part",
          clsdf_fractions(mesh, CLSDF_SIGN_AUTOMATIC, grids, 2, &options, add, &sums, NULL));
    call.should_stop = stop;
    sums.ends = 0;
    FAILS(CLSDF_CANCELLED, "cancelled",
          clsdf_fractions(outer, CLSDF_SIGN_AUTOMATIC, grids, 2, NULL, add, &sums, &call));
    clsdf_mesh_release(outer);
    clsdf_mesh_release(mesh);
    return 0;
}
