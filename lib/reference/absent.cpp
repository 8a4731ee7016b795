#include <clsdf/error.hpp>
#include <clsdf/reference.hpp>

// Replaces the library for a command that is built without GPL code: what needs the reference throws.

namespace clsdf::reference {
namespace {

[[noreturn]] void refuse() {
    throw Error(ErrorCode::unsupported,
                "this build of clsdf has no reference to compare with: it was made without CGAL's GPL parts; take the "
                "command of a clone of clsdf, which has them, or configure with -DCLSDF_BUILD_REFERENCE=ON and build "
                "again");
}

}  // namespace

struct Oracle::State {};

Oracle::Oracle(const Mesh&) {
    refuse();
}
Oracle::Oracle(Oracle&&) noexcept = default;
Oracle& Oracle::operator=(Oracle&&) noexcept = default;
Oracle::~Oracle() = default;

Nearest Oracle::nearest(const Vec3&) const {
    refuse();
}
std::optional<Nearest> Oracle::nearest_within(const Vec3&, double) const {
    refuse();
}
std::optional<int> Oracle::winding_number(const Vec3&) const {
    refuse();
}
std::optional<int> Oracle::crossings(const Vec3&) const {
    refuse();
}
std::vector<std::optional<RayCount>> Oracle::count_along_row(std::span<const double>, double, double) const {
    refuse();
}

Nearest nearest_on_triangle(const Vec3&, const Vec3&, const Vec3&, const Vec3&) {
    refuse();
}

Nearest nearest_by_brute_force(const Mesh&, const Vec3&) {
    refuse();
}

Field reference_field(const Mesh&, const Grid&, const Band&, SignRule, std::optional<double>) {
    refuse();
}

CheckReport check(const Mesh&, const Field&, const CheckOptions&) {
    refuse();
}

CheckReport check(std::span<const PlacedBody>, const Field&, const CheckOptions&) {
    refuse();
}

std::vector<CheckReport> check(const Mesh&, std::span<const Field>, const CheckOptions&) {
    refuse();
}

PointCheckReport check_points(const Mesh&, std::span<const Vec3>, const PointResults&, const PointCheckOptions&) {
    refuse();
}

std::vector<TrianglePair> find_self_intersections(const Mesh&) {
    refuse();
}

}  // namespace clsdf::reference
