#pragma once

#include "picture/canvas.hpp"

#include <boost/test/unit_test.hpp>

#include <cairo.h>

#include <cstdlib>
#include <cstring>
#include <string>

namespace clsdf::test {

inline picture::Raster read_png(const std::string& path) {
    cairo_surface_t* image = cairo_image_surface_create_from_png(path.c_str());
    BOOST_REQUIRE_MESSAGE(cairo_surface_status(image) == CAIRO_STATUS_SUCCESS, "unreadable: " << path);
    picture::Raster raster{cairo_image_surface_get_width(image), cairo_image_surface_get_height(image), {}};
    const auto width = static_cast<std::size_t>(raster.width);
    raster.pixels.resize(width * static_cast<std::size_t>(raster.height));
    const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(image));
    for (std::size_t row = 0; row < static_cast<std::size_t>(raster.height); ++row)
        std::memcpy(raster.pixels.data() + row * width, cairo_image_surface_get_data(image) + row * stride, width * 4);
    cairo_surface_destroy(image);
    return raster;
}

inline int part(std::uint32_t pixel, int shift) {
    return static_cast<int>(pixel >> static_cast<unsigned>(shift) & 0xFFU);
}

// The mean difference of a red, green or blue, 0 ... 255.
inline double mean_difference(const picture::Raster& one, const picture::Raster& other) {
    double sum = 0;
    for (std::size_t i = 0; i < one.pixels.size(); ++i)
        for (const int shift : {0, 8, 16}) sum += std::abs(part(one.pixels[i], shift) - part(other.pixels[i], shift));
    return sum / (3 * static_cast<double>(one.pixels.size()));
}

}  // namespace clsdf::test
