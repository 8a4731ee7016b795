// The unfinished files of this library's copy of the core, if that is static.
#include "core/unfinished_files.hpp"

#include <clsdf.h>

void clsdf_abandon_unfinished_files() {
    clsdf::UnfinishedFiles::of_process().abandon();
}
