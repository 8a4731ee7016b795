#pragma once

#include <clsdf/device.hpp>

#include "device/context.hpp"

#include <boost/test/unit_test.hpp>

#include <cstddef>
#include <string>
#include <vector>

/// Whether the host's and the device's compiler lay out the structs that they share alike.
namespace clsdf::test {

/// A number that both compilers must agree on; `expression` is OpenCL C.
struct Agreement {
    std::string name;
    std::size_t on_host;
    std::string expression;
};

// CLSDF_SHARED(agreements, type, member, ...): the size of the struct and the offsets of all its members.
#define CLSDF_AGREE_ON_MEMBER(to, type, member) \
    (to).push_back({#type "::" #member, offsetof(type, member), "(size_t)&((__global " #type "*)0)->" #member});
#define CLSDF_PARENTHESES ()
#define CLSDF_RESCAN_4(...) __VA_ARGS__
#define CLSDF_RESCAN_3(...) CLSDF_RESCAN_4(CLSDF_RESCAN_4(CLSDF_RESCAN_4(CLSDF_RESCAN_4(__VA_ARGS__))))
#define CLSDF_RESCAN_2(...) CLSDF_RESCAN_3(CLSDF_RESCAN_3(CLSDF_RESCAN_3(CLSDF_RESCAN_3(__VA_ARGS__))))
#define CLSDF_RESCAN(...) CLSDF_RESCAN_2(CLSDF_RESCAN_2(CLSDF_RESCAN_2(CLSDF_RESCAN_2(__VA_ARGS__))))
#define CLSDF_EACH_MEMBER(to, type, member, ...) \
    CLSDF_AGREE_ON_MEMBER(to, type, member)      \
    __VA_OPT__(CLSDF_EACH_MEMBER_AGAIN CLSDF_PARENTHESES(to, type, __VA_ARGS__))
#define CLSDF_EACH_MEMBER_AGAIN() CLSDF_EACH_MEMBER
#define CLSDF_SHARED(to, type, ...)                                           \
    (to).push_back({"sizeof(" #type ")", sizeof(type), "sizeof(" #type ")"}); \
    CLSDF_RESCAN(CLSDF_EACH_MEMBER(to, type, __VA_ARGS__))

/// Computes the expressions on the device, in a program that begins with `text`.
inline void check_agreements(const std::vector<Agreement>& agreements, std::string text) {
    text += "__kernel void measure(__global uint* found) {\n";
    for (std::size_t i = 0; i < agreements.size(); ++i)
        text += "    found[" + std::to_string(i) + "] = (uint)(" + agreements[i].expression + ");\n";
    text += "}\n";
    const Device device = Device::strongest();
    std::vector<cl_uint> found(agreements.size());
    device::guarded([&] {
        const device::Context& context = device::context_of(device);
        cl::Program program(context.context(), text);
        program.build(context.device(), "-cl-std=CL1.2");
        const std::size_t bytes = found.size() * sizeof(cl_uint);
        const cl::Buffer buffer(context.context(), CL_MEM_WRITE_ONLY, bytes);
        cl::Kernel kernel(program, "measure");
        kernel.setArg(0, buffer);
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        context.queue().enqueueReadBuffer(buffer, CL_TRUE, 0, bytes, found.data());
    });
    for (std::size_t i = 0; i < agreements.size(); ++i)
        BOOST_TEST_CONTEXT(agreements[i].name) BOOST_TEST(found[i] == agreements[i].on_host);
}

}  // namespace clsdf::test
