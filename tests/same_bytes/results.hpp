#pragma once

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <clsdf/clsdf.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// Memory for the results of a call, on the host or on the device, and lines of text that state their bytes.
namespace clsdf::test {

inline const Device& the_device() {
    static const Device device = Device::automatic();
    return device;
}

inline void require(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    std::fprintf(stderr, "%s: OpenCL error %d\n", call, status);
    std::exit(2);
}

/// FNV-1a, 64 bits: arrays of one length that differ in one byte never share it.
class Hash {
public:
    void add(std::span<const std::byte> bytes) {
        for (const std::byte byte : bytes) value_ = (value_ ^ static_cast<std::uint64_t>(byte)) * 0x100000001b3U;
        bytes_ += bytes.size();
    }
    std::string text() const {
        std::array<char, 48> text{};
        std::snprintf(text.data(), text.size(), "%zu:%016llx", bytes_, static_cast<unsigned long long>(value_));
        return text.data();
    }

private:
    std::uint64_t value_ = 0xcbf29ce484222325U;
    std::size_t bytes_ = 0;
};

/// What a case printed: names, each with a number, or with the number of bytes and their hash.
class Line {
public:
    template <typename Value>
    void add(const std::string& name, const std::vector<Value>& values) {
        add(name, std::as_bytes(std::span(values)));
    }
    void add(const std::string& name, std::span<const std::byte> bytes) {
        Hash hash;
        hash.add(bytes);
        add(name, hash);
    }
    void add(const std::string& name, const Hash& hash) { text_ += ' ' + name + '=' + hash.text(); }
    void add(const std::string& name, std::size_t number) { text_ += ' ' + name + '=' + std::to_string(number); }
    const std::string& text() const { return text_; }

private:
    std::string text_;
};

/// Prints one line for a case. The kind of an error is a result, too.
template <class Run>
void print_case(const std::string& name, const Run& run) {
    Line line;
    std::string error;
    try {
        run(line);
    } catch (const Error& e) {
        error = std::string(" ") + name_of(e.code());
    }
    std::printf("%s:%s%s\n", name.c_str(), line.text().c_str(), error.c_str());
    std::fflush(stdout);
}

/// A buffer of the device.
class Buffer {
public:
    explicit Buffer(std::span<const std::byte> contents) : bytes_(contents.size()) {
        cl_int status = CL_SUCCESS;
        memory_.reset(::clCreateBuffer(the_device().context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes_,
                                       const_cast<std::byte*>(contents.data()), &status));
        require(status, "clCreateBuffer");
    }

    cl_mem memory() const { return memory_.get(); }
    std::vector<std::byte> read() const {
        std::vector<std::byte> contents(bytes_);
        require(::clEnqueueReadBuffer(the_device().queue(), memory(), CL_TRUE, 0, bytes_, contents.data(), 0, nullptr,
                                      nullptr),
                "clEnqueueReadBuffer");
        return contents;
    }

private:
    struct Release {
        void operator()(cl_mem memory) const { ::clReleaseMemObject(memory); }
    };
    std::unique_ptr<std::remove_pointer_t<cl_mem>, Release> memory_;
    std::size_t bytes_;
};

/// Where the arrays of a call lie, and how.
struct Layout {
    bool on_device = false;
    bool doubles = false;  ///< for the outputs that may be, and triangles as int32
    enum { packed, strided, planes } order = packed;
};

/// An array for each output of a box of samples or of a row of points. Bytes that the call does not write keep a
/// pattern.
class Results {
public:
    Results(OutputSet outputs, const Index3& size, const Layout& layout = {}) : layout_(layout) {
        for (const OutputInfo& info : output_table())
            if (info.output == Output::distance || outputs.contains(info.output)) add(info, size);
    }
    Results(OutputSet outputs, std::size_t points, const Layout& layout = {})
        : Results(outputs, Index3{static_cast<std::int64_t>(points), 1, 1}, layout) {}

    const OutputTargets& targets() const { return targets_; }

    /// All bytes of each array, or those of the first items of packed ones.
    void report(Line& line, std::size_t items = static_cast<std::size_t>(-1)) const {
        for (const Values& values : values_) {
            const std::vector<std::byte> bytes = layout_.on_device ? values.buffer.front().read() : values.bytes;
            line.add(values.name, std::span(bytes).first(std::min(bytes.size() / values.item, items) * values.item));
        }
    }

private:
    struct Values {
        std::string name;
        std::size_t item = 1;  ///< bytes; 1 unless the array is packed
        std::vector<std::byte> bytes;
        std::vector<Buffer> buffer;  ///< at most one
    };

    void add(const OutputInfo& info, const Index3& size) {
        ElementType type = info.type;
        if (layout_.doubles && type == ElementType::float32) type = ElementType::float64;
        if (layout_.doubles && type == ElementType::uint32) type = ElementType::int32;
        OutputArray array;
        array.type = type;
        const auto number = static_cast<std::ptrdiff_t>(bytes_of(type));
        const std::ptrdiff_t item = number * static_cast<std::ptrdiff_t>(info.components);
        std::ptrdiff_t total = item * size[0] * size[1] * size[2];
        if (layout_.order == Layout::planes) array.component_stride = number * size[0] * size[1] * size[2];
        if (layout_.order == Layout::strided) {
            const std::ptrdiff_t column = 2 * item, row = column * (size[0] + 3), slice = row * (size[1] + 1);
            array.offset = static_cast<std::size_t>(3 * number);
            if (size[1] == 1 && size[2] == 1) {
                array.strides = {column, 0, 0};
                total = 3 * number + column * size[0];
            } else {
                array.strides = {column, row, slice};
                total = 3 * number + slice * size[2];
            }
        }
        const bool is_packed = layout_.order == Layout::packed;
        Values values{info.name,
                      is_packed ? static_cast<std::size_t>(item) : 1,
                      std::vector<std::byte>(static_cast<std::size_t>(total), std::byte{0xA5}),
                      {}};
        if (layout_.on_device) {
            values.buffer.emplace_back(values.bytes);
            array.device = values.buffer.front().memory();
        } else {
            array.host = values.bytes.data();
            array.bytes = values.bytes.size();
        }
        targets_[info.output] = array;
        values_.push_back(std::move(values));
    }

    Layout layout_;
    std::vector<Values> values_;
    OutputTargets targets_;
};

}  // namespace clsdf::test
