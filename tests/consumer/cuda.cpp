#include <clsdf/clsdf.hpp>
#include <clsdf/cuda.hpp>

#include <iostream>
#include <string>

// A device that shares no memory with CUDA is refused by a message that says so; one that does has a number there.
int main() try {
    const clsdf::cuda::SharedDevice gpu(clsdf::Device::automatic());
    return gpu.ordinal() >= 0 ? 0 : 2;
} catch (const clsdf::Error& error) {
    std::cout << error.what() << '\n';
    const bool is_expected =
        error.code() == clsdf::ErrorCode::unsupported || error.code() == clsdf::ErrorCode::no_device;
    return is_expected && std::string(error.what()).find("CUDA") != std::string::npos ? 0 : 1;
}
