#include "device_option.hpp"

#include "option_values.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

void add_device_option(CLI::App& parser, std::string& choice, const std::string& does) {
    parser.add_option("--device", choice, does + ", see \"clsdf devices\" [CLSDF_DEVICE, else the strongest]")
        ->check(not_empty())
        ->type_name("INDEX|NAME");
}

clsdf::Device open_device(const std::string& choice) {
    if (choice.empty()) return clsdf::Device::preferred();
    try {
        return clsdf::Device::select(choice);
    } catch (const clsdf::Error& error) {
        throw clsdf::Error(error.code(), fmt::format("--device {}: {}", choice, error.what()));
    }
}
