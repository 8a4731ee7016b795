#include "version_text.hpp"

#include "commit.hpp"

#include <clsdf/version.hpp>

#include <fmt/format.h>

std::string version_text() {
    const std::string commit = CLSDF_COMMIT;
    return fmt::format(
        "clsdf {}{}\nbuilt with {} {}, CGAL {}, Eigen {}, cairo {}\n\"clsdf devices\" lists the OpenCL drivers.",
        clsdf::version(), commit.empty() ? "" : " (" + commit + ")", CLSDF_COMPILER, CLSDF_COMPILER_VERSION,
        CLSDF_CGAL_VERSION, CLSDF_EIGEN_VERSION, CLSDF_CAIRO_VERSION);
}
