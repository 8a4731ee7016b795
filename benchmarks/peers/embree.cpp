// Embree: a closest-point query for each sample, limited by the distance of the sample before. The sign and the final
// distance are formed in double precision. Vertices are relative to the grid's centre, in voxels, so that Embree's
// floats round little.

#include "benchmarks/peers/for_each_listed.hpp"
#include "benchmarks/peers/pseudonormals.hpp"

#include "benchmarks/method.hpp"

#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace clsdf::bench {

namespace {

using VectorF = Eigen::Vector3f;

struct Vertices {
    Vec3 middle;
    double scale;

    explicit Vertices(const Workload& w)
        : middle(w.grid.position(w.grid.size[0] / 2, w.grid.size[1] / 2, w.grid.size[2] / 2)),
          scale(1 / w.grid.voxel()) {}
    explicit Vertices(const Mesh& mesh) : middle(mesh.box().lower), scale(256 / mesh.box().longest_side()) {
        for (std::size_t axis = 0; axis < 3; ++axis) middle[axis] = (middle[axis] + mesh.box().upper[axis]) / 2;
    }

    VectorF in_voxels(const Vec3& position) const {
        return {static_cast<float>((position[0] - middle[0]) * scale),
                static_cast<float>((position[1] - middle[1]) * scale),
                static_cast<float>((position[2] - middle[2]) * scale)};
    }
};

/// Embree's scene of the mesh, with the corners of the triangles beside it for the distances.
class Scene {
public:
    Scene(RTCDevice device, const Mesh& mesh, const Vertices& vertices, RTCSceneFlags flags = RTC_SCENE_FLAG_NONE)
        : scene_(rtcNewScene(device)) {
        rtcSetSceneFlags(scene_, flags);
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices().size()));
        auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles().size()));
        corners_.resize(3 * mesh.triangles().size());
        tbb::parallel_for(std::size_t{0}, mesh.vertices().size(), [&](std::size_t v) {
            const VectorF position = vertices.in_voxels(mesh.vertices()[v]);
            std::copy(position.data(), position.data() + 3, positions + 3 * v);
        });
        tbb::parallel_for(std::size_t{0}, mesh.triangles().size(), [&](std::size_t t) {
            for (std::size_t k = 0; k < 3; ++k) {
                indices[3 * t + k] = mesh.triangles()[t][k];
                corners_[3 * t + k] = VectorF(positions + std::size_t{3} * mesh.triangles()[t][k]);
            }
        });
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        rtcCommitScene(scene_);
    }
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    ~Scene() { rtcReleaseScene(scene_); }

    /// The closest triangle within the radius, which becomes the distance; none: the highest index there is.
    std::uint32_t closest(const VectorF& position, float& radius) const {
        Search search{corners_.data(), position, radius * radius, no_triangle};
        RTCPointQuery query{position[0], position[1], position[2], 0, radius};
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(scene_, &query, &context, &Scene::consider, &search);
        radius = std::sqrt(search.squared);
        return search.triangle;
    }

    /// The first triangle on a ray; the distance in lengths of the direction, or infinity.
    float first_hit(const VectorF& origin, const VectorF& direction) const {
        RTCRayHit ray{};
        ray.ray.org_x = origin[0];
        ray.ray.org_y = origin[1];
        ray.ray.org_z = origin[2];
        ray.ray.dir_x = direction[0];
        ray.ray.dir_y = direction[1];
        ray.ray.dir_z = direction[2];
        ray.ray.tfar = std::numeric_limits<float>::infinity();
        ray.ray.mask = std::numeric_limits<unsigned>::max();
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &ray);
        return ray.hit.geomID == RTC_INVALID_GEOMETRY_ID ? std::numeric_limits<float>::infinity() : ray.ray.tfar;
    }

private:
    struct Search {
        const VectorF* corners;
        VectorF position;
        float squared;
        std::uint32_t triangle;
    };

    static bool consider(RTCPointQueryFunctionArguments* arguments) {
        Search& search = *static_cast<Search*>(arguments->userPtr);
        const VectorF* corners = search.corners + std::size_t{3} * arguments->primID;
        const VectorF point = closest_point<float>(search.position, corners[0], corners[1], corners[2]).point;
        const float squared = (point - search.position).squaredNorm();
        if (!(squared <= search.squared)) return false;
        search.squared = squared;
        search.triangle = arguments->primID;
        arguments->query->radius = std::sqrt(squared);
        return true;
    }

    RTCScene scene_;
    std::vector<VectorF> corners_;
};

