#pragma once

#include "io/fields/bricks.hpp"
#include "io/fields/vdb.hpp"

#include <memory>
#include <string>
#include <vector>

namespace clsdf::vdb {

/// One output on its way into a tree.
class OutputTree {
public:
    OutputTree() = default;
    OutputTree(const OutputTree&) = delete;
    OutputTree& operator=(const OutputTree&) = delete;
    virtual ~OutputTree() = default;

    /// The values of the bricks and, for the distance, bricks that are inside.
    virtual void add(const Grid& grid, const SparseSlab& slab) = 0;
    virtual openvdb::GridBase::Ptr finish(float background) = 0;
};

/// OpenVDB's grids of a field's outputs, made of bricks. A brick becomes a leaf. Indices are those of the lattice.
class FieldTrees {
public:
    /// `path` begins the messages. Throws Error(unsupported) for what OpenVDB cannot store.
    FieldTrees(const std::string& path, const FieldDescription& field, OutputSet outputs);

    void add(const SparseSlab& slab);
    /// The grids in the order of infos(), the distance's first.
    std::vector<openvdb::GridBase::Ptr> finish();

    const FieldDescription& field() const { return field_; }
    const std::vector<OutputInfo>& infos() const { return infos_; }

private:
    FieldDescription field_;
    std::vector<OutputInfo> infos_;
    Background background_;
    openvdb::math::Transform::Ptr transform_;
    std::vector<std::unique_ptr<OutputTree>> trees_;
};

}  // namespace clsdf::vdb
