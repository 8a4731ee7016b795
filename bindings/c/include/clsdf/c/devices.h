#ifndef CLSDF_C_DEVICES_H
#define CLSDF_C_DEVICES_H

/*
 * Devices of OpenCL, and threads of the host.
 * A part of clsdf.h, which programs include; its rules hold.
 */

#include "basics.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Devices ---- */

/* The properties that a device reports; unknown ones are 0 or "". Texts live as long as the handle that gave them. */
typedef struct clsdf_device_info {
    size_t struct_size;
    int64_t index;    /* in the list of devices; -1: not in it, as a part of a device */
    void* id;         /* cl_device_id */
    const char* name; /* of a device without one, that of its platform */
    const char* platform;
    const char* version;   /* of OpenCL */
    const char* driver;    /* its version */
    const char* why_not;   /* why this library cannot use it; "" if it can */
    int64_t compute_units; /* 0: this and all to atomics64 are unknown */
    int64_t clock_megahertz;
    int64_t memory;             /* bytes */
    int64_t largest_allocation; /* bytes */
    int64_t float_width;        /* floats in a native vector; 1 on most GPUs */
    int32_t kind;               /* CLSDF_GPU ... */
    int32_t fp64;               /* 1: double precision, which this library needs */
    int32_t atomics64;          /* 1: atomic operations on 64 bits, which it does not need */
    int32_t source;             /* CLSDF_REGISTERED ..., how it was found: always known */
    const char* driver_file;    /* if this library opened it; of CLSDF_DEVICE_FILE, the file in /dev; else "" */
    const char* only_if_named;  /* why it is taken only if it is named, though it can be used; else "" */
} clsdf_device_info;
#define CLSDF_DEVICE_INFO_INIT                                                                                        \
    {                                                                                                                 \
        CLSDF_RESULT_SIZE(clsdf_device_info), 0, NULL, NULL, NULL, NULL, NULL, NULL, 0, 0, 0, 0, 0, 0, 0, 0, 0, NULL, \
            NULL                                                                                                      \
    }

/* Limits of clsdf_device_limited(). */
typedef struct clsdf_device_limits {
    size_t struct_size;
    int64_t compute_units; /* to use; on a processor, cores. 0: all */
    int64_t memory;        /* bytes that the buffers of one transform and its plans may take; 0: all */
} clsdf_device_limits;
#define CLSDF_DEVICE_LIMITS_INIT \
    { sizeof(clsdf_device_limits), 0, 0 }

/* All devices of all platforms, also those that cannot be used. */
CLSDF_API clsdf_status clsdf_devices_list(clsdf_devices** devices);
/* 0 for null. Threads: any number, as in the next. */
CLSDF_API int64_t clsdf_devices_count(const clsdf_devices* devices);
CLSDF_API clsdf_status clsdf_devices_describe(const clsdf_devices* devices, int64_t index, clsdf_device_info* info);

/* The strongest GPU, else the strongest other device; none with a text in only_if_named. CLSDF_NO_DEVICE says why each
 * is not taken, and the remedy. */
CLSDF_API clsdf_status clsdf_device_strongest(clsdf_device** device);
/* A whole number is an index in the list. Any other text is a part of the name, or of the platform's name, of exactly
 * one usable device. */
CLSDF_API clsdf_status clsdf_device_select(const char* index_or_part, clsdf_device** device);
/* clsdf_device_select() with the environment variable CLSDF_DEVICE if it is set and not empty, else the strongest. */
CLSDF_API clsdf_status clsdf_device_automatic(clsdf_device** device);
/* The share of a process: `rank` of the `ranks` processes on this machine, 0 <= rank < ranks. GPUs that may be
 * taken are dealt out in turn. If there is none, or if CLSDF_DEVICE names a device, it is that of
 * clsdf_device_automatic(), of a processor an equal part of the compute units, at least one. CLSDF_UNSUPPORTED names
 * the driver's variable if a processor cannot be divided. clsdf_limit_threads() limits the host's loops. */
