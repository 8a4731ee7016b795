// What comes to the host by way of pinned memory is complete, whoever is faster, the device or the host.
#include "disguise/as_gpu.hpp"

#include "device/context.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <thread>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

BOOST_TEST_GLOBAL_FIXTURE(AsGpu);

namespace {

using Words = std::vector<std::uint32_t>;
using Pinned = device::PinnedCopies;

constexpr std::size_t piece = Pinned::piece_bytes / sizeof(std::uint32_t), ring = Pinned::pieces_at_once * piece;

/// Words that are in memory of the device when an event of the caller has ended, in two parts.
struct Written {
    Written(const device::Context& context, const Words& words, std::size_t middle)
        : buffer(context.context(), CL_MEM_READ_WRITE, words.size() * sizeof(words[0])),
          writer(context.context(), context.device()) {
        const std::size_t parts[] = {0, middle, words.size()};
        for (std::size_t i = 0; i < 2; ++i) {
            begins.emplace_back(context.context());
            const std::vector<cl::Event> wait{begins.back()};
            cl::Event written;
            writer.enqueueWriteBuffer(buffer, CL_FALSE, parts[i] * sizeof(words[0]),
                                      (parts[i + 1] - parts[i]) * sizeof(words[0]), words.data() + parts[i], &wait,
                                      &written);
            milestones.push_back({parts[i + 1] * sizeof(words[0]), written});
        }
        writer.flush();
    }

    cl::Buffer buffer;
    cl::CommandQueue writer;
    std::vector<cl::UserEvent> begins;
    std::vector<device::Milestone> milestones;
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_read_while_it_is_computed_is_complete) {
    const device::Context& context = device::context_of(test_device());
    Words words(2 * ring + 3 * piece + 1234);
    std::iota(words.begin(), words.end(), 1U);
    for (const std::size_t count : {piece / 2, ring, words.size()})
        for (const std::size_t middle : {std::size_t{1}, count / 3, count - 1}) {
            const Words all(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(count));
            Written written(context, all, middle);
            const std::jthread device([&] {
                for (cl::UserEvent& begin : written.begins) {
                    std::this_thread::sleep_for(std::chrono::milliseconds(5));
                    begin.setStatus(CL_COMPLETE);
                }
            });
            Words copy(count, 0);
            context.read(context.transfers(), written.buffer, 0, count * sizeof(copy[0]),
                         reinterpret_cast<std::byte*>(copy.data()), false, written.milestones);
            BOOST_TEST((copy == all), count << " words, the first " << middle << " earlier");
        }
}

// Pieces arrive faster than the host copies them: the ring is full of what has arrived.
BOOST_AUTO_TEST_CASE(what_is_read_faster_than_the_host_copies_is_complete) {
    const device::Context& context = device::context_of(test_device());
    Words words(3 * ring + 1234);
    std::iota(words.begin(), words.end(), 1U);
    const cl::Buffer buffer(context.context(), CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                            words.size() * sizeof(words[0]), words.data());
    for (int round = 0; round < 3; ++round) {
        Words copy(words.size(), 0);
        context.read(context.queue(), buffer, 0, copy.size() * sizeof(copy[0]),
                     reinterpret_cast<std::byte*>(copy.data()));
        BOOST_TEST((copy == words));
    }
}
