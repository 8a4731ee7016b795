/* Functions that the examples share. */
#ifndef CLSDF_EXAMPLE_H
#define CLSDF_EXAMPLE_H

#include <clsdf.h>

#include <stdio.h>
#include <stdlib.h>

/* Ends the program with the message of a call that failed. */
static inline void check(clsdf_status status) {
    if (status == CLSDF_OK) return;
    fprintf(stderr, "%s: %s\n", clsdf_status_name(status), clsdf_last_error());
    exit(2);
}

static inline void* allocate(size_t bytes) {
    void* memory = malloc(bytes > 0 ? bytes : 1);
    if (memory == NULL) exit(3);
    return memory;
}

/* For tests alone: appends the bytes to the file that the environment variable CLSDF_EXAMPLE_ARRAYS names, if it is
 * set, so that the same example in another language can be compared with this one. */
static inline void record(const void* bytes, size_t size) {
    const char* path = getenv("CLSDF_EXAMPLE_ARRAYS");
    FILE* file;
    if (path == NULL) return;
    file = fopen(path, "ab");
    if (file == NULL || fwrite(bytes, 1, size, file) != size) abort();
    fclose(file);
}

#endif
