#include <clsdf/error.hpp>
#include <clsdf/papers.hpp>

#include <fmt/format.h>

#include <utility>

// Replaces the library for a command that is built without the published methods. Leaned polyhedra by bricks are the
// core's, and need none of them.

namespace clsdf {
namespace {

[[noreturn]] void refuse(const char* what) {
    throw Error(ErrorCode::unsupported,
                fmt::format("this build of clsdf has no {}: it was made without the published methods; configure with "
                            "-DCLSDF_BUILD_PAPERS=ON and build again",
                            what));
}

}  // namespace

DistanceTransform make_transform(Device device, const Mesh& mesh, const PapersOptions& method,
                                 const TransformOptions& options, const CallOptions& call) {
    const Scan scan = resolve_scan(method.polyhedra, method.scan);
    if (scan == Scan::bricks) return {std::move(device), mesh, options, call};
    if (scan == Scan::brute_force) refuse("scan by brute force");
    refuse(fmt::format("{} polyhedra scanned by slices", name_of(method.polyhedra)).c_str());
}

Classification classify_convexity(const Mesh&) {
    refuse("classification of edges and vertices");
}

SaddleReport examine_saddles(const Mesh&) {
    refuse("examination of saddle vertices");
}

std::vector<std::uint32_t> triangles_at(const Mesh&, std::uint32_t) {
    refuse("bounding polyhedra as meshes");
}

std::vector<BoundingSolid> leaned_solids(const Mesh&, std::span<const std::uint32_t>, double) {
    refuse("bounding polyhedra as meshes");
}

std::vector<BoundingSolid> peikert_sigg_solids(const Mesh&, std::span<const std::uint32_t>, double, bool) {
    refuse("bounding polyhedra as meshes");
}

SoftwareScanCounts software_scan(const Mesh&, const Grid&, double, std::size_t, std::span<float>) {
    refuse("scan of Mauch's polyhedra in software");
}

}  // namespace clsdf
