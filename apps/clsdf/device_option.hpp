#pragma once

#include <clsdf/device.hpp>

#include <CLI/CLI.hpp>

#include <string>

/// Adds --device, which sets `choice`; `does` describes the device's task: "what computes".
void add_device_option(CLI::App& parser, std::string& choice, const std::string& does);

/// The device that --device names, else Device::preferred(). Throws Error(no_device), which names the option if it
/// was given.
clsdf::Device open_device(const std::string& choice);
