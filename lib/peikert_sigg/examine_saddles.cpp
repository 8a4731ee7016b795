#include "core/parallel.hpp"
#include "peikert_sigg/gap_test.hpp"

#include <tbb/enumerable_thread_specific.h>

#include <atomic>

namespace clsdf {

namespace {

using namespace peikert_sigg;

enum Mark : std::uint8_t { saddle = 1, irregular = 2, adjacent_gap = 4, gap = 8 };

std::uint8_t examine(FanSigns& signs) {
    std::uint8_t marks = saddle;
    if (!flipped_faces(signs).empty()) marks |= irregular;
    if (!failing_lines(signs).empty()) marks |= adjacent_gap;
    if (has_gap(signs)) marks |= gap;
    return marks;
}

}  // namespace

SaddleReport examine_saddles(const Mesh& mesh) {
    const Surface surface(mesh);
    std::vector<std::uint8_t> marks(mesh.vertices().size());
    std::atomic<std::size_t> decisions = 0;
    std::atomic<std::size_t> exact_decisions = 0;
    tbb::enumerable_thread_specific<polyhedra::VertexFans> fans_of_thread;
    for_each_index(marks.size(), [&](std::size_t vertex) {
        polyhedra::VertexFans& fans = fans_of_thread.local();
        if (surface.kind(vertex, fans) != VertexKind::saddle) return;
        const Fan fan = fan_at(surface, vertex, fans);
        FanSigns signs(fan);
        marks[vertex] = examine(signs);
        decisions += signs.decisions();
        exact_decisions += signs.exact_decisions();
    });

    SaddleReport report;
    for (std::uint32_t vertex = 0; vertex < marks.size(); ++vertex) {
        if (marks[vertex] & saddle) ++report.saddles;
        if (marks[vertex] & irregular) report.irregular.push_back(vertex);
        if (marks[vertex] & adjacent_gap) report.adjacent_gaps.push_back(vertex);
        if (marks[vertex] & gap) report.gaps.push_back(vertex);
    }
    report.decisions = decisions;
    report.exact_decisions = exact_decisions;
    return report;
}

}  // namespace clsdf
