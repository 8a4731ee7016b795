#include "field/description.hpp"
#include "field/formats.hpp"
#include "field/vdb_file.hpp"
#include "field/vdb_grids.hpp"

#include <clsdf/error.hpp>
#include <clsdf/version.hpp>

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>

namespace clsdf {
namespace {

using namespace vdb;

constexpr std::int64_t leaf_side = openvdb::FloatTree::LeafNodeType::DIM;

// The block of a leaf in a layer of slices, cut off at the grid's end.
struct Block {
    Index3 first{};
    Index3 size{};

    bool is_whole() const { return size == Index3{leaf_side, leaf_side, leaf_side}; }
};

// A layer of up to eight slices of one output.
struct Layer {
    Index3 grid_size{};
    std::int64_t first_slice = 0;
    std::int64_t slices = 0;

    template <class Action>
    void for_each_block(const Action& action) const {
        for (std::int64_t y = 0; y < grid_size[1]; y += leaf_side)
            for (std::int64_t x = 0; x < grid_size[0]; x += leaf_side)
                action(Block{{x, y, first_slice},
                             {std::min(leaf_side, grid_size[0] - x), std::min(leaf_side, grid_size[1] - y), slices}});
    }

    // Calls with the offset in the leaf and the sample's in the layer.
    template <class Action>
    void for_each_sample(const Block& block, const Action& action) const {
        for (std::int64_t k = 0; k < block.size[2]; ++k)
            for (std::int64_t j = 0; j < block.size[1]; ++j)
                for (std::int64_t i = 0; i < block.size[0]; ++i)
                    action(static_cast<openvdb::Index>((i * leaf_side + j) * leaf_side + k),
                           static_cast<std::size_t>(block.first[0] + i +
                                                    grid_size[0] * (block.first[1] + j + grid_size[1] * k)));
    }
};

/// One output on its way into a tree.
class OutputTree {
public:
    OutputTree() = default;
    OutputTree(const OutputTree&) = delete;
    OutputTree& operator=(const OutputTree&) = delete;
    virtual ~OutputTree() = default;

    /// `distance` and `values` are those of the layer; a sample is active where its distance is in the band.
    virtual void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) = 0;
    virtual openvdb::GridBase::Ptr finish() = 0;
};

/// What samples beyond the band carry, compared bit by bit: -0.0 is not 0.0. Where the band has no end, none is beyond.
struct Fill {
    float outside;
    float inside;

    static bool is_same(float one, float other) {
        return std::isfinite(one) && std::bit_cast<std::uint32_t>(one) == std::bit_cast<std::uint32_t>(other);
    }
    bool is_outside(float value) const { return is_same(outside, value); }
    bool is_inside(float value) const { return is_same(inside, value); }
    bool is_beyond(float value) const { return is_outside(value) || is_inside(value); }
};

/// The samples of the band are active; what lies inside beyond it is filled by tiles, and outside is the background.
class DistanceTree : public OutputTree {
public:
    explicit DistanceTree(const Fill& fill) : fill_(fill), grid_(openvdb::FloatGrid::create(fill.outside)) {}

    void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte>) override {
        for (const float value : distance)
            if (std::isfinite(value)) farthest_ = std::max(farthest_, value);
        layer.for_each_block([&](const Block& block) {
            bool is_outside = true, is_inside = true;
            layer.for_each_sample(block, [&](openvdb::Index, std::size_t sample) {
                is_outside = is_outside && fill_.is_outside(distance[sample]);
                is_inside = is_inside && fill_.is_inside(distance[sample]);
            });
            if (is_outside) return;
            if (is_inside && block.is_whole()) {
                grid_->tree().addTile(1, coordinates(block.first), fill_.inside, false);
                return;
            }
            auto& leaf = *grid_->tree().touchLeaf(coordinates(block.first));
            layer.for_each_sample(block, [&](openvdb::Index offset, std::size_t sample) {
                const float value = distance[sample];
                if (fill_.is_beyond(value))
                    leaf.setValueOff(offset, value);
                else
                    leaf.setValueOn(offset, value);
            });
        });
    }

