#include "field/description.hpp"
#include "field/formats.hpp"
#include "field/vdb_file.hpp"
#include "field/vdb_trees.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>

namespace clsdf {
namespace {

using namespace vdb;

openvdb::math::Transform::Ptr transform_of(const Grid& grid, const std::string& path) {
    const Vec3 origin = grid.position(0, 0, 0);
    const openvdb::Vec3d translation(origin[0], origin[1], origin[2]);
    const Vec3& h = grid.spacing;
    try {
        openvdb::math::MapBase::Ptr map;
        if (h[0] == h[1] && h[0] == h[2])
            map.reset(new openvdb::math::UniformScaleTranslateMap(h[0], translation));
        else
            map.reset(new openvdb::math::ScaleTranslateMap(openvdb::Vec3d(h[0], h[1], h[2]), translation));
        // Made from a map, a transform rounds the spacing to the origin's last place; read from a file it does not.
        std::stringstream stream;
        openvdb::io::setCurrentVersion(stream);
        openvdb::writeString(stream, map->type());
        map->write(stream);
        auto transform = openvdb::math::Transform::createLinearTransform();
        transform->read(stream);
        return transform;
    } catch (const openvdb::ArithmeticError&) {
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: OpenVDB has no voxels as small as {}; scale the mesh, or choose another format",
                                path, fmt::join(h, " x ")));
    }
}

/// OpenVDB's own archive, on a stream that says when the disk is full.
class Archive : public openvdb::io::Archive {
public:
    void write(const std::string& path, const openvdb::GridCPtrVec& grids) const {
        std::ofstream stream;
        stream.exceptions(std::ios::failbit | std::ios::badbit);
        stream.open(path, std::ios::binary);
        openvdb::io::Archive::write(stream, grids, true);
        stream.close();
    }
};

class VdbWriter : public FormatWriter {
public:
    VdbWriter(const std::string& path, const FieldDescription& field, const Outputs& outputs)
        : path_(path),
          field_(field),
          kinds_(kinds_of(outputs)),
          transform_(transform_of(field.grid, path)),
          file_(path) {
        file_.temporary();  // throws where it has none
        const Fill fill{static_cast<float>(field.band.outside), -static_cast<float>(field.band.inside)};
        for (const OutputKind& kind : kinds_) trees_.push_back(tree_for(kind, fill, path));
        pending_.resize(kinds_.size());
    }

    // Layers of eight slices, the height of a leaf.
    void append(const FieldSlab& slab, std::int64_t first_slice) override {
        const Index3& size = field_.grid.size;
        const auto slice = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
        const auto slices = static_cast<std::int64_t>(slab.distance.size() / slice);
        for (std::int64_t k = 0; k < slices;) {
            const std::int64_t z = first_slice + k;
            const std::int64_t layer_begin = z / leaf_side * leaf_side;
            const std::int64_t layer_end = std::min(size[2], layer_begin + leaf_side);
            const std::int64_t count = std::min(slices - k, layer_end - z);
            std::vector<std::span<const std::byte>> parts;
            for (const OutputKind& kind : kinds_) {
                const std::size_t bytes = slice * kind.sample_bytes();
                parts.push_back(kind.bytes(slab).subspan(static_cast<std::size_t>(k) * bytes,
                                                         static_cast<std::size_t>(count) * bytes));
            }
            if (count < layer_end - layer_begin) {
                for (std::size_t i = 0; i < parts.size(); ++i) {
                    pending_[i].insert(pending_[i].end(), parts[i].begin(), parts[i].end());
                    parts[i] = pending_[i];
                }
            }
            k += count;
            if (z + count < layer_end) continue;
            add_layer({size, layer_begin, layer_end - layer_begin}, parts);
            for (std::vector<std::byte>& values : pending_) values.clear();
        }
    }

    void finish() override {
        openvdb::GridCPtrVec grids;
        for (std::size_t i = 0; i < kinds_.size(); ++i) {
            const openvdb::GridBase::Ptr grid = trees_[i]->finish();
            grid->setName(kinds_[i].name);
            grid->setTransform(transform_);
            grid->setCreator("clsdf " + version());
            if (i == 0) {
                grid->setGridClass(is_level_set() ? openvdb::GRID_LEVEL_SET : openvdb::GRID_UNKNOWN);
                grid->insertMeta(description_key, openvdb::StringMetadata(description_text(field_)));
            }
            grids.push_back(grid);
        }
        try {
            Archive archive;
            archive.setCompression(compression());
            archive.write(file_.temporary(), grids);
            seal_vdb(file_.temporary());
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            throw Error(ErrorCode::output_failure, fmt::format("cannot write '{}': {}", path_, error.what()));
        }
        file_.commit();
    }

private:
    void add_layer(const Layer& layer, std::span<const std::span<const std::byte>> values) {
        const std::span distance(reinterpret_cast<const float*>(values[0].data()), values[0].size() / sizeof(float));
        for (std::size_t i = 0; i < kinds_.size(); ++i) trees_[i]->add(layer, distance, values[i]);
    }

    // What OpenVDB's tools take one for: cubic voxels, a sign, and a background that is the half width.
    bool is_level_set() const {
        const Vec3& h = field_.grid.spacing;
        return h[0] == h[1] && h[0] == h[2] && std::isfinite(field_.band.outside) && field_.band.outside > 0 &&
               field_.sign != SignRule::none;
    }

    // Inactive values are left out where they are one of two, which are compared as numbers: not where one is a zero.
    std::uint32_t compression() const {
        const bool has_zero = field_.band.inside == 0 || field_.band.outside == 0;
        const std::uint32_t mask = has_zero ? 0U : std::uint32_t{openvdb::io::COMPRESS_ACTIVE_MASK};
        return mask | (Archive::hasBloscCompression() ? std::uint32_t{openvdb::io::COMPRESS_BLOSC} : 0U);
    }

    std::string path_;
    FieldDescription field_;
    std::vector<OutputKind> kinds_;
    openvdb::math::Transform::Ptr transform_;
    std::vector<std::unique_ptr<OutputTree>> trees_;
    std::vector<std::vector<std::byte>> pending_;  // slices of the layer that is not yet whole
    AtomicFile file_;
};

}  // namespace

std::unique_ptr<FormatWriter> vdb_writer(const std::string& path, const FieldDescription& field,
                                         const Outputs& outputs) {
    initialise();
    for (const std::int64_t size : field.grid.size)
        if (size > std::numeric_limits<std::int32_t>::max() - leaf_side)
            throw Error(ErrorCode::unsupported,
                        fmt::format("{}: OpenVDB counts the samples of an axis in 32 bits, and {} are too many; choose "
                                    ".nrrd, .npy or .h5",
                                    path, size));
    return std::make_unique<VdbWriter>(path, field, outputs);
}

void check_vdb(const std::string&) {}

}  // namespace clsdf
