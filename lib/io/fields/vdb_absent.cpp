#include "io/fields/field_files.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

// Replaces vdb_write.cpp and vdb_read.cpp if the library is built without OpenVDB.

namespace clsdf {
namespace {

[[noreturn]] void refuse(const std::string& path) {
    throw Error(
        ErrorCode::unsupported,
        fmt::format("{}: this build of clsdf has no OpenVDB; install it (on Debian: apt-get install "
                    "libopenvdb-dev), configure with -DCLSDF_WITH_OPENVDB=ON and build again, or choose another "
                    "format",
                    path));
}

}  // namespace

std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription&, OutputSet) {
    refuse(path);
}

std::unique_ptr<SparseFormatWriter> sparse_vdb_writer(const std::string& path, const FieldDescription&, OutputSet) {
    refuse(path);
}

Field read_vdb(const std::string& path, OutputSet) {
    refuse(path);
}

std::optional<SparseField> read_sparse_vdb(const std::string& path, OutputSet) {
    refuse(path);
}

void check_vdb(const std::string& path, OutputSet) {
    refuse(path);
}

}  // namespace clsdf
