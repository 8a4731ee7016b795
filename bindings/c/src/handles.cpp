#include "handles.hpp"

namespace clsdf::c {

const char* name_of(Kind kind) noexcept {
    switch (kind) {
        case Kind::devices:
            return "list of devices";
        case Kind::device:
            return "device";
        case Kind::mesh:
            return "mesh";
        case Kind::transform:
            return "transform";
        case Kind::plan:
            return "plan";
        case Kind::point_plan:
            return "plan of points";
        case Kind::field:
            return "field";
        case Kind::points:
            return "points";
        case Kind::thread_limit:
            return "thread limit";
        case Kind::field_writer:
            return "field writer";
        case Kind::sparse_field:
            return "sparse field";
        case Kind::sparse_writer:
            return "sparse writer";
        case Kind::link_plan:
            return "plan of links";
        case Kind::sparse_plan:
            return "sparse plan";
        case Kind::scene:
            return "scene";
        case Kind::cuda_device:
            return "device of CUDA";
        case Kind::cuda_memory:
            return "memory of CUDA";
        case Kind::cuda_arrays:
            return "list of arrays of CUDA";
    }
    return "kind that is not known";
}

}  // namespace clsdf::c
