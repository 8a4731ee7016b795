#pragma once

#include "frusta/cluster_index.hpp"
#include "segments/sample_box.hpp"
#include "segments/walk.hpp"

#include <clsdf/segments.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace clsdf::segments {

/// The sides of the samples of a box, exact: those of point queries off the surface; outside on a wall, inside on a
/// face within a body. Rows of samples along x are swept: where they cross the faces, and the winding number in the
/// eight looks changes.
class BoxSides {
public:
    /// rule: none makes all outside. near: all faces that rows of the box cross before their samples, and maybe others;
    /// null: all. The box must outlive this.
    BoxSides(const engine::CrossedFaces& faces, SignRule rule, const SampleBox& box,
             const std::vector<engine::RecordRange>* near = nullptr);

    /// The words of a row of samples, the lowest bit first; bits beyond the last sample are 0, and so are the words
    /// before and after the row's.
    const std::uint64_t* row(std::size_t number) const { return bits_.data() + 1 + number * (words_ + 1); }
    std::size_t words() const { return words_; }
    bool is_inside(const Place& p) const { return (row(box_.row(p))[p[0] / 64] >> (p[0] % 64) & 1U) != 0; }
    /// Of the sample in the eight looks; of a surface with open edges without the part of these.
    Windings windings(const Place& p) const;
    /// Those of the grid without its margin, packed.
    SampleSides of_grid() const;

private:
    /// Where a row crosses a face: from sample `sample` on the winding number is another one.
    struct Change {
        std::uint32_t row;
        std::int32_t sample;
        std::uint8_t looks;
        std::int8_t change;
    };

    void find_changes(const engine::CrossedFaces& faces, const std::vector<engine::RecordRange>& ranges);
    void add_changes(const engine::CrossedFaces& faces, std::size_t face, std::vector<Change>& changes) const;
    /// Of open edges, beside the part that all looks have.
    void add_changes_of_edges(const engine::CrossedFaces& faces, std::vector<Change>& changes) const;
    void sort_changes(std::vector<std::vector<Change>>& found);
    void sweep(std::size_t row, SignRule rule, const FilmTree* film);
    void sweep_with_film(std::size_t row, SignRule rule, const FilmTree& film, double unit);

    const SampleBox& box_;
    bool has_film_;
    std::size_t words_;
    UninitializedVector<std::uint64_t> bits_;
    UninitializedVector<Change> changes_;  // by row, then by sample
    UninitializedVector<std::uint32_t> row_begins_;
};

}  // namespace clsdf::segments
