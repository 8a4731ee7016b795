#include "device/context.hpp"
#include "support/temporary_folder.hpp"
#include "support/throws.hpp"

#include <clsdf/device.hpp>

#include <fmt/format.h>
#include <boost/test/unit_test.hpp>

#include <filesystem>
#include <numeric>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

namespace fs = std::filesystem;

constexpr const char* options = "-cl-std=CL1.2 -DLANES=1";

/// Whether the program works: the sum of 1, 2, ..., 10.
bool computes(const Device& device, const cl::Program& program) {
    return device::guarded([&] {
        const device::Context& context = device::context_of(device);
        std::vector<cl_uint> values(10);
        std::iota(values.begin(), values.end(), 1U);
        const cl::Buffer in(context.context(), CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(cl_uint),
                            values.data());
        const cl::Buffer sums(context.context(), CL_MEM_READ_WRITE, 2 * sizeof(cl_ulong));
        cl::Kernel kernel(program, "scan_sums");
        kernel.setArg(0, cl_uint{10});
        kernel.setArg(1, in);
        kernel.setArg(2, sums);
        context.queue().enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(1));
        cl_ulong sum = 0;
        context.queue().enqueueReadBuffer(sums, CL_TRUE, 0, sizeof sum, &sum);
        return sum == 55;
    });
}

/// Whether a program of the device is compiled from its source. It must work.
bool compiles(const Device& device, const std::string& with = options) {
    bool is_compiled = false;
    const cl::Program program = device::context_of(device).program({"scan.cl", with}, {[&] { is_compiled = true; }});
    BOOST_TEST(computes(device, program));
    return is_compiled;
}

Device writer(const std::string& folder) {
    const Device device = Device::strongest();
    device.write_programs(folder);
    return device;
}

Device reader(const std::string& folder) {
    const Device device = Device::strongest();
    device.read_programs(folder);
    return device;
}

std::vector<fs::path> files_in(const std::string& folder) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    return files;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(prepared_programs)

BOOST_AUTO_TEST_CASE(are_taken_in_place_of_compiling) {
    const TemporaryFolder scratch;
    const std::string folder = scratch.file("deep") + "/er";
    BOOST_TEST(compiles(writer(folder)));
    BOOST_TEST(files_in(folder).size() == 1U);
    BOOST_TEST(!compiles(reader(folder)));
    BOOST_TEST(!compiles(reader(folder).limited({.memory = 1U << 30U})));
    BOOST_TEST(compiles(reader(folder), fmt::format("{} -DOTHER", options)));
    BOOST_TEST(files_in(folder).size() == 1U, "a reader writes nothing");
    BOOST_TEST(compiles(writer(folder)), "a writer reads nothing");
    BOOST_TEST(compiles(Device::strongest()));
}

BOOST_AUTO_TEST_CASE(that_are_damaged_or_that_the_driver_refuses_are_compiled) {
    const TemporaryFolder scratch;
    const std::string folder = scratch.file("programs");
    compiles(writer(folder));
    const fs::path path = files_in(folder).at(0);
    const std::string whole = content_of(path.string());
    // The key lies behind 42 bytes, which end with its size.
    const std::string key = whole.substr(42, std::stoul(whole.substr(25, 16), nullptr, 16));
    const device::Records records(folder, ".program");
    BOOST_REQUIRE(records.has(key));
    records.store(key, "no program");
    const std::string refused = content_of(path.string());
    std::string damaged = whole;
    damaged[damaged.size() / 2] ^= 1;
    for (const std::string& content : {refused, damaged, whole.substr(0, whole.size() / 2), std::string()}) {
        scratch.file("programs/" + path.filename().string(), content);
        BOOST_TEST(compiles(reader(folder)));
        BOOST_TEST(content_of(path.string()) == content);
    }
    compiles(writer(folder));
    BOOST_TEST(content_of(path.string()).size() == whole.size());
    BOOST_TEST(!compiles(reader(folder)));
}

BOOST_AUTO_TEST_CASE(need_a_folder_to_be_written_and_none_to_be_read) {
    const TemporaryFolder scratch;
    const std::string file = scratch.file("file", "no folder");
    for (const std::string& folder : {file, file + "/below", std::string("/proc/clsdf")}) {
        check_throws(ErrorCode::output_failure, {"cannot write", folder}, [&] { compiles(writer(folder)); });
        BOOST_TEST(compiles(reader(folder)));
    }
    BOOST_TEST(compiles(writer("")));
    BOOST_TEST(scratch.file_count() == 1U);
}

BOOST_AUTO_TEST_SUITE_END()
