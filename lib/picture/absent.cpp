#include <clsdf/error.hpp>
#include <clsdf/picture.hpp>

// Replaces the library for a command that is built without cairo: what draws throws.

namespace clsdf::picture {
namespace {

[[noreturn]] void refuse() {
    throw Error(ErrorCode::unsupported,
                "this build of clsdf draws no pictures: it was made without cairo; configure with "
                "-DCLSDF_BUILD_PICTURE=ON and build again, or draw in Python with clsdf.slice_picture()");
}

}  // namespace

class Scene {};

const char* name_of(Axis) {
    refuse();
}

Axis parse_axis(const std::string&) {
    refuse();
}

void set_direction(View&, const std::string&) {
    refuse();
}

void set_up(View&, const std::string&) {
    refuse();
}

SlicePictures::SlicePictures(const Field& field, const Options&) : field_(field) {
    refuse();
}

Slice SlicePictures::middle(Axis) const {
    refuse();
}

void SlicePictures::write_slice(const Slice&, const std::string&) const {
    refuse();
}

void SlicePictures::write_mosaic(const Index3&, const std::string&) const {
    refuse();
}

void SlicePictures::check_path(const std::string&) {
    refuse();
}

SurfacePictures::SurfacePictures(const Field&, const Device&, std::optional<double>) {
    refuse();
}
SurfacePictures::SurfacePictures(SurfacePictures&&) noexcept = default;
SurfacePictures& SurfacePictures::operator=(SurfacePictures&&) noexcept = default;
SurfacePictures::~SurfacePictures() = default;

double SurfacePictures::offset() const {
    refuse();
}

Axis SurfacePictures::upright() const {
    refuse();
}

Hits SurfacePictures::hits(const SurfaceOptions&) const {
    refuse();
}

void SurfacePictures::write(const SurfaceOptions&, const std::string&) const {
    refuse();
}

void SurfacePictures::check_path(const std::string&) {
    refuse();
}

}  // namespace clsdf::picture
