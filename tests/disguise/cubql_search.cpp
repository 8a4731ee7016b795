#include "disguise/cubql_search.hpp"

#include <cuBQL/bvh.h>
#include <cuBQL/math/conservativeDistances.h>
#include <cuBQL/queries/triangleData/math/pointToTriangleDistance.h>

#include <vector>

namespace {

clsdf::test::CubqlWork work;

}  // namespace

// The two functions that a search calls, counted.
namespace cuBQL {

static float counted_distance(vec3f point, box3f box) {
    ++work.boxes;
    return fSqrDistance_rd(point, box);
}

namespace triangles {

static bool counted_closest_point(PointToTriangleTestResult& found, Triangle triangle, vec3f point) {
    ++work.faces;
    return computeClosestPoint(found, triangle, point);
}

}  // namespace triangles

}  // namespace cuBQL

#define fSqrDistance_rd counted_distance
#define computeClosestPoint counted_closest_point
#include <cuBQL/queries/triangleData/closestPointOnAnyTriangle.h>
#undef fSqrDistance_rd
#undef computeClosestPoint

namespace clsdf::test {

namespace {

cuBQL::vec3f in_float(const Vec3& p) {
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

}  // namespace

CubqlWork search_by_cubql(const Mesh& mesh, std::span<const Vec3> points) {
    static_assert(sizeof(cuBQL::bvh3f::Node) == bytes_of_cubql_box);
    static_assert(sizeof(cuBQL::Triangle) + sizeof *cuBQL::bvh3f::primIDs == bytes_of_cubql_face);
    std::vector<cuBQL::Triangle> triangles;
    std::vector<cuBQL::box3f> boxes;
    for (const auto& [a, b, c] : mesh.triangles()) {
        triangles.push_back({in_float(mesh.vertices()[a]), in_float(mesh.vertices()[b]), in_float(mesh.vertices()[c])});
        boxes.push_back(triangles.back().bounds());
    }
    cuBQL::bvh3f tree;
    cuBQL::cpuBuilder(tree, boxes.data(), static_cast<std::uint32_t>(boxes.size()), cuBQL::BuildConfig());
    work = {};
    for (const Vec3& point : points) {
        cuBQL::triangles::CPAT found;
        found.runQuery(triangles.data(), tree, in_float(point));
    }
    cuBQL::cpu::freeBVH(tree);
    return work;
}

}  // namespace clsdf::test
