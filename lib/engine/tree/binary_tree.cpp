#include "tree/binary_tree.hpp"

#include "core/parallel.hpp"
#include "device/read_back.hpp"
#include "launch/commands.hpp"
#include "launch/prefix_sums.hpp"
#include "launch/programs.hpp"
#include "launch/radix_sort.hpp"
#include "topology/face_order.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace clsdf::engine {

namespace {

/// A mesh on its way into the tree.
class Making {
public:
    /// found: a PointFacesFound, whose area is 0.
    Making(const DeviceTools& tools, const PointFaces& mesh, const cl::Buffer& positions, const cl::Buffer& triangles,
           const cl::Buffer& found)
        : tools_(tools),
          mesh_(mesh),
          positions_(positions),
          triangles_(triangles),
          found_buffer_(found),
          count_(mesh.count),
          places_(static_cast<cl_uint>(count_)),
          program_(tools.programs.binary_tree) {
        std::copy(mesh.lattice.origin.begin(), mesh.lattice.origin.end(), lattice_.origin);
        lattice_.unit = mesh.lattice.unit;
        // Finer cells than those of morton_order() make the tree deeper, not better.
        const double cells = 1U << morton_bits(count_), side = longest_side();
        lattice_.cells_per_unit = side > 0 ? cells / (3 * side) : 0;
        lattice_.last_cell = cells - 1;
    }

    /// before: may be null.
    FittedTree make(std::shared_ptr<const DividedFaces> before) {
        if (before) {
            FittedTree tree = fit(before);
            if (found_.special > 0 || tree.area <= 2 * before->area) return tree;
        }
        auto divided = std::make_shared<DividedFaces>(divide());
        FittedTree tree = fit(divided);
        divided->area = tree.area;
        return tree;
    }

    /// By make().
    const PointFacesFound& found() const { return found_; }

private:
    device::BufferPool::Lease lease(std::size_t bytes, const char* purpose) const {
        return tools_.pool->lease(bytes, purpose);
    }

    /// In units.
    double longest_side() const { return mesh_.box.longest_side() / mesh_.lattice.unit; }

    /// Waits twice, or not if all faces are one leaf.
    DividedFaces divide() {
        DividedFaces divided;
        const unsigned bits = static_cast<unsigned>(std::bit_width(count_));
        divided.tree.leaf = 1U << bits;
        divided.tree.distance = ~(2 * divided.tree.leaf - 1);
        divided.order = lease(count_ * sizeof(cl_uint), "order of the tree's faces");
        const device::BufferPool::Lease codes = lease(count_ * sizeof(cl_uint), "codes of faces");
        make_codes(divided, false, *codes);
        sort_by_keys(tools_, *codes, count_, 3 * morton_bits(count_), *divided.order);
        if (count_ <= CLSDF_LEAF_PLACES) {
            divided.tree.root = divided.tree.leaf;
            device::LentKernel mark = tools_.kernel(program_, "mark_only_leaf");
            launch(tools_.queue(), mark, {1}, places_, *divided.order);
        } else {
            make_codes(divided, true, *codes);
            make_nodes(divided, *codes);
        }
        return divided;
    }

    /// Waits once.
    FittedTree fit(std::shared_ptr<const DividedFaces> of_faces) {
        const DividedFaces& divided = *of_faces;
        FittedTree tree{std::move(of_faces), 0,
                        lease(std::max<std::size_t>(divided.node_count, 1) * sizeof(BinaryNode), "nodes of the tree"),
                        lease(count_ * sizeof(PlacedFace), "faces of the tree")};
        std::size_t box_count = count_;
        for (std::size_t level = count_; level >= CLSDF_JOINED_BOXES; box_count += level)
            level = chunk_count(level, CLSDF_JOINED_BOXES);
        const device::BufferPool::Lease boxes = lease(box_count * sizeof(FaceBox), "boxes of faces");
        device::LentKernel fit_faces = tools_.kernel(program_, "fit_faces"),
                           join = tools_.kernel(program_, "join_boxes");
        launch(tools_.queue(), fit_faces, {count_}, places_, lattice_, positions_, triangles_, *divided.order,
               **mesh_.polyhedra, **mesh_.faces, *boxes, *tree.faces);
        std::size_t from = 0;
        for (std::size_t level = count_; level >= CLSDF_JOINED_BOXES; level = chunk_count(level, CLSDF_JOINED_BOXES)) {
            launch(tools_.queue(), join, {chunk_count(level, CLSDF_JOINED_BOXES)}, static_cast<cl_uint>(level),
                   static_cast<cl_uint>(from), *boxes);
            from += level;
        }
        if (divided.node_count > 0) fit_nodes(divided, *boxes, *tree.nodes);
        found_ = device::read_value<PointFacesFound>(tools_.context, found_buffer_);
        const double side = longest_side();
        tree.area = side > 0 ? found_.area / (side * side) : 0;
        return tree;
    }

