#include "scenes/point_outputs.hpp"

#include "core/vectors.hpp"

#include <cmath>
#include <cstring>

namespace clsdf::scenes {

namespace {

void store_numbers(const double* numbers, std::size_t components, const targets::HostArray& to, std::size_t at) {
    for (std::size_t c = 0; c < components; ++c) {
        const std::size_t place = at * components + c;
        const auto rounded = static_cast<float>(numbers[c]);
        if (to.in_double)
            std::memcpy(to.data + place * sizeof(double), numbers + c, sizeof(double));
        else
            std::memcpy(to.data + place * sizeof(float), &rounded, sizeof(float));
    }
}

}  // namespace

Outputs::Outputs(const targets::HostArrays& wanted) : wanted_(wanted) {
    std::size_t used = 0;
    for_each_output(
        [&](const OutputInfo& info, targets::HostArray& array, const targets::HostArray& asked) {
            // The distance is NaN unless it is written, and the closest point beyond the half width.
            array.is_wanted = asked.is_wanted || info.output == Output::distance || info.output == Output::closest;
            array.in_double = may_be_double(info);
            array.data = reinterpret_cast<std::byte*>(room_.data() + used);
            used += info.components;
        },
        arrays_, wanted);
}

Vec3 Outputs::closest() const {
    Vec3 result;
    std::memcpy(result.data(), arrays_[Output::closest].data, sizeof result);
    return result;
}

bool Outputs::store(const SearchedBody* body, const Found& found, const Vec3& point, const HalfWidths& half_widths,
                    std::size_t at) {
    bool is_within = false;
    if (found.face != CLSDF_NO_FACE) {
        const Vec3 in_units = mesh_of(*body).in_units(body->frame->to_body(point));
        points::finish_on_host(*body->shape->finishing, in_units, found.face, found.sign, half_widths.of(found.body),
                               arrays_);
        is_within = is_finite(closest());
    }
    if (is_within) {
        std::memcpy(arrays_[Output::body].data, &found.body, sizeof found.body);
        turn(Output::closest, *body->frame);
        if (wanted_[Output::gradient].is_wanted) turn(Output::gradient, *body->frame);
        if (wanted_[Output::offset].is_wanted) turn(Output::offset, *body->frame);
        copy(at);
    } else {
        leave(found.is_inside() ? -half_widths.greatest : half_widths.greatest, at);
    }
    return is_within;
}

void Outputs::store_cut(const SearchedBody& body, std::uint32_t number, std::uint32_t face, const Vec3& point,
                        const Vec3& closest, double distance, std::size_t at) {
    // Triangle and weights are those of the closest point itself.
    points::finish_on_host(*body.shape->finishing, mesh_of(body).in_units(body.frame->to_body(closest)), face,
                           CLSDF_POINT_INSIDE, std::numeric_limits<double>::infinity(), arrays_);
    const auto set = [&](Output output, const auto& value) { std::memcpy(arrays_[output].data, &value, sizeof value); };
    const Vec3 offset = difference(closest, point);
    set(Output::body, number);
    set(Output::distance, -distance);
    set(Output::closest, closest);
    set(Output::offset, offset);
    set(Output::gradient, Vec3{offset[0] / distance, offset[1] / distance, offset[2] / distance});
    std::uint8_t site = 0;
    std::memcpy(&site, arrays_[Output::site].data, sizeof site);
    if (site == CLSDF_SITE_OF_FACE) set(Output::site, std::uint8_t{CLSDF_SITE_OF_CUT});
    copy(at);
}

void Outputs::leave(double distance, std::size_t at) const {
    for_each_output(
        [&](const OutputInfo& info, const targets::HostArray& to) {
            if (to.data == nullptr) return;
            const std::size_t bytes = sample_bytes(info, to.in_double);
            if (info.output != Output::distance)
                std::memset(to.data + at * bytes, 0xFF, bytes);
            else
                store_numbers(&distance, 1, to, at);
        },
        wanted_);
}

void Outputs::turn(Output output, const Frame& frame) {
    Vec3 vector;
    std::memcpy(vector.data(), arrays_[output].data, sizeof vector);
    vector = output == Output::closest ? frame.to_scene(vector) : frame.turned(vector);
    std::memcpy(arrays_[output].data, vector.data(), sizeof vector);
}

void Outputs::copy(std::size_t at) const {
    for_each_output(
        [&](const OutputInfo& info, const targets::HostArray& from, const targets::HostArray& to) {
            if (to.data == nullptr) return;
            if (!may_be_double(info)) {
                const std::size_t bytes = sample_bytes(info, true);
                std::memcpy(to.data + at * bytes, from.data, bytes);
                return;
            }
            std::array<double, 3> numbers;
            std::memcpy(numbers.data(), from.data, info.components * sizeof(double));
            // As finish_point() rounds: a distance that is not 0 stays so.
            constexpr double least = std::numeric_limits<float>::denorm_min();
            if (info.output == Output::distance && !to.in_double && numbers[0] != 0 &&
                static_cast<float>(numbers[0]) == 0)
                numbers[0] = std::copysign(least, numbers[0]);
            store_numbers(numbers.data(), info.components, to, at);
        },
        arrays_, wanted_);
}

}  // namespace clsdf::scenes