/// One thread's queries, each with the hint of the one before.
class Query {
public:
    Query(const Scene& scene, const Vertices& vertices, const Pseudonormals& normals, std::span<float> distance)
        : scene_(scene), vertices_(vertices), normals_(normals), distance_(distance) {}

    void operator()(const Vec3& position, std::size_t offset) {
        const VectorF query = vertices_.in_voxels(position);
        // The rounding of positions of up to a thousand voxels, and of the distance itself.
        float radius = (last_radius_ + (query - last_).norm()) * 1.0001F + 1e-3F;
        std::uint32_t triangle = scene_.closest(query, radius);
        if (triangle == no_triangle) {
            radius = std::numeric_limits<float>::infinity();
            triangle = scene_.closest(query, radius);
        }
        last_ = query;
        last_radius_ = radius;
        distance_[offset] = static_cast<float>(normals_.signed_distance(position, triangle));
    }

private:
    const Scene& scene_;
    const Vertices& vertices_;
    const Pseudonormals& normals_;
    std::span<float> distance_;
    VectorF last_ = VectorF::Zero();
    float last_radius_ = std::numeric_limits<float>::infinity();
};

class Embree final : public Method {
public:
    Embree() : device_(rtcNewDevice(nullptr)) {}
    ~Embree() override { rtcReleaseDevice(device_); }

    std::string name() const override { return "Embree"; }
    std::string note() const override { return "given the list of the samples"; }
    bool takes_list() const override { return true; }

    Cost compute(const Workload& workload, std::span<float> distance, std::size_t stride) override {
        const CostWatch watch;
        const Vertices vertices(workload);
        const Scene scene(device_, workload.mesh, vertices);
        const Pseudonormals normals(workload.mesh);
        const Cost set_up = watch.cost();
        for_each_listed(workload, stride, [&] { return Query(scene, vertices, normals, distance); });
        return set_up;
    }

private:
    RTCDevice device_;
};

/// Embree's device and scene, and the normals, for points.
struct PointScene {
    struct Device {
        RTCDevice device = rtcNewDevice(nullptr);
        Device() = default;
        Device(const Device&) = delete;
        Device& operator=(const Device&) = delete;
        ~Device() { rtcReleaseDevice(device); }
    };

    Device device;
    Vertices vertices;
    Scene scene;
    Pseudonormals normals;

    explicit PointScene(const Mesh& mesh) : vertices(mesh), scene(device.device, mesh, vertices), normals(mesh) {}
};

/// The same in Embree's robust mode, for rays.
struct RayScene {
    PointScene::Device device;
    Vertices vertices;
    Scene scene;

    explicit RayScene(const Mesh& mesh) : vertices(mesh), scene(device.device, mesh, vertices, RTC_SCENE_FLAG_ROBUST) {}
};

}  // namespace

PointPeer embree_points(const Mesh& mesh) {
    return [kept = std::make_shared<const PointScene>(mesh)](std::span<const Vec3> points, std::span<float> distance) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 256), [&](const auto& range) {
            Query query(kept->scene, kept->vertices, kept->normals, distance);
            for (std::size_t i = range.begin(); i != range.end(); ++i) query(points[i], i);
        });
    };
}

RayPeer embree_rays(const Mesh& mesh) {
    return [kept = std::make_shared<const RayScene>(mesh)](std::span<const Vec3> origins,
                                                           std::span<const Vec3> directions, std::span<double> t) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, origins.size(), 256), [&](const auto& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i) {
                VectorF direction;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    direction[static_cast<Eigen::Index>(axis)] =
                        static_cast<float>(directions[i][axis] * kept->vertices.scale);
                t[i] = static_cast<double>(kept->scene.first_hit(kept->vertices.in_voxels(origins[i]), direction));
            }
        });
    };
}

Entry embree_entry() {
    return {"embree", fmt::format("Embree {}", RTC_VERSION_STRING), "", std::make_unique<Embree>()};
}

}  // namespace clsdf::bench