    /// The codes of the faces or, if is_ordered, of the places.
    void make_codes(const DividedFaces& divided, bool is_ordered, const cl::Buffer& codes) {
        device::LentKernel kernel = tools_.kernel(program_, "codes_of_faces");
        launch(tools_.queue(), kernel, {count_}, places_, lattice_, positions_, triangles_, cl_uint{is_ordered},
               *divided.order, codes);
    }

    /// Waits twice, for numbers of 8 and 4 bytes.
    void make_nodes(DividedFaces& divided, const cl::Buffer& codes) {
        const cl::CommandQueue& queue = tools_.queue();
        const device::BufferPool::Lease are_nodes = lease(count_ * sizeof(cl_uint), "nodes of the tree");
        const device::BufferPool::Lease starts = lease(count_ * sizeof(cl_uint), "nodes of the tree");
        device::LentKernel find = tools_.kernel(program_, "find_nodes"), link = tools_.kernel(program_, "link_nodes"),
                           measure = tools_.kernel(program_, "find_depth");
        launch(queue, find, {count_ - 1}, places_, codes, *are_nodes);
        PrefixSums sums(tools_, *are_nodes, *starts, count_ - 1, "nodes");
        divided.node_count = sums.total();
        divided.nodes = lease(divided.node_count * sizeof(NodePlaces), "nodes of the tree");
        const device::BufferPool::Lease parents = lease(divided.node_count * sizeof(cl_uint), "parents of nodes");
        launch(queue, link, {count_ - 1}, places_, divided.tree.leaf, codes, *starts, *divided.order, *divided.nodes,
               *parents);
        const device::BufferPool::Lease depth = lease(sizeof(cl_uint), "depth of the tree");
        queue.enqueueFillBuffer(*depth, cl_uint{0}, 0, sizeof(cl_uint));
        launch(queue, measure, {divided.node_count}, static_cast<cl_uint>(divided.node_count), *parents, *depth);
        divided.depth = device::read_value<cl_uint>(tools_.context, *depth);
    }

    void fit_nodes(const DividedFaces& divided, const cl::Buffer& boxes, const cl::Buffer& nodes) {
        const std::size_t groups =
            std::min<std::size_t>(chunk_count(divided.node_count, common_group), CLSDF_AREA_GROUPS);
        const device::BufferPool::Lease areas = lease(groups * sizeof(double), "areas of boxes");
        device::LentKernel kernel = tools_.kernel(program_, "fit_nodes");
        launch(tools_.queue(), kernel, {groups * common_group}, places_, static_cast<cl_uint>(divided.node_count),
               *divided.nodes, boxes, nodes, *areas);
        device::LentKernel join = tools_.kernel(program_, "join_areas");
        launch(tools_.queue(), join, {1}, static_cast<cl_uint>(groups), *areas, found_buffer_);
    }

    const DeviceTools& tools_;
    const PointFaces& mesh_;
    const cl::Buffer& positions_;
    const cl::Buffer& triangles_;
    const cl::Buffer& found_buffer_;
    PointFacesFound found_{};
    std::size_t count_;
    cl_uint places_;
    cl::Program program_;
    TreeLattice lattice_{};
};

device::BufferPool::Lease nothing_found(const DeviceTools& tools) {
    device::BufferPool::Lease found = tools.pool->lease(sizeof(PointFacesFound), "area of the tree and special faces");
    tools.queue().enqueueFillBuffer(*found, cl_uint{0}, 0, sizeof(PointFacesFound));
    return found;
}

}  // namespace

static_assert(deep_stack_entries == CLSDF_DEEPEST_TREE);

FittedTree fitted_tree(const DeviceTools& tools, const PointFaces& mesh, const cl::Buffer& positions,
                       const cl::Buffer& triangles, std::shared_ptr<const DividedFaces> before) {
    return device::guarded([&] {
        const device::BufferPool::Lease found = nothing_found(tools);
        return Making(tools, mesh, positions, triangles, *found).make(std::move(before));
    });
}

FacesAndTree make_faces_and_tree(const DeviceTools& tools, const Box& box, const std::string& name,
                                 const GeometryOnDevice& geometry, std::shared_ptr<const DividedFaces> before) {
    return device::guarded([&] {
        const device::BufferPool::Lease found = nothing_found(tools);
        PointFaces faces = make_point_faces(tools, box, name, geometry, *found);
        Making making(tools, faces, **geometry.positions, *geometry.topology->names->triangles, *found);
        FittedTree tree = making.make(std::move(before));
        faces.found = making.found();
        return FacesAndTree{std::move(faces), std::move(tree)};
    });
}

}  // namespace clsdf::engine
