#ifndef CLSDF_IO_H
#define CLSDF_IO_H

/*
 * Files of fields, in the library libclsdf_c_io, which links HDF5 and, if it is built in, OpenVDB. A program with an
 * HDF5 of its own links libclsdf_c alone. The rules of clsdf.h hold.
 */

#include <clsdf.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a field: .nrrd, .npy, .vti, .vtkhdf, .h5, .nvdb, .sdf or, if OpenVDB is built in, .vdb; also files of other
 * programs. If the file states no band, the band has no end. An output whose file is missing has no array. */
CLSDF_API clsdf_status clsdf_field_read(const char* path, clsdf_field** field);
/* The files of outputs that the field's file names but that do not exist, one a line. */
CLSDF_API clsdf_status clsdf_field_missing_files(const char* path, char* text, int64_t size, int64_t* length);
/* Writes by the file's ending, complete or not at all. Threads: any number. */
CLSDF_API clsdf_status clsdf_field_write(const clsdf_field* field, const char* path);
/* The error that clsdf_field_write() would give for the ending, the outputs or the folder. Leaves no file. */
CLSDF_API clsdf_status clsdf_field_check_path(const char* path, uint32_t outputs);

/* Writes a field slab by slab, from the caller's arrays, without a copy. A call whose arguments alone are wrong (null,
 * a count below 1, arrays of another type or on the device) changes nothing. After any other failure (slices that do
 * not fit the grid, other outputs than announced, a full disk) the writer is of no more use, and no file stays. */
typedef struct clsdf_field_writer clsdf_field_writer;
CLSDF_API void clsdf_field_writer_retain(clsdf_field_writer* writer);
/* The last release without clsdf_field_writer_finish() leaves no file. */
CLSDF_API void clsdf_field_writer_release(clsdf_field_writer* writer);
CLSDF_API clsdf_status clsdf_field_writer_create(const char* path, const clsdf_field_description* description,
                                                 uint32_t outputs, clsdf_field_writer** writer);
/* The next `slices` slices in ascending z: packed arrays on the host, of the announced outputs, of the types that
 * clsdf_output_describe() states. Triangles in files count from 0. Threads: one. */
CLSDF_API clsdf_status clsdf_field_writer_append(clsdf_field_writer* writer, const clsdf_target* values, int64_t count,
                                                 int64_t slices);
/* Gives the files their names. Threads: one. */
CLSDF_API clsdf_status clsdf_field_writer_finish(clsdf_field_writer* writer);

/* Reads a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb as a sparse field. *field is null if the file has a dense
 * one, which clsdf_field_read() reads. Triangles count from 0 (clsdf_sparse_field_set_index_base()). The bricks of
 * .nvdb and .vdb are their leaves; samples beyond the grid have the background. Threads: any number. */
CLSDF_API clsdf_status clsdf_sparse_field_read(const char* path, clsdf_sparse_field** field);
/* Writes a sparse field to a .nvdb, .npy, .h5 or, if OpenVDB is built in, .vdb. Threads: any number. */
CLSDF_API clsdf_status clsdf_sparse_field_write(const clsdf_sparse_field* field, const char* path);

/* The same layer by layer: what a clsdf_sparse_function gets can be appended. Errors are as of a clsdf_field_writer. */
typedef struct clsdf_sparse_writer clsdf_sparse_writer;
CLSDF_API void clsdf_sparse_writer_retain(clsdf_sparse_writer* writer);
/* The last release without clsdf_sparse_writer_finish() leaves no file. */
CLSDF_API void clsdf_sparse_writer_release(clsdf_sparse_writer* writer);
CLSDF_API clsdf_status clsdf_sparse_writer_create(const char* path, const clsdf_field_description* description,
                                                  uint32_t outputs, clsdf_sparse_writer** writer);
/* The next layers in ascending z. Triangles in files count from 0. Threads: one. */
CLSDF_API clsdf_status clsdf_sparse_writer_append(clsdf_sparse_writer* writer, const clsdf_sparse_slab* slab);
/* Gives the file its name. Threads: one. */
CLSDF_API clsdf_status clsdf_sparse_writer_finish(clsdf_sparse_writer* writer);

/* For a program that is about to end: removes the unfinished files of all threads, those of clsdf.h included. The
 * program must end now. Not for signal handlers. */
CLSDF_API void clsdf_io_abandon_unfinished_files(void);

#ifdef __cplusplus
}
#endif

#endif
