#include <clsdf/clsdf.hpp>

#include <chrono>
#include <iostream>
#include <string_view>

// The first field of a process: first_compute [--keep-records]. Prints its seconds, and whether programs were tested.
int main(int count, char** arguments) try {
    const clsdf::Device device = clsdf::Device::automatic();
    if (count == 2 && arguments[1] == std::string_view("--keep-records"))
        device.keep_records(clsdf::Device::default_record_folder());
    const clsdf::Mesh mesh = clsdf::make_shape("sphere3");
    const clsdf::Band band = clsdf::Band::symmetric(0.1);
    const clsdf::Grid grid = clsdf::Grid::around(mesh, 64, band);
    clsdf::TransformStatistics statistics;
    const auto begin = std::chrono::steady_clock::now();
    const clsdf::Field field = clsdf::DistanceTransform(device, mesh).compute(grid, band, {}, {}, &statistics);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    std::cout << "first field " << seconds.count() << " s, " << (statistics.first_use ? "tested" : "not tested")
              << '\n';
    return field.distance().size() == grid.sample_count() ? 0 : 1;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
