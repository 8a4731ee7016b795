// CGAL: an AABB tree in double precision; each query starts from the closest point of the sample before.

#include "benchmarks/peers/for_each_listed.hpp"
#include "benchmarks/peers/pseudonormals.hpp"

#include "benchmarks/method.hpp"
#include "reference/aabb_tree.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/version.h>
#include <fmt/format.h>

#include <optional>

namespace clsdf::bench {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = reference::AabbTriangle<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<reference::AabbTraits<Kernel, Primitive>>;

class Query {
public:
    Query(const Tree& tree, const Triangles& triangles, const Pseudonormals& normals, std::span<float> distance)
        : tree_(tree), triangles_(triangles), normals_(normals), distance_(distance) {}

    void operator()(const Vec3& position, std::size_t offset) {
        const Point query(position[0], position[1], position[2]);
        if (!last_) last_ = Tree::Point_and_primitive_id(triangles_.front().vertex(0), triangles_.begin());
        last_ = tree_.closest_point_and_primitive(query, *last_);
        const auto triangle = static_cast<std::uint32_t>(last_->second - triangles_.begin());
        distance_[offset] = static_cast<float>(normals_.signed_distance(position, triangle));
    }

private:
    const Tree& tree_;
    const Triangles& triangles_;
    const Pseudonormals& normals_;
    std::span<float> distance_;
    std::optional<Tree::Point_and_primitive_id> last_;
};

class CgalTree final : public Method {
public:
    std::string name() const override { return "CGAL"; }
    std::string note() const override { return "given the list of the samples"; }
    bool takes_list() const override { return true; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t stride) override {
        const CostWatch watch;
        const Mesh& mesh = workload.mesh;
        Triangles triangles;
        triangles.reserve(mesh.triangles().size());
        const auto point = [&](std::uint32_t v) {
            const Vec3& p = mesh.vertices()[v];
            return Point(p[0], p[1], p[2]);
        };
        for (const Triangle& t : mesh.triangles()) triangles.emplace_back(point(t[0]), point(t[1]), point(t[2]));
        Tree tree(triangles.cbegin(), triangles.cend());
        tree.do_not_accelerate_distance_queries();  // the sample before is the better hint
        tree.build();
        const Pseudonormals normals(mesh);
        const Cost set_up = watch.cost();
        for_each_listed(workload, stride, [&] { return Query(tree, triangles, normals, distance); });
        return set_up;
    }
};

}  // namespace

Entry cgal_entry() {
    return {"cgal", fmt::format("CGAL {}", CGAL_VERSION_STR), "", std::make_unique<CgalTree>()};
}

}  // namespace clsdf::bench
