#include "io/fields/vdb_trees.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace clsdf {
namespace {

using namespace vdb;

/// OpenVDB's archive, on a stream that reports a full disk.
class Archive : public openvdb::io::Archive {
public:
    void write_file(const std::string& path, const openvdb::GridCPtrVec& grids) const {
        // OpenVDB writes a few bytes at a time.
        std::vector<char> room(std::size_t{1} << 20);
        std::ofstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.rdbuf()->pubsetbuf(room.data(), static_cast<std::streamsize>(room.size()));
        stream.open(path, std::ios::binary);
        openvdb::io::Archive::write(stream, grids, true);
        stream.close();
    }
};

class VdbWriter : public SparseFormatWriter {
public:
    VdbWriter(const std::string& path, const FieldDescription& field, OutputSet outputs)
        : path_(path), trees_(path, field, outputs), file_(path) {
        file_.temporary();  // throws if it has none
    }

    void append(const SparseSlab& slab) override { trees_.add(slab); }

    void finish() override {
        const std::vector<openvdb::GridBase::Ptr> grids = trees_.finish();
        for (const openvdb::GridBase::Ptr& grid : grids) grid->setCreator("clsdf " + version());
        grids.front()->insertMeta(description_key, openvdb::StringMetadata(description_text(trees_.field())));
        errno = 0;  // OpenVDB does not say why a write fails
        try {
            Archive archive;
            archive.setCompression(compression());
            archive.write_file(file_.temporary(), {grids.begin(), grids.end()});
            seal_vdb(file_.temporary());
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            const std::string reason = errno == 0 ? "" : std::generic_category().message(errno);
            // The stream's own text names no reason.
            const bool is_stream = dynamic_cast<const std::ios_base::failure*>(&error) != nullptr;
            const std::string what = is_stream && !reason.empty() ? "" : error.what();
            const char* const between = what.empty() || reason.empty() ? "" : ": ";
            throw Error(ErrorCode::output_failure,
                        fmt::format("cannot write '{}': {}{}{}", path_, what, between, reason));
        }
        file_.commit();
    }

private:
    // OpenVDB leaves out inactive values if a leaf has at most two of them, and compares them as numbers. So this is
    // off if one of them is zero. BLOSC would make the rest, distances of the band, smaller by 8 to 22%, and takes
    // a quarter of the whole time.
    std::uint32_t compression() const {
        const Band& band = trees_.field().band;
        if (band.inside != 0 && band.outside != 0) return openvdb::io::COMPRESS_ACTIVE_MASK;
        return Archive::hasBloscCompression() ? std::uint32_t{openvdb::io::COMPRESS_BLOSC} : 0U;
    }

    std::string path_;
    FieldTrees trees_;
    AtomicFile file_;
};

}  // namespace

std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription& field, OutputSet outputs) {
    return slices_as_bricks(field, outputs, sparse_vdb_writer(path, field, outputs));
}

std::unique_ptr<SparseFormatWriter> sparse_vdb_writer(const std::string& path, const FieldDescription& field,
                                                      OutputSet outputs) {
    return std::make_unique<VdbWriter>(path, field, outputs);
}

void check_vdb(const std::string&, OutputSet) {}

}  // namespace clsdf
