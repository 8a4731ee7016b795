// The fixed numbers of the header are those of the C++ enumerators; names, and the table of outputs.
#include "handles.hpp"
#include "values.hpp"

#include <clsdf/error.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/topology.hpp>
#include <clsdf/version.hpp>  // the compiler refuses other numbers of the version than those of clsdf.h

namespace {

using namespace clsdf;

template <typename Enum>
constexpr bool is(Enum enumerator, std::int32_t number) {
    return static_cast<std::int32_t>(enumerator) == number;
}

static_assert(is(ErrorCode::invalid_mesh, CLSDF_INVALID_MESH) &&
              is(ErrorCode::unreadable_input, CLSDF_UNREADABLE_INPUT) &&
              is(ErrorCode::invalid_argument, CLSDF_INVALID_ARGUMENT) && is(ErrorCode::no_device, CLSDF_NO_DEVICE) &&
              is(ErrorCode::device_failure, CLSDF_DEVICE_FAILURE) &&
              is(ErrorCode::out_of_memory, CLSDF_OUT_OF_MEMORY) && is(ErrorCode::unsupported, CLSDF_UNSUPPORTED) &&
              is(ErrorCode::cancelled, CLSDF_CANCELLED) && is(ErrorCode::output_failure, CLSDF_OUTPUT_FAILURE) &&
              is(ErrorCode::wrong_results, CLSDF_WRONG_RESULTS));
static_assert(is(ElementType::automatic, CLSDF_AUTOMATIC) && is(ElementType::float32, CLSDF_FLOAT32) &&
              is(ElementType::float64, CLSDF_FLOAT64) && is(ElementType::int32, CLSDF_INT32) &&
              is(ElementType::int64, CLSDF_INT64) && is(ElementType::uint32, CLSDF_UINT32) &&
              is(ElementType::uint64, CLSDF_UINT64) && is(ElementType::uint8, CLSDF_UINT8));
static_assert(is(Output::distance, CLSDF_DISTANCE) && is(Output::triangle, CLSDF_TRIANGLE) &&
              is(Output::site, CLSDF_SITE) && is(Output::closest, CLSDF_CLOSEST) &&
              is(Output::gradient, CLSDF_GRADIENT) && is(Output::barycentric, CLSDF_BARYCENTRIC) &&
              is(Output::offset, CLSDF_OFFSET) && is(Output::body, CLSDF_BODY));
static_assert(is(SignRule::automatic, CLSDF_SIGN_AUTOMATIC) && is(SignRule::nonzero, CLSDF_SIGN_NONZERO) &&
              is(SignRule::parity, CLSDF_SIGN_PARITY) && is(SignRule::none, CLSDF_SIGN_NONE) &&
              is(SignRule::solid_angle, CLSDF_SIGN_SOLID_ANGLE) && is(SignRule::below, CLSDF_SIGN_BELOW));
static_assert(is(Surface::given, CLSDF_SURFACE_GIVEN) && is(Surface::outer, CLSDF_SURFACE_OUTER));
static_assert(is(BoxPlace::within, CLSDF_WITHIN) && is(BoxPlace::inside, CLSDF_INSIDE) &&
              is(BoxPlace::outside, CLSDF_OUTSIDE) && is(BoxPlace::beyond, CLSDF_BEYOND));
static_assert(is(DeviceSource::registered, CLSDF_REGISTERED) && is(DeviceSource::bundled, CLSDF_BUNDLED) &&
              is(DeviceSource::unregistered, CLSDF_UNREGISTERED) && is(DeviceSource::device_file, CLSDF_DEVICE_FILE));
static_assert(is(DeviceKind::gpu, CLSDF_GPU) && is(DeviceKind::processor, CLSDF_PROCESSOR) &&
              is(DeviceKind::accelerator, CLSDF_ACCELERATOR) && is(DeviceKind::other, CLSDF_OTHER_DEVICE));
static_assert(is(Length::Unit::mesh, CLSDF_MESH_UNITS) && is(Length::Unit::voxels, CLSDF_VOXELS) &&
              is(Length::Unit::extent, CLSDF_EXTENT));
static_assert(is(Progress::Stage::compiling, CLSDF_COMPILING) && is(Progress::Stage::computing, CLSDF_COMPUTING) &&
              is(Progress::Stage::testing, CLSDF_TESTING));
static_assert(sizeof(clsdf_status) == sizeof(ErrorCode));

template <typename Enum>
const char* name_within(std::int32_t number, Enum last) {
    return number >= 0 && number <= static_cast<std::int32_t>(last) ? name_of(static_cast<Enum>(number)) : "unknown";
}

}  // namespace

std::int64_t clsdf_version() {
    return CLSDF_VERSION;
}

const char* clsdf_version_text() {
    static const std::string text = clsdf::version();
    return text.c_str();
}

const char* clsdf_status_name(clsdf_status status) {
    if (status == CLSDF_OK) return "ok";
    return status == CLSDF_UNEXPECTED ? "unexpected" : name_of(static_cast<ErrorCode>(status));
}
const char* clsdf_type_name(std::int32_t type) {
    return type == CLSDF_AUTOMATIC ? "automatic" : name_within(type, ElementType::uint8);
}
const char* clsdf_sign_name(std::int32_t rule) {
    return name_within(rule, SignRule::below);
}
const char* clsdf_device_kind_name(std::int32_t kind) {
    return name_within(kind, DeviceKind::other);
}
const char* clsdf_device_source_name(std::int32_t source) {
    return name_within(source, DeviceSource::device_file);
}

std::int64_t clsdf_output_count() {
    return static_cast<std::int64_t>(output_table().back().output) + 1;
}

clsdf_status clsdf_output_describe(std::int32_t output, clsdf_output_info* info) {
    return c::guarded([&] {
        const OutputInfo& row = info_of(static_cast<Output>(output));
        const clsdf_output_info result{sizeof result,
                                       output,
                                       static_cast<std::int32_t>(row.type),
                                       static_cast<std::int64_t>(row.components),
                                       row.name,
                                       row.description};
        c::write_given(result, info, "clsdf_output_info");
    });
}

#define CLSDF_REFERENCES(name)                          \
    void clsdf_##name##_retain(clsdf_##name* handle) {  \
        c::retain(handle);                              \
    }                                                   \
    void clsdf_##name##_release(clsdf_##name* handle) { \
        c::release(handle);                             \
    }
CLSDF_REFERENCES(devices)
CLSDF_REFERENCES(device)
CLSDF_REFERENCES(mesh)
CLSDF_REFERENCES(transform)
CLSDF_REFERENCES(scene)
CLSDF_REFERENCES(plan)
CLSDF_REFERENCES(point_plan)
CLSDF_REFERENCES(link_plan)
CLSDF_REFERENCES(field)
CLSDF_REFERENCES(sparse_field)
CLSDF_REFERENCES(sparse_plan)
CLSDF_REFERENCES(points)
