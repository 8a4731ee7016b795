// A program that also uses oneTBB and GMP itself: those of the system, and clsdf those that it brings. Fields that are
// computed in the program's own parallel loop are the same, and both libraries do what they should.
#include <clsdf/clsdf.hpp>
#include <clsdf/mesh_files.hpp>

#include <gmp.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/version.h>

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

int main() try {
    const clsdf::Mesh knot = clsdf::make_shape("knot");  // its predicates use GMP
    const clsdf::Band band = clsdf::Band::symmetric(0.3);
    const clsdf::Grid grid = clsdf::Grid::around(knot, 40, band);
    const clsdf::Device device = clsdf::Device::automatic();
    const clsdf::Field whole = clsdf::DistanceTransform(device, knot).compute(grid, band);

    std::vector<int> differs(4);
    tbb::parallel_for(std::size_t{0}, differs.size(), [&](std::size_t i) {
        const clsdf::Field again = clsdf::DistanceTransform(device, knot).compute(grid, band);
        for (std::size_t j = 0; j < whole.distance().size(); ++j)
            differs[i] += whole.distance()[j] != again.distance()[j] ? 1 : 0;
    });
    for (const int count : differs)
        if (count != 0) return 2;

    const std::int64_t last = 1'000'000;
    const std::int64_t sum = tbb::parallel_reduce(
        tbb::blocked_range<std::int64_t>(1, last + 1), std::int64_t{0},
        [](const tbb::blocked_range<std::int64_t>& range, std::int64_t begun) {
            for (std::int64_t i = range.begin(); i != range.end(); ++i) begun += i;
            return begun;
        },
        std::plus<>());
    if (sum != last * (last + 1) / 2) return 3;

    mpz_t factorial;
    mpz_init(factorial);
    mpz_fac_ui(factorial, 30);
    const std::unique_ptr<char, void (*)(void*)> text(mpz_get_str(nullptr, 10, factorial), std::free);
    mpz_clear(factorial);
    if (std::string(text.get()) != "265252859812191058636308480000000") return 4;

    std::cout << "headers of oneTBB " << TBB_VERSION_STRING << ", its library " << TBB_runtime_version() << "; GMP "
              << gmp_version << "; clsdf " << clsdf::version() << '\n';
    return 0;
} catch (const clsdf::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