CLSDF_API clsdf_status clsdf_device_of_rank(int64_t rank, int64_t ranks, clsdf_device** device);
/* Retains the caller's cl_context, cl_device_id and cl_command_queue. */
CLSDF_API clsdf_status clsdf_device_from_handles(void* context, void* id, void* queue, clsdf_device** device);
/* The same device with limits, with a context and a queue of its own. Threads: any number, as in all that follow. */
CLSDF_API clsdf_status clsdf_device_limited(const clsdf_device* device, const clsdf_device_limits* limits,
                                            clsdf_device** limited);
/* Asks every driver. */
CLSDF_API clsdf_status clsdf_device_describe(const clsdf_device* device, clsdf_device_info* info);
/* The cl_context, cl_device_id and cl_command_queue. They belong to the device: retain those that you keep for longer.
 * Each pointer may be null. */
CLSDF_API clsdf_status clsdf_device_handles(const clsdf_device* device, void** context, void** id, void** queue);
/* A cl_mem of `bytes` bytes, of the device's context, that is memory of another interface: of CUDA for instance,
 * exported as a POSIX file descriptor (cuMemExportToShareableHandle). On success the driver owns the descriptor, and
 * you release the cl_mem; after an error you still own the descriptor. Commands may use the cl_mem only between
 * clEnqueueAcquireExternalMemObjectsKHR and clEnqueueReleaseExternalMemObjectsKHR, which you enqueue. CLSDF_UNSUPPORTED
 * if the driver has no cl_khr_external_memory_opaque_fd, CLSDF_INVALID_ARGUMENT if it does not take the descriptor as
 * memory of this size. */
CLSDF_API clsdf_status clsdf_device_import_memory(const clsdf_device* device, int32_t descriptor, int64_t bytes,
                                                  void** memory);

/* Keeps records of passed tests in the folder, for programs that are built from now on. Null or "": none. */
CLSDF_API clsdf_status clsdf_device_keep_records(const clsdf_device* device, const char* folder);
/* Takes compiled programs from a folder that clsdf_device_write_programs() filled. The process runs the code in it:
 * name one in which nobody else can write. Null or "": none. */
CLSDF_API clsdf_status clsdf_device_read_programs(const clsdf_device* device, const char* folder);
/* Writes programs that are compiled from now on to the folder, too. Null or "": none. */
CLSDF_API clsdf_status clsdf_device_write_programs(const clsdf_device* device, const char* folder);
/* Deletes the records of this device: programs are tested again. */
CLSDF_API clsdf_status clsdf_device_forget_records(const clsdf_device* device);
/* Gives back what the device keeps for later calls, beside what transforms and plans hold: arrays of the host, at most
 * 32 MiB; and, of a device with memory of its own, memory of the device that no transform uses, at most 512 MiB and
 * 1/32 of its memory, and 40 MiB of pinned memory of the host. *bytes, if not null: how many. The next call makes what
 * it needs anew. */
CLSDF_API clsdf_status clsdf_device_release_memory(const clsdf_device* device, int64_t* bytes);
/* The folder of clsdf_device_keep_records(). */
CLSDF_API clsdf_status clsdf_device_record_folder(const clsdf_device* device, char* text, int64_t size,
                                                  int64_t* length);
/* The folder that clsdf's command uses: CLSDF_CACHE_DIR, or one of the user's. "" if none is known. */
CLSDF_API clsdf_status clsdf_default_record_folder(char* text, int64_t size, int64_t* length);

/* The loops of the library on the host (oneTBB's) have at most `count` threads, the calling one included, until the
 * handle is released. Holds for the process; of several limits the smallest. It does not limit an OpenCL driver's
 * threads: clsdf_device_limited() does. */
CLSDF_API clsdf_status clsdf_limit_threads(int64_t count, clsdf_thread_limit** limit);
/* The limit in force. */
CLSDF_API int64_t clsdf_thread_count(void);

#ifdef __cplusplus
}
#endif

#endif
