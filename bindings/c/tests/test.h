/* Checks for the C programs of this folder. A program ends at the first one that fails. */
#ifndef CLSDF_TEST_H
#define CLSDF_TEST_H

#include <clsdf.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The condition holds. */
#define CHECK(condition)                                                            \
    do {                                                                            \
        if (!(condition)) {                                                         \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition); \
            exit(1);                                                                \
        }                                                                           \
    } while (0)

/* The call succeeds and leaves no message. */
#define OK(call) succeeds((call), #call, __FILE__, __LINE__)
/* The call returns the status, and its message has the part. */
#define FAILS(expected, part, call) fails((expected), (part), (call), #call, __FILE__, __LINE__)

static inline void succeeds(clsdf_status status, const char* call, const char* file, int line) {
    if (status == CLSDF_OK && clsdf_last_error()[0] == 0) return;
    fprintf(stderr, "%s:%d: %s returns %d (%s): %s\n", file, line, call, (int)status, clsdf_status_name(status),
            clsdf_last_error());
    exit(1);
}

static inline void fails(clsdf_status expected, const char* part, clsdf_status status, const char* call,
                         const char* file, int line) {
    if (status == expected && strstr(clsdf_last_error(), part) != NULL && clsdf_last_error()[0] != 0) return;
    fprintf(stderr, "%s:%d: %s returns %d (%s) and '%s', not %d and '... %s ...'\n", file, line, call, (int)status,
            clsdf_status_name(status), clsdf_last_error(), (int)expected, part);
    exit(1);
}

static inline void* allocate(size_t bytes) {
    void* memory = calloc(bytes > 0 ? bytes : 1, 1);
    if (memory == NULL) exit(3);
    return memory;
}

static inline clsdf_target float_target(float* values, int64_t count) {
    return clsdf_host_target(CLSDF_DISTANCE, CLSDF_FLOAT32, values, count);
}

#endif
