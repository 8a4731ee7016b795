#include <clsdf/error.hpp>
#include <clsdf/method.hpp>

#include <fmt/format.h>

#include <array>
#include <utility>

namespace clsdf {

namespace {

constexpr std::array<std::pair<Polyhedra, const char*>, 3> polyhedra_names{
    {{Polyhedra::leaned, "leaned"}, {Polyhedra::peikert_sigg, "peikert-sigg"}, {Polyhedra::mauch, "mauch"}}};
constexpr std::array<std::pair<Scan, const char*>, 3> scan_names{
    {{Scan::automatic, "auto"}, {Scan::bricks, "bricks"}, {Scan::slices, "slices"}}};

}  // namespace

const char* name_of(Polyhedra polyhedra) {
    for (const auto& [kind, name] : polyhedra_names)
        if (kind == polyhedra) return name;
    return "";
}

const char* name_of(Scan scan) {
    for (const auto& [kind, name] : scan_names)
        if (kind == scan) return name;
    return "";
}

Scan resolve_scan(Polyhedra polyhedra, Scan asked) {
    if (polyhedra == Polyhedra::leaned) return asked == Scan::automatic ? Scan::bricks : asked;
    if (asked == Scan::bricks)
        throw Error(ErrorCode::unsupported,
                    fmt::format("the scan \"bricks\" is for leaned polyhedra: in a brick a triangle would count for "
                                "samples beyond its {} polyhedron; use the scan \"slices\"",
                                name_of(polyhedra)));
    return Scan::slices;
}

}  // namespace clsdf
