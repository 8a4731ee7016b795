// The orders of the directions of stencils, as the codes that they are named after number them.
#include "support/throws.hpp"

#include <clsdf/segments.hpp>

#include <boost/test/unit_test.hpp>

#include <string>
#include <vector>

using namespace clsdf;
using namespace clsdf::test;

namespace {

struct Table {
    const char* name;
    std::vector<const char*> codes;
    std::vector<LinkDirection> directions;
};

/// Typed from the codes' own sources.
const std::vector<Table> tables{
    // OpenLB: src/dynamics/latticeDescriptors.h, later src/descriptor/definition/common.h;
    // Palabos: src/latticeBoltzmann/nearestNeighborLattices3D.hh.
    {"D3Q15",
     {"OpenLB", "Palabos"},
     {{0, 0, 0},
      {-1, 0, 0},
      {0, -1, 0},
      {0, 0, -1},
      {-1, -1, -1},
      {-1, -1, 1},
      {-1, 1, -1},
      {-1, 1, 1},
      {1, 0, 0},
      {0, 1, 0},
      {0, 0, 1},
      {1, 1, 1},
      {1, 1, -1},
      {1, -1, 1},
      {1, -1, -1}}},
    {"D3Q19",
     {"OpenLB", "Palabos"},
     {{0, 0, 0},
      {-1, 0, 0},
      {0, -1, 0},
      {0, 0, -1},
      {-1, -1, 0},
      {-1, 1, 0},
      {-1, 0, -1},
      {-1, 0, 1},
      {0, -1, -1},
      {0, -1, 1},
      {1, 0, 0},
      {0, 1, 0},
      {0, 0, 1},
      {1, 1, 0},
      {1, -1, 0},
      {1, 0, 1},
      {1, 0, -1},
      {0, 1, 1},
      {0, 1, -1}}},
    {"D3Q27", {"OpenLB", "Palabos"}, {{0, 0, 0},   {-1, 0, 0}, {0, -1, 0},  {0, 0, -1}, {-1, -1, 0},  {-1, 1, 0},
                                      {-1, 0, -1}, {-1, 0, 1}, {0, -1, -1}, {0, -1, 1}, {-1, -1, -1}, {-1, -1, 1},
                                      {-1, 1, -1}, {-1, 1, 1}, {1, 0, 0},   {0, 1, 0},  {0, 0, 1},    {1, 1, 0},
                                      {1, -1, 0},  {1, 0, 1},  {1, 0, -1},  {0, 1, 1},  {0, 1, -1},   {1, 1, 1},
                                      {1, 1, -1},  {1, -1, 1}, {1, -1, -1}}},
    // waLBerla: src/stencil/generate.py and Directions.h; lbmpy: stencils.py, the ordering "walberla", its default.
    {"D3Q15",
     {"waLBerla", "lbmpy"},
     {{0, 0, 0},
      {0, 1, 0},
      {0, -1, 0},
      {-1, 0, 0},
      {1, 0, 0},
      {0, 0, 1},
      {0, 0, -1},
      {1, 1, 1},
      {-1, 1, 1},
      {1, -1, 1},
      {-1, -1, 1},
      {1, 1, -1},
      {-1, 1, -1},
      {1, -1, -1},
      {-1, -1, -1}}},
    {"D3Q19",
     {"waLBerla", "lbmpy"},
     {{0, 0, 0},
      {0, 1, 0},
      {0, -1, 0},
      {-1, 0, 0},
      {1, 0, 0},
      {0, 0, 1},
      {0, 0, -1},
      {-1, 1, 0},
      {1, 1, 0},
      {-1, -1, 0},
      {1, -1, 0},
      {0, 1, 1},
      {0, -1, 1},
      {-1, 0, 1},
      {1, 0, 1},
      {0, 1, -1},
      {0, -1, -1},
      {-1, 0, -1},
      {1, 0, -1}}},
    {"D3Q27", {"waLBerla", "lbmpy"}, {{0, 0, 0},   {0, 1, 0},   {0, -1, 0},  {-1, 0, 0},  {1, 0, 0},   {0, 0, 1},
                                      {0, 0, -1},  {-1, 1, 0},  {1, 1, 0},   {-1, -1, 0}, {1, -1, 0},  {0, 1, 1},
                                      {0, -1, 1},  {-1, 0, 1},  {1, 0, 1},   {0, 1, -1},  {0, -1, -1}, {-1, 0, -1},
                                      {1, 0, -1},  {1, 1, 1},   {-1, 1, 1},  {1, -1, 1},  {-1, -1, 1}, {1, 1, -1},
                                      {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}}},
    // XLB, which has no D3Q15: xlb/velocity_set/d3q19.py and d3q27.py.
    {"D3Q19",
     {"XLB"},
     {{0, 0, 0},
      {0, 0, -1},
      {0, 0, 1},
      {0, -1, 0},
      {0, -1, -1},
      {0, -1, 1},
      {0, 1, 0},
      {0, 1, -1},
      {0, 1, 1},
      {-1, 0, 0},
      {-1, 0, -1},
      {-1, 0, 1},
      {-1, -1, 0},
      {-1, 1, 0},
      {1, 0, 0},
      {1, 0, -1},
      {1, 0, 1},
      {1, -1, 0},
      {1, 1, 0}}},
    {"D3Q27", {"XLB"}, {{0, 0, 0},   {0, 0, -1},  {0, 0, 1},   {0, -1, 0},  {0, -1, -1}, {0, -1, 1},  {0, 1, 0},
                        {0, 1, -1},  {0, 1, 1},   {-1, 0, 0},  {-1, 0, -1}, {-1, 0, 1},  {-1, -1, 0}, {-1, -1, -1},
                        {-1, -1, 1}, {-1, 1, 0},  {-1, 1, -1}, {-1, 1, 1},  {1, 0, 0},   {1, 0, -1},  {1, 0, 1},
                        {1, -1, 0},  {1, -1, -1}, {1, -1, 1},  {1, 1, 0},   {1, 1, -1},  {1, 1, 1}}}};

}  // namespace

BOOST_AUTO_TEST_SUITE(stencils)

BOOST_AUTO_TEST_CASE(directions_have_the_numbers_of_each_code) {
    std::size_t compared = 0;
    for (const Table& table : tables)
        for (const char* const code : table.codes) {
            BOOST_TEST_CONTEXT(table.name << " of " << code)
            BOOST_TEST((stencil(table.name, code) == table.directions));
            ++compared;
        }
    BOOST_TEST(compared == 14U);
    BOOST_TEST((stencil("D3Q19") == stencil("D3Q19", "waLBerla")));
}

BOOST_AUTO_TEST_CASE(other_stencils_are_refused_by_name) {
    check_throws(ErrorCode::invalid_argument, {"D3Q15", "XLB"}, [] { stencil("D3Q15", "XLB"); });
    check_throws(ErrorCode::invalid_argument, {"D3Q19", "lettuce"}, [] { stencil("D3Q19", "lettuce"); });
    check_throws(ErrorCode::invalid_argument, {"D2Q9", "waLBerla"}, [] { stencil("D2Q9"); });
}

BOOST_AUTO_TEST_SUITE_END()
