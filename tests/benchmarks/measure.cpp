#include "small_workload.hpp"

#include "benchmarks/memory.hpp"

#include <boost/test/unit_test.hpp>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>
#include <thread>

using namespace clsdf;
using namespace clsdf::bench;
using clsdf::test::small_workload;

namespace {

/// Waits: `set_up` seconds, and `per_brick` for each brick that it is asked for.
class Waits : public Method {
public:
    Waits(std::string name, double set_up, double per_brick, std::string& calls)
        : name_(std::move(name)), set_up_(set_up), per_brick_(per_brick), calls_(calls) {}

    std::string name() const override { return name_; }
    std::string note() const override { return ""; }
    bool takes_list() const override { return per_brick_ > 0; }
    bool gets_every_call() const override { return name_ == "ours"; }

    Cost compute(const Workload& workload, std::span<float>, std::size_t stride) override {
        calls_ += name_;
        const CostWatch watch;
        wait(set_up_);
        const Cost set_up = watch.cost();
        const std::size_t bricks = (workload.list.bricks() + stride - 1) / stride;
        wait(per_brick_ * static_cast<double>(bricks));
        return set_up;
    }

private:
    static void wait(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

    std::string name_;
    double set_up_, per_brick_;
    std::string& calls_;
};

}  // namespace

BOOST_AUTO_TEST_SUITE(measuring)

BOOST_AUTO_TEST_CASE(methods_are_timed_in_turns_after_they_were_warmed_up) {
    std::string calls;
    Waits a("a", 0.001, 0, calls), b("b", 0.001, 0, calls);
    MeasureOptions options = test::every_sample();
    options.repetitions = 3;
    const std::vector<Measurement> found = measure_in_turns(small_workload(), {&a, &b}, options);
    BOOST_TEST(calls == "abababab");
    BOOST_TEST(found[0].wall.size() == 3U);
    BOOST_TEST(found[1].processor.size() == 3U);
}

BOOST_AUTO_TEST_CASE(a_part_of_the_bricks_is_scaled_to_all_of_them_and_the_set_up_is_not) {
    const Workload workload = small_workload();
    const auto bricks = static_cast<double>(workload.list.bricks());
    const double whole = 0.2;
    std::string calls;
    const double set_up = 0.3;
    Waits slow("slow", set_up, whole / bricks, calls);
    MeasureOptions options = test::every_sample();
    options.seconds_per_call = 0.08;
    const Measurement found = test::measure(workload, slow, options);
    BOOST_TEST(found.stride > 1U);
    // The least, with room for a busy machine: scaled with the bricks, the set-up alone would take three times as long.
    BOOST_TEST(spread_of(found.wall).least > 0.9 * (set_up + whole));
    BOOST_TEST(spread_of(found.wall).least < 3 * set_up);
}

BOOST_AUTO_TEST_CASE(a_slow_method_gets_fewer_calls_but_three_and_ours_gets_all) {
    std::string calls;
    Waits slow("slow", 0.02, 0, calls), slower("slower", 0.2, 0, calls), ours("ours", 0.02, 0, calls);
    MeasureOptions options = test::every_sample();
    options.repetitions = 7;
    options.seconds_per_method = 0.12;
    const std::vector<Measurement> found = measure_in_turns(small_workload(), {&slow, &slower, &ours}, options);
    BOOST_TEST(found[0].wall.size() >= 3U);
    BOOST_TEST(found[0].wall.size() < 7U);
    BOOST_TEST(found[1].wall.size() == 3U);
    BOOST_TEST(found[2].wall.size() == 7U);
}

BOOST_AUTO_TEST_CASE(the_median_of_an_even_number_lies_between_the_middle_ones) {
    const Spread spread = spread_of({4, 1, 3, 2});
    BOOST_TEST(spread.least == 1);
    BOOST_TEST(spread.median == 2.5);
    BOOST_TEST(spread.most == 4);
}

BOOST_AUTO_TEST_CASE(processor_time_counts_all_threads_and_no_sleep) {
    const CostWatch asleep;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    BOOST_TEST(asleep.cost().wall > 0.19);
    BOOST_TEST(asleep.cost().processor < 0.1);
    const CostWatch busy;
    const auto spin = [] {
        const CostWatch watch;
        while (watch.cost().wall < 0.2) {
        }
    };
    std::thread other(spin);
    other.join();
    BOOST_TEST(busy.cost().processor > 0.02);
}

BOOST_AUTO_TEST_CASE(memory_that_was_given_back_is_in_the_peak) {
    if (!(std::ofstream("/proc/self/clear_refs") << "5" << std::flush)) {
        BOOST_TEST_MESSAGE("skipped: the system does not reset the peak");
        return;
    }
    constexpr std::size_t bytes = std::size_t{64} << 20;
    const PeakMemory memory;
    {
        std::vector<char> used(bytes);
        std::memset(used.data(), 1, bytes);
    }
    const auto growth = memory.growth();
    BOOST_TEST_REQUIRE(growth.has_value());
    BOOST_TEST(*growth >= bytes * 9 / 10);
    BOOST_TEST(*growth < bytes * 2);
}

BOOST_AUTO_TEST_CASE(the_list_has_each_sample_of_the_band_once_and_neighbours_follow_each_other) {
    const Workload workload = small_workload(Length::infinite());
    const std::set<std::uint32_t> once(workload.list.samples.begin(), workload.list.samples.end());
    BOOST_TEST(once.size() == workload.grid.sample_count());
    BOOST_TEST(workload.list.samples.size() == once.size());
    const auto nx = static_cast<std::int64_t>(workload.grid.size[0]), ny = workload.grid.size[1];
    std::size_t jumps = 0;
    for (std::size_t brick = 0; brick < workload.list.bricks(); ++brick)
        for (std::size_t n = workload.list.starts[brick] + 1; n < workload.list.starts[brick + 1]; ++n) {
            const std::int64_t a = workload.list.samples[n - 1], b = workload.list.samples[n];
            const std::int64_t apart = std::abs(a % nx - b % nx) + std::abs(a / nx % ny - b / nx % ny) +
                                       std::abs(a / (nx * ny) - b / (nx * ny));
            jumps += apart == 1 ? 0U : 1U;
        }
    BOOST_TEST(jumps == 0U);
}

BOOST_AUTO_TEST_SUITE_END()
