#include <clsdf/error.hpp>
#include <clsdf/papers.hpp>

#include <fmt/format.h>

// The names of the methods, and which go together. A command that is built without the methods knows these, too.

namespace clsdf {

const char* name_of(Polyhedra polyhedra) {
    switch (polyhedra) {
        case Polyhedra::peikert_sigg:
            return "peikert-sigg";
        case Polyhedra::mauch:
            return "mauch";
        default:
            return "leaned";
    }
}

const char* name_of(Scan scan) {
    switch (scan) {
        case Scan::bricks:
            return "bricks";
        case Scan::slices:
            return "slices";
        case Scan::brute_force:
            return "brute-force";
        default:
            return "auto";
    }
}

Scan resolve_scan(Polyhedra polyhedra, Scan asked) {
    if (polyhedra == Polyhedra::leaned) return asked == Scan::automatic ? Scan::bricks : asked;
    if (asked == Scan::brute_force)
        throw Error(ErrorCode::unsupported,
                    fmt::format("the scan \"brute-force\" asks every triangle at every sample and has no use for {} "
                                "polyhedra; leave them out",
                                name_of(polyhedra)));
    if (asked == Scan::bricks)
        throw Error(ErrorCode::unsupported,
                    fmt::format("the scan \"bricks\" is for leaned polyhedra: in a brick a triangle would count for "
                                "samples beyond its {} polyhedron; use the scan \"slices\"",
                                name_of(polyhedra)));
    return Scan::slices;
}

}  // namespace clsdf