    openvdb::GridBase::Ptr finish() override {
        // Programs do arithmetic with the background: a field without end has its largest distance there.
        if (!std::isfinite(fill_.outside)) grid_->tree().root().setBackground(farthest_, true);
        // Tiles are merged where values compare equal, as 0.0 and -0.0 do.
        if (fill_.outside != 0 && fill_.inside != 0) openvdb::tools::pruneTiles(grid_->tree());
        return grid_;
    }

private:
    Fill fill_;
    float farthest_ = 0;
    openvdb::FloatGrid::Ptr grid_;
};

/// Another output, with a background that means "beyond the band".
template <class GridType>
class ExtraTree : public OutputTree {
public:
    using Value = typename GridType::ValueType;

    ExtraTree(const Fill& fill, const Value& background)
        : fill_(fill), background_(background), grid_(GridType::create(background)) {}

    void add(const Layer& layer, std::span<const float> distance, std::span<const std::byte> values) override {
        const auto value_of = [&](std::size_t sample) {
            Value value;
            std::memcpy(&value, values.data() + sample * sizeof(Value), sizeof(Value));
            return value;
        };
        layer.for_each_block([&](const Block& block) {
            bool is_background = true;
            layer.for_each_sample(block, [&](openvdb::Index, std::size_t sample) {
                is_background = is_background && fill_.is_beyond(distance[sample]) &&
                                std::ranges::equal(values.subspan(sample * sizeof(Value), sizeof(Value)),
                                                   std::as_bytes(std::span(&background_, 1)));
            });
            if (is_background) return;
            auto& leaf = *grid_->tree().touchLeaf(coordinates(block.first));
            layer.for_each_sample(block, [&](openvdb::Index offset, std::size_t sample) {
                if (fill_.is_beyond(distance[sample]))
                    leaf.setValueOff(offset, value_of(sample));
                else
                    leaf.setValueOn(offset, value_of(sample));
            });
        });
    }

    openvdb::GridBase::Ptr finish() override { return grid_; }

private:
    Fill fill_;
    Value background_;
    typename GridType::Ptr grid_;
};

std::unique_ptr<OutputTree> tree_for(const OutputKind& kind, const Fill& fill, const std::string& path) {
    constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
    if (std::string_view(kind.name) == distance_kind().name) return std::make_unique<DistanceTree>(fill);
    if (is_index(kind)) return std::make_unique<ExtraTree<openvdb::Int32Grid>>(fill, -1);  // no_triangle
    if (is_vector(kind)) return std::make_unique<ExtraTree<openvdb::Vec3SGrid>>(fill, openvdb::Vec3s(nothing));
    throw Error(ErrorCode::unsupported, fmt::format("{}: .vdb has no place for the output {}", path, kind.name));
}

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
            const std::int64_t layer_end = std::min(size[2], (z / leaf_side + 1) * leaf_side);
            const std::int64_t count = std::min(slices - k, layer_end - z);
            for (std::size_t i = 0; i < kinds_.size(); ++i) {
                const std::size_t bytes = slice * kinds_[i].sample_bytes();
                const auto part = kinds_[i].bytes(slab).subspan(static_cast<std::size_t>(k) * bytes,
                                                                static_cast<std::size_t>(count) * bytes);
                pending_[i].insert(pending_[i].end(), part.begin(), part.end());
            }
            k += count;
            if (z + count == layer_end) add_layer(z / leaf_side * leaf_side, layer_end);
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
    void add_layer(std::int64_t begin, std::int64_t end) {
        const Layer layer{field_.grid.size, begin, end - begin};
        const std::size_t samples = pending_[0].size() / sizeof(float);
        const std::span distance(reinterpret_cast<const float*>(pending_[0].data()), samples);
        for (std::size_t i = 0; i < kinds_.size(); ++i) trees_[i]->add(layer, distance, pending_[i]);
        for (std::vector<std::byte>& values : pending_) values.clear();
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
